"""The index of the scatterers: cells of a periodic box, in the plane squares, in space cubes.

A cell lists every scatterer that a tracer in it can touch, relative to the cell's centre, so that
places have all their digits far from the origin too. It has SLOTS places in one array; the others
are in a linked list, its chain. The dimension is the number of axes of `Cells.shape`, which the
compiler knows: code for the other dimension leaves no trace in a kernel. Begin reading with `Cells`
and `insert`; `particles.slot_search` looks for contacts.
"""

from math import floor, pi, sqrt
from typing import NamedTuple

import numpy as np

from particles.compiled import called, inlined, kernel
from particles.events import NEVER
from particles.values import refuse

#: Scatterers that a cell lists in its array. Chosen: as many as a vector of doubles holds, so that
#: the processor looks at all of them at once.
SLOTS = 8
#: A coordinate of no scatterer. Derived: far away, and its square is still finite.
EMPTY = sqrt(NEVER)
#: Scatterers that a cell lists on average. Only the speed depends on it: 2.5 to 10 were measured.
LISTED = 5.0
#: Least side of a cell in d. Derived: from REACH on, a scatterer reaches into its own cell and into
#: neighbours only. The origin of what this is larger is not recorded.
LEAST_SIDE = 1.5
#: A tracer in a corner must know all scatterers that are so near to contact, in d. The origin of
#: the number is not recorded.
NEAR = 1e-8
#: A cell lists what is no farther than this from it, in d. Chosen: with room for NEAR and rounding.
REACH = 1.0 + 10.0 * NEAR
#: Bytes of a line of the processor's cache.
CACHE_LINE = 64
#: Bytes of a double.
DOUBLE = 8
#: Bytes of a number of a scatterer or a node.
INT32 = 4


class Cells(NamedTuple):
    """Scatterers of a periodic box; lengths are in d.

    Parameters
    ----------
    side : of a cell
    shape : cells along each axis, (n, n) or (n, n, n)
    slots : x of each slot, then y, then z; EMPTY where free; shape (n_cells, dimension * SLOTS)
    fill : scatterers in each cell, shape (n_cells,)
    head : first node of the chain of each cell, -1 where there is none; shape (n_cells,)
    links : the node after each node, -1 at the end of a chain; shape (n_nodes,)
    nodes : places of the scatterers in chains, shape (n_nodes, dimension)
    """

    side: float
    shape: tuple[int, ...]
    slots: np.ndarray
    fill: np.ndarray
    head: np.ndarray
    links: np.ndarray
    nodes: np.ndarray


class BoxSize(NamedTuple):
    """How much a box holds: cells along each axis, and nodes for scatterers in chains."""

    cells_along: int
    nodes: int


def _cell_side(number_density: float, dimension: int) -> float:
    """Return the side of a cell that lists LISTED scatterers on average."""
    size = LISTED / number_density  # area or volume in which so many scatterers are
    if dimension == 2:
        return max(sqrt(size) - 2.0, LEAST_SIDE)
    # The volume within 1 of a cube of the side is to be that of LISTED; no other root is positive.
    cubic = (1.0, 6.0, 3.0 * pi, 4.0 * pi / 3.0 - size)
    return max(float(np.roots(cubic).real.max()), LEAST_SIDE)


def _box_size(box: float, count: int, dimension: int) -> BoxSize:
    """Return how much a box of this side (in d) must hold for `count` scatterers."""
    number_density = count / box**dimension
    n = max(int(box / _cell_side(number_density, dimension)), 1)
    if n % 2 == 0:  # odd, so that the centre of the box is one of a cell
        n -= 1
    # Cells along an axis that a scatterer, of diameter 2, overlaps.
    overlapped = 2 if box / n > 2.0 * REACH else 3
    return BoxSize(n, count * overlapped**dimension)


def box_bytes(box: float, count: int, dimension: int) -> int:
    """Return the bytes that `empty_box` asks for, and the positions while they are placed."""
    size = _box_size(box, count, dimension)
    of_cell = dimension * SLOTS * DOUBLE + INT32 + INT32  # slots, fill, head
    of_node = INT32 + dimension * DOUBLE
    of_position = 3 * DOUBLE
    return size.cells_along**dimension * of_cell + size.nodes * of_node + count * of_position


def empty_box(box: float, count: int, dimension: int) -> Cells:
    """Return the cells of a box of this side (in d) that is to hold `count` scatterers."""
    size = _box_size(box, count, dimension)
    if size.nodes >= 2**31:
        largest = 2**31 * count // size.nodes
        refuse("count", count, f"it must be below {largest}, as listings are counted in 32 bits")
    n = size.cells_along
    n_cells = n**dimension
    return Cells(
        side=box / n,
        shape=(n,) * dimension,
        slots=_aligned_rows(n_cells, dimension * SLOTS),
        fill=np.zeros(n_cells, np.int32),
        head=np.full(n_cells, -1, np.int32),
        links=np.empty(size.nodes, np.int32),
        nodes=np.empty((size.nodes, dimension)),
    )


def _aligned_rows(n_rows: int, columns: int) -> np.ndarray:
    """Return empty slots whose rows are aligned with the lines of the processor's cache."""
    numbers_in_line = CACHE_LINE // DOUBLE
    numbers = np.full(n_rows * columns + numbers_in_line, EMPTY)
    begin = -(numbers.ctypes.data // DOUBLE) % numbers_in_line
    return numbers[begin : begin + n_rows * columns].reshape(n_rows, columns)


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
    side = cells.side
    half = 0.5 * side
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
    side = cells.side
    middle = cells.shape[0] // 2
    spare = 0
    for m in range(positions.shape[0]):
        x = positions[m, 0]
        y = positions[m, 1]
        z = positions[m, 2]
        i = floor(x / side + 0.5)
        j = floor(y / side + 0.5)
        k = floor(z / side + 0.5)
        x -= i * side
        y -= j * side
        z -= k * side
        spare = insert(cells, i + middle, j + middle, k + middle, x, y, z, spare)


@inlined
def is_free(cells: Cells, cell: int, x: float, y: float, z: float) -> bool:
    """Tell whether no scatterer is nearer than 1 to a place, from the centre of its cell."""
    slots = cells.slots
    links = cells.links
    nodes = cells.nodes
    near = 0
    for slot in range(SLOTS):
        dx = slots[cell, slot] - x
        dy = slots[cell, SLOTS + slot] - y
        dz = 0.0
        if len(cells.shape) == 3:
            dz = slots[cell, 2 * SLOTS + slot] - z
        near += int(dx * dx + dy * dy + dz * dz < 1.0)
    node = cells.head[cell]
    while near == 0 and node >= 0:
        dx = nodes[node, 0] - x
        dy = nodes[node, 1] - y
        dz = 0.0
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
        x = cells.slots[cell, slot]
        y = cells.slots[cell, SLOTS + slot]
        if len(cells.shape) == 3:
            z = cells.slots[cell, 2 * SLOTS + slot]
        return x, y, z, slot + 1, node
    x = cells.nodes[node, 0]
    y = cells.nodes[node, 1]
    if len(cells.shape) == 3:
        z = cells.nodes[node, 2]
    return x, y, z, slot, cells.links[node]
