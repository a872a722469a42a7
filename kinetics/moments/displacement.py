"""Moments of the displacement, and other outputs made of it, from chains of scalar equations.

They come from the equation with its free-streaming term (paper, label ``inelaslorentz``); no
profile in space is needed.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from kinetics.moments.backward import (
    DISPLACEMENT_ALONG_START,
    MSD_SLOPE,
    SQUARED_DISPLACEMENT,
    quartic_displacement,
    speed_power,
)
from kinetics.moments.velocity import Averages, as_vector
from kinetics.numerics import FloatArray

# ln of v_rms t/l beyond which nothing changes at e = 1, and of the largest number
_LATE, _LARGEST = 115.0, 700.0


def _flown(averages: Averages) -> FloatArray:
    """v_ref t in d, (n_times,): averages of T^-n y times its n-th power do not underflow early."""
    return np.asarray(np.exp(averages.log_reference) * averages.times)


def root_mean_square(averages: Averages) -> FloatArray:
    """sqrt(<r^2>)(t) in d, shape (n_times,); also where <r^2> is out of range."""
    square = averages.average(SQUARED_DISPLACEMENT, leading=2)
    return np.asarray(np.sqrt(square) * _flown(averages))


def mean_square_displacement(averages: Averages) -> FloatArray:
    """<r^2>(t) in d^2, shape (n_times,)."""
    with np.errstate(over="ignore", under="ignore"):
        return root_mean_square(averages) ** 2


def kurtosis(averages: Averages) -> FloatArray:
    """<r^4>/<r^2>^2, shape (n_times,); at t = 0 its limit, <v^4>/<v^2>^2."""
    if averages.elastic:  # late it stands still, and fourth powers of v t/l overflow
        last = _LATE - averages.log_first + math.log(averages.mean_free_path)
        if averages.times[-1] > (last := math.exp(min(last, _LARGEST))):
            averages = replace(averages, times=np.minimum(averages.times, last))
    second = averages.average(SQUARED_DISPLACEMENT, leading=2)
    fourth = averages.average(quartic_displacement(averages.law.dimension), leading=4)
    return np.asarray(fourth / second**2)


def velocity_autocorrelation(averages: Averages) -> FloatArray:
    """<v(0) . v(t)> in U^2, shape (n_times,); negative where most bounces go backwards."""
    found = averages.average(speed_power(1.0, 1), m=0, start=1.0)
    return np.asarray(found * np.exp(averages.log_first + averages.log_reference))


def diffusion_coefficient(averages: Averages) -> tuple[FloatArray, FloatArray]:
    """D(t) = d<r^2>/dt/(2 d) in d U, and the slope d<r^2>/d ln t in d^2, (n_times,) each.

    The elastic D tends to (3/8) l <v> in the plane and (1/3) l <v> in space; tracers that cool have
    a slope that tends to 2 l^2/(kappa (1 - <cos chi>)).
    """
    mean, flown = averages.average(MSD_SLOPE, leading=1), _flown(averages)
    with np.errstate(over="ignore", under="ignore"):
        speed = np.exp(averages.log_reference) / (2.0 * averages.law.dimension)
        return mean * flown * speed, mean * flown * flown


def mean_displacement(averages: Averages) -> FloatArray:
    """<r>(t) of a directed start in d, shape (n_times, 2), in space (n_times, 3)."""
    along = averages.average(DISPLACEMENT_ALONG_START, leading=1)
    return as_vector(averages, along * _flown(averages))
