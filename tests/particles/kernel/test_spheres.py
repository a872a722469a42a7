"""Tracers among spheres: every event, free paths, the limit of low density."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import cKDTree

from particles import BoltzmannGrad, Ensemble, HardSpheres, PoissonSpheres, simulate
from particles.grid.build import positions_in_space

INSIDE = 1e-13  # no tracer is nearer to a sphere than 1 - INSIDE; rounding of 100 d is 1e-14
Spheres = HardSpheres | PoissonSpheres


def tree_of(medium: Spheres, seed: int, configuration: int = 0) -> tuple[cKDTree, float]:
    positions, box = positions_in_space(medium, np.uint64(seed), configuration), medium.box_side
    return cKDTree((positions + box / 2) % box, boxsize=box), box


def nearest(tree: cKDTree, box: float, places: np.ndarray, k: int = 1) -> tuple:
    return tree.query((places + box / 2) % box, k=k)


def stopped_after(
    medium: Spheres, law: tuple[float, float], collisions: int, tracers: int, seed: int
) -> Ensemble:
    return simulate(
        medium, law[0], media=1, tracers=tracers, max_collisions=collisions, seed=seed,
        observables=["finals"], tangential_restitution=law[1],
    )  # fmt: skip


@pytest.mark.parametrize(
    ("medium", "law"),
    [
        (HardSpheres(0.03, count=3000), (0.7, 1.0)),
        pytest.param(HardSpheres(0.4, count=3000), (1.0, 1.0), marks=pytest.mark.slow),
        pytest.param(PoissonSpheres(0.03, count=3000), (0.9, 0.4), marks=pytest.mark.slow),
        (PoissonSpheres(0.2, count=3000), (0.5, 1.0)),
    ],
)
def test_every_event(medium: Spheres, law: tuple[float, float]) -> None:
    # The same tracers stopped after 1, 2, ... collisions: in contact, nothing in the way, and the
    # rule of the collision from the geometry alone.
    tracers, seed = 10_000, 11
    tree, box = tree_of(medium, seed)
    seen = 0
    before: tuple[np.ndarray, ...] | None = None
    direction = None
    for n in range(1, 9):
        run = stopped_after(medium, law, n, tracers, seed)
        finals = run.finals
        alive = finals[:, 4] == n
        assert alive.sum() >= tracers - run.statuses.trapped
        place = finals[:, [2, 3, 5]]
        distance, struck = nearest(tree, box, place, 2)
        assert np.all(distance[:, 0] > 1 - INSIDE)
        assert np.all(distance[:, 0] < 1 + 1e-12)
        normal = place + box / 2 - tree.data[struck[:, 0]]
        normal -= box * np.round(normal / box)
        if before is not None:
            old, old_normal, old_alone = before
            flight = place - old[:, [2, 3, 5]]
            length = np.linalg.norm(flight, axis=1)
            alone = distance[:, 1] > 1 + 1e-8  # in no corner
            clear = alive & alone & old_alone & (length > 1e-5)
            seen += clear.sum()
            elapsed = np.exp(finals[:, 1]) - np.exp(old[:, 1])
            np.testing.assert_allclose(
                elapsed[clear] * np.exp(old[clear, 0]), length[clear], rtol=1e-8, atol=1e-9
            )
            for f in np.linspace(0.1, 0.9, 5):
                between, _ = nearest(tree, box, old[clear][:, [2, 3, 5]] + f * flight[clear])
                assert np.all(between > 1 - INSIDE)
            u = flight / np.maximum(length, 1e-300)[:, None]
            across = np.sum(u * normal, axis=1)
            assert np.all(across[clear] < 1e-9)
            ratio = np.sqrt(law[1] ** 2 - (law[1] ** 2 - law[0] ** 2) * across**2)
            loss = finals[:, 0] - old[:, 0]
            firm = clear & (length > 1e-3)
            np.testing.assert_allclose(np.exp(loss[firm]), ratio[firm], rtol=1e-8)
            if direction is not None:
                # Momentum at the bounce between the two flights: et tangential, -e normal.
                old_u, old_clear = direction
                w = np.sum(old_u * old_normal, axis=1)[:, None]
                v = law[1] * old_u - (law[0] + law[1]) * w * old_normal
                v /= np.linalg.norm(v, axis=1)[:, None]
                both = firm & old_clear
                np.testing.assert_allclose(u[both], v[both], rtol=0, atol=1e-9)
            direction = u, firm
        before = finals, normal, distance[:, 1] > 1 + 1e-8
    assert seen > 0.6 * 7 * tracers


@pytest.mark.slow
@pytest.mark.parametrize("kind", [HardSpheres, PoissonSpheres])
def test_no_tracer_is_inside_a_sphere_in_1e8_events(kind: type[Spheres]) -> None:
    # pytest -m slow -k 1e8_events: 1e8 collisions of each medium at l = 10 d, and the places of all
    # tracers at 20 times among them.
    medium = kind(0.1 / np.pi, count=40_000)
    tracers, times = 20_000, np.linspace(2_000, 52_000, 20)
    run = simulate(
        medium, 1.0, "monoenergetic", times=times, media=1, tracers=tracers, seed=2,
        observables=["positions"],
    )  # fmt: skip
    assert run.collision_total > 1e8
    assert run.statuses.finished == tracers
    tree, box = tree_of(medium, 2)
    for places in run.positions:
        assert nearest(tree, box, places)[0].min() > 1 - INSIDE


def test_outputs_are_never_inside_a_sphere() -> None:
    medium = PoissonSpheres(0.2, count=4000)
    tree, box = tree_of(medium, 12)
    run = simulate(
        medium, 0.5, times=np.geomspace(0.01, 1e4, 40), media=1, tracers=5000, seed=12,
        observables=["positions"],
    )  # fmt: skip
    distance, _ = nearest(tree, box, run.positions.reshape(-1, 3))
    assert 1 - INSIDE < distance.min() < 1 + 1e-4


@pytest.mark.parametrize(
    ("density", "count"),
    [
        (0.02, 3000),
        (0.2, None),
        pytest.param(0.02, None, marks=pytest.mark.slow),
        pytest.param(0.2, 3000, marks=pytest.mark.slow),
    ],
)
def test_free_paths_among_overlapping_spheres_are_exponential(
    density: float, count: int | None
) -> None:
    # The first flights, of tracers in many media: only spheres that do not cover the start are
    # in the way, so the chance of a path x is exp(-pi rho x) exactly; 4.5 sigma in each bin.
    run = simulate(
        PoissonSpheres(density, count=count), 1.0, media=6000 if count is None else 400,
        tracers=1 if count is None else 50, max_collisions=1, seed=5,
        observables=["free_path_histogram"],
    )  # fmt: skip
    histogram = run.free_path_histogram
    p = -np.diff(np.exp(-np.pi * density * histogram.edges))
    found = histogram.probability
    busy = p * run.collision_total > 60
    assert busy.sum() > 30
    # Tracers of one medium share the spheres about the start: the spread over media is the error.
    assert np.all(abs(found.value[0] - p)[busy] < 4.5 * found.error[0][busy])


def free_volume_over_surface(medium: Spheres, seed: int, media: int, points: int) -> float:
    """4V/S of what is left to a tracer: random places, and random places on the spheres, that no
    sphere covers."""
    rng = np.random.default_rng(1)
    free = exposed = 0.0
    for c in range(media):
        tree, box = tree_of(medium, seed, c)
        free += np.mean(nearest(tree, box, rng.uniform(0, box, (points, 3)))[0] > 1) * box**3
        normals = rng.normal(size=(points, 3))
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        own = rng.integers(medium.count, size=points)
        distance, _ = tree.query((tree.data[own] + (1 + 1e-9) * normals) % box)
        exposed += np.mean(distance > 1) * 4 * np.pi * medium.count
    return 4 * free / exposed


@pytest.mark.parametrize(
    "medium",
    [
        pytest.param(HardSpheres(0.1, count=4000, equilibrate=10), marks=pytest.mark.slow),
        pytest.param(HardSpheres(0.3, count=4000, equilibrate=10), marks=pytest.mark.slow),
        PoissonSpheres(0.1, count=4000),
    ],
)
def test_the_mean_free_path_is_4_free_volumes_over_the_exposed_surface(medium: Spheres) -> None:
    media = 12
    run = simulate(medium, 1.0, "monoenergetic", times=[1500.0], media=media, tracers=60, seed=6)
    path = run.mean_free_path
    expected = free_volume_over_surface(medium, 6, media, 40_000)
    assert path.error < 0.01 * path.value
    # The integral by random places: 0.3 % or so.
    assert abs(path.value - expected) < 3.5 * np.hypot(path.error, 0.003 * expected)
    if isinstance(medium, HardSpheres):
        # One more sphere of the same fluid is what a tracer is: 1/(pi rho g) (Carnahan & Starling).
        phi = np.pi / 6 * medium.number_density
        enskog = (1 - phi) ** 3 / (1 - phi / 2) / (np.pi * medium.number_density)
        assert abs(path.value / enskog - 1) < 0.03
    else:  # any density (Santalo)
        assert abs(path.value * np.pi * medium.number_density - 1) < 0.015


@pytest.mark.parametrize("law", [(0.8, 0.6), pytest.param((0.3, 1.0), marks=pytest.mark.slow)])
@pytest.mark.parametrize("kind", [HardSpheres, PoissonSpheres])
def test_at_low_density_collisions_are_those_of_a_dilute_gas(
    kind: type[Spheres], law: tuple[float, float]
) -> None:
    # E[s^p] = 2 (et^(p+2) - e^(p+2))/((p+2)(et^2 - e^2)) and the mean cosine, both from E over y^2
    # uniform on [0, 1]. Recollisions change them by the order of rho d^3 = 1e-4.
    e, et = law
    medium = kind(1e-4, count=20_000)
    tracers = 20_000
    one, two, three = (stopped_after(medium, law, n, tracers, 8).finals for n in (1, 2, 3))
    s = np.exp(two[:, 0] - one[:, 0])
    for p in (1, 2, 4):
        expected = 2 * (et ** (p + 2) - e ** (p + 2)) / ((p + 2) * (et**2 - e**2))
        assert abs(np.mean(s**p) - expected) < 4 * np.std(s**p) / np.sqrt(tracers)
    places = [f[:, [2, 3, 5]] for f in (one, two, three)]
    flights = [b - a for a, b in pairwise(places)]
    u, v = (f / np.linalg.norm(f, axis=1)[:, None] for f in flights)
    cosine = np.sum(u * v, axis=1)
    y = np.sqrt((np.arange(20_000) + 0.5) / 20_000)
    expected = np.mean(((e + et) * y**2 - e) / np.sqrt(e**2 + (et**2 - e**2) * y**2))
    assert abs(cosine.mean() - expected) < 4 * cosine.std() / np.sqrt(tracers)
    # No direction about the old one is preferred: the z component across it averages to 0.
    across = (v - cosine[:, None] * u)[:, 2]
    assert abs(across.mean()) < 4 * across.std() / np.sqrt(tracers)


@pytest.mark.parametrize("law", [(0.4, 1.0), pytest.param((0.8, 0.6), marks=pytest.mark.slow)])
def test_the_dilute_limit_is_that_of_random_free_paths(law: tuple[float, float]) -> None:
    density = 1e-3
    length = 1 / (np.pi * density)
    times = np.array([1.0, 5.0, 30.0]) * length
    runs = [
        simulate(
            medium, law[0], times=times, media=40, tracers=500, seed=4,
            tangential_restitution=law[1],
        )
        for medium in (PoissonSpheres(density), BoltzmannGrad(density, dimension=3))
    ]  # fmt: skip
    for name in ("thermal_speed", "a2", "msd", "collisions", "velocity_autocorrelation"):
        a, b = (getattr(run, name) for run in runs)
        sigmas = (a.value - b.value) / np.hypot(a.error, b.error)
        assert np.all(abs(sigmas) < 4), (name, sigmas)
