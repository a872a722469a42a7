"""A value as JSON, from which the value can be built again; nothing in it is executed.

Only classes that are registered with :func:`stored_class` are written and built.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, Protocol, Self, TypeVar, runtime_checkable

import numpy as np

from kinetics.errors import InputError, PlanStep, SolverStatus, short

#: Arrays of more numbers are named by their shape in a record for people.
MAX_NUMBERS_SHOWN = 200

#: The classes that a record may hold, by name.
_stored_classes: dict[str, type] = {}

Class = TypeVar("Class", bound=type)

#: What `json` writes and reads.
Json = bool | int | float | str | list["Json"] | dict[str, "Json"] | None


def stored_class(cls: Class) -> Class:
    """Register a dataclass or an enumeration as one that files may hold (a class decorator)."""
    _stored_classes[cls.__name__] = cls
    return cls


@runtime_checkable
class HasParts(Protocol):
    """A value that says of which parts it is built again."""

    def _to_storage(self) -> dict[str, object]:
        """Return the parts, by name."""

    @classmethod
    def _from_storage(cls, parts: dict[str, Any]) -> Self:
        """Build the value of its parts; sequences are tuples there."""


def to_json(value: object) -> Json:
    """Return a value as plain JSON types, complete, for :func:`from_json`.

    Raises InputError for a Python function, and for a class that is not registered.
    """
    if isinstance(value, np.ndarray):
        return {"array": value.tolist()}
    if isinstance(value, np.generic):
        return value.item()
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, list | tuple):
        return _items_of_list(value, to_json)
    if isinstance(value, Mapping):
        return _items_of_mapping(value, to_json)
    _check_storable(value)
    if isinstance(value, enum.Enum):
        return {"class": type(value).__name__, "name": value.name}
    if isinstance(value, HasParts):
        stored = value._to_storage()
    else:
        stored = initial_fields(value)
    return _tagged(value, _items_of_mapping(stored, to_json))


def describe(value: object) -> Json:
    """Return a value as plain JSON types for people: long arrays and functions are only named."""
    if isinstance(value, np.ndarray | np.generic):
        if value.size > MAX_NUMBERS_SHOWN:
            return f"numbers of shape {value.shape}"
        return value.tolist()
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, list | tuple):
        return _items_of_list(value, describe)
    if isinstance(value, Mapping):
        return _items_of_mapping(value, describe)
    if isinstance(value, enum.Enum):
        return {"class": type(value).__name__, "name": value.name}
    if not is_dataclass(value) or isinstance(value, type):
        return str(getattr(value, "__qualname__", type(value).__name__))
    return _tagged(value, _items_of_mapping(initial_fields(value), describe))


def _items_of_list(values: Sequence[object], convert: Callable[[object], Json]) -> list[Json]:
    """Return each item of a sequence as plain JSON types."""
    return [convert(item) for item in values]


def _items_of_mapping(
    values: Mapping[Any, object], convert: Callable[[object], Json]
) -> dict[str, Json]:
    """Return each item of a mapping as plain JSON types, by its key as a text."""
    return {str(key): convert(item) for key, item in values.items()}


def initial_fields(value: object) -> dict[str, object]:
    """Return the arguments with which a dataclass was made, by name."""
    arguments: dict[str, object] = {}
    for field in fields(value):  # type: ignore[arg-type]
        if field.init:
            arguments[field.name] = getattr(value, field.name)
    return arguments


def _tagged(value: object, arguments: dict[str, Json]) -> dict[str, Json]:
    """Return the arguments of a value with the name of its class."""
    if arguments.get("mass_ratio") == math.inf:
        del arguments["mass_ratio"]  # JSON has no infinity, and it is the default
    return {"class": type(value).__name__, **arguments}


def _check_storable(value: object) -> None:
    """Raise InputError unless the class of a value is registered."""
    cls = type(value)
    if _stored_classes.get(cls.__name__) is cls:
        return
    if callable(value) and not is_dataclass(value):
        hint = "a Python function cannot be saved in a file, give the density as a SpeedTable"
        raise InputError(f"initial: got {short(value)}; {hint}")
    raise InputError(f"value: got {short(value)}; a {cls.__name__} cannot be saved in a file")


def from_json(document: Json, find_class: Callable[[str], object]) -> Any:
    """Build the value that :func:`to_json` wrote; InputError for a class that is not registered.

    Parameters
    ----------
    document : of plain JSON types
    find_class : imports the module that defines, and registers, the class of a name
    """
    if isinstance(document, list):
        return tuple(from_json(item, find_class) for item in document)
    if not isinstance(document, dict):
        return document
    if "array" in document:
        return np.asarray(document["array"])
    arguments = {name: from_json(item, find_class) for name, item in document.items()}
    if "class" not in arguments:
        return arguments
    name = arguments.pop("class")
    find_class(str(name))
    cls = _stored_classes.get(str(name))
    if cls is None:
        raise InputError(f"it holds a {short(name)}, which is not known here")
    if issubclass(cls, enum.Enum):
        return cls[arguments["name"]]
    if issubclass(cls, HasParts):
        return cls._from_storage(arguments)
    return cls(**arguments)


# The classes of `kinetics.errors`, which stands below this module, are registered here.
stored_class(PlanStep)
stored_class(SolverStatus)
