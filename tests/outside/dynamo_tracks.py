"""Run DynamO on `lorentz.dynamo.xml` and keep its tracks: python tests/outside/dynamo_tracks.py

Other questions: python tests/outside/dynamo_tracks.py RESTITUTION DENSITY SEED FILE.npz

Needs DynamO (https://www.dynamomd.com; `dynarun` is looked for on the path). 1,000 tracers in 50
configurations among 2,000 hard disks, kept for e = 0.7 and the density 0.04; lengths in d, speeds
in U, times in d/U. A run takes half a minute.
"""

import math
import subprocess
import sys
import tempfile
from pathlib import Path
from string import Template
from xml.etree import ElementTree

import numpy as np
from lammps_tracks import FreePlaces
from outside_tracks import (
    DENSITY,
    DISKS,
    HERE,
    MEDIA,
    RESTITUTION,
    TIMES,
    TRACERS,
    write_tracks,
)

FILE = HERE / "dynamo-hard-disks-e0.7-n0.04.npz"


def fill_template(
    restitution: float, side: float, disks: np.ndarray, places: np.ndarray, velocities: np.ndarray
) -> str:
    """Fill disks and tracers into the template; each array has rows of x and y."""
    centres = np.concatenate([disks, places]) - 0.5 * side  # DynamO's box is centred on 0
    speeds = np.concatenate([np.zeros_like(disks), velocities])
    particles = [
        f'    <Pt ID="{number}"><P x="{x!r}" y="{y!r}" z="0"/><V x="{vx!r}" y="{vy!r}" z="0"/></Pt>'
        for number, (x, y, vx, vy) in enumerate(np.hstack([centres, speeds]).tolist())
    ]
    template = Template((HERE / "lorentz.dynamo.xml").read_text())
    return template.substitute(
        side=repr(side),
        restitution=repr(restitution),
        last_disk=len(disks) - 1,
        first_tracer=len(disks),
        last_tracer=len(particles) - 1,
        particles="\n".join(particles),
    )


def read_tracers(file: Path, first: int) -> np.ndarray:
    """Read x, y, vx and vy of the particles from a number on, in a configuration of DynamO."""
    root = ElementTree.parse(file).getroot()
    places = root.findall("ParticleData/Pt/P")[first:]
    velocities = root.findall("ParticleData/Pt/V")[first:]
    rows = [
        [float(vector.attrib[axis]) for vector in pair for axis in ("x", "y")]
        for pair in zip(places, velocities, strict=True)
    ]
    return np.array(rows)


def follow(text: str, first: int, times: tuple[float, ...]) -> np.ndarray:
    """Run DynamO from time to time, each run from the configuration that the last one wrote.

    Parameters
    ----------
    text : configuration at the first time
    first : number of the first tracer

    Returns
    -------
    array (time, tracer, 4) of x, y, vx, vy; the box is not folded back, so x and y run on
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "0.xml"
        file.write_text(text)
        frames = [read_tracers(file, first)]
        for number, duration in enumerate(np.diff(times), 1):
            result = Path(folder) / f"{number}.xml"
            command = ["dynarun", "--unwrapped", "-f", repr(float(duration)), "-o", result, file]
            subprocess.run(command, cwd=folder, check=True, capture_output=True)
            frames.append(read_tracers(result, first))
            file = result
    return np.array(frames)


def run_dynamo(restitution: float, density: float, seed: int, media: int = MEDIA) -> np.ndarray:
    """Draw disks and tracers and follow them; rows of medium, tracer, time, x, y, vx, vy."""
    generator = np.random.default_rng(seed)
    side = math.sqrt(DISKS / density)
    rows = []
    for medium in range(media):
        free_places = FreePlaces(side, generator)
        disks = free_places.draw(DISKS, of_disks=True)
        places = free_places.draw(TRACERS, of_disks=False)
        velocities = generator.normal(size=(TRACERS, 2))
        text = fill_template(restitution, side, disks, places, velocities)
        frames = follow(text, DISKS, TIMES)
        frames[:, :, :2] -= frames[0, :, :2]
        for tracer in range(TRACERS):
            for time, state in zip(TIMES, frames[:, tracer], strict=True):
                rows.append([medium, medium * TRACERS + tracer, time, *state])
    return np.array(rows)


if __name__ == "__main__":
    restitution, density, seed, output = RESTITUTION, DENSITY, 1, FILE
    if len(sys.argv) > 1:
        restitution, density = float(sys.argv[1]), float(sys.argv[2])
        seed, output = int(sys.argv[3]), Path(sys.argv[4])
    write_tracks(run_dynamo(restitution, density, seed), output)
