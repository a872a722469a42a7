"""Tracers that have collided once, of a start of one speed, and G(R) with its fronts."""

import dataclasses
import math
import tracemalloc

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import j0

from kinetics import Scene, Solution, SolverStatus, SpeedSamples, solve
from kinetics.collision import CollisionLaw
from kinetics.position.coupled_harmonics import eliminate, iterate
from kinetics.position.intermediate_scattering import Scattering
from kinetics.position.once_collided import Scatterer, once_collided, once_density
from kinetics.position.twice_collided import inner_fronts
from kinetics.states.isotropic import Monoenergetic

FloatArray = NDArray[np.float64]
PATH, PATH_IN_SPACE = 12.5, 25.0 / math.pi  # at the number density that is the default


def bounce(e: float, y: FloatArray, et: float = 1.0) -> tuple[FloatArray, FloatArray]:
    """Speed ratio and deflection at impact parameter y, written down again."""
    along, across = -e + (e + et) * y * y, (e + et) * y * np.sqrt(1.0 - y * y)
    return np.hypot(along, across), np.arctan2(across, along)


def one_speed(e: float, *flights: float, rtol: float = 1e-5, dimension: int = 2) -> Solution:
    """G(R) at T = v t/l."""
    path = PATH if dimension == 2 else PATH_IN_SPACE
    scene = Scene(
        e,
        initial="monoenergetic",
        dimension=dimension,
        times=path * np.array(flights),
        outputs=("msd", "position_density"),
    )
    return solve(scene, rtol=rtol)


SMOOTH = [(e, 1.0, 2) for e in (0.0, 1e-3, 0.37, 0.9, 1.0)]
SPHERES = [(e, 1.0, 3) for e in (0.0, 0.37, 1.0)]
ROUGH = [(0.37, 0.8), (0.9, 0.8), (0.6, 0.6), (0.5, 0.0), (0.0, 0.6)]


@pytest.mark.parametrize(
    ("e", "et", "dimension"),
    [*SMOOTH, *SPHERES, *((e, et, dimension) for e, et in ROUGH for dimension in (2, 3))],
)
@pytest.mark.parametrize(
    "T",
    [pytest.param(0.3, marks=pytest.mark.slow), 3.0, pytest.param(12.0, marks=pytest.mark.slow)],
)
def test_the_once_collided_against_the_integral_over_their_collision(
    e: float, et: float, dimension: int, T: float
) -> None:
    """Of exp(-x - s u) J_0(K R) over its place x and impact parameter y: smooth, no delta."""
    law = CollisionLaw(e, et, dimension)
    once = once_collided(law, Monoenergetic(), 1.0, np.array([T]), 0.0)
    once = dataclasses.replace(once, twice=False)
    node, weight = np.polynomial.legendre.leggauss(160)
    x = 0.5 * T * (1.0 + node)[:, None]
    u = 0.5 * math.pi * 0.5 * (1.0 + node)
    y, w = np.sin(u) ** 2, 0.5 * math.pi * 0.5 * weight * 2.0 * np.sin(u) * np.cos(u)
    s, turn = bounce(e, y, et)
    w = w if dimension == 2 else 2.0 * y * w
    share = np.exp(-x - s * (T - x)) * np.outer(0.5 * T * weight, w)
    r = np.abs(x + s * (T - x) * np.exp(1j * turn))
    of_waves = j0 if dimension == 2 else lambda x: np.sinc(x / math.pi)
    for k in (0.0, 1.0 / T, 10.0 / T, 60.0 / T):
        assert abs(once.scattering(0, np.array([k]))[0] - np.sum(share * of_waves(k * r))) < 1e-9
    assert abs(once.within(0, np.array([T]))[0] - share.sum()) < 1e-9
    # within one radius: the derivative of what is within is the density
    near = T * np.array([0.23, 0.55, 0.95])
    step = 1e-4 * T
    slope = (once.within(0, near + step) - once.within(0, near - step)) / (2.0 * step)
    density = once_density(near, T, Scatterer(e, et, dimension))
    assert np.abs(slope - density).max() < 1e-5 * density.max()


def turned(direction: FloatArray, turn: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Unit vectors (n, d) after a deflection; in space about a random axis across them."""
    if direction.shape[1] == 2:
        across = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
    else:
        across = np.cross(direction, rng.normal(size=direction.shape))
        across /= np.linalg.norm(across, axis=1)[:, None]
    return np.asarray(np.cos(turn)[:, None] * direction + np.sin(turn)[:, None] * across)


def twice_or_more(
    e: float, T: float, edges: FloatArray, count: int, dimension: int
) -> tuple[FloatArray, FloatArray]:
    """Shares between edges, and their deviations, of tracers with two collisions at least.

    Followed one after another in continuous angles: no wave number, no Bessel function. The
    first two collisions are made to happen, and weighed.
    """
    rng = np.random.default_rng(7)
    place = np.zeros((count, dimension))
    direction = place + np.eye(dimension)[0]
    left, speed, weight = np.full(count, T), np.ones(count), np.ones(count)
    for collision in range(40):
        longest = speed * left  # the path until T
        chance = -np.expm1(-longest)
        draw = rng.random(count)
        path = -np.log1p(-draw * chance) if collision < 2 else -np.log1p(-draw)
        weight = weight * chance if collision < 2 else weight
        path = np.minimum(path, longest)
        place += path[:, None] * direction
        left = np.where(path < longest, left - path / speed, 0.0)
        y = rng.random(count)
        ratio, turn = bounce(e, y if dimension == 2 else np.sqrt(y))
        # to either side in the plane
        turn = turn * rng.choice([-1.0, 1.0], count)
        speed, direction = speed * ratio, turned(direction, turn, rng)
        if not left.any():
            break
    which = np.searchsorted(edges, np.linalg.norm(place, axis=1)) - 1
    inside = (which >= 0) & (which < edges.size - 1)
    first, second = (
        np.bincount(which[inside], weight[inside] ** p, edges.size - 1) / count for p in (1, 2)
    )
    return first, np.sqrt((second - first**2) / count)


@pytest.mark.parametrize(
    ("e", "T", "dimension"),
    [
        (0.37, 0.3, 2),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in (
                (0.37, 3.0, 2),
                (1.0, 1.0, 2),
                (0.0, 0.5, 2),
                (0.9, 3.0, 2),
                (0.9, 1.0, 3),
                (0.37, 3.0, 3),
                (0.0, 0.5, 3),
            )
        ),
    ],
)
def test_all_collisions_against_followed_tracers(e: float, T: float, dimension: int) -> None:
    """Shares in bins whose deviations are some 1e-5: with fronts in them, and beside."""
    found = one_speed(e, T, dimension=dimension)
    edges = T * np.array([0.0, 0.1, 0.2, e, 0.35, 0.5, 0.7, 0.8, 0.95, 0.97, 0.99, 0.999])
    edges = np.unique(edges[edges < T])
    share, deviation = twice_or_more(
        e, T, edges, 200_000 if dimension == 2 else 2_000_000, dimension
    )
    displacement = found._displacement
    assert displacement is not None
    assert displacement.once is not None
    place = displacement.mean_free_path * edges
    once = dataclasses.replace(displacement.once, twice=False).within(0, place)
    all_others = found.position_fraction(place)[0] - np.diff(once)
    assert np.abs((all_others - share) / deviation).max() < 4.0
    assert deviation.max() < 1e-3


@pytest.mark.slow
def test_a_second_time_changes_nothing() -> None:
    alone, both = one_speed(0.37, 0.3), one_speed(0.37, 0.3, 3.0)
    r = PATH * np.linspace(0.01, 0.29, 30)
    assert np.array_equal(alone.position_density(r)[0], both.position_density(r)[0])


@pytest.mark.slow
def test_what_is_claimed_is_reached() -> None:
    """The error estimate holds up to 1/K from the fronts, K about 140/T at most."""
    cases = ((1.0, 1.0, 1e-5), (0.0, 0.3, 1e-5), (0.5, 1.0, 1e-5), (0.37, 0.3, 1e-4))
    for e, T, rtol in (*cases, (0.7, 0.05, 1e-4)):
        found, best = one_speed(e, T, rtol=rtol), one_speed(e, T, rtol=1e-7)
        assert found.status is SolverStatus.CONVERGED
        x = np.linspace(0.02, 0.98, 97)
        fronts = [1.0, *inner_fronts(e)]
        x = x[np.min([np.abs(x - a) for a in fronts], axis=0) > 0.03]
        apart = found.position_density(PATH * T * x) - best.position_density(PATH * T * x)
        assert np.sqrt(found.msd[0]) * np.abs(apart).max() < rtol


@pytest.mark.slow
@pytest.mark.parametrize(("e", "T", "dimension"), [(0.37, 10.0, 2), (0.2, 3.0, 3)])
def test_an_error_that_is_not_small_is_estimated_beside_the_fronts_too(
    e: float, T: float, dimension: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Against the same with twice the wave numbers, from 1/K on from the fronts."""
    found = one_speed(e, T, dimension=dimension)
    monkeypatch.setattr("kinetics.position.sweep._LARGEST_TURNS", 200.0)
    monkeypatch.setattr("kinetics.position.sweep._LARGEST_OF_PEAKS", 1.0)
    best = one_speed(e, T, rtol=1e-7, dimension=dimension)
    x = np.linspace(0.01, 0.99, 300)
    fronts = [1.0, *inner_fronts(e)]
    x = x[np.min([np.abs(x - a) for a in fronts], axis=0) > 0.01]
    r = T * x * (PATH if dimension == 2 else PATH_IN_SPACE)
    apart = found.position_density(r) - best.position_density(r)
    estimate = found.stats["position_density_error"]
    assert found.status is SolverStatus.TOLERANCE_NOT_REACHED
    assert np.sqrt(found.msd[0]) * np.abs(apart).max() < estimate


def test_asking_for_too_much_ends_and_says_so() -> None:
    little, much = one_speed(0.37, 3.0, rtol=1e-5), one_speed(0.37, 3.0, rtol=1e-8)
    for found in (little, much):
        assert found.status is SolverStatus.TOLERANCE_NOT_REACHED
        assert found.stats["position_density_error"] < 2e-3
    assert much.stats["wave_numbers"] < 1.5 * little.stats["wave_numbers"]


def test_a_few_speeds_are_solved_one_by_one_and_many_are_not() -> None:
    """Two speeds of which the slow one has hardly collided while the other is late."""
    law, speeds = CollisionLaw(1.0), [0.02, 1.0, 1.0]
    outputs = ("msd", "position_density")
    found, *each = (
        solve(Scene(law, initial=SpeedSamples(v), times=[500.0], outputs=outputs), rtol=1e-3)
        for v in (speeds, speeds[:1], speeds[1:])
    )
    assert found.status is SolverStatus.CONVERGED
    assert found._displacement is not None
    assert [share for share, _ in found._displacement.parts] == pytest.approx([1 / 3, 2 / 3])
    r = np.concatenate([np.linspace(0.05, 9.9, 100), np.linspace(10.1, 200.0, 100)])
    slow, fast = (one.position_density(r) for one in each)
    apart = found.position_density(r) - slow / 3.0 - fast * 2.0 / 3.0
    assert np.sqrt(found.msd[0]) * np.abs(apart[0]).max() < 2e-3
    edges = [0.0, 5.0, 9.9, 10.1, 500.0]
    slow, fast = (one.position_fraction(edges) for one in each)
    assert found.position_fraction(edges) == pytest.approx(slow / 3 + fast * 2 / 3, abs=2e-3)
    assert found.position_fraction(edges).sum() == pytest.approx(1.0, abs=1e-4)
    many = SpeedSamples(np.linspace(0.5, 1.5, 9))
    assert not once_collided(law, many, 1.0, np.array([1.0]), 1e-9).kept_apart(0)


def test_both_ways_to_solve_a_panel_agree() -> None:
    rng = np.random.default_rng(3)
    blocks = np.eye(7) * 3.0 + 0.2 * rng.normal(size=(9, 7, 7))
    turn, right, k = rng.random(7), rng.normal(size=(9, 7, 4)), np.array([0.1, 0.2, 0.4, 0.6])
    one, other = eliminate(blocks, turn, right, k), iterate(blocks, turn, right, k, 1e-14)
    assert other is not None
    assert np.abs(one - other).max() < 1e-12
    assert iterate(blocks, turn, right, 50.0 * k, 1e-15) is None


@pytest.mark.slow
def test_memory_is_bounded_where_collisions_may_stop_a_tracer() -> None:
    """At e = 0 speeds fall by any factor; all wave numbers at once would take gigabytes."""
    system = Scattering(CollisionLaw(0.0), 1.0, Monoenergetic(), np.array([1.0]))
    k = np.linspace(40.0, 60.0, 150)
    tracemalloc.start()
    found, error = system.whole(k, None, 1e-9)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert error < 1e-8
    assert peak < 1e9
    few, _ = system.whole(k[::50], None, 1e-9)
    assert np.abs(found[:, ::50] - few).max() < 1e-9
