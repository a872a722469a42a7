"""The report as one HTML page with nothing beside it and as text, and the formulas on it."""

import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import repeat
from typing import Any

from kinetics.crosscheck.files import rendered
from kinetics.crosscheck.report.rows import kept, scale_of
from kinetics.crosscheck.words import number, numeral

_WORDS = ("if", "L", "N", "ab", "eta", "tn", "mup", "msd", "impact", "rewrite", "collision")
"""Labels of the paper that are words or symbols too: they are labels only after "eq."."""


def algebra(system: Any) -> list[dict[str, Any]]:
    """The formulas of the report, derived: title, status, note, and both as text and as MathML."""
    from derivations import report_subset, verify

    labels: Iterable[str] = report_subset
    if not system.is_papers_law:
        of = system.name if system.name != "report" else str(system.dimension)
        labels = [f"beyond:{name}" for name in kept()["algebra"][of]]
    names = ("label", "title", "proof", "note", "printed_mathml", "derived_mathml")
    return [
        {name: getattr(check, name) for name in names}
        | {
            "status": str(check.status),
            "printed": "" if check.printed is None else str(check.printed),
            "derived": "" if check.derived is None else str(check.derived),
            "numbers": {each.name: float(each.value) for each in check.numbers},
        }
        for check in (verify(labels) if labels else ())
    ]


def with_numbers(text: Any) -> Any:
    """A text, or several, with the numbers of the paper's equations in place of their labels."""
    if not isinstance(text, str):
        return [with_numbers(each) for each in text]
    from derivations.printed import ROWS

    numbers = {label: row.number for label, row in ROWS.items() if row.number}
    every = sorted(numbers, key=len, reverse=True)
    sure = [label for label in every if label not in _WORDS]
    for start, known in ((r"\b(?:eq\. |label )", every), (r"(?<![\w:])", sure)):
        pattern = rf"{start}({'|'.join(map(re.escape, known))})(?![\w#]|\.\d)"
        text = re.sub(pattern, lambda match: f"eq. ({numbers[match[1]]})", text)
    return text


def head(system: Any) -> dict[str, str]:
    """The "title" of the page, its "symbols", the "units" of all numbers, what the equation
    has "also", and the "parameter" that `restitutions` are.
    """
    words = {"path": "1/(2dρ₀)", "fourth": "⟨c⁴⟩/2", "root": "√2"}
    if system.dimension == 3:
        words = {"path": "1/(πd²ρ₀)", "fourth": "3⟨c⁴⟩/5", "root": "√3"}
    found = kept()["head"].get(system.name, kept()["head"]["cooling"])
    texts = (text.format(**words) for text in found)
    names = ("title", "symbols", "units", "also")
    return dict(zip(names, texts, strict=True)) | {"parameter": system.parameter}


def deviation(row: Mapping[str, Any]) -> str:
    """A row's relative deviation, with its standard error where it has one."""
    value = row["deviation"]
    if value is None:
        return "–"
    if row["kind"] == "numerical":
        return numeral(100 * value, ".0e") + " %"
    if row["error"] is None:
        if value >= 1:
            return f"factor {numeral(1 + value, '.2g')}"
        return numeral(100 * value, "+.1f") + " %"
    error = float(100 * row["error"] / scale_of(row["observable"], row["theory"]))
    return number(100 * value, error, "+") + " %"


def render(document: Mapping[str, Any], figures: Sequence[Any], chance: str) -> str:
    """The page. Every text of the document is escaped."""
    from markupsafe import Markup

    from derivations import printed_equation
    from derivations.printers import mathml

    # Formulas are of this package's own printer, figures are matplotlib's with escaped texts:
    # nothing of a user's goes in unescaped.
    filters = {"numeral": numeral, "number": number, "cited": with_numbers}
    settings = document["settings"]
    cools, dimension = "tangential_restitution" in settings, settings.get("dimension", 2)
    papers_law = cools and dimension == 2 and settings["tangential_restitution"] == 1
    below = kept()["below"]["paper" if papers_law else str(dimension)] if cools else ()

    def equation(name: str) -> tuple[str, Markup]:
        words, *labels = kept()["equations"][name]
        # ascending powers read better: 1 - e^2
        printed = (mathml(printed_equation(x).formula, "rev-lex", "block") for x in labels)
        return words, Markup("".join(printed))

    return rendered(
        "report.html.j2", filters, doc=document, chance=chance, formula=Markup, deviation=deviation,
        figures=[(drawn, Markup(drawn.svg())) for drawn in figures],
        strip=[equation("collision" if papers_law or not cools else "rule"), equation("lorentz")],
        equations=[equation(name) for name in below],
        summary=_summary(document), verdicts=_verdicts(document),
    )  # fmt: skip


def _summary(document: Mapping[str, Any]) -> tuple[list[str], list[list[str]]]:
    """Restitutions, and for each quantity its name and a cell for each of them."""
    lines: dict[str, dict[float, str]] = {}
    for row in document["tables"]["summary"]:
        name, value = row["quantity"], row["value"]
        sign = "+" if name.endswith("%") else ""
        shown = numeral(value, "+.1f") if sign else number(value, digits=4)
        if row["error"]:
            shown = number(value, row["error"], sign)
        lines.setdefault(name, {})[row["restitution"]] = shown
    every = sorted({e for cells in lines.values() for e in cells})
    return [f"{document['parameter']} = {e:g}" for e in every], [
        [quantity, *(cells.get(e, "–") for e in every)] for quantity, cells in lines.items()
    ]


def _verdicts(document: Mapping[str, Any]) -> tuple[list[str], list[list[Any]]]:
    """Restitutions, and lines: a heading, or who against whom and the row of each restitution."""
    every = sorted({row["restitution"] for row in document["rows"]})
    groups: dict[str, dict[str, dict[float, Any]]] = {}
    for row in document["rows"]:
        heading = f"{kept()['observables'][row['observable']][0]}, {row['system']}"
        who = groups.setdefault(heading, {}).setdefault(f"{row['source']} / {row['against']}", {})
        who[row["restitution"]] = row
    lines = list[list[Any]]()
    for heading, whos in groups.items():
        lines += [[heading], *([w, *map(x.get, every, repeat("–"))] for w, x in whos.items())]
    return [f"{document['parameter']} = {e:g}" for e in every], lines
