"""What results are: values with read-only arrays, of which datasets, plots and files are made.

A file is netCDF-4: the averages, for any program, and the variable `record`, the JSON from which
:func:`load` builds the value again. It is checksummed by HDF5, nothing in it is executed, and only
classes that `kinetics` names are built; what was solved on demand is solved again. xarray, pandas,
h5py and matplotlib are imported at first use.
"""

from __future__ import annotations

import contextlib
import copyreg
import enum
import io
import json
import math
import os
import secrets
import sys
from collections.abc import Collection, Mapping
from dataclasses import fields, is_dataclass
from functools import cached_property
from itertools import product
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.errors import InputError, short

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.axes import Axes

COMPONENTS = ("component", "component2")
"""Dimensions of vectors and tensors, which come last; their coordinates are x, y and z."""
_FORMAT, _RECORD = "inelastic-lorentz kinetics 3", "record"


def frozen(value: Any) -> Any:
    """The value with read-only arrays (copies of others) and dictionaries, in tuples too."""
    if isinstance(value, np.ndarray) and (value.flags.writeable or value.base is not None):
        value = value.copy()
        value.setflags(write=False)
    elif type(value) is tuple:
        return tuple([frozen(item) for item in value])
    elif isinstance(value, (dict, MappingProxyType)):
        return MappingProxyType({key: frozen(item) for key, item in value.items()})
    return value


copyreg.pickle(MappingProxyType, lambda one: (frozen, (dict(one),)))  # Python itself cannot


def _contents(value: Any) -> Any:
    """A hashable object that is the same for equal contents: NaN equals NaN, and -0 equals 0."""
    if isinstance(value, np.ndarray):
        array = value + 0.0 if value.dtype.kind in "fc" else value
        return array.dtype.str, array.shape, array.tobytes()
    if isinstance(value, Mapping):
        return frozenset((key, _contents(item)) for key, item in value.items())
    if isinstance(value, tuple | list):
        return tuple(_contents(item) for item in value)
    if is_dataclass(value) and not isinstance(value, type):
        return type(value), *(_contents(getattr(value, f.name)) for f in fields(value) if f.compare)
    return "NaN" if isinstance(value, float) and value != value else value


def _brief(value: Any) -> str:
    """A dataclass in one line: what is not as by default, arrays by their sizes and ranges."""
    shown = {}
    for one in fields(value):
        part = getattr(value, one.name)
        empty = isinstance(part, np.ndarray | tuple) and len(part) == 0
        if not (empty or not one.repr or _contents(part) == _contents(one.default)):
            shown[one.name] = getattr(part, "__qualname__", repr(part))
            if isinstance(part, np.ndarray):
                size, low, high = " x ".join(map(str, part.shape)), part.min(), part.max()
                shown[one.name] = f"<{size} numbers, {low:.6g} to {high:.6g}>"
    return f"{type(value).__name__}({', '.join(f'{n}={part}' for n, part in shown.items())})"


class Value:
    """Base of frozen dataclasses whose contents cannot change: scenes, states and results.

    Arrays are read-only and dictionaries frozen, also after pickling. Two of one class are equal
    when all compared fields are. Cached properties are neither compared nor pickled.
    """

    def __init_subclass__(cls, **arguments: Any) -> None:
        # @dataclass, which runs after this, keeps the methods that it finds in the class itself
        super().__init_subclass__(**arguments)
        cls.__eq__ = Value.__eq__  # type: ignore[method-assign]
        cls.__hash__ = Value.__hash__  # type: ignore[method-assign]
        if "__repr__" not in vars(cls):
            cls.__repr__ = _brief  # type: ignore[method-assign]

    def __post_init__(self) -> None:
        self.store(**self.__dict__)

    def store(self, **values: Any) -> None:
        """Set fields in ``__post_init__``; arrays and dictionaries as copies that do not change."""
        for name, value in values.items():
            self.__dict__[name] = frozen(value)  # past the lock of a frozen dataclass

    def __eq__(self, other: object) -> bool:
        same = type(self) is type(other)
        return bool(_contents(self) == _contents(other)) if same else NotImplemented

    def __hash__(self) -> int:
        return hash(_contents(self))

    def __getstate__(self) -> dict[str, Any]:
        kept = vars(self).items()
        return {n: v for n, v in kept if not isinstance(getattr(type(self), n, 0), cached_property)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.store(**state)  # NumPy restores every array as a writable one

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write this to a netCDF-4 file, whole or not at all; :func:`kinetics.load` reads it back.

        InputError where the file cannot be written, and for what it cannot hold: a Python function,
        or a class that is not of this package.
        """
        record = json.dumps({"format": _FORMAT, "value": _plain(self, True)})
        made = self._dataset(only=())
        made[_RECORD] = "byte", np.frombuffer(record.encode(), np.uint8)
        write_whole({path: _netcdf(made)})

    def _dataset(self, only: Collection[str] | None = None, **points: Any) -> xarray.Dataset:
        return dataset(self, type(self).__name__, self, {}, {})

    def _to_storage(self) -> dict[str, Any]:
        return {f.name: getattr(self, f.name) for f in fields(self) if f.init}  # type: ignore[arg-type]

    @classmethod
    def _from_storage(cls, parts: dict[str, Any]) -> Self:
        """The value, of the parts that `_to_storage` gave; lists are tuples there."""
        return cls(**parts)


class Result(Value):
    """A value that becomes an `xarray.Dataset`, a data frame or a plot where one asks for it.

    A subclass writes ``_dataset(only, **points)`` with :func:`dataset`: all of it, or what ``only``
    names, and always what depends on the first coordinate alone, and single numbers. ``_on_demand``
    are names that it may leave out, ``_points`` the points that may be given.
    """

    _points: tuple[str, ...] = ()
    _on_demand: tuple[str, ...] = ()

    def to_xarray(self, **points: Any) -> xarray.Dataset:
        """An xarray Dataset of everything, whose attributes say units, status and accuracy.

        ``points`` are where functions are evaluated: for a Solution speeds, angles, radii,
        scaled_radii, wave_numbers and direction. Complex quantities are split into ``_real`` and
        ``_imag``, so that ``to_netcdf`` takes them. InputError for other points.
        """
        return self._made(None, points)

    def to_dataframe(self, name: str | None = None, **points: Any) -> pandas.DataFrame:
        """A pandas DataFrame: one row for each time (or other first coordinate) with all averages.

        With the ``name`` of a quantity that depends on more, such as "speed_density": one row for
        each point. Units, and the attributes of the result, are in ``frame.attrs``. ``points``: as
        of :meth:`to_xarray`. InputError for an unknown name.
        """
        import xarray

        if name is not None:
            arrays, about = self._named(name, points), {}
        else:
            made = self._made((), points)
            about, first = made.attrs, list(made.coords)[:1]
            arrays = [made[n] for n in made if first and _axes(made[n]) == first]
            # where nothing depends on the first coordinate alone there is one row of numbers
            arrays = arrays or [made[n].expand_dims("row") for n in made if not made[n].dims]
        columns = {label: part for one in arrays for label, part in _components(one).items()}
        frame = xarray.Dataset(columns).to_dataframe().reset_index()
        frame = frame.drop(columns="row", errors="ignore")
        units = {n: (columns[n] if n in columns else arrays[0][n]).attrs["units"] for n in frame}
        frame.attrs = {**about, "units": units}
        return frame

    def plot(self, name: str | None = None, ax: Axes | None = None, **points: Any) -> Any:
        """Draw one quantity by its name, on ``ax`` or on new axes; returns the matplotlib axes.

        Averages are drawn over time, densities at up to eight of the times; without a name
        everything is drawn. ``points``: as of :meth:`to_xarray`. InputError for an unknown name.
        """
        if name is not None:
            return _draw(name, self._named(name, points), ax)
        if ax is not None:
            raise InputError("ax: got axes without a name; name what to draw on them")
        return self.plot_all(**points)

    def plot_all(self, **points: Any) -> NDArray[Any]:
        """Draw each quantity in axes of its own in one new figure; returns an array of axes."""
        from matplotlib import pyplot

        groups: dict[str, list[xarray.DataArray]] = {}
        for one in self._made(None, points).data_vars.values():
            if 1 <= len(_axes(one)) <= 2 and one.values.any():  # not what is zero
                base = str(one.name).removesuffix("_real").removesuffix("_imag")
                groups.setdefault(base, []).append(one)
        columns = min(3, len(groups))
        rows = math.ceil(len(groups) / columns)
        figure = pyplot.figure(figsize=(4.2 * columns, 3.2 * rows), layout="constrained")
        for k, (name, parts) in enumerate(groups.items()):
            _draw(name, parts, figure.add_subplot(rows, columns, k + 1))
        return np.array(figure.axes)

    def _made(self, only: Collection[str] | None, points: Mapping[str, Any]) -> xarray.Dataset:
        for name in points:
            if name not in self._points:
                raise InputError(f"{name}: known are {', '.join(('name', 'ax', *self._points))}")
        return self._dataset(only=only, **points)

    def _named(self, name: str, points: Mapping[str, Any]) -> list[xarray.DataArray]:
        """The quantity of this name, as its real and imaginary part if it is complex."""
        made = self._made((name,), points)
        found = [made[n] for n in made if n in (name, f"{name}_real", f"{name}_imag")]
        if not found:
            known = ", ".join(dict.fromkeys([*map(str, made), *self._on_demand]))
            raise InputError(f"name: got {short(name)}; this result has {known}")
        return found


def variable(
    dims: tuple[str, ...], values: ArrayLike, units: str, long_name: str, symbol: str = ""
) -> tuple[Any, ...]:
    """One variable of a dataset: a copy of its values, and what they are."""
    described = {"units": units, "long_name": long_name} | ({"symbol": symbol} if symbol else {})
    return dims, np.array(values), described


def dataset(
    of: Any, title: str, question: Any, variables: Mapping[str, Any],
    coordinates: Mapping[str, Any], **attributes: Any,
) -> xarray.Dataset:  # fmt: skip
    """The Dataset of a result, from what :func:`variable` made; unused coordinates are left out.

    question : what was asked; it is the attribute `scene`, as JSON
    attributes : more of them; a solver's result has those of its status and its error as well
    """
    import xarray

    if hasattr(of, "status"):
        attributes |= {"status": of.status.name.lower(), "message": of.message}
        attributes |= {"tolerance_asked": of.rtol, "tolerance_reached": of.error_estimate}

    used = {d for dims, _, _ in variables.values() for d in dims}
    axes = {name: made for name, made in coordinates.items() if name in used}
    version = sys.modules["kinetics"].__version__
    about = {"scene": json.dumps(_plain(question, False)), "version": version}
    return xarray.Dataset(variables, axes, {"title": title, **attributes, **about})


def _axes(one: xarray.DataArray) -> list[str]:
    """Names of the dimensions that are no components."""
    return [str(d) for d in one.dims if d not in COMPONENTS]


def _components(one: xarray.DataArray) -> dict[str, xarray.DataArray]:
    """A quantity itself, or each component of a vector or a tensor, under its name."""
    inner = [d for d in one.dims if d in COMPONENTS]
    if not inner:
        return {str(one.name): one}
    places = [dict(zip(inner, at, strict=True)) for at in product(*(one[d].values for d in inner))]
    return {f"{one.name}_{''.join(at.values())}": one.sel(at, drop=True) for at in places}


def _draw(name: str, parts: list[xarray.DataArray], ax: Axes | None) -> Axes:
    """Draw a quantity, or its real and imaginary part; wide ranges on logarithmic axes."""
    free = _axes(parts[0])
    if not 1 <= len(free) <= 2:
        raise InputError(f"name: got {name!r}; plot draws what depends on one or two of {free}")
    if ax is None:
        from matplotlib import pyplot

        _, ax = pyplot.subplots(layout="constrained")
    along = parts[0][free[-1]]
    for part, style in zip(parts, ("-", "--"), strict=False):
        ax.set_prop_cycle(None)  # imaginary parts are broken lines of the same colours
        for label, line in _lines(part).items():
            ax.plot(along, line, style, label=label)
    if len(ax.lines) > 1 or (len(free) == 2 and free[0] != "angle"):
        ax.legend()
    ax.set(xlabel=_label(along), ylabel=_label(parts[0]))
    x, y = along.values, parts[0].values
    if _is_wide(x[x > 0.0] if along.name == "time" else x):  # 0 is then left out
        ax.set_xscale("log")
    top = y.max(where=np.isfinite(y), initial=0.0)
    if name.endswith(("density", "vdf")) and top > 0.0:
        ax.set(yscale="log", ylim=(1e-7 * top, 3.0 * top))  # tails are of interest
    elif len(parts) == 1 and _is_wide(y):
        ax.set_yscale("log")
    return ax


def _lines(one: xarray.DataArray) -> dict[str, Any]:
    """Label -> line: the components of what depends on the time; of other things some times."""
    free = _axes(one)
    if len(free) == 1:
        return {name.replace("_", " "): line for name, line in _components(one).items()}
    at, about = one[free[0]].values, one[free[0]].attrs
    symbol, units = about.get("symbol", free[0]), about["units"].replace("1", "")
    shown = np.linspace(0, at.size - 1, 8).round().astype(int)
    return {f"{symbol} = {at[i]:.4g} {units}".strip(): one.values[i] for i in shown}


def _label(one: xarray.DataArray) -> str:
    """Symbol and unit, as the label of an axis, with brackets and powers as they are printed."""
    symbol, units = one.attrs.get("symbol", str(one.name)), one.attrs["units"]
    text = symbol.replace("_", " ") + ("" if units == "1" else f" [{units}]")
    return text.translate({60: "⟨", 62: "⟩"}).replace("^2", "²").replace("^3", "³")


def _is_wide(values: NDArray[Any]) -> bool:
    """Whether numbers are positive and span 1.5 decades: their axis is logarithmic then."""
    x = values[np.isfinite(values)]
    return bool(x.size > 1 and 0.0 < 30.0 * x.min() < x.max())


# -- files ----------------------------------------------------------------------------------------


def load(path: str | os.PathLike[str]) -> Any:
    """The value that a file holds, of the class that was saved; see :meth:`Value.save`.

    Raises InputError, one line: there is no such file, it is damaged, or kinetics did not save it.
    """
    import h5py

    name = short(str(path), 300)
    try:
        if not os.path.isfile(path):
            raise InputError("there is no such file")
        with h5py.File(path, "r") as file:
            if not isinstance(file.get(_RECORD, getlink=True), h5py.HardLink):
                raise ValueError("a link")
            record = file[_RECORD]
            # nothing of another file, and no more memory than is stored
            beyond = record.is_virtual or record.external
            if beyond or record.id.get_storage_size() < record.nbytes:
                raise ValueError("not stored here")
            found = json.loads(record[()].tobytes())
        if found["format"] != _FORMAT:
            raise InputError(f"this version reads {_FORMAT!r}, not {short(found['format'])}")
        return _restored(found["value"])
    except InputError as error:
        raise InputError(f"path: got {name}; {error}") from None
    except Exception as error:  # h5py raises errors of nearly any class
        what = "it is damaged, or no file that kinetics saved"
        raise InputError(f"path: got {name}; {what} ({type(error).__name__})") from None


def write_whole(contents: Mapping[Any, bytes]) -> None:
    """Write files, by their paths, all of them or none; InputError where one cannot be written.

    Each is written beside its target under a random name; when all are on the disk they get their
    own. Symbolic links are followed.
    """
    parts: dict[str, str] = {}
    path: Any = ""
    try:
        for path, content in contents.items():
            target = os.path.realpath(os.fsdecode(path))
            if os.path.exists(target) and not os.path.isfile(target):
                raise OSError("it is a folder, a device or a pipe, not a file")
            folder, base = os.path.split(target)
            beside = os.path.join(folder, f".{base}.{secrets.token_hex(8)}.part")
            parts[beside] = target
            with open(beside, "xb") as file:  # x: never through a symbolic link
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
        for beside, target in parts.items():
            os.replace(beside, target)
    except (OSError, TypeError, ValueError) as error:
        reason = f"it cannot be written ({getattr(error, 'strerror', None) or error})"
        raise InputError(f"path: got {short(str(path), 300)}; {reason}") from None
    finally:
        for beside in parts:
            with contextlib.suppress(OSError):
                os.unlink(beside)  # it is there only if something went wrong


def _netcdf(made: xarray.Dataset) -> bytes:
    """A dataset as netCDF-4, in memory: on a full disk HDF5 would end the process."""
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    checked = {n: one.size > 0 and one.ndim > 0 for n, one in made.variables.items()}
    numbers = [n for n, one in made.variables.items() if one.dtype.kind in "biuf"]
    encoding = {n: {"_FillValue": None, "fletcher32": checked[n]} for n in numbers}
    image = io.BytesIO()
    # From this version of the format on the structure of a file is checksummed as well.
    with h5netcdf.File(image, "w", libver=("v110", "v110")) as file:
        made.dump_to_store(H5NetCDFStore(file), encoding=encoding)
    return image.getvalue()


def _public(name: Any) -> Any:
    """The class of this name in `kinetics`, which loads it at first use; None for another name."""
    found = getattr(sys.modules["kinetics"], str(name), None)
    is_class = isinstance(found, type) and (is_dataclass(found) or issubclass(found, enum.Enum))
    return found if is_class else None


def _plain(value: Any, whole: bool) -> Any:
    """The value as JSON holds it. Not `whole`, for people: long arrays and functions are named."""
    if isinstance(value, np.ndarray) and whole:
        return {"array": value.tolist()}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist() if value.size <= 200 else f"numbers of shape {value.shape}"
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, list | tuple):
        return [_plain(item, whole) for item in value]
    if isinstance(value, Mapping):
        return {str(key): _plain(item, whole) for key, item in value.items()}
    cls = type(value)
    if whole and callable(value) and not isinstance(value, Value):
        hint = "a Python function cannot be saved in a file, give the density as a SpeedTable"
        raise InputError(f"initial: got {short(value)}; {hint}")
    if whole and _public(cls.__name__) is not cls:
        raise InputError(f"value: got {short(value)}; a {cls.__name__} cannot be saved in a file")
    if isinstance(value, enum.Enum):
        return {"class": cls.__name__, "name": value.name}
    if not is_dataclass(value) or isinstance(value, type):
        return str(getattr(value, "__qualname__", cls.__name__))
    parts = {f.name: getattr(value, f.name) for f in fields(value) if f.init}
    if whole and isinstance(value, Value):
        parts = value._to_storage()
    if parts.get("mass_ratio") == math.inf:  # JSON has no infinity, and it is the default
        del parts["mass_ratio"]
    return {"class": cls.__name__} | {name: _plain(part, whole) for name, part in parts.items()}


def _restored(plain: Any) -> Any:
    """What `_plain` was given."""
    if isinstance(plain, list):
        return tuple(_restored(item) for item in plain)
    if not isinstance(plain, dict):
        return plain
    if "array" in plain:
        return np.asarray(plain["array"])
    parts = {name: _restored(item) for name, item in plain.items()}
    if "class" not in parts:
        return parts
    cls = _public(name := parts.pop("class"))
    if cls is None:
        raise InputError(f"it holds a {short(name)}, which is not known here")
    if issubclass(cls, enum.Enum):
        return cls[parts["name"]]
    return cls._from_storage(parts) if issubclass(cls, Value) else cls(**parts)
