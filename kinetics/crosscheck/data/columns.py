"""Columns of tables: the names that programs give them, and their units.

Our names are time, frame, x, y, z, vx, vy, vz, tracer, medium and type. `KNOWN_NAMES` has what
other programs call them; a user may add names (`--columns`).
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass
from typing import NoReturn

from kinetics.errors import InputError, short, suggestion

#: Columns of places.
AXES = ("x", "y", "z")
#: Columns of the components of velocities.
SPEEDS = ("vx", "vy", "vz")
#: Columns of labels, whose values may be numbers or texts.
LABELS = ("tracer", "medium", "type")
#: Our name -> other names, in lower case; the first that is there is taken. TrackMate has
#: POSITION_X, POSITION_T, FRAME and TRACK_ID (its ID is of a row), trackpy frame and particle,
#: LAMMPS xu and id.
KNOWN_NAMES: dict[str, tuple[str, ...]] = {
    "time": ("t", "times", "position_t", "time_s"),
    "frame": ("frames", "frame_number", "slice", "step", "timestep"),
    "x": ("xu", "position_x", "pos_x", "r_x", "rx", "dx"),
    "y": ("yu", "position_y", "pos_y", "r_y", "ry", "dy"),
    "z": ("zu", "position_z", "pos_z", "r_z", "rz", "dz"),
    "vx": ("v_x", "vel_x", "velo_x", "velocity_x"),
    "vy": ("v_y", "vel_y", "velo_y", "velocity_y"),
    "vz": ("v_z", "vel_z", "velo_z", "velocity_z"),
    "tracer": (
        *("track_id", "trackid", "track", "trajectory", "particle_id", "particle", "tracer_id"),
        *("id", "atom"),
    ),
    "medium": ("configuration", "config", "replica", "realisation", "realization", "sample"),
    "type": ("species", "element"),
}
#: The unit behind the name of a column: "t [s]", "x (mm)".
_UNIT = re.compile(r"\s*[\[(]\s*([^\])]*?)\s*[\])]\s*$")


def present(names: Iterable[str], columns: Container[str]) -> list[str]:
    """Return those of some names that columns have."""
    return [name for name in names if name in columns]


def columns_by_our_names(columns: object) -> dict[str, str]:
    """Return names of columns by ours, from a mapping or a text such as `time=t_sim,tracer=id`.

    InputError for a name that is none of ours, or that is given twice.
    """
    our_name_of: dict[str, str] = {}
    for ours, others in KNOWN_NAMES.items():
        our_name_of |= dict.fromkeys((ours, *others), ours)
    columns_of: dict[str, str] = {}
    for name, theirs in _pairs_of_names(columns):
        our_name = our_name_of.get(str(name).strip().lower())
        if our_name is None or our_name in columns_of:
            twice = " twice" if our_name else ""
            allowed = f"each once, of {', '.join(KNOWN_NAMES)}"
            raise InputError(f"columns: got {short(name)}{twice}; must be {allowed}")
        columns_of[our_name] = str(theirs).strip().lower()
    return columns_of


def _pairs_of_names(columns: object) -> list[tuple[object, object]]:
    """Return pairs of our name and theirs, as a user gives them; InputError for anything else."""
    if columns is None:
        return []
    if isinstance(columns, Mapping):
        return list(columns.items())
    if not isinstance(columns, str):
        _refuse_pairs(columns)
    pairs: list[tuple[object, object]] = []
    for text in columns.split(","):
        ours, sign, theirs = text.partition("=")
        if sign:
            pairs.append((ours, theirs))
        elif text.strip():
            _refuse_pairs(columns)
    return pairs


def _refuse_pairs(columns: object) -> NoReturn:
    """Raise InputError for names of columns that are no pairs."""
    allowed = "like time=t,tracer=id, or a dictionary of names"
    raise InputError(f"columns: got {short(columns)}; must be {allowed}")


@dataclass(frozen=True)
class ColumnName:
    """The name of a column as a file has it, and what it says.

    Parameters
    ----------
    original : as it is in the file; a mapping of a user may have a key that is no text
    plain : in lower case, without quotes
    bare : without its unit
    unit : "" where none is said
    """

    original: str
    plain: str
    bare: str
    unit: str

    @classmethod
    def of(cls, original: str) -> ColumnName:
        """Take the name of a column apart."""
        plain = str(original).strip(" \t\"'\ufeff").lower()
        unit = _UNIT.search(plain)
        if unit is None:
            return cls(original, plain, plain, "")
        return cls(original, plain, plain[: unit.start()].strip(), unit.group(1))

    def is_called(self, name: str) -> bool:
        """Return whether this is the column of a name, with or without its unit."""
        return name in (self.plain, self.bare)


def find_columns(
    where: str, names: Iterable[str], chosen: Mapping[str, str], needed: Iterable[str]
) -> dict[str, ColumnName]:
    """Return the columns by our names; InputError where a needed one is missing or is there twice.

    Parameters
    ----------
    where : names the source in messages
    names : of the columns, as the source has them
    chosen : names that the user gave, by ours
    needed : our names of those that must be there
    """
    columns = [ColumnName.of(name) for name in names]
    found: dict[str, ColumnName] = {}
    for our_name, other_names in KNOWN_NAMES.items():
        candidates = (our_name, *other_names)
        if our_name in chosen:
            candidates = (chosen[our_name],)
        column = _first_of(where, columns, candidates)
        if column is not None:
            _check_not_taken(where, column, found)
            found[our_name] = column
        elif our_name in chosen or our_name in needed:
            raise InputError(_missing(where, chosen.get(our_name, our_name), columns, needed))
    return found


def _first_of(
    where: str, columns: list[ColumnName], candidates: Iterable[str]
) -> ColumnName | None:
    """Return the column with the first of some names that is there; InputError for two of them."""
    for candidate in candidates:
        matching = [column for column in columns if column.is_called(candidate)]
        if len(matching) > 1:
            times = len(matching)
            raise InputError(
                f"{where}: got column {candidate!r} {times} times; must be one column for each"
            )
        if matching:
            return matching[0]
    return None


def _check_not_taken(where: str, column: ColumnName, found: Mapping[str, ColumnName]) -> None:
    """Raise InputError for a column that is another of ours already."""
    if column in found.values():
        raise InputError(
            f"{where}: got column {column.plain!r} for two; must be one column for each"
        )


def _missing(where: str, name: str, columns: list[ColumnName], needed: Iterable[str]) -> str:
    """Return the message of a column that is missing."""
    present = short(", ".join(column.plain for column in columns), 80)
    near = suggestion(name, [column.plain for column in columns])
    allowed = f"must be {', '.join(needed)} (--columns){near}"
    return f"{where}: got no column {name!r} in {present}; {allowed}"
