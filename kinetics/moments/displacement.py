"""Moments of the displacement, and other outputs made of it, from chains of scalar equations.

In units of the mean free path l, with T = v t/l for a tracer of initial speed v (paper, label
``inelaslorentz`` for the equation with its free-streaming term):

    chi1(T) = <v_hat(0) . r>/l   : driven by 1, harmonic m = 1
    rho(T)  = <r^2>/l^2          : driven by 2 chi1, harmonic m = 0
    <r^4>/l^4                    : the same chain to the fourth order, harmonics 0, 1, 2
    <v(0) . v(t)>                : v times a power of the speed, harmonic m = 1
    d<r^2>/d ln t                : driven by the velocity along the start

No profile in space is needed. For e = 1, where a speed is kept, they are elementary.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.moments.backward import (
    DISPLACEMENT_ALONG_START,
    MSD_SLOPE,
    QUARTIC_DISPLACEMENT,
    SQUARED_DISPLACEMENT,
    Observable,
    moment_series,
    speed_power,
)
from kinetics.moments.velocity import Averages
from kinetics.numerics import FloatArray

# of v_rms t/l: below it no tracer has collided, and its fourth power is still in range
_FREE = math.log(1e-50)
_EARLY = 1.0  # T below which elastic moments are summed as power series, of 40 terms


def _free(averages: Averages) -> tuple[NDArray[np.bool_], FloatArray]:
    """At which times all tracers fly freely to rounding, and v_rms t then, in d; (n_times,) each.

    Later, powers of v t/l do not underflow.
    """
    log_first = 0.5 * averages.speeds.log_second_moment()
    free = log_first + averages.log_stretch < _FREE
    with np.errstate(over="ignore", under="ignore"):
        return free, np.where(free, math.exp(log_first) * averages.times, 0.0)


def root_mean_square(averages: Averages) -> FloatArray:
    """sqrt(<r^2>)(t) in d, shape (n_times,); also where <r^2> is out of range."""
    free, flight = _free(averages)
    root = averages.mean_free_path * np.sqrt(_squared_paths(averages))
    return np.where(free, flight, root)


def mean_square_displacement(averages: Averages) -> FloatArray:
    """<r^2>(t) in d^2, shape (n_times,)."""
    free, flight = _free(averages)
    path = averages.mean_free_path
    with np.errstate(over="ignore", under="ignore"):
        return np.where(free, flight**2, path * (path * _squared_paths(averages)))


def _squared_paths(averages: Averages) -> FloatArray:
    """<r^2>(t)/l^2, shape (n_times,)."""
    if not averages.elastic:
        return averages.average(SQUARED_DISPLACEMENT)
    # <v(0).v(t)> = v^2 exp(-nu v t/l), nu = 1 - <cos chi> = 4/3
    nu = averages.law.harmonic_decay_rate(0.0, 1)
    mean = _ballistic_to_diffusive(nu * _elastic_paths(averages)) @ averages.speeds.weight
    return np.asarray(2.0 / nu**2 * mean)


def kurtosis(averages: Averages) -> FloatArray:
    """<r^4>/<r^2>^2, shape (n_times,); at t = 0 its limit, <v^4>/<v^2>^2."""
    if averages.elastic:
        return _elastic_kurtosis(averages)
    second = averages.average(SQUARED_DISPLACEMENT, leading=2)
    return np.asarray(averages.average(QUARTIC_DISPLACEMENT, leading=4) / second**2)


def velocity_autocorrelation(averages: Averages) -> FloatArray:
    """<v(0) . v(t)> in U^2, shape (n_times,); negative where most bounces go backwards."""
    first = 0.5 * averages.speeds.log_second_moment()
    if averages.elastic:
        nu = averages.law.harmonic_decay_rate(0.0, 1)
        with np.errstate(under="ignore"):
            kept = np.exp(2.0 * (averages.speeds.x - first) - nu * _elastic_paths(averages))
        return np.asarray(math.exp(2.0 * first) * (kept @ averages.speeds.weight))
    found = averages.average(speed_power(1.0, 1), m=0, start=1.0)
    return np.asarray(found * np.exp(first + averages.log_reference))


def diffusion_coefficient(averages: Averages) -> tuple[FloatArray, FloatArray]:
    """D(t) = (1/4) d<r^2>/dt in d U, and the slope d<r^2>/d ln t = 4 D t in d^2, (n_times,) each.

    The elastic D tends to (3/8) l <v>; for e < 1 the slope tends to
    2 l^2/(kappa (1 - <cos chi>)).
    """
    path, times = averages.mean_free_path, averages.times
    free, flight = _free(averages)
    if averages.elastic:
        nu = averages.law.harmonic_decay_rate(0.0, 1)
        first = 0.5 * averages.speeds.log_second_moment()
        with np.errstate(under="ignore"):
            done = -np.expm1(-nu * _elastic_paths(averages)) / nu
        speeds = np.exp(averages.speeds.x - first)
        value = path * ((done * speeds) @ averages.speeds.weight)
        value = 0.5 * math.exp(first) * np.where(free, flight, value)
        with np.errstate(over="ignore", under="ignore"):
            return value, np.where(free, 2.0 * flight**2, 4.0 * value * times)
    mean = averages.average(MSD_SLOPE)
    speed = np.exp(averages.log_reference)
    # T_ref = v_ref t/l stays of order 1 late: no power of t over- or underflows
    with np.errstate(over="ignore", under="ignore"):
        stretch = np.exp(averages.log_reference + averages.log_stretch)
        value = np.where(free, 0.5 * speed * flight, 0.25 * path * mean * speed)
        return value, np.where(free, 2.0 * flight**2, path * (path * mean * stretch))


def mean_displacement(averages: Averages) -> FloatArray:
    """<r>(t) of a directed start in d, shape (n_times, 2)."""
    found = averages.measure(1)
    if found is None:
        return np.zeros((averages.times.size, 2))
    if averages.elastic:
        nu = averages.law.harmonic_decay_rate(0.0, 1)
        with np.errstate(over="ignore", under="ignore"):
            paths = np.exp(found.x + averages.log_stretch[:, None])
            along: NDArray[Any] = -np.expm1(-nu * paths) @ found.weight / nu
    else:
        along = averages.average(DISPLACEMENT_ALONG_START)
    free, flight = _free(averages)
    first = 0.5 * averages.speeds.log_second_moment()
    freely = flight * (np.exp(found.x - first) @ found.weight)
    along = np.where(free, freely, averages.mean_free_path * along)
    return np.stack([along.real, -along.imag], axis=-1)


# -- the elastic case -----------------------------------------------------------------------------


def _elastic_paths(averages: Averages) -> FloatArray:
    """T = v t/l, shape (n_times, n_points)."""
    with np.errstate(over="ignore"):
        return np.exp(averages.speeds.x + averages.log_stretch[:, None])


def _ballistic_to_diffusive(x: FloatArray) -> FloatArray:
    """x - 1 + exp(-x), by its series where that cancels: 14 terms leave 0.3^14/14! = 5e-19."""
    small = x < 0.3
    near = np.where(small, x, 0.0)
    # x^2/2 (1 - x/3 (1 - x/4 (1 - ...)))
    nested = np.ones_like(x)
    for k in range(14, 2, -1):
        nested = 1.0 - near / k * nested
    with np.errstate(under="ignore"):
        direct = x - 1.0 + np.exp(-x)
    return np.asarray(np.where(small, 0.5 * near**2 * nested, direct))


def _elastic_kurtosis(averages: Averages) -> FloatArray:
    """From the moments at each speed, in units that fit each time: T_ref^2 early, T_ref late."""
    log_path = averages.speeds.x + averages.log_stretch[:, None]
    reference = averages.log_stretch + 0.5 * averages.speeds.log_second_moment()
    weight = averages.speeds.weight
    unit = np.where(reference < 0.0, 2.0 * reference, reference)[:, None]
    moments = []
    for y, order in ((SQUARED_DISPLACEMENT, 2), (QUARTIC_DISPLACEMENT, 4)):
        with np.errstate(invalid="ignore", under="ignore"):
            log_moment = _log_elastic_moment(averages.law, y, order, log_path)
            # at t = 0, where both logarithms are -inf, the ballistic limit
            start = order * (averages.speeds.x - 0.5 * averages.speeds.log_second_moment())
            still = np.isneginf(log_path)
            share = np.where(still, np.exp(start), np.exp(log_moment - 0.5 * order * unit))
        moments.append(share @ weight)
    return np.asarray(moments[1] / moments[0] ** 2)


def _log_elastic_moment(
    law: CollisionLaw, y: Observable, order: int, log_path: FloatArray
) -> FloatArray:
    """ln(<r^order>/l^order) of a tracer that keeps its speed, order 2 or 4, at ln(v t/l).

    <r^4> is the inverse Laplace transform of 16/(p^2 (p+a)^2) (1/p + 1/(2 (p+b))), with a and b
    the decay rates of the harmonics 1 and 2, by partial fractions.
    """
    early = log_path < math.log(_EARLY)
    series = moment_series(law, y)[order:]
    with np.errstate(under="ignore"):
        near = np.polynomial.polynomial.polyval(np.exp(np.where(early, log_path, 0.0)), series)
    first = order * log_path + np.log(near)
    a, b = law.harmonic_decay_rate(0.0, 1), law.harmonic_decay_rate(0.0, 2)
    far = np.maximum(log_path, math.log(_EARLY))
    with np.errstate(under="ignore"):
        inverse = np.exp(-far)  # 1/T: the moments over their leading power of T
        path = np.exp(np.minimum(far, 50.0))
        fall_a, fall_b = np.exp(-a * path), np.exp(-b * path)
        if order == 2:
            late = 2.0 / a**2 * (a - inverse * (1.0 - fall_a))
            return np.asarray(np.where(early, first, far + np.log(late)))
        triple = 8.0 / a**2 + inverse * (-32.0 / a**3 + inverse * 48.0 / a**4)
        triple -= inverse * fall_a * (16.0 / a**3 + inverse * 48.0 / a**4)
        f, g = 8.0 / (a * a * b), 8.0 / (a * a * (b - a))
        double = inverse * (f + inverse * f * (-2.0 / a - 1.0 / b))
        double += inverse * fall_a * (g + inverse * g * (2.0 / a - 1.0 / (b - a)))
        double += inverse**2 * fall_b * 8.0 / (b * b * (a - b) ** 2)
        return np.asarray(np.where(early, first, 2.0 * far + np.log(triple + double)))
