"""What makes a result a value: read-only contents, equality, a hash, pickling and saving.

A result is a frozen dataclass that inherits from :class:`Value`. Its arrays are read-only
(:func:`read_only`), its dictionaries are :class:`FrozenDict`, and it equals another one of its
class when every compared field has the same contents.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

K = TypeVar("K")
V = TypeVar("V")


def read_only(values: ArrayLike) -> NDArray[Any]:
    """A read-only copy of an array; the array itself if nobody can write to it already."""
    array = np.asarray(values)
    if array.flags.writeable or array.base is not None:
        array = array.copy()
        array.flags.writeable = False
    return array


class FrozenDict(Mapping[K, V]):
    """A dictionary that cannot be changed, which can be pickled; its arrays are read-only."""

    __slots__ = ("_items",)
    _items: dict[K, V]

    def __init__(self, items: Mapping[K, V]) -> None:
        object.__setattr__(self, "_items", {key: frozen(value) for key, value in items.items()})

    def __getitem__(self, key: K) -> V:
        return self._items[key]

    def __iter__(self) -> Iterator[K]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"a {type(self).__name__} cannot be changed")

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Mapping) and contents(self) == contents(other)

    def __hash__(self) -> int:
        return hash(contents(self))

    def __repr__(self) -> str:
        return repr(self._items)

    def __reduce__(self) -> tuple[Any, ...]:
        return FrozenDict, (self._items,)


def frozen(value: Any) -> Any:
    """The value with read-only arrays and dictionaries, in tuples and dictionaries too."""
    if isinstance(value, np.ndarray):
        return read_only(value)
    if isinstance(value, Mapping):
        return FrozenDict(value)
    if type(value) is tuple:
        return tuple(frozen(item) for item in value)
    return value


def contents(value: Any) -> Any:
    """A hashable object that is the same for equal contents: NaN equals NaN, and -0 equals 0."""
    if isinstance(value, np.ndarray):
        array = value + 0.0 if value.dtype.kind in "fc" else value
        return array.dtype.str, array.shape, array.tobytes()
    if isinstance(value, Mapping):
        return frozenset((key, contents(item)) for key, item in value.items())
    if isinstance(value, tuple | list):
        return tuple(contents(item) for item in value)
    if isinstance(value, float) and value != value:
        return "NaN"
    if is_dataclass(value) and not isinstance(value, type):
        compared = [contents(getattr(value, f.name)) for f in fields(value) if f.compare]
        return type(value), tuple(compared)
    return value


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
        from kinetics.storage import save

        save(self, path)


def _is_cached(cls: type, name: str) -> bool:
    return isinstance(getattr(cls, name, None), cached_property)
