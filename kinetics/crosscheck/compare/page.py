"""A comparison as tables for the terminal, as figures, and as a page with its numbers as JSON."""

import io
import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np

from kinetics.crosscheck.compare.theory import OBSERVABLES
from kinetics.crosscheck.words import MEANING, Verdict, number, numeral

# what an explanation comes to, in words; in the order in which they are shown
OUTCOMES = {
    "explains": "explains the difference", "found": "found in the data",
    "in part": "explains part of it", "does not": "does not explain it", "noted": "noted",
}  # fmt: skip
_REGIONS = {"68 %": 1.515, "95 %": 2.448}  # radii that hold so much of a Gaussian of two numbers


def cells_of(result: Any) -> tuple[list[list[str]], list[list[str]]]:
    """The chi-squares, and the rows, a line each below the heads."""
    tests = [["chi-square", "t [d/U]", "value", "dof", "p", "sigmas", "better than", "verdict"]]
    for t in result.tests:
        within = "" if t.within is None else f"{numeral(100 * t.within, '.2g')} %"
        tests.append([
            t.observable, "all" if t.time is None else numeral(t.time, ".4g"),
            numeral(t.chi_square, ".4g"), str(t.dof), numeral(t.p_value, ".2g"),
            numeral(t.sigmas, ".1f"), within * (t.verdict is Verdict.AGREES), str(t.verdict),
        ])  # fmt: skip
    rows = [["observable", "t [d/U]", "bin", "value ± s.e.", "theory", "sigmas", "verdict"]]
    for r in result.numbers:
        ends = ("∞" if end is None else numeral(end, ".4g") for end in (r.low, r.high))
        rows.append([
            r.observable, numeral(r.time, ".4g"), "" if r.low is None else " to ".join(ends),
            number(r.value, r.error), number(r.theory),
            "" if r.sigmas is None else numeral(r.sigmas, "+.1f"), str(r.verdict),
        ])  # fmt: skip
    return tests, rows


def scene_of(result: Any) -> dict[str, str]:
    """What was compared, by name."""
    made = f"from {result.groups} groups, by {result.grouping}"
    told = {n: f"{number(p.value, p.error)} ({p.source})" for n, p in result.parameters.items()}
    return told | {"start": result.initial, "errors": made}


def tables(result: Any) -> str:
    """The answer, parameters, tests, averages over time, odd bins, and explanations, as text."""

    def aligned(lines: Sequence[Sequence[str]]) -> str:
        wide = [max(map(len, column)) for column in zip(*lines, strict=True)]
        padded = ([cell.ljust(w) for cell, w in zip(line, wide, strict=True)] for line in lines)
        return "\n".join("  ".join(cells).rstrip() for cells in padded)

    def wrapped(text: str) -> str:
        return textwrap.fill(text, 100, subsequent_indent="  ", break_on_hyphens=False)

    tests, rows = cells_of(result)
    shown = [row for row in rows if not row[2] or row[-1] != Verdict.AGREES]
    hidden = len(rows) - len(shown)
    left_out = f"\n({hidden} bins of densities that agree are left out; --json has them)"
    parts = [
        wrapped(result.summary), *(wrapped(f"note: {text}") for text in result.warnings),
        "\n".join(wrapped(f"{name}: {text}") for name, text in scene_of(result).items()),
        aligned(tests), aligned(shown) + left_out * (hidden > 0),
        *(wrapped(f"{x.name} ({OUTCOMES[x.outcome]}): {x.text}") for x in result.explanations),
    ]  # fmt: skip
    return "\n\n".join(parts)


def render(result: Any, json_name: str) -> str:
    """The page, with nothing beside it. Every text of the comparison is escaped."""
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup

    loader = PackageLoader("kinetics.crosscheck")
    made = Environment(
        loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True,
    )  # fmt: skip
    svg = drawn(result, result.figures).decode() if result.figures else ""
    tests, rows = cells_of(result)
    return made.get_template("comparison.html.j2").render(
        result=result, outcomes=OUTCOMES, scene=scene_of(result), tests=tests, rows=rows,
        meanings={v: MEANING[v] for v in (Verdict.AGREES, Verdict.UNCLEAR, Verdict.DIFFERS)},
        svg=Markup(svg[svg.find("<svg") :]), json_name=json_name,
    )  # fmt: skip


# -- the figures, drawn from the rows: data beside theory, and all deviations ----------------------
def draw(result: Any, figure: str, ax: Any) -> None:
    """Draw one figure on matplotlib's axes: lines for theory, points with bars for data."""
    name, rows = figure.replace("-", "_"), result.rows[result.rows["time"] > 0]
    mine, bars = rows[rows["observable"] == name], {"fmt": "o", "ms": 4, "lw": 1}
    x, x_scale, y_scale = "time $t$ / (d/U)", "log", "linear"
    if name == "confidence":
        title, x_scale = "Restitution and mean free path together", "linear"
        x, y = "restitution $e$", "mean free path $l$ / d"
        e, path = (result.parameters[k].value for k in ("restitution", "mean_free_path"))
        angle, root = np.linspace(0, 2 * np.pi, 121), np.linalg.cholesky(result.covariance)
        away = root @ np.stack([np.cos(angle), np.sin(angle)])
        for share, radius in _REGIONS.items():
            ax.plot(e + radius * away[0], path * np.exp(radius * away[1]), label=share)
        ax.plot(e, path, "ko", ms=4, label="fitted")
    elif OBSERVABLES[name].measured is None:
        seen = OBSERVABLES[name]
        title, y_scale = seen.title, "log"
        x, y = f"{seen.symbol} / {seen.unit}", f"density / (1/{seen.unit})"
        bins = mine[(mine["low"] > 0) & mine["high"].notna() & (mine["value"] > 0)]
        for k, (at, part) in enumerate(bins.groupby("time")):
            middle, mark = np.sqrt(part["low"] * part["high"]), {"color": f"C{k}"}
            ax.plot(middle, part["theory"], **mark)
            mark["label"] = f"t = {at:.4g}"
            ax.errorbar(middle, part["value"], part["error"], **mark, **bars)
    else:
        seen, both = OBSERVABLES[name], mine[["value", "theory"]].to_numpy()
        title, y = seen.title, f"{seen.symbol} / {seen.unit}" if seen.unit else seen.symbol
        if both.min() > 0 and both.max() > 30 * both.min():
            y_scale = "log"
        ax.plot(mine["time"], mine["theory"], label="kinetic equation")
        shown = {"color": "black", "label": "data", **bars}
        ax.errorbar(mine["time"], mine["value"], mine["error"], **shown)
    ax.set(xlabel=x, ylabel=y, xscale=x_scale, yscale=y_scale)
    ax.set_title(title, fontsize="medium")
    ax.legend(fontsize="small", frameon=False)


def drawn(result: Any, names: Sequence[str], kind: str = "svg") -> bytes:
    """Figures in two columns as one picture, in a format of matplotlib's."""
    from matplotlib.figure import Figure

    wide = min(2, len(names))
    high = -(-len(names) // wide)
    figure, buffer = Figure(figsize=(4.6 * wide, 3.2 * high), layout="constrained"), io.BytesIO()
    for k, name in enumerate(names, 1):
        draw(result, name, figure.add_subplot(high, wide, k))
    dated: Any = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}.get(kind)
    figure.savefig(buffer, format=kind, dpi=150, metadata=dated)
    return buffer.getvalue()
