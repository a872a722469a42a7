"""Moments of the displacement, and other outputs made of it, from chains of scalar equations.

They come from the equation with its free-streaming term (paper, label ``inelaslorentz``); no
profile in space is needed.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from kinetics.moments.backward import (
    DISPLACEMENT_ALONG_START,
    MSD_SLOPE,
    SQUARED_DISPLACEMENT,
    quartic_displacement,
    speed_power,
)
from kinetics.moments.velocity import Averages, as_vector
from kinetics.numerics import FloatArray

# of v_rms t/l: below it no tracer has collided, and its fourth power is still in range
_FREE = math.log(1e-50)
_LATE, _LARGEST = -_FREE, 700.0  # later than the first nothing changes at e = 1; ln of the range


def _free(averages: Averages) -> tuple[NDArray[np.bool_], FloatArray]:
    """When all tracers fly freely to rounding, and v_rms t then, in d; (n_times,) each."""
    log_first = averages.log_first
    free = log_first + averages.log_stretch < _FREE
    with np.errstate(over="ignore", under="ignore"):
        return free, np.where(free, math.exp(log_first) * averages.times, 0.0)


def root_mean_square(averages: Averages) -> FloatArray:
    """sqrt(<r^2>)(t) in d, shape (n_times,); also where <r^2> is out of range."""
    free, flight = _free(averages)
    root = averages.mean_free_path * np.sqrt(averages.average(SQUARED_DISPLACEMENT))
    return np.where(free, flight, root)


def mean_square_displacement(averages: Averages) -> FloatArray:
    """<r^2>(t) in d^2, shape (n_times,)."""
    free, flight = _free(averages)
    path = averages.mean_free_path
    with np.errstate(over="ignore", under="ignore"):
        return np.where(free, flight**2, path * (path * averages.average(SQUARED_DISPLACEMENT)))


def kurtosis(averages: Averages) -> FloatArray:
    """<r^4>/<r^2>^2, shape (n_times,); at t = 0 its limit, <v^4>/<v^2>^2."""
    if averages.elastic:  # late it stands still, and fourth powers of v t/l overflow
        log_last = _LATE - averages.log_first + math.log(averages.mean_free_path)
        last = math.exp(min(log_last, _LARGEST))
        if averages.times[-1] > last:
            averages = averages.at(np.minimum(averages.times, last))
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
    twice = 2.0 * averages.law.dimension
    path = averages.mean_free_path
    free, flight = _free(averages)
    mean = averages.average(MSD_SLOPE)
    speed = np.exp(averages.log_reference)
    # T_ref = v_ref t/l stays of order 1 late: no power of t over- or underflows
    with np.errstate(over="ignore", under="ignore"):
        stretch = np.exp(averages.log_reference + averages.log_stretch)
        value = np.where(free, 2.0 / twice * speed * flight, path * mean * speed / twice)
        return value, np.where(free, 2.0 * flight**2, path * (path * mean * stretch))


def mean_displacement(averages: Averages) -> FloatArray:
    """<r>(t) of a directed start in d, shape (n_times, 2), in space (n_times, 3)."""
    found = averages.measure(1)
    if found is None:
        return np.zeros((averages.times.size, averages.law.dimension))
    along = averages.average(DISPLACEMENT_ALONG_START)
    free, flight = _free(averages)
    freely = flight * (np.exp(found.x - averages.log_first) @ found.weight)
    along = np.where(free, freely, averages.mean_free_path * along)
    return as_vector(averages, along)
