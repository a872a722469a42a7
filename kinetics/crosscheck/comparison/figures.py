"""The data of each figure of a comparison, as kinetics.crosscheck.report.figures draws it."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from kinetics.crosscheck.comparison.data_and_theory import DataAndTheory
from kinetics.crosscheck.comparison.theory import DISPLACEMENT, RTOL, SPEED, solved

Data = dict[str, Any]

_POINTS = 60
"""Of the theory's lines, for a page that is some 500 pixels wide."""
_LEAST_BINS = 3
_DECADES = 30.0
"""Largest over smallest value from which on an axis is logarithmic."""
_AXES = {
    "thermal_speed": ("Thermal speed", "$v_0$", "U", "log"),
    "a2": ("Second Sonine coefficient", "$a_2$", "", "linear"),
    "msd": ("Mean square displacement", r"$\langle r^2\rangle$", "d²", "log"),
    "kurtosis": (
        "Kurtosis of the displacement",
        r"$\langle r^4\rangle/\langle r^2\rangle^2$",
        "",
        "linear",
    ),
}
_BARS = "The bars are one standard error."


def figures_of(both: DataAndTheory) -> dict[str, Data]:
    """The data of every figure, by figure name."""
    figures = {}
    later = both.sample.times[both.sample.times > 0]
    if later.size and both.names:
        scene = both.solution.scene
        times = np.geomspace(later[0], later[-1], _POINTS) if later.size > 1 else later
        theory = solved(
            scene.restitution, scene.mean_free_path, scene.initial, times, both.names, RTOL
        )
        for i, name in enumerate(both.names):
            line = np.asarray(getattr(theory, name))
            figures[name.replace("_", "-")] = _over_time(both, i, times, line)
    if np.any(both.usable & (both.sample.times > 0)):
        figures["sigmas"] = _sigmas(both)
    for name in (SPEED, DISPLACEMENT):
        shown = [h for h in both.histograms if h.name == name and h.share.size > _LEAST_BINS]
        if shown:
            figures[name.replace("_", "-")] = _density(name, shown)
    return figures


def _figure(title: str, description: str, x: Data, y: Data, series: list[Data]) -> Data:
    return {"title": title, "description": description, "x": x, "y": y, "series": series}


def _axis(label: str, unit: str = "", scale: str = "linear") -> Data:
    return {"label": label, "unit": unit, "scale": scale, "limits": None}


_TIME = _axis("time $t$", "d/U", "log")


def _series(
    source: str, x: Iterable[Any], y: Iterable[Any], error: Any = None, group: str | None = None
) -> Data:
    def numbers(values: Iterable[Any]) -> list[float | None]:
        return [float(v) if np.isfinite(v) else None for v in values]

    return {
        "source": source,
        "restitution": None,
        "group": group,
        "x": numbers(x),
        "y": numbers(y),
        "error": None if error is None else numbers(error),
    }


def _over_time(both: DataAndTheory, i: int, fine: Any, line: Any) -> Data:
    title, label, unit, scale = _AXES[both.names[i]]
    times = both.sample.times
    shown = (times > 0) & np.isfinite(both.expectation.values[i])
    values, error = both.expectation.values[i, shown], both.error[i, shown]
    every = np.concatenate([values, line])
    if scale == "log" and not (every.min() > 0 and every.max() > _DECADES * every.min()):
        scale = "linear"
    return _figure(
        title,
        f"{title} over time: the data, and the kinetic equation. {_BARS}",
        _TIME,
        _axis(label, unit, scale),
        [
            _series("kinetic equation", fine, line),
            _series("data", times[shown], values, error, "data"),
        ],
    )


def _sigmas(both: DataAndTheory) -> Data:
    times = both.sample.times
    series = [_series("zero", [times[times > 0][0], times[-1]], [0.0, 0.0])]
    for i, name in enumerate(both.names):
        shown = both.usable[i] & (times > 0)
        if np.any(shown):
            z = both.difference[i, shown] / both.error[i, shown]
            series.append(_series("data", times[shown], z, np.ones(z.size), name.replace("_", " ")))
    return _figure(
        "Differences in standard errors",
        "Data minus kinetic equation, each divided by its standard error, over time. The same "
        "tracers stand behind neighbouring points, so that these move together; the chi-squares of "
        "the table take that into account.",
        _TIME,
        _axis("difference / standard error"),
        series,
    )


def _density(name: str, histograms: list[Any]) -> Data:
    series = []
    for found in histograms:
        group = f"t = {found.time:.4g}"
        # The first bin begins at 0 and the last has no end: a logarithmic axis has neither.
        low, high = found.edges[1:-2], found.edges[2:-1]
        width, middle = high - low, np.sqrt(low * high)
        value, error, theory = (
            part[1:-1] / width for part in (found.share, found.error, found.theory)
        )
        shown = value > 0
        series.append(_series("kinetic equation", middle, theory, None, group))
        series.append(_series("data", middle[shown], value[shown], error[shown], group))
    what, x, unit = ("speed", "speed $v$", "U")
    if name == DISPLACEMENT:
        what, x, unit = ("displacement", "displacement $r$", "d")
    return _figure(
        f"{what.capitalize()} density",
        f"Density of the {what}, averaged over bins in which at least 50 samples are expected: the "
        "data, and the kinetic equation averaged over the same bins, joined by straight lines. "
        f"{_BARS} What lies in the first and the last bin is in the table.",
        _axis(x, unit, "log"),
        _axis("density", f"1/{unit}", "log"),
        series,
    )
