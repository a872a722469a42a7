"""The report's document as one HTML page with nothing beside it."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from kinetics.crosscheck.report.all_figures import PAPER_FIGURES
from kinetics.crosscheck.report.equations import report_equations
from kinetics.crosscheck.report.figures import svg
from kinetics.crosscheck.report.row import TITLES, scale_of

if TYPE_CHECKING:
    from jinja2 import Environment

SHORT = {
    "free_path": "mean free path",
    "cooling_rate": "h(e)",
    "a2": "a₂",
    "thermal_speed": "v₀(t)",
    "scaled_vdf": "F(c)",
    "msd": "⟨r²(t)⟩",
    "msd_slope": "d⟨r²⟩/d ln t",
    "kurtosis": "⟨r⁴⟩/⟨r²⟩²",
    "position": "G(R)",
    "tail_exponent": "n(R)",
}
"""The name of each observable where space is short."""


def environment() -> "Environment":
    """Jinja's, for the templates of this package: everything is escaped, nothing is undefined."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    return Environment(
        loader=PackageLoader("kinetics.crosscheck"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )


def render(document: Mapping[str, Any]) -> str:
    """The page. Every text of the document is escaped."""
    return (
        environment()
        .get_template("report.html.j2")
        .render(
            doc=document,
            answers=[_answer(item, document["settings"]) for item in document["answers"]],
            figure_groups=_figure_groups(document["figures"]),
            svgs={name: Markup(svg(name, data)) for name, data in document["figures"].items()},
            equations=report_equations(),
            matrix=matrix(document),
            groups=_groups(document["rows"]),
            algebra=[_algebra(check) for check in document["algebra"]],
            method=_method(document),
        )
    )


def _answer(item: Mapping[str, Any], settings: Mapping[str, Any]) -> dict[str, Any]:
    """A question with its numbers as a table: one line per name, one cell per restitution."""
    lines: dict[tuple[str, str], dict[float | None, str]] = {}
    for n in item["numbers"]:
        cells = lines.setdefault((n["name"], n["unit"]), {})
        cells[n["restitution"]] = number(n["value"], n["error"])
    table = [
        {
            "name": f"{name}  [{unit}]" if unit else name,
            "all": cells.get(None),
            "cells": [cells.get(e, "–") for e in settings["restitutions"]],
        }
        for (name, unit), cells in lines.items()
    ]
    return {"question": item["question"], "answer": item["answer"], "table": table}


def _figure_groups(figures: Mapping[str, Any]) -> list[tuple[str, list[str]]]:
    """The headings over the figures, and the names of the figures below each."""
    paper = [name for name in figures if name in PAPER_FIGURES]
    others = [name for name in figures if name not in PAPER_FIGURES]
    groups = [("The paper's figures", paper), ("Figures that the paper lacks", others)]
    return [(title, names) for title, names in groups if names]


def matrix(document: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The short table: one line per comparison, one cell (or None) per restitution."""
    restitutions = document["settings"]["restitutions"]
    lines: dict[tuple[str, str, str], dict[float, Mapping[str, Any]]] = {}
    for row in document["rows"]:
        key = (row["observable"], row["source"], row["against"])
        lines.setdefault(key, {})[row["restitution"]] = row
    order = list(SHORT)
    return [
        {
            "quantity": SHORT[observable],
            "title": TITLES[observable],
            "comparison": f"{source} / {against}",
            "cells": [
                {"verdict": cells[e]["verdict"], "deviation": deviation(cells[e])}
                if e in cells
                else None
                for e in restitutions
            ],
        }
        for (observable, source, against), cells in sorted(
            lines.items(), key=lambda item: order.index(item[0][0])
        )
    ]


def deviation(row: Mapping[str, Any]) -> str:
    """A row's relative deviation, with its standard error where it has one."""
    value = row["deviation"]
    if value is None:
        return "–"
    if row["kind"] == "numerical":
        return f"{value:.0e}"
    if row["error"] is None:
        return f"{100 * value:+.1f} %"
    error = 100 * row["error"] / scale_of(row["observable"], row["theory"])
    digits = max(0, 1 - math.floor(math.log10(error)))
    return f"{100 * value:+.{digits}f} ± {error:.{digits}f} %"


def number(value: float | None, error: float | None = None) -> str:
    """A number to 6 digits, or to the second digit of its standard error."""
    if value is None:
        return "–"
    if not error:
        return f"{value:.6g}"
    digits = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:.{digits}f} ± {error:.{digits}f}"


def _groups(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    return [
        {"title": title, "rows": [_shown(row) for row in rows if row["observable"] == name]}
        for name, title in TITLES.items()
    ]


def _shown(row: Mapping[str, Any]) -> dict[str, str]:
    at = ""
    if row["time"] is not None:
        at = f"t = {row['time']:.4g}"
    elif row["c"] is not None:
        at = f"c = {row['c']:.3g}"
    if row["distance"] is not None:
        at = f"R = {row['distance']:.3g}"
    if row["looks"] > 1:
        at += f", worst of {row['looks']}"
    return {
        "restitution": f"{row['restitution']:g}",
        "source": row["source"],
        "against": row["against"],
        "at": at,
        "value": number(row["value"], row["error"]),
        "theory": number(row["theory"]),
        "deviation": deviation(row),
        "sigmas": "" if row["sigmas"] is None else f"{row['sigmas']:+.1f}",
        "corrected": ("" if row["corrected_sigmas"] is None else f"{row['corrected_sigmas']:.1f}"),
        "verdict": row["verdict"],
        "note": row["note"],
    }


def _algebra(check: Mapping[str, Any]) -> dict[str, Any]:
    """A check with its formulas as MathML."""
    shown = dict(check)
    for side in ("printed", "derived"):
        # Written by sympy's printer from the package's own formulas, not from anybody's data.
        shown[side] = Markup(check[f"{side}_mathml"])
    return shown


def _method(document: Mapping[str, Any]) -> dict[str, str]:
    settings = document["settings"]
    times = ", ".join(f"{t:g}" for t in settings["final_times"])
    return {
        "solver": (
            f"relative tolerance asked for {settings['rtol']:g}, {settings['position_rtol']:g} for "
            "G(R)"
        ),
        "hard disks": (
            f"{settings['media']} configurations of {settings['count']} disks times "
            f"{settings['tracers']} velocities, starting at the centre of the periodic box"
        ),
        "Boltzmann-Grad": f"{settings['free_tracers']} tracers with exponential free paths",
        "last times": f"{times} d/U, in the order of the restitutions",
        "standard errors": "jackknife over independent configurations",
        "seed": str(settings["seed"]),
        "versions": ", ".join(f"{k} {v}" for k, v in document["software"].items()),
    }
