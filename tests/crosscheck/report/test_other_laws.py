"""A report of spheres that rub: small runs against the solver, and nothing of the paper in it."""

import json
import math
from typing import Any

import numpy as np
import pytest

from kinetics import InputError
from kinetics.crosscheck.report import observables
from kinetics.crosscheck.report.case import Case
from kinetics.crosscheck.report.case_rows import rows_of_case
from kinetics.crosscheck.report.dimensions import both_dimensions
from kinetics.crosscheck.report.page import dimension_table, render, verdict_table
from kinetics.crosscheck.report.report import build_document
from kinetics.crosscheck.report.row import Row
from kinetics.crosscheck.report.run_methods import gather_case
from kinetics.crosscheck.report.settings import ReportSettings
from kinetics.crosscheck.strict_json import dumps, plain

SETTINGS = ReportSettings(
    restitutions=(0.7,), final_times=(100.0,), tangential_restitution=0.8, dimension=3, count=300,
    media=10, tracers=20, free_tracers=10_000, n_times=5, position_rtol=1e-4, workers=1,
)  # fmt: skip


@pytest.fixture(scope="module")
def case() -> Case:
    return gather_case(0.7, 100.0, SETTINGS, lambda stage: None)


@pytest.fixture(scope="module")
def rows(case: Case) -> list[Row]:
    return rows_of_case(case, SETTINGS)


@pytest.fixture(scope="module")
def document(case: Case, rows: list[Row]) -> dict[str, Any]:
    beside = both_dimensions([case], SETTINGS, lambda stage: None)
    document = build_document(SETTINGS, [case], None, rows, [])
    return document | plain({"dimensions": beside})


@pytest.mark.slow
def test_solver_and_particles_agree_and_no_printed_formula_is_compared(rows: list[Row]) -> None:
    assert {row.kind for row in rows} == {"numerical", "statistical"}
    strict = [row for row in rows if row.source in ("solver", "Boltzmann-Grad")]
    assert {row.verdict for row in strict} == {"agrees"}, strict
    assert {row.observable for row in strict} >= {"free_path", "scaled_vdf", "position"}
    assert {row.source for row in rows} == {"solver", "Boltzmann-Grad", "hard spheres"}


def test_figures_have_no_line_of_the_paper_and_the_gaussian_of_space(
    document: dict[str, Any],
) -> None:
    figures = document["figures"]
    assert list(figures)[:2] == ["position", "vdf"]
    lines = [line for data in figures.values() for line in data["series"]]
    assert not [s["source"] for s in lines if "paper" in s["source"] or "Sonine" in s["source"]]
    words = " ".join(data["title"] + data["description"] for data in figures.values())
    assert "paper" not in words
    assert "disk" not in words
    (gaussian,) = [s for s in figures["kurtosis"]["series"] if s["source"] == "Gaussian"]
    assert gaussian["y"] == pytest.approx([5 / 3, 5 / 3])
    (start,) = {s["y"][0] for s in figures["approach"]["series"] if s["source"] == "exact limit"}
    assert start == pytest.approx(document["cases"][0]["scaled"]["a2"]["exact"])


@pytest.fixture(scope="module")
def page(document: dict[str, Any]) -> str:
    return render(document)


def test_the_page_speaks_of_spheres(document: dict[str, Any], page: str) -> None:
    assert "tangential restitution 0.8" in document["summary"]
    assert "per d³" in document["summary"]
    assert "√3 U" in document["units"]
    assert "hard disks" not in page
    assert "G(R)/R² ~" in page
    assert "spheres / equation" in verdict_table(document)
    assert json.loads(dumps(document))["settings"]["dimension"] == 3


def test_disks_stand_beside_spheres(document: dict[str, Any], page: str) -> None:
    found = {(row["observable"], row["scatterers"]): row for row in document["dimensions"]}
    assert found["cooling_rate", "spheres"]["exact"] == pytest.approx(0.534477, abs=1e-6)
    assert found["cooling_rate", "disks"]["exact"] == pytest.approx(0.573844, abs=1e-6)
    for row in document["dimensions"]:
        if row["solver"] is not None:
            assert row["solver"] == pytest.approx(row["exact"], rel=1e-10)
        assert abs(row["value"] - row["equation"]) < 5 * row["error"], row
    assert len(found) == 12
    table = dimension_table(document)
    assert "0.534477" in table
    assert page.count('<td class="number">0.534477</td>') >= 2


def test_settings_of_another_law() -> None:
    assert SETTINGS.half_rate == pytest.approx(0.5 * math.pi * 0.04)
    assert "dimension" not in ReportSettings().described()
    assert SETTINGS.described()["tangential_restitution"] == 0.8
    for wrong in ({"dimension": 4}, {"tangential_restitution": 1.2}):
        with pytest.raises(InputError, match=next(iter(wrong))):
            ReportSettings(**wrong)  # type: ignore[arg-type]


def test_a_gaussian_in_space_is_reduced_to_itself() -> None:
    rng = np.random.default_rng(4)
    samples = np.linalg.norm(rng.normal(0, 7.0, (100, 4000, 3)), axis=-1)
    edges = np.array([0.0, 0.4, 0.8, 1.2, 2.0])
    measure = observables.ball(3) * np.diff(edges**3)
    found = observables.scaled_density(samples, edges, measure)
    exact = observables.bin_average(lambda c: observables.gaussian_vdf(c, 3), edges, 3)
    assert np.all(np.abs(found.value - exact) < 5 * found.error)
    assert np.sum(exact * measure) == pytest.approx(1.0, abs=0.01)
    bands = observables.BANDS
    flat = observables.bin_average(lambda c: observables.gaussian_vdf(c, 3), bands, 3)
    shares = flat * observables.ball(3) * np.diff(bands**3)
    exponent = observables.measured_exponent(samples, 3)
    sure = exponent.error < 0.1
    off = exponent.value - observables.band_exponent(shares, 3)
    assert np.count_nonzero(sure) >= 3
    assert np.all(np.abs(off[sure]) < 5 * exponent.error[sure])
    # narrow bands would have exactly 2: these are off where p changes within the first of them
    assert np.all(np.abs(observables.band_exponent(shares, 3) - 2) < 0.3)
    assert observables.contact_value(0.04, dimension=3) == pytest.approx(1.05441, abs=1e-5)
