"""Which form of the search through a cell's slots the compiled kernels contain.

FORM is "vectors" (`particles.compiled.vectors`) where that compiles and "loop" elsewhere
(`particles.compiled.slots`); NOTE then says why. Both give the same bits, so results do not depend
on it.
"""

import warnings
from collections.abc import Callable
from types import ModuleType

import numpy as np
from numba.extending import is_jitted, overload

from particles.compiled import slots
from particles.compiled.slots import SLOTS, crowd, near_chord, strike, strike_in_space
from particles.events import contact

__all__ = ["FORM", "NOTE", "SLOTS", "crowd", "near_chord", "strike", "strike_in_space"]


def _choose() -> tuple[ModuleType, str, str]:
    """Return the module of the functions that kernels compile, their form, and why."""
    if not is_jitted(contact):
        return slots, "loop", "NUMBA_DISABLE_JIT is set: nothing is compiled"
    try:
        from particles.compiled import vectors

        vectors.check()
    except Exception as error:  # llvmlite and numba raise many kinds, which change with versions
        note = f"the vector form fails here: {type(error).__name__}: {error}".splitlines()[0]
        warnings.warn(
            f"particles: {note}. The plain loop takes its place: same results, at about half the "
            f"speed. Other versions of numba and llvmlite may help.",
            RuntimeWarning,
            stacklevel=2,
        )
        return slots, "loop", note
    return vectors, "vectors", ""


_MODULE, FORM, NOTE = _choose()


# numba compares the names and the annotations of the arguments, so they are repeated here.
@overload(strike, inline="always")
def _compiled_strike(
    slots: np.ndarray, cell: int, x: float, y: float, ux: float, uy: float
) -> Callable:
    return _MODULE.strike


@overload(crowd, inline="always")
def _compiled_crowd(slots: np.ndarray, cell: int, x: float, y: float) -> Callable:
    return _MODULE.crowd


@overload(strike_in_space, inline="always")
def _compiled_strike_in_space(
    slots: np.ndarray, cell: int, place: tuple[float, float, float],
    direction: tuple[float, float, float],
) -> Callable:  # fmt: skip
    return _MODULE.strike_in_space


@overload(near_chord, inline="always")
def _compiled_near_chord(
    slots: np.ndarray, cell: int, place: tuple[float, float], chord: tuple[float, float],
    reach2: float,
) -> Callable:  # fmt: skip
    return _MODULE.near_chord
