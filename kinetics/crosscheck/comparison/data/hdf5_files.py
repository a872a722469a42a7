"""HDF5: datasets `time`, `x`, ... of shape (n,) in the root of the file, or H5MD.

H5MD has positions and velocities (n_times, n_tracers, 2 or 3) with their times; de Buyl, Colberg
and Hoefling, Comput. Phys. Commun. 185, 1546 (2014); the layout is at nongnu.org.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from kinetics.crosscheck.comparison.data.arrays import FRAMES, read_frames, read_pieces
from kinetics.crosscheck.comparison.data.columns import (
    Asked,
    Averages,
    Rows,
    find_columns,
    shown,
    stated_units,
)
from kinetics.crosscheck.comparison.data.frames import PIECE, rows_of
from kinetics.errors import InputError


def read(path: Path, asked: Asked) -> Iterator[Rows | Averages]:
    """The rows of an HDF5 file; data that lie in other files are not followed."""
    with h5py.File(path, "r") as file:
        if all(_is_own(file, name, h5py.Group) for name in ("h5md", "particles")):
            yield from _read_h5md(path, file, asked)
            return
        names = [name for name in file if _is_own_array(file, name)]
        if set(FRAMES) <= set(names):
            yield from read_frames(path, {name: file[name] for name in FRAMES})
            return
        found = find_columns(path, names, asked)
        columns = {name: file[names[place]] for name, place in found.items()}
        units = {name: _unit_of(column) for name, column in columns.items()}
        yield from read_pieces(path, columns, units)


def _read_h5md(path: Path, file: Any, asked: Asked) -> Iterator[Rows]:
    """The rows of the only group of particles with positions and velocities.

    Times stand as a dataset (n_times,), or as a step between frames with an offset. Positions are
    unwrapped by the element `image` where it stands. An element `medium` (n_tracers,), which this
    package writes, says the configuration of each tracer.
    """
    where, particles = shown(path), file["particles"]
    names = [name for name in particles if _is_own(particles, name, h5py.Group)]
    groups = [
        name for name in names
        if all(_is_own(particles[name], part, h5py.Group) for part in ("position", "velocity"))
    ]  # fmt: skip
    if len(groups) != 1:
        found = ", ".join(groups) or "none"
        raise InputError(
            f"{where}: needs one group of particles with position and velocity; found are {found}"
        )
    group = particles[groups[0]]
    position, velocity = (_value(where, group, name) for name in ("position", "velocity"))
    if position.shape[:2] != velocity.shape[:2]:
        raise InputError(f"{where}: position and velocity differ in shape")
    times = _times(where, group["position"], position.shape[0], asked)
    if not np.array_equal(times, _times(where, group["velocity"], position.shape[0], asked)):
        raise InputError(f"{where}: position and velocity are given at different times")
    units = _units(where, group)
    image = _value(where, group, "image") if _is_own(group, "image", h5py.Group) else None
    edges = _edges(where, group) if image is not None else _periodic_edges(where, group)
    medium = _dataset(where, group, "medium") if "medium" in group else None
    for k, time in enumerate(times.tolist()):
        for start in range(0, position.shape[1], PIECE):
            part = slice(start, min(start + PIECE, position.shape[1]))
            x = np.asarray(position[k, part], float)
            if image is not None:
                x = x + np.asarray(image[k, part], float) * edges
            label = (
                np.arange(part.start, part.stop)
                if "id" not in group
                else _ids(where, group, k, part)
            )
            speed, group_of = np.asarray(velocity[k, part], float), None
            if medium is not None:
                group_of = np.asarray(medium[part])
            rows = rows_of(where, time, x, speed, label, group_of)
            box = None if image is not None or edges is None else tuple(edges.tolist())
            yield replace(rows, units=units, box=box)


def _unit_of(dataset: Any) -> str:
    """The attribute `unit` of a dataset, empty where it has none."""
    unit = dataset.attrs.get("unit", dataset.attrs.get("units", ""))
    return unit.decode("utf-8", "replace") if isinstance(unit, bytes) else str(unit)


def _units(where: str, group: Any) -> dict[str, str]:
    """The units that the file states, by kind; see `Rows`."""
    elements = {"x": group["position"]["value"], "vx": group["velocity"]["value"]}
    if "time" in group["position"]:
        elements["time"] = group["position"]["time"]
    return stated_units(where, {name: _unit_of(one) for name, one in elements.items()})


def _periodic_edges(where: str, group: Any) -> Any:
    """The lengths of a box that says that it is periodic; None for another, which is not needed."""
    if not _is_own(group, "box", h5py.Group):
        return None
    boundary = np.asarray(group["box"].attrs.get("boundary", ())).astype(str).ravel()
    if boundary.size < 2 or np.any(boundary != "periodic"):
        return None
    try:
        return _edges(where, group)
    except InputError:
        return None


def _is_own(parent: Any, name: str, kind: type) -> bool:
    """Whether a group has this member in its own file; links into other files are not followed."""
    return isinstance(parent.get(name, getlink=True), h5py.HardLink) and isinstance(
        parent[name], kind
    )


def _is_own_array(parent: Any, name: str) -> bool:
    """Whether a group has this dataset, with all of its data, in its own file."""
    if not _is_own(parent, name, h5py.Dataset):
        return False
    return not parent[name].is_virtual and not parent[name].external


def _dataset(where: str, parent: Any, name: str) -> Any:
    """A dataset of numbers in this file; InputError for anything else."""
    if _is_own_array(parent, name):
        found = parent[name]
        if found.dtype.kind in "iuf" and found.shape is not None:
            return found
    raise InputError(f"{where}: {parent.name}/{name} must be numbers in this file")


def _value(where: str, group: Any, name: str) -> Any:
    found = _dataset(where, group[name], "value")
    if found.ndim != 3 or found.shape[2] not in (2, 3):
        raise InputError(f"{where}: {found.name} has shape {found.shape}; it must be (T, n, 2)")
    return found


def _times(where: str, element: Any, count: int, asked: Asked) -> Any:
    """The times of an element, (count,): as they stand, or steps times --timestep."""
    if "time" in element:
        return _sequence(where, element, "time", count)
    if asked.timestep is None:
        raise InputError(f"{where}: {element.name} has no time; say --timestep")
    return _sequence(where, element, "step", count) * asked.timestep


def _sequence(where: str, element: Any, name: str, count: int) -> Any:
    found = _dataset(where, element, name)
    if found.ndim == 0:  # a fixed step, from an offset on
        offset = float(np.asarray(found.attrs.get("offset", 0.0), float))
        values = offset + np.arange(count) * float(found[()])
    else:
        values = np.asarray(found[()], float)
    if values.shape != (count,) or not np.all(np.isfinite(values)):
        raise InputError(f"{where}: {found.name} must be {count} finite numbers")
    return values


def _edges(where: str, group: Any) -> Any:
    """The lengths of the box, (2,) or (3,)."""
    if not _is_own(group, "box", h5py.Group):
        raise InputError(f"{where}: {group.name} has image flags and no box")
    box = group["box"]
    inner = _is_own(box, "edges", h5py.Group)
    edges = _dataset(where, *((box["edges"], "value") if inner else (box, "edges")))[()]
    if edges.ndim > 1 and np.all(edges == edges[0]):
        edges = edges[0]  # at each time the same
    if edges.ndim != 1:
        raise InputError(f"{where}: the box must be rectangular and always the same")
    return edges.astype(float)


def _ids(where: str, group: Any, frame: int, part: slice) -> Any:
    """Labels (n,) of a part of a frame: an element in time, or fixed."""
    if _is_own(group, "id", h5py.Group):
        return _dataset(where, group["id"], "value")[frame, part]
    return _dataset(where, group, "id")[part]
