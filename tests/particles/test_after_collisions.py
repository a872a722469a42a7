"""What is left after N collisions without scatterers, against closed forms of the collision law.

The flights are independent and exponential, with mean l, and so are the collisions: after N of them
<v^p> = U^p E[s^p]^N for tracers that all start at U, and, with c the mean cosine of the deflection,
<r^2> = 2 l^2 [N/(1 - c) - c (1 - c^N)/(1 - c)^2]. All tracers are independent.

In three dimensions y^2 is uniform on [0, 1], so s^2 is uniform between e^2 and et^2, and
c = 2 (et - e)/(3 (et + e)).
"""

import numpy as np
import pytest
from scipy.integrate import quad

from particles import BoltzmannGrad, simulate

LAWS = [(0.4, 1.0), (0.9, 0.8), (0.3, 0.6), (0.5, 0.5), (0.7, 0.0), (0.0, 0.9)]
SIGMAS = 4  # some 80 comparisons in all: one in 200 such test files would fail by chance
COLLISIONS = 4


def averages(e: float, et: float, p: float) -> tuple[float, float]:
    """E[s^p] and the mean cosine, by quadrature over the impact parameter."""

    def ratio(y: float) -> float:
        return np.hypot(e * np.sqrt(1 - y * y), et * y)

    def cosine(y: float) -> float:
        return ((e + et) * y * y - e) / ratio(y)

    return quad(lambda y: ratio(y) ** p, 0, 1)[0], quad(cosine, 0, 1)[0]


@pytest.mark.parametrize("law", LAWS)
def test_speed_and_displacement(law: tuple[float, float]) -> None:
    e, et = law
    ensemble = simulate(
        BoltzmannGrad(0.05), e, "monoenergetic", media=10, tracers=20_000, seed=31,
        max_collisions=COLLISIONS, observables=["finals"], tangential_restitution=et,
    )  # fmt: skip
    ln_v, _, x, y, _ = ensemble.finals.T
    for p in (0.5, 1.0, 2.0, 4.0):
        mean, cosine = averages(e, et, p)
        check(np.exp(p * ln_v), mean**COLLISIONS)
    check(x * x + y * y, squared_displacement(10.0, cosine, COLLISIONS))


@pytest.mark.parametrize("law", [*LAWS, (1.0, 1.0)])
def test_speed_and_displacement_in_space(law: tuple[float, float]) -> None:
    e, et = law
    ensemble = simulate(
        BoltzmannGrad(0.05, dimension=3), e, "monoenergetic", media=10, tracers=20_000, seed=32,
        max_collisions=COLLISIONS, observables=["finals"], tangential_restitution=et,
    )  # fmt: skip
    ln_v, _, x, y, _, z = ensemble.finals.T
    for p in (0.5, 1.0, 2.0, 4.0):
        both = p + 2, et * et - e * e
        mean = e**p if e == et else 2 * (et ** both[0] - e ** both[0]) / (both[0] * both[1])
        check(np.exp(p * ln_v), mean**COLLISIONS)
    path, cosine = 1 / (np.pi * 0.05), 2 * (et - e) / (3 * (et + e))
    check(x * x + y * y + z * z, squared_displacement(path, cosine, COLLISIONS))
    for coordinate in (x, y, z):
        check(3 * coordinate**2, squared_displacement(path, cosine, COLLISIONS))
        check(coordinate, 0.0)


def squared_displacement(path: float, c: float, n: int) -> float:
    return 2 * path**2 * (n / (1 - c) - c * (1 - c**n) / (1 - c) ** 2)


def check(values: np.ndarray, expected: float) -> None:
    """The mean of independent values is the expected one within SIGMAS standard errors."""
    if np.ptp(values) < 1e-13:  # e = et: every collision has the same ratio
        np.testing.assert_allclose(values, expected, rtol=1e-13)
        return
    sigmas = (values.mean() - expected) / (values.std(ddof=1) / np.sqrt(values.size))
    assert abs(sigmas) < SIGMAS, (sigmas, values.mean(), expected)
