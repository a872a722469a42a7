"""The problems of the benchmark: its other methods are right, and errors are what was put in."""

import itertools
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from kinetics import ScalingSolution, Scene, solve
from kinetics.crosscheck import references
from kinetics.crosscheck.bench import (
    accuracy,
    cost,
    methods,
    position,
    precision,
    skipping,
    straightforward,
    throughput,
)
from kinetics.crosscheck.bench.measuring import FULL, QUICK, Effort, measure
from kinetics.crosscheck.bench.record import MEASURED
from kinetics.crosscheck.bench.report import BenchReport

E = 0.7
ONCE = Effort(quick=True, least=1, most=1, seconds=0.0, least_seeded=5)
R = position.RADII


# -- methods that are only here --------------------------------------------------------------------


def fitted_order(nodes: list[int], errors: list[float]) -> float:
    return -float(np.polyfit(np.log(nodes), np.log(errors), 1)[0])


@pytest.mark.parametrize("e", [0.0, 0.7])
def test_the_straightforward_scaled_solver_is_of_second_order(e: float) -> None:
    nodes = [101, 151, 201, 301, 401]
    exact = ScalingSolution(e)
    found = [straightforward.solve_scaled(e, n, 40.0) for n in nodes]
    errors = [abs(s.cooling_rate / exact.cooling_rate - 1.0) for s in found]
    assert fitted_order(nodes, errors) == pytest.approx(2.0, abs=0.3)
    c = precision.SCALED_SPEEDS
    assert np.max(np.abs(found[-1].vdf(c) - exact.vdf(c))) < 0.08 * exact.vdf(c).max()


@pytest.mark.parametrize("start", references.STARTS)
def test_straightforward_cooling_converges_to_the_references(start: str) -> None:
    nodes = [33, 49, 65, 97, 129]
    times = references.times("short")
    exact = references.kept("thermal_speed", E, start, "short")
    errors = [
        precision.relative(
            straightforward.solve_cooling(E, references.MEAN_FREE_PATH, start, times, n, 1e-8)[0],
            exact,
        )
        for n in nodes
    ]
    # second order for the smooth start, whose finest error is bounded too
    assert fitted_order(nodes, errors) > (1.7 if start == "gaussian" else 0.8)
    assert errors[-1] < 2e-3


def test_sonine_cooling_gets_better_up_to_order_eight_from_a_gaussian() -> None:
    times = references.times("short")
    exact = references.kept("thermal_speed", E, "gaussian", "short")
    errors = [
        precision.relative(methods.sonine_cooling(E, "gaussian", times, order)[0], exact)
        for order in (1, 2, 4, 8)
    ]
    assert all(b < 0.7 * a for a, b in itertools.pairwise(errors))
    assert errors[-1] < 2e-3


@pytest.mark.slow
def test_all_five_methods_are_measured_on_the_scaled_equation() -> None:
    works = precision.scaled_works(E, ONCE)
    for problem in ("scaled F(c), e = 0.7", "scaled h and a2, e = 0.7"):
        here = [w for w in works if w.problem == problem]
        assert list(dict.fromkeys(w.method for w in here)) == list(methods.METHODS[:5])
        for method in methods.METHODS[:5]:
            work = [w for w in here if w.method == method][2]
            error = work.error(work.call(1) if work.seeded else work.call())
            assert error < 1.0, (problem, method)


# -- error measures --------------------------------------------------------------------------------


def test_the_error_of_a_speed_histogram_is_what_was_put_in() -> None:
    exact = ScalingSolution(E)
    edges = np.geomspace(0.05, 6.0, 90)
    v0 = 0.3
    fine = np.linspace(edges[:-1], edges[1:], 41, axis=1)
    share = np.trapezoid(2 * np.pi * fine * exact.vdf(fine), fine, axis=1)

    def made_up_run(probability: Any) -> Any:
        histogram = SimpleNamespace(
            edges=edges * v0, probability=SimpleNamespace(value=probability[None])
        )
        return SimpleNamespace(
            speed_histogram=histogram, thermal_speed=SimpleNamespace(value=np.array([v0]))
        )

    assert precision.vdf_error(made_up_run(share), exact.vdf) < 1e-3
    largest = exact.vdf(precision.SCALED_SPEEDS).max()
    k = int(np.argmin(np.abs(edges - 1.0)))
    area = np.pi * (edges[k + 1] ** 2 - edges[k] ** 2)
    wrong = share + 0.1 * largest * area * (np.arange(share.size) == k)
    found = precision.vdf_error(made_up_run(wrong), exact.vdf)
    assert found == pytest.approx(0.1, rel=1e-2)


def made_up(scale: float = 1.0) -> position.DensityReference:
    """A reference whose G is 2 R exp(-R^2), times a scale; <r^2> = 9 d^2."""
    return position.DensityReference(
        SimpleNamespace(
            msd=np.array([9.0]),
            scaled_position_density=lambda x: scale * 2 * x * np.exp(-(x**2))[None],
            position_fraction=lambda edges: -scale * np.diff(np.exp(-((edges / 3) ** 2)))[None],
        ),
        kurtosis=2.0,
        rtol=1e-8,
    )


def test_the_errors_of_a_position_density_are_what_was_put_in() -> None:
    exact = made_up().curve(R)
    wrong = exact + 0.01 * exact.max() * (np.arange(R.size) == 150)
    assert made_up().error(exact) == 0.0
    assert made_up().error(wrong) == pytest.approx(0.01, rel=1e-9)
    # the run's own <r^2> scales its histogram: 16 d^2, where the same curve is wider
    edges = np.geomspace(0.01, 40.0, 120)
    share = -np.diff(np.exp(-((edges / 4) ** 2)))

    def run(probability: Any) -> Any:
        return SimpleNamespace(
            displacement_histogram=SimpleNamespace(
                edges=edges, probability=SimpleNamespace(value=probability[None])
            ),
            msd=SimpleNamespace(value=np.array([16.0])),
        )

    assert made_up().histogram_error(run(share)) < 1e-12
    k = int(np.argmin(np.abs(edges - 4.0)))
    largest = made_up().curve(R).max()
    wrong = share + 0.1 * largest * (edges[k + 1] - edges[k]) / 4 * (np.arange(119) == k)
    assert made_up().histogram_error(run(wrong)) == pytest.approx(0.1, rel=1e-9)


def test_the_moments_that_a_reference_misses() -> None:
    names = ("norm", "second", "fourth")
    assert made_up().moments_missed() == pytest.approx(dict.fromkeys(names, 0.0), abs=1e-12)
    found = made_up(1.01).moments_missed()
    assert found == pytest.approx(dict.fromkeys(names, 0.01), rel=1e-9)


@pytest.mark.slow
def test_rows_of_the_distribution() -> None:
    kept = position.density_reference(0.9, 1000.0, 1e-7)
    works = position.distribution(0.9, 1000.0, kept, ONCE)
    reference = kept.record(works[0].problem)
    rows = [reference, *measure(works, ONCE)]
    assert reference.error < 1e-5
    assert reference.seconds is None
    spectral = [r for r in rows if r.method == methods.SPECTRAL]
    assert [r.asked for r in spectral] == [1e-2, 1e-4, 1e-5]
    assert all(r.error <= r.asked for r in spectral)
    # 25 times as many samples: 5 times less, within the scatter of a largest error
    errors = [r.error for r in rows if r.method == methods.MONTE_CARLO]
    assert 2.5 < errors[0] / errors[-1] < 10.0
    printed = {r.setting: r.error for r in rows if r.method == methods.PRINTED}
    # the Gaussian is near at this pair, the Bessel function is not
    assert printed["eq. peakg, eta = 0.75"] < 0.3 < printed["eq. gdefi, eta = 1/2"]
    report = BenchReport(tuple(rows), True, ("position",), {"processor": "x"}, 1.0)
    text = report.markdown()
    assert f"- Reference of {reference.problem}, rtol = 1e-07: integrals of 1, R^2 and R^4" in text
    assert f"- {reference.problem}, eq. peakg, eta = 0.75: " in text
    assert "| as printed | - | - | - | - |" in text


@pytest.mark.parametrize("start", references.STARTS)
@pytest.mark.parametrize("e", references.RESTITUTIONS)
def test_the_kept_kurtosis_and_the_solver_agree(e: float, start: str) -> None:
    times = references.times("short")
    found = solve(Scene(e, initial=start, times=times, outputs=("kurtosis",)), rtol=1e-13)
    np.testing.assert_allclose(
        found.kurtosis, references.kept("kurtosis", e, start, "short"), rtol=5e-13
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", methods.OTHER_LAWS)
def test_other_laws_have_rows_with_their_own_references(name: str) -> None:
    law = methods.OTHER_LAWS[name]
    problems = accuracy._scaled(E, name, **law) | accuracy._late(E, name, **law)
    assert all(problem.endswith(f", {name}, e = 0.7") for problem in problems)
    for problem, run in problems.items():
        row = accuracy._row(problem, run, 1e-6)
        assert row.status == MEASURED
        assert row.error <= 1e-6, problem
    # smooth disks have another h and a2, by a sixth and more
    works = precision.scaled_works_of(name, ONCE)
    for method, bound in ((methods.SPECTRAL, 1e-2), (methods.MONTE_CARLO, 0.1)):
        work = next(w for w in works if w.method == method)
        assert work.error(work.call(1) if work.seeded else work.call()) < bound


# -- cost, skipping, particles ---------------------------------------------------------------------


@pytest.mark.slow
def test_cost_and_skipping_have_rows_of_the_displacement() -> None:
    rows = measure(cost.works(cost.displacements(), ONCE), ONCE)
    settings = {(r.problem, r.setting) for r in rows}
    assert {("G(R)", "times"), ("F(k)", "wave numbers")} <= settings
    assert all(r.status == MEASURED for r in rows)
    assert {r.setting for r in cost.exponents(rows)} >= {"times, exponent"}
    outputs = (*skipping.MOMENTS, skipping.DENSITY)
    parts = skipping._outputs(outputs, (skipping.DENSITY,), times=[300.0], rtol=1e-4)
    rows = skipping.ratios({"displacement": parts}, ONCE)
    together = {r.method: r.extra["ratio"] for r in rows}
    assert together["everything"] == 1.0
    assert together["msd alone"] > 2.0
    assert {"position_density alone", "all but position_density"} <= set(together)


@pytest.mark.parametrize("effort", [QUICK, FULL])
def test_no_medium_is_measured_twice(effort: Effort) -> None:
    found = [name for name, _ in throughput.media(effort)]
    assert len(found) == len(set(found))
    assert {medium.dimension for _, medium in throughput.media(effort)} == {2, 3}
