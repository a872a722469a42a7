"""The data of each figure of a comparison, as kinetics.crosscheck.report.figures draws it."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from kinetics.crosscheck.comparison.theory import DISPLACEMENT, RTOL, SPEED, scene

if TYPE_CHECKING:
    from kinetics.crosscheck.comparison.differences import Judged

Data = dict[str, Any]

_POINTS = 60
_LEAST_BINS = 3
_DECADES = 30.0
"""Largest over smallest value from which on an axis is logarithmic."""
_AXES: dict[str, tuple[str, str, str, str]] = {
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


def figures_of(judged: "Judged") -> dict[str, Data]:
    """The data of every figure, by figure name."""
    figures = {}
    lines = _lines(judged)
    for i, name in enumerate(judged.expectation.names):
        if name in lines and np.any(judged.sample.times > 0):
            figures[name.replace("_", "-")] = _over_time(judged, i, name, lines)
    if np.any(judged.usable & (judged.sample.times > 0)):
        figures["sigmas"] = _sigmas(judged)
    for name in (SPEED, DISPLACEMENT):
        if any(h[0] == name and h[2].share.size > _LEAST_BINS for h in judged.histograms):
            figures[name.replace("_", "-")] = _density(judged, name)
    return figures


def _lines(judged: "Judged") -> dict[str, Any]:
    """The theory over time, more finely than the data."""
    from kinetics import solve

    found = judged.solution.scene
    names = [name for name in judged.expectation.names if name in found.outputs]
    later = judged.sample.times[judged.sample.times > 0]
    if not names or later.size == 0:
        return {}
    times = np.geomspace(later[0], later[-1], _POINTS) if later.size > 1 else later
    start = found.initial
    fine = solve(
        scene(found.restitution, found.mean_free_path, start, times, names), rtol=max(RTOL, 1e-8)
    )
    return {name: np.asarray(getattr(fine, name)) for name in names} | {"times": times}


def _axis(label: str, unit: str = "", scale: str = "linear") -> Data:
    return {"label": label, "unit": unit, "scale": scale, "limits": None}


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


def _over_time(judged: "Judged", i: int, name: str, lines: dict[str, Any]) -> Data:
    title, label, unit, scale = _AXES[name]
    times = judged.sample.times
    shown = (times > 0) & np.isfinite(judged.expectation.values[i])
    values, error = judged.expectation.values[i, shown], judged.error[i, shown]
    every = np.concatenate([values, lines[name]])
    if scale == "log" and not (every.min() > 0 and every.max() > _DECADES * every.min()):
        scale = "linear"
    return {
        "title": title,
        "description": f"{title} over time: the data, and the kinetic equation. {_BARS}",
        "x": _axis("time $t$", "d/U", "log"),
        "y": _axis(label, unit, scale),
        "series": [
            _series("kinetic equation", lines["times"], lines[name]),
            _series("data", times[shown], values, error, "data"),
        ],
    }


def _sigmas(judged: "Judged") -> Data:
    times = judged.sample.times
    series = [_series("zero", [times[times > 0][0], times[-1]], [0.0, 0.0])]
    for i, name in enumerate(judged.expectation.names):
        shown = judged.usable[i] & (times > 0)
        if np.any(shown):
            z = judged.difference[i, shown] / judged.error[i, shown]
            label = name.replace("_", " ")
            series.append(_series("data", times[shown], z, np.ones(z.size), label))
    return {
        "title": "Differences in standard errors",
        "description": "Data minus kinetic equation, each divided by its standard error, over "
        "time. The same tracers stand behind neighbouring points, so that these move together; "
        "the chi-squares of the table take that into account.",
        "x": _axis("time $t$", "d/U", "log"),
        "y": _axis("difference / standard error"),
        "series": series,
    }


def _density(judged: "Judged", name: str) -> Data:
    series = []
    for kind, k, found in judged.histograms:
        if kind != name or found.share.size <= _LEAST_BINS:
            continue
        group = f"t = {judged.sample.times[k]:.4g}"
        # The first bin begins at 0 and the last has no end: a logarithmic axis has neither.
        low, high = found.edges[1:-2], found.edges[2:-1]
        width = high - low
        middle = np.sqrt(low * high)
        inner = slice(1, -1)
        shown = found.share[inner] > 0
        value, error = found.share[inner] / width, found.error[inner] / width
        series.append(_series("kinetic equation", middle, found.theory[inner] / width, None, group))
        series.append(_series("data", middle[shown], value[shown], error[shown], group))
    speed = name == SPEED
    what = "speed" if speed else "displacement"
    return {
        "title": f"{what.capitalize()} density",
        "description": f"Density of the {what}, averaged over bins in which at least 50 samples "
        f"are expected: the data, and the kinetic equation averaged over the same bins, joined by "
        f"straight lines. {_BARS} What lies in the first and the last bin is in the table.",
        "x": _axis("speed $v$" if speed else "displacement $r$", "U" if speed else "d", "log"),
        "y": _axis("density", "1/U" if speed else "1/d", "log"),
        "series": series,
    }
