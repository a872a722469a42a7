"""Runs as H5MD 1.1 files, which other programs read: positions and velocities over time.

P. de Buyl, P. H. Colberg and F. Hoefling, Comput. Phys. Commun. 185, 1546 (2014); the specification
is at nongnu.org/h5md. Units are stated as its module `units` has them: lengths in d, the diameter,
speeds in U, times in d/U. Positions are displacements from each tracer's start, in no box. Beside
what the specification knows, `medium` (n,) is the configuration of each tracer.
"""

from importlib.metadata import PackageNotFoundError, version
from io import BytesIO
from typing import TYPE_CHECKING

import h5py
import numpy as np

from particles.storage.whole_files import write_whole

if TYPE_CHECKING:
    from particles.ensemble import Ensemble

NEEDED = ("positions", "velocities")
"""The observables that a run must have for such a file."""
AUTHOR = "unknown"


def write(path: str, run: "Ensemble") -> None:
    """Write a run, replacing the file if it exists. Raises ValueError where that cannot be done."""
    for name in NEEDED:
        if name not in run.outputs:
            raise ValueError(
                f"{path}: H5MD needs positions and velocities; this run has no {name}: "
                f"simulate(observables=[{name!r}, ...])"
            )
    buffer = BytesIO()
    with h5py.File(buffer, "w") as file:
        _write_head(file)
        particles = file.create_group("particles/tracers")
        _write_box(particles, run.medium.dimension)
        _write_elements(particles, run)
        parameters = file.create_group("parameters")
        unit = run.medium.diameter
        for name in ("restitution", "tangential_restitution"):
            parameters[name] = getattr(run, name)
        parameters["number_density"] = run.number_density * unit**run.medium.dimension
        parameters["field"] = run.field * unit
    write_whole(path, buffer.getbuffer())


def _write_head(file: h5py.File) -> None:
    head = file.create_group("h5md")
    head.attrs["version"] = np.array([1, 1], np.int32)
    head.create_group("author").attrs["name"] = AUTHOR
    creator = head.create_group("creator")
    creator.attrs["name"] = "inelastic-lorentz"
    try:
        creator.attrs["version"] = version("inelastic-lorentz")
    except PackageNotFoundError:  # run from a folder, without being installed
        creator.attrs["version"] = "unknown"
    units = head.create_group("modules/units")
    units.attrs["version"] = np.array([1, 0], np.int32)


def _write_box(particles: h5py.Group, dimension: int) -> None:
    box = particles.create_group("box")
    box.attrs["dimension"] = dimension
    box.attrs["boundary"] = np.array([b"none"] * dimension)


def _write_elements(particles: h5py.Group, run: "Ensemble") -> None:
    """Positions and velocities (n_times, n, dimension), which share their steps and times."""
    count = run.media * run.tracers
    step = time = None
    length = run.medium.diameter
    for name, values, unit in (
        ("position", run.positions / length, "d"),
        ("velocity", run.velocities, "U"),
    ):
        element = particles.create_group(name)
        element.create_dataset("value", data=values).attrs["unit"] = unit
        if step is None:
            step = element.create_dataset("step", data=np.arange(run.times.size))
            time = element.create_dataset("time", data=run.times / length)
            time.attrs["unit"] = "d U-1"
        else:
            element["step"], element["time"] = step, time  # hard links
    particles["id"] = np.arange(count)
    particles["medium"] = np.arange(count) // run.tracers
