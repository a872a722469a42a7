"""ScalingSolution against products, limits and Mellin inversion in mpmath."""

import math

import mpmath as mp
import numpy as np
import pytest
from collision import Product, integer_moment
from marking import slow_but

from kinetics import ScalingSolution, solve_scaled
from kinetics.crosscheck.references import load
from kinetics.scaling import mellin

TABLE = [1e-3, *np.round(np.arange(0.05, 0.951, 0.05), 2).tolist(), 0.99, 0.999]
EXTREME = [1e-8, 1e-4, 1 - 1e-4, 1 - 1e-8]
LIMIT = 1e-13
SCALED = load()["scaled_density"]


@pytest.mark.parametrize("e", slow_but(TABLE[::5] + EXTREME, TABLE + EXTREME))
def test_cooling_rate_a2_and_integer_moments(e: float) -> None:
    exact = ScalingSolution(e)
    with mp.workdps(80):
        y = {n: integer_moment(e, n) for n in range(-2, 9) if n != 0}
        h = 2 / mp.sqrt(y[2])  # v0 = 2 l/(h t), and v t/l tends to Y
        assert abs(exact.cooling_rate / h - 1) <= LIMIT
        assert abs(exact.a2 - (y[4] / (2 * y[2] ** 2) - 1)) <= LIMIT * (1 + exact.a2)
        for n, moment in y.items():
            assert abs(exact.moment(n) / (moment / y[2] ** (mp.mpf(n) / 2)) - 1) <= LIMIT
            # kappa^n is in it
            assert abs(exact.scaled_speed_moment(n) / moment - 1) <= 2 * LIMIT
        assert exact.moment(0) == pytest.approx(1.0, rel=2e-14, abs=0.0)


@pytest.mark.parametrize(
    "e", slow_but([0.0, 1 - 1e-8], [0.0, 0.05, 0.4, 0.9, 0.99, 1e-8, 1 - 1e-8])
)
def test_moments_between_the_integers(e: float) -> None:
    """Newton's interpolation of ln E[Y^n] far out, and the recursion back."""
    exact = ScalingSolution(e)
    with mp.workdps(60):
        moment = Product(e, 0, 90).moment
        root = mp.sqrt(moment(2))
        for p in [-0.5, 0.3, 1.5, 2.5, math.pi, 7.9, 40.1, *([-1.5, -6.3] if e else [])]:
            reference = moment(p) / root ** mp.mpf(p)
            assert abs(exact.moment(p) / reference - 1) <= 2 * LIMIT, p


@pytest.mark.parametrize("e", slow_but(["0.05", "0.6", "0.95", "0.999"], SCALED))
def test_vdf_against_mellin_inversion(e: str) -> None:
    c, f = (np.array(SCALED[e][name]) for name in ("c", "F"))
    np.testing.assert_allclose(ScalingSolution(float(e)).vdf(c), f, rtol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("e", [0.0, 0.4, 0.8])
def test_exponential_tail_with_its_power(e: float, dimension: int) -> None:
    exact = ScalingSolution(e, 1.0, dimension)
    c = np.array([75.0, 150.0, 300.0]) * exact.cooling_rate
    log_f = np.log(exact.vdf(c))
    form = exact.tail_power * np.log(c) - exact.tail_rate * c
    # what is left is a constant and a series in 1/c: two steps of Richardson
    left = log_f - form
    once = 2 * left[1:] - left[:-1]
    assert abs(once[1] - once[0]) <= 0.1 * abs(left[2] - left[1]) + 1e-11
    assert exact.tail_rate == pytest.approx(2 / exact.cooling_rate)
    assert exact.tail_power == pytest.approx((dimension - 1) / (1 - e * e) - dimension)


def test_the_elastic_limit() -> None:
    elastic = ScalingSolution(1.0)
    assert elastic.cooling_rate == 0.0
    assert elastic.a2 == -0.5
    assert elastic.moment(3.3) == 1.0
    assert elastic.diffusion_slope == math.inf
    assert elastic.tail_rate == elastic.tail_power == math.inf


def test_large_speeds_beside_small_ones_near_zero() -> None:
    """What resolves a long tail towards rest lost eight digits where it ends at large speeds."""
    c = np.concatenate([np.geomspace(1e-3, 0.1, 12), np.linspace(0.2, 12.5, 40)])
    for e, d in ((1e-10, 2), (1e-8, 3)):
        exact, found = ScalingSolution(e, 1.0, d), solve_scaled(e, 1e-12, dimension=d)
        np.testing.assert_allclose(exact.vdf(c), found.vdf(c), rtol=2e-12)


@pytest.mark.parametrize("gap", [1e-4, 1e-7, 1e-10, 1e-13])
def test_the_narrow_ring_near_the_elastic_limit(gap: float) -> None:
    # a sum over a million steps of the recursion at 1 - 1e-10 once took minutes and all memory
    exact = ScalingSolution(1.0 - gap)
    width = 0.65 * math.sqrt(gap)
    c = 1.0 + width * np.linspace(-8.0, 8.0, 2001)
    F = exact.vdf(c)
    mean = 2.0 * math.pi * width * 0.008 * float(np.sum(c * F))
    assert abs(mean - 1.0) < 1e-9 + 1e-15 / width
    solved = solve_scaled(1.0 - gap, 1e-10).vdf(c)
    assert float(np.max(np.abs(solved - F))) < (1e-9 + 1e-14 / width) * float(F.max())
    assert exact.vdf(0.5) == exact.vdf(2.0) == 0.0


def test_low_speeds_do_not_depend_on_where_the_lines_are(monkeypatch: pytest.MonkeyPatch) -> None:
    """A line next to a whole exponent lost the value at its middle: 1e-5 of F among hard disks."""
    given, c = {"scatterers": "hard disks", "number_density": 0.05}, np.linspace(0.6, 0.8, 21)
    f = ScalingSolution(0.99, **given).vdf(c)
    for reach in (0.8, 1.25, 2.0):
        monkeypatch.setattr(mellin, "REACH_NEAR_GAUSSIAN", reach)
        np.testing.assert_allclose(ScalingSolution(0.99, **given).vdf(c), f, rtol=1e-11)
