"""Results as values: read-only arrays, equality and hash by content, pickling."""

from dataclasses import fields
from types import MappingProxyType
from typing import Any

import numpy as np


def frozen(value: Any) -> Any:
    """Return a read-only view of an array or of a dict of arrays; anything else as it is."""
    if isinstance(value, np.ndarray):
        value = value.view()
        value.setflags(write=False)
    elif isinstance(value, dict):
        value = MappingProxyType({name: frozen(item) for name, item in value.items()})
    return value


def _content(value: Any) -> Any:
    if isinstance(value, (np.ndarray, np.generic)):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, MappingProxyType):
        return tuple((name, _content(value[name])) for name in sorted(value))
    return value


class Value:
    """Base of frozen dataclasses (eq=False) that hold arrays.

    Two are equal if they are of one class and every field is, arrays bit by bit (so NaN equals
    NaN). Fields are made read-only. Pickling keeps the fields alone, not what was computed of them.
    """

    def __post_init__(self) -> None:
        for field in fields(self):  # type: ignore[arg-type]
            object.__setattr__(self, field.name, frozen(getattr(self, field.name)))

    def _key(self) -> tuple[Any, ...]:
        return tuple(_content(getattr(self, f.name)) for f in fields(self))  # type: ignore[arg-type]

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash((type(self), self._key()))

    def __getstate__(self) -> dict[str, Any]:
        state = {f.name: getattr(self, f.name) for f in fields(self)}  # type: ignore[arg-type]
        return {k: dict(v) if isinstance(v, MappingProxyType) else v for k, v in state.items()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():
            object.__setattr__(self, name, frozen(value))
