"""Tracers that have not collided: a singular, ballistic part of g(r, t), known exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetics.numerics import FloatArray
from kinetics.results import Value
from kinetics.states.quadrature import refined
from kinetics.states.state import State

_NONE_LEFT = 40.0  # flights of so many l without a collision: e^-40 of the tracers
_PIECES = 40  # of the radii where there are tracers, halved where the density needs it
_LEFT_OUT = 1e-12  # of all tracers, by these pieces, and beyond the last of them


@dataclass(frozen=True)
class Uncollided(Value):
    """f(r/t) exp(-r/l)/t, f the density of the initial speeds; 0 for a start of sharp speeds.

    Attributes
    ----------
    state : the initial state
    mean_free_path : l, in d
    times : in d/U, shape (n_times,)
    """

    state: State
    mean_free_path: float
    times: FloatArray

    def at(self, time: int, r: FloatArray) -> FloatArray:
        """Density in 1/d at radii r in d, shape (n_r,)."""
        profile, t = self.state.profile(0), self.times[time]
        if profile is None or t == 0.0:
            return np.zeros(r.shape)
        with np.errstate(under="ignore", over="ignore"):
            left = np.exp(-r / self.mean_free_path)
            # where none is left, the speed is not asked for: it may be larger than any number
            f = np.asarray(profile(np.where(left > 0.0, r / t, 0.0)).real)
            # a speed density is not negative: what is below zero is rounding
            return np.where(left > 0.0, np.maximum(f, 0.0) * left / t, 0.0)

    def within(self, time: int, r: FloatArray) -> FloatArray:
        """Share of all tracers that have not collided and are within r, shape of r (n_r,)."""
        t = self.times[time]
        if self.state.profile(0) is None or t == 0.0:
            return np.zeros(r.shape)
        with np.errstate(over="ignore"):
            # the points of a density stop short of where it ends
            far = 2.0 * t * fastest_speed(self.state, _LEFT_OUT)
            far = min(far, _NONE_LEFT * self.mean_free_path)
            kinks = self.state.kinks * t
        near = np.clip(r, 0.0, far)
        inner = np.concatenate([kinks[kinks < far], near, far * np.linspace(0.0, 1.0, _PIECES + 1)])
        edges = np.unique(inner)
        ends = np.stack([edges[:-1], edges[1:]], axis=1)
        at, share = refined(lambda x: self.at(time, x), ends, _LEFT_OUT)
        order = np.argsort(at)
        sums = np.concatenate([[0.0], np.cumsum(share[order])])
        return np.asarray(sums[np.searchsorted(at[order], near)])


def fronts(state: State, mean_free_path: float, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where the uncollided of each delta peak of the speed are, and their share of all tracers.

    Shape (n_times, n_speeds) each, radii in d; n_speeds = 0 for a start with a density.
    """
    speed, share = state.peaks or (np.zeros(0), np.zeros(0))
    with np.errstate(over="ignore", under="ignore"):
        radius = np.outer(times, speed)
        return radius, share * np.exp(-radius / mean_free_path)


def fastest_speed(state: State, rtol: float) -> float:
    """The largest of sharp speeds; for densities, one that all but about rtol of the tracers keep
    below.
    """
    if state.peaks is not None:
        return float(np.max(state.peaks[0]))
    found = state.harmonic(0, rtol)
    assert found is not None  # harmonic 0 is never zero
    return float(np.exp(found.x.max()))
