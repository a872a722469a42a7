"""Where the scatterers stand. A medium is frozen data that validates itself when it is made."""

import csv
from dataclasses import dataclass, field
from math import isfinite, pi, sqrt
from os import PathLike
from typing import Any, ClassVar, Literal

import numpy as np

from particles.values import Value

# Random sequential addition jams at an area fraction of 0.547, and close to it the number of
# attempts per disk diverges. In d^-2; an area fraction of 0.51.
LARGEST_RSA_DENSITY = 0.65
# In the unbounded plane the series for the density kept is good to 0.2 % up to here (tests).
LARGEST_PLANE_DENSITY = {"HardDisks": 0.3, "Poisson": 1.0}
# Scatterers that a cell lists on average. Speed depends on it, results do not;
# tests/particles/measurements/kernel_speed.py measures the speed at several values.
LISTED = 5.0
# At lower densities flights are so long that too few digits of the impact parameter are exact.
LEAST_DENSITY = 1e-10  # in d^-2
# In d. One flight must not meet a scatterer and its own image; a few diameters are enough.
SMALLEST_BOX = 4.0


def _positive(name: str, value: Any) -> None:
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not (number and isfinite(value) and value > 0):
        raise ValueError(f"{name} = {value!r}: must be a positive finite number")


def _whole(name: str, value: Any, least: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        kind = "a positive whole number" if least else "a whole number, not negative"
        raise ValueError(f"{name} = {value!r}: must be {kind}")


def _not_too_thin(name: str, value: float, in_diameters: float) -> None:
    if not in_diameters >= LEAST_DENSITY:
        raise ValueError(
            f"{name} = {value!r}: {in_diameters:.3g} scatterers per d^2; at least "
            f"{LEAST_DENSITY:g}, below use BoltzmannGrad, which is the limit"
        )


@dataclass(frozen=True)
class _Random:
    number_density: float
    count: int = 40_000
    diameter: float = 1.0
    box: Literal["periodic"] | None = "periodic"
    overlapping: ClassVar[bool]
    listed: ClassVar[float] = LISTED  # of a periodic box; for the benchmark, which varies it

    def __post_init__(self) -> None:
        _positive("number_density", self.number_density)
        _positive("diameter", self.diameter)
        _whole("count", self.count, 1)
        _not_too_thin("number_density", self.number_density, self.number_density * self.diameter**2)
        if self.box not in ("periodic", None):
            raise ValueError(f"box = {self.box!r}: must be 'periodic', or None for the plane")
        name = type(self).__name__
        if self.box is None:
            largest = LARGEST_PLANE_DENSITY[name] / self.diameter**2
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

    No disk lies within d of the box's centre, or the plane's origin, where tracers start.
    ValueError where an argument is not positive, the box is smaller than 4 d, or the density is
    lower than 1e-10 d^-2 or higher than 0.65 d^-2 (0.3 d^-2 in the plane).
    """

    equilibrate: int = 0
    overlapping = False

    def __post_init__(self) -> None:
        super().__post_init__()
        _whole("equilibrate", self.equilibrate, 0)
        if self.equilibrate and self.box is None:
            raise ValueError(f"equilibrate = {self.equilibrate}: needs box = 'periodic'")
        largest = LARGEST_RSA_DENSITY / self.diameter**2
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
    """

    overlapping = True


@dataclass(frozen=True)
class BoltzmannGrad:
    """No scatterers: exponential free paths of mean 1/(2 d rho0) and uniform impact parameters.

    The particle method of the kinetic equation itself (paper, eq. inelaslorentz2): the limit of
    number_density -> 0 at a given mean free path, without recollisions.
    """

    number_density: float
    diameter: float = 1.0

    def __post_init__(self) -> None:
        _positive("number_density", self.number_density)
        _positive("diameter", self.diameter)
        in_diameters = self.number_density * self.diameter * self.diameter
        if not 0.0 < in_diameters < float("inf") or 0.5 / in_diameters == float("inf"):
            raise ValueError(
                f"number_density = {self.number_density!r}: {in_diameters:.3g} scatterers per d^2 "
                f"at diameter = {self.diameter!r}; must be a positive finite number"
            )


@dataclass(frozen=True, eq=False, repr=False)
class Positions(Value):
    """Scatterers where the user says, in a periodic square box; they may overlap.

    positions (count, 2), the same in every configuration, or (media, count, 2), one set for each.
    box_side: side of the box, in the unit of the positions; coordinates are taken modulo it.
    start: where tracers start, the box's centre if not given. ValueError if a scatterer covers it
    (is nearer than the diameter), if a position is not finite, or if the box is smaller than 4 d or
    holds fewer than 1e-10 scatterers per d^2.

    With one set for all configurations, these differ only in their tracers, and errors are those
    of the mean over tracers in this one medium.
    """

    positions: np.ndarray
    box_side: float
    diameter: float = 1.0
    start: tuple[float, float] | None = None
    number_density: float = field(init=False)

    def __post_init__(self) -> None:
        _positive("box_side", self.box_side)
        _positive("diameter", self.diameter)
        if self.box_side < SMALLEST_BOX * self.diameter:
            raise ValueError(
                f"box_side = {self.box_side}: must be at least {SMALLEST_BOX:g} d = "
                f"{SMALLEST_BOX * self.diameter:g}"
            )
        try:
            array = np.array(self.positions, dtype=np.float64)
        except (TypeError, ValueError):
            raise ValueError("positions: must be an array of numbers") from None
        if array.ndim not in (2, 3) or array.shape[-1] != 2 or array.size == 0:
            raise ValueError(
                f"positions of shape {array.shape}: must be (count, 2) or (media, count, 2)"
            )
        bad = np.argwhere(~np.isfinite(array).all(axis=-1))
        if len(bad):
            raise ValueError(f"positions[{bad[0][-1]}] = {array[tuple(bad[0])]}: must be finite")
        start = (self.box_side / 2,) * 2 if self.start is None else self.start
        origin = np.array(start, dtype=np.float64)
        if origin.shape != (2,) or not np.isfinite(origin).all():
            raise ValueError(f"start = {self.start!r}: must be two finite numbers")
        # Relative to the start, in (-box/2, box/2): the nearest image.
        offset = array - origin
        offset -= self.box_side * np.round(offset / self.box_side)
        distance = np.hypot(offset[..., 0], offset[..., 1])
        covering = np.argwhere(distance < self.diameter)
        if len(covering):
            raise ValueError(
                f"positions[{covering[0][-1]}] = {array[tuple(covering[0])]}: covers the start "
                f"({origin[0]:g}, {origin[1]:g}), which must be at least {self.diameter:g} away"
            )
        density = array.shape[-2] / self.box_side**2
        _not_too_thin("box_side", self.box_side, density * self.diameter**2)
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

        Raises ValueError, naming the line, for one that does not hold two numbers.
        """
        rows = []
        with open(path, newline="", encoding="utf-8") as file:
            for number, row in enumerate(csv.reader(file), 1):
                if not row:
                    continue
                try:
                    x, y = (float(cell) for cell in row)
                except ValueError:
                    if number == 1:
                        continue
                    raise ValueError(f"{path}, line {number}: {row} must be two numbers") from None
                rows.append((x, y))
        if not rows:
            raise ValueError(f"{path}: holds no positions")
        return cls(np.array(rows), box_side, diameter, start)

    @property
    def count(self) -> int:
        """Number of scatterers in the box."""
        return int(self.positions.shape[-2])

    @property
    def sets(self) -> int | None:
        """Number of sets of positions, None if all configurations share one."""
        return len(self.positions) if self.positions.ndim == 3 else None


Medium = HardDisks | Poisson | BoltzmannGrad | Positions
