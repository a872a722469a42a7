"""The gain of the collisions against its ladder in many digits, and where it is known."""

import itertools
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from kinetics import CollisionLaw
from kinetics.densities.intertwining import log_gain


def rates(e: Any, z: Any, m: int, count: int) -> list[Any]:
    """1 - E[s^p cos(m chi)], p = z, z + 1, ..., for m = 0 or 2: cos(chi) = (s - e/s)/(1 - e)."""
    phi = [
        e**p * mp.hyp2f1(-p / 2, mp.mpf("0.5"), mp.mpf("1.5"), 1 - 1 / e**2) for p in (z - 2, z - 1)
    ]
    for p in range(count + 2):  # (p + 1) E[s^p] = 1 + p e^2 E[s^(p-2)]
        phi.append((1 + (z + p) * e**2 * phi[p]) / (z + p + 1))
    if m == 0:
        return [1 - phi[p + 2] for p in range(count)]
    square = [(phi[p + 4] - 2 * e * phi[p + 2] + e**2 * phi[p]) for p in range(count)]
    return [1 + phi[p + 2] - 2 * s / (1 - e) ** 2 for p, s in enumerate(square)]


def gain(e: float, z: Any, m: int) -> Any:
    """G(z), z G(z) for m = 0, up to a constant: Newton's interpolation of ln lambda far to the
    right, and products back.
    """
    far, e_ = 100, mp.mpf(e)
    row = [mp.log(rate) for rate in rates(e_, mp.mpf(far), m, 120)]
    total, binomial = mp.mpf(0), mp.mpf(1)
    for k in itertools.count(1):
        binomial *= (z - k + 1) / k
        total += binomial * row[0]
        if abs(binomial * row[0]) < mp.mpf(10) ** -20:
            break
        row = [b - a for a, b in itertools.pairwise(row)]
    value = mp.exp(total) * (z if m == 0 else 1)
    for rate in rates(e_, z, m, far):
        value /= rate
    return value


@pytest.mark.parametrize("m", [0, 2])
@pytest.mark.parametrize("e", [0.1, 0.7, 0.97])
def test_against_the_ladder_in_many_digits(e: float, m: int) -> None:
    step, marks = 0.25, (4, 24, 120)
    found = np.exp(log_gain(CollisionLaw(e), step * np.arange(121.0), m))
    with mp.workdps(90):
        near = gain(e, mp.mpc(0, -(mp.mpf(10) ** -25)), m)
        for n in marks:
            exact = complex(gain(e, mp.mpc(0, -step * n), m) / near)
            assert abs(found[n] / exact - 1.0) < 1e-12, n


def test_at_restitution_zero() -> None:
    """lambda = z/(1 + z), z G = 1; with cos(chi) = s, lambda = (z + 1)/(z + 2) for m = 1."""
    k = 0.3 * np.arange(200.0)
    law = CollisionLaw(0.0)
    assert np.all(log_gain(law, k) == 0.0)
    np.testing.assert_allclose(np.exp(log_gain(law, k, 1)), 1.0 / (1.0 - 1j * k), rtol=1e-12)


def test_near_the_elastic_limit() -> None:
    """lambda(z) tends to kappa z, and z G(z) to kappa^z Gamma(1 + z)."""
    law, k = CollisionLaw(1.0 - 1e-12), 0.2 * np.arange(100.0)
    found = np.exp(log_gain(law, k)) * law.mean_log_loss ** (1j * k)
    exact = np.array([complex(mp.gamma(mp.mpc(1, -x))) for x in k])
    assert np.max(np.abs(found / exact - 1.0)) < 1e-8
