"""The document of the report in a uniform field as one HTML page, and as a table of text."""

from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from kinetics.crosscheck.report.field_drawing import svg
from kinetics.crosscheck.report.field_rows import OBSERVABLES
from kinetics.crosscheck.report.field_settings import SCATTERERS
from kinetics.crosscheck.report.page import CLASSES, deviation, verdict_words
from kinetics.crosscheck.report.templates import environment
from kinetics.crosscheck.text_tables import aligned
from kinetics.crosscheck.verdicts import EXPLAINED, WORDS

TOP_FIGURES = ("drift", "trajectories")
"""The figures beside the findings; the first is the main one."""
DENSE_FIGURES = ("density-drift", "density-trapped", "density-captures")
"""The figures of the section on hard disks, in its order."""


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
            top_figures=[name for name in TOP_FIGURES if name in figures],
            dense_figures=[name for name in DENSE_FIGURES if name in figures],
            restitutions=columns(document),
            observables=OBSERVABLES,
            deviation=deviation,
            said=verdict_words,
            explained=EXPLAINED,
            classes=CLASSES,
        )
    )


def _dimensions(document: Mapping[str, Any]) -> list[int]:
    return [int(d) for d in document["settings"]["dimensions"]]


def columns(document: Mapping[str, Any]) -> list[float]:
    """The restitutions of all comparisons."""
    return sorted({float(row["restitution"]) for row in document["rows"]})


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
            "rows": [found.get(e) for e in columns(document)],
        }
        for (observable, source, against), found in lines.items()
    ]


def verdict_table(document: Mapping[str, Any]) -> str:
    """Text for the terminal: one line per comparison, with its verdicts and its worst deviation."""
    lines = [["", "", "", "verdicts", "the worst", ""]]
    for d in _dimensions(document):
        for line in matrix(document, d):
            rows = [row for row in line["rows"] if row]
            words = [WORDS[row["verdict"]] for row in rows]
            counted = ", ".join(f"{words.count(word)} {word}" for word in dict.fromkeys(words))
            worst = max(rows, key=lambda row: abs(row["sigmas"] or row["deviation"]))
            at = f"e = {worst['restitution']:g}"
            name = OBSERVABLES[line["observable"]].short
            cells = (name, line["comparison"], counted, deviation(worst), at)
            lines.append([SCATTERERS[d], *cells])
    return aligned(lines)
