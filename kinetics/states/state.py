"""The contract of an initial state: what a new one must provide.

Write a ``@dataclass(frozen=True, eq=False)`` class whose fields are what the user gives;
``Scene(initial=...)`` takes any object of a subclass of :class:`State`. In ``__post_init__`` check
the arguments, and store arrays with ``self.store(name=array)``, which keeps read-only copies.
Speeds are in U, densities in 1/U. Write ``harmonic`` (below are rules for Gaussians, tables,
functions and samples), ``profile`` if f_m is a function of v, which densities need, and
``in_space()`` if the state may start a scene in space and is not isotropic; set the attributes of
State where their defaults do not fit. ``tests/kinetics/states/test_contract.py`` tests all this.
The shortest example is :class:`kinetics.states.kinds.Rest`.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.errors import InputError
from kinetics.numerics import LARGEST_LOG, ROUNDING, FloatArray
from kinetics.numerics.chebyshev import interpolation_rows
from kinetics.numerics.gauss import panels_between, panels_of
from kinetics.results.result import Storable
from kinetics.results.value import Value

# Interpolation by 12 points of spacing h leaves (1 3 5 7 9 11/2^6)^2 h^12/12! times the twelfth
# derivative of a function, which is p^12 v^p for a power: the widest spacing leaves 2e-19 p^12.
_SAMPLE_SPACING, _SAMPLE_WIDTH = 1.0 / 16.0, 12
_LEFT_OUT = (10395.0 / 64.0) ** 2 / math.factorial(12)
_NOBODY = 1e30  # U: no tracer is as fast, none that moves as slow as the reciprocal

NO_INTEGRAL = (
    "initial: the density has no finite integral over the speed, or a peak too narrow to find; "
    "it must be 1, and narrow peaks need a SpeedTable"
)
SpeedFunction = Callable[[FloatArray], NDArray[Any]]  # speeds in U, (n,), to values, (n,)


@dataclass(frozen=True, eq=False, repr=False)
class LogMeasure(Value):
    """A distribution of speeds: weight w_k at ln(v/U) = x_k, shape (n_points,) each.

    The weights are real and sum to 1 for a speed distribution; complex for a harmonic of one.
    """

    x: FloatArray
    weight: NDArray[Any]

    def log_second_moment(self) -> float:
        """ln <v^2>, for speeds of any scale."""
        top = float(self.x.max())
        return 2.0 * top + math.log(float(self.weight.real @ np.exp(2.0 * (self.x - top))))


Points = LogMeasure | None  # of a harmonic; None where it is zero


class State(Storable):
    """An initial state; see the module's docstring for what a subclass must provide.

    Attributes
    ----------
    highest_harmonic : largest m for which f_m is not zero, 0 for an isotropic state; None where
        all m may be there
    smooth : whether f_m are smooth functions of ln v, so that the spectral method can be used
    lowest_moment : <v^p> exists for p above it
    peaks : speeds of delta peaks and shares of tracers in them, (n,) each; None for densities
    kinks : speeds at which the density is not smooth, rising, shape (n,)
    """

    highest_harmonic: int | None = 0
    smooth: bool = False
    lowest_moment: float = -math.inf
    peaks: tuple[FloatArray, FloatArray] | None = None
    kinks: FloatArray = np.empty(0)

    def in_space(self) -> State | None:
        """The state as it starts a three-dimensional scene; None if it has no such form.

        There harmonic m is the integral of P_m(cos theta) f over all directions, theta the angle to
        the x axis. Isotropic states that are given by their speeds are the same in space.
        """
        return self if self.highest_harmonic == 0 else None

    def harmonic(self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0) -> Points:
        """f_m(v), the integral of exp(-i m phi) v f(v, phi) over phi, as weighted points; or None.

        The sum of the weights times v^p exp(smooth function of ln v) is right to about rtol for all
        powers p from ``lowest`` to ``highest``. f_0 is the speed density: its weights sum to 1.
        """
        raise NotImplementedError

    def profile(self, m: int) -> SpeedFunction | None:
        """f_m in 1/U as a function of v/U; None where it is no function (delta peaks, samples)."""
        return None


# -- rules: distributions of speeds as weighted points in ln v -------------------------------------
#
# The solver only needs averages of smooth functions of ln v over the initial state: one point for a
# monoenergetic start, the trapezoid rule for a Gaussian, panels of Gauss-Legendre points for a
# density, and for samples a fine grid that gives every smooth average that the samples give.


def gaussian_points(
    rtol: float, lowest: float, highest: float, dimension: int, deviation: float, ratio: float = 1.0
) -> LogMeasure:
    """Speed density v^(d-1) exp(-v^2/2 D^2), D the deviation, by the trapezoid rule in ln v.

    Spacing h leaves exp(-pi^2/(2 h)), times a power of k for the powers of v, for which 8 + 1.5
    highest e-folds are added. The left end is where v^(d + lowest), or v^2, is below rtol/e^2, the
    right one where exp(-v^2/2) is as small. The density may be multiplied by a function of v/D
    that is at most ``ratio``, and at most D/v.
    """
    depth = math.log(1.0 / rtol) + 2.0
    more = depth + 6.0 + 1.5 * (highest + dimension - 2)
    power = min(2.0, dimension + lowest)
    left = -(depth + math.log(ratio)) / power
    if power > 1.0:
        left = max(left, -depth / (power - 1.0))
    spacing = 0.5 * math.pi**2 / more
    x = np.arange(left, 0.5 * math.log(2.0 * more) + spacing, spacing)
    weight = np.exp(dimension * x - 0.5 * np.exp(2.0 * x))
    return LogMeasure(x + math.log(deviation), weight / weight.sum())


def table_points(
    speed: FloatArray, density: NDArray[Any], rtol: float = 1e-16, lowest: float = 0.0
) -> LogMeasure:
    """A density, real or complex, linear between the points; pieces no wider than 1/4 in ln v.

    One that begins at speed 0 goes down to where what is left is rtol of <v^lowest>.
    """
    knots = np.log(np.maximum(speed, 1e-320))
    if speed[0] == 0.0:
        converges = (1.0 if density[0] else 2.0) + min(lowest, 0.0)
        knots[0] = knots[1] - (math.log(1.0 / rtol) + 2.0) / converges
        if knots[0] < -700.0:  # the smallest number is e^-708
            raise InputError(f"p: got {lowest:g}; <v^p> of this table is too near to divergence")
    parts = [
        np.linspace(a, b, max(2, math.ceil(4.0 * (b - a)) + 1))[:-1]
        for a, b in itertools.pairwise(knots)
        if b > a
    ]
    x, w = panels_between(np.concatenate([*parts, knots[-1:]]), 6)
    v = np.exp(x)
    return _without_zeros(x, w * v * np.interp(v, speed, density))


def samples_points(x: FloatArray, weight: NDArray[Any], rtol: float, power: float) -> LogMeasure:
    """Points x of the given weights, (n,) each, many of them gathered on a fine grid.

    Averages of v^power, and of functions of ln v that are no steeper, stay the same to a tenth of
    rtol.
    """
    width = _SAMPLE_WIDTH
    fine = (0.1 * rtol / _LEFT_OUT) ** (1.0 / width) / max(abs(power), 1.0)
    spacing = min(_SAMPLE_SPACING, fine)
    start = spacing * (math.floor(float(x.min()) / spacing) - width)
    cells = math.ceil((float(x.max()) - start) / spacing) + width
    # few are kept as they are: the grid of more has about 400 points
    if x.size <= max(400, cells if fine < _SAMPLE_SPACING else 0):
        return LogMeasure(x, weight)
    total = np.zeros(cells + 1, dtype=weight.dtype)
    nodes = np.arange(width, dtype=float)
    barycentric = np.array([(-1.0) ** k * math.comb(width - 1, k) for k in range(width)])
    pieces = max(1, x.size // 100_000)
    for chunk, part in zip(np.array_split(x, pieces), np.array_split(weight, pieces), strict=True):
        level = (chunk - start) / spacing
        first = np.floor(level).astype(int) - width // 2 + 1
        rows = interpolation_rows((level - first)[:, None] - nodes, barycentric)
        np.add.at(total, first[:, None] + np.arange(width), rows * part[:, None])
    return _without_zeros(start + spacing * np.arange(cells + 1), total)


def evaluate(density: Callable[[Any], Any], v: FloatArray) -> NDArray[Any]:
    """Call a user's density on an array of speeds; InputError where the answer cannot be used.

    NaN counts as 0 beyond _NOBODY and below its reciprocal, where powers of v overflow.
    """
    try:
        with np.errstate(all="ignore"):
            f = np.asarray(density(v))
        f = f.astype(complex if f.dtype.kind == "c" else float)
        if f.shape != v.shape:
            raise ValueError(f"it returned shape {f.shape} for speeds of shape {v.shape}")
    except (TypeError, ValueError) as error:
        what = "it must map an array of speeds to one of densities"
        raise InputError(f"initial: the density could not be evaluated ({error}); {what}") from None
    f = np.where(np.isnan(f) & ((v > _NOBODY) | (v < 1.0 / _NOBODY)), 0.0, f)
    if np.any(np.isnan(f)):
        where = f"{v[np.isnan(f)][0]:g}"
        raise InputError(f"initial: the density is NaN at v = {where} U; it must be a number")
    return f


def function_points(
    density: Callable[[Any], Any], rtol: float, lowest: float, highest: float
) -> LogMeasure | None:
    """A speed density, or a harmonic of one, given as a function: adaptive panels in ln v.

    They reach as far as powers of the speed from ``lowest`` to ``highest`` notice. None for one
    that is zero. Raises InputError where it is NaN, has no finite integral or no second moment.
    """

    def per_log_speed(x: FloatArray) -> NDArray[Any]:
        v = np.exp(x)
        return np.asarray(evaluate(density, v) * v)

    # scanned from the least number of which the square is in the range of doubles to the largest
    width, count = 0.5, 64  # of a panel in ln v, and of its Gauss points
    edges = width * np.arange(-LARGEST_LOG // 1.0, 2.0 * LARGEST_LOG // 1.0)
    x, w = panels_between(edges, count)
    with np.errstate(all="ignore"):
        mass = (np.abs(per_log_speed(x)) * w).reshape(-1, count).sum(axis=1)
    if not np.all(np.isfinite(mass)):
        raise InputError(NO_INTEGRAL)
    if not mass.any():
        return None
    last = int(np.nonzero(mass)[0][-1])
    # a power law goes on until numbers end, 60 e-folds above the bulk; a Gaussian does not
    far = edges[last] - edges[int(mass.argmax())] > 60.0
    live = np.zeros(mass.shape, dtype=bool)
    for p in (2.0, max(highest, 2.0), 0.0, min(lowest, 0.0)):
        with np.errstate(divide="ignore"):
            log_share = np.log(mass) + p * 0.5 * (edges[1:] + edges[:-1])
        share = np.exp(np.maximum(log_share - log_share.max(), -700.0))
        if p >= 2.0 and far and share[last - 2 : last + 1].max() >= 1e-3:
            raise InputError(f"initial: <v^{p:g}> of the density does not exist, and it is needed")
        live |= share > 1e-3 * rtol * share.sum()  # a thousand such panels add up to rtol
    first, last = np.nonzero(live)[0][[0, -1]]
    # two more panels on both sides, because what is left out falls from panel to panel
    first, last = max(first - 2, 0), min(last + 2, mass.size - 1)
    span = edges[first : last + 2]
    tolerance = 0.1 * max(rtol, 1e-15) * float(mass.sum())  # below that is rounding
    return _without_zeros(*refined(per_log_speed, np.stack([span[:-1], span[1:]], 1), tolerance))


def refined(
    function: Callable[[FloatArray], NDArray[Any]], ends: FloatArray, tolerance: float
) -> tuple[FloatArray, NDArray[Any]]:
    """Points, and weights times the function there, (n_points,) each, on intervals (n, 2).

    They are halved until 12 points and twice 12 points give the same integral, or a half is
    rounding.
    """
    points: list[FloatArray] = []
    weights: list[NDArray[Any]] = []
    while ends.size:
        middle = ends.mean(axis=1)
        halves = np.stack([ends[:, 0], middle, middle, ends[:, 1]], axis=1).reshape(-1, 2)
        coarse_x, coarse_w = panels_of(ends, 12)
        fine_x, fine_w = panels_of(halves, 12)
        coarse = (function(coarse_x.ravel()).reshape(coarse_x.shape) * coarse_w).sum(axis=1)
        fine = function(fine_x.ravel()).reshape(fine_x.shape) * fine_w
        good = np.abs(fine.sum(axis=1).reshape(-1, 2).sum(axis=1) - coarse) <= tolerance
        good |= middle - ends[:, 0] < 1e3 * ROUNDING
        good |= ends.shape[0] > 5000  # a noisy density ends
        both = np.repeat(good, 2)
        points.append(fine_x[both].ravel())
        weights.append(fine[both].ravel())
        ends = halves[~both]
    return np.concatenate(points), np.concatenate(weights)


def _without_zeros(x: NDArray[Any], weight: NDArray[Any]) -> LogMeasure:
    keep = weight != 0.0
    return LogMeasure(x[keep], weight[keep])
