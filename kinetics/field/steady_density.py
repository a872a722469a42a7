"""The density of the velocity in the steady state, by the integral over the last free flight.

On the ray along the field harmonics of f fall as m^-3 only, because tracers there have come by
rest. Those of what collisions make fall as m^-5, and faster in space. Where a bounce may stop a
tracer, f grows without limit towards that ray, as the logarithm of the angle.
"""

from __future__ import annotations

import math

import numpy as np

from kinetics.field.last_flight import LastFlights
from kinetics.field.resolution import smallest_ratio
from kinetics.field.steady import SteadyState
from kinetics.numerics import FloatArray

_LONGEST = 32.0  # mean free paths of a last flight
_FALL = 5.0  # power of 1/m by which harmonics of the gain fall
_CONTINUED = 2  # they are continued to 2 M
_SEEN = 0.1  # of the first panel: slower tracers are not resolved
_LAST_PAIR = 4.0  # by how much more than the last two harmonics may be missing
_LOOKED_AT = 60  # velocities of which the uncertainty is found, and as many again
_LONG_AGO = 1e300  # the time of the steady state


class SteadyDensity:
    """f at any velocity.

    Parameters
    ----------
    state : the steady state on panels
    harmonics : f_m, shape (M + 1, size)
    """

    def __init__(self, state: SteadyState, harmonics: FloatArray) -> None:
        panels, d = state.panels, state.law.dimension
        made = state.gained(harmonics)
        unsure = np.zeros_like(made)
        if state.powers[0] == 1.0:  # how they fall is not known, or with either sign
            unsure[-2:] = _LAST_PAIR * made[-2:]
        else:
            top = state.highest
            tail = (np.arange(top + 1.0, _CONTINUED * top) / top) ** -_FALL
            made = np.concatenate([made, tail[:, None] * made[-1]])
            unsure = np.concatenate([unsure, made[top + 1 :]])
        self._flights = LastFlights(panels, d, _LONGEST)
        self._flights.keep(0.0, 1.0, made[None, None])
        self._unsure = LastFlights(panels, d, _LONGEST)
        self._unsure.keep(0.0, 1.0, unsure[None, None])
        least = smallest_ratio(state.law)
        # speeds of the slowest tracers, where the panels do not see them; -1 where they do
        self._slowest = least if least < _SEEN * panels.edges[1] else -1.0

    def __call__(self, along: FloatArray, across: FloatArray) -> tuple[FloatArray, float]:
        """f at velocities (n,) in sqrt(g l), and how much of it is uncertain at most."""
        found = self._flights.density(_LONG_AGO, along, across)
        order = np.argsort(np.abs(across))  # the closest to the ray, and some of all others
        close = np.union1d(order[:_LOOKED_AT], order[:: 1 + order.size // _LOOKED_AT])
        unsure = np.abs(self._unsure.density(_LONG_AGO, along[close], across[close]))
        unseen = (np.abs(across) <= self._slowest) & (along >= 0.0)
        if self._slowest == 0.0:
            found[unseen] = math.inf
        exact = 0.0 if self._slowest == 0.0 else found[close]
        unsure = np.where(unseen[close], exact, unsure)
        return found, float(np.max(unsure, initial=0.0))
