"""Comparisons of a made-up case whose truth is known."""

import json
import math
from collections.abc import Callable
from dataclasses import asdict, replace

import numpy as np
import pytest

from kinetics import sonine
from kinetics.crosscheck.report.case import Case
from kinetics.crosscheck.report.case_rows import LEAST_EXPECTED, rows_of_case
from kinetics.crosscheck.report.observables import (
    bin_average,
    contact_value,
    cooling_rate_between,
    printed_msd_slopes,
)
from kinetics.crosscheck.report.row import OBSERVABLES, PAPER_FIT, RESCALED
from kinetics.crosscheck.report.settings import ReportSettings
from kinetics.crosscheck.strict_json import dumps

NOT_THE_TRUTH = ("1/(2dρ₀g)", PAPER_FIT)
MakeCase = Callable[..., Case]


def test_runs_that_follow_the_theory_agree(make_case: MakeCase, settings: ReportSettings) -> None:
    rows = [row for row in rows_of_case(make_case(), settings) if row.kind == "statistical"]
    # hard disks in 12.5 d do differ from Henderson's 11.9 d, and h = 0.4 from 1.45 (1 - e)
    other = [row for row in rows if row.against in NOT_THE_TRUTH]
    assert {row.verdict for row in other} == {"differs"}
    assert {row.verdict for row in rows if row not in other} == {"agrees"}
    assert {row.observable for row in rows} == set(OBSERVABLES)


@pytest.mark.parametrize("source", ["Boltzmann-Grad", "hard disks"])
def test_a_run_off_by_eight_sigma_differs_and_the_other_does_not(
    make_case: MakeCase, settings: ReportSettings, source: str
) -> None:
    case = make_case(8.0, 0.5) if source == "Boltzmann-Grad" else make_case(0.5, 8.0)
    for row in rows_of_case(case, settings):
        if row.kind != "statistical" or row.against in NOT_THE_TRUTH:
            continue
        assert row.verdict == ("differs" if row.source == source else "agrees"), row
        assert row.sigmas == pytest.approx(8.0 if row.source == source else 0.5)


def test_the_row_shows_its_worst_time(make_case: MakeCase, settings: ReportSettings) -> None:
    case = make_case()
    speed = case.free.thermal_speed
    value = speed.value.copy()
    value[3] -= 9 * speed.error[3]
    case = replace(case, free=replace(case.free, thermal_speed=replace(speed, value=value)))
    row = next(
        r
        for r in rows_of_case(case, settings)
        if r.observable == "thermal_speed" and r.source == "Boltzmann-Grad"
    )
    assert row.time == pytest.approx(case.times[3])
    assert row.sigmas == pytest.approx(-8.5)
    assert row.looks == case.times.size


def test_deviations_of_a2_are_relative_to_the_fourth_moment(
    make_case: MakeCase, settings: ReportSettings
) -> None:
    row = next(
        r
        for r in rows_of_case(make_case(2.0), settings)
        if r.observable == "a2" and r.source == "Boltzmann-Grad"
    )
    # a2 = 0.1 and two errors of 1 % of it
    assert row.deviation == pytest.approx(2 * 0.001 / 1.1)


def test_bins_with_few_samples_are_not_judged(
    make_case: MakeCase, settings: ReportSettings
) -> None:
    case = make_case()
    row = next(
        r
        for r in rows_of_case(case, settings)
        if r.observable == "scaled_vdf" and r.source == "Boltzmann-Grad"
    )
    probability = np.exp(-(case.speed_edges[:-1] ** 2)) - np.exp(-(case.speed_edges[1:] ** 2))
    assert row.looks == np.sum(10_000 * probability >= LEAST_EXPECTED)
    assert 0 < row.looks < len(probability)


def test_the_rescaled_comparison_uses_its_own_errors(
    make_case: MakeCase, settings: ReportSettings
) -> None:
    case = make_case()
    case = replace(case, rescaled_errors={name: 10 * e for name, e in case.rescaled_errors.items()})
    row = next(
        r for r in rows_of_case(case, settings) if r.observable == "msd" and r.against == RESCALED
    )
    assert row.sigmas == pytest.approx(0.05)


def test_the_elastic_case_has_no_scaling_rows(
    make_case: MakeCase, settings: ReportSettings
) -> None:
    rows = rows_of_case(make_case(restitution=1.0), settings)
    assert {row.observable for row in rows} == set(OBSERVABLES) - {
        "cooling_rate",
        "scaled_vdf",
        "msd_slope",
    }
    json.loads(dumps([asdict(row) for row in rows]))


def test_an_approximation_without_a_value_is_undefined(
    make_case: MakeCase, settings: ReportSettings
) -> None:
    rows = rows_of_case(make_case(restitution=0.4), settings)
    sonine = [row for row in rows if row.source == "Sonine"]
    assert {row.observable for row in sonine} == {"cooling_rate", "a2", "msd", "msd_slope"}
    assert {row.verdict for row in sonine} == {"undefined"}
    assert json.loads(dumps(asdict(sonine[0])))["value"] is None


def test_an_inexact_solver_differs(make_case: MakeCase, settings: ReportSettings) -> None:
    case = make_case()
    assert case.scaled is not None
    case.scaled.cooling_rate *= 1 + 1e-9  # type: ignore[misc]
    case = replace(case, exact=make_case().exact)
    row = next(
        r
        for r in rows_of_case(case, settings)
        if r.kind == "numerical" and r.observable == "cooling_rate"
    )
    assert row.verdict == "differs"
    assert row.deviation == pytest.approx(1e-9, rel=1e-4)


def test_the_bin_average_of_a_gaussian_is_exact() -> None:
    edges = np.array([0.0, 0.1, 0.25, 0.5, 0.75])
    exact = -np.diff(np.exp(-(edges**2))) / (math.pi * np.diff(edges**2))
    np.testing.assert_allclose(
        bin_average(lambda c: np.exp(-(c**2)) / math.pi, edges), exact, rtol=1e-13
    )


def test_the_slope_of_the_printed_cooling_law_is_its_rate() -> None:
    t = np.array([1.0, 10.0, 200.0])
    v = 1 / (0.7 + 0.04 * 0.435 * t)
    assert cooling_rate_between(t, v, 1, 0.04) == pytest.approx(0.435, rel=1e-12)


def test_the_late_slopes_of_the_printed_formulas_are_their_limits() -> None:
    # l^2/ln(1 + l beta) of the random walk, and the factor of the logarithm of eq. ad8
    e, density = 0.7, 0.04
    walk, printed = printed_msd_slopes(e, density)
    assert walk == pytest.approx(13.5**2 / math.log(1 + 13.5 * 1.45 * 0.3 * density), rel=1e-13)
    late = [float(sonine.msd_sonine(t, e, density)) for t in (1e100, math.e * 1e100)]
    assert printed == pytest.approx(late[1] - late[0], rel=1e-11)
    assert math.isnan(printed_msd_slopes(0.4, density)[1])


def test_hard_disks_are_met_five_percent_sooner_at_the_papers_density() -> None:
    assert contact_value(0.04) == pytest.approx(1.0512, abs=1e-4)
    assert contact_value(1e-9) == pytest.approx(1.0)
