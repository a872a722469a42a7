"""How averages over a start are taken from averages as functions of the first velocity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetics.field.backward import ALL, IS_EVEN
from kinetics.field.first_collision import Rays
from kinetics.field.panels import SpeedPanels
from kinetics.field.resolution import TimeResolution
from kinetics.numerics import FloatArray
from kinetics.states.directed import Beam, VelocitySamples
from kinetics.states.isotropic import Rest
from kinetics.states.quadrature import LogMeasure
from kinetics.states.state import State

_PIECE = 20_000  # points of a state that are interpolated at once
_SLOW = 1.0  # isotropic starts with a highest speed below this are followed along rays
_FEW = 64  # so many velocities are followed each


@dataclass(frozen=True)
class Start:
    """An initial state: its harmonics about the field, or rays, along which tracers fall freely.

    Averages converge fast over harmonics where the start has few of them, and is not slow.

    Parameters
    ----------
    measures : weighted points of ln(v/U) of each harmonic, or None
    speed : U in sqrt(g l)
    rays : if there are any, they are used, and not the harmonics
    """

    measures: tuple[LogMeasure | None, ...]
    speed: float
    rays: Rays | None = None

    @classmethod
    def rest(cls) -> Start:
        """All tracers are at rest."""
        return cls((), 1.0, Rays(np.zeros(1), np.zeros(1), np.ones(1), True))

    @classmethod
    def of(
        cls, state: State, rtol: float, speed: float, resolution: TimeResolution, dimension: int
    ) -> Start:
        """With harmonics up to the highest that is solved, and averages of v^0 to v^4."""
        if isinstance(state, Rest):
            return cls.rest()
        harmonics = resolution.harmonics
        speeds = state.harmonic(0, rtol, 0.0, 4.0)
        if speeds is None:
            raise ValueError("an initial state without a density of the speed")
        if isinstance(state, Beam):
            rays = Rays.beam(speeds, speed, state.direction, 2 * resolution.nodes)
            return cls((speeds,), speed, rays)
        if isinstance(state, VelocitySamples) and np.shape(state.velocity)[0] <= _FEW:
            velocity = speed * np.asarray(state.velocity)
            weight = np.full(velocity.shape[0], 1.0 / velocity.shape[0])
            return cls((speeds,), speed, Rays(velocity[:, 0], velocity[:, 1], weight, False))
        there = state.highest_harmonic
        last = harmonics if there is None else min(there, harmonics)
        if there == 0 and speed * float(np.exp(speeds.x.max())) < _SLOW:
            points, directions = max(3, resolution.nodes // 2), (harmonics + 1) // 2
            rays = Rays.isotropic(speeds, speed, points, directions, dimension)
            return cls((speeds,), speed, rays)
        found = tuple(state.harmonic(m, rtol, 0.0, 4.0) for m in range(last + 1))
        return cls(found, speed)

    @property
    def is_symmetric(self) -> bool:
        """Whether the state is symmetric about the field."""
        if self.rays is not None:
            return self.rays.symmetric
        return not any(np.any(np.imag(m.weight)) for m in self.measures if m)

    @property
    def highest(self) -> float:
        """The largest speed at the start."""
        if self.rays is not None:
            return float(np.max(np.hypot(self.rays.along, self.rays.across)))
        return max((self.speed * float(np.exp(m.x.max())) for m in self.measures if m), default=0.0)

    def functional(self, panels: SpeedPanels, harmonics: int) -> FloatArray:
        """Weights (M + 1, size, n_observables) of the average over harmonics of the averages."""
        out = np.zeros((harmonics + 1, panels.size, len(ALL)))
        for m, measure in enumerate(self.measures[: harmonics + 1]):
            if measure is None:
                continue
            for first in range(0, measure.x.size, _PIECE):
                x = measure.x[first : first + _PIECE]
                w = measure.weight[first : first + _PIECE]
                found = w @ panels.interpolation(self.speed * np.exp(x))
                # the weights have the factor exp(-i m phi)
                out[m] += np.where(IS_EVEN, found.real[:, None], -found.imag[:, None])
        return out
