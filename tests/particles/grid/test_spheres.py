"""Where spheres stand: densities, distances, what cells list, space that does not change."""

import re
from itertools import product

import numpy as np
import pytest
from scipy.spatial import cKDTree

from particles import HardSpheres, PoissonSpheres
from particles.grid import space
from particles.grid.build import build, positions_in_space
from particles.grid.cells import SLOTS, Cells
from particles.grid.spheres import place_spheres


def listed(cells: Cells, cell: int) -> np.ndarray:
    """Return what a cell lists, (n, 3), from its centre, sorted."""
    n = cells.fill[cell]
    found = cells.slots[cell].reshape(3, SLOTS).T[: min(n, SLOTS)].tolist()
    node = cells.head[cell]
    while node >= 0:
        found.append(cells.nodes[node].tolist())
        node = cells.links[node]
    assert len(found) == n
    return np.array(sorted(found)).reshape(-1, 3)


def in_space(cells: Cells, i: int, j: int, k: int) -> np.ndarray:
    space.make(cells, i, j, k)
    return listed(cells, space.place(i, j, k))


def within_reach(spheres: np.ndarray, half: float) -> np.ndarray:
    """Tell which spheres of radius 1 overlap a cube around the origin."""
    return np.linalg.norm(np.maximum(abs(spheres) - half, 0.0), axis=1) <= 1.0


@pytest.mark.parametrize("sweeps", [0, 10])
@pytest.mark.parametrize("density", [0.03, 0.6])
def test_hard_spheres_do_not_overlap(density: float, sweeps: int) -> None:
    medium = HardSpheres(density, count=1500, equilibrate=sweeps)
    positions, box = positions_in_space(medium, np.uint64(1), 0), medium.box_side
    tree = cKDTree((positions + box / 2) % box, boxsize=box)
    assert tree.query(tree.data, k=2)[0][:, 1].min() >= 1.0 - 1e-12
    assert np.linalg.norm(positions, axis=1).min() >= 1.0
    assert abs(positions).max() <= box / 2
    other = positions_in_space(medium, np.uint64(1), 1)
    assert len(positions) == len(np.unique(np.concatenate((positions, other)), axis=0)) / 2


def test_spheres_are_uniform() -> None:
    # Counts in 5 x 5 x 5 parts: chi^2 of 124 degrees, 124 +- 16; below 4 sigma = 190. Exclusion
    # makes hard spheres more even, so only the upper side is theirs.
    for medium, low in (
        (PoissonSpheres(0.1, count=25_000), 65),
        (HardSpheres(0.1, count=25_000), 0),
        (HardSpheres(0.1, count=25_000, equilibrate=3), 0),
    ):
        positions = positions_in_space(medium, np.uint64(3), 0)
        parts = np.floor((positions / medium.box_side + 0.5) * 5).astype(int)
        counts = np.bincount(parts @ [25, 5, 1], minlength=125)
        assert low < np.sum((counts - 200) ** 2) / 200 < 190


def test_equilibration_reaches_the_contact_value_of_equilibrium() -> None:
    # g at contact, from pairs within 3 % of it: (1 - phi/2)/(1 - phi)^3 in equilibrium (Carnahan &
    # Starling 1969), falling by some 10 % over the shell.
    phi = np.pi / 6 * 0.6
    shell = 4 / 3 * np.pi * (1.03**3 - 1)
    placed, moved = (
        positions_in_space(HardSpheres(0.6, count=4000, equilibrate=sweeps), np.uint64(1), 0)
        for sweeps in (0, 100)
    )
    assert np.mean(np.all(placed == moved, axis=1)) < 0.01
    box = HardSpheres(0.6, count=4000).box_side
    pairs = cKDTree((moved + box / 2) % box, boxsize=box).query_pairs(1.03)
    found = 2 * len(pairs) / (4000 * 0.6 * shell)
    assert -0.12 < found * (1 - phi) ** 3 / (1 - phi / 2) - 1 < 0


def test_steps_are_as_likely_forth_as_back() -> None:
    # The mean displacement in 4 sweeps, over 3000 spheres and 8 configurations, is 0 within 4 sigma
    # along each axis; sigma, some 0.004 d, from the spread over configurations.
    box, n = (3000 / 0.3) ** (1 / 3), 8
    means = np.empty((n, 3))
    for c in range(n):
        before, after = (place_spheres(box, 3000, False, s, np.uint64(4), c)[0] for s in (0, 4))
        moved = after - before
        means[c] = (moved - box * np.round(moved / box)).mean(axis=0)
    sigma = means.std(axis=0, ddof=1) / np.sqrt(n)
    assert np.all(sigma < 0.01)
    assert np.all(abs(means.mean(axis=0)) < 4 * sigma), (means.mean(axis=0), sigma)


def test_few_spheres_reach_the_equilibrium_that_rejection_draws() -> None:
    # 5 spheres in a box of 4 d, 2000 configurations after 40 sweeps against those of 60 000 without
    # an overlap: the mean squares of coordinates and the near pairs agree within 4 sigma.
    box, n = 4.0, 2000
    found = np.array(
        [place_spheres(box, 5, False, 40, np.uint64(9), c)[0] for c in range(n)]
    ).reshape(n, 5, 3)
    drawn = np.random.default_rng(1).uniform(-box / 2, box / 2, (60_000, 5, 3))

    def distances(spheres: np.ndarray) -> np.ndarray:
        with_start = np.concatenate([np.zeros((len(spheres), 1, 3)), spheres], axis=1)
        i, j = np.triu_indices(6, 1)
        apart = with_start[:, i] - with_start[:, j]
        return np.linalg.norm(apart - box * np.round(apart / box), axis=-1)

    drawn = drawn[np.all(distances(drawn) >= 1, axis=1)]
    assert len(drawn) > 5000
    statistics = [
        np.concatenate(
            [s.mean(axis=1), (s**2).mean(axis=1), (distances(s) < 1.3).mean(axis=1)[:, None]],
            axis=1,
        )
        for s in (found, drawn)
    ]
    error = np.sqrt(sum(s.var(axis=0) / len(s) for s in statistics))
    sigmas = (statistics[0].mean(axis=0) - statistics[1].mean(axis=0)) / error
    assert np.all(abs(sigmas) < 4), sigmas


@pytest.mark.parametrize(("density", "count"), [(0.03, 300), (0.03, 3000), (0.9, 200)])
def test_a_cell_of_a_box_lists_what_can_be_touched_in_it(density: float, count: int) -> None:
    medium = PoissonSpheres(density, count=count)
    cells = build(medium, np.uint64(5), 0)
    assert cells is not None
    positions, n, side = positions_in_space(medium, np.uint64(5), 0), cells.n, cells.side
    box = n * side
    images = np.concatenate([positions + box * np.array(m) for m in product((-1, 0, 1), repeat=3)])
    # Every cell of the corner and of the middle, whose neighbours lie across the box's faces.
    chosen = sorted({0, 1, n // 2, n - 1})
    for i, j, k in product(chosen, repeat=3):
        centre = (np.array([i, j, k]) - n // 2) * side
        around = images - centre
        expected = around[within_reach(around, side / 2)]
        found = listed(cells, (i * n + j) * n + k)
        distance, _ = cKDTree(found).query(expected)
        assert distance.max(initial=0) < 1e-9
        assert len(found) - len(expected) in (0, 1)  # by the margin of 1e-7


def test_a_cell_of_space_is_the_same_whoever_asks() -> None:
    medium = PoissonSpheres(0.2, count=None)
    one, other = (build(medium, np.uint64(7), 3) for _ in range(2))
    assert one is not None
    assert other is not None
    half = one.side / 2
    places = [(0, 0, 0), (1, 0, -1), (-3, 2, 5), (200, -100, 7)]
    first = {p: in_space(one, *p) for p in places}
    for p in reversed(places):
        again = in_space(other, *p)
        assert np.array_equal(first[p], again)
        for axis in range(3):  # the neighbour lists the same spheres about the common face
            step = np.eye(3, dtype=int)[axis]
            beyond = in_space(other, *(np.array(p) + step)) + one.side * step
            strips = [
                s[np.all(abs(s - half * step) < half - (half - 1) * step, axis=1)]
                for s in (again, beyond)
            ]
            np.testing.assert_allclose(*(s[np.lexsort(s.T)] for s in strips), atol=1e-9)
    assert not np.array_equal(in_space(build(medium, np.uint64(7), 4), 0, 0, 0), first[0, 0, 0])


@pytest.mark.parametrize("density", [0.003, 0.2, 1.0])
def test_numbers_in_space_are_poisson(density: float) -> None:
    # Spheres that 4000 cells, none near another or the start, list: mean and variance to 4 sigma.
    cells = build(PoissonSpheres(density, count=None), np.uint64(2), 0)
    assert cells is not None
    numbers = np.array([len(in_space(cells, 3 * k + 5, -7, k % 40)) for k in range(4000)])
    mean = density * space.listed_volume(cells.side)
    assert abs(numbers.mean() - mean) < 4 * np.sqrt(mean / 4000)
    spread = np.sqrt((2 * mean**2 + mean) / 4000)
    assert abs(numbers.var(ddof=1) - mean) < 4 * spread


def test_no_sphere_covers_the_start() -> None:
    for configuration in range(200):
        cells = build(PoissonSpheres(0.5, count=None), np.uint64(2), configuration)
        assert cells is not None
        assert np.linalg.norm(in_space(cells, 0, 0, 0), axis=1).min() >= 1.0


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: HardSpheres(0.7),
            "number_density = 0.7: at most 0.65 for HardSpheres of diameter",
        ),
        (lambda: HardSpheres(0.1, 2.0), "number_density = 0.1: at most 0.08125 for HardSpheres"),
        (lambda: PoissonSpheres(1.1), "number_density = 1.1: at most 1 for PoissonSpheres"),
        (lambda: PoissonSpheres(-1), "number_density = -1: must be a positive finite number"),
        (lambda: PoissonSpheres(0.1, 0.0), "diameter = 0.0: must be a positive finite number"),
        (
            lambda: PoissonSpheres(1e-11),
            "number_density = 1e-11: 1e-11 scatterers per d^3; at least",
        ),
        (lambda: HardSpheres(0.1, count=0), "count = 0: must be a whole number from 1 to"),
        (lambda: HardSpheres(0.1, count=None), "count = None: must be a whole number from 1 to"),
        (lambda: HardSpheres(0.1, equilibrate=-1), "equilibrate = -1: must be a whole number"),
        (lambda: PoissonSpheres(0.1, count=5), "count = 5: the box would be 3.68 d wide"),
    ],
)
def test_bad_input_gets_one_clear_line(make: object, message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)) as caught:
        make()  # type: ignore[operator]
    assert "\n" not in str(caught.value)


def test_spheres_that_find_no_room_are_counted() -> None:
    with pytest.raises(ValueError, match=r"only \d+ of 45 spheres could be placed; the largest"):
        _place_many(HardSpheres(0.65, count=45))


def _place_many(medium: HardSpheres) -> None:
    for seed in range(50):
        positions_in_space(medium, np.uint64(seed), 0)
