"""Where scatterers stand: densities, distances, the plane that is the same whoever asks."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from particles import BoltzmannGrad, HardDisks, Poisson, Positions, simulate
from particles.grid.blocks import listed, make_cell
from particles.grid.build import build
from particles.grid.cells import BLOCK, WINDOW, Cells
from particles.grid.equilibrate import centres


def in_box(medium: HardDisks | Poisson, seed: int = 1, configuration: int = 0) -> np.ndarray:
    cells = build(medium, np.uint64(seed), configuration)
    positions = np.empty((medium.count, 2))
    centres(cells, positions)
    return positions


def in_cell(cells: Cells, i: int, j: int) -> np.ndarray:
    """Return the scatterers that cell (i, j) of the plane lists, from the origin, sorted."""
    found = list(listed(cells, make_cell(cells, i, j)))
    return np.array(found).reshape(-1, 2) + np.array([i, j]) * cells.side


def in_plane(cells: Cells, n: int) -> np.ndarray:
    """Return all scatterers with centres in the cells -n to n, each once."""
    found = []
    for i in range(-n, n + 1):
        for j in range(-n, n + 1):
            disks = in_cell(cells, i, j)
            own = np.all(abs(disks - np.array([i, j]) * cells.side) <= cells.side / 2, axis=1)
            found.append(disks[own])
    return np.concatenate(found)


@pytest.mark.parametrize("equilibrate", [0, 20])
@pytest.mark.parametrize("density", [0.04, 0.5])
def test_hard_disks_do_not_overlap(density: float, equilibrate: int) -> None:
    medium = HardDisks(density, 2000, equilibrate=equilibrate)
    positions = in_box(medium)
    box = medium.box_side
    tree = cKDTree((positions + box / 2) % box, boxsize=box)
    distance, _ = tree.query(tree.data, k=2)
    assert distance[:, 1].min() >= 1.0 - 1e-12
    assert np.hypot(*positions.T).min() >= 1.0
    assert len(positions) == 2000


def test_scatterers_are_uniform() -> None:
    # Counts in 10 x 10 parts of the box: chi^2 of 99 degrees, 99 +- 14; below 4 sigma = 156.
    # (Exclusion makes hard disks more even, so only the upper side is theirs.)
    for medium, low in ((Poisson(0.1, 40_000), 43), (HardDisks(0.1, 40_000), 0)):
        positions = in_box(medium)
        parts = np.floor((positions / medium.box_side + 0.5) * 10).astype(int)
        counts = np.bincount(parts[:, 0] * 10 + parts[:, 1], minlength=100)
        assert low < np.sum((counts - 400) ** 2) / 400 < 156
    assert not np.array_equal(in_box(Poisson(0.1, 100)), in_box(Poisson(0.1, 100), 1, 1))
    assert not np.array_equal(in_box(Poisson(0.1, 100)), in_box(Poisson(0.1, 100), 2))


def test_equilibration_reaches_the_contact_value_of_equilibrium() -> None:
    # g at contact, from pairs within 5 % of it: (1 - 7 eta/16)/(1 - eta)^2 in equilibrium
    # (Henderson 1975), falling by some 10 % over the shell. Random addition has fewer.
    eta = np.pi / 4 * 0.5
    expected = (1 - 7 * eta / 16) / (1 - eta) ** 2
    found = []
    for sweeps in (0, 100):
        medium = HardDisks(0.5, 4000, equilibrate=sweeps)
        pairs = 0
        for c in range(4):
            positions = in_box(medium, configuration=c)
            box = medium.box_side
            tree = cKDTree((positions + box / 2) % box, boxsize=box)
            pairs += len(tree.query_pairs(1.05))
        shell = np.pi * (1.05**2 - 1)
        found.append(2 * pairs / (4 * 4000 * 0.5 * shell))
    assert -0.1 < found[1] / expected - 1 < 0
    assert found[0] < 0.93 * found[1]


@pytest.mark.parametrize("medium", [Poisson(0.04, box=None), HardDisks(0.3, box=None)])
def test_a_cell_of_the_plane_is_the_same_whoever_asks(medium: HardDisks | Poisson) -> None:
    one = build(medium, np.uint64(7), 3)
    other = build(medium, np.uint64(7), 3)
    side = one.side
    cells = [(i, j) for i in (-3, -1, 0, 1, 2, 3, 200) for j in (-2, 0, 3, 5)]
    first = {c: in_cell(one, *c) for c in cells}
    for c in reversed(cells):
        again = in_cell(other, *c)
        assert np.array_equal(first[c], again)
        # The neighbours list the same scatterers along the common edges.
        middle = np.array(c) * side
        for axis in (0, 1):
            neighbour = in_cell(other, c[0] + 1 - axis, c[1] + axis)
            strips = []
            for disks in (again, neighbour):
                x, y = (disks - middle).T[:: 1 - 2 * axis]
                strip = disks[(abs(x - side / 2) < 1) & (abs(y) < side / 2)]
                strips.append(strip[np.lexsort(strip.T)])
            np.testing.assert_allclose(*strips, atol=1e-9)
    assert not np.array_equal(in_cell(build(medium, np.uint64(7), 4), 0, 0), in_cell(one, 0, 0))


@pytest.mark.slow
def test_the_plane_has_the_density_asked_for() -> None:
    # Poisson: the count is Poisson, 4 sigma. Hard disks: more even, and 0.2 % for the series.
    for medium in (Poisson(0.04, box=None), Poisson(1.0, box=None)):
        cells = build(medium, np.uint64(1), 0)
        n = 60
        expected = medium.number_density * ((2 * n + 1) * cells.side) ** 2
        assert abs(len(in_plane(cells, n)) - expected) < 4 * np.sqrt(expected)
    for density in (0.04, 0.15, 0.3):
        cells = build(HardDisks(density, box=None), np.uint64(1), 0)
        n = 60
        disks = in_plane(cells, n)
        expected = density * ((2 * n + 1) * cells.side) ** 2
        sigma = np.sqrt(expected)  # an upper bound
        assert (
            abs(len(disks) - expected) < 2.5 * sigma * (1 - np.pi * density / 2) + 0.002 * expected
        )
        distance, _ = cKDTree(disks).query(disks, k=2)
        assert distance[:, 1].min() >= 1.0 - 1e-12
        assert np.hypot(*disks.T).min() >= 1.0


def test_hard_disks_of_the_plane_are_what_random_sequential_addition_keeps() -> None:
    # All candidates of 5 by 5 blocks, from their regions' streams, taken in the order of their
    # marks; what comes of it in the middle block does not depend on what lies beyond.
    from particles.grid import plane

    cells = build(HardDisks(0.3, box=None), np.uint64(3), 0)
    law, counts = cells.law, cells.counts
    for block in ((0, 0), (-1, 0), (7, -4)):
        candidates = []
        for p in range(2 * block[0] - 4, 2 * block[0] + 5):
            for q in range(2 * block[1] - 4, 2 * block[1] + 5):
                state, gamma = map(np.uint64, plane.open_region(law, p, q))
                for k in range(plane.count(counts, p, q, state)):
                    u, v = plane.spot(state, gamma, k)
                    x, y = u * plane.width(law, p), v * plane.width(law, q)
                    if plane.is_clear(law, p, q, x, y):
                        x += (p >> 1) * law.side + plane.begin(law, p) + law.edge
                        y += (q >> 1) * law.side + plane.begin(law, q) + law.edge
                        candidates.append((plane.mark(state, gamma, k), x, y))
        kept: list[tuple[float, float]] = []
        for _, x, y in sorted(candidates):
            if all((x - a) ** 2 + (y - b) ** 2 >= 1 for a, b in kept):
                kept.append((x, y))
        disks = np.array(kept)
        assert len(candidates) > 1.1 * len(kept)
        for i in range(block[0] << BLOCK, (block[0] + 1) << BLOCK):
            for j in range(block[1] << BLOCK, (block[1] + 1) << BLOCK):
                offset = abs(disks - np.array([i, j]) * cells.side) - cells.side / 2
                expected = disks[(offset < 1 - 1e-6).all(axis=1)]
                found = in_cell(cells, i, j)
                offset = abs(found - np.array([i, j]) * cells.side) - cells.side / 2
                found = found[(offset < 1 - 1e-6).all(axis=1)]
                np.testing.assert_allclose(
                    found[np.lexsort(found.T)], expected[np.lexsort(expected.T)], atol=1e-9
                )


@pytest.mark.parametrize("kind", [HardDisks, Poisson])
def test_tracers_far_apart_in_the_plane_do_not_take_each_others_cells(kind: type) -> None:
    # Tracers run together share the window of cells; alone, each has it for itself. They come so
    # far that places in the window are wanted by several at once.
    medium = kind(0.05, box=None)
    velocities = np.random.default_rng(4).normal(size=(8, 2))
    arguments = dict(restitution=1.0, max_collisions=60_000, media=1, observables=["finals"])
    together = simulate(medium, initial=velocities, tracers=8, **arguments).finals
    window = build(medium, np.uint64(1), 0).side * 2 ** (BLOCK + WINDOW)
    assert np.ptp(together[:, 2:4], axis=0).max() > 1.2 * window
    for one, velocity in zip(together, velocities, strict=True):
        alone = simulate(medium, initial=velocity[None], tracers=1, **arguments).finals
        np.testing.assert_array_equal(alone[0], one)


@pytest.mark.parametrize("kind", [HardDisks, Poisson])
def test_plane_and_box_agree(kind: type) -> None:
    # The same law of scatterers in two programs: 3.5 sigma for 8 numbers.
    arguments = dict(restitution=0.7, times=[20.0, 300.0], media=400, tracers=20)
    box = simulate(kind(0.15, 2000), seed=1, **arguments)
    plane = simulate(kind(0.15, box=None), seed=2, **arguments)
    for name in ("thermal_speed", "a2", "msd", "collisions"):
        a, b = getattr(box, name), getattr(plane, name)
        assert np.all(abs(a.value - b.value) < 3.5 * np.hypot(a.error, b.error)), name


@pytest.mark.slow
def test_mean_free_path_of_hard_disks_is_santalos() -> None:
    # pi A_free / perimeter: what a tracer's centre is free to visit, over the length of its border,
    # both of this configuration. Disks of radius 1 around the scatterers, by a fine grid of angles
    # and of points; elastic, so that a long path is uniform in the free area. 3 sigma.
    medium = HardDisks(0.1, 400)
    ratios = []
    for c in range(4):
        positions = in_box(medium, 5, c)
        box = medium.box_side
        tree = cKDTree((positions + box / 2) % box, boxsize=box)
        grid = (np.arange(1200) + 0.5) / 1200 * box
        covered, _ = tree.query(np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2))
        free = np.mean(covered >= 1.0) * box**2
        angles = (np.arange(2000) + 0.5) / 2000 * 2 * np.pi
        circle = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        rim = (tree.data[:, None, :] + circle).reshape(-1, 2) % box
        nearest, _ = tree.query(rim)
        border = np.mean(nearest >= 1.0 - 1e-9) * 2 * np.pi * len(positions)
        given = Positions(tree.data, box, start=(box / 2, box / 2))
        run = simulate(
            given, 1.0, "monoenergetic", times=[30_000.0], media=30, tracers=1, seed=c + 1
        )
        path = run.mean_free_path
        ratios.append((path.value / (np.pi * free / border) - 1, path.error / path.value))
    deviations, errors = np.array(ratios).T
    assert np.all(errors < 0.01)
    assert np.all(abs(deviations) < 4 * errors)
    assert abs(deviations.mean()) < 3 * np.sqrt(np.sum(errors**2)) / len(errors)


def test_positions_from_csv(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    positions = rng.uniform(0, 4, (30, 2))
    path = tmp_path / "disks.csv"
    rows = "\n".join(f"{x!r},{y!r}" for x, y in positions.tolist())
    arguments = dict(restitution=0.5, times=[3.0, 30.0], media=2, tracers=5)
    a = simulate(Positions(positions, 10.0, start=(7.0, 7.0)), **arguments)
    for text in (rows, "x,y\n" + rows + "\n\n"):
        path.write_text(text)
        b = simulate(Positions.from_csv(path, 10.0, start=(7.0, 7.0)), **arguments)
        assert np.array_equal(a.msd.value, b.msd.value)
    path.write_text("x,y\n1.0,2.0\n1.0,two\n")
    with pytest.raises(
        ValueError, match=r"disks.csv, line 3: \['1.0', 'two'\] must be two numbers"
    ):
        Positions.from_csv(path, 10.0)
    path.write_text("x,y\n")
    with pytest.raises(ValueError, match=r"disks.csv: holds no positions"):
        Positions.from_csv(path, 10.0)


@pytest.mark.parametrize(
    ("contents", "message"),
    [
        (bytes(range(256)), "disks.csv: must be a CSV file, text in UTF-8"),
        (b"1,2\n" + b"1" * 200_000 + b",2\n", "disks.csv: must be a CSV file, text in UTF-8"),
        (b"1,2\n3,\0004\n", "disks.csv, line 2: ['3', '\\x004'] must be two numbers"),
        (b"1,2\n" + b"3," * 9000, "disks.csv, line 2: ['3', '3', '3', '3',"),
    ],
)
def test_what_is_no_table_of_positions_is_refused(
    contents: bytes, message: str, tmp_path: Path
) -> None:
    path = tmp_path / "disks.csv"
    path.write_bytes(contents)
    with pytest.raises(ValueError, match=re.escape(message)) as caught:
        Positions.from_csv(path, 10.0)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 120 + len(str(path))


def test_positions_that_cannot_be_read_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"none.csv: cannot be read \(No such file"):
        Positions.from_csv(tmp_path / "none.csv", 10.0)
    with pytest.raises(ValueError, match=r"cannot be read \(Is a directory\)"):
        Positions.from_csv(tmp_path, 10.0)
    with pytest.raises(ValueError, match="path = 3: must be the path of a file"):
        Positions.from_csv(3, 10.0)


def test_a_set_of_positions_for_each_configuration() -> None:
    rng = np.random.default_rng(6)
    sets = rng.uniform(0, 6, (3, 20, 2))
    arguments = dict(restitution=0.5, times=[30.0], tracers=5, observables=["positions"])
    together = simulate(Positions(sets, 10.0, start=(8.0, 8.0)), media=3, **arguments)
    alone = simulate(Positions(sets[0], 10.0, start=(8.0, 8.0)), media=1, **arguments)
    assert np.array_equal(together.positions[:, :5], alone.positions)
    with pytest.raises(ValueError, match=r"media = 2: must be 3, the sets of positions given"):
        simulate(Positions(sets, 10.0, start=(8.0, 8.0)), media=2, **arguments)


BAD = [
    (lambda: Poisson(-1, 10), "number_density = -1: must be a positive finite number"),
    (lambda: Poisson(float("inf"), 10), "number_density = inf: must be a positive finite number"),
    (lambda: Poisson(1.0, 1), "count = 1: the box would be 1 d wide at number_density = 1.0; it"),
    (lambda: HardDisks(0.9, 1000), "number_density = 0.9: disks cannot be placed at random so"),
    (lambda: HardDisks(0.9, 1000), "at most 0.65 for diameter = 1.0"),
    (lambda: HardDisks(0.1, 0), "count = 0: must be a whole number from 1 to"),
    (lambda: HardDisks(0.1, 99, equilibrate=-1), "equilibrate = -1: must be a whole number from 0"),
    (lambda: HardDisks(0.1, box=None, equilibrate=5), "equilibrate = 5: needs box = 'periodic'"),
    (lambda: HardDisks(0.4, box=None), "number_density = 0.4: at most 0.3 in the unbounded plane"),
    (lambda: Poisson(0.1, 99, box=10.0), "box = 10.0: must be 'periodic', or None for the plane"),
    (lambda: BoltzmannGrad(0.1, diameter=float("nan")), "diameter = nan: must be a positive"),
    (lambda: Positions([[1, 2]], 3.0), "box_side = 3.0: must be at least 4 d = 4"),
    (lambda: Positions([[5.5, 5]], 10), "positions[0] = [5.5 5. ]: covers the start (5, 5)"),
    (lambda: Positions([[1, 1], [0, 9.2]], 10, start=(0, 0)), "positions[1] = [0.  9.2]: covers"),
    (lambda: Positions([[1, 1], [np.nan, 2]], 10), "positions[1] = [nan  2.]: must be finite"),
    (lambda: Positions([1, 2, 3], 10), "positions of shape (3,): must be (count, 2)"),
    (
        lambda: Positions([["a", "b"]], 10),
        "positions = [['a', 'b']]: must be an array of real numbers",
    ),
    (lambda: Positions([[1, 2]], 10, start=(1,)), "start = (1,): must be two finite numbers"),
    (lambda: Positions([[1, 2]], 10, start="ab"), "start = 'ab': must be two finite numbers"),
    (lambda: Positions([[1, 2j]], 10), "positions = [[1, 2j]]: must be an array of real numbers"),
    (lambda: Positions(np.ones((1, 2), complex), 10), "must be an array of real numbers"),
    (lambda: Positions(np.ma.masked_all((1, 2)), 10), "must be an array of real numbers"),
    (lambda: Positions([[1, 1e14]], 10), "[1.e+00 1.e+14]: more than 1e+12 boxes away"),
    (lambda: Positions([[1, 2]], 10, start=(0, -1e308)), "start: more than 1e+12 boxes away"),
    (lambda: Positions([[1, 2]], 1e308, diameter=1e300), "box_side = 1e+308: 0 scatterers per"),
    (lambda: Positions([[1, 2]], 10**400), f"box_side = 1{'0' * 56}...: must be a positive"),
    (lambda: HardDisks(0.04, diameter=1e308), "count = 40000: the box would be"),
    (lambda: HardDisks(0.04, diameter=10**400), f"diameter = 1{'0' * 56}...: must be a positive"),
    (lambda: HardDisks(0.04, 10**400), f"count = 1{'0' * 56}...: must be a whole number from 1"),
    (lambda: HardDisks(0.04, box=np.ones(2)), "box = array([1., 1.]): must be 'periodic', or None"),
    (lambda: Poisson(10**200, diameter=10**200), "count = 40000: the box would be"),
    (lambda: BoltzmannGrad(10**400), f"number_density = 1{'0' * 56}...: must be a positive"),
    (lambda: BoltzmannGrad(10**200, 10**200), "inf scatterers per d^2"),
]


@pytest.mark.parametrize(("make_bad", "message"), BAD, ids=[m[:40] for _, m in BAD])
def test_bad_media_get_one_clear_line(make_bad: object, message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)) as caught:
        make_bad()
    assert "\n" not in str(caught.value)
