"""The benchmark of the displacement: its references, its error measures, its rows and figures."""

from types import SimpleNamespace

import numpy as np
import pytest

from kinetics import Scene, solve
from kinetics.crosscheck.bench import BenchReport, cost, methods, position, references, skipping
from kinetics.crosscheck.bench.record import MEASURED, NOT_AVAILABLE
from kinetics.crosscheck.bench.sweeps import run_sweeps
from kinetics.crosscheck.bench.timing import Effort

ONCE = Effort(quick=True, least=1, most=1, seconds=0.0)
R = position.RADII


@pytest.mark.parametrize("start", references.STARTS)
@pytest.mark.parametrize("e", [0.0, 0.7])
def test_kept_kurtosis_is_the_power_series(e, start):
    k = 20
    t = references.times("short")[k]
    fourth = references.quartic_displacement(e, start, t)
    second = references.square_displacement(e, start, t)
    kept = references.reference("kurtosis", e, start, "short")
    assert kept[k] == pytest.approx(float(fourth / second**2), rel=1e-15)
    # ballistic at first: <v^4>/<v^2>^2, and bounces add terms of the order of v t/l = 0.01
    assert kept[0] == pytest.approx(2.0 if start == "gaussian" else 1.0, rel=0.03)


@pytest.mark.parametrize("start", references.STARTS)
@pytest.mark.parametrize("e", references.RESTITUTIONS)
def test_kept_kurtosis_and_the_solver_agree(e, start):
    times = references.times("short")
    found = solve(Scene(e, initial=start, times=times, outputs=("kurtosis",)), rtol=1e-13)
    kept = references.reference("kurtosis", e, start, "short")
    np.testing.assert_allclose(found.kurtosis, kept, rtol=5e-13)


def made_up(scale=1.0):
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


def test_error_of_a_curve_is_what_was_put_in():
    exact = made_up().curve(R)
    wrong = exact + 0.01 * exact.max() * (np.arange(R.size) == 150)
    assert made_up().error(exact) == 0.0
    assert made_up().error(wrong) == pytest.approx(0.01, rel=1e-9)


def test_error_of_a_histogram_is_what_was_put_in():
    # the run's own <r^2> scales its histogram: 16 d^2, where the same curve is wider
    edges = np.geomspace(0.01, 40.0, 120)
    share = -np.diff(np.exp(-((edges / 4) ** 2)))

    def run(probability):
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
    # outside of the bins that are looked at
    outside = share + 0.1 * (np.arange(119) == 118)
    assert made_up().histogram_error(run(outside)) < 1e-12


def test_the_moments_that_a_reference_misses():
    assert made_up().moments_missed() == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    assert made_up(1.01).moments_missed() == pytest.approx((0.01, 0.01, 0.01), rel=1e-9)
    found = position.density_reference(0.6, 300.0, rtol=1e-5)
    norm, second, fourth = found.moments_missed()
    assert norm < 1e-9
    assert second < 1e-6
    assert fourth < 1e-4


def test_rows_of_the_distribution():
    kept = position.density_reference(0.9, 1000.0, 1e-7)
    sweeps = position._density(0.9, 1000.0, kept, ONCE)
    reference = position._moments_of(sweeps[0].problem, kept)
    rows = [reference, *run_sweeps(sweeps, ONCE)]
    assert reference.error < 1e-5
    assert reference.seconds is None  # no competitor
    spectral = [r for r in rows if r.method == methods.SPECTRAL]
    assert [r.asked for r in spectral] == [1e-2, 1e-4, 1e-5]
    assert all(r.error <= r.asked for r in spectral)
    # 25 times as many samples: 5 times less, within the scatter of a largest error
    errors = [r.error for r in rows if r.method == methods.MONTE_CARLO]
    assert 2.5 < errors[0] / errors[-1] < 10.0
    printed = {r.setting: r.error for r in rows if r.method == methods.PRINTED}
    assert len(printed) == 3
    # the Gaussian is near at this pair, the Bessel function is not
    assert printed["eq. peakg, eta = 0.75"] < 0.3 < printed["eq. gdefi, eta = 1/2"]
    missing = position.cannot([reference.problem])
    assert {r.method for r in missing if r.status == NOT_AVAILABLE} == {
        methods.CONSERVATIVE, methods.STRAIGHTFORWARD, methods.SONINE
    }  # fmt: skip

    report = BenchReport(tuple(rows), True, ("position",), {"processor": "x"}, 1.0)
    text = report.markdown()
    assert f"- Reference of {reference.problem}, rtol = 1e-07: integrals of 1, R^2 and R^4" in text
    assert f"- {reference.problem}, eq. peakg, eta = 0.75: " in text
    assert "| as printed | - | - | - | - |" in text
    assert "no other method is quicker" in text
    figure = report.figures()["precision-position.svg"]
    assert "as printed" in figure
    assert "Monte Carlo" in figure


def test_cost_and_skipping_have_rows_of_the_displacement():
    rows = run_sweeps(cost._position(ONCE), ONCE)
    settings = {(r.problem, r.setting) for r in rows}
    assert {("G(R)", "times"), ("F(k)", "wave numbers")} <= settings
    assert all(r.status == MEASURED for r in rows)
    assert {r.setting for r in cost.exponents(rows)} >= {"times, exponent"}
    rows = skipping.ratios({"displacement": skipping._position()}, ONCE)
    together = {r.method: r.extra["ratio"] for r in rows}
    assert together["everything"] == 1.0
    assert {"msd alone", "position_density alone", "all but position_density"} <= set(together)
