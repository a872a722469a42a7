"""CollisionLaw against closed forms in mpmath at 50 digits, for every restitution."""

import math
from types import ModuleType
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinetics import CollisionLaw, InputError

NEAR_AND_FAR = [1e-8, 1e-4, 1e-2, 0.1, 0.5, 0.9, 0.99, 1 - 1e-4, 1 - 1e-8]
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
@pytest.mark.parametrize("m", [1, 2, 3, 8])
def test_harmonic_decay_rate(e: float, m: int, formulas: ModuleType) -> None:
    law = CollisionLaw(e)
    # the reference loses m times the digits of 1 - e
    with mp.workdps(60 + (8 * m if e > 0.5 else 0)):
        for p in (0.0, 1.0, 2.5, 7.0):
            exact = 1 - formulas.ratio_power_cosine(e, p, m)
            assert relative(law.harmonic_decay_rate(p, m), exact) <= LIMIT


@settings(deadline=None, derandomize=True)
@given(e=st.floats(1e-6, 1.0, exclude_max=True), p=st.floats(-20.0, 200.0))
def test_powers_two_apart(e: float, p: float) -> None:
    """(p+1) E[s^p] = 1 + p e^2 E[s^(p-2)], by partial integration over the impact parameter."""
    law = CollisionLaw(e)
    left = (p + 1.0) * law.mean_speed_ratio_power(p)
    right = p * e * e * law.mean_speed_ratio_power(p - 2.0)
    assert abs(left - 1.0 - right) <= 1e-13 * (abs(left) + 1.0 + abs(right))


def test_shapes_follow_the_exponents() -> None:
    law = CollisionLaw(0.3)
    p = np.arange(6.0).reshape(2, 3)
    assert law.decay_rate(p).shape == (2, 3)
    assert law.decay_rate(p + 1j).dtype == complex
    assert isinstance(float(law.decay_rate(2)), float)
    assert law.decay_rate(p)[1, 2] == pytest.approx(law.decay_rate(5.0), rel=1e-15, abs=0.0)
    # one exponent gives what it gives in company
    assert law.decay_rate(np.array([0.5 + 900j, 1.0]))[1] == pytest.approx(
        law.decay_rate(1.0), rel=1e-14, abs=0.0
    )


def test_a_bounce_that_stops_every_tracer_is_refused() -> None:
    for e in (0.0, 5e-324, 9e-9):
        with pytest.raises(InputError, match=f"tangential_restitution: got 5e-09; at .* {e}"):
            CollisionLaw(e, 5e-9)
    assert CollisionLaw(0.0, 1e-8).least_loss > 18.0


@pytest.mark.parametrize("p", [math.nan, math.inf, "x", None, [1.0, math.nan], -400.0])
@pytest.mark.parametrize("name", ["decay_rate", "mean_speed_ratio_power"])
def test_bad_exponent(name: str, p: Any) -> None:
    """-400 is a number, but E[s^-400] is above 1e308."""
    with pytest.raises(InputError, match=r"^p: got "):
        getattr(CollisionLaw(0.01), name)(p)


def test_moments_that_do_not_exist_at_zero_restitution() -> None:
    for p in (-1.0, -2.0, np.array([0.0, -1.5]), -1.0 + 2j):
        with pytest.raises(InputError, match="above -1"):
            CollisionLaw(0.0).decay_rate(p)
    with pytest.raises(InputError, match="above -1"):
        CollisionLaw(0.0).harmonic_decay_rate(-1.0, 2)


@pytest.mark.parametrize("m", [0.5, True, "1", None, math.nan])
def test_bad_harmonic(m: Any) -> None:
    with pytest.raises(InputError, match=r"^m: got "):
        CollisionLaw(0.5).harmonic_decay_rate(1.0, m)


@pytest.mark.parametrize("e", [5e-324, 1e-300, 1e-200, 1e-160])
def test_the_smallest_restitutions(e: float) -> None:
    law = CollisionLaw(e)
    assert law.decay_rate(1.0) == pytest.approx(0.5, rel=1e-13)
    assert law.mean_log_loss == pytest.approx(1.0, rel=1e-13)
    assert law.harmonic_decay_rate(1.0, 1) == pytest.approx(2 / 3, rel=1e-13)
