"""Where the scatterers stand. A medium is frozen data that validates itself when it is made."""

from dataclasses import dataclass, field
from math import cbrt, pi, sqrt
from os import PathLike
from typing import ClassVar, Literal, get_args

import numpy as np

from particles.checks import check_positive, check_whole, real_array, refuse
from particles.position_file import read_positions
from particles.results import Value

# Random sequential addition jams at an area fraction of 0.547, and close to it the number of
# attempts per disk diverges. In d^-2; an area fraction of 0.51. Spheres jam at a volume fraction of
# 0.384; for them the same number is in d^-3, a volume fraction of 0.34.
LARGEST_RSA_DENSITY = 0.65
# Overlapping spheres, in d^-3: cells of unbounded space list 100 of them. The places that a tracer
# can be at are no longer connected above 0.84.
LARGEST_POISSON_DENSITY = 1.0
# In the unbounded plane the series for the density kept is good to 0.2 % up to here (tests).
LARGEST_PLANE_DENSITY = {"HardDisks": 0.3, "Poisson": 1.0}
# Scatterers that a cell lists on average. Speed depends on it, results do not;
# tests/particles/measurements/kernel_speed.py measures the speed at several values.
LISTED = 5.0
# At lower densities flights are so long that too few digits of the impact parameter are exact.
LEAST_DENSITY = 1e-10  # in d^-2, or d^-3
FARTHEST = 1e12  # boxes; a coordinate so far away, modulo the box, has four digits left
# In d. One flight must not meet a scatterer and its own image; a few diameters are enough.
SMALLEST_BOX = 4.0
LARGEST_COUNT = 10**15  # what a run has memory for is far less; it says so


def _not_too_thin(name: str, value: float, in_diameters: float, dimension: int = 2) -> None:
    if not in_diameters >= LEAST_DENSITY:
        raise ValueError(
            f"{name} = {value!r}: {in_diameters:.3g} scatterers per d^{dimension}; at least "
            f"{LEAST_DENSITY:g}, below use BoltzmannGrad, which is the limit"
        )


@dataclass(frozen=True)
class _Random:
    dimension: ClassVar[int] = 2
    number_density: float
    count: int = 40_000
    diameter: float = 1.0
    box: Literal["periodic"] | None = "periodic"
    overlapping: ClassVar[bool]
    listed: ClassVar[float] = LISTED  # of a periodic box; kernel_speed.py varies it

    def __post_init__(self) -> None:
        density = check_positive("number_density", self.number_density)
        d = check_positive("diameter", self.diameter)
        check_whole("count", self.count, 1, LARGEST_COUNT)
        _not_too_thin("number_density", self.number_density, density * d * d)
        if self.box is not None and not (isinstance(self.box, str) and self.box == "periodic"):
            refuse("box", self.box, "must be 'periodic', or None for the plane")
        name = type(self).__name__
        if self.box is None:
            largest = LARGEST_PLANE_DENSITY[name] / (d * d)
            if self.number_density > largest:
                raise ValueError(
                    f"number_density = {self.number_density}: at most {largest:g} in the unbounded "
                    f"plane for {name} of diameter = {self.diameter}"
                )
        elif self.box_side < SMALLEST_BOX * self.diameter:
            raise ValueError(
                f"count = {self.count}: the box would be {self.box_side / self.diameter:.3g} d "
                f"wide at number_density = {self.number_density}; it must be at least "
                f"{SMALLEST_BOX:g} d"
            )

    @property
    def box_side(self) -> float:
        """Side of the periodic box, sqrt(count / number_density); infinite without one."""
        return sqrt(self.count / self.number_density) if self.box else float("inf")

    @property
    def area_fraction(self) -> float:
        """Area of the scatterers per unit area, overlaps counted as often as they occur."""
        return pi / 4 * self.number_density * self.diameter**2


@dataclass(frozen=True)
class HardDisks(_Random):
    """Disks that do not overlap, placed by random sequential addition (paper, section 2).

    number_density: disks per unit area. count: their number in the periodic square box, of side
    sqrt(count / number_density). diameter d of a disk and of the tracer, in the unit of length
    that density, times and results share. box=None: an unbounded plane instead, made where a
    tracer goes (count is not used). equilibrate: sweeps of Monte Carlo moves (Metropolis, one
    attempt per disk each) after the placement, periodic box only.

    No disk lies within d of the box's centre, or the plane's origin, where tracers start. It is
    kept free while the disks are placed, as if the tracer were the first of them, so that slightly
    fewer stand beside it than beside a place that is found free afterwards: within 1.25 d of it
    1.6 % fewer at 0.04 d^-2, 15 % at 0.2 d^-2, and so many fewer first flights end there.
    After `equilibrate` there is no difference.

    In a field along x the disks nearer than 2 d to each other leave corners for a tracer's centre;
    one that opens against the field is a trap, in which inelastic tracers come to rest.
    ValueError where an argument is not positive, the box is smaller than 4 d, or the density is
    lower than 1e-10 d^-2 or higher than 0.65 d^-2 (0.3 d^-2 in the plane).
    """

    equilibrate: int = 0
    overlapping = False

    def __post_init__(self) -> None:
        super().__post_init__()
        check_whole("equilibrate", self.equilibrate, 0, 2**31)
        if self.equilibrate and self.box is None:
            raise ValueError(f"equilibrate = {self.equilibrate}: needs box = 'periodic'")
        d = float(self.diameter)
        largest = LARGEST_RSA_DENSITY / (d * d)
        if self.number_density > largest:
            raise ValueError(
                f"number_density = {self.number_density}: disks cannot be placed at random so "
                f"densely; at most {largest:g} for diameter = {self.diameter}"
            )


@dataclass(frozen=True)
class Poisson(_Random):
    """Scatterers placed without regard to one another; they may overlap.

    Arguments as of HardDisks. Their number in a periodic box is `count` exactly; in the plane
    (box=None, density at most 1 d^-2) it is Poisson in any area. None lies within d of the start.
    In a field, corners that open against it are traps, pi rho0^2 d^2 exp(-pi rho0 d^2) of them per
    unit area, each of which may hold many tracers.
    """

    overlapping = True


@dataclass(frozen=True)
class _Spheres:
    dimension: ClassVar[int] = 3
    number_density: float
    diameter: float = 1.0
    count: int | None = 40_000
    largest_density: ClassVar[float]  # in d^-3

    def __post_init__(self) -> None:
        density = check_positive("number_density", self.number_density)
        d = check_positive("diameter", self.diameter)
        in_diameters = density * d * d * d
        _not_too_thin("number_density", self.number_density, in_diameters, dimension=3)
        if in_diameters > self.largest_density:
            raise ValueError(
                f"number_density = {self.number_density}: at most "
                f"{self.largest_density / d**3:g} for {type(self).__name__} of diameter = {d:g}"
            )
        if self.count is None:
            return
        check_whole("count", self.count, 1, LARGEST_COUNT)
        if self.box_side < SMALLEST_BOX * d:
            raise ValueError(
                f"count = {self.count}: the box would be {self.box_side / d:.3g} d wide at "
                f"number_density = {self.number_density}; it must be at least {SMALLEST_BOX:g} d"
            )

    @property
    def box_side(self) -> float:
        """Side of the periodic box, (count / number_density)^(1/3); infinite without one."""
        return cbrt(self.count / self.number_density) if self.count else float("inf")

    @property
    def volume_fraction(self) -> float:
        """Volume of the spheres per unit volume, overlaps counted as often as they occur."""
        return pi / 6 * self.number_density * self.diameter**3


@dataclass(frozen=True)
class HardSpheres(_Spheres):
    """Spheres in three dimensions that do not overlap, placed by random sequential addition.

    number_density: spheres per unit volume. diameter d of a sphere and of the tracer, in the unit
    of length that density, times and results share. count: their number in the periodic cubic box,
    of side (count / number_density)^(1/3). equilibrate: sweeps of Monte Carlo moves (Metropolis,
    one attempt per sphere each) after the placement.

    No sphere lies within d of the box's centre, where tracers start; beside it slightly fewer stand
    than beside a place found free afterwards, unless equilibrated, as HardDisks says of disks.
    ValueError where an argument is not positive, the box is smaller than 4 d, or the density is
    lower than 1e-10 d^-3 or higher than 0.65 d^-3.
    """

    count: int = 40_000
    equilibrate: int = 0
    largest_density = LARGEST_RSA_DENSITY

    def __post_init__(self) -> None:
        check_whole("count", self.count, 1, LARGEST_COUNT)
        super().__post_init__()
        check_whole("equilibrate", self.equilibrate, 0, 2**31)


@dataclass(frozen=True)
class PoissonSpheres(_Spheres):
    """Spheres in three dimensions, placed without regard to one another; they may overlap.

    Arguments as of HardSpheres; the density is 1 d^-3 at most. count=None: unbounded space instead
    of a periodic box, made where a tracer goes; it takes several times as long, because tracers
    leave most of what is made for them behind. None of the spheres lies within d of the start.
    """

    largest_density = LARGEST_POISSON_DENSITY


@dataclass(frozen=True)
class BoltzmannGrad:
    """No scatterers: exponential free paths, and impact parameters as a dilute gas has them.

    The particle method of the kinetic equation itself (paper, eq. inelaslorentz2): the limit of
    number_density -> 0 at a given mean free path, without recollisions.

    dimension 2: disks, number_density per unit area, free paths of mean 1/(2 d rho0), the impact
    parameter uniform. dimension 3: spheres, number_density per unit volume, mean 1/(pi d^2 rho0),
    the impact parameter uniform in the disk across the velocity. ValueError where dimension is
    another number or a number is not positive and finite.
    """

    number_density: float
    diameter: float = 1.0
    dimension: Literal[2, 3] = 2

    def __post_init__(self) -> None:
        if type(self.dimension) is not int or self.dimension not in (2, 3):
            refuse("dimension", self.dimension, "must be 2 or 3")
        d = check_positive("diameter", self.diameter)
        in_diameters = check_positive("number_density", self.number_density) * d * d
        if self.dimension == 3:
            in_diameters *= d
        if not 0.0 < in_diameters < float("inf") or 0.5 / in_diameters == float("inf"):
            raise ValueError(
                f"number_density = {self.number_density!r}: {in_diameters:.3g} scatterers per "
                f"d^{self.dimension} at diameter = {self.diameter!r}; must be a positive finite "
                f"number"
            )


@dataclass(frozen=True, eq=False, repr=False)
class Positions(Value):
    """Scatterers where the user says, in a periodic square box; they may overlap.

    positions (count, 2), the same in every configuration, or (media, count, 2), one set for each.
    box_side: side of the box, in the unit of the positions; coordinates are taken modulo it.
    start: where tracers start, the box's centre if not given. ValueError if a scatterer covers it
    (is nearer than the diameter), if a position is not finite, or if the box is smaller than 4 d or
    holds fewer than 1e-10 scatterers per d^2. Where the start is the box's centre, only the first
    tracer of a run from rest begins there, the others at random free places (`simulate`).

    With one set for all configurations, these differ only in their tracers, and errors are those
    of the mean over tracers in this one medium.
    """

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
            allowed = f"must be at least {SMALLEST_BOX:g} d = {SMALLEST_BOX * d:g}"
            refuse("box_side", self.box_side, allowed)
        array = real_array("positions", self.positions, "must be an array of real numbers")
        if array.ndim not in (2, 3) or array.shape[-1] != 2 or array.size == 0:
            raise ValueError(
                f"positions of shape {array.shape}: must be (count, 2) or (media, count, 2)"
            )
        bad = np.argwhere(~np.isfinite(array).all(axis=-1))
        if len(bad):
            raise ValueError(f"positions[{bad[0][-1]}] = {array[tuple(bad[0])]}: must be finite")
        start = (box / 2,) * 2 if self.start is None else self.start
        origin = real_array("start", start, "must be two finite numbers")
        if origin.shape != (2,) or not np.isfinite(origin).all():
            refuse("start", self.start, "must be two finite numbers")
        far = np.argwhere((abs(array) > FARTHEST * box).any(axis=-1))
        if len(far) or abs(origin).max() > FARTHEST * box:
            where = f"positions[{far[0][-1]}] = {array[tuple(far[0])]}" if len(far) else "start"
            raise ValueError(f"{where}: more than {FARTHEST:g} boxes away, beyond their digits")
        # Relative to the start, in (-box/2, box/2): the nearest image.
        offset = array - origin
        offset -= box * np.round(offset / box)
        distance = np.hypot(offset[..., 0], offset[..., 1])
        covering = np.argwhere(distance < d)
        if len(covering):
            raise ValueError(
                f"positions[{covering[0][-1]}] = {array[tuple(covering[0])]}: covers the start "
                f"({origin[0]:g}, {origin[1]:g}), which must be at least {self.diameter:g} away"
            )
        density = array.shape[-2] / (box * box)
        _not_too_thin("box_side", self.box_side, density * d * d)
        object.__setattr__(self, "positions", array)
        object.__setattr__(self, "start", (float(origin[0]), float(origin[1])))
        object.__setattr__(self, "number_density", density)
        super().__post_init__()

    def __repr__(self) -> str:
        shape = " x ".join(str(n) for n in self.positions.shape)
        return (
            f"Positions(<{shape} numbers>, box_side={self.box_side!r}, "
            f"diameter={self.diameter!r}, start={self.start!r})"
        )

    @classmethod
    def from_csv(
        cls, path: str | PathLike[str], box_side: float, diameter: float = 1.0,
        start: tuple[float, float] | None = None,
    ) -> "Positions":  # fmt: skip
        """Read positions from a CSV file of two columns, x and y; one header line may precede.

        Raises ValueError, naming the line, for one that does not hold two numbers, and for a file
        that cannot be read or is not text.
        """
        return cls(read_positions(path), box_side, diameter, start)

    @property
    def count(self) -> int:
        """Number of scatterers in the box."""
        return int(self.positions.shape[-2])

    @property
    def sets(self) -> int | None:
        """Number of sets of positions, None if all configurations share one."""
        return len(self.positions) if self.positions.ndim == 3 else None


Medium = HardDisks | Poisson | HardSpheres | PoissonSpheres | BoltzmannGrad | Positions
MEDIA: tuple[type, ...] = get_args(Medium)


def dilute_mean_path(medium: Medium) -> float:
    """Return the mean free path in d of a dilute medium of this density."""
    d = medium.diameter
    in_diameters = medium.number_density * d * d
    return 1.0 / (pi * in_diameters * d) if medium.dimension == 3 else 0.5 / in_diameters
