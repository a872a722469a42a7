"""Tracers that have not collided: a singular, ballistic part of g(r, t), known exactly."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from kinetics.states.state import State

FloatArray = NDArray[np.float64]


def fronts(state: State, mean_free_path: float, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where the uncollided of each delta peak of the speed are, and their share of all tracers.

    Shape (n_times, n_speeds) each, radii in d; n_speeds = 0 for a start with a density.
    """
    peaks = state.peaks
    if peaks is None:
        return np.zeros((times.size, 0)), np.zeros((times.size, 0))
    speed, share = peaks
    with np.errstate(over="ignore", under="ignore"):
        radius = np.outer(times, speed)
        return radius, share * np.exp(-radius / mean_free_path)


def uncollided_density(
    state: State, mean_free_path: float, times: FloatArray
) -> Callable[[int, FloatArray], FloatArray]:
    """(time index, r) -> f(r/t) exp(-r/l)/t, f the density of the initial speeds; 0 for peaks."""
    profile = state.profile(0)

    def density(time: int, r: FloatArray) -> FloatArray:
        if profile is None or times[time] == 0.0:
            return np.zeros(r.shape)
        with np.errstate(under="ignore", over="ignore"):
            v = r / times[time]
            return np.asarray(profile(v).real * np.exp(-r / mean_free_path) / times[time])

    return density


def reach(state: State, times: FloatArray, rtol: float) -> FloatArray:
    """The largest radius there can be, (n_times,): no tracer outruns its initial speed.

    For densities, up to the speed that all but about rtol of the tracers keep below.
    """
    peaks = state.peaks
    if peaks is None:
        found = state.harmonic(0, rtol)
        assert found is not None
        fastest = float(np.exp(found.x.max()))
    else:
        fastest = float(np.max(peaks[0]))
    with np.errstate(over="ignore"):
        return np.asarray(times * fastest)
