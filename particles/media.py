"""Where the scatterers stand. A medium is frozen data that validates itself when it is made."""

import os
from dataclasses import dataclass, field
from math import cbrt, pi, sqrt
from os import PathLike
from typing import ClassVar, Literal, get_args

import numpy as np

from particles.values import (
    Value,
    check_number,
    check_path,
    check_positive,
    check_whole,
    machine_memory,
    real_array,
    refuse,
    set_fields,
    shown_path,
)

#: Least density in d^-2, or d^-3. Derived: at lower ones flights are so long that too few digits of
#: the impact parameter are exact.
LEAST_DENSITY = 1e-10
#: Farthest coordinate of a scatterer, in boxes. Derived: modulo the box, it has four digits left.
FARTHEST = 1e12
#: Smallest side of a box, in d and in exclusions. Chosen: one flight must not meet a scatterer and
#: its own image; a few diameters are enough.
SMALLEST_BOX = 4.0
#: Density times exclusion^dimension of hard scatterers up to which they can be placed: 0.51 of the
#: area, or 0.34 of the volume. Measured: random sequential addition jams at 0.547, or 0.384, and
#: close to that the number of attempts diverges.
LARGEST_PACKING = 0.65
#: Largest density of spheres in d^-3. Measured: above 0.84 the places that a tracer can be at are
#: not connected.
LARGEST_SPHERE_DENSITY = 1.0
#: Bytes of memory for a byte of a CSV file of positions at most. Derived: the line "1,2" is a text
#: of 61 bytes and two numbers.
MEMORY_OF_TEXT = 20
#: Share of the memory that reading such a file may take. Chosen: the run needs some, too.
SHARE_FOR_TEXT = 0.25
#: Largest exclusion in d. Derived: of a tracer that is a point, d is half a scatterer's diameter.
LARGEST_EXCLUSION = 2.0


def _require_density(name: str, value: float, in_diameters: float, dimension: int = 2) -> None:
    if not in_diameters >= LEAST_DENSITY:
        allowed = f"{LEAST_DENSITY:g} per d^{dimension} or more; below use BoltzmannGrad, the limit"
        refuse(name, value, f"in units of d it is {in_diameters:.3g}, it must be {allowed}")


class Random:
    """What scatterers at random places in a periodic box share.

    `diameter` d: distance at which a tracer collides; `spacing`: least distance between two
    scatterers.
    """

    number_density: float
    diameter: float
    count: int
    dimension: ClassVar[int]

    def __post_init__(self) -> None:
        density = check_positive("number_density", self.number_density)
        d = check_positive("diameter", self.diameter)
        count = check_whole("count", self.count, 1)
        set_fields(self, number_density=density, diameter=d, count=count)
        in_diameters = density * d * d
        if self.dimension == 3:
            in_diameters *= d
        _require_density("number_density", self.number_density, in_diameters, self.dimension)
        self._require_room(in_diameters)
        if self.box_side < SMALLEST_BOX * d:
            wide = f"with it the box is {self.box_side / d:.3g} d wide"
            refuse("count", self.count, f"{wide}, it must be at least {SMALLEST_BOX:g} d")

    def _require_room(self, in_diameters: float) -> None:
        """Refuse a density, also in units of d, that leaves a tracer no room."""
        if self.dimension == 3:
            self._require_at_most(in_diameters, LARGEST_SPHERE_DENSITY)

    def _require_at_most(self, density: float, largest: float) -> None:
        """Refuse a density that, in some unit, is larger than it may be."""
        if density > largest:
            limit = largest / density * self.number_density
            allowed = f"it must be at most {limit:g} for {type(self).__name__} of diameter "
            allowed += f"{self.diameter:g}"
            if self.spacing not in (0.0, self.diameter):
                allowed += f" and exclusion {self.spacing:g}"
            refuse("number_density", self.number_density, allowed)

    @property
    def box_side(self) -> float:
        """Side of the periodic box, (count / number_density)^(1/dimension)."""
        volume = self.count / self.number_density
        return sqrt(volume) if self.dimension == 2 else cbrt(volume)

    @property
    def share_of_space(self) -> float:
        """Area, or volume, of the scatterers over that of space, overlaps counted twice."""
        of_unit_diameter = pi / 4 if self.dimension == 2 else pi / 6
        return of_unit_diameter * self.number_density * self.own_diameter**self.dimension

    @property
    def spacing(self) -> float:
        """Least distance between two scatterers, in the unit of length of the medium."""
        return 0.0

    @property
    def own_diameter(self) -> float:
        """Diameter of a scatterer, in the unit of length of the medium."""
        return self.diameter


class Hard(Random):
    """What scatterers share that keep a distance from each other."""

    exclusion: float | None
    name_of_equal: ClassVar[str]  # where tracers have the size of scatterers

    def __post_init__(self) -> None:
        d = check_positive("diameter", self.diameter)
        exclusion = d
        if self.exclusion is not None:
            largest = LARGEST_EXCLUSION * d
            allowed = (
                f"it must be a number from 0 to {LARGEST_EXCLUSION:g} d = {largest:g}, or None"
            )
            exclusion = check_number("exclusion", self.exclusion, 0.0, largest, allowed)
        set_fields(self, exclusion=exclusion)
        super().__post_init__()
        if self.box_side < SMALLEST_BOX * exclusion:
            wide = f"with it the box is {self.box_side / exclusion:.3g} exclusions wide"
            refuse("count", self.count, f"{wide}, it must be at least {SMALLEST_BOX:g}")

    def _require_room(self, in_diameters: float) -> None:
        """Refuse a density at which the scatterers, or a tracer, have no room."""
        packing = self.number_density * self.spacing * self.spacing
        if self.dimension == 3:
            packing *= self.spacing
        self._require_at_most(packing, LARGEST_PACKING)
        super()._require_room(in_diameters)

    @property
    def scatterers(self) -> str:
        """The medium as a Scene of `kinetics` and the command line call it."""
        if self.exclusion == self.diameter:
            return self.name_of_equal
        return f"{self.name_of_equal} of another size"

    @property
    def spacing(self) -> float:
        """Least distance between two scatterers: the exclusion."""
        assert self.exclusion is not None  # since __post_init__
        return self.exclusion

    @property
    def own_diameter(self) -> float:
        """Diameter of a scatterer, in the unit of length of the medium: the exclusion."""
        return self.spacing


@dataclass(frozen=True)
class HardDisks(Hard):
    """Disks that do not overlap, placed by random sequential addition (paper, section 2).

    number_density: disks per unit area, 1e-10 to 0.65 d^-2. count: their number in the periodic
    square box, whose side is at least 4 d. diameter d of a disk and of the tracer, in the unit of
    length that density, times and results share: a tracer collides where its centre is at this
    distance from that of a disk. exclusion: the least distance between two disks, which is their
    own diameter where tracers have another size (d is then half the sum of both); 0 to 2 d, and
    number_density <= 0.65 exclusion^-2; d if None. With 0 the medium is that of Poisson. A tracer
    that is never farther from its start than
    half the side of the box has the same path as in an unbounded plane.

    No disk lies within d of the box's centre, where tracers start. It is kept free while the disks
    are placed, so that slightly fewer stand beside it than beside a place that is found free
    afterwards: within 1.25 d of it 1.6 % fewer at 0.04 d^-2, 15 % at 0.2 d^-2.

    In a field along x the disks nearer than 2 d to each other leave corners for a tracer's centre;
    one that opens against the field is a trap, in which inelastic tracers come to rest.
    """

    number_density: float
    count: int = 40_000
    diameter: float = 1.0
    exclusion: float | None = None
    name_of_equal: ClassVar[str] = "hard disks"
    dimension: ClassVar[int] = 2

    area_fraction = Random.share_of_space


@dataclass(frozen=True)
class Poisson(Random):
    """Scatterers placed without regard to one another; they may overlap.

    Arguments as of HardDisks. Their number in the periodic box is `count` exactly. None lies within
    d of the start. In a field, corners that open against it are traps,
    pi rho0^2 d^2 exp(-pi rho0 d^2) of them per unit area, each of which may hold many tracers.
    """

    number_density: float
    count: int = 40_000
    diameter: float = 1.0
    scatterers: ClassVar[str] = "overlapping disks"
    dimension: ClassVar[int] = 2

    area_fraction = Random.share_of_space


@dataclass(frozen=True)
class HardSpheres(Hard):
    """Spheres in three dimensions that do not overlap, placed by random sequential addition.

    Arguments as of HardDisks, per unit volume, in a cubic box (number_density <= 0.65 exclusion^-3,
    and 1 d^-3); so is what it says of the places beside the start.
    """

    number_density: float
    diameter: float = 1.0
    count: int = 40_000
    exclusion: float | None = None
    name_of_equal: ClassVar[str] = "hard spheres"
    dimension: ClassVar[int] = 3

    volume_fraction = Random.share_of_space


@dataclass(frozen=True)
class PoissonSpheres(Random):
    """Spheres in three dimensions, placed without regard to one another; they may overlap.

    Arguments as of HardDisks; at most 1 d^-3. None lies within d of the start.
    """

    number_density: float
    diameter: float = 1.0
    count: int = 40_000
    scatterers: ClassVar[str] = "overlapping spheres"
    dimension: ClassVar[int] = 3

    volume_fraction = Random.share_of_space


@dataclass(frozen=True)
class BoltzmannGrad:
    """No scatterers: exponential free paths, and impact parameters as a dilute gas has them.

    The particle method of the kinetic equation itself (paper, eq. inelaslorentz2): the limit of
    number_density -> 0 at a given mean free path, without recollisions. dimension 2: disks, free
    paths of mean 1/(2 d rho0), the impact parameter uniform. dimension 3: spheres, mean
    1/(pi d^2 rho0), the impact parameter uniform in the disk across the velocity.
    """

    number_density: float
    diameter: float = 1.0
    dimension: Literal[2, 3] = 2
    scatterers: ClassVar[str] = "dilute"

    def __post_init__(self) -> None:
        dimension = check_whole("dimension", self.dimension, 2, 3)
        density = check_positive("number_density", self.number_density)
        d = check_positive("diameter", self.diameter)
        set_fields(self, number_density=density, diameter=d, dimension=dimension)
        in_diameters = density * d * d
        if dimension == 3:
            in_diameters *= d
        if not 0.0 < in_diameters < float("inf") or 0.5 / in_diameters == float("inf"):
            allowed = f"in units of d it is {in_diameters:.3g}, it must be above 0 and finite"
            refuse("number_density", self.number_density, allowed)


@dataclass(frozen=True, eq=False, repr=False)
class Positions(Value):
    """Scatterers where the user says, in a periodic square box; they may overlap.

    positions (count, 2), the same in every configuration, or (media, count, 2), one set for each.
    box_side: side of the box, 4 d or more, in the unit of the positions; coordinates are taken
    modulo it. start: where tracers start, the box's centre if not given; no scatterer may be nearer
    than d. Where it is the box's centre, only the first tracer of a run from rest begins there, the
    others at random free places (`simulate`).

    With one set for all configurations, these differ only in their tracers, and errors are those
    of the mean over tracers in this one medium.
    """

    scatterers: ClassVar[str] = "positions"
    dimension: ClassVar[int] = 2
    positions: np.ndarray
    box_side: float
    diameter: float = 1.0
    start: tuple[float, float] | None = None
    number_density: float = field(init=False)

    def __post_init__(self) -> None:
        box = check_positive("box_side", self.box_side)
        d = check_positive("diameter", self.diameter)
        if box < SMALLEST_BOX * d:
            allowed = f"it must be at least {SMALLEST_BOX:g} d = {SMALLEST_BOX * d:g}"
            refuse("box_side", self.box_side, allowed)
        allowed = "it must be real numbers of shape (count, 2) or (media, count, 2)"
        array = real_array("positions", self.positions, allowed)
        if array.ndim not in (2, 3) or array.shape[-1] != 2 or array.size == 0:
            refuse("positions", self.positions, allowed)
        start = (box / 2,) * 2 if self.start is None else self.start
        origin = real_array("start", start, "it must be two finite numbers")
        if origin.shape != (2,) or not abs(origin).max() <= FARTHEST * box:
            allowed = f"it must be two finite numbers, at most {FARTHEST:g} boxes away"
            refuse("start", self.start, allowed)

        is_near = np.asarray(np.all(abs(array) <= FARTHEST * box, axis=-1))
        _require_positions(array, is_near, f"it must be finite, at most {FARTHEST:g} boxes away")
        offset = array - origin
        offset -= box * np.round(offset / box)  # from the start to the nearest image
        is_free = np.asarray(np.hypot(offset[..., 0], offset[..., 1]) >= d)
        covered = f"it covers the start {tuple(origin.tolist())}"
        _require_positions(array, is_free, f"{covered}; it must be {d:g} away or more")
        density = array.shape[-2] / (box * box)
        _require_density("box_side", self.box_side, density * d * d)
        start = tuple(origin.tolist())
        set_fields(self, positions=array, box_side=box, diameter=d, start=start)
        set_fields(self, number_density=density)
        super().__post_init__()

    def __repr__(self) -> str:
        shape = " x ".join(map(str, self.positions.shape))
        lengths = f"box_side={self.box_side!r}, diameter={self.diameter!r}, start={self.start!r}"
        return f"Positions(<{shape} numbers>, {lengths})"

    @classmethod
    def from_csv(
        cls, path: str | PathLike[str], box_side: float, diameter: float = 1.0,
        start: tuple[float, float] | None = None,
    ) -> "Positions":  # fmt: skip
        """Read positions from a CSV file of two columns, x and y; one header line may precede."""
        name = check_path("path", path)
        if os.path.exists(name) and not os.path.isfile(name):
            raise ValueError(
                f"{shown_path(name)}: is a folder, a device or a pipe; it must be a file"
            )
        _require_memory_for(name)
        try:
            with open(name, encoding="utf-8-sig") as file:
                lines = [line for line in file if line.strip()]
            if lines and _is_header(lines[0]):
                del lines[0]
            if not lines:
                raise ValueError("holds no positions")
            rows = np.loadtxt(lines, delimiter=",", quotechar='"', ndmin=2)
        except (OSError, ValueError) as error:  # of loadtxt with the row; what is no text in UTF-8
            problem = f"must be two columns of numbers ({error})"
            raise ValueError(f"{shown_path(name)}: {problem}") from None
        return cls(rows, box_side, diameter, start)

    @property
    def count(self) -> int:
        """Number of scatterers in the box."""
        return int(self.positions.shape[-2])

    @property
    def sets(self) -> int | None:
        """Number of sets of positions, None if all configurations share one."""
        return len(self.positions) if self.positions.ndim == 3 else None


def _require_positions(positions: np.ndarray, is_allowed: np.ndarray, allowed: str) -> None:
    """Refuse the first of the positions that is not allowed, if there is one."""
    refused = np.argwhere(~is_allowed)
    if len(refused):
        place = tuple(refused[0])
        refuse(f"positions[{place[-1]}]", positions[place].tolist(), allowed)


def _require_memory_for(path: str) -> None:
    """Raise ValueError for a file of text whose lines and numbers do not fit into the memory."""
    size = os.path.getsize(path) if os.path.exists(path) else 0
    needed = MEMORY_OF_TEXT * size
    available = machine_memory() * SHARE_FOR_TEXT
    if needed > available:
        problem = f"its text takes about {needed / 1e9:.2g} GB of memory"
        raise ValueError(f"{shown_path(path)}: {problem}; it may take {available / 1e9:.2g} GB")


def _is_header(line: str) -> bool:
    """Tell whether the first column of a line holds no digit."""
    first_column = line.split(",")[0]
    return not any(digit in first_column for digit in "0123456789")


Medium = HardDisks | Poisson | HardSpheres | PoissonSpheres | BoltzmannGrad | Positions
MEDIA: tuple[type, ...] = get_args(Medium)


def dilute_mean_path(medium: Medium) -> float:
    """Return the mean free path in d of a dilute medium of this density."""
    d = medium.diameter
    in_diameters = medium.number_density * d * d
    return 1.0 / (pi * in_diameters * d) if medium.dimension == 3 else 0.5 / in_diameters
