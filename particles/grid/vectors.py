"""The innermost steps, eight scatterers at once: which slot of a cell is struck first, which are
near.

In Python these are loops over the slots. Compiled, it is the same arithmetic on vectors of eight
doubles, written in LLVM's own terms because the loop, with its minimum and its index, is not
vectorised by the compiler. Nothing is contracted or reordered: every bit is that of the loop.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, overload

from particles.events import GRAZING, NEVER, contact

SLOTS = 8


def strike(
    slots: np.ndarray, cell: int, x: float, y: float, ux: float, uy: float
) -> tuple[float, int]:
    """Return (path to contact, slot) of the first scatterer met in a cell; NEVER if none.

    slots (n_cells, 2 * SLOTS): x of each slot, then y. Of equal paths the lowest slot is meant.
    """
    path, found = NEVER, 0
    for slot in range(SLOTS):
        s, _ = contact(slots[cell, slot] - x, slots[cell, SLOTS + slot] - y, ux, uy)
        if s < path:
            path, found = s, slot
    return path, found


_DOUBLE = ir.DoubleType()
_INT32 = ir.IntType(32)
_INT64 = ir.IntType(64)
_VECTOR = ir.VectorType(_DOUBLE, SLOTS)


def _splat(builder: Any, value: Any) -> Any:
    nothing = ir.Constant(_VECTOR, ir.Undefined)
    first = builder.insert_element(nothing, value, ir.Constant(_INT32, 0))
    zeros = ir.Constant(ir.VectorType(_INT32, SLOTS), [0] * SLOTS)
    return builder.shuffle_vector(first, nothing, zeros)


def _minimum(builder: Any, vector: Any) -> Any:
    """Return the least element, by halves: no element is NaN."""
    width = SLOTS
    while width > 1:
        nothing = ir.Constant(ir.VectorType(_DOUBLE, width), ir.Undefined)
        width //= 2
        half = ir.VectorType(_INT32, width)
        low, high = (
            builder.shuffle_vector(
                vector, nothing, ir.Constant(half, list(range(start, start + width)))
            )
            for start in (0, width)
        )
        vector = builder.select(builder.fcmp_ordered("<", low, high), low, high)
    return builder.extract_element(vector, ir.Constant(_INT32, 0))


def _loader(context: Any, builder: Any, sig: Any, args: Any) -> Callable[[int], Any]:
    """Return what loads eight numbers from somewhere in a cell's slots."""
    array = context.make_array(sig.args[0])(context, builder, args[0])
    row = builder.gep(array.data, [builder.mul(args[1], ir.Constant(_INT64, 2 * SLOTS))])

    def load(offset: int) -> Any:
        start = builder.gep(row, [ir.Constant(_INT64, offset)])
        vector = builder.load(builder.bitcast(start, _VECTOR.as_pointer()))
        vector.align = 8
        return vector

    return load


@intrinsic
def _strike(typingctx, slots, cell, x, y, ux, uy):  # type: ignore[no-untyped-def]
    signature = types.Tuple((types.float64, types.int64))(slots, cell, x, y, ux, uy)

    def generate(context, b, sig, args):  # type: ignore[no-untyped-def]
        load = _loader(context, b, sig, args)

        def constant(value: float) -> Any:
            return ir.Constant(_VECTOR, [value] * SLOTS)

        px, py, dir_x, dir_y = (_splat(b, a) for a in args[2:])
        # The lines of `contact`, in its order.
        dx, dy = b.fsub(load(0), px), b.fsub(load(SLOTS), py)
        along = b.fadd(b.fmul(dx, dir_x), b.fmul(dy, dir_y))
        impact = b.fsub(b.fmul(dx, dir_y), b.fmul(dy, dir_x))
        square = b.fmul(b.fsub(constant(1.0), impact), b.fadd(constant(1.0), impact))
        struck = b.and_(
            b.fcmp_ordered(">", along, constant(GRAZING)),
            b.fcmp_ordered(">", square, constant(0.0)),
        )
        root = cgutils.get_or_insert_function(
            b.module, ir.FunctionType(_VECTOR, [_VECTOR]), f"llvm.sqrt.v{SLOTS}f64"
        )
        path = b.select(struck, b.fsub(along, b.call(root, [square])), constant(NEVER))
        least = _minimum(b, path)
        equal = b.fcmp_ordered("==", path, _splat(b, least))
        mask = b.zext(b.bitcast(equal, ir.IntType(SLOTS)), _INT32)
        slot = b.zext(b.cttz(mask, ir.Constant(ir.IntType(1), 0)), _INT64)
        return context.make_tuple(b, sig.return_type, [least, slot])

    return signature, generate


@overload(strike, inline="always")
def _compiled_strike(slots, cell, x, y, ux, uy):  # type: ignore[no-untyped-def]
    return lambda slots, cell, x, y, ux, uy: _strike(slots, cell, x, y, ux, uy)


def crowd(slots: np.ndarray, cell: int, x: float, y: float) -> int:
    """Return which slots of a cell are nearer than 1 to (x, y), one bit each."""
    mask = 0
    for slot in range(SLOTS):
        dx, dy = slots[cell, slot] - x, slots[cell, SLOTS + slot] - y
        mask |= int(dx * dx + dy * dy < 1.0) << slot
    return mask


@intrinsic
def _crowd(typingctx, slots, cell, x, y):  # type: ignore[no-untyped-def]
    signature = types.int64(slots, cell, x, y)

    def generate(context, b, sig, args):  # type: ignore[no-untyped-def]
        load = _loader(context, b, sig, args)
        dx, dy = (b.fsub(load(at), _splat(b, a)) for at, a in ((0, args[2]), (SLOTS, args[3])))
        square = b.fadd(b.fmul(dx, dx), b.fmul(dy, dy))
        near = b.fcmp_ordered("<", square, ir.Constant(_VECTOR, [1.0] * SLOTS))
        return b.zext(b.bitcast(near, ir.IntType(SLOTS)), _INT64)

    return signature, generate


@overload(crowd, inline="always")
def _compiled_crowd(slots, cell, x, y):  # type: ignore[no-untyped-def]
    return lambda slots, cell, x, y: _crowd(slots, cell, x, y)
