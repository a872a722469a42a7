"""The report in a uniform field: what is compared with what, and the page."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from marking import slow_but
from pages import check_alone, check_in_browser

from kinetics import CollisionLaw, solve_field
from kinetics.crosscheck.report.case import Measured
from kinetics.crosscheck.report.field_density import density_case
from kinetics.crosscheck.report.field_limits import (
    dispersion_near_elastic,
    drift_constant,
    drift_near_elastic,
)
from kinetics.crosscheck.report.field_page import render_field, text
from kinetics.crosscheck.report.field_report import build_document, make_report, stages
from kinetics.crosscheck.report.field_rows import OBSERVABLES, all_rows
from kinetics.crosscheck.report.field_runs import (
    ApproachCase,
    SteadyCase,
    approach_case,
    solver_line,
    steady_case,
    steady_values,
)
from kinetics.crosscheck.report.field_settings import FieldSettings
from kinetics.crosscheck.report.picture import picture_in_field
from kinetics.crosscheck.strict_json import dumps
from kinetics.crosscheck.verdicts import Verdict

SETTINGS = FieldSettings(
    restitutions=(0.9,),
    approach=(0.5,),
    line=(0.0, 0.5, 0.99),
    densities=(0.02, 0.04, 0.08),
    dense=(0.7,),
    configurations=20,
    tracers=5,
    collisions=50_000,
    groups=20,
    rtol=1e-5,
    time_rtol=1e-3,
    workers=1,
)
Cases = tuple[list[SteadyCase], list[ApproachCase]]


@pytest.fixture(scope="module")
def cases() -> Cases:
    steady = [steady_case(0.9, d, SETTINGS) for d in (2, 3)]
    return steady, [approach_case(0.5, 2, SETTINGS)]


@pytest.fixture(scope="module")
def document(cases: Cases) -> dict[str, Any]:
    lines = [solver_line(d, SETTINGS) for d in (2, 3)]
    dense = [density_case(0.7, SETTINGS)]
    return build_document(SETTINGS, lines, *cases, dense) | {"picture": picture_in_field(1)}


@pytest.fixture(scope="module")
def page(document: dict[str, Any]) -> str:
    return render_field(document)


def test_the_limiting_laws_are_those_of_the_solver() -> None:
    assert drift_constant(2) == pytest.approx(0.52666478, abs=1e-8)
    assert drift_constant(3) == pytest.approx(0.63452714, abs=1e-8)
    e = 1.0 - 1e-8
    for d in (2, 3):
        state = solve_field(e, d, rtol=1e-6)
        along, across = dispersion_near_elastic(e, d)
        assert drift_near_elastic(e, d) == pytest.approx(state.drift, rel=1e-3)
        assert along == pytest.approx(state.diffusion_parallel, rel=1e-3)
        assert across == pytest.approx(state.diffusion_perpendicular, rel=1e-3)


def test_averages_of_a_made_up_run() -> None:
    # Tracers of constant velocity, so that every average is known; groups differ by `each`.
    groups, tracers, times = 4, 3, np.array([1.0, 2.0, 5.0])
    each = np.array([0.9, 1.0, 1.0, 1.1])
    v = np.zeros((3, groups, tracers, 2))
    v[..., 0], v[..., 1] = 0.6 * each[:, None], 0.8 * each[:, None]
    r = v * times[:, None, None, None]
    run = SimpleNamespace(
        times=times, media=groups, tracers=tracers,
        velocities=v.reshape(3, -1, 2), positions=r.reshape(3, -1, 2),
    )  # fmt: skip
    law = CollisionLaw(0.5)
    found = steady_values(run, law)  # type: ignore[arg-type]
    spread = each.std(ddof=1) / 2  # of the mean of the groups
    assert found["drift"].value == pytest.approx(0.6)
    assert found["drift"].error == pytest.approx(0.6 * spread)
    assert found["mean_speed"].error == pytest.approx(spread)
    square = np.mean(each**2)
    assert found["mean_square_speed"].value == pytest.approx(square)
    assert found["mean_square_along"].value == pytest.approx(0.36 * square)
    assert found["momentum"].value == pytest.approx(0.6 * square)
    # variances over all tracers: along (0.6 t)^2 var(each), across about the mean 0
    assert found["diffusion_parallel"].value == pytest.approx(0.36 * 24 * 0.005 / 8)
    assert found["diffusion_perpendicular"].value == pytest.approx(0.64 * 24 * square / 8)
    cube = np.mean(each**3) * float(law.decay_rate(2.0)) / (2 * 0.6)
    assert found["energy"].value == pytest.approx(cube)
    assert found["direction"].value == pytest.approx(0.6 / square / float(law.decay_rate(1.0)))


def test_particles_and_solver_agree(cases: Cases) -> None:
    rows = all_rows(*cases)
    assert {item.row.observable for item in rows} == set(OBSERVABLES) - {"drift_among_disks"}
    assert [row.kind for item in rows if (row := item.row).verdict is Verdict.DIFFERS] == []
    exact = [item.row for item in rows if item.row.kind == "numerical"]
    assert len(exact) == 12  # six relations, disks and spheres
    assert all(abs(row.deviation) < 1e-5 for row in exact)
    # the relation of the momentum is in closed form
    assert {row.theory for row in exact if row.observable == "momentum"} == {1.5 / 1.9, 2.0 / 1.9}
    assert max(row.looks for item in rows if (row := item.row)) == 33  # times from rest


def test_a_wrong_drift_is_seen(cases: Cases) -> None:
    steady, approach = cases
    right = steady[0].values["drift"]
    wrong = Measured(right.value + 6 * right.error, right.error)
    changed = replace(steady[0], values={**steady[0].values, "drift": wrong})
    drifts = [
        item.row.verdict
        for item in all_rows([changed], approach)
        if item.row.observable == "drift" and item.row.kind == "statistical"
    ]
    assert drifts == [Verdict.DIFFERS]
    late = replace(approach[0], drift=1.2 * approach[0].drift)
    (row,) = (r.row for r in all_rows([], [late]) if r.row.observable == "drift_from_rest")
    assert row.verdict is Verdict.DIFFERS


def test_the_document_is_strict_json_with_every_number(
    document: dict[str, Any], cases: Cases
) -> None:
    assert json.loads(dumps(document)) == document
    assert document["schema"] == "inelastic-lorentz/field-report/1"
    assert len(document["rows"]) == len(all_rows(*cases)) + 1  # and that of hard disks
    assert 4 <= len(document["findings"]) <= 6
    dense = document["dense"][0]
    assert 0.5 < dense["drift"]["value"][-1] < 1.0
    assert dense["trapped"]["value"][-1][-1] > dense["trapped"]["value"][0][-1]
    assert "0.5267 · (1−e²)^(1/4) √(gl) among disks" in document["findings"][1]
    drawn = document["figures"]["drift"]
    assert len(drawn["ratio"]["series"]) == 3  # of disks and spheres, and 1
    limits = [line for line in drawn["series"] if line["source"] == "limiting law"]
    # of each dimension the law of e -> 1, which begins with its constant, and the value at e = 0
    assert [line["y"][0] for line in limits] == pytest.approx(
        [0.52666478, 0.985849365, 0.63452714, 1.14674025], abs=1e-5
    )
    points = [line for line in drawn["series"] if line["source"] == "particles"]
    assert [line["group"] for line in points] == ["disks", "spheres"]
    assert all(line["x"] == [0.9] and line["error"][0] > 0 for line in points)


def test_the_page_needs_nothing_beside_it_and_hides_no_figure(
    document: dict[str, Any], page: str
) -> None:
    every = document["figures"] | {"picture": document["picture"]}
    check_alone(page, len(every))
    assert len(every) == 9
    for name, data in every.items():
        assert f'aria-labelledby="fig-{name}-title fig-{name}-desc"' in page
        assert data["description"][:40] in page
    assert page.count('class="verdict agrees"') > 20


def test_the_printed_table_has_a_line_for_each_comparison(document: dict[str, Any]) -> None:
    table = text(document).splitlines()
    assert {"disks", "spheres"} <= {line.split()[0] for line in table if line}
    law = [line for line in table if "limit e → 1 / solver" in line]
    assert law[0].split("solver")[1].split() == ["1", "off", "by", "−3.5", "%", "e", "=", "0.9"]
    assert max(len(line) for line in table) <= 100
    assert not [line for line in table if "agree" in line]


@pytest.mark.parametrize("width", slow_but([390], [390, 1400]))
def test_nothing_but_tables_scrolls_sideways(
    page: str, browser: Any, tmp_path: Path, width: int
) -> None:
    path = tmp_path / "field.html"
    path.write_text(page, encoding="utf-8")
    check_in_browser(browser, path, 9, width)


def test_the_command_writes_both_files(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, lorentz: Any
) -> None:
    def tiny(settings: FieldSettings) -> FieldSettings:
        return replace(
            settings, line=(0.0, 0.9), approach=(), collisions=20_000, groups=10, rtol=1e-4
        )

    monkeypatch.setattr(FieldSettings, "quick", tiny)
    arguments = ["--field", "--quick", "-e", "0.6", "--dimension", "3", "--figures", "png"]
    printed = lorentz("report", *arguments, "-o", str(tmp_path))
    assert "\nspheres  " in printed
    assert {path.name for path in tmp_path.iterdir()} == {
        "field.html", "field.json", "field-drift.png", "field-dispersion-spheres.png",
    }  # fmt: skip
    settings = json.loads((tmp_path / "field.json").read_text(encoding="utf-8"))["settings"]
    assert (settings["restitutions"], settings["dimensions"]) == ([0.6], [3])


def test_every_stage_is_told() -> None:
    settings = replace(
        SETTINGS,
        dimensions=(2,),
        restitutions=(0.5,),
        approach=(),
        line=(0.0,),
        collisions=2_000,
        dense=(),
    )
    told: list[str] = []
    make_report(settings, told.append)
    assert len(told) == stages(settings) - 1  # and one more when the files are written


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("-e", "1"), "restitutions"),
        (("-e", "0.5", "-e", "0.5"), "only once"),
        (("--dimension", "4"), "dimension"),
        (("--count", "50"), "--count"),
        (("--number-density", "0.1"), "--number-density"),
        (("-t", "5"), "--until"),
    ],
)
def test_refusals(arguments: tuple[str, ...], named: str, lorentz: Any, tmp_path: Path) -> None:
    output = str(tmp_path / "out")
    assert named in lorentz.refused("report", "--field", *arguments, "-o", output)
    assert not (tmp_path / "out").exists()
