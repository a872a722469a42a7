"""The fit of a point of the theory to a sample: begin with `fit`.

Parameters are fitted to second moments x_k alone (v^2 and r^2 at a few times, or |r(t) - r(s)|^2
of a few pairs of frames): fourth moments hang on a few fast tracers. With mu_k their theory and
D = d ln mu/d theta, the estimate solves

    D^T W g = 0,     g_k = <x_k>/mu_k - 1,

which is unbiased if W does not come from the tracers that it weighs. It is the inverse of the
covariance of g among simulated tracers (`pool`) at a first estimate. To first order theta moves by
A g, A = (D^T W D)^-1 D^T W, and the covariance of theta is that of A g over the groups of the data:
no covariance of the data is inverted.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.compare.measured import Layout, Measured
from kinetics.crosscheck.compare.observables import BETWEEN_FRAMES, Array
from kinetics.crosscheck.compare.parameters import (
    FreeParameter,
    coordinates_of,
    derivatives,
    is_at_foreign_limit,
    limits_of,
    point_at,
)
from kinetics.crosscheck.compare.point import Point
from kinetics.crosscheck.compare.pool import (
    N_FOR_TEST,
    N_FOR_WEIGHTS,
    Pool,
    can_simulate,
)
from kinetics.crosscheck.compare.residuals import Influence, Residuals, covariance_with_gaps
from kinetics.crosscheck.compare.selection import tested_components
from kinetics.crosscheck.compare.statistics import (
    ChiSquare,
    influence_covariance,
    jackknife_covariance,
    whitening,
    with_infinite_variances,
    without_information,
)
from kinetics.crosscheck.compare.theory import Theory

Indices = NDArray[np.int64]

#: The averages over time that are second moments, or roots of them.
SECOND_MOMENTS = ("thermal_speed", "msd")
#: Rounds of pool and fit: the second pool is at an estimate that has the weights of the first.
N_ROUNDS = 2
#: Newton steps at most. From a first estimate three or four are usual.
MAX_NEWTON_STEPS = 20
#: Largest change of a coordinate in one step. Chosen: far less than the range of each.
MAX_CHANGE = 0.3
#: Change of a coordinate that ends the steps: far below any error.
CONVERGED_BELOW = 1e-6
#: Starts from which the first estimate is refined: the best ones of all that are tried.
N_REFINED_STARTS = 2


@dataclass(frozen=True, eq=False)
class Fit:
    """A sample beside its theory at a point, with some fitted parameters, perhaps none.

    Parameters
    ----------
    measured : the data, at the times that the fit looks at
    theory : of their components
    point : with the fitted numbers
    free : what was fitted
    covariance : of the numbers themselves, or of their logarithms where these are fitted
    slopes : of the theory in these, shape (n_components, n_free)
    gain : change of the fitted numbers for a relative change of the second moments, (n_free, p)
    indices : the components that the parameters are fitted to, shape (p,)
    residuals : data less theory, at the point
    """

    measured: Measured
    theory: Theory
    point: Point
    free: tuple[FreeParameter, ...]
    covariance: Array
    slopes: Array
    gain: Array
    indices: Indices
    residuals: Residuals

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the fitted numbers."""
        return tuple(parameter.name for parameter in self.free)

    @property
    def coordinates(self) -> Array:
        """The fitted numbers, or their logarithms, without the scales of `FreeParameter`."""
        return coordinates_of(self.point, self.free) * _scales(self.free)

    @cached_property
    def chi_square(self) -> ChiSquare | None:
        """The one test of all averages together."""
        return self.residuals.test(tested_components(self.measured))

    @property
    def criterion(self) -> float:
        """By how much the data are unlikely: T^2, and 2 for each fitted number (Akaike).

        The likelihood of a Gaussian with the covariance C has ln det C beside T^2, which is left
        out: relative to the averages C is nearly the same in all media but for the error of the
        theory of dense ones, which T^2 alone lets off. At n = 0.04 ln det C of hard disks was
        above that of dilute scatterers by 0.0 for 2,000 tracers and by 3.5 for 20,000, where T^2
        differed by 18 and by 200.
        """
        if self.chi_square is None:
            return np.inf
        return self.chi_square.statistic + 2.0 * len(self.free)

    @property
    def clock(self) -> float:
        """The times in d/U over those of the sample, where U was fitted; else 1.

        Until U is known, the times of positions alone are in the d/U of a U that is 1 in the data.
        """
        if "speed_unit" not in self.names:
            return 1.0
        return self.point.clock

    def value(self, name: str) -> tuple[float, float]:
        """Return a fitted number and its standard error."""
        index = self.names.index(name)
        value = float(getattr(self.point, name))
        error = float(np.sqrt(self.covariance[index, index]))
        return value, value * error if self.free[index].is_logarithm else error

    def residuals_of(self, measured: Measured, theory: Theory) -> Residuals:
        """Return the residuals of the same sample at all its times.

        They are those of the fit where it looks at all of them. The pool has the components of the
        fit among its own, so that both move together.
        """
        if measured.layout.is_same_as(self.measured.layout):
            return self.residuals
        pool = pool_at(measured, self.point, N_FOR_TEST)
        influence = None
        if self.free:
            indices = _same_components(self.measured, measured, self.indices)
            slopes = _slopes_of(theory, self.point, self.free)
            of_theory = theory.values(self.point)
            influence = _influence(measured, indices, slopes, self.gain, of_theory)
        return Residuals.at(measured, theory, self.point, pool, influence)


def pool_at(measured: Measured, point: Point, n_tracers: int) -> Pool | None:
    """Return tracers simulated at a point; None where there can be none."""
    layout = measured.layout
    if not can_simulate(point, layout.law, float(layout.times[-1])):
        return None
    return Pool(layout, point, measured.has_velocities, n_tracers)


def compare_with_point(
    measured: Measured, point: Point, n_pool: int = N_FOR_TEST, theory: Theory | None = None
) -> Fit:
    """Return the sample beside the theory of a point without fitted numbers.

    Parameters
    ----------
    measured : the data
    point : that they are compared with
    n_pool : tracers of the pool for the test
    theory : of the components of the data, which has solutions already; None: a new one
    """
    if theory is None:
        theory = Theory(measured.layout, measured.has_velocities)
    residuals = Residuals.at(measured, theory, point, pool_at(measured, point, n_pool))
    nothing = np.empty((0, 0))
    slopes = np.empty((measured.layout.size, 0))
    no_indices = np.empty(0, np.int64)
    return Fit(measured, theory, point, (), nothing, slopes, nothing, no_indices, residuals)


def fit(
    measured: Measured,
    point: Point,
    free: Sequence[FreeParameter],
    starts: Sequence[Sequence[float]],
    n_rounds: int = N_ROUNDS,
    n_pool: int = N_FOR_TEST,
) -> Fit | None:
    """Fit some numbers of a point to data.

    Parameters
    ----------
    measured : the data, at the times that the fit looks at
    point : has the numbers that are not fitted, and the medium
    free : what is fitted, one number at least
    starts : coordinates to begin from, shape (n_starts, n_free)
    n_rounds : of pool and fit
    n_pool : tracers of the pool for the test

    Returns
    -------
    Fit; None where there are fewer averages than numbers, no theory at any start, or where a
        number runs into a limit that is none of its own (`FreeParameter.is_at_limit`). Where no
        tracers can be simulated, all logarithms weigh alike.
    """
    estimation = _Estimation.of(measured, point, tuple(free))
    if estimation is None:
        return None
    with suppress(ValueError, np.linalg.LinAlgError):  # no theory there, or it is not finite
        at = estimation.first_estimate(starts)
        if at is None:
            return None
        weights = np.eye(estimation.indices.size)
        for _ in range(n_rounds):
            pool = pool_at(estimation.measured, estimation.point(at), N_FOR_WEIGHTS)
            if pool is None:
                break
            weights = estimation.weights(pool)
            at = estimation.solve(at, weights)
        if is_at_foreign_limit(free, at):
            return None
        return estimation.result(at, weights, measured, n_pool)
    return None


def first_estimate(
    measured: Measured,
    point: Point,
    free: Sequence[FreeParameter],
    starts: Sequence[Sequence[float]],
) -> Array | None:
    """Return the coordinates of the least squares of all logarithms alike; None if it fails."""
    estimation = _Estimation.of(measured, point, tuple(free))
    if estimation is None:
        return None
    with suppress(ValueError, np.linalg.LinAlgError):
        return estimation.first_estimate(starts)
    return None


@dataclass(frozen=True, eq=False)
class _Estimation:
    """The second moments that are fitted, and their theory as a function of the coordinates.

    Parameters
    ----------
    measured : the averages that are second moments, alone: others take the solver longer
    theory : of these
    specified : the numbers that are not fitted
    free : what is fitted
    indices : the components, shape (p,)
    powers : a second moment is the component to this power, 2 for the thermal speed
    moments : the second moments of the data, shape (p,)
    """

    measured: Measured
    theory: Theory
    specified: Point
    free: tuple[FreeParameter, ...]
    indices: Indices
    powers: Array
    moments: Array

    @classmethod
    def of(
        cls, whole: Measured, specified: Point, free: tuple[FreeParameter, ...]
    ) -> _Estimation | None:
        """Choose the components; None where they are fewer than the parameters."""
        pairs = whole.layout.pairs
        names: list[str] = []  # of positions alone, pairs of frames
        if pairs is None:
            names = [name for name in whole.layout.names if name in SECOND_MOMENTS]
        layout = Layout(
            tuple(names), whole.layout.times, whole.layout.law, pairs, whole.layout.presence
        )
        measured = Measured(whole.sample, layout)
        theory = Theory(measured.layout, whole.has_velocities)
        indices = fitted_components(measured)
        if indices.size < len(free):
            return None
        powers = _powers(measured, indices)
        moments = measured.values[indices] ** powers
        return cls(measured, theory, specified, free, indices, powers, moments)

    @property
    def low(self) -> Array:
        return limits_of(self.free)[0]

    @property
    def high(self) -> Array:
        return limits_of(self.free)[1]

    def point(self, at: Array) -> Point:
        """Return the point at some coordinates."""
        return point_at(self.specified, self.free, at)

    def log_theory(self, at: Array) -> Array:
        """Return the logarithms of the second moments in theory, shape (p,)."""
        values = self.theory.values(self.point(at))[self.indices]
        return np.asarray(self.powers * np.log(values))

    def slopes(self, at: Array) -> Array:
        """Return the derivatives of the logarithms, shape (p, n_free)."""
        return derivatives(self.log_theory, at, self.free)

    def log_difference(self, at: Array) -> Array:
        """Return the logarithms of data over theory, shape (p,)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.log(self.moments) - self.log_theory(at))

    def first_estimate(self, starts: Sequence[Sequence[float]]) -> Array | None:
        """Return the least squares of all logarithms alike; None where nothing is finite."""
        from scipy.optimize import least_squares

        width = np.minimum(1.0, self.high - self.low)
        inner_low = self.low + 1e-4 * width
        inner_high = self.high - 1e-4 * width
        tried = []
        for start in starts:
            at = np.clip(np.asarray(start, float), inner_low, inner_high)
            cost = np.inf
            with suppress(ValueError):  # there is no theory at this start
                cost = float(np.sum(self.log_difference(at) ** 2))
            if np.isfinite(cost):
                tried.append((cost, at))
        tried.sort(key=lambda pair: pair[0])
        refined = [
            least_squares(
                self.log_difference,
                at,
                lambda x: -self.slopes(x),
                bounds=(self.low, self.high),
                x_scale="jac",
                xtol=1e-5,
                ftol=1e-7,
                max_nfev=50,
            )
            for _, at in tried[: self._n_refined]
        ]
        if not refined:
            return None
        best = min(refined, key=lambda result: float(result.cost))
        return np.asarray(best.x)

    @property
    def _n_refined(self) -> int:
        """How many starts are refined: of pairs of frames, which take the solver long, the best."""
        return N_REFINED_STARTS if self.measured.layout.pairs is None else 1

    def weights(self, pool: Pool) -> Array:
        """Return the inverse of the covariance of the relative second moments of the pool."""
        covariance = influence_covariance(self._relative(pool))
        shares = self.measured.shares_without_gaps_of_pool[self.indices]
        axes = whitening(covariance_with_gaps(covariance, shares))
        return np.asarray(axes.T @ axes)

    def _relative(self, pool: Pool) -> Array:
        """Return what each tracer of a pool adds to each second moment, relative to it."""
        values = pool.values[self.indices]
        return np.asarray(self.powers * pool.influence[:, self.indices] / values)

    def solve(self, at: Array, weights: Array) -> Array:
        """Return the solution of D^T W g = 0 near some coordinates, within their limits."""
        for _ in range(MAX_NEWTON_STEPS):
            slopes = self.slopes(at)
            relative = np.expm1(self.log_difference(at))
            change = self._change_within_limits(at, slopes, weights, relative)
            new = np.clip(at + change, self.low, self.high)
            is_converged = np.abs(new - at).max() < CONVERGED_BELOW
            at = new
            if is_converged:
                break
        return at

    def _change_within_limits(
        self, at: Array, slopes: Array, weights: Array, relative: Array
    ) -> Array:
        """Return a Newton step of the coordinates that are not held at a limit.

        A coordinate at a limit that would leave it is held there, and the others are solved for
        without it.
        """
        is_free = np.ones(at.size, bool)
        while True:
            change = np.zeros(at.size)
            change[is_free] = _gain(slopes[:, is_free], weights) @ relative
            change = np.clip(change, -MAX_CHANGE, MAX_CHANGE)
            leaves = ((at <= self.low) & (change < 0.0)) | ((at >= self.high) & (change > 0.0))
            if not np.any(leaves):
                return change
            is_free &= ~leaves

    def result(self, at: Array, weights: Array, measured: Measured, n_pool: int) -> Fit:
        """Return the fit of all averages at its solution, with the covariance of the parameters."""
        point = self.point(at)
        theory = Theory(measured.layout, measured.has_velocities)
        scales = _scales(self.free)
        # a parameter that is held at a limit does not follow the data, but it has an error
        is_inside = (at > self.low) & (at < self.high)
        slopes = self.slopes(at)
        without_limits = scales[:, None] * _gain(slopes, weights)
        gain = np.zeros((at.size, self.indices.size))
        gain[is_inside] = _gain(slopes[:, is_inside], weights)
        gain = scales[:, None] * gain
        indices = _same_components(self.measured, measured, self.indices)
        plain_slopes = _slopes_of(theory, point, self.free)
        influence = _influence(measured, indices, plain_slopes, gain, theory.values(point))
        pool = pool_at(measured, point, n_pool)
        residuals = Residuals.at(measured, theory, point, pool, influence)
        own = residuals.own
        covariance = self._covariance(
            without_limits, point, own if own is None else own[np.ix_(indices, indices)]
        )
        is_unknown = without_information(slopes.T @ weights @ slopes)
        covariance = with_infinite_variances(covariance, is_unknown)
        return Fit(
            measured,
            theory,
            point,
            self.free,
            covariance,
            plain_slopes,
            gain,
            indices,
            residuals,
        )

    def _covariance(self, gain: Array, point: Point, own: Array | None) -> Array:
        """Return the covariance of the parameters, from the groups and the theory's own error."""
        relative = self.powers / self.theory.values(point)[self.indices]
        replicates = self.measured.replicates[:, self.indices] * relative
        n_groups = len(replicates)
        covariance = jackknife_covariance(replicates @ gain.T)
        covariance = covariance * (n_groups - 1) / max(n_groups - len(self.free), 1)
        if own is not None:
            covariance = covariance + gain @ (own * np.outer(relative, relative)) @ gain.T
        return np.asarray(covariance)


def fitted_components(measured: Measured) -> Indices:
    """Return the second moments that a fit looks at: pairs of frames, or v0 and <r^2> over time."""
    layout = measured.layout
    wanted = layout.is_of("thermal_speed", "msd") & (layout.time > 0.0)
    if layout.pairs is not None:
        wanted = layout.is_of(BETWEEN_FRAMES)
    values = measured.values
    with np.errstate(invalid="ignore"):
        wanted &= np.isfinite(values) & (values > 0.0)
        wanted &= np.all(measured.replicates > 0.0, axis=0)
    return np.flatnonzero(wanted)


def _powers(measured: Measured, indices: Indices) -> Array:
    """Return to which power components are second moments: 2 for thermal speeds, else 1."""
    is_speed = measured.layout.is_of("thermal_speed")[indices]
    return np.where(is_speed, 2.0, 1.0)


def _gain(slopes: Array, weights: Array) -> Array:
    """Return A = (D^T W D)^-1 D^T W."""
    weighted = slopes.T @ weights
    return np.asarray(np.linalg.pinv(weighted @ slopes) @ weighted)


def _influence(
    measured: Measured, indices: Indices, slopes: Array, gain: Array, theory: Array
) -> Influence:
    """Return how the theory moves with the data of the fitted components."""
    relative = _powers(measured, indices) / theory[indices]
    return Influence(indices, slopes @ (gain * relative))


def _slopes_of(theory: Theory, point: Point, free: Sequence[FreeParameter]) -> Array:
    """Return the derivatives of the theory in the numbers, or their logarithms, (n, n_free)."""

    def values(coordinates: Array) -> Array:
        return theory.values(point_at(point, free, coordinates))

    return derivatives(values, coordinates_of(point, free), free) / _scales(free)


def _scales(free: Sequence[FreeParameter]) -> Array:
    """Return the units of coordinates: 1 of a logarithm."""
    scales = [1.0 if parameter.is_logarithm else parameter.scale for parameter in free]
    return np.array(scales)


def _same_components(part: Measured, whole: Measured, indices: Indices) -> Indices:
    """Return where components of some times of a sample are among those of all its times."""
    layout = whole.layout
    index_of_name: dict[tuple[str, float, float], int] = {}
    for index in range(layout.size):
        index_of_name[_name_of_component(layout, index)] = index
    indices_in_whole = []
    for index in indices.tolist():
        indices_in_whole.append(index_of_name[_name_of_component(part.layout, index)])
    return np.array(indices_in_whole, np.int64)


def _name_of_component(layout: Layout, index: int) -> tuple[str, float, float]:
    """Return the observable, its time, and the earlier time of a pair of frames, else 0."""
    name = str(layout.observable[index])
    earlier = 0.0
    if name == BETWEEN_FRAMES:
        earlier = float(layout.times[layout.earlier_index[index]])
    return name, float(layout.time[index]), earlier
