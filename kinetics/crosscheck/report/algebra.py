"""The formulas of a report, derived again, and the numbers of the paper's equations in texts."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

from kinetics.crosscheck.report.systems import System
from kinetics.crosscheck.report.words_of_report import report_words

#: Labels of the paper that are words or symbols too: they are labels only after "eq.".
AMBIGUOUS_LABELS = (
    "if",
    "L",
    "N",
    "ab",
    "eta",
    "tn",
    "mup",
    "msd",
    "impact",
    "rewrite",
    "collision",
)
ERRATUM = "erratum"


@dataclass(frozen=True)
class AlgebraRow:
    """A formula, derived: its status, a note, and the formulas as text and as MathML."""

    label: str
    title: str
    proof: str
    note: str
    printed_mathml: str
    derived_mathml: str
    status: str
    printed: str
    derived: str
    numbers: dict[str, float]


@dataclass(frozen=True)
class Erratum:
    """A printed formula that is wrong: its place in the paper, its title, and what it changes."""

    label: str
    place: str
    title: str
    change: str


def derive(system: System) -> list[AlgebraRow]:
    """Derive the formulas of the report of a system: the paper's, or those beyond it."""
    from derivations import ERRATA, report_subset, verify

    words = report_words()
    labels: list[str]
    if system.is_papers_law:
        of_errata = [erratum.label for erratum in ERRATA if erratum.label not in report_subset]
        labels = [*report_subset, *of_errata]
    else:
        kind = str(system.dimension) if system.name == "report" else system.name
        labels = [f"beyond:{name}" for name in words.algebra[kind]]
    if not labels:
        return []
    rows = []
    for check in verify(labels):
        row = AlgebraRow(
            label=check.label,
            title=check.title,
            proof=check.proof,
            note=check.note,
            printed_mathml=check.printed_mathml,
            derived_mathml=check.derived_mathml,
            status=str(check.status),
            printed=_text_of(check.printed),
            derived=_text_of(check.derived),
            numbers={number.name: float(number.value) for number in check.numbers},
        )
        rows.append(row)
    return rows


def _text_of(formula: object) -> str:
    """Return a formula as text; empty if there is none."""
    if formula is None:
        return ""
    return str(formula)


def errata(checks: Sequence[AlgebraRow]) -> list[Erratum]:
    """Return those of the formulas that are errata, in the order of the paper."""
    from derivations import ERRATA

    titles = {check.label: check.title for check in checks if check.status == ERRATUM}
    errata_of_report = []
    for item in ERRATA:
        if item.label in titles:
            equation = cite(f"eq. {item.label}")
            change = in_symbols(item.changes)
            errata_of_report.append(Erratum(item.label, equation, titles[item.label], change))
    return errata_of_report


#: How a page writes what a terminal shows in plain letters.
SYMBOLS = {
    "^2": "²",
    "^(0)": "⁽⁰⁾",
    "^(j)": "⁽ʲ⁾",
    "^(i)": "⁽ⁱ⁾",
    "nabla": "∇",
    "D_e": "Dₑ",
    "nu_D": "ν_D",
    "gamma": "γ",
    "eta": "η",
}


def in_symbols(text: str) -> str:
    """Return a sentence of the errata with symbols in place of their names."""
    text = re.sub(r"<([^<>]+)>", r"⟨\1⟩", text)
    for name, symbol in SYMBOLS.items():
        if name.isalpha():
            text = re.sub(rf"\b{name}\b", symbol, text)
        else:
            text = text.replace(name, symbol)
    return text


@cache
def _numbers() -> dict[str, str]:
    """Return the number of each equation of the paper by its label."""
    from derivations.printed import ROWS

    return {label: row.number for label, row in ROWS.items() if row.number}


def cite(text: str) -> str:
    """Return a text with the numbers of the paper's equations in place of their labels."""
    numbers = _numbers()
    longest_first = sorted(numbers, key=len, reverse=True)
    sure = [label for label in longest_first if label not in AMBIGUOUS_LABELS]
    for start, labels in ((r"\b(?:eq\. |label )", longest_first), (r"(?<![\w:])", sure)):
        alternatives = "|".join(map(re.escape, labels))
        pattern = rf"{start}({alternatives})(?![\w#]|\.\d)"
        text = re.sub(pattern, lambda match: f"eq. ({numbers[match[1]]})", text)
    return text
