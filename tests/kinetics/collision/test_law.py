"""CollisionLaw against closed forms in mpmath at 50 digits, for every restitution."""

from types import ModuleType
from typing import Any

import mpmath as mp
import pytest

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
def test_decay_rate_and_mean_power(e: float, p: complex, formulas: ModuleType) -> None:
    law = CollisionLaw(e)
    with mp.workdps(60):
        power = formulas.speed_ratio_power(e, p)
        # a complex power turns on the way: relative to what it is made of
        size = formulas.speed_ratio_power(e, mp.re(p))
        assert float(abs(law.mean_speed_ratio_power(p) - power) / size) <= LIMIT
        assert relative(law.decay_rate(p), 1 - power) <= LIMIT


@pytest.mark.parametrize("e", NEAR_AND_FAR)
def test_mean_log_loss_and_mean_cosine(e: float, formulas: ModuleType) -> None:
    law = CollisionLaw(e)
    with mp.workdps(60):
        assert relative(law.mean_log_loss, formulas.mean_log_loss(e)) <= LIMIT
        b = mp.sqrt(1 - mp.mpf(e) ** 2)
        q = mp.atanh(b) / b
        cosine = -mp.mpf(e) * q + (1 - mp.mpf(e) ** 2 * q) / (2 * (1 - mp.mpf(e)))
        assert relative(law.mean_cosine, cosine) <= LIMIT


@pytest.mark.parametrize("e", [*NEAR_AND_FAR, 0.0, 1.0])
@pytest.mark.parametrize("m", [1, 2, 5])
def test_harmonic_decay_rate(e: float, m: int, formulas: ModuleType) -> None:
    law = CollisionLaw(e)
    # the reference loses m times the digits of 1 - e
    with mp.workdps(60 + (8 * m if e > 0.5 else 0)):
        for p in (0.0, 1.0, 2.5, 7.0):
            exact = 1 - formulas.ratio_power_cosine(e, p, m)
            assert relative(law.harmonic_decay_rate(p, m), exact) <= LIMIT


@pytest.mark.parametrize("e", [5e-324, 1e-300, 1e-200, 1e-160])
def test_the_smallest_restitutions(e: float) -> None:
    law = CollisionLaw(e)
    assert law.decay_rate(1.0) == pytest.approx(0.5, rel=1e-13)
    assert law.mean_log_loss == pytest.approx(1.0, rel=1e-13)
    assert law.harmonic_decay_rate(1.0, 1) == pytest.approx(2 / 3, rel=1e-13)
