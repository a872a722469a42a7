"""Initial states of driven tracers: by their harmonics, or as velocities that fall freely.

Speeds of a state are in U. Those of the solver are in sqrt(g l) in a field of the acceleration g,
with l the mean free path, and in U with other drives. The field is along x, and phi is the angle to
it. Harmonic m of a state is the integral over the directions of exp(-i m phi), in space of
P_m(cos phi), times the density of the speed and the direction; harmonic 0 is the density of the
speed.

Over harmonics, averages converge fast where the start has few of them and is not slow. Other starts
are velocities: rest, beams, a few samples and slow isotropic starts. Of each velocity what has not
collided is in closed form (`kinetics.driven.free_fall`), and collisions spread directions.

Begin with `DrivenStart.of`; `DrivenStart.projected` is what a solver of harmonics takes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.driven.axis import VelocityAxis
from kinetics.driven.free_fall import BATCH_SIZE, Velocities
from kinetics.numerics import FloatArray
from kinetics.states.kinds import Beam, Rest, VelocitySamples
from kinetics.states.state import LogMeasure, State

#: Most samples that are followed as velocities; more are harmonics. Also the number of directions
#: over which `velocity_density` spreads a sharp speed, and the most velocities of which
#: `field_evolution` follows each bounce. Chosen: averages are the same to the
#: tolerance either way: with 32, 40 samples take 60 s in place of 2 s; with 128, 100 samples take
#: 4 s in place of 53 s. With half or twice as many directions shares that have not collided move by
#: 2e-6 (e = 0.7).
MAX_FOLLOWED = 64
#: Largest imaginary part of a weight of a harmonic, absolute (the weights of harmonic 0 sum to 1),
#: that is rounding: a state that is not symmetric about the field has larger ones. Chosen:
#: the largest measured for symmetric starts is 1e-14, of a beam against the field.
SYMMETRIC_BELOW = 1e-9
#: The tolerance with which the harmonics of a start are represented, over that of the result; who
#: calls `DrivenStart.of` multiplies with it. Chosen: with half or twice of it
#: averages move by 3e-10 at rtol 1e-6.
START_SHARE_OF_TOLERANCE = 0.1
#: Highest power of the speed whose average over the start must be right: v^4 is the highest that
#: the outputs need (`kinetics.driven.averages`), v^0 the lowest.
HIGHEST_POWER = 4
#: The lowest such power.
LOWEST_POWER = 0.0


def measures_of_start(state: State, rtol: float, last: int) -> list[LogMeasure | None]:
    """Return the harmonics 0 to `last` of a state as weighted points; None where one is zero.

    Parameters
    ----------
    state : the initial state
    rtol : relative tolerance of the result, of which the start takes `START_SHARE_OF_TOLERANCE`
    last : the highest harmonic
    """
    tolerance = START_SHARE_OF_TOLERANCE * rtol
    return [state.harmonic(m, tolerance, LOWEST_POWER, HIGHEST_POWER) for m in range(last + 1)]


@dataclass(frozen=True)
class DrivenStart:
    """An initial state in units of the solver.

    Parameters
    ----------
    measures : harmonics m = 0, 1, ... as weighted points of ln(v/U); None where one is zero. Rest
        has none, and starts that are velocities have m = 0 only
    speed : U in units of the solver
    velocities : the start as velocities; None where it is harmonics. A solver in a field takes the
        velocities if there are any, and else `projected`
    """

    measures: tuple[LogMeasure | None, ...]
    speed: float
    velocities: Velocities | None = None

    @classmethod
    def rest(cls, dimension: int) -> DrivenStart:
        """Return the start at which all tracers are at rest."""
        return cls((), 1.0, Velocities.rest(dimension))

    @classmethod
    def of(
        cls, state: State, rtol: float, speed: float, harmonics: int, dimension: int
    ) -> DrivenStart:
        """Return the start of tracers in a field, in units of sqrt(g l).

        Rest, beams, at most `MAX_FOLLOWED` samples, and isotropic starts whose speeds are all below
        sqrt(g l) become velocities; anything else becomes harmonics.

        Parameters
        ----------
        state : the initial state
        rtol : relative error of averages of v^0 to v^4 over the start
        speed : U in sqrt(g l)
        harmonics : the highest harmonic that is solved for
        dimension : d, 2 or 3
        """
        if isinstance(state, Rest):
            return cls.rest(dimension)
        speeds = state.harmonic(0, rtol, LOWEST_POWER, HIGHEST_POWER)
        assert speeds is not None  # every state has its speeds
        v = speed * np.exp(speeds.x)
        if isinstance(state, Beam):
            sine = math.sin(state.direction)
            along = v * math.cos(state.direction)
            across = v * sine
            is_along_field = sine == 0.0
            beam = Velocities(along, across, speeds.weight.real, is_along_field, dimension)
            return cls((speeds,), speed, beam)
        if isinstance(state, VelocitySamples) and np.shape(state.velocity)[0] <= MAX_FOLLOWED:
            return cls((speeds,), speed, Velocities.samples(speed * np.asarray(state.velocity)))
        highest = state.highest_harmonic
        is_slow = v.max() < 1.0  # in sqrt(g l), which a field gives a tracer on one free path
        if highest == 0 and is_slow:
            directions = (harmonics + 1) // 2  # averages of harmonics up to this one are exact
            isotropic = Velocities.isotropic(speeds, speed, directions, dimension)
            return cls((speeds,), speed, isotropic)
        last = harmonics if highest is None else min(highest, harmonics)
        measures = (state.harmonic(m, rtol, LOWEST_POWER, HIGHEST_POWER) for m in range(last + 1))
        return cls(tuple(measures), speed)

    @property
    def speeds(self) -> LogMeasure:
        """Harmonic 0: weighted points of ln(v/U), whose weights sum to 1; rest has none."""
        speeds = self.measures[0]
        assert speeds is not None  # every state has its speeds
        return speeds

    @property
    def is_symmetric(self) -> bool:
        """Whether the state is symmetric about the field: no harmonic has an imaginary part.

        The imaginary part of harmonic m is minus the average of sin(m phi).
        """
        if self.velocities is not None:
            return self.velocities.symmetric
        across = [np.abs(np.imag(measure.weight)) for measure in self.measures if measure]
        return all(np.all(weights <= SYMMETRIC_BELOW) for weights in across)

    @property
    def highest(self) -> float:
        """The largest speed at the start, in units of the solver."""
        if self.velocities is not None:
            return self.velocities.highest
        largest = [float(np.exp(measure.x.max())) for measure in self.measures if measure]
        return max(self.speed * v for v in largest)

    @property
    def mean_speed(self) -> float:
        """The average speed at the start, in units of the solver; 0 for rest."""
        if not self.measures:
            return 0.0
        return self.speed * float(self.speeds.weight.real @ np.exp(self.speeds.x))

    def projected(
        self,
        axis: VelocityAxis,
        count: int,
        families: int,
        state: State | None,
        tolerance: float = math.inf,
    ) -> FloatArray:
        """Return averages over the harmonics of the start of the nodal polynomials of an axis.

        A few points of a measure give averages of smooth functions, but a polynomial on a panel is
        smooth on its panel only: where the state has a profile, that is integrated instead. The
        `velocities` of a start do not matter here.

        Parameters
        ----------
        axis : the axis of speeds; its polynomials are 1 at one of `axis.speeds` and 0 at the others
        count : number of harmonics, m = 0 ... count - 1
        families : 1 for the averages with cos(m phi) alone, of starts that are symmetric about the
            field; 2 for those with sin(m phi) too
        state : whose profiles are integrated; None to take the points of the measures
        tolerance : by so much integrals of v^0 ... v^4 over a profile may differ from those over
            the measure, relative to those of harmonic 0; beyond, the quadrature has missed
            something, such as a narrow peak, and the points of the measure are taken. By default
            this is not checked

        Returns
        -------
        Shape (families, count, size), size the number of polynomials
        """
        sums = np.zeros((families, count, axis.size))
        for m, measure in enumerate(self.measures[:count]):
            if measure is None:
                continue
            averages = None if state is None else self._profile_averages(axis, m, state)
            if averages is None or not self._has_same_moments(axis, measure, averages, tolerance):
                averages = self._point_averages(axis, m, measure)
            # exp(-i m phi) = cos(m phi) - i sin(m phi)
            sums[:, m] = np.stack([np.real(averages), -np.imag(averages)])[:families]
        return sums

    def _profile_averages(
        self, axis: VelocityAxis, m: int, state: State
    ) -> NDArray[np.inexact] | None:
        """Return averages of the polynomials over the profile of harmonic m, shape (size,).

        None if the harmonic has no profile. An axis may make use of the parity, m % 2: see
        `VelocityAxis`.
        """
        profile = state.profile(m)
        if profile is None:
            return None

        def density(v: FloatArray) -> NDArray[np.inexact]:
            """Return f_m of speeds v in units of the solver."""
            return np.asarray(profile(v / self.speed) / self.speed)

        kinks = self.speed * np.asarray(state.kinks)
        return np.asarray(axis.averaged(density, m % 2, kinks))

    def _point_averages(
        self, axis: VelocityAxis, m: int, measure: LogMeasure
    ) -> NDArray[np.inexact]:
        """Return averages of the polynomials of an axis over the points of a measure, (size,)."""
        v = self.speed * np.exp(measure.x)
        averages: NDArray[Any] = np.zeros(axis.size, dtype=measure.weight.dtype)
        for batch in np.array_split(np.arange(v.size), 1 + v.size // BATCH_SIZE):
            averages += measure.weight[batch] @ axis.interpolation(v[batch], m % 2)
        return averages

    def _has_same_moments(
        self,
        axis: VelocityAxis,
        measure: LogMeasure,
        averages: NDArray[np.inexact],
        tolerance: float,
    ) -> bool:
        """Return whether averages of v^0 ... v^4 agree with those over the points of a measure.

        Parameters
        ----------
        axis : the axis of speeds
        measure : a harmonic, as weighted points of ln(v/U)
        averages : of the polynomials over its profile, (size,): v^p is the sum over
            `axis.speeds` of its values there times the polynomials
        tolerance : relative to the averages over harmonic 0; if infinite, all agree
        """
        if math.isinf(tolerance):
            return True
        for power in range(HIGHEST_POWER + 1):
            moment = axis.speeds**power @ averages
            expected = measure.weight @ (self.speed * np.exp(measure.x)) ** power
            scale = self.speeds.weight.real @ (self.speed * np.exp(self.speeds.x)) ** power
            if not abs(moment - expected) <= tolerance * scale:
                return False
        return True
