"""The index of the scatterers: cells of a periodic box, in the plane squares, in space cubes.

A cell lists every scatterer that a tracer in it can touch, relative to the cell's centre, so that
places have all their digits far from the origin too. It has SLOTS places in one array; the others
are in a linked list, its chain. The dimension is the number of axes of `Cells.shape`, which the
compiler knows: code for the other dimension leaves no trace in a kernel.
"""

from math import floor, pi, sqrt
from typing import NamedTuple

import numpy as np

from particles.checks import refuse
from particles.compiled import called, inlined, kernel
from particles.search import SLOTS

EMPTY = 1e150  # far away, and its square is still finite
# Scatterers that a cell lists on average; only the speed depends on it: 2.5 to 10 were measured.
LISTED = 5.0
# A scatterer reaches into no cell but its own and its neighbours.
LEAST_SIDE = 1.5  # in d
# A cell lists what is no farther than this from it, in d: 1, with room for rounding and for a
# tracer in a corner of several spheres, which must know all within 1e-8 (particles.kernel.pockets).
REACH = 1.0 + 1e-7


class Cells(NamedTuple):
    """Scatterers of a periodic box; lengths are in d.

    side: of a cell. shape: cells along each axis, (n, n) or (n, n, n). slots
    (n_cells, dimension * SLOTS): x of each slot, then y, then z; EMPTY where free. fill (n_cells,):
    scatterers in each cell. head (n_cells,), links, nodes (, dimension): the chains; -1 ends one.
    """

    side: float
    shape: tuple[int, ...]
    slots: np.ndarray
    fill: np.ndarray
    head: np.ndarray
    links: np.ndarray
    nodes: np.ndarray


def _cell_side(number_density: float, dimension: int) -> float:
    """Return the side of a cell that lists LISTED scatterers on average."""
    if dimension == 2:
        return max(sqrt(LISTED / number_density) - 2.0, LEAST_SIDE)
    # The volume within 1 of a cube is that in `listed`; Newton's steps go down to the side.
    side, volume = (LISTED / number_density) ** (1.0 / 3.0), LISTED / number_density
    for _ in range(60):
        slope = 3.0 * side**2 + 12.0 * side + 3.0 * pi
        listed = side**3 + 6.0 * side**2 + 3.0 * pi * side + 4.0 * pi / 3.0
        side = max(side - (listed - volume) / slope, 0.0)
    return max(side, LEAST_SIDE)


def _sizes(box: float, count: int, dimension: int) -> tuple[int, int]:
    """Return the number of cells along the box, odd so that its centre is one's, and of nodes."""
    n = max(int(box / _cell_side(count / box**dimension, dimension)), 1)
    n -= n % 2 == 0
    across = 2 if box / n > 2.0 * REACH else 3  # cells that a diameter of 2 overlaps
    return n, count * across**dimension


def box_bytes(box: float, count: int, dimension: int) -> int:
    """Return the bytes that `empty_box` asks for, and the positions while they are placed."""
    n, room = _sizes(box, count, dimension)
    each = n**dimension * (dimension * SLOTS * 8 + 4 + 4)  # slots, fill, head
    return each + room * (4 + dimension * 8) + count * 3 * 8


def empty_box(box: float, count: int, dimension: int) -> Cells:
    """Return the cells of a box of this side (in d) that is to hold `count` scatterers."""
    n, room = _sizes(box, count, dimension)
    if room >= 2**31:
        most = 2**31 * count // room
        refuse("count", count, f"it must be below {most}, as listings are counted in 32 bits")
    return Cells(
        side=box / n,
        shape=(n,) * dimension,
        slots=_aligned_rows(n**dimension, dimension * SLOTS),
        fill=np.zeros(n**dimension, np.int32),
        head=np.full(n**dimension, -1, np.int32),
        links=np.empty(room, np.int32),
        nodes=np.empty((room, dimension)),
    )


def _aligned_rows(n_rows: int, columns: int) -> np.ndarray:
    """Return empty slots whose rows are aligned with the lines of the processor's cache."""
    line = 64 // 8  # numbers in a line of 64 bytes
    whole = np.full(n_rows * columns + line, EMPTY)
    begin = -(whole.ctypes.data // 8) % line
    return whole[begin : begin + n_rows * columns].reshape(n_rows, columns)


@inlined
def cell_at(shape: tuple[int, ...], i: int, j: int, k: int) -> int:
    """Return where the cell is stored that these numbers stand for, modulo the box."""
    n = shape[0]
    cell = i % n * n + j % n
    return cell * n + k % n if len(shape) == 3 else cell


@inlined
def _enlist(cells: Cells, cell: int, x: float, y: float, z: float, spare: int) -> int:
    """Enter a scatterer in a cell, in node `spare` if its slots are full; return the next spare."""
    slot = cells.fill[cell]
    cells.fill[cell] = slot + 1
    if slot < SLOTS:
        cells.slots[cell, slot] = x
        cells.slots[cell, SLOTS + slot] = y
        if len(cells.shape) == 3:
            cells.slots[cell, 2 * SLOTS + slot] = z
        return spare
    cells.nodes[spare, 0] = x
    cells.nodes[spare, 1] = y
    if len(cells.shape) == 3:
        cells.nodes[spare, 2] = z
    cells.links[spare] = cells.head[cell]
    cells.head[cell] = spare
    return spare + 1


@called
def insert(
    cells: Cells, i: int, j: int, k: int, x: float, y: float, z: float, spare: int
) -> int:  # fmt: skip
    """List a scatterer at (x, y, z) from the centre of cell (i, j, k) wherever it reaches.

    Return the next spare node. In the plane k and z are 0, here and everywhere.
    """
    side, half = cells.side, 0.5 * cells.side
    layers = 1 if len(cells.shape) == 3 else 0
    for di in range(-1, 2):
        rx = x - di * side
        gap_x = max(abs(rx) - half, 0.0)
        for dj in range(-1, 2):
            ry = y - dj * side
            gap_y = max(abs(ry) - half, 0.0)
            for dk in range(-layers, layers + 1):
                rz = z - dk * side
                gap_z = max(abs(rz) - half, 0.0)
                if gap_x * gap_x + gap_y * gap_y + gap_z * gap_z <= REACH * REACH:
                    cell = cell_at(cells.shape, i + di, j + dj, k + dk)
                    spare = _enlist(cells, cell, rx, ry, rz, spare)
    return spare


@kernel
def insert_all(cells: Cells, positions: np.ndarray) -> None:
    """List scatterers at positions (count, 3) from the middle of the box, in empty cells."""
    side, middle = cells.side, cells.shape[0] // 2
    spare = 0
    for m in range(positions.shape[0]):
        x, y, z = positions[m, 0], positions[m, 1], positions[m, 2]
        i, j, k = floor(x / side + 0.5), floor(y / side + 0.5), floor(z / side + 0.5)
        x, y, z = x - i * side, y - j * side, z - k * side
        spare = insert(cells, i + middle, j + middle, k + middle, x, y, z, spare)


@inlined
def is_free(cells: Cells, cell: int, x: float, y: float, z: float) -> bool:
    """Tell whether no scatterer is nearer than 1 to a place, from the centre of its cell."""
    slots, links, nodes = cells.slots, cells.links, cells.nodes
    near = 0
    for slot in range(SLOTS):
        dx, dy, dz = slots[cell, slot] - x, slots[cell, SLOTS + slot] - y, 0.0
        if len(cells.shape) == 3:
            dz = slots[cell, 2 * SLOTS + slot] - z
        near += int(dx * dx + dy * dy + dz * dz < 1.0)
    node = cells.head[cell]
    while near == 0 and node >= 0:
        dx, dy, dz = nodes[node, 0] - x, nodes[node, 1] - y, 0.0
        if len(cells.shape) == 3:
            dz = nodes[node, 2] - z
        near += int(dx * dx + dy * dy + dz * dz < 1.0)
        node = links[node]
    return near == 0


@called
def next_listed(
    cells: Cells, cell: int, slot: int, node: int
) -> tuple[float, float, float, int, int]:  # fmt: skip
    """Return (centre of the next scatterer of a cell, next slot, next node).

    From slot 0 and node `cells.head[cell]` on until slot SLOTS and a negative node.
    """
    z = 0.0
    if slot < SLOTS:
        if len(cells.shape) == 3:
            z = cells.slots[cell, 2 * SLOTS + slot]
        return cells.slots[cell, slot], cells.slots[cell, SLOTS + slot], z, slot + 1, node
    if len(cells.shape) == 3:
        z = cells.nodes[node, 2]
    return cells.nodes[node, 0], cells.nodes[node, 1], z, slot, cells.links[node]
