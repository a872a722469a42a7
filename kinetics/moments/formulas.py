"""Outputs that are made of averages of powers of the speed, and the number of collisions.

Each function takes the :class:`kinetics.moments.velocity.Averages` of a scene; the powers that it
needs are solved once, whichever function asks first.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.errors import InputError
from kinetics.moments.backward import MEAN_COLLISIONS
from kinetics.moments.velocity import Averages
from kinetics.numerics import FloatArray
from kinetics.states.state import State
from kinetics.validation import exponent, whole_number

_HIGHEST_POWER, _HIGHEST_HARMONIC = 40.0, 256


def moment_arguments(law: CollisionLaw, state: State, p: Any, m: Any) -> tuple[float, int]:
    """p and m of <v^p exp(-i m phi)>; InputError out of range, or where it does not exist."""
    p = exponent("p", p, _HIGHEST_POWER)
    m = whole_number("m", m, 0, _HIGHEST_HARMONIC)
    lowest = max(state.lowest_moment, law.lowest_power)
    if p <= lowest:
        raise InputError(f"p: got {p!r}; moments of this scene exist for p > {lowest:g} only")
    return p, m


def thermal_speed(averages: Averages) -> FloatArray:
    """v0 = sqrt(<v^2>) in U, shape (n_times,) (paper, label ``v0defi``)."""
    return np.asarray(np.exp(averages.log_reference) * np.sqrt(averages.power(2.0)))


def temperature(averages: Averages) -> FloatArray:
    """<v^2>/d in m U^2, shape (n_times,) (paper, label ``thermo``)."""
    square = np.exp(averages.log_reference) ** 2 * averages.power(2.0)
    return np.asarray(square / averages.law.dimension)


def a2(averages: Averages) -> FloatArray:
    """<v^4> d/((d+2) <v^2>^2) - 1, shape (n_times,) (paper, label ``sonine5``)."""
    gaussian = averages.law.dimension / (averages.law.dimension + 2.0)
    return np.asarray(gaussian * averages.power(4.0) / averages.power(2.0) ** 2 - 1.0)


def mean_velocity(averages: Averages) -> FloatArray:
    """(<v_x>, <v_y>) in U, shape (n_times, 2), from harmonic 1; in space (n_times, 3)."""
    return as_vector(averages, np.exp(averages.log_reference) * averages.power(1.0, 1))


def as_vector(averages: Averages, along: NDArray[Any]) -> FloatArray:
    """The vector whose harmonic 1 is ``along``, (n_times,): (n_times, 2), in space (n_times, 3)."""
    if averages.law.dimension == 2:
        return np.stack([along.real, -along.imag], axis=-1)
    return np.stack([along.real, 0.0 * along.real, 0.0 * along.real], axis=-1)


def velocity_tensor(averages: Averages) -> FloatArray:
    """<v_i v_j> in U^2, shape (n_times, 2, 2), from harmonics 0 and 2; in space (n_times, 3, 3)."""
    square = np.exp(averages.log_reference) ** 2
    trace, second = square * averages.power(2.0), square * averages.power(2.0, 2)
    if averages.law.dimension == 3:
        # v_x^2 = v^2 (1 + 2 P_2)/3, and the rest is shared by y and z
        tensor = np.zeros((averages.times.size, 3, 3))
        tensor[:, 0, 0] = (trace + 2.0 * second.real) / 3.0
        tensor[:, 1, 1] = tensor[:, 2, 2] = (trace - second.real) / 3.0
        return tensor
    xx, yy = 0.5 * (trace + second.real), 0.5 * (trace - second.real)
    xy = -0.5 * second.imag
    return np.stack([xx, xy, xy, yy], axis=-1).reshape(-1, 2, 2)


def collisions(averages: Averages) -> FloatArray:
    """Mean number of collisions of a tracer since t = 0, shape (n_times,)."""
    return np.asarray(averages.average(MEAN_COLLISIONS))
