"""Runs as H5MD 1.1 files, which other programs read: positions and velocities over time.

P. de Buyl, P. H. Colberg and F. Hoefling, Comput. Phys. Commun. 185, 1546 (2014); the specification
is at nongnu.org/h5md. Units are stated as its module `units` has them: lengths in d, the diameter,
speeds in U, times in d/U. Positions are displacements from each tracer's start, in no box. Beside
what the specification knows, `medium` (n,) is the configuration of each tracer.
"""

from importlib.metadata import PackageNotFoundError, version
from io import BytesIO

import h5py
import numpy as np

from particles.configuration import Plan
from particles.storage.whole_files import write_whole

AUTHOR = "unknown"


def write(path: str, plan: Plan, positions: np.ndarray, velocities: np.ndarray) -> None:
    """Write a run, replacing the file if it exists. Raises ValueError where that cannot be done.

    positions in d, velocities in U, (n_times, n, dimension); NaN where a tracer has ended.
    """
    buffer = BytesIO()
    with h5py.File(buffer, "w") as file:
        _write_head(file)
        particles = file.create_group("particles/tracers")
        box = particles.create_group("box")
        box.attrs["dimension"] = plan.medium.dimension
        box.attrs["boundary"] = np.array([b"none"] * plan.medium.dimension)
        _write_elements(particles, plan, {"position": positions, "velocity": velocities})
        parameters = file.create_group("parameters")
        unit = plan.medium.diameter
        for name in ("restitution", "tangential_restitution"):
            parameters[name] = getattr(plan, name)
        parameters["number_density"] = plan.medium.number_density * unit**plan.medium.dimension
        parameters["field"] = plan.field * unit
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


def _write_elements(particles: h5py.Group, plan: Plan, elements: dict[str, np.ndarray]) -> None:
    """Positions and velocities, which share their steps and times, and the labels of tracers."""
    count = plan.media * plan.tracers
    step = time = None
    for name, values in elements.items():
        element = particles.create_group(name)
        unit = "d" if name == "position" else "U"
        element.create_dataset("value", data=values).attrs["unit"] = unit
        if step is None:
            step = element.create_dataset("step", data=np.arange(plan.times.size))
            time = element.create_dataset("time", data=plan.times / plan.medium.diameter)
            time.attrs["unit"] = "d U-1"
        else:
            element["step"], element["time"] = step, time  # hard links
    particles["id"] = np.arange(count)
    particles["medium"] = np.arange(count) // plan.tracers
