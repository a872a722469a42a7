"""Tracers that remember their last collisions: between the Boltzmann-Grad limit and Poisson."""

from pathlib import Path

import numpy as np
import pytest

from particles import BoltzmannGrad, Ensemble, ForgetfulPoisson, Poisson, path_integrals, simulate

POWERS = [(1, 0.0), (2, 0.0), (0, 1.0), (1, 1.0)]
PATHS = [1.0, 4.0, 12.0]
ALL = 300  # more collisions than a tracer makes


def walk(memory: int, collisions: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Places of one elastic tracer, from its start on, and the scatterers it has met.

    Runs of the same seed and fewer collisions are the beginning of one and the same path.
    """
    places = [np.zeros(2)]
    for n in range(1, collisions + 2):
        run = simulate(
            ForgetfulPoisson(0.3, memory), 1.0, media=1, tracers=1, max_collisions=n, seed=seed,
            observables=["finals"], workers=1,
        )  # fmt: skip
        places.append(run.finals[0, 2:4])
    path = np.array(places)
    flights = np.diff(path, axis=0)
    directions = flights / np.hypot(*flights.T)[:, None]
    normals = np.diff(directions, axis=0)
    normals /= np.hypot(*normals.T)[:, None]
    return path[:-1], path[1:-1] - normals


def distances(path: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """From each scatterer to each flight, (scatterers, flights)."""
    begin, along = path[:-1], np.diff(path, axis=0)
    share = np.einsum("sfk,fk->sf", centres[:, None] - begin, along) / np.sum(along**2, axis=1)
    near = begin + np.clip(share, 0.0, 1.0)[..., None] * along
    return np.linalg.norm(centres[:, None] - near, axis=2)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_with_a_whole_memory_no_scatterer_is_in_the_way_of_any_flight(seed: int) -> None:
    path, centres = walk(ALL, 60, seed)
    assert distances(path, centres).min() > 1.0 - 1e-6
    # and scatterers are met again, at the very places where they were
    apart = np.linalg.norm(centres[:, None] - centres, axis=2)
    assert np.count_nonzero(np.triu(apart < 1e-6, 1)) > 3
    assert np.count_nonzero(np.triu((apart > 1e-6) & (apart < 1e-3), 1)) == 0


@pytest.mark.parametrize("memory", [0, 1, 3])
def test_what_is_remembered_holds_and_what_is_forgotten_does_not(memory: int) -> None:
    broken = 0
    for seed in (1, 2, 3):
        path, centres = walk(memory, 60, seed)
        apart = distances(path, centres)
        for met in range(len(centres)):
            # Scatterer `met` ends flight `met`. Flights that it was remembered in or that were
            # remembered when it was met: the last `memory` before, and as many after its own.
            known = apart[met, max(met - memory, 0) : met + memory + 1]
            assert known.min() > 1.0 - 1e-6
        broken += np.count_nonzero(apart < 0.9)
    assert broken > 10


@pytest.mark.parametrize("e", [0.5, 1.0])
def test_no_memory_is_the_boltzmann_grad_limit(e: float) -> None:
    """Other random numbers, the same law: mean square displacement, speed, number of collisions."""
    runs = [
        simulate(medium, e, times=[5.0, 50.0, 500.0], media=100, tracers=100, seed=seed)
        for medium, seed in ((BoltzmannGrad(0.1), 1), (ForgetfulPoisson(0.1, 0), 2))
    ]
    for name in ("msd", "thermal_speed", "collisions", "velocity_autocorrelation", "kurtosis"):
        a, b = (getattr(run, name) for run in runs)
        sigma = np.hypot(a.error, b.error) + 1e-12
        assert np.all(abs(a.value - b.value) < 3.5 * sigma), name


@pytest.mark.slow
@pytest.mark.parametrize("e", [0.5, 1.0])
def test_a_whole_memory_is_a_poisson_medium(e: float) -> None:
    """Also against the unbounded plane, whose scatterers are drawn by their places."""
    n = 0.1
    whole, plane, none = (
        path_integrals(medium, e, POWERS, PATHS, windows=2, settling=5.0, media=m, tracers=t)
        for medium, m, t in (
            (ForgetfulPoisson(n, ALL), 100, 200), (Poisson(n, box=None), 500, 40),
            (ForgetfulPoisson(n, 0), 100, 200),
        )
    )  # fmt: skip
    a, b, c = whole.integrals, plane.integrals, none.integrals
    assert np.all(abs(a.value - b.value) < 3.5 * np.hypot(a.error, b.error) + 1e-12)
    # The same test tells the medium without a memory from it.
    assert np.any(abs(c.value - b.value) > 8.0 * np.hypot(c.error, b.error) + 1e-12)
    paths = whole.mean_free_path, plane.mean_free_path
    assert abs(paths[0].value - paths[1].value) < 3.5 * np.hypot(paths[0].error, paths[1].error)
    if e == 1.0:  # Santalo: overlapping disks leave the mean free path as it is
        assert abs(paths[0].value - 1.0) < 3.5 * paths[0].error
        assert paths[0].error < 0.003


def test_tracers_are_trapped_between_remembered_disks_only() -> None:
    runs = [
        simulate(ForgetfulPoisson(0.2, k), 0.2, times=[1e4], media=4, tracers=100)
        for k in (0, 1, 2, 50)
    ]
    trapped = [run.statuses.trapped for run in runs]
    assert trapped[:2] == [0, 0]
    assert min(trapped[2:]) > 20
    assert all(run.statuses.finished == 400 - t for run, t in zip(runs, trapped, strict=True))
    assert np.all(runs[3].trapped == trapped[3])


def test_it_is_saved_and_resumed(tmp_path: Path) -> None:
    arguments = dict(restitution=0.7, times=[1.0, 20.0], media=3, tracers=4)
    run = simulate(ForgetfulPoisson(0.2, 3), **arguments, output=tmp_path / "run.h5")
    assert Ensemble.load(tmp_path / "run.h5") == run
    assert run.medium.memory == 3
    with pytest.raises(ValueError, match="holds another run"):
        simulate(ForgetfulPoisson(0.2, 4), **arguments, output=tmp_path / "run.h5", resume=True)


def test_the_unit_of_length_changes_nothing() -> None:
    one = simulate(ForgetfulPoisson(0.25, 5), 0.7, times=[2.0, 8.0], media=2, tracers=9)
    other = simulate(ForgetfulPoisson(1.0, 5, 0.5), 0.7, times=[1.0, 4.0], media=2, tracers=9)
    assert np.allclose(one.msd.value, 4.0 * other.msd.value, rtol=1e-12)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((0.1, -1), "memory = -1"),
        ((0.1, 1.5), "memory = 1.5"),
        ((0.1, 1001), "memory = 1001: .*1000"),
        ((2.0, 1), "number_density = 2.0: must be at most 1"),
        ((0.0, 1), "number_density = 0.0"),
        ((1e-11, 1), "below use BoltzmannGrad"),
        ((0.1, 1, -1.0), "diameter = -1.0"),
    ],
)
def test_bad_media_are_refused(arguments: tuple, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        ForgetfulPoisson(*arguments)
