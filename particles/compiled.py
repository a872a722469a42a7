"""How functions are compiled: `inlined` into kernels, `called` by them, or a `kernel` kept on disk.

numba compiles a function anew when its own file has changed, but does not see a change to one of
another file that has been inlined. Here the contents of every file that a kernel may be made of are
part of the key that compiled code is found by. Begin reading with `kernel`.
"""

import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from hashlib import sha256
from importlib.resources import files
from typing import Any, ParamSpec, TypeVar

from numba import njit
from numba.core.caching import FunctionCache
from numba.extending import register_jitable

P = ParamSpec("P")
R = TypeVar("R")

#: Options of njit, whose types do not know all of them.
KERNEL_OPTIONS: Any = {"error_model": "numpy", "nogil": True, "no_cfunc_wrapper": True}
# Interpreted where Python calls them. So they are compiled without an entry for Python, which would
# begin with the conversion of all arguments and take a third of the time.
called = register_jitable(error_model="numpy", no_cfunc_wrapper=True)
# forceinline: LLVM puts the body where the call is, so a step costs no call and no copies.
inlined = register_jitable(error_model="numpy", forceinline=True, no_cfunc_wrapper=True)


@cache
def sources() -> str:
    """Return the SHA-256 of the files that kernels are compiled from, in hexadecimal."""
    root = files("particles")
    paths = [*root.iterdir(), *(root / "kernel").iterdir()]
    total = sha256()
    for path in sorted(paths, key=str):
        if path.name.endswith(".py"):
            total.update(path.read_bytes())
    return total.hexdigest()


class _Cache(FunctionCache):
    """numba's files of one function; what cannot be read or written there stops nothing."""

    def _index_key(self, signature: object, codegen: object) -> tuple[object, ...]:
        return (*super()._index_key(signature, codegen), sources())

    def load_overload(self, sig: object, target_context: object) -> object:
        """Return the compiled code, or None where there is none that can be used."""
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # what a full disk or a loss of power has left there
            with suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: object, data: object) -> None:
        """Write compiled code."""
        try:
            super().save_overload(sig, data)
        except OSError as error:
            _warn_not_kept(error.strerror or str(error))


@cache
def _warn_not_kept(why: str) -> None:
    """Say, once, that every process compiles anew."""
    warnings.warn(
        f"compiled code cannot be kept ({why}): each start compiles it again, for up to half a "
        f"minute; set NUMBA_CACHE_DIR to a folder of yours",
        stacklevel=2,
    )


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function that Python calls: it runs without the GIL and is kept on disk."""
    compiled: Any = njit(**KERNEL_OPTIONS)(function)
    if compiled is not function:  # the same function again under NUMBA_DISABLE_JIT
        try:
            compiled._cache = _Cache(function)
        except RuntimeError:  # numba finds no folder that it may write to
            _warn_not_kept("no folder for it can be written")
    return compiled
