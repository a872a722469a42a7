"""Lengths and durations of free flights: closed forms, particles, and what is refused."""

import itertools
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from kinetics import (
    Beam,
    Monoenergetic,
    Scene,
    SpeedDensity,
    SpeedSamples,
    VelocitySamples,
    solve,
)
from particles import BoltzmannGrad, simulate

EDGES = np.geomspace(0.1, 50.0, 40)


def flights(e: float, times: Any, **scene: Any) -> Any:
    return solve(Scene(e, 0.04, times=times, outputs=("collisions",), **scene), rtol=1e-6)


def test_of_one_speed_that_is_kept() -> None:
    # up to T (T - s) e^-s/l of T/l flights are longer than s, and than x = s
    found, times = flights(1.0, [0.0, 10.0, 50.0], initial="monoenergetic"), np.array([10.0, 50.0])
    longer = np.maximum(times[:, None] - EDGES, 0.0) * np.exp(-EDGES / 12.5) / times[:, None]
    for shares in (found.free_time_fraction(EDGES), found.free_path_fraction(EDGES)):
        np.testing.assert_allclose(shares[1:], -np.diff(longer), atol=1e-12)
        assert np.isnan(shares[0]).all()


def step(v: Any) -> Any:
    """A density of the speed that is the same from 0.4321 to 1.7777, and 0 elsewhere."""
    return np.where((np.asarray(v) > 0.4321) & (np.asarray(v) < 1.7777), 1.0 / 1.3456, 0.0)


@pytest.mark.parametrize("last", [0.5, 3.0])
@pytest.mark.parametrize(
    ("initial", "density", "slowest", "fastest"),
    [
        ("gaussian", lambda v: v * np.exp(-0.5 * v * v), 0.0, 9.0),
        (SpeedDensity(step), step, 0.4321, 1.7777),
    ],
    ids=["gaussian", "step"],
)
def test_flights_of_elastic_tracers_are_those_of_the_speeds_at_the_start(
    initial: Any, density: Any, slowest: float, fastest: float, last: float
) -> None:
    """Up to T there are e^-x int v f(v) (T - x/v) dv flights longer than x, v > x/T, for l = 1."""
    edges = np.array([0.0, 0.3, 0.7, 1.1, 2.0, 3.3])
    scene = Scene(1.0, 0.5, initial=initial, times=[last], outputs=("collisions",))
    solution = solve(scene, rtol=1e-8)

    def longer_in_length(x: float) -> float:
        ends = np.linspace(max(x / last, slowest), max(x / last, fastest), 10)
        pieces = [
            quad(lambda v: density(v) * (v * last - x), low, high, epsabs=1e-13)[0]
            for low, high in itertools.pairwise(ends)
        ]
        return float(np.exp(-x) * sum(pieces))

    def longer_in_time(s: float) -> float:
        ends = np.linspace(slowest, fastest, 10)
        pieces = [
            quad(lambda v: density(v) * v * np.exp(-v * s), low, high, epsabs=1e-13)[0]
            for low, high in itertools.pairwise(ends)
        ]
        return max(last - s, 0.0) * sum(pieces)

    for fraction, longer in (
        (solution.free_path_fraction, longer_in_length),
        (solution.free_time_fraction, longer_in_time),
    ):
        numbers = np.array([longer(edge) for edge in edges])
        np.testing.assert_allclose(fraction(edges)[0], -np.diff(numbers) / numbers[0], atol=1e-9)


@pytest.mark.parametrize("initial", ["gaussian", "monoenergetic"])
def test_no_flight_is_completed_at_time_0(initial: str) -> None:
    scene = Scene(0.9, initial=initial, times=[0.0, 1.0], outputs=("collisions",))
    solution = solve(scene, rtol=1e-3)
    for fraction in (solution.free_time_fraction, solution.free_path_fraction):
        shares = fraction([0.0, 1.0, 5.0])
        assert np.isnan(shares[0]).all()
        assert np.isfinite(shares[1]).all()


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_late_lengths_are_exponential_and_durations_are_not(e: float) -> None:
    found = flights(e, [1e2, 1e4, 1e8], dimension=3)
    exponential = -np.diff(np.exp(-EDGES / found.scene.mean_free_path))
    first, middle, last = abs(found.free_path_fraction(EDGES) - exponential).max(axis=1)
    # of the flights T cuts off one for each tracer, of T/l of them or of some ln T
    assert last < (1e-6 if e == 1.0 else 0.7 * middle)
    assert middle < 0.8 * first
    assert abs(found.free_time_fraction(EDGES)[-1] - exponential).max() > 1e-3


@pytest.mark.parametrize(
    ("e", "dimension", "initial"),
    [(0.0, 3, "gaussian"), (1.0, 2, "gaussian"), (0.5, 3, "monoenergetic")],
)  # fmt: skip
def test_particles_have_the_same_flights(e: float, dimension: int, initial: str) -> None:
    names = ("free_path", "free_time")
    run = simulate(BoltzmannGrad(0.04, dimension=dimension), e, initial, times=[60.0], media=60,
                   tracers=200, seed=3,
                   observables=[f"{name}_histogram" for name in names])  # fmt: skip
    scene = Scene(e, 0.04, dimension=dimension, initial=initial, times=[60.0])
    found = solve(scene, rtol=1e-6 if initial == "gaussian" else 1e-3)
    for name in names:
        seen = getattr(run, f"{name}_histogram")
        expected = getattr(found, f"{name}_fraction")(seen.edges)[0]
        busy = expected * run.collision_total > 100
        off = abs(seen.probability.value[0] - expected)[busy] / seen.probability.error[0, busy]
        assert busy.sum() > 60
        assert off.max() < 4.5  # of about 100 bins, errors from 60 configurations


BINS = [0.0, 0.05, 0.1, 0.2, 0.5]


def particle_flights(
    speeds: list[float], e: float, last: float, tracers: int = 200_000
) -> tuple[Any, Any, int]:
    """Shares of free paths and of free times in BINS by Monte Carlo in the plane, for l = 1."""
    rng = np.random.default_rng(1)
    v = rng.choice(speeds, tracers)
    t = np.zeros(tracers)
    lengths, durations = [], []
    while v.size:
        length = rng.exponential(size=v.size)
        t = t + length / v
        is_completed = t < last
        lengths.append(length[is_completed])
        durations.append((length / v)[is_completed])
        v, t = v[is_completed], t[is_completed]
        squared_cosine = 1.0 - rng.uniform(size=v.size) ** 2  # of the impact parameter
        v = v * np.sqrt(1.0 - (1.0 - e * e) * squared_cosine)
    paths, times = np.concatenate(lengths), np.concatenate(durations)
    shares = [np.histogram(x, BINS)[0] / x.size for x in (paths, times)]
    return shares[0], shares[1], paths.size


@pytest.mark.filterwarnings("ignore::kinetics.ToleranceWarning")
@pytest.mark.parametrize("e", [0.6, 1.0])
@pytest.mark.parametrize("rtol", [0.1, 1e-4])
@pytest.mark.parametrize(
    ("initial", "sharp_speeds", "last"),
    [
        (Beam(0.0, Monoenergetic(1.3)), [1.3], 0.2),
        (SpeedSamples([1.0]), [1.0], 0.2),
        (SpeedSamples([0.5, 1.0, 2.2]), [0.5, 1.0, 2.2], 3.0),
        (Beam(0.3, SpeedSamples([0.5, 1.0, 1.0])), [0.5, 1.0, 1.0], 3.0),
        (VelocitySamples([[0.3, 0.4], [0.0, 2.2]]), [0.5, 2.2], 3.0),
    ],
    ids=["beam", "sample", "samples", "beam of samples", "velocities"],
)
def test_flights_of_sharp_speeds_are_those_of_particles(
    initial: Any, sharp_speeds: list[float], last: float, rtol: float, e: float
) -> None:
    """However tight the tolerance; the speed of a beam was taken to be 1."""
    scene = Scene(e, number_density=0.5, times=[last], outputs="collisions", initial=initial)
    solution = solve(scene, rtol=rtol)
    paths, times, count = particle_flights(sharp_speeds, e, last)
    for shares, expected in (
        (solution.free_path_fraction(BINS)[0], paths),
        (solution.free_time_fraction(BINS)[0], times),
    ):
        # flights of one tracer belong together: twice the binomial error, and five of these
        error = 2.0 * np.sqrt(np.maximum(expected, 1e-5) / count)
        assert np.all(abs(shares - expected) < 5.0 * error)


def test_flights_of_a_narrow_start_that_hardly_cools() -> None:
    """The spectral method would need 42,000 nodes there; the flights were refused for that."""
    width = 0.01

    def peak(v: Any) -> Any:
        distance = np.minimum(np.abs(v - 1.0) / width, 100.0)
        return np.exp(-0.5 * distance**2) / (width * np.sqrt(2.0 * np.pi))

    last = 0.75
    scene = Scene(0.992, 1.0 / np.pi, dimension=3, initial=peak, times=[last], outputs="collisions")
    edges = np.array([0.0, 0.2, 0.4, 0.7])
    found = solve(scene, rtol=1e-3).free_time_fraction(edges)[0]
    longer = (last - edges) * np.exp(-edges)  # of tracers that keep the speed 1
    np.testing.assert_allclose(found, -np.diff(longer) / last, atol=2e-3)
