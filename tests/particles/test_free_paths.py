"""Mean free paths, first flights, elastic diffusion and the dilute limit of fixed scatterers."""

from typing import Any

import numpy as np
import pytest
from scattered import Around, places

from particles import (
    BoltzmannGrad,
    HardDisks,
    HardSpheres,
    Poisson,
    PoissonSpheres,
    Positions,
    simulate,
)

FIRST: dict[str, Any] = dict(restitution=1.0, media=400, tracers=50, max_collisions=1)
MANY: dict[str, Any] = dict(media=100, tracers=100, max_collisions=20)


@pytest.mark.parametrize(("medium", "path", "run"), [
    (Poisson(0.1, 1000), 5.0, FIRST),
    (PoissonSpheres(0.2, count=3000), 5 / np.pi, FIRST),
    (BoltzmannGrad(0.04), 12.5, MANY),
    (BoltzmannGrad(0.04, dimension=3), 25 / np.pi, MANY),
    (BoltzmannGrad(0.5), 1.0, MANY | dict(initial="rest", field=2.0)),
    (BoltzmannGrad(0.5), 1.0, MANY | dict(heating=0.05, drag=0.05)),
])  # fmt: skip
def test_free_paths_are_exponential(medium: Any, path: float, run: dict[str, Any]) -> None:
    # Of overlapping scatterers the first ones only: those that do not cover the start are in the
    # way. Tracers of one medium share them, so the spread over media is the error; 4.5 sigma in
    # each bin. In a field the length is that along the parabola.
    found = simulate(medium, **dict(restitution=0.7) | run, seed=5,
                     observables=["free_path_histogram"])  # fmt: skip
    histogram = found.free_path_histogram
    p = -np.diff(np.exp(-histogram.edges / path))
    busy = p * found.collision_total > 60
    assert busy.sum() > 30
    shares = histogram.probability
    assert np.all(abs(shares.value[0] - p)[busy] < 4.5 * shares.error[0][busy])
    if isinstance(medium, BoltzmannGrad):
        assert found.statuses.collision_cap == run["media"] * run["tracers"]
        assert abs(found.mean_free_path.value - path) < 4 * found.mean_free_path.error


@pytest.mark.slow
@pytest.mark.parametrize(("density", "expected"), [(0.005, 0.970), (0.01, 0.947), (0.02, 0.908)])
def test_elastic_diffusion_among_overlapping_disks(density: float, expected: float) -> None:
    # D over Boltzmann's 3/8 l v, the slope of <r^2> between 60 and 180 free times. Measured before,
    # by another program, to 0.001 or 0.002.
    length, media = 0.5 / density, 8000
    medium = Poisson(density, int(density * (60 * length) ** 2))  # no tracer leaves the box
    times = np.array([60.0, 180.0]) * length
    run = simulate(
        medium, 1.0, "monoenergetic", times=times, media=media, tracers=8, seed=3,
        observables=["positions"],
    )  # fmt: skip
    r2 = np.sum(run.positions**2, axis=-1).reshape(2, media, 8).mean(axis=-1)
    ratios = (r2[1] - r2[0]) / (times[1] - times[0]) / (1.5 * length)
    error = ratios.std() / np.sqrt(media)
    assert error < 0.006
    assert abs(ratios.mean() - expected) < 0.002 + 3 * error


def free_volume_and_surface(medium: Any, seed: int, c: int, points: int) -> tuple[float, float]:
    """Volume that is left to a tracer and its surface: random places, in the box and on the
    scatterers, that none covers."""
    rng, d = np.random.default_rng(1), medium.dimension
    around = Around(medium, seed, c)
    free = np.mean(around.nearest(rng.uniform(0, around.box, (points, d)))[0] > 1) * around.box**d
    normals = rng.normal(size=(points, d))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    own = places(medium, seed, c)[rng.integers(medium.count, size=points)]
    exposed = np.mean(around.nearest(own + (1 + 1e-9) * normals)[0] > 1)
    return free, exposed * {2: 2 * np.pi, 3: 4 * np.pi}[d] * medium.count


SANTALO = [HardDisks(0.1, 4000), HardSpheres(0.3, count=4000), PoissonSpheres(0.1, count=4000)]


@pytest.mark.slow
@pytest.mark.parametrize("medium", SANTALO)
def test_the_mean_free_path_is_that_of_santalo(medium: Any) -> None:
    # pi V/S in the plane, 4 V/S in space, of what a tracer's centre is free to visit.
    media = 12
    run = simulate(medium, 1.0, "monoenergetic", times=[1500.0], media=media, tracers=60, seed=6)
    parts = [free_volume_and_surface(medium, 6, c, 40_000) for c in range(media)]
    volume, surface = np.sum(parts, axis=0)
    path, expected = run.mean_free_path, {2: np.pi, 3: 4.0}[medium.dimension] * volume / surface
    assert path.error < 0.01 * path.value
    # The integral by random places: 0.3 % or so.
    assert abs(path.value - expected) < 3.5 * np.hypot(path.error, 0.003 * expected)
    if isinstance(medium, PoissonSpheres):  # any density (Santalo)
        assert abs(path.value * np.pi * medium.number_density - 1) < 0.015


@pytest.mark.parametrize(("medium", "more"), [
    (BoltzmannGrad(0.04), {}), (BoltzmannGrad(0.04, diameter=2.0, dimension=3), {}),
    (HardDisks(0.1, 200, diameter=0.5), {}), (PoissonSpheres(0.1, count=300), {}),
    (BoltzmannGrad(0.04), dict(field=1e-13)), (HardDisks(0.1, 200), dict(field=1e-13)),
    (BoltzmannGrad(0.04, dimension=3), dict(bath_speed=1e-13)),
])  # fmt: skip
def test_at_speed_one_a_flight_lasts_as_long_as_it_is(medium: Any, more: dict[str, Any]) -> None:
    names = ["free_path_histogram", "free_time_histogram"]
    run = simulate(medium, 1.0, "monoenergetic", times=[40.0], media=4, tracers=50, seed=2,
                   observables=names, **more)  # fmt: skip
    paths, times = (getattr(run, name) for name in names)
    first, last = np.searchsorted(times.edges, paths.edges[0]), times.edges.size - 1
    assert times.edges[first] == paths.edges[0]
    shares = paths.probability.value[0, : last - first]
    # one flight may round into the next bin
    np.testing.assert_allclose(
        times.probability.value[0, first:], shares, atol=1.5 / run.collision_total
    )
    assert shares.sum() > 0.99


def test_the_free_path_in_a_square_lattice() -> None:
    """Santalo's formula: the mean free path is pi times free area over perimeter, 4 sigma.

    In a cell of side a around a disk of the collision distance 1 it is (a^2 - pi)/2.
    """
    side = 3.0
    cells = 4
    centres = (np.arange(cells) + 0.5) * side
    x, y = np.meshgrid(centres, centres)
    lattice = Positions(np.column_stack([x.ravel(), y.ravel()]), box_side=cells * side)
    run = simulate(lattice, restitution=1.0, times=[20.0, 20_000.0], media=20, tracers=10, seed=3)
    path = run.mean_free_path
    assert abs(path.value - (side**2 - np.pi) / 2.0) < 4.0 * path.error
    assert path.error < 0.01
