"""Moments in time at restitution 0, where a head-on bounce stops the tracer: every p above -1."""

import warnings

import mpmath as mp
import numpy as np
import pytest

from kinetics import Beam, CollisionLaw, InputError, Scene, SpeedTable, solve

FREE_PATH = 12.5
REDUCED = (1e-6, 0.01, 0.5, 1.0, 3.0, 12.0, 40.0, 1e3, 1e9)  # T = v t/l
POWERS = (-0.1, -0.3, -0.5, -0.9, -0.999, -1.0 + 1e-10)


def one_speed(p: float, reduced: float) -> float:
    """<(v/v(0))^p> = T^-p gamma(p + 1, T) + e^-T, gamma the lower incomplete gamma function.

    At e = 0, s is uniform on [0, 1]: u(T) = <(v/v(0))^p> obeys u' + u = T^-(p+1) I, where I is the
    integral of x^p u(x) from 0 to T; its power series is sum_k (-T)^k/k! p/(p+k).
    """
    with mp.workdps(40):
        p_, t = mp.mpf(p), mp.mpf(reduced)
        return float(t**-p_ * mp.gammainc(p_ + 1, 0, t) + mp.exp(-t))


def harmonic(p: float, m: int, reduced: float) -> float:
    """<(v/v(0))^p cos(m phi)> of a beam by its power series; cos(chi) = s at e = 0."""
    # T_m(s) as a polynomial in s: T_(k+1) = 2 s T_k - T_(k-1)
    before, polynomial = np.array([1.0]), np.array([0.0, 1.0])
    for _ in range(m - 1):
        before, polynomial = polynomial, np.polynomial.polynomial.polysub(
            2.0 * np.append(0.0, polynomial), before
        )  # fmt: skip
    with mp.workdps(60 + int(reduced)):
        p_, t = mp.mpf(p), mp.mpf(reduced)
        term = total = mp.mpf(1)
        for k in range(int(40 + 6 * reduced)):
            kept = mp.fsum(mp.mpf(c) / (p_ + k + 1 + j) for j, c in enumerate(polynomial))
            term *= -(1 - kept) * t / (k + 1)
            total += term
        return float(total)


@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-10, 1e-12])
@pytest.mark.parametrize("p", POWERS)
def test_every_power_above_minus_one(p: float, rtol: float) -> None:
    times = FREE_PATH * np.array(REDUCED)
    found = solve(Scene(0.0, times=times, initial="monoenergetic"), rtol).moment(p)
    exact = np.array([one_speed(p, t) for t in REDUCED])
    assert np.max(np.abs(found / exact - 1.0)) <= rtol


@pytest.mark.parametrize("p", [-0.3, -0.9])
def test_averages_over_a_gaussian_start(p: float) -> None:
    reduced = np.array([0.1, 2.0, 50.0])
    found = solve(Scene(0.0, times=FREE_PATH * reduced), 1e-10).moment(p)
    # v = u^10 makes the integrand smooth at 0
    x, w = np.polynomial.legendre.leggauss(160)
    u = 0.5 * (1.0 + x) * 10.0**0.1
    v = u**10
    w = 0.5 * 10.0**0.1 * w * 10.0 * u**9 * v ** (1 + p) * np.exp(-0.5 * v * v)
    for t, value in zip(reduced, found, strict=True):
        exact = sum(weight * one_speed(p, speed * t) for weight, speed in zip(w, v, strict=True))
        assert value == pytest.approx(exact, rel=1e-9, abs=0.0)


@pytest.mark.parametrize(
    ("p", "m"),
    [
        (-0.5, 1), (-0.5, 4), (-0.9, 2), (-0.99, 7),
        *(
            pytest.param(p, m, marks=pytest.mark.slow)
            for p in (-0.5, -0.9, -0.99) for m in (1, 2, 3, 4, 7)
            if (p, m) not in ((-0.5, 1), (-0.5, 4), (-0.9, 2), (-0.99, 7))
        ),
    ],
)  # fmt: skip
def test_harmonics_of_a_beam(p: float, m: int) -> None:
    """To rtol of <v^p>; even m keep their sign at s = 0, where chi = pi/2, and odd m vanish."""
    reduced = np.array([0.01, 0.3, 1.0, 10.0, 30.0])
    exact = np.array([harmonic(p, m, t) for t in reduced])
    for rtol in (1e-6, 1e-11):
        solution = solve(Scene(0.0, times=FREE_PATH * reduced, initial=Beam()), rtol)
        error = np.abs(solution.harmonic(p, m) - exact) / solution.moment(p)
        assert np.max(error) <= rtol


@pytest.mark.parametrize("m", [1, 2, 4, 5])
def test_decay_rates_of_harmonics_below_minus_a_quarter(m: int) -> None:
    """1 - E[s^p T_m(s)], s uniform on [0, 1]."""
    p = np.array([-0.3, -0.9, -1.0 + 1e-9, 2.0])
    with mp.workdps(30):
        exact = [
            float(1 - mp.quad(lambda s, q=q: (mp.chebyt(m, s) - mp.chebyt(m, 0)) * s**q, [0, 1])
                  - mp.chebyt(m, 0) / (mp.mpf(q) + 1))
            for q in p
        ]  # fmt: skip
    np.testing.assert_allclose(
        CollisionLaw(0.0).harmonic_decay_rate(p, m), exact, rtol=1e-13, atol=1e-15
    )


def test_where_the_start_has_no_such_moment() -> None:
    table = SpeedTable([0.0, 1.0], [1.0, 1.0])
    for start in ("gaussian", table):
        solution = solve(Scene(0.0, times=[1.0], initial=start))
        with pytest.raises(InputError, match="p > -1"):
            solution.moment(-1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.isfinite(solution.moment(-0.9)).all()
