"""Frozen dataclasses that hold arrays and can still be compared, hashed, pickled and printed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from types import MappingProxyType
from typing import Any, cast

import numpy as np


class PlainData:
    """Base class of frozen dataclasses whose fields are arrays, numbers, texts, tuples or mappings.

    A subclass is declared with ``@dataclass(frozen=True, eq=False, repr=False)``, so that the
    methods of this class are not replaced by those that ``dataclass`` writes. Two objects are equal
    if they are of one class and all their fields are equal, array by array; functions are equal if
    they are the same function. Fields declared with ``compare=False`` do not count.

    The arrays that an object is given become read-only, without a copy: hand over your own.
    """

    def __post_init__(self) -> None:
        self.store(**vars(self))

    def store(self, **values: Any) -> None:
        """Set fields. Arrays become read-only as they are (no copy), mappings read-only views."""
        for name, value in values.items():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False
            object.__setattr__(
                self, name, MappingProxyType(value) if isinstance(value, dict) else value
            )

    def _held(self, compared: bool = False) -> dict[str, Any]:
        known = fields(cast(Any, self))
        return {f.name: getattr(self, f.name) for f in known if f.compare or not compared}

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        assert isinstance(other, PlainData)
        return _equal(self._held(compared=True), other._held(compared=True))

    def __hash__(self) -> int:
        return hash((type(self).__name__, _hashable(self._held(compared=True))))

    def __getstate__(self) -> dict[str, Any]:
        # without what was cached, and without views, which cannot be pickled
        held = self._held().items()
        return {name: dict(v) if isinstance(v, MappingProxyType) else v for name, v in held}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.store(**state)  # an array that was pickled is writeable again

    def __repr__(self) -> str:
        shown = (f"{name}={_summary(value)}" for name, value in self._held(compared=True).items())
        return f"{type(self).__name__}({', '.join(shown)})"


def _equal(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return np.array_equal(a, b, equal_nan=True)
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(_equal(a[key], b[key]) for key in a)
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(map(_equal, a, b))
    return bool(a == b)


def _hashable(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.shape, (value + 0.0).tobytes()  # -0.0 equals 0.0
    if isinstance(value, Mapping):
        return frozenset((key, _hashable(item)) for key, item in value.items())
    if isinstance(value, tuple):
        return tuple(map(_hashable, value))
    return value


def _summary(value: Any) -> str:
    if isinstance(value, np.ndarray):
        size = " x ".join(map(str, value.shape))
        ends = f" from {value.min():.6g} to {value.max():.6g}" if value.dtype.kind == "f" else ""
        return f"<{size} numbers{ends}>" if value.size else "<no numbers>"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key!r}: {_summary(item)}" for key, item in value.items()) + "}"
    if callable(value):
        return str(getattr(value, "__qualname__", type(value).__name__))
    return repr(value)
