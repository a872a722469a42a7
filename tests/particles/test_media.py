"""Where scatterers stand: distances, densities, what cells list; bad media."""

import os
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scattered import Around, places
from scipy.spatial import cKDTree

from particles import HardDisks, HardSpheres, Poisson, PoissonSpheres, Positions, simulate
from particles.cells import SLOTS, Cells
from particles.media import Medium
from particles.placement import build

HARD = {2: HardDisks, 3: HardSpheres}
OVERLAPPING = {2: Poisson, 3: PoissonSpheres}
both = pytest.mark.parametrize("dimension", [2, 3])


@both
@pytest.mark.parametrize("density", [0.04, 0.6])
def test_hard_scatterers_do_not_overlap(dimension: int, density: float) -> None:
    medium = HARD[dimension](density, count=1500)
    around, own = Around(medium), places(medium)
    assert around.nearest(own, 2)[0][:, 1].min() >= 1.0 - 1e-12
    assert np.linalg.norm(own, axis=1).min() >= 1.0
    assert abs(own).max() <= medium.box_side / 2
    others = np.concatenate((own, places(medium, 1, 1), places(medium, 2)))
    assert len(np.unique(others, axis=0)) == 4500


@both
@pytest.mark.parametrize("exclusion", [0.3, 1.5, 2.0])
def test_scatterers_keep_their_distance_from_each_other_and_from_the_start(
    exclusion: float, dimension: int
) -> None:
    d = 3.0
    density = 0.5 / (exclusion * d) ** dimension if exclusion > 1.0 else 0.6 / d**dimension
    medium = HARD[dimension](density, count=1500, diameter=d, exclusion=exclusion * d)
    around, own = Around(medium), places(medium)
    nearest = around.nearest(own, 2)[0][:, 1].min()
    assert exclusion - 1e-12 <= nearest < 1.1 * exclusion
    assert 1.0 <= np.linalg.norm(own, axis=1).min() < 2.0
    assert abs(own).max() <= medium.box_side / d / 2


@both
def test_scatterers_without_exclusion_are_those_of_poisson(dimension: int) -> None:
    medium = HARD[dimension](0.3, count=800, exclusion=0.0)
    assert np.array_equal(places(medium), places(OVERLAPPING[dimension](0.3, count=800)))


@both
@pytest.mark.parametrize("exclusion", [0.4, 1.6])
def test_a_tracer_of_another_size_collides_at_the_diameter(
    exclusion: float, dimension: int
) -> None:
    """And its mean free path is what the space that it is free to visit makes it (Santalo).

    Spheres of contact that do not reach each other, as for exclusion 2, leave a volume of 1 - n V1,
    the surface n S1. Smaller ones overlap, and the mean path is that of Poisson for exclusion 0.
    """
    density = 0.05
    paths = []
    for medium in (
        HARD[dimension](density, count=2000, exclusion=exclusion),
        HARD[dimension](density, count=2000, exclusion=2.0),
        OVERLAPPING[dimension](density, count=2000),
    ):
        run = simulate(medium, 1.0, "monoenergetic", [400.0], 8, 60, seed=4)
        paths.append(run.mean_free_path)
    between, far, none = paths
    ball = {2: np.pi, 3: 4 * np.pi / 3}[dimension]
    mean_chord = {2: np.pi, 3: 4.0}[dimension] / (dimension * ball)
    expected_far = mean_chord * (1 - density * ball) / density
    assert abs(far.value - expected_far) < 4 * far.error + 0.005 * expected_far
    assert abs(none.value - mean_chord / density) < 4 * none.error + 0.005 * none.value
    assert far.value < between.value < none.value


def test_media_whose_scatterers_have_no_room_are_refused() -> None:
    for exclusion in (-0.1, 2.1, np.nan):
        with pytest.raises(ValueError, match=r"^exclusion: got"):
            HardDisks(0.01, exclusion=exclusion)
    with pytest.raises(ValueError, match=r"number_density: .* at most 0.1625"):
        HardDisks(0.2, exclusion=2.0)
    with pytest.raises(ValueError, match=r"number_density: .* at most 1 "):
        HardSpheres(1.2, exclusion=0.1)
    with pytest.raises(ValueError, match=r"^count: .* exclusions wide"):
        HardDisks(0.1, count=6, exclusion=2.0)
    assert HardDisks(0.2).exclusion == 1.0
    assert HardDisks(0.05, diameter=2.0) == HardDisks(0.05, diameter=2.0, exclusion=2.0)


def test_the_area_of_disks_is_that_of_their_own_diameter() -> None:
    assert HardDisks(0.1, exclusion=2.0).area_fraction == pytest.approx(0.1 * np.pi)


@both
def test_scatterers_are_uniform(dimension: int) -> None:
    # Counts in 125 (121) parts: chi^2 of 124 +- 16; below 4 sigma = 190. Exclusion makes hard ones
    # more even, so only the upper side is theirs.
    per_side = {2: 11, 3: 5}[dimension]
    parts_in_all, n = per_side**dimension, 200 * per_side**dimension
    for medium, low in (
        (OVERLAPPING[dimension](0.1, count=n), 60),
        (HARD[dimension](0.1, count=n), 0),
    ):
        parts = np.floor((places(medium, 3) / medium.box_side + 0.5) * per_side).astype(int)
        number = parts @ [per_side**k for k in range(dimension)]
        counts = np.bincount(number, minlength=parts_in_all)
        assert low < np.sum((counts - 200) ** 2) / 200 < 190


def listed(cells: Cells, cell: int) -> np.ndarray:
    """Return what a cell lists, from its centre."""
    n, dimension = cells.fill[cell], len(cells.shape)
    found = cells.slots[cell].reshape(dimension, SLOTS).T[: min(n, SLOTS)].tolist()
    node = cells.head[cell]
    while node >= 0:
        found.append(cells.nodes[node].tolist())
        node = cells.links[node]
    assert len(found) == n
    return np.array(found).reshape(-1, dimension)


@both
@pytest.mark.parametrize(("density", "count"), [(0.03, 300), (0.03, 3000), (0.9, 200)])
@pytest.mark.parametrize("given", [False, True])
def test_a_cell_lists_what_can_be_touched_in_it(
    density: float, count: int, dimension: int, given: bool
) -> None:
    medium: Medium = OVERLAPPING[dimension](density, count=count)
    own, box = places(medium, 5), medium.box_side
    if given and dimension == 2:
        medium = Positions(own + 3.0, box, start=(3.0, 3.0))
    cells = build(medium, np.uint64(5), 0)
    assert cells is not None
    n, side = cells.shape[0], cells.side
    shifts = np.array(list(product((-1, 0, 1), repeat=dimension)))
    images = (own + box * shifts[:, None]).reshape(-1, dimension)
    # Every cell of the corner and of the middle, whose neighbours lie across the box's faces.
    for index in product(sorted({0, 1, n // 2, n - 1}), repeat=dimension):
        around = images - (np.array(index) - n // 2) * side
        gaps = np.maximum(abs(around) - side / 2, 0.0)
        expected = around[np.linalg.norm(gaps, axis=1) <= 1.0]
        found = listed(cells, int(np.ravel_multi_index(index, cells.shape)))
        assert cKDTree(found).query(expected)[0].max(initial=0) < 1e-9
        assert len(found) - len(expected) in (0, 1)  # by the margin of 1e-7


def test_a_scatterer_that_finds_no_room_is_counted() -> None:
    def place_many() -> None:
        for seed in range(50):
            places(HardSpheres(0.65, count=45), seed)

    with pytest.raises(ValueError, match=r"only \d+ of 45 spheres could be placed"):
        place_many()


def test_positions_from_csv(tmp_path: Path) -> None:
    positions = np.random.default_rng(5).uniform(0, 4, (30, 2))
    path = tmp_path / "disks.csv"
    rows = "\n".join(f"{x!r},{y!r}" for x, y in positions.tolist())
    expected = Positions(positions, 10.0, start=(7.0, 7.0))
    for text in (rows, "x,y\n" + rows + "\n\n", '"x","y"\n' + rows):
        path.write_text(text)
        assert Positions.from_csv(path, 10.0, start=(7.0, 7.0)) == expected
    for contents, words in (
        (b"x,y\n1.0,2.0\n1.0,two\n", "two columns of numbers .*two.* at row 1"),
        (b"x,y\n", "holds no positions"),
        (b"", "holds no positions"),
        (bytes(range(256)), "two columns of numbers"),
        (b"1,2\n" + b"3," * 9000, "two columns of numbers"),
    ):
        path.write_bytes(contents)
        with pytest.raises(ValueError, match=f"disks.csv: .*{words}") as caught:
            Positions.from_csv(path, 10.0)
        assert "\n" not in str(caught.value)
    with pytest.raises(ValueError, match=r"none.csv: .*No such file"):
        Positions.from_csv(tmp_path / "none.csv", 10.0)
    (tmp_path / "zero.csv").symlink_to("/dev/zero")
    os.mkfifo(tmp_path / "pipe.csv")
    for name in ("zero.csv", "pipe.csv"):  # neither ends
        with pytest.raises(ValueError, match="it must be a file"):
            Positions.from_csv(tmp_path / name, 10.0)


def test_a_set_of_positions_for_each_configuration() -> None:
    sets = np.random.default_rng(6).uniform(0, 6, (3, 20, 2))
    arguments: Any = dict(restitution=0.5, times=[30.0], tracers=5, observables=["positions"])
    together = simulate(Positions(sets, 10.0, start=(8.0, 8.0)), media=3, **arguments)
    alone = simulate(Positions(sets[0], 10.0, start=(8.0, 8.0)), media=1, **arguments)
    assert np.array_equal(together.positions[:, :5], alone.positions)
    with pytest.raises(ValueError, match="media: got 2; it must be 3, the sets"):
        simulate(Positions(sets, 10.0, start=(8.0, 8.0)), media=2, **arguments)
