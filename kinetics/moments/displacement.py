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
    SQUARED_DISPLACEMENT,
    Observable,
    moment_series,
    quartic_displacement,
    speed_power,
)
from kinetics.moments.formulas import as_vector
from kinetics.moments.velocity import Averages
from kinetics.numerics import FloatArray

# of v_rms t/l: below it no tracer has collided, and its fourth power is still in range
_FREE = math.log(1e-50)
# b - a over a below which partial fractions lose digits, and the terms of a series that does not
_APART, _CLOSE_TERMS = 1e-2, 8
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
    fourth = averages.average(quartic_displacement(averages.law.dimension), leading=4)
    return np.asarray(fourth / second**2)


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
    """D(t) = d<r^2>/dt/(2 d) in d U, and the slope d<r^2>/d ln t in d^2, (n_times,) each.

    The elastic D tends to (3/8) l <v> in the plane and (1/3) l <v> in space; tracers that cool have
    a slope that tends to 2 l^2/(kappa (1 - <cos chi>)).
    """
    twice = 2.0 * averages.law.dimension
    path, times = averages.mean_free_path, averages.times
    free, flight = _free(averages)
    if averages.elastic:
        nu = averages.law.harmonic_decay_rate(0.0, 1)
        first = 0.5 * averages.speeds.log_second_moment()
        with np.errstate(under="ignore"):
            done = -np.expm1(-nu * _elastic_paths(averages)) / nu
        speeds = np.exp(averages.speeds.x - first)
        value = path * ((done * speeds) @ averages.speeds.weight)
        value = 2.0 / twice * math.exp(first) * np.where(free, flight, value)
        with np.errstate(over="ignore", under="ignore"):
            return value, np.where(free, 2.0 * flight**2, twice * value * times)
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
    return as_vector(averages, along)


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
    fourth = quartic_displacement(averages.law.dimension)
    for y, order in ((SQUARED_DISPLACEMENT, 2), (fourth, 4)):
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
    the decay rates of the harmonics 1 and 2; in space of 40/(3 p^2 (p+a)^2) (1/p + 4/(5 (p+b))).
    """
    early = log_path < math.log(_EARLY)
    series = moment_series(law, y)[order:]
    with np.errstate(under="ignore"):
        near = np.polynomial.polynomial.polyval(np.exp(np.where(early, log_path, 0.0)), series)
    first = order * log_path + np.log(near)
    far = np.maximum(log_path, math.log(_EARLY))
    with np.errstate(under="ignore"):
        late = _late_square(law, far) if order == 2 else _late_fourth(law, far)
    return np.asarray(np.where(early, first, 0.5 * order * far + np.log(late)))


def _late_square(law: CollisionLaw, log_path: FloatArray) -> FloatArray:
    """<r^2>/(l^2 T) at ln T = log_path."""
    a = law.harmonic_decay_rate(0.0, 1)
    fall = np.exp(-a * np.exp(np.minimum(log_path, 50.0)))
    return np.asarray(2.0 / a**2 * (a - np.exp(-log_path) * (1.0 - fall)))


def _late_fourth(law: CollisionLaw, log_path: FloatArray) -> FloatArray:
    """<r^4>/(l^4 T^2) at ln T = log_path, by partial fractions."""
    a, b = law.harmonic_decay_rate(0.0, 1), law.harmonic_decay_rate(0.0, 2)
    first, second = (16.0, 8.0) if law.dimension == 2 else (40.0 / 3.0, 32.0 / 3.0)
    inverse = np.exp(-log_path)  # 1/T: the moments over their leading power of T
    path = np.exp(np.minimum(log_path, 50.0))
    fall_a, fall_b = np.exp(-a * path), np.exp(-b * path)
    triple = 0.5 / a**2 + inverse * (-2.0 / a**3 + inverse * 3.0 / a**4)
    triple -= inverse * fall_a * (1.0 / a**3 + inverse * 3.0 / a**4)
    if abs(b - a) > _APART * a:
        f, g = 1.0 / (a * a * b), 1.0 / (a * a * (b - a))
        double = inverse * (f + inverse * f * (-2.0 / a - 1.0 / b))
        double += inverse * fall_a * (g + inverse * g * (2.0 / a - 1.0 / (b - a)))
        double += inverse**2 * fall_b / (b * b * (a - b) ** 2)
    else:
        # 1/(p+b) as a series in b - a: smooth elastic spheres have a = b = 1
        double = np.zeros_like(path)
        for n in range(_CLOSE_TERMS):
            double += (a - b) ** n * inverse**2 * _double_pole(a, n + 3, path, fall_a)
    return np.asarray(first * triple + second * double)


def _double_pole(a: float, n: int, path: FloatArray, fall: FloatArray) -> FloatArray:
    """The inverse Laplace transform of 1/(p^2 (p+a)^n) at T = path, fall = exp(-a T)."""
    out = path / a**n - n / a ** (n + 1)
    term = fall.copy()
    for j in range(1, n + 1):
        out = out + (n - j + 1) / a ** (n - j + 2) * term
        term = term * path / j
    return np.asarray(out)
