"""The judgement: rows, tests, and the one p-value that the verdict is on. Begin with `judge`.

Data and theory are looked at in several ways: all averages together, each average alone, each
density, and each row for an outlier. The p-value of the verdict allows for the number of looks.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinetics.crosscheck.compare.densities import Histogram, densities_of
from kinetics.crosscheck.compare.fit import Fit
from kinetics.crosscheck.compare.measured import Measured
from kinetics.crosscheck.compare.observables import BETWEEN_FRAMES
from kinetics.crosscheck.compare.residuals import Residuals
from kinetics.crosscheck.compare.result import ComparisonTest, Row
from kinetics.crosscheck.compare.selection import tested_components
from kinetics.crosscheck.compare.statistics import ChiSquare
from kinetics.crosscheck.compare.theory import Theory
from kinetics.crosscheck.words import (
    Verdict,
    can_differ,
    corrected_sigmas,
    gaussian_sigmas,
    judge_sigmas,
    limit_factor,
)

#: Tolerances of the solver by which data without scatter may be off: the data are rounded too.
TOLERANCES_OF_EXACT = 10.0
#: An average near 0 that is off by less than this is no different.
LEAST_DIFFERENCE = 1e-15


@dataclass(frozen=True, eq=False)
class Judgement:
    """What a comparison comes to.

    Parameters
    ----------
    residuals : data less theory, at all times
    rows : one for each observable and time, pair of frames, or bin
    tests : one for each average, over its times, and for each density and time
    has_densities : whether densities were compared
    remarks : which densities were not, although the data have them
    p_value : of the verdict; 1 where nothing could be tested
    verdict : on everything
    """

    residuals: Residuals
    rows: tuple[Row, ...]
    tests: tuple[ComparisonTest, ...]
    has_densities: bool
    remarks: tuple[str, ...]
    p_value: float
    verdict: Verdict


def judge(fitted: Fit, measured: Measured, theory: Theory) -> Judgement:
    """Return the judgement on a fit.

    Parameters
    ----------
    fitted : the fit, which looks at some of the times
    measured, theory : of all times of the same sample
    """
    residuals = fitted.residuals_of(measured, theory)
    densities = densities_of(measured.sample, fitted.point)
    rows = [*rows_of_averages(residuals), *rows_of_densities(densities.histograms)]
    tests = tests_of(fitted, residuals, densities.histograms)
    p_value = _one_p_value(fitted.chi_square, tests, rows)
    return Judgement(
        residuals=residuals,
        rows=tuple(rows),
        tests=tuple(tests),
        has_densities=bool(densities.histograms),
        remarks=densities.remarks,
        p_value=p_value,
        verdict=_verdict(p_value, tests, rows),
    )


def _one_p_value(
    averages: ChiSquare | None, tests: Sequence[ComparisonTest], rows: Sequence[Row]
) -> float:
    """Return the p-value of everything that was tested.

    The test of all averages together has half of the level, all tests of one average or density a
    quarter, and the rows the other quarter, each divided by their number.
    """
    n_observables = len({row.observable for row in rows})
    candidates = [1.0]
    if averages is not None:
        candidates.append(2.0 * averages.p_value)
    for test in tests:
        candidates.append(4.0 * len(tests) * test.p_value)
    for row in rows:
        if row.corrected_sigmas is not None:  # corrected for the rows of its observable
            of_row = math.erfc(abs(row.corrected_sigmas) / math.sqrt(2.0))
            candidates.append(4.0 * n_observables * of_row)
    return min(candidates)


def _verdict(p_value: float, tests: Sequence[ComparisonTest], rows: Sequence[Row]) -> Verdict:
    """Return the verdict of a p-value, and of rows without scatter, which no test can hold."""
    verdicts = [row.verdict for row in rows if row.sigmas is None]
    if tests:
        verdicts.append(judge_sigmas(gaussian_sigmas(p_value)))
    verdict = worst_of(verdicts)
    is_tested = any(test.verdict is not Verdict.NOT_TESTED for test in tests)
    if verdict is Verdict.AGREES and tests and not is_tested:
        return Verdict.NOT_TESTED  # what is exact, or the start, agrees: no test of the rest
    return verdict


def _verdict_on(sigmas: float, is_testable: bool) -> Verdict:
    """Return the verdict on corrected sigmas; agreement says nothing where nothing could differ."""
    verdict = judge_sigmas(sigmas)
    if verdict is Verdict.AGREES and not is_testable:
        return Verdict.NOT_TESTED
    return verdict


def worst_of(verdicts: Sequence[Verdict]) -> Verdict:
    """Return the worst of some; not tested only where nothing was, undefined without any."""
    order = (Verdict.DIFFERS, Verdict.UNCLEAR, Verdict.AGREES, Verdict.NOT_TESTED)
    for verdict in order:
        if verdict in verdicts:
            return verdict
    return Verdict.UNDEFINED


# -- rows ------------------------------------------------------------------------------------------
def rows_of_averages(residuals: Residuals) -> list[Row]:
    """Return one row for each average and time, and for each pair of frames."""
    layout = residuals.measured.layout
    sizes = layout.sizes(residuals.theory)
    rows = []
    for name in layout.all_names:
        indices = layout.indices_of(name)
        n_looks = int(np.count_nonzero(residuals.is_usable[indices]))
        for index in indices[residuals.is_compared[indices]].tolist():
            rows.append(_row(residuals, index, float(sizes[index]), n_looks))
    return rows


def _row(residuals: Residuals, index: int, size: float, n_looks: int) -> Row:
    layout = residuals.measured.layout
    name = str(layout.observable[index])
    value = float(residuals.measured.values[index])
    theory = float(residuals.theory[index])
    error = 0.0
    sigmas = None
    corrected = None
    if residuals.is_usable[index]:
        error = float(residuals.plain_error[index])
        sigmas = float(residuals.sigmas[index])
        groups = float(residuals.groups_of_error[index])
        corrected = corrected_sigmas(sigmas, groups, n_looks)
        verdict = _verdict_on(corrected, can_differ(error / size, groups))
    else:
        verdict = _verdict_without_scatter(residuals, index, size)
    since = None
    if name == BETWEEN_FRAMES:
        since = float(layout.times[layout.earlier_index[index]])
    return Row(
        observable=name,
        time=float(layout.time[index]),
        value=value,
        error=error,
        theory=theory,
        sigmas=sigmas,
        verdict=verdict,
        corrected_sigmas=corrected,
        samples=int(residuals.measured.counts[index]),
        since=since,
    )


def _verdict_without_scatter(residuals: Residuals, index: int, size: float) -> Verdict:
    """Return the verdict on an average that is the same in every group.

    The solver has a tolerance, and data are rounded: ten of these are no difference. What is exact
    in theory must be as near. Else the theory has some tracers that have collided where the data
    have none: a share p of N tracers is missed with the probability exp(-N p), and one collision
    changes an average at most to its double.
    """
    sample = residuals.measured.sample
    time = float(residuals.measured.layout.time[index])
    value = float(residuals.measured.values[index])
    theory = float(residuals.theory[index])
    is_exact = bool(residuals.is_exact[index])
    relative = TOLERANCES_OF_EXACT * sample.law.rtol
    if math.isclose(value, theory, rel_tol=relative, abs_tol=LEAST_DIFFERENCE):
        verdict = Verdict.AGREES
    elif is_exact or time == 0.0:
        return Verdict.DIFFERS
    else:
        missed_share = abs(value - theory) / size / 2.0
        n_tracers = int(residuals.measured.counts[index])
        verdict = judge_sigmas(gaussian_sigmas(math.exp(-n_tracers * missed_share)))
    if is_exact:
        return verdict
    if sample.groups < 3:  # one tracer is always like itself
        return Verdict.NOT_TESTED
    if (sample.law.field or sample.law.is_driven) and time > 0.0:
        return Verdict.UNDEFINED  # a tracer falls before its first collision as others do
    return verdict


def rows_of_densities(histograms: Sequence[Histogram]) -> list[Row]:
    """Return one row for each bin: shares over the width of the bin, of the last bin shares."""
    n_looks: dict[str, int] = {}
    for histogram in histograms:
        n_looks[histogram.name] = n_looks.get(histogram.name, 0) + histogram.share.size
    rows = []
    for histogram in histograms:
        rows += _rows_of_histogram(histogram, n_looks[histogram.name])
    return rows


def _rows_of_histogram(histogram: Histogram, n_looks: int) -> list[Row]:
    is_testable = _has_testable_bin(histogram)
    rows = []
    for index in range(histogram.share.size):
        low = float(histogram.edges[index])
        high = float(histogram.edges[index + 1])
        has_end = math.isfinite(high)
        width = 1.0
        if has_end:
            width = high - low
        error = float(histogram.error[index])
        sigmas = float(histogram.share[index] - histogram.theory[index]) / error
        corrected = corrected_sigmas(sigmas, histogram.groups, n_looks)
        row = Row(
            observable=histogram.name,
            time=histogram.time,
            value=float(histogram.share[index]) / width,
            error=error / width,
            theory=float(histogram.theory[index]) / width,
            sigmas=sigmas,
            verdict=_verdict_on(corrected, is_testable),
            corrected_sigmas=corrected,
            samples=histogram.samples,
            low=low,
            high=high if has_end else None,
        )
        rows.append(row)
    return rows


def _has_testable_bin(histogram: Histogram) -> bool:
    """Return whether in some bin a density that is wrong by its own value would be seen."""
    is_expected = histogram.theory > 0.0
    relative = histogram.error[is_expected] / histogram.theory[is_expected]
    return can_differ(float(relative.min(initial=math.inf)), histogram.groups)


# -- tests -----------------------------------------------------------------------------------------
def tests_of(
    fitted: Fit, residuals: Residuals, histograms: Sequence[Histogram]
) -> list[ComparisonTest]:
    """Return one test for each average, over times, and for each density and time.

    Parameters
    ----------
    fitted : the averages at the times that a test looks at
    residuals : at all times
    histograms : of the densities
    """
    of_averages = []
    for name in fitted.measured.layout.all_names:
        chi_square = _test_over_times(fitted, name)
        if chi_square is not None:
            of_averages.append((name, chi_square))
    of_densities = []
    for histogram in histograms:
        if histogram.chi_square is not None:
            of_densities.append((histogram, histogram.chi_square))
    n_tests = len(of_averages) + len(of_densities)
    tests = []
    for name, chi_square in of_averages:
        tests.append(_average_test(residuals, name, chi_square, n_tests))
    for histogram, chi_square in of_densities:
        tests.append(_density_test(histogram, chi_square, n_tests))
    return tests


def _test_over_times(fitted: Fit, name: str) -> ChiSquare | None:
    """Return the test of one average at the times of the fit."""
    layout = fitted.measured.layout
    indices = tested_components(fitted.measured)
    of_name = indices[layout.observable[indices] == name]
    if of_name.size == 0:  # <r^2> from the first frame, which is among the pairs of frames
        of_name = layout.indices_of(name)
    return fitted.residuals.test(of_name)


def _average_test(
    residuals: Residuals, name: str, chi_square: ChiSquare, n_tests: int
) -> ComparisonTest:
    layout = residuals.measured.layout
    indices = layout.indices_of(name)
    indices = indices[residuals.is_usable[indices]]
    relative = (residuals.plain_error / layout.sizes(residuals.theory))[indices]
    groups = residuals.groups_of_error[indices]
    relative_difference = np.abs(residuals.difference / layout.sizes(residuals.theory))[indices]
    is_testable = False
    within = 0.0  # what the data exclude at every time
    rows = zip(relative_difference.tolist(), relative.tolist(), groups.tolist(), strict=True)
    for difference, error, n_groups in rows:
        is_testable |= can_differ(error, n_groups)
        within = max(within, difference + limit_factor(n_groups) * error)
    return _comparison_test(name, None, chi_square, n_tests, is_testable, within)


def _density_test(histogram: Histogram, chi_square: ChiSquare, n_tests: int) -> ComparisonTest:
    is_testable = chi_square.groups is None or _has_testable_bin(histogram)
    return _comparison_test(histogram.name, histogram.time, chi_square, n_tests, is_testable)


def _comparison_test(
    observable: str,
    time: float | None,
    chi_square: ChiSquare,
    n_tests: int,
    is_testable: bool,
    within: float | None = None,
) -> ComparisonTest:
    """Return a chi-square as one of several tests."""
    sigmas = gaussian_sigmas(min(1.0, chi_square.p_value * n_tests))
    return ComparisonTest(
        observable=observable,
        time=time,
        chi_square=chi_square.value,
        dof=chi_square.freedom,
        p_value=chi_square.p_value,
        groups=chi_square.groups,
        sigmas=sigmas,
        verdict=_verdict_on(sigmas, is_testable),
        within=within,
    )
