"""CollisionLaw against closed forms and integrals in mpmath: smooth disks, rough ones, spheres."""

from itertools import product
from typing import Any

import collision
import mpmath as mp
import pytest
from marking import slow_but

from kinetics import CollisionLaw

NEAR_AND_FAR = [1e-8, 1e-2, 0.5, 0.99, 1 - 1e-8]
REAL = [-0.7, 1e-6, 0.5, 1.0, 2.0, 3.0, 4.7, 10.0, 25.3, 100.0, 300.0]
NEGATIVE = [-1.0, -2.0, -3.5, -8.0]
COMPLEX = [0.5 + 1j, 2 + 10j, 1 + 40j, -0.5 + 3j, 3 - 150j, 2 + 600j]
LIMIT = 1e-13


def relative(found: complex, exact: Any) -> float:
    return float(abs(mp.mpmathify(found) / exact - 1))


@pytest.mark.parametrize("e", NEAR_AND_FAR)
@pytest.mark.parametrize("p", REAL + NEGATIVE + COMPLEX)
def test_decay_rate_and_mean_power(e: float, p: complex) -> None:
    law = CollisionLaw(e)
    with mp.workdps(60):
        power = collision.speed_ratio_power(e, p)
        # a complex power turns on the way: relative to what it is made of
        size = collision.speed_ratio_power(e, mp.re(p))
        assert float(abs(law.mean_speed_ratio_power(p) - power) / size) <= LIMIT
        assert relative(law.decay_rate(p), 1 - power) <= LIMIT


@pytest.mark.parametrize("e", NEAR_AND_FAR)
def test_mean_log_loss_and_mean_cosine(e: float) -> None:
    law = CollisionLaw(e)
    with mp.workdps(60):
        assert relative(law.mean_log_loss, collision.mean_log_loss(e)) <= LIMIT
        b = mp.sqrt(1 - mp.mpf(e) ** 2)
        q = mp.atanh(b) / b
        cosine = -mp.mpf(e) * q + (1 - mp.mpf(e) ** 2 * q) / (2 * (1 - mp.mpf(e)))
        assert relative(law.mean_cosine, cosine) <= LIMIT


@pytest.mark.parametrize("e", [*NEAR_AND_FAR, 0.0, 1.0])
@pytest.mark.parametrize("m", [1, 2, 5])
def test_harmonic_decay_rate(e: float, m: int) -> None:
    law = CollisionLaw(e)
    # the reference loses m times the digits of 1 - e
    with mp.workdps(60 + (8 * m if e > 0.5 else 0)):
        for p in (0.0, 1.0, 2.5, 7.0):
            exact = 1 - collision.ratio_power_cosine(e, p, m)
            assert relative(law.harmonic_decay_rate(p, m), exact) <= LIMIT


@pytest.mark.parametrize("e", [0.0, 5e-324, 1e-300, 1e-200, 1e-160])
def test_the_smallest_restitutions(e: float) -> None:
    law = CollisionLaw(e)
    assert law.decay_rate(-1e-50) == pytest.approx(-1e-50, rel=1e-13, abs=0.0)
    assert law.decay_rate(1.0) == pytest.approx(0.5, rel=1e-13)
    assert law.mean_log_loss == pytest.approx(1.0, rel=1e-13)
    assert law.harmonic_decay_rate(1.0, 1) == pytest.approx(2 / 3, rel=1e-13)


# -- rough ones, and spheres ----------------------------------------------------------------------

NORMAL = [0.0, 1e-6, 0.3, 0.7, 0.999, 1.0]
TANGENTIAL = [0.0, 0.01, 0.7, 0.8, 1.0]
LAWS = [(e, et) for e, et in product(NORMAL, TANGENTIAL) if e + et > 0.0]
CASES = [(e, et, d) for e, et in ((0.0, 0.5), (0.9, 0.6), (0.3, 0.0), (1.0, 0.5)) for d in (2, 3)]
POWERS = [-0.9, -0.5, 1e-200, 1e-10, 0.5, 1.0, 2.0, 3.7, 40.0]


def sphere_decay(e: float, et: float, p: float) -> mp.mpf:
    """1 - E[s^p] of spheres: s^2 is uniform between e^2 and et^2."""
    e, et, p = mp.mpf(e), mp.mpf(et), mp.mpf(p)
    if e == et:
        return 1 - e**p
    return 1 - 2 * (et ** (p + 2) - e ** (p + 2)) / ((p + 2) * (et**2 - e**2))


def decay(e: float, et: float, dimension: int, p: float, m: int) -> mp.mpf:
    """1 - E[s^p cos(m chi)] or 1 - E[s^p P_m(cos chi)], as an integral over y."""
    e, et = mp.mpf(e), mp.mpf(et)

    def kept(y: mp.mpf) -> mp.mpf:
        s = mp.sqrt(e**2 + (et**2 - e**2) * y**2)
        if not s:
            return s
        cosine = (-e + (e + et) * y**2) / s
        angular = mp.chebyt(m, cosine) if dimension == 2 else mp.legendre(m, cosine)
        return (dimension - 1) * y ** (dimension - 2) * s**p * angular

    ends = [0, 1e-6, 1e-3, 0.1, 0.5, 0.9, 0.999, 1 - mp.mpf(10) ** -6, 1]
    return 1 - mp.quad(kept, ends)


@pytest.mark.parametrize(("e", "et"), LAWS)
def test_spheres_against_the_closed_form(e: float, et: float) -> None:
    law = CollisionLaw(e, et, dimension=3)
    with mp.workdps(300):  # E[s^40] may be 1e-240
        for p in POWERS:
            exact = sphere_decay(e, et, p)
            if exact:
                assert relative(law.decay_rate(p), exact) <= LIMIT
            assert relative(law.mean_speed_ratio_power(p), 1 - exact) <= LIMIT


@pytest.mark.parametrize(("e", "et", "dimension"), slow_but([CASES[1], CASES[2]], CASES))
def test_harmonics_against_integrals(e: float, et: float, dimension: int) -> None:
    law = CollisionLaw(e, et, dimension)
    with mp.workdps(30):
        for p, m in [(0.5, 0), (-0.5, 0), (0.0, 1), (2.0, 1), (1.0, 3), (3.0, 7), (-0.5, 2)]:
            exact = decay(e, et, dimension, p, m)
            assert float(abs(law.harmonic_decay_rate(p, m) - exact)) <= LIMIT


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("p", [-1.99, -1.5, -1.0, 0.5, 3.0, 40.0])
def test_bounces_that_keep_no_tangential_velocity(p: float, dimension: int) -> None:
    """E[s^p] of s = e sqrt(1 - y^2), y^(d - 1) uniform: near the lowest power -2 it diverges."""
    law = CollisionLaw(0.5, 0.0, dimension)
    with mp.workdps(40):
        a = mp.mpf(p) / 2 + 1
        q = mp.mpf(dimension - 1) / 2
        mean = mp.mpf("0.5") ** p * q * mp.beta(a, q)
        assert relative(law.mean_speed_ratio_power(p), mean) <= 1e-12


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("e", [0.0, 0.5, 0.9])
def test_the_tail_exponent_is_that_of_large_powers(e: float, dimension: int) -> None:
    """E[s^p] = b/p (1 + O(1/p)): one step of Richardson leaves O(1/p^2)."""
    law = CollisionLaw(e, dimension=dimension)
    low, high = (p * law.mean_speed_ratio_power(p) for p in (1e5, 2e5))
    assert law.tail_exponent == pytest.approx(2.0 * high - low, rel=1e-7)
