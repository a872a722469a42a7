"""Averages of a paper, or a digitised curve, held against the kinetic equation.

Begin with `compare_averages`; what is fitted, and how, says `curve_fit`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kinetics.collision.medium import word_for_scatterers
from kinetics.crosscheck.compare.curve_fit import CurveFit, Curves, fit_in_media
from kinetics.crosscheck.compare.flat_directions import cannot_tell, unknown_numbers
from kinetics.crosscheck.compare.media import across_media, media_not_excluded, media_of
from kinetics.crosscheck.compare.observables import MEAN_SPEED, OBSERVABLES
from kinetics.crosscheck.compare.point import Point
from kinetics.crosscheck.compare.result import Comparison, ComparisonTest, Parameter, Row
from kinetics.crosscheck.compare.starts import STARTS
from kinetics.crosscheck.compare.statistics import whitening
from kinetics.crosscheck.data.averages import AveragesTable
from kinetics.crosscheck.data.options import refuse_data
from kinetics.crosscheck.data.sample import Law
from kinetics.crosscheck.words import Verdict, gaussian_sigmas, judge_sigmas, numeral
from kinetics.errors import InputError
from kinetics.validation import check_restitution, refuse

#: Standard errors that hold 95 % of a Gaussian.
LIMIT_SIGMAS = 1.96
#: Remark on errors that a table states.
INDEPENDENT = (
    "Errors of different times and averages are taken for independent. Those of one set of tracers "
    "are not: what is fitted may have larger errors."
)
#: Remark on a table that states none.
NO_ERRORS = (
    "Without standard errors nothing is tested. The errors of what is fitted are from the scatter."
)


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
    scatterers : "dilute", "hard disks", "overlapping disks", or "auto": the likeliest of the
        first two
    dimension : 2 (also None) or 3

    Raises
    ------
    InputError
        There are too few averages, or an argument is out of range.
    """
    scatterers = word_for_scatterers(scatterers, ("auto",))
    law = Law(dimension=dimension or 2)
    start = _start(table, initial)
    _check_scatterers(scatterers, law)
    curves = Curves.of(table, law)
    point = Point(restitution=0.7, path=_largest_distance(curves), start=start)
    free = ["restitution", "path"]
    if restitution is not None:
        free.remove("restitution")
        restitution = check_restitution(restitution)
        point = point.with_values(restitution=restitution)
    path = None
    if number_density is not None:
        free.remove("path")
        path = law.free_path(number_density)
        point = point.with_values(path=path)
    if curves.size < len(free) + 1:
        averages = f"{curves.size} averages after time 0"
        if table.has_errors:
            averages += " with errors"
        refuse_data(table.source, averages, f"{len(free) + 1} at least")
    media = media_of(scatterers, law, path, restitution)
    curves, fits = fit_in_media(curves, point, free, media)
    if not fits:
        raise InputError(
            f"{table.source}: no restitution and density fit these averages; give them"
        )
    return _comparison(table, curves, fits)


def _start(table: AveragesTable, initial: str) -> str:
    """Return the start as a Scene has it; InputError where there is no theory of the averages."""
    start = STARTS.get(initial)
    if start == "auto":
        return "gaussian"
    if start not in ("gaussian", "monoenergetic"):
        refuse("initial", initial, "averages do not say it: it must be gaussian or one speed")
    if MEAN_SPEED in table.names and start != "gaussian":
        refuse("initial", initial, "of mean speeds it must be gaussian")
    return start


def _check_scatterers(scatterers: str, law: Law) -> None:
    """Raise InputError for scatterers of which there is no theory."""
    if law.dimension == 3 and scatterers not in ("auto", "dilute"):
        refuse("scatterers", scatterers, "of others than disks it must be 'dilute'")


def _largest_distance(curves: Curves) -> float:
    """Return a length of the order of how far tracers go."""
    squares = curves.value[curves.observable == "msd"]
    if squares.size and squares.max() > 0.0:
        return math.sqrt(float(squares.max()))
    return float(curves.time.max(initial=1.0))


# -- the comparison --------------------------------------------------------------------------------


def _comparison(table: AveragesTable, curves: Curves, fits: Sequence[CurveFit]) -> Comparison:
    """Return the comparison with the likeliest of fits, one for each medium."""
    from scipy.stats import chi2

    best = min(fits, key=lambda fitted: fitted.criterion)
    undecided = media_not_excluded(best, fits)
    point, coordinates, covariance = across_media(best, undecided)
    reported = replace(best, point=point, coordinates=coordinates, covariance=covariance)
    freedom = curves.size - len(best.names)
    p_value = None
    chi_square = None
    dof = None
    verdict = Verdict.NOT_TESTED
    next_step = "Give standard errors: columns such as msd_error."
    if curves.has_errors:
        next_step = ""
        chi_square = best.chi_square
        dof = freedom
        p_value = float(chi2.sf(best.chi_square, freedom))
        verdict = judge_sigmas(gaussian_sigmas(p_value))
    dimension = curves.layout.law.dimension
    parameters = _parameters(reported, verdict, dimension)
    return Comparison(
        verdict=verdict,
        summary=_summary(best, verdict, curves.size, dimension),
        parameters=parameters,
        initial=best.point.start_in_words,
        samples=0,
        groups=0,
        grouping="stated errors",
        names=(table.source.rsplit("/", 1)[-1],),
        warnings=(*table.remarks, *_remarks(curves)),
        tests=_tests(curves, best),
        explanations=(),
        numbers=_rows(curves, best),
        medium=best.medium,
        covariance=tuple(tuple(row) for row in reported.covariance.tolist()),
        overall_p_value=p_value,
        chi_square=chi_square,
        dof=dof,
        units=dict(table.units or {}),
        dimension=dimension,
        cannot_tell=cannot_tell(reported.names, reported.covariance, "these averages"),
        media={fitted.medium: (fitted.chi_square, freedom) for fitted in fits},
        undecided=tuple(fitted.medium for fitted in undecided),
        n_times=int(np.unique(curves.time).size),
        first_time=float(curves.time.min()),
        last_time=float(curves.time.max()),
        next_step=next_step,
    )


def _remarks(curves: Curves) -> list[str]:
    """Return what a reader should know of the errors."""
    if not curves.has_errors:
        return [NO_ERRORS]
    remarks = [INDEPENDENT]
    if curves.n_left_out:
        remarks.append(
            f"{curves.n_left_out} averages without a standard error above 0 are left out."
        )
    return remarks


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
    unknown = unknown_numbers(fitted.names, fitted.covariance)
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
    for k in range(curves.size):
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
    """Return a chi-square of each average, with the covariance that the fit leaves of it."""
    if not curves.has_errors:
        return ()
    names = list(dict.fromkeys(curves.observable.tolist()))
    tests = []
    for name in names:
        test = _test(curves, fitted, name, len(names))
        if test is not None:
            tests.append(test)
    return tuple(tests)


def _test(curves: Curves, fitted: CurveFit, name: str, n_tests: int) -> ComparisonTest | None:
    """Return the test of one average; None where the fit leaves nothing to test."""
    from scipy.stats import chi2

    chosen = np.flatnonzero(curves.observable == name)
    axes = whitening(fitted.residual_covariance[np.ix_(chosen, chosen)])
    freedom = len(axes)
    if freedom == 0:
        return None
    difference = curves.value[chosen] - fitted.theory[chosen]
    chi_square = float(np.sum((axes @ difference) ** 2))
    p_value = float(chi2.sf(chi_square, freedom))
    sigmas = gaussian_sigmas(p_value * n_tests)
    sizes = np.abs(fitted.theory[chosen] + OBSERVABLES[name].offset)
    excluded = np.abs(difference) + LIMIT_SIGMAS * fitted.error[chosen]
    return ComparisonTest(
        observable=name,
        time=None,
        chi_square=chi_square,
        dof=freedom,
        p_value=p_value,
        groups=None,
        sigmas=sigmas,
        verdict=judge_sigmas(sigmas),
        within=float(np.max(excluded / sizes)),
    )


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
