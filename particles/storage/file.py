"""Runs in HDF5 files: a file holds whole configurations; a damaged or foreign one is refused.

Layout. Attributes of the root: `format`, `version`, `done` (configurations in the file, the first
so many), `plan` (JSON: medium and arguments), `digest` (SHA-256 of all the rest). Version 2 is for
plans with numbers that version 1 did not know; at their defaults these are left out, and the
version is 1. Version 3 is for media that version 2 did not know, version 4 for runs in a field.
Each dataset has an attribute `unit`. Lengths are in d and times in d/U with d the diameter,
whatever unit the user's arguments were in.

    plan/times (n_times,)           output times, in the user's unit of length over U
    plan/velocities                 given initial velocities, if any, in U
    plan/positions                  given scatterers, if any, in the user's unit of length
    moments (done, n_times, 8)      sums over tracers: 1, (s v)^2, (s v)^4, r^2, r^4, collisions,
                                    s v(t).v(0), trapped; s = 2^round(log2(max(t, 1)))
    path_sums (done, 2)             path and collisions
    field_sums (done, n_times, 10)  in a field, whose s is 1, sums over tracers: v_x, v_y, v_x^2,
                                    v_x v_y, v_y^2, and the same of the place; in space (.., 18)
    statuses (4,)                   finished, collision cap, trapped, escaped
    traps (n, 5)                    configuration, tracer, time, x, y of each trapped tracer;
                                    among spheres (n, 6), with z
    histograms/<name>/sums (3, n_times, bins + 2)   sums over configurations of the counts c,
                                    of c^2 and of c m; the first and last bins are what lies outside
    histograms/<name>/samples (2, n_times)          sums of m, the counts of a time, and of m^2
    raw/passages (done * tracers,)  where a depth was given, when each tracer first was there;
                                    inf if it never was
    raw/<name>                      as the attributes of Ensemble, in d and U

A run that is under way has a journal beside its file: particles.storage.journal.
"""

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import fields
from io import BytesIO
from os import PathLike
from typing import Any

import h5py
import numpy as np

from particles.arguments import make_plan
from particles.checks import check_path
from particles.configuration import Plan, trap_columns
from particles.kernel.columns import (
    FIELD_SUMS,
    FINALS,
    HISTOGRAMS,
    MOMENTS,
    STATUSES,
    TOTALS,
)
from particles.media import MEDIA, HardSpheres, Medium, PoissonSpheres, Positions
from particles.storage.whole_files import require_regular, write_whole

FORMAT = "inelastic-lorentz particles"
# Numbers of a plan that version 1 of the layout did not have, and what they were then.
LATER = {
    "tangential_restitution": 1.0,
    "dimension": 2,
    "field": 0.0,
    "rest": False,
    "depth": None,
}
# Media that version 2 did not have.
_LATER_MEDIA = [medium.__name__ for medium in (HardSpheres, PoissonSpheres)]

_MEDIA: dict[str, type] = {medium.__name__: medium for medium in MEDIA}
_UNITS = {
    "plan/times": "length/U",
    "plan/velocities": "U",
    "plan/positions": "length",
    "moments": "1, U^2, U^4, d^2, d^4, 1, U^2, 1",
    "path_sums": "d, 1",
    "field_sums": "U, U^2, d, d^2",
    "traps": "1, 1, d/U, d, d",  # and d among spheres
    "raw/positions": "d",
    "raw/velocities": "U",
    "raw/passages": "d/U",
    "raw/finals": "ln U, ln(d/U), d, d, 1",  # and d in three dimensions
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
    described = {
        "medium": {"kind": type(medium).__name__, **_without_defaults(values)},
        "restitution": plan.restitution,
        "tangential_restitution": plan.tangential_restitution,
        "monoenergetic": plan.monoenergetic,
        "field": plan.field,
        "rest": plan.rest,
        "depth": plan.depth,
        "media": plan.media,
        "tracers": plan.tracers,
        "max_collisions": plan.max_collisions,
        "seed": plan.seed,
        "observables": sorted(plan.observables),
    }
    return json.dumps(_without_defaults(described), sort_keys=True), arrays


def _without_defaults(values: dict[str, Any]) -> dict[str, Any]:
    return {k: value for k, value in values.items() if k not in LATER or value != LATER[k]}


def _version(text: str) -> int:
    """Return the version of the layout that a plan, as JSON, needs."""
    if '"field"' in text:
        return 4
    if any(f'"{name}"' in text for name in _LATER_MEDIA):
        return 3
    return 2 if any(f'"{name}"' in text for name in LATER) else 1


def _understand(text: str, arrays: dict[str, np.ndarray]) -> Plan:
    """Return the plan that `_describe` was given, its values checked as the user's were."""
    values = json.loads(text)
    described = values.pop("medium")
    kind = _MEDIA[described.pop("kind")]
    if kind is Positions:
        described["positions"] = arrays["plan/positions"]
        described["start"] = tuple(described["start"])
    medium: Medium = kind(**described)
    times = arrays["plan/times"]
    initial = "monoenergetic" if values.pop("monoenergetic") else "gaussian"
    initial = "rest" if values.pop("rest", False) else initial
    plan = make_plan(
        medium=medium,
        initial=arrays.get("plan/velocities", initial),
        times=times if times.size else None,
        **values,
    )
    if _describe(plan)[0] != text:
        raise ValueError("a plan of other keys or values than are written")
    return plan


def _digest(text: str, done: int, arrays: dict[str, np.ndarray]) -> str:
    total = hashlib.sha256(f"{FORMAT} {_version(text)} {done} {text}".encode())
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
    """Write a run, replacing what is at `path`. Raises ValueError if it cannot be written."""
    text, described = _describe(plan)
    everything = {**described, **arrays}
    # In memory: where the disk is full, HDF5 ends the process while it closes its file.
    image = BytesIO()
    with h5py.File(image, "w") as file:
        file.attrs["format"] = FORMAT
        file.attrs["version"] = _version(text)
        file.attrs["done"] = done
        file.attrs["plan"] = text
        file.attrs["digest"] = _digest(text, done, everything)
        for name, array in everything.items():
            file.create_dataset(name, data=array).attrs["unit"] = _UNITS.get(name, "1")
    write_whole(check_path("path", path), image.getbuffer())


class _Refused(ValueError):
    """A file that is not a saved run of this version; the message says why."""


def read(path: str | PathLike[str]) -> tuple[Plan, dict[str, np.ndarray], int]:
    """Return (plan, arrays, configurations done) from a file.

    Raises ValueError for a file that is missing, damaged, or not one of ours; it is only read.
    """
    name = check_path("path", path)
    if not os.path.exists(name):
        raise ValueError(f"{name}: no such file")
    require_regular(name)
    try:
        plan, arrays, done = _read(name)
    except _Refused as error:
        raise ValueError(f"{name}: {error}") from None
    except Exception as error:  # of nearly any class; h5py's own words are long
        what = f"is damaged, or not a saved simulation ({type(error).__name__})"
        raise ValueError(f"{name}: {what}") from None
    return plan, arrays, done


def _read(path: str) -> tuple[Plan, dict[str, np.ndarray], int]:
    with h5py.File(path, "r") as file:
        if file.attrs.get("format") != FORMAT:
            raise _Refused("is not a saved simulation")
        if file.attrs["version"] not in (1, 2, 3, 4):
            raise _Refused(f"version {file.attrs['version']}; this program reads 1 to 4")
        done, text, digest = (file.attrs[name] for name in ("done", "plan", "digest"))
        arrays = _own_arrays(file, os.path.getsize(path))
    if _digest(text, done, arrays) != digest:
        raise _Refused("is damaged (its contents do not match their digest)")
    # The digest tells accidents. What follows refuses a file that was made to do harm.
    plan = _understand(text, arrays)
    results = {name: array for name, array in arrays.items() if not name.startswith("plan/")}
    if not 0 <= done <= plan.media or not _fit(plan, done, results):
        raise _Refused("is damaged (its arrays do not fit its plan)")
    return plan, results, int(done)


def _own_arrays(file: h5py.File, size: int) -> dict[str, np.ndarray]:
    """Return all arrays of a file of so many bytes, none of which may claim to be larger."""
    arrays: dict[str, np.ndarray] = {}

    def collect(name: str, item: Any) -> None:
        nonlocal size
        if not isinstance(item, h5py.Dataset):
            return
        size -= item.nbytes
        elsewhere = item.is_virtual or item.external or item.chunks is not None
        if elsewhere or size < 0 or item.id.get_storage_size() != item.nbytes:
            raise _Refused(f"is damaged (the array {name!r} is not stored in it as a whole)")
        if item.dtype not in (np.float64, np.int64):
            raise _Refused(f"is damaged (the array {name!r} has the type {item.dtype})")
        arrays[name] = item[()]

    file.visititems(collect)
    return arrays


def _fit(plan: Plan, done: int, arrays: Mapping[str, np.ndarray]) -> bool:
    """Tell whether the results of a file have the types and shapes that its plan gives them."""
    times, tracers = plan.times.size, done * plan.tracers
    shapes: dict[str, tuple[int, ...]] = {
        "moments": (done, times, MOMENTS),
        "path_sums": (done, TOTALS),
        "statuses": (STATUSES,),
        "traps": (len(arrays["traps"]), 1 + trap_columns(plan.medium)),
    }
    if plan.field:
        shapes["field_sums"] = (done, times, FIELD_SUMS[plan.medium.dimension])
    if done:
        for name, bins in zip(HISTOGRAMS, plan.grids()[:, 2].astype(int) + 2, strict=True):
            if name in plan.observables:
                rows = 1 if name == "free_path_histogram" else times
                shapes[f"histograms/{name}/sums"] = (3, rows, bins)
                shapes[f"histograms/{name}/samples"] = (2, rows)
        dimension = plan.medium.dimension
        each = {"finals": (tracers, FINALS[dimension]), "passages": (tracers,)}
        for name in plan.raw:
            shapes[f"raw/{name}"] = each.get(name, (times, tracers, dimension))
    whole = {name for name in shapes if name == "statuses" or name.startswith("histograms")}
    return {name: array.shape for name, array in arrays.items()} == shapes and all(
        array.dtype == (np.int64 if name in whole else np.float64) for name, array in arrays.items()
    )


def difference(plan: Plan, found: Plan) -> str:
    """Return the name of an argument in which two plans differ, or an empty string."""
    text, arrays = _describe(plan)
    other_text, other_arrays = _describe(found)
    ours, theirs = LATER | json.loads(text), LATER | json.loads(other_text)
    for name in ours:
        if ours[name] != theirs[name]:
            return f"{name} = {theirs[name]}, not {ours[name]}"
    for name in sorted(arrays | other_arrays):
        a, b = arrays.get(name), other_arrays.get(name)
        if a is None or b is None or a.shape != b.shape or a.tobytes() != b.tobytes():
            return f"other {name.removeprefix('plan/')}"
    return ""
