"""Compiled code on disk, in numba's own files; where they cannot be used it is compiled anew."""

import warnings
from contextlib import suppress
from functools import cache
from typing import Any

from numba.core.caching import FunctionCache


class Cache(FunctionCache):
    """numba's files of one function; what cannot be read or written there stops nothing."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the compiled code, or None where there is none that can be used."""
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # what a full disk or a loss of power has left there
            with suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
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


def keep(compiled: Any, kind: type[Cache] = Cache) -> Any:
    """Keep what is compiled of a function, under the keys of this kind of cache."""
    try:
        compiled._cache = kind(compiled.py_func)
    except RuntimeError:  # numba finds no folder that it may write to
        _warn_not_kept("no folder for it can be written")
    return compiled
