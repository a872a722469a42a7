"""Grooves and pockets between spheres: who leaves, and how, and who is trapped."""

import numpy as np
import pytest
import reference_simulator as reference
from marking import slow_but

from particles import Ensemble, PoissonSpheres, placement, simulate
from particles.cells import empty_box, insert_all
from particles.kernel.pockets import FOR_EVER, LEAVES, RESTS, last_bounces

BOUNCES = 250
START = 1e-3  # from the groove or the pocket to the start of a tracer, in d


def around(angles: np.ndarray, steepness: float) -> np.ndarray:
    """Return spheres whose spheres of contact all pass through the point START below the origin.

    angles: of their centres about the vertical. steepness: of the planes that touch them there.
    """
    flat, down = np.cos(steepness), np.sin(steepness)
    centres = [[down * np.cos(a), down * np.sin(a), -flat] for a in angles]
    return np.array(centres) - [0.0, 0.0, START]


def drop(
    spheres: np.ndarray, law: tuple[float, float], monkeypatch: pytest.MonkeyPatch, n: int = 40
) -> tuple[Ensemble, np.ndarray]:
    """Send n tracers from the origin down to them; return the run and the initial velocities."""
    rng = np.random.default_rng(4)
    velocities = np.stack([*(0.6 * rng.uniform(-1, 1, (2, n))), -np.ones(n)], axis=1)
    medium = PoissonSpheres(len(spheres) / 30.0**3, count=len(spheres))
    cells = empty_box(30.0, len(spheres), 3)
    insert_all(cells, spheres)
    monkeypatch.setattr(placement, "build", lambda *_: cells)
    run = simulate(
        medium, law[0], velocities, times=[0.5], media=1, tracers=n, workers=1,
        observables=["velocities", "positions"], tangential_restitution=law[1],
    )  # fmt: skip
    return run, velocities


def between_planes(walls: np.ndarray, u: np.ndarray, law: tuple[float, float]) -> np.ndarray | None:
    """Bounce between planes, one after another; the last velocity, None if there is no end to it.

    walls (n, 4): normals and gaps. Gaps shrink relative to the others only, so no digit is lost.
    """
    normals, gap, v = walls[:, :3], walls[:, 3].copy(), u.copy()
    for _ in range(BOUNCES):
        w = normals @ v
        path = np.where(w < -1e-9 * np.linalg.norm(v), -gap / np.minimum(w, -1e-300), np.inf)
        k = int(np.argmin(path))
        if path[k] == np.inf:
            return v
        gap = np.maximum(gap + path[k] * w, 0.0)
        gap[k] = 0.0
        v = law[1] * v - (law[0] + law[1]) * w[k] * normals[k]
    return None


PLANES = [(0.1, 0.5), (0.3, 1.0), (0.05, 1.0), (0.4, 0.9)]


def end_and_error(walls: np.ndarray, u: np.ndarray, law: tuple[float, float]) -> tuple:
    """How it ends between these walls, and how far the last velocity is off; None without end."""
    end, found, ratio = last_bounces(walls.copy(), tuple(u), *law)
    expected = between_planes(walls, u, law)
    return end, None if expected is None else np.max(abs(ratio * np.array(found) - expected))


@pytest.mark.parametrize(
    "law", [PLANES[0], *(pytest.param(law, marks=pytest.mark.slow) for law in PLANES[1:])]
)
def test_three_planes_against_one_bounce_after_another(law: tuple[float, float]) -> None:
    rng = np.random.default_rng(7)
    ends, wrong = [0, 0, 0], 0
    for _ in range(500):
        angles = np.array([0.0, 2.1, 4.2]) + rng.uniform(-0.5, 0.5, 3)
        tilt = rng.uniform(0.05, 0.7, 3)  # small: the planes are steep, the pocket is narrow
        normals = np.stack(
            [-np.cos(tilt) * np.cos(angles), -np.cos(tilt) * np.sin(angles), np.sin(tilt)], axis=1
        )
        gaps = np.array([0.0, *rng.uniform(0.1, 1.0, 2)])
        walls = np.concatenate([normals, 1e-12 * gaps[:, None]], axis=1)
        u = rng.normal(size=3)
        u /= np.linalg.norm(u)
        if u @ normals[0] < 0:
            continue
        end, error = end_and_error(walls, u, law)
        ends[end] += 1
        if error is None:
            assert end != LEAVES
        elif error > 1e-5:
            assert end == FOR_EVER
            wrong += 1
    assert ends[LEAVES] > 50
    assert ends[RESTS] > 0
    assert (ends[FOR_EVER] > 1) == (law[1] == 1.0)
    # Where a groove leads a tracer into the point of the pocket itself, all gaps are 0 and the
    # order of the next bounces is that of rounding.
    assert wrong <= 0.02 * ends[FOR_EVER]


def test_a_third_plane_in_the_way_ends_a_groove_before_its_end() -> None:
    """Bounces between two planes that would never end: most end at the third, which is near."""
    rng, law, wrong = np.random.default_rng(7), (0.1, 1.0), 0
    for _ in range(500):
        across, up = rng.uniform(0.05, 0.25), rng.uniform(0.3, 1.2)
        normals = np.array([
            [-np.cos(across), 0.0, np.sin(across)], [np.cos(across), 0.0, np.sin(across)],
            [np.sin(0.3) * np.cos(up), -np.cos(0.3) * np.cos(up), np.sin(up)],
        ])  # fmt: skip
        walls = np.concatenate([normals, 1e-12 * np.array([[0.0], [1.0], [3.0]])], axis=1)
        u = np.array([-rng.uniform(0.4, 0.9), rng.uniform(0.3, 1.0), rng.uniform(-0.3, 0.1)])
        u /= np.linalg.norm(u)
        error = end_and_error(walls, u, law)[1]
        wrong += error is not None and error > 1e-5
    assert wrong <= 5  # of 500: a groove that leads into the point of the pocket


GROOVE, POCKET = (0.0, np.pi), (0.1, 2.2, 4.3)
CASES = [  # spheres at these angles, law, steepness; how many of 40 tracers are caught
    *((GROOVE, (e, 1.0), s, 0) for e in (0.05, 0.3, 0.7) for s in (0.3, 0.9, 1.2, 1.4)),
    # Between planes the third of these would bounce for ever; spheres curve away.
    (GROOVE, (0.1, 0.5), 1.25, 40), (GROOVE, (0.3, 0.5), 1.25, 0),
    (GROOVE, (0.1, 0.5), 1.217, 0), (GROOVE, (0.05, 0.9), 1.1, 40),
    (POCKET, (0.1, 1.0), 1.15, 0), (POCKET, (0.1, 1.0), 1.25, 40), (POCKET, (0.2, 1.0), 1.25, 0),
    (POCKET, (0.2, 1.0), 1.35, 40), (POCKET, (0.4, 1.0), 1.35, 0),
]  # fmt: skip
KEPT = [case for case in CASES if case[1][0] != 0.2 and case[2] not in (0.9, 1.4)]


@pytest.mark.parametrize(("angles", "law", "steepness", "caught"), slow_but(KEPT, CASES))
def test_who_is_caught_and_how_others_leave_is_what_the_reference_says(
    angles: tuple, law: tuple[float, float], steepness: float, caught: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    spheres, pocket = around(np.array(angles), steepness), angles == POCKET
    run, velocities = drop(spheres, law, monkeypatch)
    assert run.statuses.trapped == caught
    if pocket:
        end = np.array([0.0, 0.0, -START])
        assert np.all(np.linalg.norm(run.statuses.trap_places - end, axis=1) < 1e-7)
    for k in range(8):
        path = reference.follow(spheres, None, velocities[k], law, BOUNCES, 200 if pocket else 120)
        last = np.array(path[-1][4:7], float) if path else velocities[k]
        endless = len(path) == BOUNCES
        if angles == GROOVE and law[1] == 1.0:
            if endless:  # what is left runs along the groove
                along = np.array([0.0, np.linalg.norm(last), 0.0])
                np.testing.assert_allclose(abs(last), along, rtol=0, atol=1e-2)
        else:
            assert endless == (caught > 0)
        if pocket and caught:
            assert last @ last < 1e-16
            assert np.array_equal(run.velocities[0, k], [0.0, 0.0, 0.0])
            np.testing.assert_allclose(run.positions[0, k], end, atol=1e-7)
        elif not caught:
            # In a pocket a dozen bounces within 1e-9 d: rounding grows.
            bound = 1e-5 if pocket else 1e-6
            np.testing.assert_allclose(run.velocities[0, k], last, rtol=0, atol=bound)
