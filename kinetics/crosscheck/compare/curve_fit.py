"""The fit of a point of the theory to averages at times: begin with `fit_in_media`.

The averages x_i at times t_i have stated standard errors s_i, which are taken for independent, as
nothing else is known. With the theory mu_i(e, ln l) and the covariance M of its own error (among
dilute scatterers none),

    chi^2 = (x - mu)' C^-1 (x - mu),   C = diag(s^2) + M,

is least for the values that are fitted; their covariance is (J' C^-1 J)^-1, J the slopes of mu.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.compare.measured import Layout
from kinetics.crosscheck.compare.observables import OBSERVABLES, Array
from kinetics.crosscheck.compare.parameters import (
    FIRST_RESTITUTIONS,
    STEP,
    FreeParameter,
    combinations_of,
    derivatives,
    free_parameter,
    is_at_foreign_limit,
    limits_of,
    point_at,
)
from kinetics.crosscheck.compare.point import Point
from kinetics.crosscheck.compare.statistics import covariance_of_information
from kinetics.crosscheck.compare.theory import Theory
from kinetics.crosscheck.data.averages import AveragesTable
from kinetics.crosscheck.data.sample import Law

#: Logarithms of the largest distance over the mean free path from which a fit begins. The origin of
#: the range is not recorded.
FIRST_FOLDS = range(4)
#: Relative error of averages without any, from which a fit begins: only its size, which the
#: scatter tells, is unknown.
UNKNOWN_ERROR = 0.01
#: Relative error that the scatter tells, at least: ten times the tolerance of the solver.
LEAST_ERROR = 1e-6
#: Rounds of the theory's own covariance and the fit: the second one is that at an estimate.
N_ROUNDS = 2
#: An average below this share of the largest of its kind has the error of that share: it may be 0.
SMALLEST_SIZE = 1e-3


@dataclass(frozen=True, eq=False)
class Curves:
    """Averages after time 0 as a flat list of those that are compared.

    Parameters
    ----------
    layout : of the averages of the table at its times
    index : of each in the flat list of the layout, shape (n,)
    value, error : of each in d and U
    has_errors : whether the errors are stated; else only their ratios are known
    n_left_out : averages without an error in a table that states some
    """

    layout: Layout
    index: NDArray[np.int64]
    value: Array
    error: Array
    has_errors: bool
    n_left_out: int = 0

    @classmethod
    def of(cls, table: AveragesTable, law: Law) -> Curves:
        """Take the averages of a table that can be compared."""
        is_later = table.times > 0.0
        names = tuple(name for name in OBSERVABLES if name in table.names)
        rows = [table.names.index(name) for name in names]
        value = table.values[rows][:, is_later].ravel()
        error = table.errors[rows][:, is_later].ravel()
        is_compared = np.isfinite(value)
        n_left_out = 0
        if table.has_errors:
            has_error = error > 0.0
            n_left_out = int(np.count_nonzero(is_compared & ~has_error))
            is_compared &= has_error
        curves = cls(
            layout=Layout(names, table.times[is_later], law),
            index=np.flatnonzero(is_compared),
            value=value[is_compared],
            error=error[is_compared],
            has_errors=table.has_errors,
            n_left_out=n_left_out,
        )
        if table.has_errors:
            return curves
        return replace(curves, error=UNKNOWN_ERROR * curves._sizes())

    @property
    def size(self) -> int:
        """The number of averages."""
        return int(self.value.size)

    @property
    def observable(self) -> NDArray[np.str_]:
        """The name of each average, shape (n,)."""
        return np.asarray(self.layout.observable[self.index])

    @property
    def time(self) -> Array:
        """The time of each average in d/U, shape (n,)."""
        return np.asarray(self.layout.time[self.index])

    def _sizes(self) -> Array:
        """Return what one relative error of all averages is relative to."""
        sizes = np.empty(self.size)
        for name in self.layout.names:
            chosen = self.observable == name
            of_name = np.abs(self.value[chosen] + OBSERVABLES[name].offset)
            sizes[chosen] = np.maximum(of_name, SMALLEST_SIZE * of_name.max(initial=0.0))
        return np.where(sizes > 0.0, sizes, 1.0)


@dataclass(frozen=True, eq=False)
class CurveFit:
    """A point of the theory that was fitted to averages, or specified.

    Parameters
    ----------
    point : of the theory
    names : of the numbers that were fitted: "restitution", "path"
    coordinates : e and ln l of these, shape (n_names,)
    covariance : of these, shape (n_names, n_names); infinite for what nothing is known of
    theory : of each average, shape (n,)
    difference_covariance : of the averages less the theory of a point that is not fitted, (n, n)
    residual_covariance : of what the fit leaves of them, (n, n)
    chi_square : of all averages
    """

    point: Point
    names: tuple[str, ...]
    coordinates: Array
    covariance: Array
    theory: Array
    difference_covariance: Array
    residual_covariance: Array
    chi_square: float

    @property
    def medium(self) -> str:
        """The scatterers of the theory."""
        return self.point.scatterers

    @property
    def criterion(self) -> float:
        """By how much the averages are unlikely: -2 ln likelihood, chi^2 + ln det C, of a Gaussian.

        Without ln det C a medium whose theory has large errors would be likelier for these alone.
        """
        _, log_determinant = np.linalg.slogdet(self.difference_covariance)
        return self.chi_square + float(log_determinant)

    @property
    def error(self) -> Array:
        """The standard error of each difference from the theory, shape (n,)."""
        return np.asarray(np.sqrt(np.diagonal(self.difference_covariance)))


def fit_in_media(
    curves: Curves, point: Point, names: Sequence[str], media: Sequence[str]
) -> tuple[Curves, list[CurveFit]]:
    """Fit averages in each of some media.

    Parameters
    ----------
    curves : the averages
    point : has the numbers that are not fitted, and a guess of the others
    names : of the numbers that are fitted, fewer than the averages
    media : that the scatterers may be

    Returns
    -------
    curves : the same, where none are stated with the errors that the scatter about the theory of
        the best medium tells
    fits : one for each medium in which the fit came to an end
    """
    problems = []
    for medium in media:
        in_medium = point.with_values(scatterers=medium)
        free = tuple(free_parameter(name, in_medium) for name in names)
        problems.append(_Problem(curves, Theory(curves.layout), in_medium, free))
    if not curves.has_errors:
        curves = _with_errors_of_scatter(curves, problems)
        problems = [replace(problem, curves=curves) for problem in problems]
    fits = []
    for problem in problems:
        fitted = problem.fit()
        if fitted is not None:
            fits.append(fitted)
    return curves, fits


def _with_errors_of_scatter(curves: Curves, problems: Sequence[_Problem]) -> Curves:
    """Return the averages with the errors that the scatter tells: chi^2 is n less what is fitted.

    The scatter is one of the data, whatever the medium: it is that about the best of them.
    """
    variances = []
    for problem in problems:
        variance = problem.variance_of_scatter()
        if variance is not None:
            variances.append(variance)
    smallest = max(min(variances, default=1.0), (LEAST_ERROR / UNKNOWN_ERROR) ** 2)
    return replace(curves, error=math.sqrt(smallest) * curves.error)


@dataclass(frozen=True, eq=False)
class _Problem:
    """Averages, and their theory in a medium as a function of the coordinates (e, ln l).

    Parameters
    ----------
    curves : the averages
    theory : of their layout
    point : what is not fitted
    free : what is fitted
    """

    curves: Curves
    theory: Theory
    point: Point
    free: tuple[FreeParameter, ...]

    def values(self, coordinates: Array) -> Array:
        """Return the theory of each average, shape (n,)."""
        components = self.theory.values(point_at(self.point, self.free, coordinates))
        return np.asarray(components[self.curves.index])

    def own_covariance(self, coordinates: Array) -> Array:
        """Return the covariance of the theory's own error, shape (n, n)."""
        point = point_at(self.point, self.free, coordinates)
        own = self.theory.own_covariance(point, self.theory.values(point))
        if own is None:
            return np.zeros((self.curves.size, self.curves.size))
        index = self.curves.index
        return np.asarray(own[np.ix_(index, index)])

    def chi_square(self, coordinates: Array, covariance: Array) -> float:
        """Return r' C^-1 r of the differences r from the theory."""
        residuals = _whitening(covariance) @ (self.curves.value - self.values(coordinates))
        return float(residuals @ residuals)

    def best_start(self) -> Array | None:
        """Return the coordinates from which a fit begins: the likeliest of a few.

        None where there is no theory at any of them.
        """
        size = self.point.path
        values = {
            "restitution": FIRST_RESTITUTIONS,
            "path": [size * math.exp(-folds) for folds in FIRST_FOLDS],
        }
        low, high = limits_of(self.free)
        covariance = np.diag(self.curves.error**2)
        least = math.inf
        best = None
        for start in combinations_of(self.free, values):
            coordinates = np.clip(start, low + STEP, high - STEP)
            cost = math.inf
            with suppress(ValueError):
                cost = self.chi_square(coordinates, covariance)
            if cost < least:
                least = cost
                best = coordinates
        return best

    def least_squares(self, start: Array, covariance: Array) -> Array | None:
        """Return the coordinates of the least chi-square near a start; None if it has no end."""
        from scipy.optimize import least_squares

        if not self.free:
            return start
        whitening = _whitening(covariance)
        solved = least_squares(
            lambda x: whitening @ (self.values(x) - self.curves.value),
            start,
            lambda x: whitening @ derivatives(self.values, x, self.free),
            bounds=limits_of(self.free),
            x_scale="jac",
        )
        if not solved.success:
            return None
        return np.asarray(solved.x)

    def variance_of_scatter(self) -> float | None:
        """Return the mean square of the residuals over the errors; None without a fit."""
        covariance = np.diag(self.curves.error**2)
        with suppress(ValueError, np.linalg.LinAlgError):  # no theory there, or it is not finite
            coordinates = self.best_start()
            if coordinates is not None:
                coordinates = self.least_squares(coordinates, covariance)
            if coordinates is not None:
                freedom = self.curves.size - len(self.free)
                return self.chi_square(coordinates, covariance) / freedom
        return None

    def fit(self) -> CurveFit | None:
        """Return the best fit; None where it has no end, or ends at a limit of the theory.

        The theory's own covariance is that at the estimate before, so that it does not pull the
        fit.
        """
        covariance = np.diag(self.curves.error**2)
        with suppress(ValueError, np.linalg.LinAlgError):
            coordinates = self.best_start()
            for _ in range(N_ROUNDS):
                if coordinates is None:
                    return None
                covariance = np.diag(self.curves.error**2) + self.own_covariance(coordinates)
                coordinates = self.least_squares(coordinates, covariance)
            if coordinates is not None and not is_at_foreign_limit(self.free, coordinates):
                return self._result(coordinates, covariance)
        return None

    def _result(self, coordinates: Array, covariance: Array) -> CurveFit:
        """Return the fit at its coordinates; covariance : of the differences."""
        of_numbers = np.empty((0, 0))
        residual_covariance = covariance
        if self.free:
            slopes = derivatives(self.values, coordinates, self.free)
            whitened = _whitening(covariance) @ slopes
            information = whitened.T @ whitened
            of_numbers = covariance_of_information(information)
            explained = slopes @ np.linalg.pinv(information) @ slopes.T
            residual_covariance = covariance - explained
        return CurveFit(
            point=point_at(self.point, self.free, coordinates),
            names=tuple(parameter.name for parameter in self.free),
            coordinates=coordinates,
            covariance=of_numbers,
            theory=self.values(coordinates),
            difference_covariance=covariance,
            residual_covariance=residual_covariance,
            chi_square=self.chi_square(coordinates, covariance),
        )


def _whitening(covariance: Array) -> Array:
    """Return W with W C W' = 1."""
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)))
