"""The index of the scatterers: cells of a periodic box, in the plane squares, in space cubes.

A cell lists every scatterer that a tracer in it can touch, relative to the cell's centre, so that
places have all their digits far from the origin too. It has SLOTS places in one array; the others
are in a linked list, its chain. The dimension is the number of axes of `Cells.shape`, which the
compiler knows: code for the other dimension leaves no trace in a kernel.
"""

from math import floor, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from particles.compiled import called, inlined, kernel
from particles.events import GRAZING, NEVER
from particles.values import refuse

SLOTS = 8

EMPTY = sqrt(NEVER)  # far away, and its square is still finite
# Scatterers that a cell lists on average; only the speed depends on it: 2.5 to 10 were measured.
LISTED = 5.0
# A scatterer reaches into no cell but its own and its neighbours.
LEAST_SIDE = 1.5  # in d
# A tracer in a corner must know all scatterers that are so near to contact, in d. A cell lists what
# is no farther than REACH from it: with room for them and for rounding.
NEAR = 1e-8
REACH = 1.0 + 10.0 * NEAR


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
    # The volume within 1 of a cube of the side is to be that of LISTED; no other root is positive.
    cubic = 1.0, 6.0, 3.0 * pi, 4.0 * pi / 3.0 - LISTED / number_density
    return max(float(np.roots(cubic).real.max()), LEAST_SIDE)


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


# The eight slots of a cell, searched at once: what is struck first. LLVM makes no vectors of a loop
# that holds a minimum and the place of it. So the search is written in LLVM's own instructions, on
# vectors of eight doubles, in compiled code only. The arithmetic is that of `events.contact`, line
# by line, so every bit is that of the loop. With 40,000 hard disks at 0.04 d^-2 that is worth a
# factor of two in collisions/s.

_DOUBLE = ir.DoubleType()
_INT32 = ir.IntType(32)
_INT64 = ir.IntType(64)
_VECTOR = ir.VectorType(_DOUBLE, SLOTS)


def _constant(value: float) -> Any:
    return ir.Constant(_VECTOR, [value] * SLOTS)


def _splat(b: Any, value: Any) -> Any:
    nothing = ir.Constant(_VECTOR, ir.Undefined)
    first = b.insert_element(nothing, value, ir.Constant(_INT32, 0))
    zeros = ir.Constant(ir.VectorType(_INT32, SLOTS), [0] * SLOTS)
    return b.shuffle_vector(first, nothing, zeros)


def _minimum(b: Any, vector: Any) -> Any:
    """Return the least element, by halves: no element is NaN."""
    width = SLOTS
    while width > 1:
        nothing = ir.Constant(ir.VectorType(_DOUBLE, width), ir.Undefined)
        width //= 2
        half = ir.VectorType(_INT32, width)
        low, high = (
            b.shuffle_vector(vector, nothing, ir.Constant(half, list(range(at, at + width))))
            for at in (0, width)
        )
        vector = b.select(b.fcmp_ordered("<", low, high), low, high)
    return b.extract_element(vector, ir.Constant(_INT32, 0))


def _offsets(context: Any, b: Any, sig: Any, args: Any) -> list[Any]:
    """Return a cell's slots from a place, one vector for each coordinate: args begin with these."""
    parts = cgutils.unpack_tuple(b, args[2])
    array = context.make_array(sig.args[0])(context, b, args[0])
    row = b.gep(array.data, [b.mul(args[1], ir.Constant(_INT64, len(parts) * SLOTS))])
    found = []
    for k, part in enumerate(parts):
        start = b.gep(row, [ir.Constant(_INT64, k * SLOTS)])
        vector = b.load(b.bitcast(start, _VECTOR.as_pointer()))
        vector.align = 8
        found.append(b.fsub(vector, _splat(b, part)))
    return found


def _strike(typingctx, slots, cell, place, direction):  # type: ignore[no-untyped-def]
    """Return (path to contact, slot) of the first scatterer met in a cell; NEVER if none.

    slots: those of Cells. place, unit direction: two numbers each, or three in space. Of equal
    paths the lowest slot counts.
    """
    signature = types.Tuple((types.float64, types.int64))(slots, cell, place, direction)

    def generate(context, b, sig, args):  # type: ignore[no-untyped-def]
        dimension = len(sig.args[2])

        def total(terms: list[Any]) -> Any:
            first = b.fadd(terms[0], terms[1])
            return first if dimension == 2 else b.fadd(first, terms[2])

        u = [_splat(b, part) for part in cgutils.unpack_tuple(b, args[3])]
        offset = _offsets(context, b, sig, args)
        along = total([b.fmul(d, v) for d, v in zip(offset, u, strict=True)])
        if dimension == 2:  # the lines of `contact`, in its order
            impact = b.fsub(b.fmul(offset[0], u[1]), b.fmul(offset[1], u[0]))
            square = b.fmul(b.fsub(_constant(1.0), impact), b.fadd(_constant(1.0), impact))
        else:  # of `contact_in_space`
            across = [b.fsub(d, b.fmul(along, v)) for d, v in zip(offset, u, strict=True)]
            square = b.fsub(_constant(1.0), total([b.fmul(p, p) for p in across]))
        struck = b.and_(
            b.fcmp_ordered(">", along, _constant(GRAZING)),
            b.fcmp_ordered(">", square, _constant(0.0)),
        )
        root = cgutils.get_or_insert_function(
            b.module, ir.FunctionType(_VECTOR, [_VECTOR]), f"llvm.sqrt.v{SLOTS}f64"
        )
        path = b.select(struck, b.fsub(along, b.call(root, [square])), _constant(NEVER))
        least = _minimum(b, path)
        equal = b.fcmp_ordered("==", path, _splat(b, least))
        mask = b.zext(b.bitcast(equal, ir.IntType(SLOTS)), _INT32)
        slot = b.zext(b.cttz(mask, ir.Constant(ir.IntType(1), 0)), _INT64)
        return context.make_tuple(b, sig.return_type, (least, slot))

    return signature, generate


strike: Any = intrinsic(_strike)


@inlined
def near_chord(
    slots: np.ndarray, cell: int, place: tuple[float, float], chord: tuple[float, float],
    reach2: float,
) -> int:  # fmt: skip
    """Return which slots of a cell in the plane are within reach of a chord, one bit each."""
    (x, y), (ex, ey), near = place, chord, 0
    per = 1.0 / max(ex * ex + ey * ey, 1e-300)
    for slot in range(SLOTS):
        dx, dy = slots[cell, slot] - x, slots[cell, SLOTS + slot] - y
        part = min(max((dx * ex + dy * ey) * per, 0.0), 1.0)
        px, py = dx - part * ex, dy - part * ey
        near |= int(px * px + py * py <= reach2) << slot
    return near
