"""Averages of a paper, or a digitised curve, held against the kinetic equation.

Begin with `compare_averages`. The averages x_i at times t_i have stated standard errors s_i, which
are taken for independent, as nothing else is known. With the theory mu_i(e, ln l) and the
covariance M of its own error (among dilute scatterers none),

    chi^2 = (x - mu)' C^-1 (x - mu),   C = diag(s^2) + M,

is least for the values that are fitted; their covariance is (J' C^-1 J)^-1, J the slopes of mu.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinetics.collision.medium import HIGHEST_DENSITY, LEAST_RESTITUTION
from kinetics.crosscheck.compare.flat_directions import NAMED_FROM, NAMES, UNKNOWN_FROM
from kinetics.crosscheck.compare.measured import Layout
from kinetics.crosscheck.compare.observables import OBSERVABLES
from kinetics.crosscheck.compare.point import Point
from kinetics.crosscheck.compare.result import Comparison, ComparisonTest, Parameter, Row
from kinetics.crosscheck.compare.theory import (
    Theory,
    correlation_over_time,
    relative_error,
    solve_at,
)
from kinetics.crosscheck.data.averages import AveragesTable
from kinetics.crosscheck.data.options import refuse_data
from kinetics.crosscheck.data.sample import Law
from kinetics.crosscheck.words import Verdict, gaussian_sigmas, judge_sigmas, numeral
from kinetics.errors import InputError
from kinetics.validation import check_restitution, one_of, refuse

Array = NDArray[np.float64]

#: The average that is no function of the ones of a `Layout`.
MEAN_SPEED = "mean_speed"
#: Starts that averages may have, and their names in a Scene.
STARTS = {
    "auto": "gaussian",
    "gaussian": "gaussian",
    "monoenergetic": "monoenergetic",
    "one speed": "monoenergetic",
}
#: Restitutions from which a fit begins.
FIRST_RESTITUTIONS = (0.3, 0.6, 0.85, 0.97)
#: Logarithms of the largest distance over the mean free path from which a fit begins.
FIRST_FOLDS = (0.0, 1.0, 2.0, 3.0)
#: Folds of e by which the mean free path may differ from the middle of these.
MAX_FOLDS = 12.0
#: Step of e and of ln l for slopes: solutions are right to 1e-7, so that slopes are to 1e-4.
STEP = 1e-3
#: Relative error of averages without any: only its size, which the scatter tells, is unknown.
UNKNOWN_ERROR = 0.01
#: An average below this share of the largest of its kind has the error of that share: it may be 0.
SMALLEST_SIZE = 1e-3
#: Chi-square above that of the likeliest medium from which one is excluded: odds of 20.
EXCLUDED_FROM = 6.0
#: Standard errors that hold 95 % of a Gaussian.
LIMIT_SIGMAS = 1.96
#: Speeds at which a density is summed, from this fraction of the least thermal speed on.
LOWEST_SPEED = 1e-4
#: Up to this speed in U.
HIGHEST_SPEED = 8.0
#: So many of them: the mean is right to 1e-5.
N_SPEEDS = 400
#: Remark on errors that a table states.
INDEPENDENT = (
    "Errors of different times and averages are taken for independent. Those of one set of tracers "
    "are not: what is fitted may have larger errors."
)
#: Remark on a table that states none.
NO_ERRORS = (
    "Without standard errors nothing is tested. The errors of what is fitted are from the scatter."
)


@dataclass(frozen=True, eq=False)
class Curves:
    """Averages as a flat list of those that are there after time 0.

    Parameters
    ----------
    layout : of the averages that are functions of those of a sample
    observable, time : of each average, shape (n,)
    value, error : of each in d and U; the error is NaN where none is stated
    index : of each in the flat list of all averages at all times
    """

    layout: Layout
    observable: NDArray[np.str_]
    time: Array
    value: Array
    error: Array
    index: NDArray[np.int64]

    @classmethod
    def of(cls, table: AveragesTable, law: Law) -> Curves:
        """Take the averages of a table that can be compared."""
        is_later = table.times > 0.0
        names = tuple(name for name in OBSERVABLES if name in table.names and name != MEAN_SPEED)
        order = [*names]
        if MEAN_SPEED in table.names:
            order.append(MEAN_SPEED)
        rows = [table.names.index(name) for name in order]
        times = table.times[is_later]
        value = table.values[rows][:, is_later].ravel()
        error = table.errors[rows][:, is_later].ravel()
        is_there = np.isfinite(value)
        if table.has_errors:
            is_there &= error > 0.0
        observable = np.repeat(np.array(order, dtype="U40"), times.size)
        return cls(
            layout=Layout(names, times, law),
            observable=observable[is_there],
            time=np.tile(times, len(order))[is_there],
            value=value[is_there],
            error=error[is_there],
            index=np.flatnonzero(is_there),
        )

    @property
    def has_errors(self) -> bool:
        """Whether standard errors are stated."""
        return bool(np.all(np.isfinite(self.error)))

    @property
    def weighting_error(self) -> Array:
        """The errors that weigh: those that are stated, or one relative error for all."""
        if self.has_errors:
            return self.error
        sizes = np.abs(self.value)
        for name in np.unique(self.observable):
            chosen = self.observable == name
            sizes[chosen] = np.abs(self.value[chosen] + OBSERVABLES[str(name)].offset)
            smallest = SMALLEST_SIZE * float(sizes[chosen].max())
            sizes[chosen] = np.maximum(sizes[chosen], smallest)
        return np.asarray(UNKNOWN_ERROR * sizes)


@dataclass(frozen=True, eq=False)
class CurveFit:
    """A point of the theory that was fitted to averages, or specified.

    Parameters
    ----------
    point : of the theory
    names : of the numbers that were fitted: "restitution", "path"
    coordinates : e and ln l of these, shape (n_names,)
    covariance : of these, shape (n_names, n_names)
    theory : of each average, shape (n,)
    error : standard error of each difference from it
    chi_square : of all averages
    """

    point: Point
    names: tuple[str, ...]
    coordinates: Array
    covariance: Array
    theory: Array
    error: Array
    chi_square: float

    @property
    def medium(self) -> str:
        """The scatterers of the theory."""
        return self.point.scatterers


def compare_averages(
    table: AveragesTable,
    restitution: float | None = None,
    number_density: float | None = None,
    initial: str = "auto",
    scatterers: str = "auto",
    dimension: int | None = None,
) -> Comparison:
    """Compare averages with the kinetic equation.

    Parameters
    ----------
    table : of averages, in d and U
    restitution, number_density : the latter in d^-2 (d^-3 in space); None: they are fitted
    initial : "gaussian" (also "auto"), or "monoenergetic" ("one speed")
    scatterers : "dilute", "hard disks", "overlapping", or "auto": the likeliest of the first two
    dimension : 2 (also None) or 3

    Raises
    ------
    InputError
        There are too few averages, or an argument is out of range.
    """
    if initial not in STARTS:
        refuse("initial", initial, "averages do not say it: it must be gaussian or one speed")
    if MEAN_SPEED in table.names and STARTS[initial] != "gaussian":
        refuse("initial", initial, "of mean speeds it must be gaussian")
    one_of("scatterers", scatterers, ("auto", "dilute", "hard disks", "overlapping"))
    law = Law(dimension=dimension or 2)
    if law.dimension == 3 and scatterers not in ("auto", "dilute"):
        refuse("scatterers", scatterers, "of others than disks it must be 'dilute'")
    curves = Curves.of(table, law)
    point = Point(
        restitution=0.7 if restitution is None else check_restitution(restitution),
        path=_largest_distance(curves) if number_density is None else law.free_path(number_density),
        start=STARTS[initial],
    )
    specified = {"restitution": restitution, "path": number_density}
    free = tuple(name for name, value in specified.items() if value is None)
    if curves.value.size < len(free) + 1:
        averages = f"{curves.value.size} averages after time 0"
        if table.has_errors:
            averages += " with errors"
        refuse_data(table.source, averages, f"{len(free) + 1} at least")
    fits = [
        fitted
        for medium in _media(scatterers, point, free, law)
        if (fitted := _fit(curves, point.with_values(scatterers=medium), free)) is not None
    ]
    if not fits:
        raise InputError(
            f"{table.source}: no restitution and density fit these averages; give them"
        )
    return _comparison(table, curves, fits)


def _largest_distance(curves: Curves) -> float:
    """Return a length of the order of how far tracers go."""
    squares = curves.value[curves.observable == "msd"]
    if squares.size and squares.max() > 0.0:
        return math.sqrt(float(squares.max()))
    return float(curves.time.max(initial=1.0))


def _media(scatterers: str, point: Point, free: Sequence[str], law: Law) -> list[str]:
    """Return the media that are tried."""
    if scatterers != "auto":
        return [scatterers]
    has_theory = law.dimension == 2
    if "path" not in free:
        has_theory &= law.free_path(point.path) <= HIGHEST_DENSITY
    if "restitution" not in free:
        has_theory &= point.restitution >= LEAST_RESTITUTION
    return ["dilute", "hard disks"] if has_theory else ["dilute"]


# -- theory and fit --------------------------------------------------------------------------------


class CurveTheory:
    """The theory of averages as a function of the numbers that are fitted, (e, ln l).

    Parameters
    ----------
    curves : the averages
    point : what is not fitted
    free : names of the numbers that are fitted
    """

    def __init__(self, curves: Curves, point: Point, free: tuple[str, ...]) -> None:
        self.curves = curves
        self.first_point = point
        self.free = free
        self._theory = Theory(curves.layout)

    def point(self, coordinates: Array) -> Point:
        """Return the point at coordinates."""
        values = dict(zip(self.free, coordinates.tolist(), strict=True))
        if "path" in values:
            values["path"] = math.exp(values["path"])
        return self.first_point.with_values(**values)

    def values(self, coordinates: Array) -> Array:
        """Return the theory of each average, shape (n,)."""
        point = self.point(coordinates)
        layout = self.curves.layout
        components = self._theory.values(point) if layout.names else np.empty(0)
        if np.any(self.curves.observable == MEAN_SPEED):
            components = np.append(components, _mean_speeds(point, layout))
        return np.asarray(components[self.curves.index])

    def own_covariance(self, coordinates: Array) -> Array:
        """Return the covariance of the theory's own error, shape (n, n)."""
        layout = self.curves.layout
        point = self.point(coordinates)
        has_mean_speed = bool(np.any(self.curves.observable == MEAN_SPEED))
        n_all = layout.size + layout.times.size * has_mean_speed
        covariance = np.zeros((n_all, n_all))
        if point.scatterers != "dilute":
            if layout.names:
                of_layout = self._theory.own_covariance(point, self._theory.values(point))
                covariance[: layout.size, : layout.size] = of_layout
            if has_mean_speed:
                error = relative_error(MEAN_SPEED, point, layout) * _mean_speeds(point, layout)
                of_mean_speed = correlation_over_time(layout.times) * np.outer(error, error)
                covariance[layout.size :, layout.size :] = of_mean_speed
        index = self.curves.index
        return np.asarray(covariance[np.ix_(index, index)])

    def limits(self) -> tuple[Array, Array]:
        """Return the lowest and the highest coordinates."""
        is_dilute = self.first_point.scatterers == "dilute"
        middle = math.log(self.first_point.path)
        shortest = -math.log(2.0 * HIGHEST_DENSITY)
        low = {
            "restitution": 0.0 if is_dilute else LEAST_RESTITUTION,
            "path": middle - MAX_FOLDS if is_dilute else shortest,
        }
        high = {"restitution": 1.0, "path": middle + MAX_FOLDS}
        return (
            np.array([low[name] for name in self.free]),
            np.array([high[name] for name in self.free]),
        )

    def slopes(self, coordinates: Array) -> Array:
        """Return the derivatives of the theory, shape (n, n_free)."""
        low, high = self.limits()
        columns = []
        for k in range(coordinates.size):
            above = coordinates.copy()
            below = coordinates.copy()
            above[k] = min(coordinates[k] + STEP, high[k])
            below[k] = max(coordinates[k] - STEP, low[k])
            difference = self.values(above) - self.values(below)
            columns.append(difference / (above[k] - below[k]))
        return np.stack(columns, axis=1)


def _mean_speeds(point: Point, layout: Layout) -> Array:
    """Return <v> at each time, from the density of the speed."""
    solution = solve_at(point, layout.law, layout.times, ("speed_density", "thermal_speed"))
    slowest = LOWEST_SPEED * float(np.min(solution.thermal_speed))
    speeds = np.geomspace(slowest, HIGHEST_SPEED, N_SPEEDS)
    density = np.asarray(solution.speed_density(speeds))
    weighted = density * speeds  # in the logarithm of the speed
    steps = np.log(speeds)
    return np.asarray(
        np.trapezoid(weighted * speeds, steps, axis=1) / np.trapezoid(weighted, steps, axis=1)
    )


def _fit(curves: Curves, point: Point, free: tuple[str, ...]) -> CurveFit | None:
    """Return the fit in the medium of a point; None where it did not come to an end.

    The theory's own covariance is that at the first estimate, so that it does not pull the fit.
    """
    from scipy.optimize import least_squares

    theory = CurveTheory(curves, point, free)
    error = curves.weighting_error
    coordinates = np.empty(0)
    whitening = np.diag(1.0 / error)
    if free:
        coordinates = _best_start(theory, whitening)
    for _ in range(2):
        covariance = np.diag(error**2) + theory.own_covariance(coordinates)
        whitening = np.linalg.inv(np.linalg.cholesky(covariance))
        if free:
            solved = least_squares(
                _whitened_residuals,
                coordinates,
                _whitened_slopes,
                bounds=theory.limits(),
                x_scale="jac",
                args=(theory, whitening),
            )
            if not solved.success:
                return None
            coordinates = solved.x
    values = theory.values(coordinates)
    chi_square = float(np.sum((whitening @ (curves.value - values)) ** 2))
    information = np.empty((0, 0))
    if free:
        slopes = whitening @ theory.slopes(coordinates)
        information = slopes.T @ slopes
    freedom = max(curves.value.size - len(free), 1)
    scale = 1.0 if curves.has_errors else chi_square / freedom
    return CurveFit(
        point=theory.point(coordinates),
        names=free,
        coordinates=coordinates,
        covariance=np.asarray(scale * np.linalg.pinv(information), float),
        theory=values,
        error=math.sqrt(scale) * np.sqrt(np.diag(covariance)),
        chi_square=chi_square,
    )


def _whitened_residuals(coordinates: Array, theory: CurveTheory, whitening: Array) -> Array:
    """Return differences from the theory, in units of their standard errors."""
    return np.asarray(whitening @ (theory.values(coordinates) - theory.curves.value))


def _whitened_slopes(coordinates: Array, theory: CurveTheory, whitening: Array) -> Array:
    """Return the derivatives of `_whitened_residuals`."""
    return np.asarray(whitening @ theory.slopes(coordinates))


def _best_start(theory: CurveTheory, whitening: Array) -> Array:
    """Return the coordinates from which a fit begins: the likeliest of a few."""
    low, high = theory.limits()
    size = math.log(theory.first_point.path)
    choices = {
        "restitution": list(FIRST_RESTITUTIONS),
        "path": [size - folds for folds in FIRST_FOLDS],
    }
    starts = np.stack(np.meshgrid(*[choices[name] for name in theory.free]), axis=-1)
    best = np.clip(starts.reshape(-1, len(theory.free)), low + STEP, high - STEP)
    costs = [np.sum(_whitened_residuals(start, theory, whitening) ** 2) for start in best]
    return np.asarray(best[int(np.nanargmin(costs))])


# -- the comparison --------------------------------------------------------------------------------


def _comparison(table: AveragesTable, curves: Curves, fits: Sequence[CurveFit]) -> Comparison:
    """Return the comparison with the likeliest of fits, one for each medium."""
    from scipy.stats import chi2

    best = min(fits, key=lambda fitted: fitted.chi_square)
    alike = [
        fitted
        for fitted in fits
        if fitted is not best and fitted.chi_square < best.chi_square + EXCLUDED_FROM
    ]
    best = _covering(best, alike)
    n = curves.value.size
    freedom = n - len(best.names)
    p_value = None
    verdict = Verdict.NOT_TESTED
    remarks = [*table.remarks, INDEPENDENT if curves.has_errors else NO_ERRORS]
    if curves.has_errors:
        p_value = float(chi2.sf(best.chi_square, freedom))
        verdict = judge_sigmas(gaussian_sigmas(p_value))
    dimension = curves.layout.law.dimension
    parameters = _parameters(best, verdict, dimension)
    return Comparison(
        verdict=verdict,
        summary=_summary(best, verdict, n, dimension),
        parameters=parameters,
        initial=best.point.start_in_words,
        samples=0,
        groups=0,
        grouping="stated errors",
        names=(table.source.rsplit("/", 1)[-1],),
        warnings=tuple(remarks),
        tests=_tests(curves, best),
        explanations=(),
        numbers=_rows(curves, best),
        medium=best.medium,
        covariance=tuple(tuple(row) for row in best.covariance.tolist()),
        overall_p_value=p_value,
        chi_square=best.chi_square if curves.has_errors else None,
        dof=freedom if curves.has_errors else None,
        units=dict(table.units or {}),
        dimension=dimension,
        cannot_tell=_cannot_tell(best),
        media={fitted.medium: (fitted.chi_square, freedom) for fitted in fits},
        undecided=tuple(fitted.medium for fitted in alike) if curves.has_errors else (),
        n_times=int(np.unique(curves.time).size),
        first_time=float(curves.time.min()),
        last_time=float(curves.time.max()),
        next_step="" if curves.has_errors else "Give standard errors: columns such as msd_error.",
    )


def _covering(best: CurveFit, alike: Sequence[CurveFit]) -> CurveFit:
    """Return a fit whose errors reach the values in other media that are not excluded."""
    covariance = best.covariance
    for fitted in alike:
        away = fitted.coordinates - best.coordinates
        covariance = covariance + np.outer(away, away)
    return replace(best, covariance=covariance)


def _parameters(fitted: CurveFit, verdict: Verdict, dimension: int) -> dict[str, Parameter]:
    """Return the numbers of the theory in d; without values where it does not fit."""
    point = fitted.point
    law = Law(dimension=dimension)
    density = law.free_path(point.path)
    values = {
        "restitution": ("restitution", point.restitution, 1.0),
        "number_density": ("path", density, density),
        "mean_free_path": ("path", point.path, point.path),
    }
    unknown = _unknown_numbers(fitted)
    parameters = {}
    for name, (coordinate, value, error_scale) in values.items():
        if coordinate not in fitted.names:
            parameters[name] = Parameter(value, None, "told")
        elif verdict is Verdict.DIFFERS:
            parameters[name] = Parameter(None, None, "no value: the model does not fit")
        elif coordinate in unknown:
            parameters[name] = Parameter(None, None, "no value: these averages do not tell it")
        else:
            k = fitted.names.index(coordinate)
            error = error_scale * math.sqrt(fitted.covariance[k, k])
            parameters[name] = Parameter(value, error, "fitted to averages over time")
    return parameters


def _rows(curves: Curves, fitted: CurveFit) -> tuple[Row, ...]:
    """Return a row for each average; without stated errors none is judged."""
    rows = []
    for k in range(curves.value.size):
        name = str(curves.observable[k])
        sigmas = None
        corrected = None
        verdict = Verdict.NOT_TESTED
        if curves.has_errors:
            sigmas = float((curves.value[k] - fitted.theory[k]) / fitted.error[k])
            n_looks = int(np.count_nonzero(curves.observable == name))
            corrected = gaussian_sigmas(math.erfc(abs(sigmas) / math.sqrt(2.0)) * n_looks)
            verdict = judge_sigmas(corrected)
        row = Row(
            observable=name,
            time=float(curves.time[k]),
            value=float(curves.value[k]),
            error=float(fitted.error[k]),
            theory=float(fitted.theory[k]),
            sigmas=sigmas,
            verdict=verdict,
            corrected_sigmas=corrected,
            samples=0,
        )
        rows.append(row)
    return tuple(rows)


def _tests(curves: Curves, fitted: CurveFit) -> tuple[ComparisonTest, ...]:
    """Return a chi-square of each average; each has its share of the numbers that were fitted."""
    from scipy.stats import chi2

    if not curves.has_errors:
        return ()
    names = list(dict.fromkeys(curves.observable.tolist()))
    tests = []
    for name in names:
        chosen = curves.observable == name
        difference = curves.value[chosen] - fitted.theory[chosen]
        error = fitted.error[chosen]
        n = int(np.count_nonzero(chosen))
        freedom = max(round(n - len(fitted.names) * n / curves.value.size), 1)
        chi_square = float(np.sum((difference / error) ** 2))
        p_value = float(chi2.sf(chi_square, freedom))
        sigmas = gaussian_sigmas(p_value * len(names))
        sizes = np.abs(fitted.theory[chosen] + OBSERVABLES[name].offset)
        within = float(np.max((np.abs(difference) + LIMIT_SIGMAS * error) / sizes))
        test = ComparisonTest(
            observable=name,
            time=None,
            chi_square=chi_square,
            dof=freedom,
            p_value=p_value,
            groups=None,
            sigmas=sigmas,
            verdict=judge_sigmas(sigmas),
            within=within,
        )
        tests.append(test)
    return tuple(tests)


def _unknown_numbers(fitted: CurveFit) -> list[str]:
    """Return which of the fitted numbers the averages do not tell: those of a flat direction."""
    if not fitted.names:
        return []
    units = np.array([UNKNOWN_FROM[name] for name in fitted.names])
    variances, directions = np.linalg.eigh(fitted.covariance / np.outer(units, units))
    if variances[-1] <= 1.0:
        return []
    is_named = np.abs(directions[:, -1]) > NAMED_FROM
    is_named |= np.diag(fitted.covariance) > units**2
    return [name for name, chosen in zip(fitted.names, is_named, strict=True) if chosen]


def _cannot_tell(fitted: CurveFit) -> tuple[str, ...]:
    """Return a sentence where fitted numbers are not known."""
    names = [NAMES[name] for name in _unknown_numbers(fitted)]
    if not names:
        return ()
    if len(names) > 1:
        return (f"{' and '.join(names)} cannot be told apart by these averages.",)
    return (f"{names[0]} cannot be told from these averages.",)


def _summary(fitted: CurveFit, verdict: Verdict, n: int, dimension: int) -> str:
    """Return the verdict, and what was compared, in two sentences."""
    words = {
        Verdict.AGREES: "No difference seen.",
        Verdict.UNCLEAR: "A difference is possible.",
        Verdict.DIFFERS: "They differ.",
    }
    point = fitted.point
    density = Law(dimension=dimension).free_path(point.path)
    system = f"e = {numeral(point.restitution, '.6g')}, ρ₀ = {numeral(density, '.6g')}"
    judgement = words.get(verdict, "Not tested: no standard errors are stated.")
    return (
        f"{judgement} {n} averages, compared with the kinetic equation with {system}, from "
        f"{point.start_in_words}."
    )
