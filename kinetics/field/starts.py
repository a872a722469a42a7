"""How averages over a start are taken from averages as functions of the first velocity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetics.field.backward import ALL, IS_EVEN
from kinetics.field.panels import SpeedPanels
from kinetics.numerics import FloatArray
from kinetics.states.quadrature import LogMeasure
from kinetics.states.state import State

_PIECE = 20_000  # points of a state that are interpolated at once


@dataclass(frozen=True)
class Start:
    """An initial state, as its harmonics about the field; or rest.

    Parameters
    ----------
    measures : weighted points of ln(v/U) of each harmonic, or None; without any: rest
    speed : U in sqrt(g l)
    """

    measures: tuple[LogMeasure | None, ...]
    speed: float

    @classmethod
    def of(cls, state: State, harmonics: int, rtol: float, speed: float) -> Start:
        """Up to the highest harmonic that is solved, with averages of v^0 to v^4."""
        there = state.highest_harmonic
        last = harmonics if there is None else min(there, harmonics)
        found = tuple(state.harmonic(m, rtol, 0.0, 4.0) for m in range(last + 1))
        return cls(found, speed)

    @property
    def is_symmetric(self) -> bool:
        """Whether the state is symmetric about the field."""
        return not any(np.any(np.imag(m.weight)) for m in self.measures if m)

    @property
    def highest(self) -> float:
        """The largest speed at the start."""
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


def free_fall(t: FloatArray) -> FloatArray:
    """The even observables of a tracer that falls from rest, (n, n_observables)."""
    out = np.zeros((t.size, len(ALL)))
    for name, power in (("v_x", 1), ("v^2", 2), ("v^2 cos 2", 2), ("v^3", 3), ("v^4", 4)):
        out[:, ALL.index(name)] = t**power
    out[:, ALL.index("x")] = 0.5 * t**2
    out[:, ALL.index("x^2")] = 0.25 * t**4
    return out


def moved(fallen: FloatArray, after: FloatArray) -> FloatArray:
    """Averages from rest with the first collision after these times (n,).

    after : averages from that collision on, (n, n_observables)
    """
    out = after.copy()
    way = 0.5 * fallen**2
    out[:, ALL.index("x")] += way
    out[:, ALL.index("x^2")] += way**2 + 2.0 * way * after[:, ALL.index("x")]
    out[:, ALL.index("collisions")] += 1.0
    return out
