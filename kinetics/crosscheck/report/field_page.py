"""The document of the report in a uniform field as one HTML page, and as text for the terminal."""

from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from kinetics.crosscheck.report.field_rows import OBSERVABLES
from kinetics.crosscheck.report.field_settings import SCATTERERS
from kinetics.crosscheck.report.figures import svg
from kinetics.crosscheck.report.page import (
    CLASSES,
    SHORT,
    deviation,
    matrix,
    picture_of,
    verdict_words,
)
from kinetics.crosscheck.report.templates import environment
from kinetics.crosscheck.text_tables import aligned, wrapped
from kinetics.crosscheck.verdicts import EXPLAINED, WORDS


def render_field(document: Mapping[str, Any]) -> str:
    """The page. Every text of the document is escaped."""
    figures = document["figures"]
    first, *others = figures
    page = environment().get_template("field.html.j2")
    return page.render(
        doc=document,
        svgs={name: Markup(svg(name, data)) for name, data in figures.items()},
        picture=picture_of(document),
        matrices=_matrices(document),
        names=SCATTERERS,
        main_figure=first,
        dilute_figures=[name for name in others if not name.startswith("density-")],
        dense_figures=[name for name in others if name.startswith("density-")],
        restitutions=_restitutions(document),
        observables=OBSERVABLES,
        deviation=deviation,
        said=verdict_words,
        explained=EXPLAINED,
        classes=CLASSES,
    )


def _restitutions(document: Mapping[str, Any]) -> list[float]:
    """Those of all comparisons."""
    return sorted({row["restitution"] for row in document["rows"]})


def _matrices(document: Mapping[str, Any]) -> list[tuple[str, list[dict[str, Any]]]]:
    """The scatterers of each dimension, and the short table of its comparisons."""
    every = _restitutions(document)
    return [
        (name, matrix((r for r in document["rows"] if r["dimension"] == d), every, OBSERVABLES))
        for d, name in SCATTERERS.items()
        if d in document["settings"]["dimensions"]
    ]


def text(document: Mapping[str, Any]) -> str:
    """The findings, and a line for each comparison: its verdicts and its worst deviation."""
    parts = [wrapped(finding) for finding in document["findings"]]
    for name, comparisons in _matrices(document):
        lines = [[name, "", "verdicts", "the worst", ""]]
        for line in comparisons:
            rows = [row for row in line["rows"] if row]
            words = [WORDS[row["verdict"]] for row in rows]
            counted = ", ".join(f"{words.count(word)} {word}" for word in dict.fromkeys(words))
            worst = max(rows, key=lambda row: abs(row["sigmas"] or row["deviation"]))
            who = " / ".join(SHORT.get(who, who) for who in line["comparison"].split(" / "))
            at = f"e = {worst['restitution']:g}"
            lines.append(
                [f"  {OBSERVABLES[line['observable']].short}", who, counted, deviation(worst), at]
            )
        parts.append("\n" + aligned(lines))
    return "\n".join(parts)
