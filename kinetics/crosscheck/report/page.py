"""The report as one HTML page with nothing beside it."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from itertools import repeat
from typing import TYPE_CHECKING, Any

from kinetics.crosscheck.files import rendered
from kinetics.crosscheck.report.algebra import cite
from kinetics.crosscheck.report.figures import Drawn
from kinetics.crosscheck.report.rows import APPROXIMATION, NUMERICAL, scale_of
from kinetics.crosscheck.report.systems import System
from kinetics.crosscheck.report.words_of_report import report_words
from kinetics.crosscheck.words import number, numeral

if TYPE_CHECKING:
    from markupsafe import Markup

#: The document of a report, as its JSON file holds it.
Document = Mapping[str, Any]
NO_VALUE = "–"
# Symbols that differ between the plane and space.
PLANE = {"path": "1/(2dρ₀)", "fourth": "⟨c⁴⟩/2", "root": "√2"}
SPACE = {"path": "1/(πd²ρ₀)", "fourth": "3⟨c⁴⟩/5", "root": "√3"}
#: Digits of a number without an error in the table by restitution.
SUMMARY_DIGITS = 4


@dataclass(frozen=True)
class HtmlTable:
    """A table: its heads, and lines of a name and cells; a line of a name alone is a heading."""

    heads: list[str]
    lines: list[list[Any]]


def head(system: System) -> dict[str, str]:
    """Return the "title" of the page, its "symbols", the "units" of all numbers, what the equation
    has "also", and the "parameter" that differs between cases.
    """
    symbols = SPACE if system.dimension == 3 else PLANE
    heads = report_words().head
    texts = heads.get(system.name, heads["cooling"])
    names = ("title", "symbols", "units", "also")
    document = {name: text.format(**symbols) for name, text in zip(names, texts, strict=True)}
    document["parameter"] = system.parameter
    return document


def deviation(row: Mapping[str, Any]) -> str:
    """Return a row's relative deviation, with its standard error where it has one."""
    value = row["deviation"]
    if value is None:
        return NO_VALUE
    if row["kind"] == NUMERICAL:
        return numeral(100 * value, ".0e") + " %"
    if row["kind"] == APPROXIMATION and value >= 1:
        return f"factor {numeral(1 + value, '.2g')}"
    if row["error"] is None:
        return numeral(100 * value, "+.1f") + " %"
    error = float(100 * row["error"] / scale_of(row["observable"], row["theory"]))
    return number(100 * value, error, "+") + " %"


def render(document: Document, figures: Sequence[Drawn], chance: str) -> str:
    """Return the page. Every text of the document is escaped."""
    from markupsafe import Markup

    # Formulas are of this package's own printer, figures are matplotlib's with escaped texts:
    # nothing of a user's goes in unescaped.
    settings = document["settings"]
    cools = "tangential_restitution" in settings
    dimension = settings["dimension"]
    is_papers_law = cools and dimension == 2 and settings["tangential_restitution"] == 1
    rule = "collision"
    if cools and not is_papers_law:
        rule = "rule"
    return rendered(
        "report.html.j2",
        {"numeral": numeral, "number": number, "cited": cite},
        doc=document,
        chance=chance,
        today=date.today().isoformat(),
        formula=Markup,
        deviation=deviation,
        figures=[(drawn, Markup(drawn.svg())) for drawn in figures],
        strip=[_equation(rule), _equation("lorentz")],
        equations=[_equation(name) for name in _folded_equations(cools, is_papers_law, dimension)],
        summary=_summary(document),
        verdicts=_verdicts(document),
    )


def _folded_equations(cools: bool, is_papers_law: bool, dimension: int) -> Iterable[str]:
    """Return the names of the equations that are folded at the end of the page."""
    if not cools:
        return ()
    kind = "paper" if is_papers_law else str(dimension)
    return report_words().below[kind]


def _equation(name: str) -> "tuple[str, Markup]":
    """Return what an equation says in words, and its formulas."""
    from markupsafe import Markup

    from derivations import printed_equation
    from derivations.printers import mathml

    words, *labels = report_words().equations[name]
    # Ascending powers read better: 1 - e^2.
    formulas = [mathml(printed_equation(label).formula, "rev-lex", "block") for label in labels]
    return words, Markup("".join(formulas))


def _heads(document: Document, values: Iterable[float]) -> list[str]:
    """Return the heads of columns, one for each value of the parameter."""
    return [f"{document['parameter']} = {value:g}" for value in values]


def _summary(document: Document) -> HtmlTable:
    """Return the table of quantities by restitution."""
    cells_by_quantity: dict[str, dict[float, str]] = {}
    for record in document["tables"]["summary"]:
        cells = cells_by_quantity.setdefault(record["quantity"], {})
        cells[record["restitution"]] = _summary_cell(record)
    values = sorted(set().union(*cells_by_quantity.values()))
    lines = []
    for quantity, cells in cells_by_quantity.items():
        lines.append([quantity, *map(cells.get, values, repeat(NO_VALUE))])
    return HtmlTable(_heads(document, values), lines)


def _summary_cell(record: Mapping[str, Any]) -> str:
    """Return a number of the summary as text: per cents with a sign, errors where there are any."""
    is_percent = record["quantity"].endswith("%")
    sign = "+" if is_percent else ""
    if record["error"]:
        return number(record["value"], record["error"], sign)
    if is_percent:
        return numeral(record["value"], "+.1f")
    return number(record["value"], digits=SUMMARY_DIGITS)


def _verdicts(document: Document) -> HtmlTable:
    """Return the table of all rows: a heading for each observable, a line for who against whom."""
    groups: dict[str, dict[str, dict[float, Any]]] = {}
    for row in document["rows"]:
        observable = report_words().observables[row["observable"]]
        lines_of_group = groups.setdefault(f"{observable.title}, {row['system']}", {})
        rows_of_line = lines_of_group.setdefault(f"{row['source']} / {row['against']}", {})
        rows_of_line[row["restitution"]] = row
    values = sorted({row["restitution"] for row in document["rows"]})
    lines: list[list[Any]] = []
    for heading, lines_of_group in groups.items():
        lines.append([heading])
        for name, rows_of_line in lines_of_group.items():
            lines.append([name, *map(rows_of_line.get, values, repeat(NO_VALUE))])
    return HtmlTable(_heads(document, values), lines)
