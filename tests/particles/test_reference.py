"""The sequence of events and what is between them, against a brute-force simulator in 40 digits."""

from typing import Any

import mpmath as mp
import numpy as np
import pytest
import reference_simulator as reference
from scattered import places

from particles import HardDisks, HardSpheres, Poisson, PoissonSpheres, simulate

EVENTS = {2: 8, 3: 6}  # each multiplies an error by some 2 l/d: about 1e-16 10^8 in all
LAWS = [(0.8, 1.0), (0.9, 0.4), (0.0, 1.0), (0.3, 1.0), (1.0, 1.0), (0.3, 0.8), (0.7, 0.0)]
MEDIA: list[Any] = [
    HardDisks(0.12, 50), Poisson(0.12, 50), HardSpheres(0.15, count=30),
    PoissonSpheres(0.2, count=40),
]  # fmt: skip


@pytest.mark.parametrize("medium", MEDIA, ids=repr)
@pytest.mark.parametrize(
    "law", [*LAWS[:2], *(pytest.param(law, marks=pytest.mark.slow) for law in LAWS[2:])]
)
def test_the_first_events_are_those_of_the_reference(medium: Any, law: tuple[float, float]) -> None:
    compared, d = 0, medium.dimension
    for seed in range(2):
        velocity = np.random.default_rng(seed).normal(size=d)
        own = places(medium, seed)
        expected = reference.follow(own, medium.box_side, velocity, law, EVENTS[d], 40)
        error = 1e-15
        for k, (t, *state, _) in enumerate(expected, 1):
            run = simulate(
                medium, law[0], velocity[None], media=1, tracers=1, max_collisions=k, seed=seed,
                observables=["finals"], workers=1, tangential_restitution=law[1],
            )  # fmt: skip
            ln_v, ln_t, x, y, n, *z = run.finals[0]
            if n < k:
                break  # trapped
            compared += 1
            # What chaos makes of the first rounding; a wrong event is of order 1.
            error *= 40
            apart = np.array([x, y, *z]) - np.array(state[:d], float)
            assert abs(apart).max() < error + 1e-13
            assert abs(ln_t - float(mp.log(t))) < 10 * error + 1e-13
            speed = mp.sqrt(reference.dot(state[d:], state[d:]))
            assert abs(ln_v - float(mp.log(speed))) < 10 * error + 1e-13
    assert compared >= EVENTS[d]


@pytest.mark.parametrize("medium", MEDIA[1::2], ids=repr)
def test_outputs_between_events_are_on_the_reference_path(medium: Any) -> None:
    d = medium.dimension
    for seed in range(2):
        velocity = np.random.default_rng(50 + seed).normal(size=d)
        own = places(medium, seed)
        path = reference.follow(own, medium.box_side, velocity, (0.6, 1.0), 4, 40)
        begun = [np.array([0.0] * (d + 1) + [*velocity])]
        begun += [np.array(event[:-1], float) for event in path[:-1]]
        # Three times within each of the first four flights.
        times = [
            b[0] + f * (float(event[0]) - b[0])
            for b, event in zip(begun, path, strict=True)
            for f in (0.1, 0.5, 0.9)
        ]
        run = simulate(
            medium, 0.6, velocity[None], times=times, media=1, tracers=1, seed=seed,
            observables=["positions", "velocities"],
        )  # fmt: skip
        for k, t in enumerate(times):
            now, place, moving = np.split(begun[k // 3], [1, d + 1])
            expected = place + (t - now) * moving
            np.testing.assert_allclose(run.positions[k, 0], expected, rtol=0, atol=1e-9)
            np.testing.assert_allclose(run.velocities[k, 0], moving, rtol=1e-9, atol=1e-9)
            assert run.collisions.value[k] == k // 3
