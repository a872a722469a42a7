"""Averages after N collisions: direct sums, particles, and what is refused."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from example_values import DENSITY

from kinetics import AngularHarmonics, Beam, CollisionLaw, Scene, solve
from kinetics.moments.by_collision import ByCollision
from particles import BoltzmannGrad, simulate

SIGMAS = 4.0  # some 500 comparisons: one in 30 such test files would fail by chance
NUMBERS = (1, 2, 5)


def after(law: Any, numbers: Any = NUMBERS, **options: Any) -> ByCollision:
    """With l = 1."""
    scene = Scene(law, number_density=DENSITY[law.dimension], collision_numbers=numbers, **options)
    return solve(scene).by_collision


@pytest.mark.parametrize("cosine", [-1.0, -0.75, 0.0, 0.5, 1.0 - 2.0**-12, 1.0 - 2.0**-40, 1.0])
def test_the_displacement_is_a_sum_over_pairs_of_flights(cosine: float) -> None:
    """Exactly: <r^2> = 2 l^2 sum of (N - k) c^k."""
    numbers, c = [0, 1, 2, 7, 40, 300], Fraction(cosine)
    exact = [float(2 * sum((n - k) * c**k for k in range(n))) for n in numbers]
    found = after(CollisionLaw.from_samples([1.0], [1.0], [cosine]), numbers).msd
    np.testing.assert_allclose(found, exact, rtol=1e-12, atol=1e-14)


def test_the_start_does_not_matter_to_the_displacement() -> None:
    law = CollisionLaw(0.6, 0.9, 3)
    beam, gaussian = after(law, initial=Beam()), after(law)
    np.testing.assert_array_equal(beam.msd, gaussian.msd)
    c = law.mean_cosine
    exact = [sum(c**k for k in range(n)) for n in NUMBERS]
    np.testing.assert_allclose(beam.mean_displacement[:, 0], exact, rtol=1e-13)
    assert np.all(beam.mean_displacement[:, 1:] == 0.0)
    turned = after(CollisionLaw(0.4), initial=Beam(0.7)).mean_displacement
    np.testing.assert_allclose(np.arctan2(turned[:, 1], turned[:, 0]), 0.7, rtol=1e-13)
    np.testing.assert_allclose(beam.harmonic(0.0, 1).real, c ** np.array(NUMBERS), rtol=1e-13)


def check(values: Any, expected: float) -> None:
    if np.ptp(values) < 1e-13:  # e = et: every collision has the same ratio
        assert values[0] == pytest.approx(expected, rel=1e-12)
        return
    sigmas = (values.mean() - expected) / (values.std(ddof=1) / np.sqrt(values.size))
    assert abs(sigmas) < SIGMAS, (sigmas, values.mean(), expected)


LAWS = [(0.7, 1.0, 2), (0.5, 0.5, 2), (0.0, 0.9, 3)]


@pytest.mark.parametrize("initial", ["gaussian", "monoenergetic"])
@pytest.mark.parametrize(("e", "et", "dimension"), LAWS)
def test_particles_recorded_by_collision(e: float, et: float, dimension: int, initial: str) -> None:
    law = CollisionLaw(e, et, dimension)
    medium = BoltzmannGrad(DENSITY[dimension], dimension=dimension)
    found = after(law, initial=initial)
    for i, n in enumerate(NUMBERS):
        ends = simulate(
            medium, e, initial, media=4, tracers=25_000, seed=n, max_collisions=n,
            observables=["finals"], tangential_restitution=et,
        ).finals  # fmt: skip
        v, place = np.exp(ends[:, 0]), np.delete(ends[:, 2:], 2, axis=1)
        check(v**2, found.thermal_speed[i] ** 2)
        check(np.sqrt(v), found.moment(0.5)[i])
        gaussian = dimension / (dimension + 2.0)
        check(v**4, (found.a2[i] + 1.0) * found.thermal_speed[i] ** 4 / gaussian)
        check(np.sum(place**2, axis=1), found.msd[i])
        for coordinate in place.T:
            check(coordinate, 0.0)
            check(dimension * coordinate**2, found.msd[i])
        # of a Gaussian in the plane, and where a bounce may stop a tracer, <1/v^2> is infinite
        if initial == "monoenergetic" and law.lowest_power == -np.inf:
            check(np.exp(ends[:, 1]), found.mean_time[i])


def test_a_gaussian_keeps_its_mean_time_in_space() -> None:
    """<1/v> = sqrt(2/pi)/U and E[1/s] = 2 (1 - e)/(1 - e^2): s^2 is uniform."""
    e, numbers = 0.6, [0, 1, 4]
    found = after(CollisionLaw(e, dimension=3), numbers).mean_time
    slower = 2.0 / (1.0 + e)
    exact = [np.sqrt(2.0 / np.pi) * sum(slower**k for k in range(n)) for n in numbers]
    np.testing.assert_allclose(found, exact, rtol=1e-9)


def test_harmonics_after_many_collisions() -> None:
    """Of a beam along x in space: E[s^p P_m]^N, also where that is negative or next to nothing."""
    law = CollisionLaw(0.9, dimension=3)
    found = after(law, [0, 1, 2, 3, 10**9], initial=Beam())
    q = law.quadrature
    for p, m in ((0.0, 1), (2.0, 2), (1.0, 3)):
        kept = q.weight @ (q.ratio**p * (1.0 - q.harmonic_loss(m)))
        exact = kept ** np.arange(4)
        np.testing.assert_allclose(found.harmonic(p, m)[:4].real, exact, rtol=0, atol=1e-13)
        assert found.harmonic(p, m)[-1] == 0.0
    other = AngularHarmonics({0: lambda v: np.exp(-v)})
    assert np.all(after(law, initial=other).harmonic(1.0, 1) == 0.0)
