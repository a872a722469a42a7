"""Runs in HDF5 files: a file holds whole configurations; a damaged or foreign one is refused.

Layout (version 1). Attributes of the root: `format`, `version`, `done` (configurations in the file,
the first so many), `plan` (JSON: medium and arguments), `digest` (SHA-256 of all the rest). Each
dataset has an attribute `unit`. Lengths are in d and times in d/U with d the diameter, whatever
unit the user's arguments were in.

    plan/times (n_times,)           output times, in the user's unit of length over U
    plan/velocities                 given initial velocities, if any, in U
    plan/positions                  given scatterers, if any, in the user's unit of length
    moments (done, n_times, 8)      sums over tracers: 1, (s v)^2, (s v)^4, r^2, r^4, collisions,
                                    s v(t).v(0), trapped; s = 2^round(log2(max(t, 1)))
    path_sums (done, 2)             path and collisions
    statuses (4,)                   finished, collision cap, trapped, escaped
    traps (n, 5)                    configuration, tracer, time, x, y of each trapped tracer
    histograms/<name>/sums (3, n_times, bins + 2)   sums over configurations of the counts c,
                                    of c^2 and of c m; the first and last bins are what lies outside
    histograms/<name>/samples (2, n_times)          sums of m, the counts of a time, and of m^2
    raw/<name>                      as the attributes of Ensemble, in d and U

A run that is under way has a journal beside its file: particles.storage.journal.
"""

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import fields
from os import PathLike
from typing import Any

import h5py
import numpy as np

from particles.configuration import Plan
from particles.media import BoltzmannGrad, HardDisks, Medium, Poisson, Positions

FORMAT = "inelastic-lorentz particles"
VERSION = 1

_MEDIA: dict[str, type] = {m.__name__: m for m in (HardDisks, Poisson, BoltzmannGrad, Positions)}
_UNITS = {
    "plan/times": "length/U",
    "plan/velocities": "U",
    "plan/positions": "length",
    "moments": "1, U^2, U^4, d^2, d^4, 1, U^2, 1",
    "path_sums": "d, 1",
    "traps": "1, 1, d/U, d, d",
    "raw/positions": "d",
    "raw/velocities": "U",
    "raw/finals": "ln U, ln(d/U), d, d, 1",
}


def _describe(plan: Plan) -> tuple[str, dict[str, np.ndarray]]:
    """Return a plan as JSON and the arrays in it."""
    medium = plan.medium
    arrays = {"plan/times": plan.times}
    if plan.velocities is not None:
        arrays["plan/velocities"] = plan.velocities
    values = {f.name: getattr(medium, f.name) for f in fields(medium) if f.init}
    if isinstance(medium, Positions):
        arrays["plan/positions"] = values.pop("positions")
    text = json.dumps(
        {
            "medium": {"kind": type(medium).__name__, **values},
            "restitution": plan.restitution,
            "monoenergetic": plan.monoenergetic,
            "media": plan.media,
            "tracers": plan.tracers,
            "max_collisions": plan.max_collisions,
            "seed": plan.seed,
            "observables": sorted(plan.observables),
        },
        sort_keys=True,
    )
    return text, arrays


def _understand(text: str, arrays: dict[str, np.ndarray]) -> Plan:
    """Return the plan that `_describe` was given."""
    values = json.loads(text)
    described = values.pop("medium")
    kind = _MEDIA[described.pop("kind")]
    if kind is Positions:
        described["positions"] = arrays["plan/positions"]
        described["start"] = tuple(described["start"])
    medium: Medium = kind(**described)
    return Plan(
        medium=medium,
        velocities=arrays.get("plan/velocities"),
        times=arrays["plan/times"],
        **(values | {"observables": frozenset(values["observables"])}),
    )


def _digest(text: str, done: int, arrays: dict[str, np.ndarray]) -> str:
    total = hashlib.sha256(f"{FORMAT} {VERSION} {done} {text}".encode())
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        total.update(f"{name} {array.dtype.str} {array.shape}".encode())
        total.update(array.data if array.size else b"")
    return total.hexdigest()


def plan_digest(plan: Plan) -> bytes:
    """Return the SHA-256 of a plan, 32 bytes."""
    text, arrays = _describe(plan)
    return bytes.fromhex(_digest(text, 0, arrays))


def write(
    path: str | PathLike[str], plan: Plan, arrays: Mapping[str, np.ndarray], done: int
) -> None:
    """Write a run beside `path` and rename it there. Raises ValueError if it cannot be written."""
    target = os.fspath(path)
    beside = f"{target}.part"
    text, described = _describe(plan)
    everything = {**described, **arrays}
    try:
        with h5py.File(beside, "w") as file:
            file.attrs["format"] = FORMAT
            file.attrs["version"] = VERSION
            file.attrs["done"] = done
            file.attrs["plan"] = text
            file.attrs["digest"] = _digest(text, done, everything)
            for name, array in everything.items():
                file.create_dataset(name, data=array).attrs["unit"] = _UNITS.get(name, "1")
        with open(beside, "rb+") as file:
            os.fsync(file.fileno())
        os.replace(beside, target)
    except BaseException as error:
        # Also after an interruption: HDF5 would not open the same file again for the next one.
        if os.path.isfile(beside):
            os.unlink(beside)
        if isinstance(error, OSError):
            raise cannot_write(target, error) from None
        raise


def cannot_write(path: str, error: OSError) -> ValueError:
    """Return what is said where a file cannot be written."""
    reason = error.strerror or str(error).splitlines()[0]
    return ValueError(f"output = {path!r}: cannot be written ({reason})")


def read(path: str | PathLike[str]) -> tuple[Plan, dict[str, np.ndarray], int]:
    """Return (plan, arrays, configurations done) from a file.

    Raises ValueError for a file that is missing, damaged, or not one of ours; it is only read.
    """
    name = os.fspath(path)
    arrays: dict[str, np.ndarray] = {}

    def collect(key: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset):
            arrays[key] = item[()]

    if not os.path.exists(name):
        raise ValueError(f"{name}: no such file")
    try:
        with h5py.File(name, "r") as file:
            if file.attrs.get("format") != FORMAT:
                raise ValueError(f"{name}: is not a saved simulation")
            if file.attrs["version"] != VERSION:
                raise ValueError(
                    f"{name}: version {file.attrs['version']}; this program reads {VERSION}"
                )
            done = int(file.attrs["done"])
            text, digest = str(file.attrs["plan"]), str(file.attrs["digest"])
            file.visititems(collect)
    except (OSError, KeyError, RuntimeError) as error:
        # h5py's own words are long and name its internals.
        raise ValueError(
            f"{name}: is damaged, or not a saved simulation ({type(error).__name__})"
        ) from None
    if _digest(text, done, arrays) != digest:
        raise ValueError(f"{name}: is damaged (its contents do not match their digest)")
    plan = _understand(text, arrays)
    return plan, {k: v for k, v in arrays.items() if not k.startswith("plan/")}, done


def difference(plan: Plan, found: Plan) -> str:
    """Return the name of an argument in which two plans differ, or an empty string."""
    text, arrays = _describe(plan)
    other_text, other_arrays = _describe(found)
    ours, theirs = json.loads(text), json.loads(other_text)
    for name in ours:
        if ours[name] != theirs.get(name):
            return f"{name} = {theirs.get(name)}, not {ours[name]}"
    for name in sorted(arrays | other_arrays):
        a, b = arrays.get(name), other_arrays.get(name)
        if a is None or b is None or a.shape != b.shape or a.tobytes() != b.tobytes():
            return f"other {name.removeprefix('plan/')}"
    return ""
