"""Results in HDF5 files: `save(value, path)` and `load(path)`.

A file holds one value of a class that is named in :data:`HOMES` or was given to :func:`register`.
Each field of a dataclass is an HDF5 object of that name, so that a file can be read without this
package: arrays and scalars are datasets; dataclasses, dictionaries and tuples are groups. The
attribute `kind` of each object says what it stands for, `class` names the class of a dataclass or
an enumeration, and `unit` is the unit of an array where the class states it. Before the HDF5 data,
in the "user block" that HDF5 skips, stand the format, its version and the SHA-256 of all the rest:
HDF5 itself notices hardly any damage, and may never come to an end on a damaged file.

Nothing in a file is ever executed: there is no pickle inside, and Python functions are refused. A
class may say what is stored of it with `_to_storage(self) -> dict` and restore it with the
classmethod `_from_storage(cls, parts)`; the units of its arrays with `_storage_units(self)`, a
dictionary from paths to units.
"""

from __future__ import annotations

import contextlib
import enum
import hashlib
import io
import os
import secrets
import stat
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

from kinetics.errors import InputError, short

if TYPE_CHECKING:
    import h5py

FORMAT = "inelastic-lorentz kinetics"
VERSION = 1
_HEADER = 512  # bytes of the user block, the smallest that HDF5 allows

HOMES = {
    # what a user saves, and what these are made of
    "ByCollision": "kinetics.moments.by_collision",
    "CollisionLaw": "kinetics.collision.law",
    "Comparison": "kinetics.crosscheck.compare.result",
    "SampledBounce": "kinetics.collision.samples",
    "FieldState": "kinetics.field.solution",
    "FieldUnits": "kinetics.field.solution",
    "PlanStep": "kinetics.status",
    "ScaledVDF": "kinetics.scaling.scaled_vdf",
    "ScalingSolution": "kinetics.scaling.closed_form",
    "Scene": "kinetics.scene",
    "Solution": "kinetics.solution",
    "SolverStatus": "kinetics.status",
    # initial states
    "AngularHarmonics": "kinetics.states.directed",
    "Beam": "kinetics.states.directed",
    "Gaussian": "kinetics.states.isotropic",
    "Maxwell": "kinetics.states.isotropic",
    "Monoenergetic": "kinetics.states.isotropic",
    "PolarGrid": "kinetics.states.directed",
    "Rest": "kinetics.states.isotropic",
    "SpeedDensity": "kinetics.states.isotropic",
    "SpeedSamples": "kinetics.states.isotropic",
    "SpeedTable": "kinetics.states.isotropic",
    "VelocitySamples": "kinetics.states.directed",
    # densities of the velocity
    "ElasticDensity": "kinetics.densities.elastic",
    "GridDensity": "kinetics.densities.grid_density",
    "LogGrid": "kinetics.numerics.log_grid",
    "NodeMasses": "kinetics.densities.node_masses",
    "Profile": "kinetics.densities.harmonic",
    "ThenScaling": "kinetics.densities.harmonic",
    # the steady state in a field
    "SpeedPanels": "kinetics.field.panels",
    "SteadyAverages": "kinetics.field.averages",
    # density of the displacement
    "Displacement": "kinetics.position.density",
    "FrontTail": "kinetics.position.front_tail",
    "OnceCollided": "kinetics.position.once_collided",
    "PowerTail": "kinetics.position.tail",
    "UncollidedDensity": "kinetics.position.ballistic_front",
    "WavePanel": "kinetics.position.wave_panel",
}
"""Name of a class in a file -> the module that defines it. Names stay, modules may move."""

_registered: dict[str, type] = {}

_SCALARS = {"bool": bool, "int": int, "float": float, "complex": complex}


def register(cls: type, name: str | None = None) -> type:
    """Make a frozen dataclass, or an enumeration, one that files may hold; also as a decorator.

    ``name`` is what the class is called in files, its own name by default. So that `load` finds
    the class before its module is imported, add a line to :data:`HOMES` as well.
    """
    _registered[name or cls.__name__] = cls
    return cls


def save(value: Any, path: str | os.PathLike[str]) -> None:
    """Write a value to an HDF5 file at the path, whole or not at all.

    It is written under another name in the same folder and renamed, so that an interruption leaves
    what was there before.

    Raises
    ------
    InputError (a ValueError) : the file cannot be written, or the value holds something that a
        file cannot, such as a Python function
    """
    import h5py

    what = type(value).__name__
    _name_of(type(value), what, value)
    # In memory: where the disk is full, HDF5 ends the process while it closes its file.
    image = io.BytesIO()
    with h5py.File(image, "w", userblock_size=_HEADER) as file:
        _write(file, "value", value, what)
    image.seek(0)
    image.write(_header(hashlib.sha256(image.getbuffer()[_HEADER:]).hexdigest()))
    _write_whole(_path(path), image.getbuffer())


def _write_whole(target: str, contents: memoryview) -> None:
    """Write a file beside its target, under a random name, and rename it."""
    folder, base = os.path.split(target)
    beside = os.path.join(folder, f".{base}.{secrets.token_hex(8)}.part")
    try:
        _require_file(target)
        with open(beside, "xb", buffering=0) as file:  # x: never through a symbolic link
            while contents:
                contents = contents[file.write(contents[: 2**24]) :]
            os.fsync(file.fileno())
        os.replace(beside, target)
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(f"path: got {target!r}; it cannot be written ({reason})") from None
    finally:
        with contextlib.suppress(OSError):
            os.unlink(beside)  # it is there only if something went wrong


def _path(path: str | os.PathLike[str]) -> str:
    try:
        text = os.fsdecode(path)
    except TypeError:
        text = ""
    if not text or "\0" in text:
        raise InputError(f"path: got {short(path)}; it must be the path of a file")
    return text


def _require_file(path: str) -> None:
    """Raise InputError where a device or a pipe is, which might be waited for or be replaced."""
    with contextlib.suppress(OSError):
        mode = os.stat(path).st_mode
        if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
            raise InputError(f"path: got {path!r}; it is a device or a pipe, not a file")


def load(path: str | os.PathLike[str]) -> Any:
    """The value that a file holds, of the class that was saved; see :func:`save`.

    Raises
    ------
    InputError (a ValueError) : no such file, a damaged one, one of another format or version, or
        one that holds a class which this version does not know
    """
    import h5py

    name = _path(path)
    _require_file(name)
    _check_header(name)
    try:
        with h5py.File(name, "r") as file:
            return _read(_child(file, "value"), name)
    except InputError:
        raise
    except Exception as error:  # h5py raises errors of nearly any class
        raise _damaged(name, type(error).__name__) from None


def _damaged(path: str, why: str) -> InputError:
    return InputError(f"path: got {path!r}; it is damaged, or from another program ({why})")


def _header(digest: str) -> bytes:
    """The first bytes of a file: its format, its version and the SHA-256 of all the rest."""
    return f"{FORMAT} version {VERSION} sha256 {digest}\n".encode().ljust(_HEADER, b"\0")


def _check_header(path: str) -> None:
    """Raise InputError unless the file is one of ours, of this version, and undamaged."""
    try:
        with open(path, "rb") as file:
            found = file.read(_HEADER)
            expected = _header(hashlib.file_digest(file, "sha256").hexdigest())
    except OSError as error:
        raise InputError(f"path: got {path!r}; it cannot be read ({error.strerror})") from None
    words = found[: found.find(b"\n")].decode("ascii", "replace").split(" version ")
    if words[0] != FORMAT or len(words) != 2:
        raise InputError(f"path: got {path!r}; it is no file that kinetics saved")
    version = words[1].split(" ")[0]
    if version != str(VERSION):
        raise InputError(
            f"path: got {path!r}; it has version {version} of the format, this program reads "
            f"version {VERSION}"
        )
    if found != expected:
        raise _damaged(path, "its contents do not match their digest")


def _name_of(cls: type, where: str, value: Any) -> str:
    """What a class is called in files; InputError if it cannot be stored."""
    for name, registered in _registered.items():
        if registered is cls:
            return name
    if HOMES.get(cls.__name__) == cls.__module__:
        return cls.__name__
    if callable(value):
        raise InputError(
            f"{where}: got {short(value)}; a Python function cannot be stored in a file: give the "
            "initial state as a SpeedTable (or another state that is made of numbers)"
        )
    raise InputError(f"{where}: got {short(value)}; a {cls.__name__} cannot be stored in a file")


def _class_of(name: str, path: str) -> type:
    """The class that has this name in files; InputError if there is none."""
    if name not in _registered and name in HOMES:
        return register(getattr(import_module(HOMES[name]), name), name)
    if name not in _registered:
        raise InputError(f"path: got {path!r}; it holds a {name!r}, which is not known here")
    return _registered[name]


# -- writing --------------------------------------------------------------------------------------


def _write(group: h5py.Group, name: str, value: Any, where: str) -> None:
    """Write a value under this name; ``where`` says in messages which part of the whole it is."""
    import h5py
    import numpy as np

    if isinstance(value, np.generic):
        value = value.item()
    kind = type(value).__name__
    if value is None:
        group.create_dataset(name, data=h5py.Empty("f8")).attrs["kind"] = "none"
    elif isinstance(value, enum.Enum):
        item = group.create_dataset(name, data=value.name)
        item.attrs["kind"] = "enum"
        item.attrs["class"] = _name_of(type(value), where, value)
    elif kind in _SCALARS or kind == "str":
        if kind == "int" and not -(2**63) <= value < 2**63:
            raise InputError(f"{where}: got {short(value)}; files hold whole numbers of 64 bits")
        group.create_dataset(name, data=value).attrs["kind"] = kind
    elif isinstance(value, np.ndarray) and value.dtype.kind in "biufc":
        group.create_dataset(name, data=value).attrs["kind"] = "array"
    elif isinstance(value, tuple | list) and kind in ("tuple", "list"):
        children = _subgroup(group, name, kind)
        for i, item in enumerate(value):
            _write(children, str(i), item, f"{where}[{i}]")
    elif isinstance(value, Mapping):
        _write_mapping(group, name, value, where)
    else:
        _write_object(group, name, value, where)


def _subgroup(group: h5py.Group, name: str, kind: str) -> h5py.Group:
    found = group.create_group(name, track_order=True)
    found.attrs["kind"] = kind
    return found


def _write_mapping(group: h5py.Group, name: str, value: Mapping[Any, Any], where: str) -> None:
    """A dictionary whose keys are all strings or all whole numbers."""
    children = _subgroup(group, name, "dict" if isinstance(value, dict) else "mapping")
    kinds = {type(key) for key in value}
    if len(kinds) > 1 or not kinds <= {str, int} or any("/" in str(key) for key in value):
        raise InputError(f"{where}: got keys {short(list(value))}; they must be names or numbers")
    children.attrs["keys"] = "int" if int in kinds else "str"
    for key, item in value.items():
        _write(children, str(key), item, f"{where}[{key!r}]")


def _write_object(group: h5py.Group, name: str, value: Any, where: str) -> None:
    """A dataclass, field by field."""
    stored_as = _name_of(type(value), where, value)
    children = _subgroup(group, name, "object")
    children.attrs["class"] = stored_as
    if hasattr(value, "_to_storage"):
        parts = value._to_storage()
    else:
        parts = {f.name: getattr(value, f.name) for f in fields(value) if f.init}
    for key, item in parts.items():
        _write(children, key, item, f"{where}.{key}")
    units = value._storage_units() if hasattr(value, "_storage_units") else {}
    for key, unit in units.items():
        if key in children:
            children[key].attrs["unit"] = unit


# -- reading --------------------------------------------------------------------------------------


def _read(item: Any, path: str) -> Any:
    """The value that an HDF5 object stands for."""
    from kinetics.frozen import FrozenDict, read_only

    kind = item.attrs["kind"]
    if kind == "none":
        return None
    if kind == "enum":
        return _class_of(item.attrs["class"], path)[item.asstr()[()]]  # type: ignore[index]
    if kind == "str":
        return item.asstr()[()]
    if kind == "array" or kind in _SCALARS:
        _require_own(item)
    if kind in _SCALARS:
        return _SCALARS[kind](item[()])
    if kind == "array":
        return read_only(item[()])
    if kind in ("tuple", "list"):
        found = [_read(_child(item, str(i)), path) for i in range(len(item))]
        return tuple(found) if kind == "tuple" else found
    children: dict[Any, Any] = {key: _read(_child(item, key), path) for key in item}
    if kind == "object":
        return _rebuild(_class_of(item.attrs["class"], path), children)
    if item.attrs["keys"] == "int":
        children = {int(key): child for key, child in children.items()}
    return children if kind == "dict" else FrozenDict(children)


def _child(group: h5py.Group, name: str) -> Any:
    """An object of a group; KeyError for a link to another place, which may be another file."""
    import h5py

    if not isinstance(group.get(name, getlink=True), h5py.HardLink):
        raise KeyError(name)
    return group[name]


def _require_own(dataset: h5py.Dataset) -> None:
    """Raise ValueError for data of another file, or that are larger than what is stored of them."""
    elsewhere = dataset.is_virtual or dataset.external or dataset.chunks is not None
    if elsewhere or dataset.id.get_storage_size() != dataset.nbytes:
        raise ValueError


def _rebuild(cls: type[Any], parts: dict[str, Any]) -> Any:
    """An object from its parts, without its __init__: the numbers stay as they were stored."""
    if hasattr(cls, "_from_storage"):
        return cls._from_storage(parts)
    assert is_dataclass(cls)
    found: Any = object.__new__(cls)
    for f in fields(cls):
        if f.init and f.name in parts:
            value = parts.pop(f.name)
        elif f.default_factory is not MISSING:
            value = f.default_factory()
        elif f.default is not MISSING:
            value = f.default
        else:
            raise KeyError(f.name)
        object.__setattr__(found, f.name, value)
    if parts:
        raise KeyError(*parts)
    return found
