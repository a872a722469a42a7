"""The data of each figure of a comparison, as kinetics.crosscheck.report.figures draws it."""

from typing import Any

import numpy as np

from kinetics.crosscheck.comparison.data_and_theory import LEAST_EXPECTED, DataAndTheory
from kinetics.crosscheck.comparison.result import OBSERVABLES
from kinetics.crosscheck.comparison.theory import (
    DISPLACEMENT,
    SPEED,
    average_of,
    solved_averages,
    system_of,
)
from kinetics.crosscheck.report.figures import Data, axis, figure, series

_POINTS = 60
"""Of the theory's lines, for a page that is some 500 pixels wide."""
_LEAST_BINS = 3
_DECADES = 30.0
"""Largest over smallest value from which on an axis is logarithmic."""


def figures_of(both: DataAndTheory, explained: Any = None) -> dict[str, Data]:
    """The data of every figure, by figure name.

    explained (n_names, n_times): the averages that the likeliest explanation expects, or None.
    """
    figures = {}
    later = both.sample.times[both.sample.times > 0]
    if later.size and both.names:
        times = np.geomspace(later[0], later[-1], _POINTS) if later.size > 1 else later
        theory = solved_averages(system_of(both.solution), times, both.names)
        for i, name in enumerate(both.names):
            line = average_of(theory, name)
            figures[name.replace("_", "-")] = _over_time(both, i, (times, line), explained)
    if np.any(both.usable & (both.sample.times > 0)):
        figures["sigmas"] = _sigmas(both)
    for name in (SPEED, DISPLACEMENT):
        shown = [h for h in both.histograms if h.name == name and h.share.size > _LEAST_BINS]
        if shown:
            figures[name.replace("_", "-")] = _density(name, shown)
    return figures


_TIME, _SENTENCES = axis("time $t$", "d/U", "log"), "comparison.txt.j2"


def _over_time(both: DataAndTheory, i: int, theory: tuple[Any, Any], explained: Any) -> Data:
    fine, line = theory
    observable = OBSERVABLES[both.names[i]]
    times = both.sample.times
    shown = (times > 0) & np.isfinite(both.expectation.values[i])
    values, error = both.expectation.values[i, shown], both.error[i, shown]
    every = np.concatenate([values, line])
    scale = observable.scale
    if scale == "log" and not (every.min() > 0 and every.max() > _DECADES * every.min()):
        scale = "linear"
    lines = [
        series("kinetic equation", fine, line),
        series("data", times[shown], values, error, group="data"),
    ]
    if explained is not None:
        lines.append(series("best explanation", times[shown], explained[i, shown]))
    y = axis(observable.symbol, observable.unit, scale)
    made = figure("over_time", _TIME, y, lines, _SENTENCES, title=observable.name)
    ratio = _over_theory(both, i, explained)
    return made if ratio is None else made | {"ratio": ratio}


def _over_theory(both: DataAndTheory, i: int, explained: Any) -> Data | None:
    """Data and best explanation over the equation, which must be positive, for the panel below."""
    times, theory = both.sample.times, both.theory[i]
    shown = (times > 0) & np.isfinite(both.expectation.values[i])
    if np.count_nonzero(shown) < 2 or not np.all(theory[shown] > 0):
        return None
    at, scale = times[shown], theory[shown]
    values, error = both.expectation.values[i, shown] / scale, both.error[i, shown] / scale
    lines = [
        series("zero", at[[0, -1]], [1.0, 1.0]),
        series("data", at, values, error, group="data"),
    ]
    if explained is not None:
        lines.append(series("best explanation", at, explained[i, shown] / scale))
    return {"y": axis("over the equation"), "series": lines}


def _sigmas(both: DataAndTheory) -> Data:
    times = both.sample.times
    lines = [series("zero", [times[times > 0][0], times[-1]], [0.0, 0.0])]
    for i, name in enumerate(both.names):
        shown = both.usable[i] & (times > 0)
        if np.any(shown):
            z, group = both.difference[i, shown] / both.error[i, shown], name.replace("_", " ")
            lines.append(series("data", times[shown], z, np.ones(z.size), group=group))
    return figure("sigmas", _TIME, axis("difference / standard error"), lines, _SENTENCES)


def _density(name: str, histograms: list[Any]) -> Data:
    lines = []
    for found in histograms:
        group = f"t = {found.time:.4g}"
        # The first bin begins at 0 and the last has no end: a logarithmic axis has neither.
        low, high = found.edges[1:-2], found.edges[2:-1]
        width, middle = high - low, np.sqrt(low * high)
        value, error, theory = (
            part[1:-1] / width for part in (found.share, found.error, found.theory)
        )
        shown = value > 0
        lines.append(series("kinetic equation", middle, theory, group=group))
        lines.append(series("data", middle[shown], value[shown], error[shown], group=group))
    _, _, what, label, unit, scale = OBSERVABLES[name]
    x, y = axis(label, unit, scale), axis("density", f"1/{unit}", scale)
    return figure("density", x, y, lines, _SENTENCES, what=what, least=LEAST_EXPECTED)
