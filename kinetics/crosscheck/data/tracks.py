"""Anybody's particle data as one dense array: tracers at common times, whatever file they are from.

A format (`formats`) gives either columns, one row for each tracer at each time, which
`from_columns` turns into `Tracks`, or frames, which are Tracks already; or `Averages`.
"""

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.crosscheck.data.units import split_unit, stated
from kinetics.errors import InputError, short
from kinetics.validation import one_of, real_number, refuse

AXES, SPEEDS = ("x", "y", "z"), ("vx", "vy", "vz")
LABELS = ("tracer", "medium", "type")
"""Columns that may be there: whole numbers or texts."""
ALIASES = {
    "time": ("t", "times"),
    **{a: (f"{a}u", f"r_{a}", f"r{a}", f"pos_{a}", f"d{a}") for a in AXES},
    **{f"v{a}": (f"v_{a}", f"vel_{a}", f"velo_{a}") for a in AXES},
    "tracer": ("id", "particle", "atom", "tracer_id", "particle_id"),
    "medium": ("configuration", "config", "replica", "realisation", "realization", "sample"),
    "type": ("species", "element"),
}
"""Other names of columns, in lower case, which are looked for where the first is missing."""
AVERAGES = {
    "thermal_speed": ("v0", "v_0", "v0(t)"),
    "mean_square_speed": ("v2", "<v2>", "<v^2>", "msv"),
    "a2": ("a_2",),
    "msd": ("r2", "<r2>", "<r^2>", "mean_square_displacement"),
    "kurtosis": (),
}
"""Averages that a table of averages may have, and other names of them."""
_ERRORS = ("_error", "_err", "_se", "_sem", "_stderr", "_sigma")
"""Endings of the name of an average's standard error."""
MOST_TIMES = 400
"""Different times that data may have: bounds the memory of what is reduced."""
SAME_TIME = 1e-9
"""Relative difference below which two times are one: above the rounding of 12 digits."""


@dataclass(frozen=True)
class Asked:
    """What the user says about data.

    positions : "displacement": x, y are relative to the tracer's place at time 0. "absolute":
        they are places, from which the tracer's own place at time 0 is subtracted; needs a column
        `tracer` and rows at time 0. "auto": absolute if a position at time 0 is not the origin.
    speed_unit : U in the data's unit of speed; "data": from <v^2> at time 0, as a Gaussian has it
    diameter : d in the data's unit of length
    time_unit : d/U in the data's unit of time; None: diameter/speed_unit, in the units that the
        file states, if it does
    columns : names of columns in the files by ours, {"time": "t_sim"} or "time=t_sim"
    timestep : the time of one step, for formats whose frames give steps
    dimension : 2 or 3; None: that of an Ensemble, or 2
    bin_times : times that differ by less than this fraction are one time, at their mean
    with_field : whether the data were in a field, where speeds rise
    type : of the particles that are compared, where a file has several
    """

    positions: str = "auto"
    speed_unit: float | str = 1.0
    diameter: float = 1.0
    time_unit: float | None = None
    columns: Any = field(default_factory=dict)
    timestep: float | None = None
    dimension: int | None = None
    bin_times: float | None = None
    with_field: bool = False
    type: str | int | None = None

    def __post_init__(self) -> None:
        one_of("positions", self.positions, ("auto", "displacement", "absolute"))
        for name in ("speed_unit", "diameter", "time_unit", "timestep"):
            value = getattr(self, name)
            free = value is None and name in ("time_unit", "timestep")
            if not free and not (
                name == "speed_unit" and isinstance(value, str) and value == "data"
            ):
                # a unit enters as its square and its cube, which must be finite
                object.__setattr__(self, name, real_number(name, value, 1e-100, 1e100))
        if self.dimension not in (None, 2, 3):
            refuse("dimension", self.dimension, "it must be 2 or 3")
        if self.bin_times is not None:
            allowed = "it must be a number from 0 to 0.2, a fraction of the time"
            real_number("bin_times", self.bin_times, 0.0, 0.2, allowed)
        object.__setattr__(self, "columns", checked_columns(self.columns or {}))

    def times_of(self, where: str, time: Any, step: Any) -> Any:
        """The times of frames: as they stand, or their steps times the timestep."""
        if time is not None:
            return np.asarray(time, float)
        if step is None or self.timestep is None:
            what = "times" if step is None else "times, only steps; say --timestep"
            raise InputError(f"{where}: gives no {what}")
        return np.asarray(step, float) * self.timestep


def checked_columns(columns: Any) -> dict[str, str]:
    """Names of columns by ours, from a mapping or a text such as `time=t_sim,tracer=id`.

    InputError for another form, and for a name that is unknown or stands twice.
    """
    pairs: Any = columns.items() if isinstance(columns, Mapping) else None
    if isinstance(columns, str):
        parts = [part.partition("=") for part in columns.split(",") if part.strip()]
        pairs = [(ours.strip(), theirs.strip()) for ours, _, theirs in parts]
    if pairs is None or not all(str(theirs) for _, theirs in pairs):
        refuse("columns", columns, "it must be like time=t,tracer=id, or a dictionary of names")
    found: dict[str, str] = {}
    for name, theirs in pairs:
        plain = str(name).strip().lower()
        ours = next((one for one, others in ALIASES.items() if plain in (one, *others)), None)
        if ours is None or ours in found:
            why = "stands twice" if ours else "is not known"
            raise InputError(f"columns: {short(name)} {why}; allowed are {', '.join(ALIASES)}")
        found[ours] = str(theirs)
    return found


@dataclass(frozen=True)
class Tracks:
    """Tracers at common times; NaN where one is missing.

    times (T,) rising; place, velocity (T, n, d); tracer, medium (n,) whole numbers, None where
    unknown; box (d,) where positions may be wrapped; units that the file states, by "length",
    "speed" and "time"; own (T, n): the times of the rows themselves where times were binned; file:
    number of the file, or (n,).
    """

    times: Any
    place: Any
    velocity: Any
    tracer: Any = None
    medium: Any = None
    box: Any = None
    units: Mapping[str, str] = field(default_factory=dict)
    own: Any = None
    file: Any = 0


@dataclass(frozen=True)
class Averages:
    """A table of averages: "time", averages and, behind "error of ", their errors, (n,) each."""

    columns: Mapping[str, Any]
    units: Mapping[str, str]


@dataclass(frozen=True)
class Table:
    """Columns in memory that take the place of a file."""

    columns: Mapping[str, Any]
    name: str = "data"


def name_of(source: Path | Table) -> str:
    """A file's path, or the name of a table, on one line that can be written."""
    text = source.name if isinstance(source, Table) else str(source)
    text = " ".join(text.encode("utf-8", "replace").decode().split()) or "''"
    return text if len(text) <= 200 else f"{text[:90]}...{text[-100:]}"


def require_memory(where: str, declared: float, stored: float | None = None) -> None:
    """InputError for data of more bytes than the machine has free, or than a file can hold.

    declared: bytes of the arrays; three times as much is needed to work with them. stored: bytes in
    the file, where they are packed by deflate, which makes nothing smaller than by 1032.
    """
    if stored is not None and declared > 1100 * stored + 1e6:
        raise InputError(f"{where}: declares {declared:.2g} bytes, and holds {stored:.2g} of them")
    try:
        lines = Path("/proc/meminfo").read_text().split("\n")
        free = next(1024.0 * int(line.split()[1]) for line in lines if "MemAvailable" in line)
    except (OSError, StopIteration, ValueError):
        free = 16e9  # another system: what most machines have
    if 3 * declared > free:
        raise InputError(
            f"{where}: needs about {3 * declared / 1e9:.2g} GB of memory, {free / 1e9:.2g} GB are "
            "free; compare fewer times or tracers"
        )


# -- columns: one row for each tracer at each time -------------------------------------------------


def find_columns(where: str, names: Sequence[Any], asked: Asked) -> dict[str, int]:
    """The place of each known column; InputError where one is missing or stands twice."""
    plain = [str(name).strip().strip("\"'").strip().lower() for name in names]
    bare = [split_unit(name)[0] for name in plain]
    if averages := _find_averages(bare, asked):
        return averages
    d = 3 if asked.dimension == 3 else 2
    needed = ("time", *AXES[:d], *SPEEDS[:d], *(("type",) if asked.type is not None else ()))
    found: dict[str, int] = {}
    for ours, others in ALIASES.items():
        told = asked.columns.get(ours)
        if ours not in needed and told is None and ours in ("z", "type"):
            continue  # z alone does not matter in the plane; vz is read, to be refused
        wanted = [told.strip().lower()] if told is not None else [ours]
        if told is None and ours not in bare:
            wanted = [one for one in others if one in bare]
        known = plain if wanted and wanted[0] in plain else bare
        here = [k for k, one in enumerate(known) if one in wanted]
        if len(here) > 1:
            raise InputError(f"{where}: column {ours!r} stands {len(here)} times")
        if here and here[0] in found.values():
            other = next(one for one, k in found.items() if k == here[0])
            raise InputError(f"{where}: column {known[here[0]]!r} cannot be {other} and {ours}")
        if here:
            found[ours] = here[0]
        elif ours in needed or told is not None:
            near = difflib.get_close_matches(wanted[0] if wanted else ours, plain, 1, 0.5)
            hint = f"; is {short(near[0])} meant? Say so by --columns" if near else ""
            raise InputError(
                f"{where}: column {told or ours!r} is missing; needed are {', '.join(needed)}, "
                f"found are {short(', '.join(plain), 80)}{hint}"
            )
    return found


def _find_averages(bare: Sequence[str], asked: Asked) -> dict[str, int]:
    """The places of the columns of a table of averages; empty where it is none."""
    if any(name in bare or name in asked.columns for name in ("x", "vx", *ALIASES["x"])):
        return {}
    told = asked.columns.get("time", "").strip().lower()
    times = [k for k, one in enumerate(bare) if one in (told, "time", *ALIASES["time"])]
    found: dict[str, int] = {}
    for name, others in AVERAGES.items():
        for one in (name, *others):
            error = next((f"{one}{end}" for end in _ERRORS if f"{one}{end}" in bare), None)
            if one in bare and error is not None:
                found |= {name: bare.index(one), f"error of {name}": bare.index(error)}
    return {"time": times[0]} | found if found and times else {}


def from_columns(
    where: str, columns: Mapping[str, Any], asked: Asked, units: Mapping[str, str] | None = None
) -> Tracks | Averages:
    """Tracks, or averages, of columns by our names, (n,) each; units: of those that state one."""
    said = stated(where, units or {})
    values = {name: _column(where, name, np.asarray(column)) for name, column in columns.items()}
    sizes = {name: len(column) for name, column in values.items()}
    if len({*sizes.values()}) > 1:
        text = ", ".join(f"{name} {size}" for name, size in sizes.items())
        raise InputError(f"{where}: columns differ in length ({text})")
    checked = ("time", *AXES, *SPEEDS) if "x" in values else ("time",)
    for name in checked:  # averages may be NaN where they are not known
        if name in values and not np.all(good := np.isfinite(values[name])):
            k = int(np.argmin(good))
            raise InputError(
                f"{where}: row {k} has {name} = {values[name][k]}; every value must be finite"
            )
    if "x" not in values:
        return Averages(values, said)
    if asked.type is not None:
        kinds = np.array([f"{x:g}" if isinstance(x, float) else str(x) for x in columns["type"]])
        chosen = kinds == str(asked.type)
        values = {name: column[chosen] for name, column in values.items()}
        if not np.any(chosen):
            known = ", ".join(sorted({*kinds[:1000]})[:9]) or "none"
            raise InputError(f"{where}: type: got {short(asked.type)}; there are {known}")
    if not values["time"].size:
        raise InputError(f"{where}: has no rows; at least two tracers are needed")
    d = asked.dimension or 2
    if d == 2 and np.any(values.get("vz", 0.0)):
        raise InputError(f"{where}: velocities have a z component; say dimension 3")
    return _dense(where, values, said, asked, d)


def _column(where: str, name: str, values: Any) -> Any:
    """Numbers as floats, labels as whole numbers."""
    if values.ndim != 1:
        raise InputError(f"{where}: column {name!r} has shape {values.shape}; it must be (n,)")
    if values.dtype.kind not in "iuf" or values.dtype.itemsize > 8:
        if name not in LABELS or values.dtype.kind not in "OUST":
            raise InputError(f"{where}: column {name!r} is of type {values.dtype}, not of numbers")
        return np.unique(values.astype(str), return_inverse=True)[1]
    if name not in LABELS:
        return values.astype(float, copy=False)
    whole = values.dtype.kind != "f" or (np.abs(values) < 2.0**63) & (values == np.rint(values))
    if not np.all(whole):
        raise InputError(f"{where}: {name!r} must be whole numbers below 2^63, without NaN")
    with np.errstate(over="ignore"):
        return values.astype(np.int64, copy=False)


def _dense(
    where: str, c: Mapping[str, Any], units: Mapping[str, str], asked: Asked, d: int
) -> Tracks:
    index, times = _binned(where, c["time"], max(SAME_TIME, asked.bin_times or 0.0))
    labels = {name: c[name] for name in ("tracer", "medium") if name in c}
    if "tracer" not in labels:  # the k-th row of each time is taken for the same tracer
        labels["rank"] = _rank(_number([index, *labels.values()]))
    every, frame = list(labels.values()), index.size // times.size
    frames = index.size == frame * times.size and all(
        np.array_equal(column, np.tile(column[:frame], times.size)) for column in every
    )
    number = np.tile(_number([c[:frame] for c in every]), times.size) if frames else _number(every)
    n = int(number.max()) + 1
    require_memory(where, 16.0 * d * n * times.size)
    cell = index * n + number
    filled = np.bincount(cell, minlength=n * times.size)
    if filled.max() > 1:
        k = int(np.argmax(filled[cell] > 1))
        who = " of ".join(f"{name} {values[k]}" for name, values in labels.items())
        raise InputError(f"{where}: {who} has more than one row at time {c['time'][k]:g}")

    def spread_out(names: Sequence[str]) -> Any:
        out = np.full((times.size * n, len(names)), np.nan)
        for k, name in enumerate(names):
            out[cell, k] = c[name]
        return out.reshape(times.size, n, len(names))

    first = np.empty(n, np.int64)
    first[number[::-1]] = np.arange(number.size)[::-1]
    one = {name: c[name][first] if name in c else None for name in ("tracer", "medium")}
    own = spread_out(["time"])[..., 0] if asked.bin_times else None
    return Tracks(
        times, spread_out(AXES[:d]), spread_out(SPEEDS[:d]), one["tracer"], one["medium"], None,
        units, own,
    )  # fmt: skip


def _number(columns: Sequence[Any]) -> Any:
    """One whole number from 0 on for each row, (n,), the same where all columns are the same."""
    keys, size = np.zeros(len(columns[0]), np.int64), 1
    for column in columns:
        low, high = int(column.min()), int(column.max())
        if high - low < 4 * column.size + 1000:  # labels that are counted need no sorting
            codes, span = column - low, high - low + 1
        else:
            codes = np.unique(column, return_inverse=True)[1]
            span = int(codes.max()) + 1
        if size * span > 16 * column.size + 1000:
            keys = np.unique(keys * span + codes, return_inverse=True)[1]
            size = int(keys.max()) + 1
        else:
            keys, size = keys * span + codes, size * span
    there = np.bincount(keys, minlength=size) > 0
    return keys if np.all(there) else (np.cumsum(there) - 1)[keys]


def _rank(keys: Any) -> Any:
    """The number of each row among those with the same key."""
    order = np.argsort(keys, kind="stable")
    counts = np.bincount(keys)
    out = np.empty(keys.size, np.int64)
    out[order] = np.arange(keys.size) - np.repeat(np.cumsum(counts) - counts, counts)
    return out


def _binned(where: str, time: Any, within: float) -> tuple[Any, Any]:
    """The index of each row's time among the different ones, and these."""
    if time.min() < 0:
        raise InputError(f"{where}: time: got {time.min():g}; times must not be negative")
    # rows that stand together at one time, as in most files, are looked at once
    starts = np.flatnonzero(np.concatenate([[True], time[1:] != time[:-1]]))
    different, found = np.unique(time[starts], return_inverse=True)
    firsts = [different[0]]
    while different[-1] - firsts[-1] > within * different[-1]:
        if len(firsts) == MOST_TIMES:
            raise InputError(
                f"{where}: time: more than {MOST_TIMES} different times; every tracer must be "
                "given at the same few times, or say --bin-times"
            )
        # the first that is not so near: t - first > within * t rises with t
        firsts.append(different[np.argmax(different - firsts[-1] > within * different)])
    times = np.array(firsts)
    nearest = np.searchsorted(times[:-1] / 2 + times[1:] / 2, different)
    at = np.repeat(nearest[found], np.diff(np.concatenate([starts, [time.size]])))
    return at, times if within <= SAME_TIME else np.bincount(at, time) / np.bincount(at)


# -- frames ----------------------------------------------------------------------------------------


def checked(where: str, found: Tracks, asked: Asked) -> Tracks:
    """Tracks whose shapes and values can be used, by rising time; else InputError."""
    d, shape, speeds = asked.dimension or 2, np.shape(found.place), np.shape(found.velocity)
    if len(shape) != 3 or speeds[:2] != shape[:2] or np.shape(found.times) != shape[:1]:
        raise InputError(
            f"{where}: times, positions and velocities have shapes {np.shape(found.times)}, "
            f"{shape}, {speeds}; they must be (n_times,) and twice (n_times, n_tracers, 2 or 3)"
        )
    if shape[0] > MOST_TIMES:
        raise InputError(f"{where}: time: more than {MOST_TIMES} different times")
    labels = [x for x in (found.tracer, found.medium) if x is not None]
    if any(np.shape(label) != shape[1:2] for label in labels):
        raise InputError(f"{where}: needs one label for each of {shape[1]} tracers")
    if min(shape[2], speeds[2]) < d:
        raise InputError(f"{where}: has no z components; dimension 3 needs them")
    if np.any(np.nan_to_num(found.velocity[..., d:])):
        raise InputError(f"{where}: velocities have a z component; say dimension 3")
    times = np.asarray(found.times, float)
    if not np.all(np.isfinite(times)) or np.any(times < 0):
        raise InputError(f"{where}: times must be finite numbers, not negative")
    order = np.argsort(times, kind="stable")
    times = times[order]
    if np.any(np.diff(times) <= SAME_TIME * times[1:]):
        raise InputError(f"{where}: has more than one frame at one time")
    place, velocity = (np.asarray(a[..., :d], float) for a in (found.place, found.velocity))
    if not np.all(order == np.arange(order.size)):
        place, velocity = place[order], velocity[order]
    bad = ~np.isfinite(place).all(axis=2) | ~np.isfinite(velocity).all(axis=2)
    if np.any(bad):  # a tracer without any number has ended
        gone = np.isnan(place).all(axis=2) & np.isnan(velocity).all(axis=2)
        if np.any(bad & ~gone):
            k, i = np.argwhere(bad & ~gone)[0]
            raise InputError(
                f"{where}: tracer {i} at time {times[k]:g} has {place[k, i]} and {velocity[k, i]}; "
                "every value must be a finite number"
            )
    box = None if found.box is None else np.asarray(found.box, float)[:d]
    return replace(found, times=times, place=place, velocity=velocity, box=box)


def unwrapped(tracks: Tracks) -> tuple[Tracks, bool]:
    """Continuous positions of tracers in a periodic box, and whether any had been wrapped.

    Speeds never rise without a field, so that between two frames a tracer moves by |v| dt at most.
    Where that is less than half the box, its way is the shortest one; else nothing is changed.
    """
    if tracks.box is None or tracks.tracer is None:
        return tracks, False
    place, out, crossed = tracks.place, np.empty_like(tracks.place), False
    added, last = np.zeros(place.shape[1:]), place[0].copy()
    speed, time = np.zeros((2, len(added)))
    for k, at in enumerate(tracks.times):
        there = np.isfinite(place[k, :, 0])
        now = np.full(len(added), at) if tracks.own is None else tracks.own[k]
        known = there & np.isfinite(last[:, 0])
        elapsed = (now - time)[known]
        if np.any(elapsed < 0) or np.any(speed[known] * elapsed >= tracks.box.min() / 2):
            return tracks, False
        edges = np.where(known[:, None], np.round((last - place[k]) / tracks.box), 0.0)
        crossed = crossed or bool(np.any(edges))
        added += edges * tracks.box
        out[k] = place[k] + added
        last[there], time[there] = place[k, there], now[there]
        speed[there] = np.linalg.norm(tracks.velocity[k, there], axis=1)
    return replace(tracks, place=out), crossed


def joined(parts: Sequence[Tracks], names: Sequence[str], within: float) -> Tracks:
    """The tracers of several files side by side, at the times of any of them."""
    first = parts[0]
    if len(parts) == 1:
        return first
    for name in ("tracer", "medium"):
        if len({getattr(part, name) is None for part in parts}) > 1:
            raise InputError(f"{names[-1]}: column {name} must be in all files or in none")
    if any(dict(part.units) != dict(first.units) for part in parts):
        raise InputError(f"{names[-1]}: states other units than what was read before")
    every = np.concatenate([part.times for part in parts])
    index, times = _binned(names[0], every, max(SAME_TIME, within))
    rows = np.split(index, np.cumsum([part.times.size for part in parts])[:-1])
    if any(np.unique(at).size < at.size for at in rows):
        raise InputError("bin_times: times of the files do not fall together; give another")

    def side_by_side(name: str) -> Any:
        whole = []
        for part, at in zip(parts, rows, strict=True):
            values = getattr(part, name)
            out = np.full((times.size, *values.shape[1:]), np.nan)
            out[at] = values
            whole.append(out)
        return np.concatenate(whole, axis=1)

    def labels(name: str) -> Any:
        every = [getattr(part, name) for part in parts]
        return None if every[0] is None else np.concatenate(every)

    file = np.repeat(np.arange(len(parts)), [part.place.shape[1] for part in parts])
    return Tracks(
        times, side_by_side("place"), side_by_side("velocity"), labels("tracer"), labels("medium"),
        None, first.units, None if first.own is None else side_by_side("own"), file,
    )  # fmt: skip
