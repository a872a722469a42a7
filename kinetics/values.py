"""What makes a result a value: read-only contents, equality, a hash, pickling and saving.

A result is a frozen dataclass that inherits from :class:`Value`. Its arrays are read-only and its
dictionaries are frozen (`kinetics.frozen`), and it equals another one of its class when every
compared field has the same contents.
"""

from __future__ import annotations

import os
from functools import cached_property
from typing import Any

from kinetics.frozen import contents, frozen
from kinetics.storage import save


class Value:
    """Base of the frozen dataclasses that are results, or parts of results.

    Gives each of them equality and a hash by contents (also where fields are arrays), arrays that
    stay read-only after pickling, and :meth:`save`. What was computed on demand and kept
    (cached properties) is no part of the value: it is neither compared nor pickled.
    """

    def __init_subclass__(cls, **arguments: Any) -> None:
        # @dataclass, which runs after this, keeps the methods that it finds in the class itself
        super().__init_subclass__(**arguments)
        cls.__eq__ = Value.__eq__  # type: ignore[method-assign]
        cls.__hash__ = Value.__hash__  # type: ignore[method-assign]

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return bool(contents(self) == contents(other))

    def __hash__(self) -> int:
        return hash(contents(self))

    def __getstate__(self) -> dict[str, Any]:
        kept = [name for name in self.__dict__ if not _is_cached(type(self), name)]
        return {name: self.__dict__[name] for name in kept}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():
            # NumPy restores every array as a writable one
            object.__setattr__(self, name, frozen(value))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write this to an HDF5 file, whole or not at all; :func:`kinetics.load` reads it back.

        Raises InputError where the file cannot be written, or where the initial state is a Python
        function, which a file cannot hold.
        """
        save(self, path)


def _is_cached(cls: type, name: str) -> bool:
    return isinstance(getattr(cls, name, None), cached_property)
