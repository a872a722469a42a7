"""What all methods give at one value of the parameter: a `Case`, and `Results`, which holds all.

Rows, figures and findings read nothing else. A case names who says something (a *source*), and what
about (an *observable*): ``case.measured["hard disks"]["msd"]`` was measured among hard disks.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics import Solution
from kinetics.crosscheck.report.systems import System
from kinetics.driven.driven_state import DrivenState
from kinetics.scaling.closed_form import ScalingSolution
from kinetics.scaling.scaled_vdf import ScaledVDF

FloatArray = NDArray[np.float64]
#: Values of an observable: one, or an array over times or bins.
Values = float | FloatArray

# Who says something: theories, then particles.
KINETIC = "kinetic equation"
EXACT = "exact"
SOLVER = "solver"
FIT = "paper's fit"
SONINE = "Sonine"
FREE = "Boltzmann-Grad"

#: Observables that are compared at each time, without a field.
OVER_TIME = ("thermal_speed", "a2", "msd", "kurtosis")


class HasError(Protocol):
    """Anything that has a value and its standard error."""

    @property
    def value(self) -> FloatArray:
        """The value."""

    @property
    def error(self) -> FloatArray:
        """Its standard error."""


@dataclass(frozen=True)
class Measured:
    """An estimate with its standard error, of the same shape; NaN where nothing was measured."""

    value: FloatArray
    error: FloatArray

    @staticmethod
    def of(estimate: HasError) -> "Measured":
        """Return the value and the error of another estimate."""
        return Measured(np.asarray(estimate.value), np.asarray(estimate.error))

    @property
    def last(self) -> "Measured":
        """The last value and its error, of shape ()."""
        last_value = np.ravel(self.value)[-1]
        last_error = np.ravel(self.error)[-1]
        return Measured(np.asarray(last_value), np.asarray(last_error))

    def __truediv__(self, scale: ArrayLike) -> "Measured":
        divisor = np.asarray(scale, dtype=float)
        return Measured(np.asarray(self.value / divisor), np.asarray(self.error / divisor))

    def select(self, chosen: NDArray[np.bool_]) -> "Measured":
        """Return the values and errors where `chosen` is true."""
        return Measured(self.value[chosen], self.error[chosen])


@dataclass(frozen=True)
class SampleSize:
    """How many independent groups of tracers a source has, and how many tracers are in each."""

    groups: int
    tracers: int

    @property
    def total(self) -> int:
        """All tracers."""
        return self.groups * self.tracers


@dataclass(frozen=True)
class Place:
    """What an observable depends on: "time", "c" or "distance", and the values of it."""

    name: str
    values: FloatArray


@dataclass(frozen=True)
class DensityTest:
    """A measured density in bins that are so wide that a difference of a tenth shows in each."""

    measured: Measured
    theory: FloatArray
    place: Place


@dataclass(frozen=True, kw_only=True)
class Case:
    """What every method gives at one value of the parameter.

    Parameters
    ----------
    system : what the rows call it
    value : of the system's parameter
    times : output times
    measured : by source and observable, estimates with their errors
    theory : by who says so and observable; arrays where there are several times or bins
    sizes : of each source
    places : of an observable that depends on something, what it depends on
    """

    system: str
    value: float
    dimension: int
    times: FloatArray
    measured: dict[str, dict[str, Measured]]
    theory: dict[str, dict[str, Values]]
    sizes: dict[str, SampleSize]
    places: Mapping[str, Place]

    def measured_of(self, observable: str) -> dict[str, Measured]:
        """Return one observable as every source has measured it."""
        return {source: estimates[observable] for source, estimates in self.measured.items()}


@dataclass(frozen=True, kw_only=True)
class ScalingStates:
    """The scaling state of a law: in closed form and as solved."""

    exact: ScalingSolution
    solved: ScaledVDF


@dataclass(frozen=True, kw_only=True)
class CoolingSolutions:
    """Solutions of the kinetic equation for one law.

    Parameters
    ----------
    kinetic : at the times of the particles
    late : until `cooling.LATEST_TIME`
    position : at the last time of the particles, with the position density
    dense : the equation corrected for hard disks at this density; None where there is none
    scaling : None for an elastic law, which does not cool
    """

    kinetic: Solution
    late: Solution
    position: Solution
    dense: Solution | None
    scaling: ScalingStates | None


@dataclass(frozen=True, kw_only=True)
class CoolingCase(Case):
    """A case of a gas that is left alone.

    Parameters
    ----------
    early : index of the time from which on late rates are measured, a tenth of the last
    solutions : which figures draw between the points
    tests : by source and observable ("scaled_vdf", "position"), densities in wide bins
    """

    early: int
    solutions: CoolingSolutions
    tests: dict[str, dict[str, DensityTest]] = field(default_factory=dict)

    @property
    def scaling(self) -> ScalingStates | None:
        """The scaling state; None for an elastic law."""
        return self.solutions.scaling

    @property
    def cools(self) -> bool:
        """Whether there is a scaling state: the law is not elastic."""
        return self.scaling is not None


@dataclass(frozen=True, kw_only=True)
class DrivenCase(Case):
    """A case of driven tracers; `state` is the steady state, None where nothing drives."""

    state: DrivenState | None


@dataclass(frozen=True)
class Results:
    """Everything that was run: cases of a gas that cools, or of driven tracers."""

    system: System
    cooling: Sequence[CoolingCase] = ()
    driven: Sequence[DrivenCase] = ()

    @property
    def cases(self) -> list[Case]:
        """All cases."""
        return [*self.cooling, *self.driven]

    @property
    def inelastic(self) -> list[CoolingCase]:
        """The cases that cool."""
        return [case for case in self.cooling if case.cools]
