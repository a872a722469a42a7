"""How functions are compiled: `inlined` into kernels, `called` by them, or a `kernel` kept on disk.

The steps of a tracer come `by_dimension`: one event loop serves the plane and space, and is
compiled for either with the steps of that dimension in it.

numba keeps compiled code in `__pycache__`, or where NUMBA_CACHE_DIR says, and compiles a function
anew when its own file has changed. It does not see a change to a function of another file that has
been inlined. Here the contents of every file that a kernel may be made of are part of the key that
compiled code is found by, so no file ever has to be deleted by hand.
"""

from collections.abc import Callable
from functools import cache
from hashlib import sha256
from importlib.resources import files
from typing import Any

from numba import njit
from numba.extending import overload, register_jitable

from particles.compiled.cache import Cache, keep
from particles.compiled.search import FORM

# forceinline: LLVM puts the body where the call is, so a step costs no call and no copies.
_OPTIONS: Any = {"error_model": "numpy", "forceinline": True, "no_cfunc_wrapper": True}
_KERNEL: Any = {"error_model": "numpy", "nogil": True, "no_cfunc_wrapper": True}
# Interpreted where Python calls them. So they are compiled without an entry for Python, which would
# begin with the conversion of all arguments and take a third of the time.
called = register_jitable(error_model="numpy", no_cfunc_wrapper=True)
inlined = register_jitable(**_OPTIONS)


def by_dimension(plane: Any, space: Any) -> Callable:
    """Return one function for two `inlined` ones of the same arguments.

    The first argument is a record; the function for space is meant if it has a field `z`. A kernel
    chooses when it is compiled, so it has no trace of the other function.
    """

    def either(record: Any, *others: Any) -> Any:
        return (space if "z" in record.dtype.names else plane)(record, *others)

    def choose(record: Any, *others: Any) -> Any:
        chosen = space if "z" in record.fields else plane
        return getattr(chosen, "py_func", chosen)

    overload(either, strict=False, jit_options=_OPTIONS)(choose)
    return either


@cache
def sources() -> str:
    """Return the SHA-256 of the files that kernels are compiled from, in hexadecimal."""
    root = files("particles")
    found = [root / "events.py", root / "streams.py"]
    for folder in ("compiled", "grid", "kernel"):
        found += [path for path in (root / folder).iterdir() if path.name.endswith(".py")]
    total = sha256()
    for path in sorted(found, key=str):
        total.update(path.read_bytes())
    return total.hexdigest()


class _Cache(Cache):
    def _index_key(self, signature: Any, codegen: Any) -> tuple[Any, ...]:
        return (*super()._index_key(signature, codegen), sources(), FORM)


def kernel(function: Callable) -> Any:
    """Compile a function that Python calls: it runs without the GIL and is kept on disk."""
    compiled: Any = njit(**_KERNEL)(function)
    # The same function again: nothing is compiled (NUMBA_DISABLE_JIT).
    return compiled if compiled is function else keep(compiled, _Cache)
