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
checksummed by HDF5. A run that is killed goes on from its file, to the same bits.
"""

import json
import os
import secrets
import time
from contextlib import suppress
from dataclasses import fields
from io import BytesIO
from math import inf
from typing import Any

import h5py
import numpy as np

from particles.configuration import Arrays, Totals
from particles.impact import Tabulated, Viscoelastic
from particles.media import MEDIA
from particles.outputs import DRIVES
from particles.plan import Plan
from particles.values import check_path, package_version, short

FORMAT = "inelastic-lorentz particles 8"
SHARE = 0.02  # of the time between two writings of the whole file that one of them may take


def write(path: Any, plan: Plan, arrays: Arrays, done: int) -> None:
    """Write a run, replacing what is at `path`. Raises ValueError if it cannot be written."""
    image = BytesIO()  # in memory: on a full disk HDF5 would end the process
    with h5py.File(image, "w", libver=("v110", "v110")) as file:  # its structure is checksummed
        file.attrs.update({"format": np.bytes_(FORMAT), "done": done})
        text = np.frombuffer(_text(plan), np.uint8)
        for name, array in {"plan": text, **arrays}.items():
            file.create_dataset(name, data=array, fletcher32=array.size > 0 or None)
    write_whole(check_path("path", path), image.getvalue())


def read(path: Any) -> tuple[Plan, dict[str, np.ndarray], int]:
    """Return (plan, arrays, configurations done) from a file; ValueError if it cannot be used."""
    path = check_path("path", path)
    if not os.path.isfile(path):
        raise ValueError(f"{path}: no such file")
    names: list[str] = []
    try:
        with h5py.File(path, "r") as file:
            found, done = file.attrs["format"].decode(), int(file.attrs["done"])
            if found == FORMAT:
                file.visit(names.append)
                arrays = {n: file[n][()] for n in names if isinstance(file[n], h5py.Dataset)}
                plan = _understood(arrays.pop("plan").tobytes())
    except Exception as error:  # of nearly any class; h5py's own words are long
        what = "is damaged, or no saved simulation"
        raise ValueError(f"{path}: {what} ({type(error).__name__})") from None
    if found != FORMAT:
        raise ValueError(f"{path}: holds {short(found)}; this version reads {FORMAT!r}")
    return plan, arrays, done


def _text(plan: Plan) -> bytes:
    """Return the arguments of a plan as JSON."""

    def plain(value: Any) -> Any:
        if isinstance(value, frozenset):
            return sorted(value)
        if isinstance(value, np.ndarray):
            return value.tolist()
        own = {f.name: getattr(value, f.name) for f in fields(value) if f.init}
        return {"kind": type(value).__name__} | own

    return json.dumps(dict(plan.arguments()), default=plain).encode()


def _understood(text: bytes) -> Plan:
    """Return the plan that `_text` was given."""
    arguments = json.loads(text)
    kinds = {medium.__name__: medium for medium in MEDIA}
    medium = arguments["medium"]
    arguments["medium"] = kinds[medium.pop("kind")](**medium)
    law = arguments["restitution"]
    if isinstance(law, dict):
        is_table = law.pop("kind") == "Tabulated"
        law = Tabulated(*map(np.array, law.values())) if is_table else Viscoelastic(**law)
        arguments["restitution"] = law
    arguments["times"] = np.array(arguments["times"], float)
    if arguments["velocities"] is not None:
        arguments["velocities"] = np.array(arguments["velocities"], float)
    arguments["observables"] = frozenset(arguments["observables"])
    if arguments["part"]:
        arguments["part"] = tuple(arguments["part"])
    return Plan.of_arguments(arguments)


class Saver:
    """Writes the file of a run now and then, and at its end."""

    def __init__(self, path: str, plan: Plan) -> None:
        self.path, self.plan = os.path.realpath(path), plan
        self._next = 0.0

    def begin(self, resume: bool) -> Totals:
        """Return the totals to go on from, and make sure that the run can be saved."""
        if not os.path.isfile(self.path):
            totals = Totals(self.plan)
            self.write(totals)
            return totals
        where = f"output: got {short(self.path, 200)}"
        if not resume:
            raise ValueError(f"{where}; it exists, resume=True (--resume) would go on from it")
        found, arrays, done = read(self.path)
        if other := self.plan.difference_from(found):
            raise ValueError(f"{where}; it holds {other}")
        return Totals(self.plan, arrays, done)

    def write(self, totals: Totals, at_once: bool = True) -> None:
        """Save everything, at once or if the last time was long enough ago."""
        if at_once or time.monotonic() >= self._next:
            began = time.monotonic()
            write(self.path, self.plan, totals.arrays(), totals.configurations)
            self._next = time.monotonic() + (time.monotonic() - began) / SHARE


def write_whole(path: str, contents: bytes) -> None:
    """Write a file beside its target, or what a link points to, rename it, and wait for the disk.

    Raises ValueError if it cannot be written; what was there before is left as it was.
    """
    if os.path.exists(path) and not os.path.isfile(path):
        raise ValueError(f"{path}: is a folder, a device or a pipe, not a file")
    home, name = os.path.split(os.path.realpath(path))
    part = os.path.join(home, f".{name}.{secrets.token_hex(8)}.part")
    try:
        with open(part, "xb") as file:  # x: never through a symbolic link
            file.write(contents)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, os.path.join(home, name))
        if os.name == "posix":  # the new name is safe with its folder
            descriptor = os.open(home, os.O_RDONLY)
            os.fsync(descriptor)
            os.close(descriptor)
    except OSError as error:
        why = f"it cannot be written ({error.strerror or error})"
        raise ValueError(f"output: got {short(path, 200)}; {why}") from None
    finally:
        with suppress(OSError):
            os.unlink(part)  # it is there only if something went wrong


def write_h5md(path: str, plan: Plan, positions: np.ndarray, velocities: np.ndarray) -> None:
    """Write a run as H5MD 1.1: positions and velocities (n_times, n, dimension), in d and U.

    P. de Buyl, P. H. Colberg and F. Hoefling, Comput. Phys. Commun. 185, 1546 (2014). Positions are
    displacements from each tracer's start, in no box; NaN where a tracer has ended. `medium` (n,)
    is the configuration of each tracer.
    """
    unit, dimension = plan.medium.diameter, plan.medium.dimension
    first, count = plan.configurations.start, len(plan.configurations) * plan.tracers
    with h5py.File(image := BytesIO(), "w") as file:
        file.create_group("h5md").attrs["version"] = np.array([1, 1], np.int32)
        file.create_group("h5md/author").attrs["name"] = "unknown"
        creator = {"name": "inelastic-lorentz", "version": package_version()}
        file.create_group("h5md/creator").attrs.update(creator)
        file.create_group("h5md/modules/units").attrs["version"] = np.array([1, 0], np.int32)
        group = file.create_group("particles/tracers")
        boundary = np.array([b"none"] * dimension)
        group.create_group("box").attrs.update({"dimension": dimension, "boundary": boundary})
        for name, values, of in (("position", positions, "d"), ("velocity", velocities, "U")):
            group[f"{name}/value"] = values
            group[f"{name}/value"].attrs["unit"] = of
            group[f"{name}/step"] = np.arange(plan.times.size)
            group[f"{name}/time"] = plan.times / unit
            group[f"{name}/time"].attrs["unit"] = "d U-1"
        group["id"], group["medium"] = np.arange(count), first + np.arange(count) // plan.tracers
        law = plan.drive.restitution  # as text where it depends on the impact speed
        file["parameters/restitution"] = law if isinstance(law, float) else repr(law)
        for name in (name for name in DRIVES if getattr(plan.drive, name)):
            file[f"parameters/{name}"] = getattr(plan.drive, name)
        if plan.drive.mass_ratio < inf:
            file["parameters/mass_ratio"] = plan.drive.mass_ratio
    write_whole(path, image.getvalue())
