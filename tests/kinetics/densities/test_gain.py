"""The gain of the collisions against its ladder in many digits, and where it is known."""

from typing import Any

import mpmath as mp
import numpy as np
import pytest
from collision import Product

from kinetics import CollisionLaw
from kinetics.densities.gain import log_gain


@pytest.mark.parametrize("m", [0, 2])
@pytest.mark.parametrize("e", [0.1, 0.97])
def test_against_the_ladder_in_many_digits(e: float, m: int) -> None:
    step, marks = 0.25, (4, 24, 60)
    found = np.exp(log_gain(CollisionLaw(e), step * np.arange(61.0), m))
    with mp.workdps(40):
        product = Product(e, m, step * marks[-1])

        def gain(z: Any) -> Any:
            return (z if m == 0 else 1) / product(z)

        near = gain(mp.mpc(0, -(mp.mpf(10) ** -25)))
        for n in marks:
            exact = complex(gain(mp.mpc(0, -step * n)) / near)
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
