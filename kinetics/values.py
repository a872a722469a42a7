"""What makes a result a value: read-only contents, equality, a hash, pickling and saving."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import fields
from functools import cached_property
from typing import Any

import numpy as np

from kinetics.frozen import contents, frozen
from kinetics.storage import save


class Value:
    """Base of the frozen dataclasses that are results, or parts of results.

    Their arrays are read-only and their dictionaries are frozen (`kinetics.frozen`), also after
    pickling. Two of one class are equal when every compared field has the same contents. What was
    computed on demand and kept (cached properties) is no part of the value: it is neither compared
    nor pickled. The text is one line, unless the class has its own ``__repr__``.
    """

    def __init_subclass__(cls, **arguments: Any) -> None:
        # @dataclass, which runs after this, keeps the methods that it finds in the class itself
        super().__init_subclass__(**arguments)
        cls.__eq__ = Value.__eq__  # type: ignore[method-assign]
        cls.__hash__ = Value.__hash__  # type: ignore[method-assign]
        if "__repr__" not in vars(cls):
            cls.__repr__ = brief  # type: ignore[method-assign]

    def __post_init__(self) -> None:
        values = self.__dict__  # past the lock of a frozen dataclass
        for name, value in values.items():
            values[name] = frozen(value)

    def store(self, **values: Any) -> None:
        """Set fields in ``__post_init__``; arrays and dictionaries as copies that do not change."""
        for name, value in values.items():
            self.__dict__[name] = frozen(value)

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return bool(contents(self) == contents(other))

    def __hash__(self) -> int:
        return hash(contents(self))

    def __getstate__(self) -> dict[str, Any]:
        cls = type(self)
        return {
            name: value
            for name, value in vars(self).items()
            if not isinstance(getattr(cls, name, None), cached_property)
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.store(**state)  # NumPy restores every array as a writable one

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write this to an HDF5 file, whole or not at all; :func:`kinetics.load` reads it back.

        Raises InputError where the file cannot be written, or where the initial state is a Python
        function, which a file cannot hold.
        """
        save(self, path)


def html_table(figures: Mapping[str, str]) -> str:
    """A table of two columns for notebooks: the name of each figure and its value, as HTML."""
    rows = "".join(f"<tr><td>{name}</td><td>{value}</td></tr>" for name, value in figures.items())
    return f"<table>{rows}</table>"


def brief(value: Any) -> str:
    """A dataclass in one line: arrays by their sizes and ranges, functions by their names."""
    shown = (f"{f.name}={_summary(getattr(value, f.name))}" for f in fields(value))
    return f"{type(value).__name__}({', '.join(shown)})"


def _summary(value: Any) -> str:
    if isinstance(value, np.ndarray):
        ends = f", {value.min():.6g} to {value.max():.6g}" if value.size else ""
        return f"<{' x '.join(map(str, value.shape))} numbers{ends}>"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key!r}: {_summary(item)}" for key, item in value.items()) + "}"
    if callable(value):
        return str(getattr(value, "__qualname__", type(value).__name__))
    return repr(value)
