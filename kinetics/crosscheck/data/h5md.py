"""H5MD (nongnu.org/h5md): the group of particles with positions, and velocities if it has some."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kinetics.crosscheck.data.arrays import Column, Floats
from kinetics.crosscheck.data.columns import AXES, SPEEDS
from kinetics.crosscheck.data.containers import (
    dataset_of,
    member_of,
    numbers_of,
    take_dataset,
)
from kinetics.crosscheck.data.frames import Box, Frame
from kinetics.crosscheck.data.memory import MemoryBudget
from kinetics.crosscheck.data.missing import without_mask
from kinetics.crosscheck.data.options import DataOptions, refuse_data
from kinetics.crosscheck.data.table import Table, table_of_frames

if TYPE_CHECKING:
    import h5py

#: Elements that are labels of particles, and our names; this package writes `medium`.
LABEL_OF_ELEMENT = {"id": "tracer", "medium": "medium", "species": "type"}


def read_h5md(file: h5py.File, where: str, options: DataOptions) -> Table:
    """Read an open H5MD file."""
    group = _group_of_particles(where, file["particles"])
    _require_memory(where, group)
    positions = without_mask(numbers_of(where, group, "position")).astype(float, copy=False)
    times = _times_of(where, group, "position", positions.shape[0], options)
    vectors = {"position": positions}
    if "velocity" in group:
        vectors["velocity"] = _velocities(where, group, positions, times, options)
    labels = _labels_of(where, group, positions.shape[:2])
    box = _box_of(where, group, positions.shape[2])
    if "image" in group:
        vectors["position"] = _unwrapped_by_images(where, group, positions, box)
        box = None
    frames = [_frame(vectors, labels, index, time) for index, time in enumerate(times)]
    return table_of_frames(where, frames, options, box)


def _require_memory(where: str, group: h5py.Group) -> None:
    """Raise InputError for elements of particles that together do not fit."""
    import h5py

    budget = MemoryBudget(where)
    for name in ("position", "velocity", "image", *LABEL_OF_ELEMENT):
        dataset = dataset_of(group, name)
        if isinstance(dataset, h5py.Dataset):
            take_dataset(budget, where, dataset)


def _group_of_particles(where: str, particles: h5py.Group) -> h5py.Group:
    """Return the only group of particles that has positions."""
    groups = []
    for name in particles:
        group = member_of(particles, name)
        if group is not None and member_of(group, "position") is not None:
            groups.append(group)
    if len(groups) != 1:
        refuse_data(where, f"{len(groups)} groups with position", "one")
    return groups[0]


def _times_of(
    where: str, group: h5py.Group, name: str, n_frames: int, options: DataOptions
) -> Floats:
    """Return the times of an element, from its times or its steps.

    Each may be an array, or one number: the increment, with an offset as its attribute.
    """
    element = group[name]
    if "time" in element:
        return _progression(where, element, "time", n_frames)
    if "step" not in element:
        refuse_data(where, "no times", "times or steps of each frame")
    return options.times_of_steps(where, _progression(where, element, "step", n_frames))


def _progression(where: str, element: h5py.Group, name: str, n_frames: int) -> Floats:
    """Return times or steps (n_frames,), also where only their increment is stored."""
    values = np.asarray(numbers_of(where, element, name), float)
    if values.ndim == 0:
        offset = float(element[name].attrs.get("offset", 0.0))
        values = offset + float(values) * np.arange(n_frames)
    if values.shape != (n_frames,):
        refuse_data(
            f"{where}: {name}", f"shape {values.shape}", f"one number for {n_frames} frames"
        )
    return values


def _velocities(
    where: str, group: h5py.Group, positions: Floats, times: Floats, options: DataOptions
) -> Floats:
    """Return velocities at the times of the positions; missing at those that have none."""
    values = without_mask(numbers_of(where, group, "velocity")).astype(float, copy=False)
    velocity_times = _times_of(where, group, "velocity", values.shape[0], options)
    if values.shape[1:] != positions.shape[1:]:
        refuse_data(f"{where}: velocity", values.shape, f"{positions.shape}, as of the positions")
    index = np.searchsorted(times, velocity_times)
    index = np.minimum(index, times.size - 1)
    if not np.array_equal(times[index], velocity_times):
        refuse_data(where, "positions and velocities at different times", "at the same times")
    velocities = np.full(positions.shape, np.nan)
    velocities[index] = values
    return velocities


def _labels_of(where: str, group: h5py.Group, shape: tuple[int, ...]) -> dict[str, Column]:
    """Return the labels of the particles, shape (n_frames, n); by default they keep their order."""
    labels: dict[str, Column] = {"tracer": np.arange(shape[1])}
    for element, name in LABEL_OF_ELEMENT.items():
        if element in group:
            labels[name] = without_mask(numbers_of(where, group, element))
    for name, values in labels.items():
        if values.shape not in (shape, shape[1:]):
            allowed = f"a label for each of the {shape[1]} particles"
            refuse_data(f"{where}: {name}", f"shape {values.shape}", allowed)
        labels[name] = np.broadcast_to(values, shape)
    return labels


def _box_of(where: str, group: h5py.Group, n_axes: int) -> Box | None:
    """Return the box, if it has edges; they may be a vector or a matrix, also for each frame."""
    import h5py

    box = member_of(group, "box")
    if box is None or "edges" not in box:
        return None
    edges = np.asarray(numbers_of(where, box, "edges"), float)
    if edges.size == 0:
        return None
    is_over_time = isinstance(member_of(box, "edges"), h5py.Group)
    if is_over_time:
        if not np.all(edges == edges[0]):
            refuse_data(f"{where}: box", "one that changes", "one that is always the same")
        edges = edges[0]
    if edges.ndim == 2 and edges.shape[0] == edges.shape[1]:
        if np.any(edges != np.diag(np.diagonal(edges))):
            refuse_data(f"{where}: box", "a slanted one", "rectangular")
        edges = np.diagonal(edges)
    edges = np.atleast_2d(edges)[0]
    sides = dict(zip(AXES[:n_axes], edges.tolist(), strict=False))
    periodic = set()
    for axis, word in zip(AXES, np.ravel(box.attrs.get("boundary", ())), strict=False):
        if _text(word) == "periodic":
            periodic.add(axis)
    return Box(sides, frozenset(periodic))


def _text(word: str | bytes) -> str:
    """Return a text of HDF5, which may be bytes."""
    if isinstance(word, bytes):
        return word.decode()
    return str(word)


def _unwrapped_by_images(
    where: str, group: h5py.Group, positions: Floats, box: Box | None
) -> Floats:
    """Return positions with the sides of the box that each tracer has crossed."""
    images = without_mask(numbers_of(where, group, "image")).astype(float, copy=False)
    sides = np.zeros(positions.shape[2])
    if box is not None:
        for index, axis in enumerate(AXES[: sides.size]):
            sides[index] = box.sides.get(axis, 0.0)
    if images.shape != positions.shape or not np.all(sides > 0):
        allowed = f"{positions.shape}, with a box that is always the same"
        refuse_data(f"{where}: image", images.shape, allowed)
    return np.asarray(positions + images * sides)


def _frame(vectors: dict[str, Floats], labels: dict[str, Column], index: int, time: float) -> Frame:
    """Return one frame by our names."""
    columns = {name: values[index] for name, values in labels.items()}
    for names, element in ((AXES, "position"), (SPEEDS, "velocity")):
        if element in vectors:
            columns |= dict(zip(names, vectors[element][index].T, strict=False))
    return Frame(float(time), columns)
