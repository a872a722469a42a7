"""Runs in HDF5 files, while they go on and when they have ended; and as H5MD for other programs.

Attributes of a file: `format`, `done` (the first so many configurations are in it) and `plan`, the
arguments as JSON, whose arrays are datasets in `plan`. Lengths are in the diameter d, times in d/U:

    moments (done, n_times, 8)      sums over tracers: 1, (s v)^2, (s v)^4, r^2, r^4, collisions,
                                    s v(t).v(0), trapped; s = 2^round(log2(max(t, 1)))
    path_sums (done, 2)             path and collisions
    field_sums (done, n_times, 10)  in a field, whose s is 1, sums over tracers: v_x, v_y, v_x^2,
                                    v_x v_y, v_y^2, and the same of the place; in space (.., 18)
    statuses (4,)                   finished, collision cap, trapped, escaped
    traps (n, 5)                    configuration, tracer, time, x, y (and z) of trapped tracers
    histograms/<name>/sums (3, n_times, bins + 2)   sums over configurations of the counts c,
                                    of c^2 and of c m; the first and last bins are what lies outside
    histograms/<name>/samples (2, n_times)          sums of m, the counts of a time, and of m^2
    raw/<name>                      of each tracer: as the attributes of Ensemble; passages (n,)

While a run goes on, each configuration is a file of its own in the folder `<file>.parts`, until the
run's file is written again. Every file is written beside its target and renamed, so it is whole or
absent, and checksummed by its format. A part (.npz, which takes a tenth of the time of HDF5) that
cannot be read is run again, to the same bits.
"""

import json
import os
import re
import secrets
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import fields
from io import BytesIO
from typing import Any

import h5py
import numpy as np

from particles.checks import check_path, short
from particles.configuration import Plan, Tally
from particles.media import MEDIA
from particles.results import package_version
from particles.totals import Totals

try:
    import fcntl
except ImportError:  # pragma: no cover - Windows: nothing keeps two runs from one file
    fcntl = None  # type: ignore[assignment]

FORMAT = "inelastic-lorentz particles 5"
SHARE = 0.02  # of the time between two writings of the whole file that one of them may take
_KINDS = {medium.__name__: medium for medium in MEDIA}
_PART = re.compile(r"\d{9}\.npz|\..*\.[0-9a-f]{16}\.part")
_in_use: set[str] = set()  # by this process, which its own locks do not stop


def write(
    path: Any, plan: Plan, arrays: Mapping[str, np.ndarray], done: int, beside: str = ""
) -> None:
    """Write a run, replacing what is at `path`. Raises ValueError if it cannot be written."""
    text, described = _described(plan)
    about = {"format": np.bytes_(FORMAT), "done": done, "plan": np.bytes_(text)}
    write_whole(check_path("path", path), _image(about, {**described, **arrays}), beside)


def read(path: Any) -> tuple[Plan, dict[str, np.ndarray], int]:
    """Return (plan, arrays, configurations done) from a file, which is only read.

    Raises ValueError, one line, for a file that is missing, damaged, or not one of ours.
    """
    name = check_path("path", path)
    if not os.path.isfile(name):
        raise ValueError(f"{name}: no such file")
    try:
        about, arrays = _contents(name)
        plan = {k: arrays.pop(k) for k in [*arrays] if k.startswith("plan/")}
        done = int(about["done"])
        if len(arrays["moments"]) != done:
            raise ValueError("its arrays do not fit its plan")
        return _understood(about["plan"].decode(), plan), arrays, done
    except Exception as error:  # of nearly any class; h5py's own words are long
        what = "is damaged, or not a saved simulation of this version"
        raise ValueError(f"{name}: {what} ({type(error).__name__})") from None


def _described(plan: Plan) -> tuple[str, dict[str, np.ndarray]]:
    """Return a plan as JSON, field by field, and its arrays."""
    arrays: dict[str, np.ndarray] = {}
    return json.dumps({f.name: _plain(f.name, plan, arrays) for f in fields(plan)}), arrays


def _plain(name: str, of: Any, arrays: dict[str, np.ndarray]) -> Any:
    value = getattr(of, name)
    if isinstance(value, np.ndarray):
        arrays[f"plan/{name}"] = value
        return {"array": f"plan/{name}"}
    if (kind := type(value).__name__) in _KINDS:
        kept = {f.name: _plain(f.name, value, arrays) for f in fields(value) if f.init}
        return {"kind": kind, **kept}
    return sorted(value) if isinstance(value, frozenset) else value


def _understood(text: str, arrays: Mapping[str, np.ndarray]) -> Plan:
    """Return the plan that `_described` was given."""

    def restored(values: dict[str, Any]) -> Any:
        if "array" in values:
            return arrays[values["array"]]
        kind = values.pop("kind", None)
        return _KINDS[kind](**values) if kind else values

    values = json.loads(text, object_hook=restored)
    return Plan(**values | {"observables": frozenset(values["observables"])})


def _image(about: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> bytes:
    """Return an HDF5 file, made in memory: on a full disk HDF5 would end the process."""
    image = BytesIO()
    with h5py.File(image, "w", libver=("v110", "v110")) as file:  # its structure is checksummed
        file.attrs.update(about)
        for name, array in arrays.items():
            file.create_dataset(name, data=array, fletcher32=array.size > 0 or None)
    return image.getvalue()


def _contents(path: str) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return the attributes and the arrays of a file; links to others are not followed."""
    arrays: dict[str, np.ndarray] = {}

    def collect(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset):
            elsewhere = item.is_virtual or item.external
            if elsewhere or item.id.get_storage_size() < item.nbytes:
                raise ValueError(f"{name!r} is not stored in it as a whole")
            arrays[name] = item[()]

    with h5py.File(path, "r") as file:
        about = dict(file.attrs)
        if about["format"] != FORMAT.encode():
            raise ValueError("another format")
        file.visititems(collect)
    return about, arrays


class Saver:
    """Saves a run configuration by configuration; no other run can be saved there meanwhile."""

    def __init__(self, path: str, plan: Plan) -> None:
        self.path, self.plan = os.path.realpath(path), plan
        self._folder, self._text = f"{self.path}.parts", _described(plan)[0].encode()
        self._lock: Any = None
        self._next, self._saved = 0.0, 0

    def begin(self, resume: bool) -> Totals:
        """Return the totals to go on from, and make sure that the run can be saved.

        Raises ValueError for a run that exists (without resume), is in use, is damaged or is
        another one, or if it cannot be written. What is refused is left as it was.
        """
        require_regular(self.path)
        try:
            self._open()
            if os.path.exists(self.path):
                if not resume:
                    what = "exists; resume=True (--resume) would go on from it"
                    raise ValueError(f"output = {short(self.path, 200)}: {what}")
                totals = self._read()
            else:
                totals = Totals(self.plan)
                self._write(totals)  # any parts are of a run whose file is gone
            return totals
        except BaseException as error:
            self._close()
            raise cannot_write(self.path, error) if isinstance(error, OSError) else error from None

    def add(self, tally: Tally, totals: Totals) -> None:
        """Save one more configuration, which `totals` holds already."""
        nested = {"histograms": tally.histograms, "raw": tally.raw}
        arrays = {k: v for k, v in vars(tally).items() if isinstance(v, np.ndarray)}
        arrays |= {f"{k}/{name}": v for k, group in nested.items() for name, v in group.items()}
        arrays["plan"] = np.frombuffer(self._text, np.uint8)
        np.savez(image := BytesIO(), **arrays)  # type: ignore[arg-type]
        write_whole(self._part(tally.configuration), image.getvalue(), sync=False)
        if time.monotonic() >= self._next:
            self._write(totals)

    def finish(self, totals: Totals) -> None:
        """Save everything in the run's own file, and remove the parts."""
        try:
            if totals.configurations > self._saved:
                self._write(totals)
            self._clear()
        finally:
            self._close()

    def stop(self) -> None:
        """Save what is complete after an exception; one configuration may be half added by then.

        Where that cannot be done, as on a full disk, the parts stay and the run goes on from them.
        """
        try:
            self.finish(self._read())
        finally:
            self._close()

    def _read(self) -> Totals:
        """Return what the file and the parts hold, of this run and no other."""
        found, arrays, self._saved = read(self.path)
        for f in fields(self.plan):
            ours, theirs = (getattr(plan, f.name) for plan in (self.plan, found))
            if not np.array_equal(ours, theirs):
                what = f"holds another run, with {f.name} = {short(theirs)}, not {short(ours)}"
                raise ValueError(f"output = {short(self.path, 200)}: {what}")
        totals = Totals.restore(self.plan, arrays)
        while tally := self._tally(totals.configurations):
            totals.add(tally)
        return totals

    def _tally(self, configuration: int) -> Tally | None:
        """Return what a part holds; None where it is not there, damaged, or of another run."""
        parts: dict[str, Any] = {"histograms": {}, "raw": {}}
        with suppress(Exception), np.load(self._part(configuration)) as arrays:
            if arrays["plan"].tobytes() == self._text:
                for name in set(arrays) - {"plan"}:  # the CRC of each is checked
                    group, _, key = name.rpartition("/")
                    (parts[group] if group else parts)[key] = arrays[name]
                return Tally(configuration, **parts)
        return None

    def _part(self, configuration: int) -> str:
        return os.path.join(self._folder, f"{configuration:09}.npz")

    def _write(self, totals: Totals) -> None:
        began = time.monotonic()
        write(self.path, self.plan, totals.arrays(), totals.configurations, self._folder)
        self._saved, ended = totals.configurations, time.monotonic()
        self._next = ended + (ended - began) / SHARE
        self._clear()

    def _clear(self) -> None:
        """Remove the parts, and what is left of parts that were not finished."""
        for name in filter(_PART.fullmatch, os.listdir(self._folder)):
            os.unlink(os.path.join(self._folder, name))

    def _open(self) -> None:
        """Lock the folder of the parts; the system unlocks it when a process is killed."""
        path = os.path.join(self._folder, "lock")
        busy = ValueError(f"output = {short(self.path, 200)}: in use by another process")
        if self.path in _in_use:
            raise busy
        while self._lock is None:
            with suppress(FileExistsError):
                os.mkdir(self._folder)
            file = open(path, "ab")  # noqa: SIM115 - closed by `_close`
            try:
                if fcntl is not None:
                    fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except (BlockingIOError, PermissionError):
                file.close()
                raise busy from None
            with suppress(FileNotFoundError):  # the process that had it has removed it in between
                if os.path.samestat(os.stat(path), os.fstat(file.fileno())):
                    self._lock = file
            if self._lock is None:
                file.close()
        _in_use.add(self.path)

    def _close(self) -> None:
        """Unlock; and remove the folder if no parts are in it."""
        if self._lock is None:
            return
        with suppress(OSError):
            if os.listdir(self._folder) == ["lock"]:
                os.unlink(self._lock.name)
                os.rmdir(self._folder)
        self._lock.close()
        self._lock = None
        _in_use.discard(self.path)


def write_whole(path: str, contents: bytes, folder: str = "", sync: bool = True) -> None:
    """Write a file in a folder, its own by default, rename it, and wait for the disk.

    A symbolic link is followed: the file that it points to is replaced. Raises ValueError if it
    cannot be written; what was there before is left as it was.
    """
    require_regular(path)
    home, name = os.path.split(os.path.realpath(path))
    part = os.path.join(folder or home, f".{name}.{secrets.token_hex(8)}.part")
    try:
        with open(part, "xb") as file:  # x: never through a symbolic link
            file.write(contents)
            file.flush()
            if sync:
                os.fsync(file.fileno())
        os.replace(part, os.path.join(home, name))
        if sync and os.name == "posix":  # the new name is safe with its folder
            descriptor = os.open(home, os.O_RDONLY)
            os.fsync(descriptor)
            os.close(descriptor)
    except OSError as error:
        raise cannot_write(path, error) from None
    finally:
        with suppress(OSError):
            os.unlink(part)  # it is there only if something went wrong


def require_regular(path: str) -> None:
    """Raise ValueError for a path where something else than a file is: a folder, device or pipe."""
    if os.path.exists(path) and not os.path.isfile(path):
        raise ValueError(f"{path}: is a folder, a device or a pipe, not a file")


def cannot_write(path: str, error: OSError) -> ValueError:
    """Return what is said where a file cannot be written."""
    return ValueError(f"output = {short(path, 200)}: cannot be written ({error.strerror or error})")


def write_h5md(path: str, plan: Plan, positions: np.ndarray, velocities: np.ndarray) -> None:
    """Write a run as H5MD 1.1: positions and velocities over time, which other programs read.

    P. de Buyl, P. H. Colberg and F. Hoefling, Comput. Phys. Commun. 185, 1546 (2014); the
    specification is at nongnu.org/h5md. Units are stated as its module `units` has them: lengths in
    the diameter d, speeds in U, times in d/U. Positions are displacements from each tracer's start,
    in no box; NaN where a tracer has ended. Beside what the specification knows, `medium` (n,) is
    the configuration of each tracer. positions, velocities (n_times, n, dimension).
    """
    unit, dimension = plan.medium.diameter, plan.medium.dimension
    image = BytesIO()
    with h5py.File(image, "w") as file:
        file.create_group("h5md").attrs["version"] = np.array([1, 1], np.int32)
        file.create_group("h5md/author").attrs["name"] = "unknown"
        creator = {"name": "inelastic-lorentz", "version": package_version()}
        file.create_group("h5md/creator").attrs.update(creator)
        file.create_group("h5md/modules/units").attrs["version"] = np.array([1, 0], np.int32)
        group = file.create_group("particles/tracers")
        box = group.create_group("box")
        box.attrs.update({"dimension": dimension, "boundary": np.array([b"none"] * dimension)})
        for name, values, of in (("position", positions, "d"), ("velocity", velocities, "U")):
            group[f"{name}/value"] = values
            group[f"{name}/value"].attrs["unit"] = of
        group["position/step"] = np.arange(plan.times.size)
        group["position/time"] = plan.times / unit
        group["position/time"].attrs["unit"] = "d U-1"
        for name in ("step", "time"):
            group[f"velocity/{name}"] = group[f"position/{name}"]  # a hard link
        count = plan.media * plan.tracers
        group["id"], group["medium"] = np.arange(count), np.arange(count) // plan.tracers
        file["parameters/restitution"] = plan.restitution
        file["parameters/tangential_restitution"] = plan.tangential_restitution
        file["parameters/number_density"] = plan.medium.number_density * unit**dimension
        file["parameters/field"] = plan.field * unit
    write_whole(path, image.getvalue())
