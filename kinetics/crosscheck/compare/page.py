"""A comparison as tables for the terminal, as figures, and as a page with its numbers as JSON."""

import textwrap
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.crosscheck.compare.draw import drawn
from kinetics.crosscheck.compare.judge import Both
from kinetics.crosscheck.compare.result import OBSERVABLES, OUTCOMES, Comparison
from kinetics.crosscheck.compare.theory import DISPLACEMENT, SPEED, average_of, solved_averages
from kinetics.crosscheck.files import require_file
from kinetics.crosscheck.words import MEANING, Verdict, number, numeral
from kinetics.errors import InputError

WIDTH = 100  # columns of a terminal
UNITS = (
    "Lengths in d, the diameter of a scatterer and of the tracer; speeds in U, the standard "
    "deviation of one component of the initial velocity; times in d/U; densities in d⁻²."
)
PARAMETERS = {
    "restitution": "restitution e",
    "number_density": "number density ρ₀ / d⁻²",
    "mean_free_path": "mean free path l / d",
}
_POINTS = 60  # of the theory's lines
_LEAST_BINS = 3
_DECADES = 30.0
"""Largest over smallest value from which on an axis is logarithmic."""

# -- tables ----------------------------------------------------------------------------------------


def test_cells(result: Comparison) -> list[list[str]]:
    """The chi-squares, a line each below the heads."""
    lines = [["chi-square", "t [d/U]", "value", "dof", "p", "sigmas", "better than", "verdict"]]
    for t in result.tests:
        within = t.within if t.verdict is Verdict.AGREES else None
        lines.append(
            [t.observable, "all" if t.time is None else numeral(t.time, ".4g"),
             numeral(t.chi_square, ".4g"), str(t.dof), numeral(t.p_value, ".2g"),
             numeral(t.sigmas, ".1f"),
             "" if within is None else f"{numeral(100 * within, '.2g')} %", str(t.verdict)]
        )  # fmt: skip
    return lines


def row_cells(result: Comparison, every: bool = True) -> list[list[str]]:
    """The rows, a line each below the heads; or those over time, and bins that do not agree."""
    lines = [["observable", "t [d/U]", "bin", "value ± s.e.", "theory", "sigmas", "verdict"]]
    columns = result.columns
    for row in zip(*(columns[name] for name in columns), strict=True):
        r = dict(zip(columns, row, strict=True))
        if not (every or r["low"] is None or r["verdict"] != Verdict.AGREES):
            continue
        high = "∞" if r["high"] is None else numeral(r["high"], ".4g")
        lines.append(
            [r["observable"], numeral(r["time"], ".4g"),
             "" if r["low"] is None else f"{numeral(r['low'], '.4g')} to {high}",
             number(r["value"], r["error"]), number(r["theory"]),
             "" if r["sigmas"] is None else numeral(r["sigmas"], "+.1f"), str(r["verdict"])]
        )  # fmt: skip
    return lines


def tables(result: Comparison) -> str:
    """The answer, parameters, tests, averages over time, odd bins, and explanations, as text."""
    parts = [_wrapped(result.summary), *(_wrapped(f"note: {text}") for text in result.warnings)]
    told = [
        _wrapped(f"{k}: {number(p.value, p.error)} ({p.source})")
        for k, p in result.parameters.items()
    ]
    made = f"from {result.groups} groups, by {result.grouping}" if result.groups else "as told"
    parts.append("\n".join([*told, f"start: {result.initial}", f"errors: {made}"]))
    shown = row_cells(result, every=False)
    text = _aligned(shown)
    if hidden := len(result.columns["time"]) + 1 - len(shown):
        text += f"\n({hidden} bins of densities that agree are left out; --json has them)"
    parts += [_aligned(test_cells(result)), text]
    parts += [_wrapped(f"{x.name} ({OUTCOMES[x.outcome]}): {x.text}") for x in result.explanations]
    return "\n\n".join(parts)


def _wrapped(text: str) -> str:
    return textwrap.fill(text, WIDTH, subsequent_indent="  ", break_on_hyphens=False)


def _aligned(lines: Sequence[Sequence[str]]) -> str:
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    )


# -- figures ---------------------------------------------------------------------------------------


def _axis(label: str, unit: str = "", scale: str = "linear") -> dict[str, str]:
    return {"label": label, "unit": unit, "scale": scale}


def _series(source: str, x: Any, y: Any, error: Any = None, group: str = "") -> dict[str, Any]:
    """Points, or a line; NaN is null."""
    lists = (None if a is None else np.asarray(a, float).tolist() for a in (x, y, error))
    return {"source": source, "group": group} | dict(zip(("x", "y", "error"), lists, strict=True))


def figures_of(both: Both, expected: Any = None) -> dict[str, Any]:
    """The data of every figure, by figure name.

    expected (n_names, n_times): the averages that the likeliest explanation expects, or None.
    """
    figures, times, log_time = {}, both.sample.times, _axis("time $t$", "d/U", "log")
    later = times[times > 0]
    if later.size and both.names:
        fine = np.geomspace(later[0], later[-1], _POINTS) if later.size > 1 else later
        theory = solved_averages(both.point, both.sample.law, fine, both.names)
        for i, name in enumerate(both.names):
            seen = OBSERVABLES[name]
            shown = (times > 0) & np.isfinite(both.expectation.values[i])
            at, value, error = times[shown], both.expectation.values[i, shown], both.error[i, shown]
            line = average_of(theory, name)
            every = np.concatenate([value, line])
            positive = every.min() > 0 and every.max() > _DECADES * every.min()
            lines = [_series("kinetic equation", fine, line), _series("data", at, value, error)]
            if expected is not None:
                lines.append(_series("best explanation", at, expected[i, shown]))
            figures[name.replace("_", "-")] = {
                "title": seen.name,
                "x": log_time,
                "y": _axis(seen.symbol, seen.unit, seen.scale if positive else "linear"),
                "series": lines,
            }
    if np.any(both.usable & (times > 0)):
        lines = [_series("zero", later[[0, -1]], [0.0, 0.0])]
        for i, name in enumerate(both.names):
            shown = both.usable[i] & (times > 0)
            if np.any(shown):
                z, one = both.difference[i, shown] / both.error[i, shown], np.ones(np.sum(shown))
                lines.append(_series("data", times[shown], z, one, OBSERVABLES[name].symbol))
        y = _axis("difference / standard error")
        title = "Differences in standard errors"
        figures["sigmas"] = {"title": title, "x": log_time, "y": y, "series": lines}
    for name in (SPEED, DISPLACEMENT):
        mine = [h for h in both.histograms if h.name == name and h.share.size > _LEAST_BINS]
        lines = []
        for found in mine:
            # The first bin begins at 0 and the last has no end: a logarithmic axis has neither.
            low, high = found.edges[1:-2], found.edges[2:-1]
            parts = (found.share, found.error, found.theory)
            value, error, line = (part[1:-1] / (high - low) for part in parts)
            middle, group = np.sqrt(low * high), f"t = {found.time:.4g}"
            lines.append(_series("kinetic equation", middle, line, group=group))
            shown = value > 0
            lines.append(_series("data", middle[shown], value[shown], error[shown], group))
        if mine:
            seen = OBSERVABLES[name]
            figures[name.replace("_", "-")] = {
                "title": seen.name,
                "x": _axis(seen.symbol, seen.unit, "log"),
                "y": _axis("density", f"1/{seen.unit}", "log"),
                "series": lines,
            }
    return figures


# -- files -----------------------------------------------------------------------------------------


def prepare(output: Path, data: Iterable[Path]) -> None:
    """InputError, before anything is read, for an output that cannot be written.

    Or that would take the place of the data.
    """
    for path, endings in ((output, (".html", ".htm")), (output.with_suffix(".json"), (".json",))):
        require_file("output", path, endings)
        if any(path.resolve() == other.resolve() for other in data):
            raise InputError(f"output: {str(path)!r} is one of the data; they are never changed")


def files_of(
    result: Comparison, output: Path, formats: Sequence[str] = ()
) -> dict[str, str | bytes]:
    """File names and contents: the page, the JSON beside it, and figures in these formats."""
    numbers = output.with_suffix(".json").name
    files: dict[str, str | bytes] = {
        numbers: result.to_json(),
        output.name: render(result, numbers),
    }
    for kind in formats:
        for name, data in result.figures.items():
            files[f"{output.stem}-{name}.{kind}"] = drawn([data], kind)
    return files


def render(result: Comparison, json_name: str) -> str:
    """The page, with nothing beside it. Every text of the comparison is escaped."""
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup

    made = Environment(
        loader=PackageLoader("kinetics.crosscheck"), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    svg = ""
    if result.figures:
        text = drawn([*result.figures.values()]).decode()
        svg = text[text.index("<svg") :]
    best = result.explanations[0] if result.explanations else None
    return made.get_template("comparison.html.j2").render(
        result=result,
        cause=best if best and best.outcome in ("explains", "found", "in part") else None,
        outcomes=OUTCOMES,
        meanings={v: MEANING[v] for v in (Verdict.AGREES, Verdict.UNCLEAR, Verdict.DIFFERS)},
        parameters={
            PARAMETERS[k]: f"{number(p.value, p.error)} ({p.source})"
            for k, p in result.parameters.items()
        },
        observables=OBSERVABLES,
        tests=test_cells(result),
        rows=row_cells(result),
        svg=Markup(svg),
        units=UNITS,
        json_name=json_name,
    )
