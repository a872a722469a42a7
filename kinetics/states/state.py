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
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.errors import InputError
from kinetics.numerics import LARGEST_LOG, ROUNDING, FloatArray
from kinetics.numerics.chebyshev import barycentric_weights, interpolation_rows
from kinetics.numerics.gauss import gauss_legendre, panels_between, panels_of
from kinetics.results.result import Storable
from kinetics.results.value import Value

# Interpolation by 12 points of spacing h leaves (1 3 5 7 9 11/2^6)^2 h^12/12! times the twelfth
# derivative of a function, which is p^12 v^p for a power: the widest spacing leaves 2e-19 p^12.
_SAMPLE_SPACING, _SAMPLE_WIDTH = 1.0 / 16.0, 12
_LEFT_OUT = (10395.0 / 64.0) ** 2 / math.factorial(12)
_NOBODY = 1e30  # U: no tracer is as fast, none that moves as slow as the reciprocal

#: Width in ln v of the panels on which a function of the speed is scanned. Origin not recorded.
SCAN_PANEL = 0.5
#: Equal parts of such a panel that are integrated one by one; a power of two, as panels are halved.
SCAN_PARTS = 8
#: Up to which |ln(v/U)|, how many Gauss points a part gets. Chosen: near U, where densities are,
#: peaks 0.1 % wide are seen; beyond e^70 only power laws matter. Fewer points than 8 everywhere.
SCAN_ZONES = ((16.0, 64), (70.0, 8), (math.inf, 2))
#: Gauss points of a panel, or of a half of one. Origin not recorded.
POINTS = 12
#: Half the width in ln v of the narrowest panel: a thousand roundings of ln v of order 1.
NARROWEST = 1e3 * ROUNDING
#: Panels halved at once beyond which a density counts as noise. Origin not recorded.
MOST_PANELS = 5000
#: Error over the difference of 12 and 24 points where panels cannot be halved. Derived for an
#: inverse square root at the end of a panel: 1/(sqrt(2) - 1) = 2.4, and 4 with a margin.
UNRESOLVED_SAFETY = 4.0

#: Roundings of the speed that a panel may be off. Chosen; an inverse square root at the end of a
#: panel then is rounding where the panel is some thousand roundings wide.
VARIATION_SAFETY = 10.0
#: Roundings of its mass that a panel may be off. Chosen: sums of 24 and of 512 points.
MASS_SAFETY = 100.0

NO_INTEGRAL = (
    "initial: the density has no finite integral over the speed, or a peak too narrow to find; "
    "it must be 1, and narrow peaks need a SpeedTable"
)
SpeedFunction = Callable[[FloatArray], NDArray[Any]]  # speeds in U, (n,), to values, (n,)


@dataclass(frozen=True, eq=False, repr=False)
class LogMeasure(Value):
    """A distribution of speeds: weight w_k at ln(v/U) = x_k, shape (n_points,) each.

    The weights are real and sum to 1 for a speed distribution; complex for a harmonic of one.

    error : estimated relative error of averages over it, of a density that quadrature does not
        resolve to the tolerance requested; 0 where it does
    """

    x: FloatArray
    weight: NDArray[Any]
    error: float = 0.0

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
    """Quadrature points of a speed density, or a harmonic of one, that a function gives.

    Averages of v^p are right to about rtol for p from ``lowest`` to ``highest``, and for p = 0 and
    2: panels in ln v reach as far as these powers notice, and are halved until each of the powers
    is resolved. What cannot be resolved is in the ``error`` of the result.

    Returns
    -------
    The points; None for a function that is zero.

    Raises
    ------
    InputError
        where the function is NaN, has no finite integral or no second moment.
    """

    def per_log_speed(x: FloatArray) -> NDArray[Any]:
        v = np.exp(x)
        return np.asarray(evaluate(density, v) * v)

    scan = _Scan.of(per_log_speed)
    if not scan.mass.any():
        return None
    powers = sorted({2.0, max(highest, 2.0), 0.0, min(lowest, 0.0)}, reverse=True)
    log_averages = scan.log_averages(powers)
    if scan.has_power_law_tail:
        scan.refuse_divergent(powers, log_averages)
    live = scan.panels_that_count(powers, log_averages, rtol)

    def importance(x: FloatArray) -> FloatArray:
        """Largest relative change of the averages, for a change of the mass at ln v = x."""
        exponents = [
            p * x - log_average for p, log_average in zip(powers, log_averages, strict=True)
        ]
        return np.asarray(np.exp(np.minimum(np.max(exponents, axis=0), LARGEST_LOG)))

    ends = np.stack([scan.edges[:-1], scan.edges[1:]], axis=1)[live]
    tolerance = 0.1 * max(rtol, 1e-15)  # below that is rounding
    x, weight, error = refined(per_log_speed, ends, scan.parts[live], importance, tolerance)
    points = _without_zeros(x, weight)
    return LogMeasure(points.x, points.weight, error)


@dataclass(frozen=True)
class _Scan:
    """A function of ln v, integrated over panels from the slowest to the fastest speed in doubles.

    edges : of the panels in ln v, (n_panels + 1,)
    mass : integral of the absolute value over each panel, (n_panels,)
    parts : integral over each of the SCAN_PARTS equal parts of each panel, (n_panels, SCAN_PARTS);
        NaN where the scan is too coarse to know it
    """

    edges: FloatArray
    mass: FloatArray
    parts: NDArray[Any]

    @classmethod
    def of(cls, function: Callable[[FloatArray], NDArray[Any]]) -> _Scan:
        """Scan a function of ln v; InputError where its integral is not finite."""
        # from the least number of which the square is in the range of doubles to the largest
        edges = SCAN_PANEL * np.arange(-LARGEST_LOG // 1.0, 2.0 * LARGEST_LOG // 1.0)
        distance = np.minimum(abs(edges[:-1]), abs(edges[1:]))
        mass = np.zeros(distance.size)
        parts: NDArray[Any] = np.full((distance.size, SCAN_PARTS), np.nan)
        nearest = 0.0
        for farthest, count in SCAN_ZONES:
            zone = np.nonzero((distance >= nearest) & (distance < farthest))[0]
            offsets = np.linspace(0.0, SCAN_PANEL, SCAN_PARTS + 1)
            starts = edges[zone, None] + offsets[:-1]
            ends = np.stack([starts, edges[zone, None] + offsets[1:]], axis=2).reshape(-1, 2)
            x, w = panels_of(ends, count)
            values = function(x.ravel()).reshape(x.shape)
            with np.errstate(all="ignore"):
                mass[zone] = (np.abs(values) * w).reshape(zone.size, -1).sum(axis=1)
                if nearest == 0.0:
                    integrals = (values * w).sum(axis=1).reshape(-1, SCAN_PARTS)
                    parts = parts.astype(integrals.dtype)
                    parts[zone] = integrals
            nearest = farthest
        if not np.all(np.isfinite(mass)):
            raise InputError(NO_INTEGRAL)
        return cls(edges, mass, parts)

    @property
    def has_power_law_tail(self) -> bool:
        """Whether the function goes on until numbers end, 60 e-folds above its bulk."""
        last = int(np.nonzero(self.mass)[0][-1])
        return bool(self.edges[last] - self.edges[int(self.mass.argmax())] > 60.0)

    def _log_terms(self, power: float) -> FloatArray:
        """ln of what each panel adds to the average of v^power, (n_panels,)."""
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(self.mass) + power * 0.5 * (self.edges[1:] + self.edges[:-1]))

    def _shares(self, power: float, log_average: float) -> FloatArray:
        """What each panel adds to the average of v^power, relative to it, (n_panels,)."""
        return np.asarray(np.exp(np.maximum(self._log_terms(power) - log_average, -700.0)))

    def log_averages(self, powers: list[float]) -> list[float]:
        """ln of the integral of the absolute value times v^p, for each power p."""
        logs = []
        for power in powers:
            terms = self._log_terms(power)
            largest = float(terms.max())
            logs.append(
                largest + math.log(float(np.exp(np.maximum(terms - largest, -700.0)).sum()))
            )
        return logs

    def refuse_divergent(self, powers: list[float], log_averages: list[float]) -> None:
        """Raise InputError for a power p >= 2 to whose average the last panels add much."""
        last = int(np.nonzero(self.mass)[0][-1])
        for power, log_average in zip(powers, log_averages, strict=True):
            shares = self._shares(power, log_average)
            if power >= 2.0 and shares[last - 2 : last + 1].max() >= 1e-3 * shares.max():
                raise InputError(
                    f"initial: <v^{power:g}> of the density does not exist, and it is needed"
                )

    def panels_that_count(
        self, powers: list[float], log_averages: list[float], rtol: float
    ) -> slice:
        """The panels that any of the averages notices, and two more on each side."""
        live = np.zeros(self.mass.shape, dtype=bool)
        for power, log_average in zip(powers, log_averages, strict=True):
            live |= self._shares(power, log_average) > 1e-3 * rtol  # a thousand add up to rtol
        first, last = np.nonzero(live)[0][[0, -1]]
        # what is left out falls from panel to panel
        return slice(max(first - 2, 0), min(last + 3, self.mass.size))


def refined(
    function: Callable[[FloatArray], NDArray[Any]],
    ends: FloatArray,
    parts: NDArray[Any],
    importance: Callable[[FloatArray], FloatArray],
    tolerance: float,
) -> tuple[FloatArray, NDArray[Any], float]:
    """Integrate a function, that may have steps, kinks and infinities, on panels that are halved.

    A panel is resolved when 12 points on it give the same integral as 12 points on each half, when
    the polynomials through the latter go on to the values at the ends of the halves (else a step
    or a kink may lie between an end and the outermost point), and when the integral is that of the
    scan, which has more points.

    Parameters
    ----------
    ends : of the panels, (n, 2)
    parts : integrals over equal parts of each panel, (n, n_parts), to compare with; NaN: unknown
    importance : what an error of the integral around a point counts
    tolerance : largest error of a panel of width SCAN_PANEL, times its importance; of narrower
        ones in proportion, so that those around a step or an infinity do not add up

    Returns
    -------
    Points, weights times the function there, (n_points,) each, and the error estimate of what is
    not resolved: panels too narrow to be halved, or too many.
    """
    points: list[FloatArray] = []
    weights: list[NDArray[Any]] = []
    unresolved = 0.0
    while ends.size:
        panels = _HalvedPanels.of(function, ends)
        value = np.maximum(importance(ends[:, 0]), importance(ends[:, 1]))
        error = panels.error
        if parts.shape[1]:
            difference = np.abs(panels.integral - parts.sum(axis=1))
            # NaN where the scan does not know it
            error = np.fmax(error, np.where(difference > panels.rounding, difference, 0.0))
        width = ends[:, 1] - ends[:, 0]
        is_resolved = error * value <= tolerance * np.minimum(width / SCAN_PANEL, 1.0)
        is_last = (0.5 * width < NARROWEST) | (error <= panels.rounding)
        is_last |= ends.shape[0] > MOST_PANELS  # a noisy density ends
        missed = np.where(is_last & ~is_resolved, error * value, 0.0)
        unresolved += UNRESOLVED_SAFETY * float(missed.sum())
        is_done = is_resolved | is_last
        points.append(panels.x[is_done].ravel())
        weights.append(panels.weighted[is_done].ravel())
        ends = panels.halves[~is_done].reshape(-1, 2)
        parts = _parts_of_halves(parts[~is_done])
    return np.concatenate(points), np.concatenate(weights), unresolved


def _parts_of_halves(parts: NDArray[Any]) -> NDArray[Any]:
    """Integrals over parts of panels, (n, n_parts), as parts of their halves, (2 n, n_parts/2)."""
    count = parts.shape[1] // 2
    return parts[:, : 2 * count].reshape(2 * parts.shape[0], count)


@dataclass(frozen=True)
class _HalvedPanels:
    """A function on panels, by 12 points on each half.

    halves : ends of the halves, (n, 2, 2)
    x, weighted : points, and weights times the function there, (n, 24)
    integral, error : of each panel, and its estimate, (n,)
    rounding : of the integral, (n,)
    """

    halves: FloatArray
    x: FloatArray
    weighted: NDArray[Any]
    integral: NDArray[Any]
    error: FloatArray
    rounding: FloatArray

    @classmethod
    def of(cls, function: Callable[[FloatArray], NDArray[Any]], ends: FloatArray) -> _HalvedPanels:
        """Evaluate the function on panels ``ends``, (n, 2)."""
        n = ends.shape[0]
        middle = ends.mean(axis=1)
        halves = np.stack([ends[:, 0], middle, middle, ends[:, 1]], axis=1).reshape(n, 2, 2)
        coarse_x, coarse_w = panels_of(ends, POINTS)
        fine_x, fine_w = panels_of(halves.reshape(-1, 2), POINTS)
        # from inside: a step at the end of a half is no concern of it
        inside = halves + 0.5 * NARROWEST * np.array([1.0, -1.0])
        x = [coarse_x, fine_x.reshape(n, 2 * POINTS), inside.reshape(n, 4)]
        values = function(np.concatenate(x, axis=1).ravel()).reshape(n, -1)
        coarse, fine, at_ends = np.split(values, [POINTS, 3 * POINTS], axis=1)
        weighted = fine * fine_w.reshape(n, 2 * POINTS)
        integral = weighted.sum(axis=1)
        expected = (fine.reshape(2 * n, POINTS) @ _to_the_ends().T).reshape(n, 4)
        gap = float(gauss_legendre(POINTS)[0][0]) * (middle - ends[:, 0])
        beyond = np.abs(at_ends - expected).max(axis=1) * gap
        error = np.maximum(np.abs(integral - (coarse * coarse_w).sum(axis=1)), beyond)
        # the speeds are rounded as well: of a steep function by this share of how much it varies
        variation = np.abs(fine - fine.mean(axis=1, keepdims=True)).max(axis=1)
        mass = np.abs(weighted).sum(axis=1)
        rounding = ROUNDING * (VARIATION_SAFETY * variation + MASS_SAFETY * mass)
        return cls(halves, x[1], weighted, integral, error, rounding)


@lru_cache(maxsize=1)
def _to_the_ends() -> FloatArray:
    """Values at the ends 0 and 1 from those at the Gauss points of [0, 1], (2, POINTS)."""
    nodes = gauss_legendre(POINTS)[0]
    distances = np.array([0.0, 1.0])[:, None] - nodes
    return interpolation_rows(distances, barycentric_weights(nodes))


def _without_zeros(x: NDArray[Any], weight: NDArray[Any]) -> LogMeasure:
    keep = weight != 0.0
    return LogMeasure(x[keep], weight[keep])
