"""GSD: frames as HOOMD-blue writes them, read by the package gsd, which is an extra.

Numbers are of single precision. Positions are unwrapped by the image flags that the format has; a
frame says its step, so that --timestep is needed.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.crosscheck.comparison.data.columns import Asked, Rows, shown
from kinetics.crosscheck.comparison.data.frames import PIECE, rows_of
from kinetics.errors import InputError


def read(path: Path, asked: Asked) -> Iterator[Rows]:
    """The rows of a file; the k-th of each frame is the same tracer."""
    try:
        import gsd.hoomd
    except ImportError:
        raise InputError(
            f"{shown(path)}: to read it, the package gsd is needed: pip install gsd"
        ) from None
    if asked.timestep is None:
        raise InputError(f"{shown(path)}: gives steps and no times; say --timestep")
    with gsd.hoomd.open(str(path), "r") as file:
        if not len(file):
            raise InputError(f"{shown(path)}: has no frames")
        for frame in file:
            yield from _rows(shown(path), frame, asked.timestep)


def _rows(where: str, frame: Any, timestep: float) -> Iterator[Rows]:
    """The rows of one frame. Image flags that are all 0 may be none: then it may be wrapped."""
    particles, dimension = frame.particles, 3 if frame.configuration.dimensions == 3 else 2
    box = np.asarray(frame.configuration.box, float)
    if np.any(box[3:] != 0):
        raise InputError(f"{where}: the box must be rectangular")
    edges, time = box[:dimension], frame.configuration.step * timestep
    wrapped = not np.any(particles.image)
    for start in range(0, particles.N, PIECE):
        part = slice(start, min(start + PIECE, particles.N))
        image = np.asarray(particles.image[part, :dimension], float)
        place = np.asarray(particles.position[part, :dimension], float) + image * edges
        speed = np.asarray(particles.velocity[part, :dimension], float)
        rows = rows_of(where, time, place, speed, np.arange(part.start, part.stop))
        yield replace(rows, box=tuple(edges.tolist()) if wrapped and np.all(edges > 0) else None)
