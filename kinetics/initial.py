"""Initial speed distributions, as weighted points on the logarithmic speed axis.

The solver only ever needs averages of smooth functions of ln v over the initial state, so that a
state is a list of points and weights: one point for a monoenergetic start, the trapezoid rule for a
Gaussian, panels of Gauss-Legendre points for a density, and for samples of velocities the points
of a fine grid that give every smooth average that the samples give.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.collision import _gauss_legendre
from kinetics.errors import InputError, short

FloatArray = NDArray[np.float64]

NAMES = ("gaussian", "monoenergetic")


@dataclass(frozen=True)
class LogMeasure:
    """A distribution of speeds: weight w_k at ln v = x_k; the weights sum to 1.

    Attributes
    ----------
    x : ln(v/U), shape (n_points,)
    weight : shape (n_points,)
    """

    x: FloatArray
    weight: FloatArray

    def moment(self, p: float) -> float:
        """<v^p> in units of U^p."""
        top = float(self.x.max())
        return math.exp(p * top) * float(self.weight @ np.exp(p * (self.x - top)))


@dataclass(frozen=True)
class SpeedTable:
    """A tabulated speed density: linear between the points, zero outside them.

    Parameters
    ----------
    speed : in U, rising, not negative, shape (n,), n >= 2
    density : integral over the speed = 1 (within 1e-6; rescaled to it), shape (n,)

    Raises
    ------
    InputError : negative, NaN, unsorted, or not normalised
    """

    speed: ArrayLike
    density: ArrayLike

    def __post_init__(self) -> None:
        v, f = _column("speed", self.speed), _column("density", self.density)
        if v.size < 2 or v.size != f.size:
            raise InputError(f"density: got {f.size} values for {v.size} speeds; both need n >= 2")
        if np.any(np.diff(v) <= 0.0) or v[0] < 0.0:
            raise InputError(f"speed: got {short(self.speed)}; it must rise and not be negative")
        if np.any(f < 0.0):
            raise InputError(f"density: got a value of {f.min():.3g}; it must not be negative")
        total = float(np.sum(0.5 * (f[1:] + f[:-1]) * np.diff(v)))
        if not abs(total - 1.0) < 1e-6:
            raise InputError(f"density: its integral over the speed is {total:.6g}; it must be 1")
        object.__setattr__(self, "speed", v)
        object.__setattr__(self, "density", f / total)


@dataclass(frozen=True)
class SpeedSamples:
    """Speeds of particles, each of the same weight.

    Parameters
    ----------
    speed : in U, above zero, shape (n,)

    Raises
    ------
    InputError : empty, NaN or not above zero
    """

    speed: ArrayLike

    def __post_init__(self) -> None:
        v = _column("speed", self.speed)
        if v.size == 0 or np.any(v <= 0.0):
            raise InputError(f"speed: got {short(self.speed)}; samples must be above 0, at least 1")
        object.__setattr__(self, "speed", v)


InitialState = str | SpeedTable | SpeedSamples | Callable[[Any], Any]


def _column(name: str, values: ArrayLike) -> FloatArray:
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{name}: got {short(values)}; it must be an array of numbers") from None
    if array.ndim != 1 or not np.all(np.isfinite(array)):
        raise InputError(f"{name}: got {short(values)}; it must be 1-dimensional and finite")
    return array


def check_initial(initial: Any) -> InitialState:
    """The initial state as given, or an InputError that says what is allowed."""
    allowed = f"it must be one of {', '.join(NAMES)}, a SpeedTable, SpeedSamples or a function of v"
    if isinstance(initial, str) and initial not in NAMES:
        raise InputError(f"initial: got {initial!r}; {allowed}")
    if not isinstance(initial, str | SpeedTable | SpeedSamples) and not callable(initial):
        raise InputError(f"initial: got {short(initial)}; {allowed}")
    return initial


def measure(initial: InitialState, rtol: float, lowest: float = 0.0) -> LogMeasure:
    """The initial state as weighted points that give averages to about rtol.

    ``lowest`` is the smallest power of the speed that will be averaged: it tells how far down the
    slow tail matters.
    """
    if isinstance(initial, str):
        if initial == "monoenergetic":
            return LogMeasure(np.zeros(1), np.ones(1))
        return _gaussian(rtol, lowest)
    if isinstance(initial, SpeedTable):
        return _table(initial)
    if isinstance(initial, SpeedSamples):
        return _samples(np.asarray(initial.speed, dtype=float))
    return _function(initial, rtol)


def _gaussian(rtol: float, lowest: float) -> LogMeasure:
    """Speed density v exp(-v^2/2), by the trapezoid rule in ln v.

    Its transform falls as exp(-pi k/4): spacing h leaves exp(-pi^2/(2 h)), times a power of k for
    the powers of v. The left end is where
    v^(2 + lowest) is below rtol.
    """
    depth = math.log(1.0 / rtol)
    spacing = 0.5 * math.pi**2 / (depth + 14.0)
    left = -(depth + 2.0) / (2.0 + min(0.0, lowest))
    right = 0.5 * math.log(2.0 * (depth + 12.0))
    x = np.arange(left, right + spacing, spacing)
    weight = spacing * np.exp(2.0 * x - 0.5 * np.exp(2.0 * x))
    return LogMeasure(x, weight / weight.sum())


def _panels(edges: FloatArray, points: int) -> tuple[FloatArray, FloatArray]:
    """Gauss-Legendre nodes and weights on each interval between edges, flattened."""
    node, weight = _gauss_legendre(points)
    width = np.diff(edges)
    return (edges[:-1, None] + width[:, None] * node).ravel(), (width[:, None] * weight).ravel()


def _table(table: SpeedTable) -> LogMeasure:
    """Linear pieces: Gauss points in ln v, pieces no wider than 1/4 in ln v."""
    v = np.asarray(table.speed, dtype=float)
    f = np.asarray(table.density, dtype=float)
    lowest = max(v[0], 1e-9 * v[-1])
    knots = np.log(np.maximum(v, lowest))
    parts = [
        np.linspace(a, b, max(2, math.ceil(4.0 * (b - a)) + 1))[:-1]
        for a, b in itertools.pairwise(knots)
        if b > a
    ]
    edges = np.concatenate([*parts, knots[-1:]])
    x, w = _panels(edges, 6)
    weight = w * np.exp(x) * np.interp(np.exp(x), v, f)
    keep = weight > 0.0
    return LogMeasure(x[keep], weight[keep] / weight.sum())


def _samples(speed: FloatArray) -> LogMeasure:
    """Spread the samples over a fine grid by local interpolation (12 points, spacing 1/16).

    Averages of functions that are smooth in ln v, as the solver's are, stay the same to 1e-13.
    """
    x = np.log(speed)
    if x.size <= 400:
        unique, count = np.unique(x, return_counts=True)
        return LogMeasure(unique, count / x.size)
    spacing, width = 1.0 / 16.0, 12
    start = spacing * (math.floor(float(x.min()) / spacing) - width)
    cells = math.ceil((float(x.max()) - start) / spacing) + width
    weight = np.zeros(cells + 1)
    nodes = np.arange(width, dtype=float)
    barycentric = np.array([(-1.0) ** k * math.comb(width - 1, k) for k in range(width)])
    for chunk in np.array_split(x, max(1, x.size // 100_000)):
        level = (chunk - start) / spacing
        first = np.floor(level).astype(int) - width // 2 + 1
        distance = (level - first)[:, None] - nodes
        exact = distance == 0.0
        rows = barycentric / np.where(exact, 1.0, distance)
        rows /= rows.sum(axis=1, keepdims=True)
        hit = exact.any(axis=1)
        rows[hit] = exact[hit]
        np.add.at(weight, first[:, None] + np.arange(width), rows)
    keep = weight != 0.0
    return LogMeasure((start + spacing * np.arange(cells + 1))[keep], weight[keep] / x.size)


def _function(density: Callable[[Any], Any], rtol: float) -> LogMeasure:
    """A speed density given as a function: adaptive Gauss panels in ln v."""

    def per_log_speed(x: FloatArray) -> FloatArray:
        v = np.exp(x)
        try:
            f = np.asarray(density(v), dtype=float)
        except (TypeError, ValueError) as error:
            raise InputError(
                f"initial: the speed density could not be evaluated on an array ({error}); "
                "it must map an array of speeds to an array"
            ) from None
        if f.shape != v.shape or np.any(np.isnan(f)):
            raise InputError(
                f"initial: the speed density returned shape {f.shape} or NaN for speeds of shape "
                f"{v.shape}; it must map an array of speeds to finite densities"
            )
        if np.any(f < 0.0):
            raise InputError(
                f"initial: the speed density is {f.min():.3g} somewhere; it must not be negative"
            )
        return np.asarray(f * v)

    edges = np.arange(-360.0, 360.5, 0.5)
    x, w = _panels(edges, 8)
    with np.errstate(all="ignore"):
        mass = (per_log_speed(x) * w).reshape(-1, 8).sum(axis=1)
        energy = mass * np.exp(2.0 * np.minimum(edges[1:], 350.0))
    if not np.all(np.isfinite(mass)) or mass.sum() <= 0.0:
        raise InputError("initial: the speed density has no finite integral; it must be 1")
    small = 1e-3 * rtol
    live = (mass > small * mass.sum()) | (energy > small * energy.sum())
    first, last = np.nonzero(live)[0][[0, -1]]
    if last == mass.size - 1 or energy[last] > 0.01 * energy.sum():
        raise InputError("initial: the speed density has no second moment; <v^2> must be finite")
    points: list[FloatArray] = []
    weights: list[FloatArray] = []
    pieces = [(edges[i], edges[i + 1]) for i in range(max(first - 2, 0), last + 2)]
    total = float(mass.sum())
    depth = 0
    while pieces and depth < 40:
        ends = np.array(pieces)
        again = []
        coarse_x, coarse_w = _panels_of(ends, 12)
        middle = ends.mean(axis=1)
        halves = np.concatenate(
            [np.stack([ends[:, 0], middle], 1), np.stack([middle, ends[:, 1]], 1)]
        )
        fine_x, fine_w = _panels_of(halves, 12)
        coarse = (per_log_speed(coarse_x.ravel()).reshape(coarse_x.shape) * coarse_w).sum(axis=1)
        fine_f = per_log_speed(fine_x.ravel()).reshape(fine_x.shape) * fine_w
        fine = fine_f.sum(axis=1)
        n = len(pieces)
        for i in range(n):
            if abs(fine[i] + fine[n + i] - coarse[i]) <= 0.1 * rtol * total:
                points += [fine_x[i], fine_x[n + i]]
                weights += [fine_f[i], fine_f[n + i]]
            else:
                again += [tuple(halves[i]), tuple(halves[n + i])]
        pieces = again
        depth += 1
    x, weight = np.concatenate(points), np.concatenate(weights)
    norm = float(weight.sum())
    if not abs(norm - 1.0) < 1e-6:
        raise InputError(f"initial: the integral of the speed density is {norm:.6g}; it must be 1")
    keep = weight > 0.0
    return LogMeasure(x[keep], weight[keep] / norm)


def _panels_of(ends: FloatArray, points: int) -> tuple[FloatArray, FloatArray]:
    """Gauss-Legendre nodes and weights on intervals (n, 2): two arrays (n, points)."""
    node, weight = _gauss_legendre(points)
    width = (ends[:, 1] - ends[:, 0])[:, None]
    return ends[:, :1] + width * node, width * weight
