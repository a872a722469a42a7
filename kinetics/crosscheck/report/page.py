"""The report's document as one HTML page with nothing beside it, and as a table of text."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from markupsafe import Markup

from kinetics.crosscheck.report.all_figures import PAPER_FIGURES
from kinetics.crosscheck.report.equations import report_equations
from kinetics.crosscheck.report.figures import svg
from kinetics.crosscheck.report.headline import HEAD_FIGURES
from kinetics.crosscheck.report.row import OBSERVABLES, Names, relative_error
from kinetics.crosscheck.report.templates import environment, number, numeral
from kinetics.crosscheck.text_tables import aligned
from kinetics.crosscheck.verdicts import EXPLAINED, WORDS, Verdict

CLASSES = {
    "no difference": "agrees", "unclear": "unclear", "differs": "differs",
    "holds": "holds", "holds in part": "partly", "does not hold": "fails",
}  # fmt: skip
"""The class of the style sheet for each word that is explained, or that judges a claim."""
CONTENTS = {
    "claims": "The paper’s claims, judged",
    "causes": "What lifts the paper’s 1.45",
    "answers": "Questions and answers in numbers",
    "figures": "Figures",
    "finite-density": "Hard disks predicted: the finite density",
    "findings": "What explains the differences",
    "dimensions": "Disks and spheres side by side",
    "verdicts": "Verdicts",
    "equations": "The equations",
    "rows": "Every comparison",
    "algebra": "The algebra",
    "method": "How it was made",
}
"""Sections of the page by their id, as far as a report has them."""
_MARKS = "●■▲◆▼✚"
"""The markers of the restitutions, as `strokes` draws them."""
_DIGITS = {"%": 3, "d/U": 3, "σ": 3}
"""Digits of a number without an error, by its unit; others have five."""
_LOW_POWER = 0.1
"""Relative difference that would have been seen, above which "no difference" says little."""


def render(document: Mapping[str, Any]) -> str:
    """The page. Every text of the document is escaped."""
    settings = document["settings"]
    restitutions = settings["restitutions"]
    parts = {
        "claims": document["claims"], "causes": document["causes"],
        "answers": document["answers"], "dimensions": document.get("dimensions"),
        "finite-density": document.get("finite_density"),
    }  # fmt: skip
    page = environment().get_template("report.html.j2")
    return page.render(
        doc=document,
        contents=[(id, title) for id, title in CONTENTS.items() if parts.get(id, True)],
        head_figures=_head_figures(document),
        picture=picture_of(document),
        explained=EXPLAINED,
        classes=CLASSES,
        causes=[_cause_cells(step) for step in document["causes"]],
        marks=list(zip(restitutions, _MARKS * len(restitutions), strict=False)),
        scatterers="spheres" if settings.get("dimension") == 3 else "disks",
        tables=[_number_table(item, restitutions) for item in document["answers"]],
        figure_groups=_figure_groups(document),
        svgs={name: Markup(svg(name, data)) for name, data in document["figures"].items()},
        equations=report_equations(settings.get("dimension")),
        matrix=matrix(document["rows"], restitutions, OBSERVABLES),
        dimensions=dimension_pairs(document),
        is_papers_law="dimension" not in settings,
        observables=_observables(document),
        deviation=deviation,
        said=verdict_words,
        dimension_cells=_dimension_cells,
        # Written by sympy's printer from the package's own formulas, not from anybody's data.
        formula=Markup,
    )


def picture_of(document: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """Title, description and "svg" of a picture of the system, if the document has one."""
    picture = document.get("picture")
    # Drawn by matplotlib, its texts escaped: nothing of a user's goes in.
    return None if picture is None else {**picture, "svg": Markup(picture["svg"])}


def _head_figures(document: Mapping[str, Any]) -> list[str]:
    """The figures beside the findings; the others stand in their own section."""
    return [name for name in HEAD_FIGURES if name in document["figures"]]


def _cause_cells(step: Mapping[str, Any]) -> dict[str, str]:
    """The cells of one restitution in the table of causes."""

    def percent(value: Mapping[str, float]) -> str:
        return number(100 * value["value"], 100 * value["error"], "+") + " %"

    predicted = step["predicted"]
    return {
        "e": f"{step['restitution']:g}",
        "exact": numeral(step["exact"], ".4f"),
        "start": numeral(100 * step["start"], "+.1f") + " %",
        "same_times": numeral(step["same_times"], ".4f"),
        "density": percent(step["density"]),
        "predicted": "–" if predicted is None else numeral(100 * predicted, "+.1f") + " %",
        "disks": number(step["disks"]["value"], step["disks"]["error"]),
        "free_path": percent(step["free_path"]),
        "fit": f"{step['fit']:g}",
    }


def verdict_words(row: Mapping[str, Any]) -> dict[str, str]:
    """The word of a row's verdict, what is added to it, and the class of the style sheet."""
    word, more, style = WORDS[row["verdict"]], "", str(row["verdict"])
    if row["verdict"] == Verdict.AGREES and row["kind"] == "statistical":
        within = row["within"]
        more = f"better than {numeral(100 * within, '.2g')} %"
        if within > _LOW_POWER:
            style = "weak"
    return {"word": word, "more": more, "style": style}


def _observables(document: Mapping[str, Any]) -> dict[str, Names]:
    """The names of the observables; in space p is G(R)/(4 pi R^2)."""
    if document["settings"].get("dimension") != 3:
        return OBSERVABLES
    title, short = OBSERVABLES["tail_exponent"]
    return OBSERVABLES | {"tail_exponent": Names(title.replace("G(R)/R ", "G(R)/R² "), short)}


def _figure_groups(document: Mapping[str, Any]) -> list[tuple[str, list[str]]]:
    """Heading and names of the figures; those of another law than the paper's have no heading."""
    names = list(document["figures"])
    names = [name for name in names if name not in _head_figures(document)]
    papers = [name for name in names if name in PAPER_FIGURES]
    if "dimension" in document["settings"]:
        return [("", names)]
    others = [name for name in names if name not in papers]
    return [("The paper's figures", papers), ("Figures that the paper lacks", others)]


def _number_table(answer: Mapping[str, Any], restitutions: list[float]) -> list[dict[str, Any]]:
    """The numbers of an answer as a table: one line per name, one cell per restitution."""
    lines: dict[str, dict[float | None, str]] = {}
    for n in answer["numbers"]:
        name = n["name"].replace(" - ", " − ").replace("a2", "a₂")
        name += f"  [{n['unit']}]" if n["unit"] else ""
        shown = number(n["value"], n["error"], digits=_DIGITS.get(n["unit"], 5))
        lines.setdefault(name, {})[n["restitution"]] = shown
    return [
        {"name": name, "all": cells.get(None), "cells": [cells.get(e, "–") for e in restitutions]}
        for name, cells in lines.items()
    ]


def matrix(
    rows: Iterable[Mapping[str, Any]], restitutions: Sequence[float], observables: Iterable[str]
) -> list[dict[str, Any]]:
    """The short table: one line per comparison, one cell (or None) per restitution.

    In the order of the observables.
    """
    lines: dict[tuple[str, str, str], dict[float, Mapping[str, Any]]] = {}
    for row in rows:
        key = (row["observable"], row["source"], row["against"])
        lines.setdefault(key, {})[row["restitution"]] = row
    order = list(observables)
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


def text(document: Mapping[str, Any]) -> str:
    """What the terminal shows: the verdicts, and disks beside spheres."""
    parts = verdict_table(document), dimension_table(document)
    return "\n\n".join(part for part in parts if part)


def verdict_table(document: Mapping[str, Any]) -> str:
    """Text for the terminal, of 100 columns at most: one line per comparison, four restitutions."""
    every = document["settings"]["restitutions"]
    parts = [
        _verdict_columns(document, range(k, min(k + 4, len(every))))
        for k in range(0, len(every), 4)
    ]
    return "\n\n".join([_TABLE_LEGEND, *parts])


_TABLE_LEGEND = (
    "Differences in %. No mark: none seen; ? unclear; ! differs; ~ a formula is off by so much."
)
_MARK = {"differs": "!", "unclear": "?", "agrees": " ", "undefined": " "}
SHORT = {
    "kinetic equation, measured l": "equation, own l", "kinetic equation": "equation",
    "Boltzmann-Grad": "dilute limit", "hard disks": "disks", "hard spheres": "spheres",
    "paper's integral": "integral", "hard disks, extrapolated": "disks",
}  # fmt: skip
"""Names where columns are few; "own l": with the mean free path that the same run measured."""


def _verdict_columns(document: Mapping[str, Any], which: range) -> str:
    every = document["settings"]["restitutions"]
    lines = [["", *(f"e = {every[k]:g}" for k in which)]]
    titles = []
    last = None
    for line in matrix(document["rows"], every, OBSERVABLES):
        if line["observable"] != last:
            last = line["observable"]
            titles.append((len(lines), OBSERVABLES[last].short))
        who, against = (SHORT.get(name, name) for name in line["comparison"].split(" / "))
        cells = []
        for k in which:
            row = line["rows"][k]
            text = "–" if row is None else _percent(row)
            cells.append(f"{_MARK.get(row['verdict'], '~') if row else ' '} {text}")
        lines.append([f"  {who} / {against}", *cells])
    shown = aligned(lines).splitlines()
    for at, title in reversed(titles):
        shown.insert(at, title)
    return "\n".join(shown)


def deviation(row: Mapping[str, Any]) -> str:
    """A row's relative deviation, with its standard error where it has one."""
    value = row["deviation"]
    if value is None:
        return "–"
    if row["kind"] == "numerical":
        return numeral(value, ".0e")
    if row["error"] is None:
        if value >= 1:
            return f"factor {numeral(1 + value, '.2g')}"
        return numeral(100 * value, "+.1f") + " %"
    return number(100 * value, relative_error(row), "+") + " %"


def _percent(row: Mapping[str, Any]) -> str:
    """A row's deviation for a table whose numbers are all in per cent."""
    if row["kind"] == "numerical" and row["deviation"] is not None:
        return numeral(100 * row["deviation"], ".0e")
    return deviation(row).removesuffix(" %")
