"""The events among spheres in a box, against a brute-force simulator in 40 digits."""

import importlib.util
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest

from particles import HardSpheres, PoissonSpheres, simulate
from particles.grid.build import build, positions_in_space
from particles.grid.cells import SLOTS, Cells
from particles.grid.space import make, place

_SPEC = importlib.util.spec_from_file_location(
    "reference_simulator", Path(__file__).with_name("reference_simulator.py")
)
reference = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(reference)

EVENTS = 6  # each multiplies an error by some 2 l/d: about 1e-16 10^6 in all
LAWS = [(0.0, 1.0), (0.3, 1.0), (0.8, 1.0), (1.0, 1.0), (0.3, 0.8), (0.9, 0.4), (0.7, 0.0)]


@pytest.mark.parametrize(
    ("medium", "law"),
    [
        (PoissonSpheres(0.2, count=40), (0.3, 1.0)),
        (PoissonSpheres(0.2, count=40), (0.9, 0.4)),
        (HardSpheres(0.15, count=30), (0.3, 0.8)),
        *(
            pytest.param(medium, law, marks=pytest.mark.slow)
            for medium in (PoissonSpheres(0.2, count=40), HardSpheres(0.15, count=30))
            for law in LAWS
        ),
    ],
)
def test_the_first_events_are_those_of_the_reference(
    medium: PoissonSpheres | HardSpheres, law: tuple[float, float]
) -> None:
    compared = 0
    for seed in range(3):
        spheres = positions_in_space(medium, np.uint64(seed), 0)
        velocity = np.random.default_rng(seed).normal(size=3)
        expected = reference.follow(spheres, medium.box_side, velocity, law, EVENTS, 40)
        error = 1e-15
        for k, (t, *state, _) in enumerate(expected, 1):
            run = simulate(
                medium, law[0], velocity[None], media=1, tracers=1, max_collisions=k, seed=seed,
                observables=["finals"], workers=1, tangential_restitution=law[1],
            )  # fmt: skip
            ln_v, ln_t, x, y, n, z = run.finals[0]
            if n < k:
                break  # trapped
            compared += 1
            # What chaos makes of the first rounding; a wrong event is of order 1.
            error *= 40
            for found, exact in zip((x, y, z), state[:3], strict=True):
                assert abs(found - float(exact)) < error + 1e-13
            assert abs(ln_t - float(mp.log(t))) < 10 * error + 1e-13
            speed = mp.sqrt(reference.dot(state[3:], state[3:]))
            assert abs(ln_v - float(mp.log(speed))) < 10 * error + 1e-13
    assert compared >= 2 * EVENTS


def test_unbounded_space_has_the_events_of_its_spheres() -> None:
    # The spheres within 8 d of the start, taken out of the cells; paths that stay within 5 d.
    medium, seed = PoissonSpheres(0.15, count=None), 3
    cells = build(medium, np.uint64(seed), 0)
    assert cells is not None
    spheres = within(cells, 8.0)
    rng = np.random.default_rng(1)
    compared = 0
    for velocity in rng.normal(size=(12, 3)):
        velocity /= np.linalg.norm(velocity)
        path = reference.follow(spheres, None, velocity, (0.6, 1.0), 4, 40)
        for k, (_, *state, _) in enumerate(path, 1):
            if np.linalg.norm(np.array(state[:3], float)) > 5.0:
                break
            run = simulate(
                medium, 0.6, velocity[None], media=1, tracers=1, max_collisions=k, seed=seed,
                observables=["finals"], workers=1,
            )  # fmt: skip
            found = run.finals[0, [2, 3, 5]]
            np.testing.assert_allclose(found, np.array(state[:3], float), rtol=0, atol=1e-9)
            compared += 1
    assert compared > 15


def within(cells: Cells, radius: float) -> np.ndarray:
    """Return the spheres of unbounded space with centres so near the origin."""

    n = int(radius / cells.side) + 1
    found = set()
    for i in range(-n, n + 1):
        for j in range(-n, n + 1):
            for k in range(-n, n + 1):
                make(cells, i, j, k)
                cell = place(i, j, k)
                rows = cells.slots[cell].reshape(3, SLOTS).T[: cells.fill[cell]].tolist()
                node = cells.head[cell]
                while node >= 0:
                    rows.append(cells.nodes[node].tolist())
                    node = cells.links[node]
                here = np.array(rows).reshape(-1, 3)
                own = np.all(abs(here) <= cells.side / 2, axis=1)
                found.update(map(tuple, here[own] + np.array([i, j, k]) * cells.side))
    spheres = np.array(sorted(found))
    return spheres[np.linalg.norm(spheres, axis=1) < radius]
