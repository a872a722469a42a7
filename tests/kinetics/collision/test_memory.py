"""Oscillations that a law leaves in ln v: zeros of 1 - E[s^z], found by other routes."""

import itertools
import math

import mpmath as mp
import numpy as np
import pytest

from kinetics import CollisionLaw
from kinetics.collision.memory import common_loss, oscillations, time_to_forget

TWO = CollisionLaw.from_samples([0.4, 0.6], [0.9, 0.4], [0.0, 0.0])


def turns(law: CollisionLaw, top: float) -> int:
    """How many zeros lie in -0.999 < Re z < 1e-3, -top < Im z < -1e-3: turns of lambda around 0."""
    ends = [
        complex(-0.999, -1e-3),
        complex(-0.999, -top),
        complex(1e-3, -top),
        complex(1e-3, -1e-3),
    ]
    corners = [*ends, ends[0]]
    sides = [np.linspace(a, b, 12_000) for a, b in itertools.pairwise(corners)]
    value = np.concatenate([law.decay_symbol(side) for side in sides])
    steps = np.angle(value[1:] / value[:-1])
    assert np.abs(steps).max() < 1.5
    return round(float(steps.sum()) / (2.0 * math.pi))


@pytest.mark.parametrize(
    "law",
    [
        CollisionLaw(0.01),
        CollisionLaw(0.5),
        CollisionLaw(0.9, dimension=3),
        CollisionLaw(1.0, 0.4),
        CollisionLaw(0.7, 0.75),
        CollisionLaw(0.2, 0.3, 3),
        CollisionLaw(0.3, 0.3),
        TWO,
        CollisionLaw.from_samples([0.995, 0.005], [0.7, 1e-3], [0.0, 0.0]),
    ],
)
def test_none_is_missed_and_none_is_too_many(law: CollisionLaw) -> None:
    """By the argument principle: smooth scatterers leave none."""
    found = oscillations(law, 20.3)
    assert len(found) == turns(law, 20.3)
    assert all(abs(complex(law.decay_rate(z))) < 1e-10 for z in found)
    if law.tangential_restitution == 1.0:
        assert found == ()


@pytest.mark.parametrize("law", [CollisionLaw(0.6, 0.6), CollisionLaw(0.6, 0.6, 3)])
def test_one_ratio_oscillates_for_ever(law: CollisionLaw) -> None:
    step = 2.0 * math.pi / -math.log(0.6)
    np.testing.assert_allclose(oscillations(law, 40.0), [-1j * step, -2j * step, -3j * step])
    assert common_loss(law, 40.0) == pytest.approx(-math.log(0.6), rel=1e-12)
    assert time_to_forget(oscillations(law, 40.0)[0], 2.0) == math.inf


def test_bounces_that_lose_nothing_leave_no_waves() -> None:
    """As atoms of the loss they made the search for fast waves last for minutes."""
    law = CollisionLaw.mixture([3, 2], [CollisionLaw(1.0), CollisionLaw(0.67)])
    assert oscillations(law, 1e6) == oscillations(law, 64.0)
    assert len(oscillations(law, 20.3)) == turns(law, 20.3)


def test_losses_with_a_common_divisor() -> None:
    law = CollisionLaw.from_samples([0.5, 0.2, 0.3], [0.25, 1.0, 0.125], [0.0, 0.0, 0.0])
    assert common_loss(law, 64.0) == pytest.approx(math.log(2.0), rel=1e-12)
    assert common_loss(TWO, 64.0) is None
    assert common_loss(CollisionLaw(0.5), 64.0) is None


def test_nearly_one_ratio_against_many_digits() -> None:
    e, et = 0.7, 0.72
    found = oscillations(CollisionLaw(e, et, 3), 64.0)
    with mp.workdps(30):

        def rate(z: mp.mpc) -> mp.mpc:
            both = mp.mpf(et) ** (z + 2) - mp.mpf(e) ** (z + 2)
            return 1 - 2 * both / ((z + 2) * (mp.mpf(et) ** 2 - mp.mpf(e) ** 2))

        exact = [complex(mp.findroot(rate, mp.mpc(z))) for z in found]
    assert len(found) >= 3
    np.testing.assert_allclose(found, exact, rtol=1e-12)
    assert found[0].real < -1e-3
    slow = time_to_forget(found[0], 1e6)
    assert math.exp(found[0].real * slow) * 1e6 == pytest.approx(1.0)
    assert time_to_forget(found[0], 0.5) == 0.0
