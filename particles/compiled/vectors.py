"""The search through a cell's eight slots as vectors of eight doubles, in LLVM's own instructions.

What it gains: the loop of `particles.compiled.slots` holds a minimum and the place of it, which
LLVM does not turn into vectors by itself. With 40,000 hard disks at number density 0.04 and one
thread: 1.17e7 collisions/s in this form and 5.1e6 with the loop, on a processor without AVX-512.
`tests/particles/measurements/kernel_speed.py` measures both again.

The arithmetic is that of the loop, line by line. Nothing is contracted or reordered, so every bit
is the same (tests/particles/compiled/test_search.py). This is the only file that needs llvmlite.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

from particles.compiled import slots as loop
from particles.compiled.cache import keep
from particles.compiled.slots import SLOTS
from particles.events import GRAZING, NEVER, contact, contact_in_space

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


def _first(builder: Any, along: Any, square: Any) -> tuple[Any, Any]:
    """Return (path, slot) of the first contact: the last lines of `contact`, and the minimum."""

    def constant(value: float) -> Any:
        return ir.Constant(_VECTOR, [value] * SLOTS)

    b = builder
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
    return least, b.zext(b.cttz(mask, ir.Constant(ir.IntType(1), 0)), _INT64)


def _loader(
    context: Any, builder: Any, sig: Any, args: Any, dimension: int = 2
) -> Callable[[int], Any]:
    """Return what loads eight numbers from somewhere in a cell's slots."""
    array = context.make_array(sig.args[0])(context, builder, args[0])
    row = builder.gep(array.data, [builder.mul(args[1], ir.Constant(_INT64, dimension * SLOTS))])

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

        px, py, dir_x, dir_y = (_splat(b, a) for a in args[2:])
        # The lines of `contact`, in its order.
        dx, dy = b.fsub(load(0), px), b.fsub(load(SLOTS), py)
        along = b.fadd(b.fmul(dx, dir_x), b.fmul(dy, dir_y))
        impact = b.fsub(b.fmul(dx, dir_y), b.fmul(dy, dir_x))
        one = ir.Constant(_VECTOR, [1.0] * SLOTS)
        square = b.fmul(b.fsub(one, impact), b.fadd(one, impact))
        return context.make_tuple(b, sig.return_type, _first(b, along, square))

    return signature, generate


@intrinsic
def _strike_in_space(typingctx, slots, cell, x, y, z, ux, uy, uz):  # type: ignore[no-untyped-def]
    result = types.Tuple((types.float64, types.int64))
    signature = result(slots, cell, x, y, z, ux, uy, uz)

    def generate(context, b, sig, args):  # type: ignore[no-untyped-def]
        load = _loader(context, b, sig, args, dimension=3)
        place, direction = ([_splat(b, a) for a in group] for group in (args[2:5], args[5:]))
        # The lines of `contact_in_space`, in its order.
        offset = [b.fsub(load(k * SLOTS), p) for k, p in enumerate(place)]

        def total(terms: list[Any]) -> Any:
            return b.fadd(b.fadd(terms[0], terms[1]), terms[2])

        along = total([b.fmul(d, u) for d, u in zip(offset, direction, strict=True)])
        across = [b.fsub(d, b.fmul(along, u)) for d, u in zip(offset, direction, strict=True)]
        one = ir.Constant(_VECTOR, [1.0] * SLOTS)
        square = b.fsub(one, total([b.fmul(p, p) for p in across]))
        return context.make_tuple(b, sig.return_type, _first(b, along, square))

    return signature, generate


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


@intrinsic
def _near_chord(typingctx, slots, cell, x, y, ex, ey, reach2):  # type: ignore[no-untyped-def]
    signature = types.int64(slots, cell, x, y, ex, ey, reach2)

    def generate(context, b, sig, args):  # type: ignore[no-untyped-def]
        load = _loader(context, b, sig, args)
        (_, _, x, y, ex, ey, reach2) = args
        square = b.fadd(b.fmul(ex, ex), b.fmul(ey, ey))
        least = ir.Constant(_DOUBLE, 1e-300)
        square = b.select(b.fcmp_ordered(">", square, least), square, least)
        per = _splat(b, b.fdiv(ir.Constant(_DOUBLE, 1.0), square))
        px, py, ahead, across, reach = (_splat(b, a) for a in (x, y, ex, ey, reach2))
        zero, one = (ir.Constant(_VECTOR, [value] * SLOTS) for value in (0.0, 1.0))
        # The lines of the loop, in its order.
        dx, dy = b.fsub(load(0), px), b.fsub(load(SLOTS), py)
        part = b.fmul(b.fadd(b.fmul(dx, ahead), b.fmul(dy, across)), per)
        part = b.select(b.fcmp_ordered(">", part, zero), part, zero)
        part = b.select(b.fcmp_ordered("<", part, one), part, one)
        dx, dy = b.fsub(dx, b.fmul(part, ahead)), b.fsub(dy, b.fmul(part, across))
        near = b.fcmp_ordered("<=", b.fadd(b.fmul(dx, dx), b.fmul(dy, dy)), reach)
        return b.zext(b.bitcast(near, ir.IntType(SLOTS)), _INT64)

    return signature, generate


def strike(
    slots: np.ndarray, cell: int, x: float, y: float, ux: float, uy: float
) -> tuple[float, int]:
    """As `particles.compiled.slots.strike`; runs compiled only."""
    return _strike(slots, cell, x, y, ux, uy)  # type: ignore[call-arg]


def crowd(slots: np.ndarray, cell: int, x: float, y: float) -> int:
    """As `particles.compiled.slots.crowd`; runs compiled only."""
    return _crowd(slots, cell, x, y)  # type: ignore[call-arg]


def near_chord(
    slots: np.ndarray, cell: int, place: tuple[float, float], chord: tuple[float, float],
    reach2: float,
) -> int:  # fmt: skip
    """As `particles.compiled.slots.near_chord`; runs compiled only."""
    (x, y), (ex, ey) = place, chord
    return _near_chord(slots, cell, x, y, ex, ey, reach2)  # type: ignore[call-arg]


def strike_in_space(
    slots: np.ndarray, cell: int, place: tuple[float, float, float],
    direction: tuple[float, float, float],
) -> tuple[float, int]:  # fmt: skip
    """As `particles.compiled.slots.strike_in_space`; runs compiled only."""
    x, y, z = place
    ux, uy, uz = direction
    return _strike_in_space(slots, cell, x, y, z, ux, uy, uz)  # type: ignore[call-arg]


@keep
@njit
def _all(slots, cell, x, y, ux, uy):  # type: ignore[no-untyped-def]
    space = _strike_in_space(slots, cell, x, y, 0.5 * x, 0.6 * ux, 0.6 * uy, 0.8)
    near = _near_chord(slots, cell, x, y, 3.0 * ux, 3.0 * uy, 1.5)
    return _strike(slots, cell, x, y, ux, uy), _crowd(slots, cell, x, y), space, near


# `check` runs them in every process that imports the kernels; compiling them takes half a second.
for _function in (contact, contact_in_space):
    keep(_function)


def check() -> None:
    """Compile them and compare them with the loops; raise where one fails."""
    row = np.linspace(-3.0, 3.0, 3 * SLOTS)[None, :]
    for x, y, ux, uy in ((0.1, 0.2, 0.6, 0.8), (-2.0, 2.5, 0.8, -0.6), (9.0, 9.0, 1.0, 0.0)):
        space = loop.strike_in_space(row, 0, (x, y, 0.5 * x), (0.6 * ux, 0.6 * uy, 0.8))
        near = loop.near_chord(row, 0, (x, y), (3.0 * ux, 3.0 * uy), 1.5)
        expected = loop.strike(row, 0, x, y, ux, uy), loop.crowd(row, 0, x, y), space, near
        if _all(row, 0, x, y, ux, uy) != expected:
            raise ArithmeticError("its results are not those of the loop")
