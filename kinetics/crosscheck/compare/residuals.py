"""Differences of data and theory, and how they scatter by chance: begin with `Residuals`.

What is expected of chance is, wherever tracers can be simulated, the scatter of a `Pool` of
independent tracers at the point of the theory. Tracers that share media scatter more: there the
groups of the data, each with one medium, say how much. Where nothing can be simulated (fields,
drives) the groups alone are known.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.compare.measured import Measured
from kinetics.crosscheck.compare.observables import Array
from kinetics.crosscheck.compare.point import Point
from kinetics.crosscheck.compare.pool import SEED, Pool, gaussian_vectors
from kinetics.crosscheck.compare.statistics import (
    ROUNDING,
    ChiSquare,
    influence_covariance,
    is_scatter,
    jackknife_covariance,
    test_by_groups,
    test_by_simulation,
    whitening,
)
from kinetics.crosscheck.compare.theory import Theory
from kinetics.crosscheck.data.sample import effective_groups, errors

Indices = NDArray[np.int64]

#: Averages that say something at time 0, of a start that is not that of the data.
OF_START = ("drift", "thermal_speed", "a2")
#: Standard error over value up to which the scatter of an exactly known average (|v| of elastic
#: tracers) is rounding, of data in single precision or in seven digits. Above what these have.
ROUNDING_OF_EXACT = 1e-6
#: Share of the tracers that are in a component from which on gaps do not matter.
MIN_SHARE_PRESENT = 0.98
#: The groups that an error is from which is that of the theory: as good as infinitely many.
MANY_GROUPS = 1e9


def covariance_with_gaps(covariance: Array, shares: Array) -> Array:
    """Return N times the covariance of means of which each has a share of N tracers.

    Gaps are taken to be independent: a share s_k s_l of the tracers is in two components.

    Parameters
    ----------
    covariance : of one tracer, (p, p)
    shares : shape (p,)
    """
    return np.asarray(covariance + np.diag(np.diagonal(covariance) * (1.0 / shares - 1.0)))


@dataclass(frozen=True, eq=False)
class Influence:
    """How a fit moves the theory with the data: to first order, a linear function of them.

    Parameters
    ----------
    indices : the components that the fit looks at, among those of the residuals
    on_theory : change of each component of the theory for a change of these, (n_components, p)
    """

    indices: Indices
    on_theory: Array

    def remaining(self, deviations: Array) -> Array:
        """Return what deviations of data (..., n_components) leave of themselves after the fit."""
        return np.asarray(deviations - deviations[..., self.indices] @ self.on_theory.T)


@dataclass(frozen=True, eq=False)
class Residuals:
    """Data less theory at a point.

    Parameters
    ----------
    measured : the data
    point : of the theory
    theory : what it gives, shape (n_components,)
    is_exact : where the theory has no scatter
    own : covariance of the error of the theory itself, None for 0
    pool : simulated tracers with the same components; None where there are none
    influence : of the data on the theory; None for a point that does not depend on them
    """

    measured: Measured
    point: Point
    theory: Array
    is_exact: NDArray[np.bool_]
    own: Array | None = None
    pool: Pool | None = None
    influence: Influence | None = None

    @classmethod
    def at(
        cls,
        measured: Measured,
        theory: Theory,
        point: Point,
        pool: Pool | None,
        influence: Influence | None = None,
    ) -> Residuals:
        """Return the differences from the theory of a point."""
        values = theory.values(point)
        own = theory.own_covariance(point, values)
        is_exact = theory.is_exact(point)
        return cls(measured, point, values, is_exact, own, pool, influence)

    @cached_property
    def difference(self) -> Array:
        """Data less theory."""
        with np.errstate(invalid="ignore"):
            return np.asarray(self.measured.values - self.theory)

    @cached_property
    def shaped(self) -> Array:
        """The differences as `observables.shaped_difference`."""
        return self.measured.layout.shaped(self.theory, self.difference)

    @cached_property
    def replicates(self) -> Array:
        """Shaped differences with each group left out in turn, after the fit: (n_groups, n)."""
        with np.errstate(invalid="ignore"):
            plain = self.measured.replicates - self.theory
        return self._after_fit(self.measured.layout.shaped(self.theory, plain))

    def _after_fit(self, deviations: Array) -> Array:
        return deviations if self.influence is None else self.influence.remaining(deviations)

    @cached_property
    def _shares(self) -> Array:
        """The share of the tracers that are in each component, if the pool has not their gaps."""
        return self.measured.shares_without_gaps_of_pool

    @cached_property
    def _pool_influence(self) -> Array:
        """What each tracer of the pool adds to each component, in units of the theory."""
        assert self.pool is not None
        return self._after_fit(self.pool.influence * self._theory_over_pool)

    @cached_property
    def _theory_over_pool(self) -> Array:
        """The size of each component in theory over that in the pool: pools are of dilute gases."""
        assert self.pool is not None
        layout = self.measured.layout
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = layout.sizes(self.theory) / layout.sizes(self.pool.values)
        return np.where(np.isfinite(ratio), ratio, 1.0)

    @cached_property
    def _pool_error(self) -> Array:
        """The standard error of each component by the pool, 0 without one."""
        if self.pool is None:
            return np.zeros(self.theory.size)
        shares = np.where(self._shares > 0.0, self._shares, 1.0)
        return np.asarray(self._draws.std(axis=0) / np.sqrt(shares))

    @property
    def _looks_at_groups(self) -> bool:
        """Whether the data scatter otherwise than simulated tracers: shared media, or gaps."""
        if self.pool is None or not self.measured.sample.is_independent:
            return True
        return bool(np.any(self._shares[self.is_compared] < MIN_SHARE_PRESENT))

    @cached_property
    def _group_error(self) -> Array:
        """The standard error of each component by the groups of the data."""
        return errors(self.replicates)

    @cached_property
    def error(self) -> Array:
        """The standard error of each difference, with what a fit leaves of that of the theory.

        Tracers that share media scatter no less than independent ones: of few groups the larger
        of both errors counts.
        """
        error = self._pool_error
        if self._looks_at_groups:
            error = np.fmax(error, self._group_error)
        if self.own is None:
            return error
        own = np.maximum(np.diagonal(self._own_after_fit), 0.0)
        return np.asarray(np.sqrt(error**2 + own))

    @cached_property
    def groups_of_error(self) -> Array:
        """The groups that each error is as good as from."""
        if not self._looks_at_groups:
            return np.full(self.theory.size, MANY_GROUPS)
        return effective_groups(self.replicates)

    @cached_property
    def sigmas(self) -> Array:
        """The shaped differences in their standard errors."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self.shaped / self.error)

    @cached_property
    def plain_error(self) -> Array:
        """The standard error of the plain difference, towards the side on which it lies.

        Averages of few tracers are skewed: a plain difference over this is the shaped one over its
        own error.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            stretch = self.difference / self.shaped
        is_known = np.isfinite(stretch) & (stretch > 0.0)
        return np.asarray(self.error * np.where(is_known, stretch, 1.0))

    @cached_property
    def is_compared(self) -> NDArray[np.bool_]:
        """Whether there is something to compare: not the start of the data with itself."""
        layout = self.measured.layout
        is_of_start = layout.is_of(*(() if self.point.has_own_start else OF_START))
        return np.isfinite(self.difference) & (is_of_start | (layout.time > 0.0))

    @cached_property
    def is_usable(self) -> NDArray[np.bool_]:
        """Whether there is something to compare that scatters."""
        error = self._group_error if self._looks_at_groups else self._pool_error
        least = np.where(self.is_exact, ROUNDING_OF_EXACT, ROUNDING)
        return self.is_compared & is_scatter(error, self.measured.values, self.theory, least=least)

    def test(self, indices: Indices) -> ChiSquare | None:
        """Test some of the components at once; None where nothing scatters."""
        indices = np.asarray(indices)[self.is_usable[indices]]
        if indices.size == 0:
            return None
        difference = self.shaped[indices]
        own = np.zeros((indices.size, indices.size))
        if self.own is not None:
            own = self._own_after_fit[np.ix_(indices, indices)]
        axes = self._whitening_axes(indices, own)
        if len(axes) == 0:
            return None
        white = axes @ difference
        if self._looks_at_groups:
            groups = self.replicates[:, indices]
            return test_by_groups(white, groups @ axes.T, axes @ own @ axes.T)
        draws = self._draws[:, indices]
        if self.own is not None:
            random = np.random.default_rng(SEED + 1)
            draws = draws + gaussian_vectors(own, len(draws), random)
        return test_by_simulation(white, draws @ axes.T)

    def _whitening_axes(self, indices: Indices, own: Array) -> Array:
        """Return axes on which the differences have unit covariance; without a pool, unit scale."""
        if self.pool is None:
            of_groups = jackknife_covariance(self.replicates[:, indices])
            return np.diag(1.0 / np.sqrt(np.diagonal(of_groups + own)))
        influence = self._pool_influence[:, indices]
        covariance = covariance_with_gaps(influence_covariance(influence), self._shares[indices])
        return whitening(covariance / self.measured.n_tracers + own)

    @cached_property
    def _draws(self) -> Array:
        """Shaped deviations of sets of as many tracers as the data have, after the fit."""
        assert self.pool is not None
        draws = self.pool.draws(self.measured.n_tracers) * self._theory_over_pool
        return self._after_fit(draws)

    @cached_property
    def _own_after_fit(self) -> Array:
        """The covariance of the error of the theory that a fit leaves."""
        assert self.own is not None
        if self.influence is None:
            return self.own
        passed = self.influence.remaining(np.eye(self.theory.size))
        return np.asarray(passed.T @ self.own @ passed)
