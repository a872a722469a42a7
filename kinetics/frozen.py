"""Contents that cannot be changed: read-only arrays, frozen dictionaries, and their equality."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

K = TypeVar("K")
V = TypeVar("V")


def read_only(values: ArrayLike) -> NDArray[Any]:
    """A read-only copy of an array; the array itself if it is read-only already."""
    array = np.asarray(values)
    if array.flags.writeable or array.base is not None:
        array = array.copy()
        array.setflags(write=False)
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


_PLAIN = frozenset({float, int, str, bool, complex, type(None)})  # nothing in them can change


def frozen(value: Any) -> Any:
    """The value with read-only arrays and dictionaries, in tuples and dictionaries too."""
    kind = type(value)
    if kind in _PLAIN or kind is FrozenDict:
        return value
    if kind is tuple:
        return tuple([frozen(item) for item in value])
    if isinstance(value, np.ndarray):
        return read_only(value)
    # a dictionary of any kind; asking Mapping about every object takes longer than freezing it
    if hasattr(kind, "keys") and isinstance(value, Mapping):
        return FrozenDict(value)
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
