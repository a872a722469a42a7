"""Initial states of driven tracers: by their harmonics, or as velocities that fall freely.

Over harmonics, averages converge fast where the start has few of them and is not slow. Rest, beams,
a few samples and slow isotropic starts are velocities instead: of each what has not collided is in
closed form (`kinetics.driven.free_fall`), and collisions spread directions. Begin with
`DrivenStart`.
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

#: Most samples, or directions, that are followed one by one. Chosen: it bounds work and memory.
MAX_FOLLOWED = 64
#: Imaginary weights, of harmonics across the field, that are rounding. Chosen: far above rounding;
#: at half and at twice nothing moves.
SYMMETRIC_BELOW = 1e-9
#: The tolerance with which a start is represented, over that of the result. Chosen: so that it adds
#: little; at half and at twice a field over time moves by 3e-6 at rtol 1e-4.
START_SHARE_OF_TOLERANCE = 0.1
#: Highest power of the speed whose average a start must have.
HIGHEST_POWER = 4


@dataclass(frozen=True)
class DrivenStart:
    """An initial state in units of the solver.

    Parameters
    ----------
    measures : weighted points of ln(v/U) of each harmonic, or None
    speed : U in units of the solver
    velocities : if there are any, they are used, and not the harmonics
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

        Parameters
        ----------
        state : the initial state
        rtol : relative error of averages of v^0 to v^4
        speed : U in sqrt(g l)
        harmonics : the highest that is solved
        dimension : d
        """
        if isinstance(state, Rest):
            return cls.rest(dimension)
        speeds = state.harmonic(0, rtol, 0.0, HIGHEST_POWER)
        assert speeds is not None  # every state has its speeds
        v = speed * np.exp(speeds.x)
        if isinstance(state, Beam):
            sine = math.sin(state.direction)
            along = v * math.cos(state.direction)
            across = v * sine
            beam = Velocities(along, across, speeds.weight.real, sine == 0.0, dimension)
            return cls((speeds,), speed, beam)
        if isinstance(state, VelocitySamples) and np.shape(state.velocity)[0] <= MAX_FOLLOWED:
            return cls((speeds,), speed, Velocities.samples(speed * np.asarray(state.velocity)))
        highest = state.highest_harmonic
        is_slow = v.max() < 1.0  # sqrt(g l)
        if highest == 0 and is_slow:
            directions = (harmonics + 1) // 2
            isotropic = Velocities.isotropic(speeds, speed, directions, dimension)
            return cls((speeds,), speed, isotropic)
        last = harmonics if highest is None else min(highest, harmonics)
        measures = (state.harmonic(m, rtol, 0.0, HIGHEST_POWER) for m in range(last + 1))
        return cls(tuple(measures), speed)

    @property
    def speeds(self) -> LogMeasure:
        """The weighted points of the speed, of harmonic 0; a start at rest has none."""
        speeds = self.measures[0]
        assert speeds is not None  # every state has its speeds
        return speeds

    @property
    def is_symmetric(self) -> bool:
        """Whether the state is symmetric about the field."""
        if self.velocities is not None:
            return self.velocities.symmetric
        # the weights have the factor exp(-i m phi)
        across = [np.abs(np.imag(measure.weight)) for measure in self.measures if measure]
        return all(np.all(weights <= SYMMETRIC_BELOW) for weights in across)

    @property
    def highest(self) -> float:
        """The largest speed at the start."""
        if self.velocities is not None:
            return self.velocities.highest
        largest = [float(np.exp(measure.x.max())) for measure in self.measures if measure]
        return max(self.speed * v for v in largest)

    @property
    def mean_speed(self) -> float:
        """The average speed at the start; 0 of rest, which has no measure."""
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
        """Return sums over the start of harmonics and polynomials of an axis.

        A few points of a measure give averages of smooth functions, but a polynomial on a panel is
        smooth on its panel only: where the state has a profile, that is integrated instead.

        Parameters
        ----------
        axis : the axis of speeds
        count, families : of the harmonics
        state : whose profiles are integrated; None to take the points of the measures
        tolerance : by so much integrals of v^0 ... v^4 over a profile may differ from those over
            the measure, relative to those of harmonic 0; beyond, the quadrature has missed
            something, such as a narrow peak, and the points of the measure are taken

        Returns
        -------
        Shape (families, count, size)
        """
        sums = np.zeros((families, count, axis.size))
        for m, measure in enumerate(self.measures[:count]):
            if measure is None:
                continue
            averages = None if state is None else self._profile_averages(axis, m, state)
            if averages is None or not self._has_same_moments(axis, measure, averages, tolerance):
                averages = self._point_averages(axis, m, measure)
            # the weights have the factor exp(-i m phi)
            sums[:, m] = np.stack([np.real(averages), -np.imag(averages)])[:families]
        return sums

    def _profile_averages(
        self, axis: VelocityAxis, m: int, state: State
    ) -> NDArray[np.inexact] | None:
        """Return averages of polynomials over the profile of harmonic m, if it has one."""
        profile = state.profile(m)
        if profile is None:
            return None

        def density(v: FloatArray) -> NDArray[np.inexact]:
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
        """Return whether v^0 ... v^4 have the averages that the measure gives them."""
        if math.isinf(tolerance):
            return True
        for power in range(HIGHEST_POWER + 1):
            moment = axis.speeds**power @ averages
            expected = measure.weight @ (self.speed * np.exp(measure.x)) ** power
            scale = self.speeds.weight.real @ (self.speed * np.exp(self.speeds.x)) ** power
            if not abs(moment - expected) <= tolerance * scale:
                return False
        return True
