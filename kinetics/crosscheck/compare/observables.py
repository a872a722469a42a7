"""What is compared: `OBSERVABLES`, one row for each, in the order of the page.

An average is a function of means over tracers of powers of the speed and of the displacement (the
sums of a `Sample` over their number); a density is compared in bins (`densities`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.data.sample import R2, R4, V2, V4, VX, X2, Law, X

Array = NDArray[np.float64]

#: The name of the density of the speed.
SPEED_DENSITY = "speed_density"
#: The name of the density of the displacement.
DISPLACEMENT_DENSITY = "position_density"
#: The name of the mean square displacement between two frames, of tracks of positions alone.
BETWEEN_FRAMES = "displacement_between_frames"
#: The name of the mean speed, of tables of averages: of tracks <v^2> says the same.
MEAN_SPEED = "mean_speed"


class Where(Enum):
    """The systems in which an average is compared."""

    ANYWHERE = auto()
    WITHOUT_FIELD = auto()
    IN_FIELD = auto()
    #: In a field, and of tracers that all start along x.
    ALONG_X = auto()


class Shape(Enum):
    """The function of an average whose standard error hardly depends on the value.

    Means of squares of few tracers are skewed: where the mean is low by chance, so is its error.
    The logarithm of a second moment, and the power -3 of a ratio of a fourth moment to the square
    of a second, are close to Gaussian for a hundred tracers and more.
    """

    PLAIN = auto()
    LOGARITHM = auto()
    INVERSE_CUBE = auto()


@dataclass(frozen=True)
class Observable:
    """One row of the table of what is compared.

    Parameters
    ----------
    title, symbol, unit, text : how it is written: as a heading, in a formula, and in a sentence
    measure : maps the means over tracers, columns first, and the law to the average; None for what
        is not a function of these means
    where : the systems in which it is compared
    output : the name of the output of a Solution; empty if it is that of the row
    component : the component of that output
    shape : the function of it that is compared
    """

    title: str
    symbol: str
    unit: str
    text: str
    measure: Callable[[Array, Law], Array] | None = None
    where: Where = Where.WITHOUT_FIELD
    output: str = ""
    component: tuple[int, ...] = ()
    shape: Shape = Shape.PLAIN

    @property
    def offset(self) -> float:
        """What is added before an average is compared with its theory by their ratio: 1 to a2."""
        return 1.0 if self.symbol == "$a_2$" else 0.0


def _a2(means: Array, law: Law) -> Array:
    """Return the second Sonine coefficient, <v^4>/<v^2>^2 over that of a Gaussian less 1."""
    return np.asarray(means[V4] / (law.gaussian * means[V2] ** 2) - 1.0)


def _variance_across_field(means: Array, law: Law) -> Array:
    """Return the variance of a component across the field, whose mean is 0."""
    return np.asarray((means[R2] - means[X2]) / (law.dimension - 1))


OBSERVABLES: dict[str, Observable] = {
    "drift": Observable(
        title="Mean velocity along x",
        symbol=r"$\langle v_x\rangle$",
        unit="U",
        text="⟨v_x⟩",
        measure=lambda means, law: means[VX],
        where=Where.ALONG_X,
        output="mean_velocity",
        component=(0,),
    ),
    "thermal_speed": Observable(
        title="Thermal speed",
        symbol="$v_0$",
        unit="U",
        text="v₀",
        measure=lambda means, law: np.asarray(np.sqrt(means[V2])),
        where=Where.ANYWHERE,
        shape=Shape.LOGARITHM,
    ),
    "a2": Observable(
        title="Second Sonine coefficient",
        symbol="$a_2$",
        unit="",
        text="1 + a₂",
        measure=_a2,
        shape=Shape.INVERSE_CUBE,
    ),
    "msd": Observable(
        title="Mean square displacement",
        symbol=r"$\langle r^2\rangle$",
        unit="d²",
        text="⟨r²⟩",
        measure=lambda means, law: means[R2],
        shape=Shape.LOGARITHM,
    ),
    "kurtosis": Observable(
        title="Kurtosis of the displacement",
        symbol=r"$\langle r^4\rangle/\langle r^2\rangle^2$",
        unit="",
        text="⟨r⁴⟩/⟨r²⟩²",
        measure=lambda means, law: np.asarray(means[R4] / means[R2] ** 2),
        shape=Shape.INVERSE_CUBE,
    ),
    "mean_displacement": Observable(
        title="Mean displacement along x",
        symbol=r"$\langle x\rangle$",
        unit="d",
        text="⟨x⟩",
        measure=lambda means, law: means[X],
        where=Where.ALONG_X,
        component=(0,),
    ),
    "dispersion_parallel": Observable(
        title="Variance along the field",
        symbol="var $x$",
        unit="d²",
        text="var x",
        measure=lambda means, law: np.asarray(means[X2] - means[X] ** 2),
        where=Where.IN_FIELD,
        output="displacement_tensor",
        component=(0, 0),
    ),
    "dispersion_perpendicular": Observable(
        title="Variance across the field",
        symbol="var $y$",
        unit="d²",
        text="var y",
        measure=_variance_across_field,
        where=Where.IN_FIELD,
        output="displacement_tensor",
        component=(1, 1),
    ),
    MEAN_SPEED: Observable(
        title="Mean speed",
        symbol=r"$\langle v\rangle$",
        unit="U",
        text="⟨v⟩",
    ),
    BETWEEN_FRAMES: Observable(
        title="Mean square displacement between two frames",
        symbol=r"$\langle |r(t)-r(s)|^2\rangle$",
        unit="d²",
        text="⟨|r(t) − r(s)|²⟩",
        shape=Shape.LOGARITHM,
    ),
    SPEED_DENSITY: Observable(
        title="Speed density", symbol="speed $v$", unit="U", text="mean over a bin"
    ),
    DISPLACEMENT_DENSITY: Observable(
        title="Displacement density", symbol="displacement $r$", unit="d", text="mean over a bin"
    ),
}
"""Everything that is compared, in the order of the page: a new average is one row."""


def averages_of(law: Law, starts_along_x: bool = False) -> tuple[str, ...]:
    """Return the names of the averages over time that are compared under a law."""
    wanted = {Where.ANYWHERE, Where.WITHOUT_FIELD}
    if law.field:
        wanted = {Where.ANYWHERE, Where.IN_FIELD}
    if law.field or starts_along_x:
        wanted.add(Where.ALONG_X)
    names = [name for name, row in OBSERVABLES.items() if row.measure and row.where in wanted]
    if law.capture_speed:  # places are not those of all that move
        names = [name for name in names if name in ("drift", "thermal_speed", "a2")]
    if law.is_driven and "kurtosis" in names:  # there is no theory of it
        names.remove("kurtosis")
    return tuple(names)


def shaped_difference(
    shape: Shape, theory: Array, difference: Array, offset: float = 0.0
) -> NDArray[Any]:
    """Return differences of a function of an average, over the slope of the function at the theory.

    Where the function has no value, as of an average that is 0, the plain difference is returned.
    """
    if shape is Shape.PLAIN:
        return difference
    size = theory + offset
    with np.errstate(divide="ignore", invalid="ignore"):
        log_ratio = np.log1p(difference / size)
        if shape is Shape.LOGARITHM:
            shaped = size * log_ratio
        else:
            shaped = size * np.expm1(-3.0 * log_ratio) / -3.0
    return np.where(np.isfinite(shaped), shaped, difference)
