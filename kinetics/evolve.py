"""The time-dependent homogeneous equation (paper, label ``inelaslorentz2``).

Averages of powers of the speed come from the backward equation (:mod:`kinetics.backward`): one
smooth function of v t for each, averaged over the initial state. The speed density itself comes
from the forward equation in :mod:`kinetics.forward`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetics.backward import BackwardEquation, Observable, nodes_for
from kinetics.collision import CollisionLaw
from kinetics.initial import LogMeasure

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Averages:
    """Averages over an initial state, at given times.

    Parameters
    ----------
    law : the collision law
    mean_free_path : l, in d
    state : the initial speeds
    times : in d/U, shape (n_times,)
    rtol : relative accuracy
    degree : largest power of the speed that will be asked for; sets the nodes
    """

    law: CollisionLaw
    mean_free_path: float
    state: LogMeasure
    times: FloatArray
    rtol: float
    degree: float = 4.0

    @property
    def elastic(self) -> bool:
        """Speeds are kept: nothing needs to be solved."""
        return self.law.restitution == 1.0

    @cached_property
    def log_stretch(self) -> FloatArray:
        """ln(t/l) per time, -inf at t = 0, shape (n_times,)."""
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(self.times) - math.log(self.mean_free_path))

    @cached_property
    def log_reference(self) -> FloatArray:
        """ln of a speed of the order of the thermal one, shape (n_times,): nothing overflows."""
        first = math.log(self.state.moment(2.0)) / 2.0 if self._moderate else self._typical
        if self.elastic:
            return np.full(self.times.shape, first)
        with np.errstate(divide="ignore"):
            late = -self.log_stretch - math.log(self.law.mean_log_loss)
        return np.minimum(first, late)

    @property
    def _moderate(self) -> bool:
        return float(np.max(np.abs(self.state.x))) < 100.0

    @property
    def _typical(self) -> float:
        return float(
            self.state.x[
                np.argmax(self.state.weight * np.exp(2.0 * (self.state.x - self.state.x.max())))
            ]
        )

    @cached_property
    def equation(self) -> BackwardEquation:
        """The backward equation, up to the largest v t that occurs."""
        highest = float(self.state.x.max() + self.log_stretch[-1])
        highest = highest if math.isfinite(highest) else -2.0
        return BackwardEquation(self.law, highest, nodes_for(self.rtol, self.degree))

    def power(self, p: float, harmonic: int = 0) -> FloatArray:
        """<(v/v_ref)^p cos(m (phi - phi_0))>, v_ref = exp(log_reference), shape (n_times,)."""
        y = Observable(degree=p, harmonic=harmonic)
        return self.average(y)

    def average(self, y: Observable) -> FloatArray:
        """<y>/v_ref^p, with sources and constants as they stand (lengths in l), (n_times,)."""
        x, w = self.state.x, self.state.weight
        out = np.empty(self.times.shape)
        p = y.degree
        # averages over many points are made in pieces of the time axis: memory stays flat
        piece = max(1, 200_000 // x.size)
        for first in range(0, self.times.size, piece):
            part = slice(first, first + piece)
            stretch = self.log_stretch[part, None]
            reference = self.log_reference[part, None]
            small, large = self.equation.reduced(y, x + stretch)
            with np.errstate(under="ignore", invalid="ignore"):
                # y = T^p m: m where T is small, y where it is not
                start = np.where(np.isnan(small), 0.0, small * np.exp(p * (x - reference)))
                late = np.where(np.isnan(large), 0.0, large * np.exp(-p * (stretch + reference)))
            out[part] = (start + late) @ w
        return out

    def initial_power(self, p: float) -> FloatArray:
        """<(v/v_ref)^p> where speeds are kept, shape (n_times,)."""
        x, w = self.state.x, self.state.weight
        return np.asarray(np.exp(p * (x - self.log_reference[:, None])) @ w)
