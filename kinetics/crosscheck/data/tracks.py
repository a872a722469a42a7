"""Anybody's particle data as one dense array: tracers at common times, whatever file they are from.

A format (`formats`) gives `Rows`, columns with one row for each tracer at each time, which are
checked here; `dense` makes `Tracks` of those of all files.
"""

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pandas as pd

from kinetics.errors import InputError, short
from kinetics.validation import one_of, real_number, refuse

Rows = dict[str, Any]  # columns by our names, one row for each tracer at each time
AXES, SPEEDS = ("x", "y", "z"), ("vx", "vy", "vz")
LABELS = ("tracer", "medium", "type")  # columns that may be there: numbers or texts
# other names of columns, in lower case, which are looked for where the first is missing
ALIASES = {
    "time": ("t", "times"),
    **{a: (f"{a}u", f"r_{a}", f"r{a}", f"pos_{a}", f"d{a}") for a in AXES},
    **{f"v{a}": (f"v_{a}", f"vel_{a}", f"velo_{a}") for a in AXES},
    "tracer": ("id", "particle", "atom", "tracer_id", "particle_id"),
    "medium": ("configuration", "config", "replica", "realisation", "realization", "sample"),
    "type": ("species", "element"),
}
MOST_TIMES = 400  # different times that data may have: bounds the memory of what is reduced
LARGEST = 1e70  # of times, speeds and displacements: fourth powers of these are doubles
_UNIT = re.compile(r"\s*\[\s*(.*?)\s*\]$|\s+\(.*\)$")  # behind the name of a column: "t [s]"


def bad(where: str, got: Any, must: str) -> NoReturn:
    """Raise InputError in one line: where, what was found there, and what must be."""
    raise InputError(f"{where}: got {got}; must be {must}")


@dataclass
class Asked:
    """What the user says about data, as `compare` has it; InputError for what is not allowed.

    with_axes : whether means along each axis matter, as in a field
    units : U, d and d/U in the data's units
    """

    positions: str = "auto"
    speed_unit: float = 1.0
    diameter: float = 1.0
    time_unit: float | None = None
    columns: Any = None
    timestep: float | None = None
    dimension: int | None = None
    with_axes: bool = False
    type: str | int | None = None
    units: dict[str, float] = field(init=False)

    def __post_init__(self) -> None:
        one_of("positions", self.positions, ("auto", "displacement", "absolute"))
        for name in ("speed_unit", "diameter", "time_unit", "timestep"):
            value = getattr(self, name)
            if value is not None or name in ("speed_unit", "diameter"):
                # a unit enters as its square and its cube, which must be finite
                setattr(self, name, real_number(name, value, 1e-100, 1e100))
        if self.dimension not in (None, 2, 3):
            refuse("dimension", self.dimension, "it must be 2 or 3")
        self.columns = _by_our_names(self.columns)
        time = self.diameter / self.speed_unit if self.time_unit is None else self.time_unit
        self.units = {"speed": self.speed_unit, "length": self.diameter, "time": time}

    def times_of(self, where: str, time: Any, step: Any) -> Any:
        """The times of frames: as they stand, or their steps times the timestep."""
        if time is not None:
            return np.asarray(time, float)
        if step is None or self.timestep is None:
            bad(where, "no times" if step is None else "only steps", "times, or say --timestep")
        return np.asarray(step, float) * self.timestep


def _by_our_names(columns: Any) -> dict[str, str]:
    """Names of columns by ours, from a mapping or a text such as `time=t_sim,tracer=id`."""
    pairs: Any = columns.items() if isinstance(columns, Mapping) else columns or ()
    if isinstance(columns, str):
        pairs = [part.split("=", 1) for part in columns.split(",") if part.strip()]
    if not isinstance(columns, Mapping | str | None) or any(len(pair) < 2 for pair in pairs):
        bad("columns", short(columns), "like time=t,tracer=id, or a dictionary of names")
    known = {other: ours for ours, others in ALIASES.items() for other in (ours, *others)}
    found: dict[str, str] = {}
    for name, theirs in pairs:
        ours = known.get(str(name).strip().lower())
        if ours is None or ours in found:
            twice = " twice" if ours else ""
            bad("columns", f"{short(name)}{twice}", f"each once, of {', '.join(ALIASES)}")
        found[ours] = str(theirs).strip().lower()
    return found


@dataclass(frozen=True)
class Tracks:
    """Tracers at common times; NaN where one is missing.

    times (T,) rising; place, velocity (T, n, d); tracer, medium (n,) labels, None where unknown;
    file (n,), its number.
    """

    times: Any
    place: Any
    velocity: Any
    tracer: Any = None
    medium: Any = None
    file: Any = 0


def name_of(source: Any) -> str:
    """A file's path on one line that can be written; "data" for columns in memory."""
    text = str(source) if isinstance(source, Path) else "data"
    return " ".join(text.encode("utf-8", "replace").decode().split())[-200:] or "''"


def require_memory(where: str, declared: float, stored: float | None = None) -> None:
    """InputError for arrays of more bytes than a sixth of the memory, or than `stored` hold."""
    # deflate makes nothing smaller than by 1032
    if stored is not None and declared > 1100 * stored + 1e6:
        bad(where, f"{stored:.2g} bytes that declare {declared:.2g}", "a whole file")
    # on another system: what most machines have
    total = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") if os.name == "posix" else 16e9
    if 6 * declared > total:
        bad(where, f"data of {declared:.2g} bytes", f"at most a sixth of the memory, {total:.2g}")


def without_mask(values: Any) -> Any:
    """Return values as an array in which what is masked or missing is NaN (None where texts).

    Masked arrays, alone or in lists, and the missing values of pandas' nullable types are missing
    values as NaN is. What has none keeps its type.
    """
    if _holds_masked(values) and isinstance(values, list | tuple):
        return np.array([without_mask(part) for part in values])
    if isinstance(values, pd.Series | pd.Index):
        values = values.array
    if isinstance(values, pd.api.extensions.ExtensionArray):
        return _of_nullable(values)
    if not np.ma.isMaskedArray(values):
        return np.asarray(values)
    mask = np.ma.getmaskarray(values)
    if not np.any(mask):
        return np.asarray(values.data)
    if values.dtype.kind in "iuf":
        return np.where(mask, np.nan, values.data)
    texts = values.data.astype(object)
    texts[mask] = None
    return texts


def _holds_masked(values: Any) -> bool:
    """Whether values are a masked array or a masked number, or a list that holds some."""
    if isinstance(values, list | tuple):
        return any(_holds_masked(part) for part in values)
    return np.ma.isMaskedArray(values)


def _of_nullable(values: Any) -> Any:
    """Return an array of pandas as one of numpy."""
    is_number = pd.api.types.is_numeric_dtype(values.dtype)
    if not is_number or pd.api.types.is_bool_dtype(values.dtype):
        return np.asarray(values)
    if np.any(values.isna()):
        return values.to_numpy(dtype=float, na_value=np.nan)
    return values.to_numpy(dtype=getattr(values.dtype, "numpy_dtype", None))


def find_columns(where: str, names: Iterable[Any], asked: Asked) -> dict[str, Any]:
    """The name of each known column by ours; InputError where one is missing or stands twice."""
    names = list(names)
    plain = [str(name).strip(" \t\"'").lower() for name in names]
    bare, d = [_UNIT.sub("", one) for one in plain], asked.dimension or 2
    needed = ("time", *AXES[:d], *SPEEDS[:d], *(("type",) if asked.type is not None else ()))
    found: dict[str, int] = {}
    for ours, others in ALIASES.items():
        told = asked.columns.get(ours)
        if ours not in needed and told is None and ours in ("z", "type"):
            continue  # z alone does not matter in the plane; vz is read, to be refused
        wanted = (told,) if told else (ours,) if ours in bare else others
        here = [k for k in range(len(names)) if plain[k] in wanted or bare[k] in wanted]
        if len(here) > 1 or {*here} & {*found.values()}:
            twice = "for two" if len(here) == 1 else f"{len(here)} times"
            bad(where, f"column {wanted[0]!r} {twice}", "one column for each")
        if not here and (ours in needed or told):
            there = short(", ".join(plain), 80)
            bad(where, f"no column {told or ours!r} in {there}", f"{', '.join(needed)} (--columns)")
        if here:
            found[ours] = here[0]
    return {ours: names[k] for ours, k in found.items()}


def rows_of(where: str, columns: Mapping[Any, Any], asked: Asked) -> Rows:
    """The rows of columns (n,) by the names of a file, checked; or InputError."""
    found = find_columns(where, columns, asked)
    c = {ours: without_mask(columns[name]) for ours, name in found.items()}
    if len(shapes := {one.shape for one in c.values()}) > 1 or c["time"].ndim != 1:
        bad(where, f"columns that differ in length or shape, {shapes}", "one length (n,)")
    if not c["time"].size:
        bad(where, "no rows", "two at least")
    for name, values in c.items():
        in_words = name in LABELS and values.dtype.kind in "OUST"
        if not in_words and (values.dtype.kind not in "iuf" or values.dtype.itemsize > 8):
            bad(f"{where}: column {name!r}", f"type {values.dtype}", "numbers")
        if values.dtype.kind == "O" and np.any(missing := pd.isna(values)):
            bad(f"{where}: row {int(np.argmax(missing))}", f"no {name}", "there, in every row")
        c[name] = values.astype(str) if in_words else values
        if name not in LABELS:
            c[name] = values.astype(float, copy=False)
        if values.dtype.kind == "f" and not np.all(good := np.isfinite(values)):
            k = int(np.argmin(good))
            who = f"row {k}" if "tracer" not in c else f"tracer {c['tracer'][k]}"
            who += f" at time {c['time'][k]:g}"
            bad(f"{where}: {who}", f"{name} = {values[k]}", "a finite number")
    if asked.type is not None:
        texts = c.pop("type").astype(str)
        chosen = texts == str(asked.type)
        if not np.any(chosen):
            bad(f"{where}: type", short(asked.type), f"one of {', '.join(np.unique(texts)[:9])}")
        c = {name: values[chosen] for name, values in c.items()}
    if asked.dimension != 3 and np.any(c.pop("vz", 0)):
        bad(where, "velocities with z components", "none, or say dimension 3")
    x, v, t = ("".join(_UNIT.findall(str(found[name]))) for name in ("x", "vx", "time"))
    parts = re.findall(r"[^\W\d]+", v)
    if x and t and len(parts) == 2 and parts != [x, t] and asked.time_unit is None:
        got = f"lengths in {x}, speeds in {v}, times in {t}"
        bad(where, got, "units that belong together, or say --time-unit")
    return c


def rows_of_frames(where: str, frames: Sequence[Mapping[str, Any]], asked: Asked) -> Rows:
    """The rows of frames, each with columns by our names."""
    if not frames:
        bad(where, "no frames", "a file of this format")
    names = [name for name in frames[0] if all(name in frame for frame in frames)]
    c = {name: np.concatenate([frame[name] for frame in frames]) for name in names}
    # tracers without any number have ended
    here = ~np.all([np.isnan(c[name]) for name in (*AXES, *SPEEDS) if name in c], axis=0)
    c = c if np.all(here) else {name: values[here] for name, values in c.items()}
    return rows_of(where, c, replace(asked, columns=None))


def rows_of_arrays(
    where: str, asked: Asked, times: Any, place: Any, velocity: Any, **labels: Any
) -> Rows:
    """The rows of times (T,), places and velocities (T, n, d), labels (n,) or (T, n).

    Without `tracer` the k-th of each frame is the same tracer.
    """
    times, place, velocity = (without_mask(one) for one in (times, place, velocity))
    shape = (*place.shape, 0, 0)[:2]
    labels = {"tracer": np.arange(shape[1])} | {k: without_mask(a) for k, a in labels.items()}
    shapes = [times.shape, place.shape, velocity.shape, *(a.shape for a in labels.values())]
    right = times.shape == shape[:1] and velocity.shape[:2] == shape
    right &= all(found in (shape, shape[1:]) for found in shapes[3:])
    if not right or place.ndim != 3 or velocity.ndim != 3:
        must = "(T,), (T, n, d), (T, n, d) and (n,) for each label"
        bad(f"{where}: shapes", ", ".join(map(str, shapes)), must)
    found = {"time": np.repeat(times, shape[1])}
    for names, vectors in ((AXES, place), (SPEEDS, velocity)):
        found |= dict(zip(names, vectors.reshape(-1, vectors.shape[2]).T, strict=False))
    found |= {k: np.broadcast_to(a, shape).ravel() for k, a in labels.items()}
    return rows_of_frames(where, [found], asked)


def dense(parts: Sequence[Rows], names: Sequence[str], asked: Asked) -> Tracks:
    """The tracers of all files side by side, at the times of any of them, in d, U and d/U."""
    where, first = ", ".join(names), parts[0]
    for name, part in zip(names, parts, strict=True):
        for label in {*LABELS} & (part.keys() ^ first.keys()):
            bad(name, f"another column {label} than before", "in all files or in none")
    c = first
    if len(parts) > 1:
        c = {name: np.concatenate([part[name] for part in parts]) for name in c}
    index, times = pd.factorize(c["time"], sort=True)
    if times[0] < 0:
        bad(f"{where}: time", f"{times[0]:g}", "not negative")
    # what differs less is the same time, rounded to 12 digits
    new = np.append(True, np.diff(times) > 1e-9 * times[1:])
    if (count := np.count_nonzero(new)) > MOST_TIMES:
        bad(where, f"{count} different times", f"at most {MOST_TIMES}, the same for every tracer")
    index, times = (np.cumsum(new) - 1)[index], times[new]
    keys = [name for name in ("tracer", "medium") if name in c]
    labels: dict[str, Any] = {name: c[name] for name in keys}
    if len(parts) > 1:
        sizes = [part["time"].size for part in parts]
        labels["file"] = np.repeat(np.arange(len(parts)), sizes)
    if "tracer" not in c:  # the k-th row of each time is taken for the same tracer
        rows = pd.DataFrame({"time": index, **labels})
        labels["rank"] = rows.groupby(list(rows)).cumcount().to_numpy()
    number = np.zeros(index.size, np.int64)
    for values in labels.values():
        code, known = pd.factorize(values, sort=True)
        number = number * known.size + code
    number = pd.factorize(number, sort=True)[0]
    n = int(number.max()) + 1
    require_memory(where, 32.0 * n * times.size)
    cell = index * n + number
    if (filled := np.bincount(cell)).max() > 1:
        k = int(np.argmax(filled[cell] > 1))
        who = " of ".join(f"{name} {c[name][k]}" for name in keys)
        bad(where, f"more than one row of {who} at time {c['time'][k]:g}", "one row for each time")

    one = np.empty(n, np.int64)
    one[number] = np.arange(number.size)  # a row of each tracer
    vectors, units = [], asked.units
    for axes, unit in ((AXES, units["length"]), (SPEEDS, units["speed"])):
        known = [c[name] for name in axes if name in c]
        out = np.full((times.size * n, len(known)), np.nan)
        out[cell] = np.stack(known, axis=-1) / unit
        vectors.append(out.reshape(times.size, n, -1))
    far, fast = (np.nanmax(np.abs(out), initial=0.0) for out in vectors)
    if max(far, fast) > LARGEST:
        got = f"speeds of {fast:.3g} U and displacements of {far:.3g} d"
        bad(where, got, f"below {LARGEST:g}; give --speed-unit and --diameter")
    of_each = {name: values[one] for name, values in labels.items() if name != "rank"}
    return Tracks(times / units["time"], *vectors, **of_each)
