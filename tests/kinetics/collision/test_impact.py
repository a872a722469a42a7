"""Disks and spheres, smooth and rough: averages against closed forms and mpmath integrals."""

from itertools import product

import mpmath as mp
import pytest
from marking import slow_but

from kinetics import CollisionLaw

LIMIT = 1e-13
NORMAL = [0.0, 1e-6, 0.3, 0.7, 0.999, 1.0]
TANGENTIAL = [0.0, 0.01, 0.7, 0.8, 1.0]
LAWS = [(e, et) for e, et in product(NORMAL, TANGENTIAL) if e + et > 0.0]
CASES = [(e, et, d) for e, et in ((0.0, 0.5), (0.9, 0.6), (0.3, 0.0), (1.0, 0.5)) for d in (2, 3)]
POWERS = [-0.9, -0.5, 0.5, 1.0, 2.0, 3.7, 40.0]


def relative(found: float, exact: mp.mpf) -> float:
    return float(abs(mp.mpf(found) / exact - 1))


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
