"""The event sequence, against a brute-force simulator in 40 digits."""

import importlib.util
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest

from particles import Positions, simulate

_SPEC = importlib.util.spec_from_file_location(
    "reference_simulator", Path(__file__).with_name("reference_simulator.py")
)
reference = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(reference)

EVENTS = 8  # each multiplies an error by some 2 l/d: about 1e-16 10^8 in all


def scene(seed: int, overlapping: bool) -> tuple[np.ndarray, float, np.ndarray]:
    """Return disks around a tracer at (0, 0), the box and the tracer's velocity."""
    rng = np.random.default_rng(seed)
    box = 20.0
    disks: list[np.ndarray] = []
    while len(disks) < 50:
        new = rng.uniform(-box / 2, box / 2, 2)
        gaps = [np.hypot(*((new - d + box / 2) % box - box / 2)) for d in disks]
        if np.hypot(*new) > 1.0 and (overlapping or not gaps or min(gaps) > 1.0):
            disks.append(new)
    return np.array(disks), box, rng.normal(size=2)


def events(
    disks: np.ndarray, box: float, velocity: np.ndarray, law: tuple[float, float], n: int
) -> list[np.ndarray]:
    """Return ln v, ln t, x, y after 1, 2, ..., n collisions."""
    medium = Positions(disks, box, start=(0.0, 0.0))
    return [
        simulate(
            medium, law[0], velocity[None], media=1, tracers=1, max_collisions=k,
            observables=["finals"], workers=1, tangential_restitution=law[1],
        ).finals[0]
        for k in range(1, n + 1)
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("law", "overlapping"),
    [
        ((0.8, 1.0), False),
        ((0.9, 0.4), True),
        *(
            pytest.param(law, overlapping, marks=pytest.mark.slow)
            for law in (
                (0.8, 1.0), (0.9, 0.4), (0.0, 1.0), (0.3, 1.0), (1.0, 1.0), (0.3, 0.8), (0.7, 0.0),
            )
            for overlapping in (False, True)
        ),
    ],
)  # fmt: skip
def test_the_first_events_are_those_of_the_reference(
    overlapping: bool, law: tuple[float, float]
) -> None:
    compared = 0
    for seed in range(8):
        disks, box, velocity = scene(100 + seed, overlapping)
        expected = reference.follow(disks, box, velocity, law, EVENTS, 40)
        found = events(disks, box, velocity, law, EVENTS)
        error = 1e-15
        for k, (t, x, y, vx, vy, _) in enumerate(expected, 1):
            ln_v, ln_t, fx, fy, n = found[k - 1]
            if n < k:
                break  # trapped
            compared += 1
            # What chaos makes of the first rounding; a wrong event is of order 1.
            error *= 20
            assert abs(fx - float(x)) < error + 1e-13
            assert abs(fy - float(y)) < error + 1e-13
            assert abs(ln_t - float(mp.log(t))) < 10 * error + 1e-13
            assert abs(ln_v - float(mp.log(vx**2 + vy**2) / 2)) < 10 * error + 1e-13
    assert compared >= 6 * EVENTS


def test_outputs_between_events_are_on_the_reference_path() -> None:
    for seed in range(5):
        disks, box, velocity = scene(200 + seed, True)
        path = reference.follow(disks, box, velocity, (0.6, 1.0), 4, 40)
        begun = [(0.0, 0.0, 0.0, *velocity)] + [tuple(map(float, e[:5])) for e in path[:-1]]
        ended = [float(e[0]) for e in path]
        # Three times within each of the first four flights.
        times = [
            b[0] + f * (t - b[0])
            for b, t in zip(begun, ended, strict=True)
            for f in (0.1, 0.5, 0.9)
        ]
        ensemble = simulate(
            Positions(disks, box, start=(0.0, 0.0)), 0.6, velocity[None], times=times,
            media=1, tracers=1, observables=["positions", "velocities"],
        )  # fmt: skip
        for k, t in enumerate(times):
            t0, x, y, vx, vy = begun[k // 3]
            place = [x + (t - t0) * vx, y + (t - t0) * vy]
            np.testing.assert_allclose(ensemble.positions[k, 0], place, rtol=0, atol=1e-9)
            np.testing.assert_allclose(ensemble.velocities[k, 0], [vx, vy], rtol=1e-9)
            assert ensemble.collisions.value[k] == k // 3


def test_elastic_paths_are_reversible() -> None:
    # Six collisions out and back: an error grows by some 2 l/d at each, 1e-16 to about 1e-6.
    turned = 0
    for seed in range(20):
        disks, box, velocity = scene(300 + seed, False)
        end = events(disks, box, velocity, (1.0, 1.0), 7)
        # Half way between the sixth and the seventh.
        t6, t7 = np.exp(end[5][1]), np.exp(end[6][1])
        there = simulate(
            Positions(disks, box, start=(0.0, 0.0)), 1.0, velocity[None],
            times=[(t6 + t7) / 2], media=1, tracers=1, observables=["positions", "velocities"],
        )  # fmt: skip
        place, arrived = there.positions[0, 0], there.velocities[0, 0]
        assert there.collisions.value[0] == 6
        if np.hypot(*((disks - place + box / 2) % box - box / 2).T).min() < 1.0:
            continue  # by rounding, when the seventh flight is very short
        back = simulate(
            Positions(disks, box, start=tuple(place)), 1.0, -arrived[None],
            times=[(t6 + t7) / 2], media=1, tracers=1, observables=["positions", "velocities"],
        )  # fmt: skip
        turned += 1
        np.testing.assert_allclose(back.positions[0, 0], -place, rtol=0, atol=1e-6)
        np.testing.assert_allclose(back.velocities[0, 0], -velocity, rtol=0, atol=1e-6)
    assert turned >= 18
