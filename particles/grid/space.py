"""The index of the scatterers in three dimensions: cubic cells, in a periodic box or in all space.

As in the plane (`particles.grid.cells`), a cell lists every scatterer that a tracer in it can
touch. Unbounded space holds overlapping spheres only and is made cell by cell where a tracer goes,
from streams of (seed, configuration, place), so a cell is always the same. Spheres are drawn in
cubes as large as a cell and displaced against the cells by little more than 1 d along each axis:
what a cell lists lies in 8 of these cubes, where 27 cubes in line with the cells would be needed.
"""

from math import ceil, pi, sqrt
from typing import Any

import numpy as np
from numba import int64, njit, uint64
from numba.extending import overload

from particles.compiled.decorators import inlined, kernel
from particles.compiled.slots import SLOTS
from particles.grid.cells import EMPTY, Cells, rows
from particles.grid.plane import GUIDES, Counts, make_counts_of, make_law
from particles.streams import bits, mix, to_unit

# Scatterers that a cell lists on average. Speed depends on it, results in a box do not.
LISTED = 5.0
# Unbounded space keeps 2**WINDOW cells along each axis, those last visited.
WINDOW = 4
# A cell lists what is no farther than this from it. In a corner between scatterers, all of those
# within 1e-8 d of contact must be listed (particles.kernel.pockets).
REACH = 1.0 + 1e-7
_NOWHERE = -(2**62)
# A scatterer is listed in at most so many cells of side 1.5 or more; counted in 32 bits.
LISTINGS = 27
_SQRT2, _SQRT3, _SQRT5 = 0x6A09E667F3BCC909, 0xBB67AE8584CAA73B, 0x3C6EF372FE94F82B
_TO_UNIT = 2.0**-32


def listed_volume(side: float) -> float:
    """Return the volume within 1 of a cube of this side, in d^3."""
    return side**3 + 6.0 * side**2 + 3.0 * pi * side + 4.0 * pi / 3.0


def cell_side(number_density: float, least: float, listed: float = LISTED) -> float:
    """Return the side of a cell that lists so many scatterers on average, at least this much."""
    side = (listed / number_density) ** (1.0 / 3.0)  # too large, so Newton's steps go down
    for _ in range(60):
        slope = 3.0 * side**2 + 12.0 * side + 3.0 * pi
        side = max(side - (listed_volume(side) - listed / number_density) / slope, 0.0)
    return max(side, least)


def cells_along(box: float, number_density: float) -> int:
    """Return the number of cells along a box: odd, so that its centre is that of a cell."""
    n = max(int(box / cell_side(number_density, 1.5)), 1)
    return n - (n % 2 == 0)


def box_bytes(box: float, number_density: float, count: int) -> int:
    """Return the bytes that the cells of a box ask for, and the spheres while they are placed."""
    n = cells_along(box, number_density)
    of_a_cell = 3 * SLOTS * 8 + 4 + 4  # slots, fill, head
    chained = _chained(box, n, count)
    return n**3 * of_a_cell + chained * (4 + 3 * 8) + count * 3 * 8


def _chained(box: float, n: int, count: int) -> int:
    """Return for how many listings in chains there is room at first."""
    listings = count * min(listed_volume(box / n) / (box / n) ** 3, LISTINGS)
    return ceil(listings) + 64


def boxed(positions: np.ndarray, box: float) -> Cells:
    """Return the cells of a box of this side that list the spheres at positions (count, 3).

    Positions are from the middle of the box, in d. Raises ValueError for more than 32 bits number.
    """
    count = len(positions)
    n = cells_along(box, count / box**3)
    room = _chained(box, n, count)
    while True:
        cells = _empty(box / n, n, n**3, room, np.empty((0, 3), np.int8))
        cells.fill[:] = 0
        cells.head[:] = -1
        cells.slots[:] = EMPTY
        needed = _list_all(cells, positions)
        if needed <= room:
            return cells
        room = needed


def unbounded(number_density: float, key: Any, old: Cells | None = None) -> Cells:
    """Return unbounded space; its cells are drawn later, when tracers enter them.

    key: of the streams that they are drawn from. old: space of the same density that is no longer
    needed and whose memory is used again.
    """
    side = cell_side(number_density, 2.5)
    law = make_law(side, -0.5 * side - REACH, False, key)
    if old is not None and old.law.side == side and old.keys.shape[1] == 3:
        old.keys[:] = _NOWHERE
        return old._replace(law=law)
    counts = make_counts_of((number_density * side**3,))
    n_cells = 8**WINDOW
    mean = number_density * listed_volume(side)
    # Twelve standard deviations, as for the numbers in a cube.
    room = n_cells * ceil(mean + 12.0 * sqrt(mean) + 40.0)
    keys = np.full((n_cells, 3), _NOWHERE)
    return _empty(side, 0, n_cells, room, keys)._replace(law=law, counts=counts)


def _empty(side: float, n: int, n_cells: int, room: int, keys: np.ndarray) -> Cells:
    if room >= 2**31:
        raise ValueError(f"a box of {n}^3 cells: too many scatterers to be counted in 32 bits")
    return Cells(
        side=side,
        n=n,
        slots=rows(n_cells, 3),
        fill=np.empty(n_cells, np.int32),
        head=np.empty(n_cells, np.int32),
        links=np.empty(room, np.int32),
        nodes=np.empty((room, 3)),
        keys=keys,
        law=make_law(side, 0.0, False, np.uint64(0)),
        counts=Counts(np.empty((0, 0)), np.empty((0, 0), np.int64)),
        draft=np.empty((0, 6)),
        pairs=np.empty((0, 2), np.int64),
        who=np.empty((0, SLOTS), np.int64),
    )


@inlined
def _enlist(cells: Cells, cell: int, sphere: tuple[float, float, float], spare: int) -> int:
    """As `particles.grid.cells.enlist`; a scatterer for which there is no node is left out."""
    k = cells.fill[cell]
    cells.fill[cell] = k + 1
    if k < SLOTS:
        for axis in range(3):
            cells.slots[cell, axis * SLOTS + k] = sphere[axis]
        return spare
    if spare < cells.links.size:
        for axis in range(3):
            cells.nodes[spare, axis] = sphere[axis]
        cells.links[spare] = cells.head[cell]
        cells.head[cell] = spare
    return spare + 1


@njit(error_model="numpy", inline="always")
def _reaches(x: float, y: float, z: float, half: float) -> bool:
    """Tell whether a sphere of radius REACH around (x, y, z) overlaps the cube |x|, ... <= half."""
    gap_x = max(abs(x) - half, 0.0)
    gap_y = max(abs(y) - half, 0.0)
    gap_z = max(abs(z) - half, 0.0)
    return gap_x * gap_x + gap_y * gap_y + gap_z * gap_z <= REACH * REACH


@kernel
def _list_all(cells: Cells, positions: np.ndarray) -> int:
    """List spheres at positions (count, 3) from the middle of a box; return the nodes needed."""
    n, side = cells.n, cells.side
    half, middle = 0.5 * side, n // 2
    spare = 0
    for sphere in range(positions.shape[0]):
        x, y, z = positions[sphere, 0], positions[sphere, 1], positions[sphere, 2]
        i, j, k = round(x / side), round(y / side), round(z / side)
        x -= i * side
        y -= j * side
        z -= k * side
        for di in range(-1, 2):
            for dj in range(-1, 2):
                for dk in range(-1, 2):
                    rx, ry, rz = x - di * side, y - dj * side, z - dk * side
                    if _reaches(rx, ry, rz, half):
                        cell = (i + di + middle) % n * n + (j + dj + middle) % n
                        cell = cell * n + (k + dk + middle) % n
                        spare = _enlist(cells, cell, (rx, ry, rz), spare)
    return spare


@njit(error_model="numpy", inline="always")
def place(i: int, j: int, k: int) -> int:
    """Return where the window stores cell (i, j, k); cells less than its width apart differ."""
    inside = 2**WINDOW - 1
    return (((i & inside) << WINDOW | (j & inside)) << WINDOW) | (k & inside)


def supply(keys: np.ndarray, cells: Cells, i: int, j: int, k: int) -> None:
    """Draw cell (i, j, k) of unbounded space; nothing is compiled for a box."""
    make(cells, i, j, k)


@overload(supply, inline="always")
def _compiled_supply(keys, cells, i, j, k):  # type: ignore[no-untyped-def]
    if keys.dtype == int64:
        return lambda keys, cells, i, j, k: make(cells, i, j, k)
    return lambda keys, cells, i, j, k: None


@njit(error_model="numpy")
def make(cells: Cells, i: int, j: int, k: int) -> None:
    """Draw cell (i, j, k) of unbounded space where the window stores it."""
    # Taken out of their tuples once: in the loops, numba would count references to them each time.
    slots, fill, head, links, nodes = (
        cells.slots, cells.fill, cells.head, cells.links, cells.nodes,
    )  # fmt: skip
    cumulative, guides, keys = cells.counts.cumulative, cells.counts.guides, cells.keys
    law = cells.law
    cell = place(i, j, k)
    keys[cell, 0], keys[cell, 1], keys[cell, 2] = i, j, k
    listed, last = 0, -1
    for slot in range(3 * SLOTS):
        slots[cell, slot] = EMPTY
    side, half = law.side, 0.5 * law.side
    near = max(abs(i), abs(j), abs(k)) <= 1
    spare = cell * (links.size >> 3 * WINDOW)
    for cube in range(8):
        p, q, r = cube >> 2, cube >> 1 & 1, cube & 1
        where = uint64(int64(i + p)) * uint64(_SQRT2) + uint64(int64(j + q)) * uint64(_SQRT3)
        state = mix(uint64(law.key) + where + uint64(int64(k + r)) * uint64(_SQRT5))
        gamma = mix(state ^ uint64(law.key)) | uint64(1)
        ox, oy, oz = law.edge + p * side, law.edge + q * side, law.edge + r * side
        u = to_unit(state)
        number = guides[0, int(u * GUIDES)]
        while u > cumulative[0, number]:
            number += 1
        for sphere in range(number):
            word = bits(state, gamma, 2 * sphere + 1)
            x = ox + (float(int64(word >> uint64(32))) + 0.5) * _TO_UNIT * side
            y = oy + (float(int64(word & uint64(0xFFFFFFFF))) + 0.5) * _TO_UNIT * side
            word = bits(state, gamma, 2 * sphere + 2)
            z = oz + (float(int64(word >> uint64(32))) + 0.5) * _TO_UNIT * side
            if not _reaches(x, y, z, half):
                continue
            if near:  # none covers the origin, where tracers start
                ax, ay, az = x + i * side, y + j * side, z + k * side
                if ax * ax + ay * ay + az * az < 1.0:
                    continue
            if listed < SLOTS:
                slots[cell, listed], slots[cell, SLOTS + listed] = x, y
                slots[cell, 2 * SLOTS + listed] = z
            else:
                nodes[spare, 0], nodes[spare, 1], nodes[spare, 2] = x, y, z
                links[spare] = last
                last = spare
                spare += 1
            listed += 1
    fill[cell], head[cell] = listed, last
