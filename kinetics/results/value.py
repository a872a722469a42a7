"""Values: frozen dataclasses whose contents cannot change."""

from __future__ import annotations

import copyreg
from collections.abc import Hashable, Mapping
from dataclasses import Field, fields, is_dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from kinetics.results.table import wrapped


def frozen(value: Any) -> Any:
    """Return a value with read-only arrays (copies of others) and dictionaries, in tuples too."""
    if isinstance(value, np.ndarray):
        is_protected = not value.flags.writeable and value.base is None
        return value if is_protected else _read_only_copy(value)
    if type(value) is tuple:
        return tuple(frozen(item) for item in value)
    if isinstance(value, (dict, MappingProxyType)):
        return MappingProxyType({key: frozen(item) for key, item in value.items()})
    return value


def _read_only_copy(array: np.ndarray) -> np.ndarray:
    """Return a copy of an array that cannot be written."""
    copied = array.copy()
    copied.setflags(write=False)
    return copied


def _reduce_mapping_proxy(proxy: MappingProxyType[Any, Any]) -> tuple[Any, tuple[Any]]:
    """Return how to pickle a read-only dictionary, which Python itself cannot."""
    return frozen, (dict(proxy),)


copyreg.pickle(MappingProxyType, _reduce_mapping_proxy)


def contents(value: object) -> Hashable:
    """Return an object that is equal for equal contents, where NaN equals NaN and -0 equals 0."""
    if isinstance(value, np.ndarray):
        has_signed_zero = value.dtype.kind in "fc"
        array = value + 0.0 if has_signed_zero else value
        return array.dtype.str, array.shape, array.tobytes()
    if isinstance(value, Mapping):
        return frozenset((key, contents(item)) for key, item in value.items())
    if isinstance(value, tuple | list):
        return tuple(contents(item) for item in value)
    if is_dataclass(value) and not isinstance(value, type):
        compared = [
            contents(getattr(value, field.name)) for field in fields(value) if field.compare
        ]
        return type(value), *compared
    if isinstance(value, float) and np.isnan(value):
        return "NaN"
    return value


class Value:
    """Base of frozen dataclasses whose contents cannot change: scenes, states and results.

    Arrays are read-only and dictionaries frozen, also after pickling. Two objects of one class are
    equal if all compared fields are. Cached properties are neither compared nor pickled.

    A subclass is decorated with ``@dataclass(frozen=True, eq=False, repr=False)``: comparison, hash
    and repr are those of this class, as the ones that `dataclass` writes cannot compare arrays.
    """

    def __post_init__(self) -> None:
        self.store(**self.__dict__)

    def store(self, **values: object) -> None:
        """Set fields in ``__post_init__``; arrays and dictionaries as copies that do not change."""
        for name, value in values.items():
            object.__setattr__(self, name, frozen(value))

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return contents(self) == contents(other)

    def __hash__(self) -> int:
        return hash(contents(self))

    def __repr__(self) -> str:
        arguments = [f"{name}={text}" for name, text in fields_shown(self).items()]
        return wrapped(f"{type(self).__name__}({', '.join(arguments)})")

    def __getstate__(self) -> dict[str, object]:
        return {name: value for name, value in vars(self).items() if not self._is_cache(name)}

    def __setstate__(self, state: dict[str, object]) -> None:
        self.store(**state)  # NumPy restores every array as a writable one

    @classmethod
    def _is_cache(cls, name: str) -> bool:
        """Return whether an attribute is a cached property, which can be computed again."""
        return isinstance(getattr(cls, name, None), cached_property)


def fields_shown(value: object) -> dict[str, str]:
    """Return the texts of the fields that are not as by default, by name."""
    shown = {}
    for field in fields(value):  # type: ignore[arg-type]
        item = getattr(value, field.name)
        if _is_worth_showing(field, item):
            shown[field.name] = _short_text(item)
    return shown


def _is_worth_showing(field: Field[object], item: object) -> bool:
    """Return whether a repr needs a field: not if it is empty or has its default."""
    if not field.repr:
        return False
    if isinstance(item, np.ndarray | tuple) and len(item) == 0:
        return False
    return contents(item) != contents(field.default)


def _short_text(item: object) -> str:
    """Return the text of a field: of an array its size and range, of a function its name."""
    if isinstance(item, np.ndarray):
        size = " x ".join(map(str, item.shape))
        if item.size == 1:
            return f"<1 number, {item.flat[0]:.6g}>"
        return f"<{size} numbers, {item.min():.6g} to {item.max():.6g}>"
    return getattr(item, "__qualname__", repr(item))
