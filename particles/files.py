"""Runs in HDF5 files, while they go on and when they have ended; and as H5MD for other programs.

Attributes of a file: `format`, and `done` (the first so many configurations are in it). Lengths are
in the diameter d, times in d/U; columns in `outputs`:

    plan (n,)                       the arguments, JSON as bytes
    moments (done, n_times, 8)      sums over tracers; velocities times s = 2^round(log2(max(t, 1)))
    path_sums (done, 2)             path and collisions
    field_sums (done, n_times, ..)  in a field, whose s is 1
    statuses (5,)                   finished, collision cap, trapped, escaped, captured
    traps (n, ..)                   configuration, tracer, time, place: trapped or captured
    histograms/<name>/sums (3, n_times, bins + 2)   sums over configurations of the counts c,
                                    of c^2 and of c m; the first and last bins are what lies outside
    histograms/<name>/samples (2, n_times)          sums of m, the counts of a time, and of m^2
    raw/<name>                      of each tracer: as the attributes of Ensemble; passages (n,)

While a run goes on, its file is written whenever the time since the last writing is fifty times
what that took: beside its target, and renamed, so that it is whole or the one before. All of it is
checksummed by HDF5. A run that is killed goes on from its file, and leaves the same bytes as
a whole one; what it left half written is removed then. Begin reading with `write` and `read`.
"""

import json
import os
import secrets
import time
from contextlib import suppress
from dataclasses import fields
from glob import escape, glob
from io import BytesIO
from math import inf
from os import PathLike
from typing import Any

import h5py
import numpy as np

from particles.arguments import COPIES
from particles.configuration import Arrays, Totals, stored_arrays
from particles.impact import Law, Tabulated, Viscoelastic
from particles.media import MEDIA
from particles.outputs import DRIVES
from particles.plan import Plan
from particles.values import (
    SHOWN_PATH,
    check_path,
    machine_memory,
    package_version,
    short,
    shown_path,
)

FORMAT = "inelastic-lorentz particles 8"
#: What a file has that the package `kinetics` saved.
KINETICS_RECORD = "record"
#: Names in a file that are not those of layouts alone: the plan, and those who were caught.
PLAN = "plan"
TRAPS = "traps"
#: Bytes of memory for a byte of JSON at most. Derived: a list that holds a float for "0," takes 32.
JSON_EXPANSION = 16
#: What deflate, which other programs may pack a file with, makes smaller at most: 1032 times.
MAX_COMPRESSION = 1100
#: Bytes that an array may have whatever is stored of it. Chosen: no run minds them.
SMALL_ARRAY = 1_000_000
#: Share of the time of a run that the writing of its file may take. Chosen: a run then is longer by
#: 2 %, and what a run that is killed loses is fifty times what a writing takes.
WRITING_SHARE = 0.02


# -- whole runs ------------------------------------------------------------------------------------


def write(path: str | PathLike[str], plan: Plan, arrays: Arrays, done: int) -> None:
    """Write a run, replacing what is at `path`. Raises ValueError if it cannot be written.

    done: how many configurations, from the first one on, have been run.
    """
    image = BytesIO()  # in memory: on a full disk HDF5 would end the process
    with h5py.File(image, "w", libver=("v110", "v110")) as file:  # its structure is checksummed
        file.attrs.update({"format": np.bytes_(FORMAT), "done": done})
        plan_as_bytes = np.frombuffer(_encode(plan), np.uint8)
        # in this order, so that a run that was interrupted leaves the same bytes as a whole one
        for name, array in sorted({PLAN: plan_as_bytes, **arrays}.items()):
            file.create_dataset(name, data=array, fletcher32=array.size > 0 or None)
    write_whole(check_path("path", path), image.getvalue())


def read(path: str | PathLike[str]) -> tuple[Plan, dict[str, np.ndarray], int]:
    """Return (plan, arrays, configurations done) from a file; ValueError if it cannot be used."""
    path = check_path("path", path)
    if not os.path.isfile(path):
        raise ValueError(f"{shown_path(path)}: no such file")
    try:
        with h5py.File(path, "r") as file:
            is_of_kinetics = KINETICS_RECORD in file
            if not is_of_kinetics:
                file_format = file.attrs["format"].decode()
                done = int(file.attrs["done"])
            if not is_of_kinetics and file_format == FORMAT:
                plan = _read_plan(file)
                arrays = _read_arrays(file, plan, done)
    except MemoryError as error:
        raise ValueError(f"{shown_path(path)}: {error}") from None
    except Exception as error:  # of nearly any class; h5py's own words are long
        problem = f"is damaged, or no saved simulation ({type(error).__name__})"
        raise ValueError(f"{shown_path(path)}: {problem}") from None
    if is_of_kinetics:
        problem = "is a result of kinetics, which kinetics.load reads"
        raise ValueError(f"{shown_path(path)}: {problem}")
    if file_format != FORMAT:
        holds = f"holds {short(file_format)}; this version reads {FORMAT!r}"
        raise ValueError(f"{shown_path(path)}: {holds}")
    return plan, arrays, done


def _read_plan(file: h5py.File) -> Plan:
    """Return the plan of a file."""
    dataset = _dataset(file, PLAN)
    _require_memory(JSON_EXPANSION * dataset.nbytes)
    return _decode(dataset[()].tobytes())


def _read_arrays(file: h5py.File, plan: Plan, done: int) -> dict[str, np.ndarray]:
    """Return the arrays that so many configurations of a plan leave, by their names.

    Names, types, shapes and sizes are checked before memory is asked for. ValueError for an array
    that the plan does not have, or has in another shape; MemoryError where all do not fit.
    """
    if not 0 <= done <= len(plan.configurations):
        raise ValueError("more configurations than the plan has")
    expected = stored_arrays(plan, done, done * plan.tracers)
    names = _names_of_datasets(file) - {PLAN}
    if names != set(expected):
        raise ValueError("other arrays than the plan has")
    datasets = {name: _dataset(file, name) for name in names}
    for name, (shape, dtype) in expected.items():
        own_shape = datasets[name].shape
        if name == TRAPS and len(own_shape) == 2:  # a row for each tracer that was caught
            own_shape = (max(own_shape[0], shape[0]), own_shape[1])
        if own_shape != shape or datasets[name].dtype != dtype:
            raise ValueError("an array of another shape or type than the plan has")
    _require_memory(sum(dataset.nbytes for dataset in datasets.values()))
    return {name: dataset[()] for name, dataset in datasets.items()}


def _names_of_datasets(file: h5py.File) -> set[str]:
    """Return the names of all datasets that lie in the file itself: links are not followed."""
    names: list[str] = []
    file.visit(names.append)
    return {name for name in names if isinstance(file[name], h5py.Dataset)}


def _dataset(file: h5py.File, name: str) -> h5py.Dataset:
    """Return a dataset; ValueError if its numbers are elsewhere, or more than are stored."""
    if not isinstance(file.get(name, getlink=True), h5py.HardLink):
        raise ValueError("a link in place of an array")
    dataset = file[name]
    if dataset.is_virtual or dataset.external:
        raise ValueError("an array that is stored elsewhere")
    stored = dataset.id.get_storage_size()
    if dataset.nbytes > MAX_COMPRESSION * stored + SMALL_ARRAY:
        raise ValueError("an array of which little is stored")
    return dataset


def _require_memory(size: int) -> None:
    """Raise MemoryError for arrays of so many bytes that do not fit, as a run would not."""
    limit = machine_memory() / COPIES
    if size > limit:
        problem = f"its arrays take {size / 1e9:.2g} GB of memory"
        raise MemoryError(f"{problem}, and a run may have {limit / 1e9:.2g} GB here")


def _encode(plan: Plan) -> bytes:
    """Return the arguments of a plan as JSON."""
    return json.dumps(dict(plan.arguments()), default=_as_json).encode()


def _as_json(value: Any) -> object:
    """Return an argument that JSON has no form of as lists and dictionaries."""
    if isinstance(value, frozenset):
        return sorted(value)
    if isinstance(value, np.ndarray):
        return value.tolist()
    arguments = {field.name: getattr(value, field.name) for field in fields(value) if field.init}
    return {"kind": type(value).__name__} | arguments


def _decode(text: bytes) -> Plan:
    """Return the plan that `_encode` was given."""
    arguments = json.loads(text)
    medium = arguments["medium"]
    class_of_medium = {kind.__name__: kind for kind in MEDIA}[medium.pop("kind")]
    arguments["medium"] = class_of_medium(**medium)
    restitution = arguments["restitution"]
    if isinstance(restitution, dict):
        arguments["restitution"] = _decode_law(restitution)
    arguments["times"] = np.array(arguments["times"], float)
    if arguments["velocities"] is not None:
        arguments["velocities"] = np.array(arguments["velocities"], float)
    arguments["observables"] = frozenset(arguments["observables"])
    if arguments["part"]:
        arguments["part"] = tuple(arguments["part"])
    return Plan.of_arguments(arguments)


def _decode_law(law: dict[str, Any]) -> Law:
    """Return a restitution that depends on the impact speed."""
    if law["kind"] == "Tabulated":
        return Tabulated(np.array(law["speeds"]), np.array(law["values"]))
    return Viscoelastic(law["b"])


class Saver:
    """Writes the file of a run now and then, and at its end."""

    def __init__(self, path: str, plan: Plan) -> None:
        self.path = os.path.realpath(path)
        self.plan = plan
        self._next_writing = 0.0

    def begin(self, resume: bool) -> Totals:
        """Return the totals to go on from, and make sure that the run can be saved."""
        if resume:
            remove_unfinished(self.path)
        if not os.path.isfile(self.path):
            totals = Totals(self.plan)
            self.write(totals)
            return totals
        file = f"output: got {short(self.path, SHOWN_PATH)}"
        if not resume:
            raise ValueError(f"{file}; it exists, resume=True (--resume) would go on from it")
        plan, arrays, done = read(self.path)
        if difference := self.plan.difference_from(plan):
            raise ValueError(f"{file}; it holds {difference}")
        return Totals(self.plan, arrays, done)

    def write(self, totals: Totals, at_once: bool = True) -> None:
        """Save everything, at once or if the last time was long enough ago."""
        began = time.monotonic()
        if not at_once and began < self._next_writing:
            return
        write(self.path, self.plan, totals.arrays(), totals.configurations)
        ended = time.monotonic()
        self._next_writing = ended + (ended - began) / WRITING_SHARE


def write_whole(path: str, contents: bytes) -> None:
    """Write a file beside its target, or what a link points to, rename it, and wait for the disk.

    Raises ValueError if it cannot be written; what was there before is left as it was.
    """
    if os.path.exists(path) and not os.path.isfile(path):
        raise ValueError(f"{shown_path(path)}: is a folder, a device or a pipe, not a file")
    folder, name = os.path.split(os.path.realpath(path))
    unfinished = os.path.join(folder, _unfinished_name(name, secrets.token_hex(8)))
    try:
        with open(unfinished, "xb") as file:  # x: never through a symbolic link
            file.write(contents)
            file.flush()
            os.fsync(file.fileno())
        os.replace(unfinished, os.path.join(folder, name))
        if os.name == "posix":  # the new name is safe with its folder
            descriptor = os.open(folder, os.O_RDONLY)
            os.fsync(descriptor)
            os.close(descriptor)
    except OSError as error:
        why = f"it cannot be written ({error.strerror or error})"
        raise ValueError(f"output: got {short(path, SHOWN_PATH)}; {why}") from None
    finally:
        with suppress(OSError):
            os.unlink(unfinished)  # it is there only if something went wrong


def remove_unfinished(path: str) -> None:
    """Remove what processes left that were killed while they wrote this file."""
    folder, name = os.path.split(os.path.realpath(path))
    for left in glob(_unfinished_name(escape(name), "*"), root_dir=folder, include_hidden=True):
        with suppress(OSError):
            os.unlink(os.path.join(folder, left))


def _unfinished_name(name: str, code: str) -> str:
    """Return the name of a file while it is written; the code tells writers apart."""
    return f".{name}.{code}.part"


# -- H5MD ------------------------------------------------------------------------------------------


def write_h5md(path: str, plan: Plan, positions: np.ndarray, velocities: np.ndarray) -> None:
    """Write a run as H5MD 1.1: positions and velocities (n_times, n, dimension), in d and U.

    P. de Buyl, P. H. Colberg and F. Hoefling, Comput. Phys. Commun. 185, 1546 (2014). Positions are
    displacements from each tracer's start, in no box; NaN where a tracer has ended. `medium` (n,)
    is the configuration of each tracer.
    """
    image = BytesIO()
    with h5py.File(image, "w") as file:
        _write_h5md_header(file)
        _write_h5md_tracers(file, plan, positions, velocities)
        _write_h5md_parameters(file, plan)
    write_whole(path, image.getvalue())


def _write_h5md_header(file: h5py.File) -> None:
    """Write what every H5MD file begins with."""
    file.create_group("h5md").attrs["version"] = np.array([1, 1], np.int32)
    file.create_group("h5md/author").attrs["name"] = "unknown"
    creator = {"name": "inelastic-lorentz", "version": package_version()}
    file.create_group("h5md/creator").attrs.update(creator)
    units = file.create_group("h5md/modules/units")
    units.attrs["version"] = np.array([1, 0], np.int32)


def _write_h5md_tracers(
    file: h5py.File, plan: Plan, positions: np.ndarray, velocities: np.ndarray
) -> None:
    """Write the tracers: their numbers, their configurations, where they are and how fast."""
    dimension = plan.medium.dimension
    group = file.create_group("particles/tracers")
    boundary = np.array([b"none"] * dimension)
    group.create_group("box").attrs.update({"dimension": dimension, "boundary": boundary})
    _write_h5md_element(group, "position", positions, "d", plan)
    _write_h5md_element(group, "velocity", velocities, "U", plan)
    numbers = np.arange(len(plan.configurations) * plan.tracers)
    group["id"] = numbers
    group["medium"] = plan.configurations.start + numbers // plan.tracers


def _write_h5md_element(
    group: h5py.Group, name: str, values: np.ndarray, unit: str, plan: Plan
) -> None:
    """Write what depends on the time, as an element of H5MD."""
    group[f"{name}/value"] = values
    group[f"{name}/value"].attrs["unit"] = unit
    group[f"{name}/step"] = np.arange(plan.times.size)
    group[f"{name}/time"] = plan.times / plan.medium.diameter
    group[f"{name}/time"].attrs["unit"] = "d U-1"


def _write_h5md_parameters(file: h5py.File, plan: Plan) -> None:
    """Write what drives the tracers, without what does not act."""
    drive = plan.drive
    law = drive.restitution  # as text where it depends on the impact speed
    file["parameters/restitution"] = law if isinstance(law, float) else repr(law)
    for name in DRIVES:
        strength = getattr(drive, name)
        if strength:
            file[f"parameters/{name}"] = strength
    if drive.mass_ratio < inf:
        file["parameters/mass_ratio"] = drive.mass_ratio
