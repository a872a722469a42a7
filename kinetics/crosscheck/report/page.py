"""The report's document as one HTML page with nothing beside it, and as a table of text."""

from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from kinetics.crosscheck.report.all_figures import PAPER_FIGURES
from kinetics.crosscheck.report.equations import report_equations
from kinetics.crosscheck.report.figures import svg
from kinetics.crosscheck.report.row import OBSERVABLES, Names, relative_error
from kinetics.crosscheck.report.templates import environment, number
from kinetics.crosscheck.text_tables import aligned


def render(document: Mapping[str, Any]) -> str:
    """The page. Every text of the document is escaped."""
    restitutions = document["settings"]["restitutions"]
    page = environment().get_template("report.html.j2")
    return page.render(
        doc=document,
        tables=[_number_table(item, restitutions) for item in document["answers"]],
        figure_groups=_figure_groups(document),
        svgs={name: Markup(svg(name, data)) for name, data in document["figures"].items()},
        equations=report_equations(document["settings"].get("dimension")),
        matrix=matrix(document),
        dimensions=dimension_pairs(document),
        is_papers_law="dimension" not in document["settings"],
        observables=_observables(document),
        deviation=deviation,
        dimension_cells=_dimension_cells,
        # Written by sympy's printer from the package's own formulas, not from anybody's data.
        formula=Markup,
    )


def _observables(document: Mapping[str, Any]) -> dict[str, Names]:
    """The names of the observables; in space p is G(R)/(4 pi R^2)."""
    if document["settings"].get("dimension") != 3:
        return OBSERVABLES
    title, short = OBSERVABLES["tail_exponent"]
    return OBSERVABLES | {"tail_exponent": Names(title.replace("G(R)/R ", "G(R)/R² "), short)}


def _figure_groups(document: Mapping[str, Any]) -> list[tuple[str, list[str]]]:
    """Heading and names of the figures; those of another law than the paper's have no heading."""
    names = list(document["figures"])
    papers = [name for name in names if name in PAPER_FIGURES]
    if "dimension" in document["settings"]:
        return [("", names)]
    others = [name for name in names if name not in papers]
    return [("The paper's figures", papers), ("Figures that the paper lacks", others)]


def _number_table(answer: Mapping[str, Any], restitutions: list[float]) -> list[dict[str, Any]]:
    """The numbers of an answer as a table: one line per name, one cell per restitution."""
    lines: dict[str, dict[float | None, str]] = {}
    for n in answer["numbers"]:
        name = f"{n['name']}  [{n['unit']}]" if n["unit"] else n["name"]
        lines.setdefault(name, {})[n["restitution"]] = number(n["value"], n["error"])
    return [
        {"name": name, "all": cells.get(None), "cells": [cells.get(e, "–") for e in restitutions]}
        for name, cells in lines.items()
    ]


def matrix(document: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The short table: one line per comparison, one cell (or None) per restitution."""
    lines: dict[tuple[str, str, str], dict[float, Mapping[str, Any]]] = {}
    for row in document["rows"]:
        key = (row["observable"], row["source"], row["against"])
        lines.setdefault(key, {})[row["restitution"]] = row
    order, restitutions = list(OBSERVABLES), document["settings"]["restitutions"]
    return [
        {
            "observable": observable,
            "comparison": f"{source} / {against}",
            "rows": [lines[observable, source, against].get(e) for e in restitutions],
        }
        for observable, source, against in sorted(lines, key=lambda key: order.index(key[0]))
    ]


def dimension_pairs(document: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Disks beside spheres: one line per quantity and restitution, its two rows of the document."""
    lines: dict[tuple[str, float], list[Mapping[str, Any]]] = {}
    for row in document.get("dimensions", ()):
        lines.setdefault((row["observable"], row["restitution"]), []).append(row)
    order = list(OBSERVABLES)
    return [
        {"observable": observable, "restitution": e, "rows": lines[observable, e]}
        for observable, e in sorted(lines, key=lambda key: (order.index(key[0]), key[1]))
    ]


def dimension_table(document: Mapping[str, Any]) -> str:
    """The same as text for the terminal; empty where the report has no such table."""
    pairs = dimension_pairs(document)
    if not pairs:
        return ""
    heads = ("closed form", "solver", "equation", "particles")
    lines = [["", "", *(f"{of}: {head}" for of in ("disks", "spheres") for head in heads)]]
    for pair in pairs:
        cells = [cell for row in pair["rows"] for cell in _dimension_cells(row)]
        name = OBSERVABLES[pair["observable"]].short
        lines.append([name, f"e = {pair['restitution']:g}", *cells])
    return aligned(lines)


def _dimension_cells(row: Mapping[str, Any]) -> list[str]:
    limits = [number(row[name]) for name in ("exact", "solver", "equation")]
    return [*limits, number(row["value"], row["error"])]


def verdict_table(document: Mapping[str, Any]) -> str:
    """Text for the terminal: one line per comparison, one column per restitution."""
    lines = [["", "", *(f"e = {e:g}" for e in document["settings"]["restitutions"])]]
    for line in matrix(document):
        cells = [f"{row['verdict']} {deviation(row)}" if row else "-" for row in line["rows"]]
        lines.append([OBSERVABLES[line["observable"]].short, line["comparison"], *cells])
    return aligned(lines)


def deviation(row: Mapping[str, Any]) -> str:
    """A row's relative deviation, with its standard error where it has one."""
    value = row["deviation"]
    if value is None:
        return "–"
    if row["kind"] == "numerical":
        return f"{value:.0e}"
    if row["error"] is None:
        return f"{100 * value:+.1f} %"
    return number(100 * value, relative_error(row), "+") + " %"
