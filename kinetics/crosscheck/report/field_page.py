"""The document of the report in a uniform field as one HTML page, and as a table of text."""

from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from kinetics.crosscheck.report.field_drawing import svg
from kinetics.crosscheck.report.field_rows import OBSERVABLES
from kinetics.crosscheck.report.field_settings import SCATTERERS
from kinetics.crosscheck.report.page import deviation
from kinetics.crosscheck.report.templates import environment
from kinetics.crosscheck.text_tables import aligned


def render_field(document: Mapping[str, Any]) -> str:
    """The page. Every text of the document is escaped."""
    figures = document["figures"]
    return (
        environment()
        .get_template("field.html.j2")
        .render(
            doc=document,
            svgs={name: Markup(svg(name, data)) for name, data in figures.items()},
            matrices=[(SCATTERERS[d], matrix(document, d)) for d in _dimensions(document)],
            names=SCATTERERS,
            observables=OBSERVABLES,
            deviation=deviation,
        )
    )


def _dimensions(document: Mapping[str, Any]) -> list[int]:
    return [int(d) for d in document["settings"]["dimensions"]]


def matrix(document: Mapping[str, Any], dimension: int) -> list[dict[str, Any]]:
    """The short table of one dimension: a line per comparison, a cell or None per restitution."""
    lines: dict[tuple[str, str, str], dict[float, Mapping[str, Any]]] = {}
    for row in document["rows"]:
        if row["dimension"] == dimension:
            key = (row["observable"], row["source"], row["against"])
            lines.setdefault(key, {})[row["restitution"]] = row
    return [
        {
            "observable": observable,
            "comparison": f"{source} / {against}",
            "rows": [found.get(e) for e in document["settings"]["restitutions"]],
        }
        for (observable, source, against), found in lines.items()
    ]


def verdict_table(document: Mapping[str, Any]) -> str:
    """Text for the terminal: one line per comparison, one column per restitution."""
    lines = [["", "", "", *(f"e = {e:g}" for e in document["settings"]["restitutions"])]]
    for d in _dimensions(document):
        for line in matrix(document, d):
            cells = [f"{row['verdict']} {deviation(row)}" if row else "-" for row in line["rows"]]
            name = OBSERVABLES[line["observable"]].short
            lines.append([SCATTERERS[d], name, line["comparison"], *cells])
    return aligned(lines)
