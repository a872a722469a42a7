"""The report on the finite density: levels of the theory, runs that remember, table and text."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from kinetics import Scene, solve
from kinetics.crosscheck.report.case import Case, Measured, Scans
from kinetics.crosscheck.report.case_rows import rows_of_case
from kinetics.crosscheck.report.density_levels import (
    DILUTE,
    FIRST,
    FITTED,
    LEADING,
    LEVELS,
    PATH,
    Prediction,
    place_predictions,
    predictions,
    solution,
)
from kinetics.crosscheck.report.density_part import (
    DensityPart,
    add_density_part,
    gather_density_part,
)
from kinetics.crosscheck.report.density_scan import MEMORIES
from kinetics.crosscheck.report.observables import contact_value
from kinetics.crosscheck.report.page import render
from kinetics.crosscheck.report.report import build_document
from kinetics.crosscheck.report.settings import ReportSettings

MakeCase = Callable[..., Case]
TIMES = np.array([500.0])


@pytest.fixture
def small(settings: ReportSettings) -> ReportSettings:
    return replace(settings, media=8, tracers=25, count=400, free_tracers=8000)


_PART: list[DensityPart] = []  # made once


def in_truth(case: Case) -> Case:
    """The made-up case with the solution of the true equation, on which ratios are based."""
    scene = Scene(0.7, 0.04, times=case.times, outputs=("thermal_speed", "a2", "msd", "kurtosis"))
    return replace(case, kinetic=solve(scene))


@pytest.fixture
def part(make_case: MakeCase, scans: Scans, small: ReportSettings) -> DensityPart:
    if not _PART:
        found = gather_density_part([in_truth(make_case())], scans, small)
        assert found is not None
        _PART.append(found)
    return _PART[0]


def msd(level: str, density: float = 0.04, scatterers: str = "hard disks") -> float:
    return float(solution(0.7, density, TIMES, ("msd",), level, scatterers).msd[0])


@pytest.mark.parametrize(("level", "order"), [(LEADING, "leading"), (FIRST, "first")])
def test_orders_are_those_of_a_scene(level: str, order: str) -> None:
    scene = Scene(
        0.7, 0.04, times=TIMES, outputs=("msd",), scatterers="hard disks", density_order=order
    )
    assert msd(level) == solve(scene, rtol=1e-6).msd[0]


def test_the_path_level_is_the_dilute_equation_with_the_contact_value() -> None:
    dense = 0.04 * contact_value(0.04)
    assert msd(PATH) == pytest.approx(msd(DILUTE, dense), rel=1e-5)
    assert msd(PATH, scatterers="overlapping") == msd(DILUTE)


@pytest.mark.parametrize("level", LEVELS)
def test_every_level_tends_to_the_dilute_equation(level: str) -> None:
    n = 1e-5
    scaled = solution(0.7, n, TIMES * 0.04 / n, ("msd",), level).msd[0] * (n / 0.04) ** 2
    assert scaled == pytest.approx(msd(DILUTE), rel=3 * n * np.log(1 / n))


def test_predictions_are_compared_with_the_disks_of_the_case(
    make_case: MakeCase, settings: ReportSettings
) -> None:
    case = make_case()
    found = {row.observable: row for row in predictions([case], settings)}
    assert list(found) == ["thermal_speed", "cooling_rate", "msd", "msd_slope", "kurtosis"]
    row = found["msd"]
    assert row.theory[DILUTE] == case.kinetic.msd[-1]
    assert row.disks.value == case.hard.msd.value[-1]
    assert row.time == 1000.0
    expected = solve(
        Scene(0.7, 0.04, times=case.times, outputs=("msd",), scatterers="hard disks")
    ).msd
    assert row.theory[FITTED] == pytest.approx(expected[-1], rel=1e-9)
    decade = np.log(case.times[-1] / case.times[case.early])
    slope = (expected[-1] - expected[case.early]) / decade
    assert found["msd_slope"].theory[FITTED] == pytest.approx(slope, rel=1e-8)
    assert found["thermal_speed"].theory[FIRST] < found["thermal_speed"].theory[DILUTE]


def test_places_of_the_disks_are_compared_with_both_equations(
    make_case: MakeCase, settings: ReportSettings
) -> None:
    case = make_case()
    (found,) = place_predictions([case], settings)
    scene = Scene(
        0.7, 0.04, times=case.times[-1:], outputs=("msd", "position_density"),
        scatterers="hard disks",
    )  # fmt: skip
    theory = solve(scene, rtol=1e-4)
    root = np.sqrt(theory.msd[0])
    widths = np.diff(case.position_edges)
    density = theory.position_fraction(case.position_edges * root)[0] / widths
    at_theory = Measured(density, case.hard.position.error)
    hard = replace(case.hard, position=at_theory)
    (same,) = place_predictions([replace(case, hard=hard)], settings)
    assert same.chi_square[FITTED] < 0.01
    assert same.chi_square[DILUTE] > 10.0
    assert found.chi_square[FITTED] > 10.0
    assert 0 < found.bins <= widths.size
    # all configurations have the same number in a bin: no error is known there
    error = case.hard.position.error.copy()
    error[np.argmax(density)] = 0.0
    few = replace(case, hard=replace(case.hard, position=Measured(density, error)))
    (rest,) = place_predictions([few], settings)
    assert rest.bins == same.bins - 1
    assert rest.chi_square[FITTED] < 0.01


def test_deviations_and_changes_are_ratios_less_one() -> None:
    theory = dict(zip(LEVELS, (100.0, 80.0, 60.0, 66.0, 63.0), strict=True))
    row = Prediction(0.7, "msd", 1.0, theory, Measured(np.asarray(66.0), np.asarray(3.0)))
    assert (row.off(LEADING).value, row.off(LEADING).error) == pytest.approx((0.1, 0.05))
    assert row.change(PATH) == pytest.approx(-0.2)
    assert row.change(FIRST) == pytest.approx(0.1)


def test_the_elastic_gas_has_no_cooling(make_case: MakeCase, settings: ReportSettings) -> None:
    found = predictions([make_case(restitution=1.0)], settings)
    assert [row.observable for row in found] == ["msd", "msd_slope", "kurtosis"]


@pytest.mark.slow
def test_runs_that_remember_more_spread_less(part: DensityPart, scans: Scans) -> None:
    scan = part.scan
    known, everything = scan.remembered, scan.all_remembered
    assert abs(known.value[0] - 1.0) < 4 * known.error[0]
    assert known.error[0] < 0.06
    assert known.value[-1] < known.value[0]
    # one seed: from 10 collisions on hardly any tracer goes another way
    assert abs(known.value[-1] - everything.value) < known.error[-1]
    points = scan.points["overlapping"]
    assert np.all(abs(points.value - scan.curves["overlapping"][FITTED][-1]) < 6 * points.error)
    np.testing.assert_array_equal(
        scan.points["hard disks"].value, scans.density.ratios["msd"].value
    )
    assert known.value.size == len(MEMORIES)


def test_curves_are_ratios_at_the_same_time_in_free_flights(
    make_case: MakeCase, part: DensityPart
) -> None:
    case, scan = in_truth(make_case()), part.scan
    hard = scan.curves["hard disks"]
    for k, n in ((3, 0.02), (-1, 0.04)):
        assert scan.grid[k] == pytest.approx(n)
        later = case.times[-1:] * 0.04 / n
        sparse = solution(0.7, n, later, ("msd",), LEADING).msd[0] * (n / 0.04) ** 2
        assert hard[LEADING][k] == pytest.approx(sparse / case.kinetic.msd[-1], rel=1e-5)
    assert np.all(np.diff(hard[PATH]) < 0)
    assert PATH not in scan.curves["overlapping"]


def test_the_page_has_every_level_and_the_figures(
    make_case: MakeCase, scans: Scans, small: ReportSettings, part: DensityPart
) -> None:
    case = make_case()
    plain = build_document(small, [case], scans, rows_of_case(case, small), [])
    document = add_density_part(plain, part, [in_truth(case)])
    shown = ("finite-density", "memory")
    page = render(document | {"figures": {name: document["figures"][name] for name in shown}})
    assert 'id="finite-density"' in page
    assert all(f'scope="col">{level}</th>' in page for level in LEVELS)
    assert tuple(document["figures"])[-2:] == shown
    assert all(f'id="figure-{name}"' in page for name in shown)
    row = next(r for r in document["finite_density"]["rows"] if r["observable"] == "msd")
    off = 100 * row["off"][FITTED]["value"]
    assert f"which leaves {off:+.1f} ±" in document["finite_density"]["text"][0]
    assert document["finite_density"]["text"][-1].startswith("e = 0.7: G(R) of hard disks at t =")
    assert "30 l/U" not in " ".join(document["finite_density"]["text"])


def test_times_before_the_returns_have_built_up_are_said(
    make_case: MakeCase, part: DensityPart
) -> None:
    case = in_truth(make_case())
    early: Any = replace(case, times=case.times / 10)
    text = add_density_part({"figures": {}}, part, [early])["finite_density"]["text"]
    assert any(line.startswith("At e = 0.7 the last time is before 30 l/U") for line in text)


def test_a_density_outside_the_theory_has_no_such_part(
    make_case: MakeCase, scans: Scans, small: ReportSettings
) -> None:
    crowded = replace(small, number_density=0.4)
    assert gather_density_part([make_case()], scans, crowded) is None
    case = make_case()
    document = build_document(small, [case], scans, rows_of_case(case, small), [])
    assert add_density_part(document, None, [case]) is document
    assert 'id="finite-density"' not in render(document | {"figures": {}})
