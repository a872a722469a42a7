"""What is left after N collisions without scatterers, against closed forms of the collision law.

The flights are independent and exponential, with mean l, and so are the collisions: after N of them
<v^p> = U^p E[s^p]^N for tracers that all start at U, and, with c the mean cosine of the deflection,
<r^2> = 2 l^2 [N/(1 - c) - c (1 - c^N)/(1 - c)^2]. All tracers are independent.
"""

import numpy as np
import pytest
from scipy.integrate import quad

from particles import BoltzmannGrad, simulate

LAWS = [(0.4, 1.0), (0.9, 0.8), (0.3, 0.6), (0.5, 0.5), (0.7, 0.0), (0.0, 0.9), (1.0, 1.0)]
SIGMAS = 4  # some 100 comparisons in all: one in 160 such test files would fail by chance
COLLISIONS = 4


def averages(e: float, et: float, p: float, dimension: int) -> tuple[float, float]:
    """E[s^p] and the mean cosine, by quadrature over the impact parameter."""

    def ratio(y: float) -> float:
        return np.hypot(e * np.sqrt(1 - y * y), et * y)

    def cosine(y: float) -> float:
        return ((e + et) * y * y - e) / ratio(y)

    def mean(function) -> float:  # type: ignore[no-untyped-def]
        weight = (lambda y: 1.0) if dimension == 2 else (lambda y: 2 * y)
        return quad(lambda y: weight(y) * function(y), 0, 1)[0]

    return mean(lambda y: ratio(y) ** p), mean(cosine)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("law", LAWS)
def test_speed_and_displacement(law: tuple[float, float], dimension: int) -> None:
    e, et = law
    ensemble = simulate(
        BoltzmannGrad(0.05, dimension=dimension), e, "monoenergetic", media=10, tracers=20_000,
        max_collisions=COLLISIONS, observables=["finals"], tangential_restitution=et, seed=31,
    )  # fmt: skip
    ln_v, _, x, y, _, *z = ensemble.finals.T
    for p in (0.5, 1.0, 2.0, 4.0):
        mean, c = averages(e, et, p, dimension)
        check(np.exp(p * ln_v), mean**COLLISIONS)
    path, n = {2: 10.0, 3: 1 / (np.pi * 0.05)}[dimension], COLLISIONS
    squared = 2 * path**2 * (n / (1 - c) - c * (1 - c**n) / (1 - c) ** 2)
    for coordinate in (x, y, *z):
        check(dimension * coordinate**2, squared)
        check(coordinate, 0.0)
    check(x * x + y * y + sum(one**2 for one in z), squared)


def check(values: np.ndarray, expected: float) -> None:
    """The mean of independent values is the expected one within SIGMAS standard errors."""
    if np.ptp(values) < 1e-13:  # e = et: every collision has the same ratio
        np.testing.assert_allclose(values, expected, rtol=1e-12)
        return
    sigmas = (values.mean() - expected) / (values.std(ddof=1) / np.sqrt(values.size))
    assert abs(sigmas) < SIGMAS, (sigmas, values.mean(), expected)
