"""Where the scatterers stand. A medium is frozen data that validates itself when it is made."""

from dataclasses import dataclass
from math import isfinite, pi, sqrt
from typing import ClassVar

# Random sequential addition jams at an area fraction of 0.547; the last percents take for ever.
LARGEST_RSA_DENSITY = 0.65  # in d^-2, an area fraction of 0.51
# A tracer must not meet a scatterer and its image in one flight: a few diameters.
SMALLEST_BOX = 4.0


def _positive(name: str, value: float) -> None:
    if not (isinstance(value, (int, float)) and isfinite(value) and value > 0):
        raise ValueError(f"{name} = {value!r}: must be a positive finite number")


@dataclass(frozen=True, kw_only=False)
class _Random:
    """Scatterers at random in a periodic square box of side sqrt(count / number_density).

    number_density per unit area, diameter d of a scatterer and of the tracer, in the same unit of
    length. Raises ValueError where one is not positive or the box is smaller than 4 d.
    """

    number_density: float
    count: int = 40_000
    diameter: float = 1.0
    overlapping: ClassVar[bool]

    def __post_init__(self) -> None:
        _positive("number_density", self.number_density)
        _positive("diameter", self.diameter)
        if isinstance(self.count, bool) or not isinstance(self.count, int) or self.count < 1:
            raise ValueError(f"count = {self.count!r}: must be a positive whole number")
        if self.box < SMALLEST_BOX * self.diameter:
            raise ValueError(
                f"count = {self.count}: the box would be {self.box / self.diameter:.3g} d wide at "
                f"number_density = {self.number_density}; it must be at least {SMALLEST_BOX:g} d"
            )

    @property
    def box(self) -> float:
        """Side of the periodic box."""
        return sqrt(self.count / self.number_density)

    @property
    def area_fraction(self) -> float:
        """Area of the scatterers over the area of the box, overlaps counted twice."""
        return pi / 4 * self.number_density * self.diameter**2


@dataclass(frozen=True)
class HardDisks(_Random):
    """Disks that do not overlap, by random sequential addition in a periodic square box.

    As in the paper's section 2. No disk lies within d of the box's centre, where tracers start.
    `number_density` up to 0.65 d^-2; ValueError beyond, and where a box cannot be filled.
    """

    overlapping = False

    def __post_init__(self) -> None:
        super().__post_init__()
        largest = LARGEST_RSA_DENSITY / self.diameter**2
        if self.number_density > largest:
            raise ValueError(
                f"number_density = {self.number_density}: disks cannot be placed at random so "
                f"densely; at most {largest:g} for diameter = {self.diameter}"
            )


@dataclass(frozen=True)
class Poisson(_Random):
    """Scatterers placed without regard to one another; they may overlap.

    None lies within d of the box's centre, where tracers start. Their number is `count` exactly.
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


Medium = HardDisks | Poisson | BoltzmannGrad
