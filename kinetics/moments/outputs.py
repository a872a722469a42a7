"""Outputs that are made of averages: one function and one row of a table for each.

To add one, write a function that makes its array from `Averages`, and add its row to the table in
:func:`averaged_outputs`: the row says which averages it is made of, so that its error estimate, and
what is solved for it, follow. Then add its row to
`kinetics.outputs.ALL_OUTPUTS`.

Speeds are in U, lengths in d, times in d/U. l is the mean free path and kappa = E[-ln s] the mean
loss of ln v in a collision.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.moments.averages import Averages
from kinetics.moments.observables import (
    DISPLACEMENT_ALONG_START,
    MEAN_COLLISIONS,
    MSD_SLOPE,
    SQUARED_DISPLACEMENT,
    Observable,
    quartic_displacement,
    speed_power,
)
from kinetics.numerics import LARGEST_LOG, FloatArray, NumberArray

#: v^2.
SQUARED_SPEED = speed_power(2.0)
#: v cos(phi - phi_0), phi_0 the initial direction.
VELOCITY_ALONG_START = speed_power(1.0, 1)


@dataclass(frozen=True)
class Ingredient:
    """One average that an output is made of.

    Parameters
    ----------
    observable : what is averaged
    error_factor : how many times its relative error enters that of the output
    start_harmonic : the harmonic of the initial state over which it is averaged; None: its own
    """

    observable: Observable
    error_factor: float = 1.0
    start_harmonic: int | None = None

    @property
    def averaged_over(self) -> int:
        """The harmonic of the initial state over which it is averaged."""
        if self.start_harmonic is None:
            return self.observable.harmonic
        return self.start_harmonic


@dataclass(frozen=True)
class AveragedOutput:
    """An output of a scene that is made of averages.

    Parameters
    ----------
    functions : make its arrays, in the order of their names in :data:`kinetics.outputs.OUTPUTS`
    ingredients : the averages that it is made of
    """

    functions: tuple[Callable[[Averages], FloatArray], ...]
    ingredients: tuple[Ingredient, ...]


@cache
def averaged_outputs(dimension: int) -> Mapping[str, AveragedOutput]:
    """Return the table of outputs that are made of averages, by name, in 2 or 3 dimensions."""
    squared_speed = Ingredient(SQUARED_SPEED)
    squared_displacement = Ingredient(SQUARED_DISPLACEMENT)
    return {
        "thermal_speed": AveragedOutput(
            (thermal_speed,), (Ingredient(SQUARED_SPEED, error_factor=0.5),)
        ),
        "temperature": AveragedOutput((temperature,), (squared_speed,)),
        "a2": AveragedOutput(
            (a2,), (Ingredient(SQUARED_SPEED, error_factor=2.0), Ingredient(speed_power(4.0)))
        ),
        "collisions": AveragedOutput((collisions,), (Ingredient(MEAN_COLLISIONS),)),
        "msd": AveragedOutput((msd,), (squared_displacement,)),
        "kurtosis": AveragedOutput(
            (kurtosis,),
            (
                Ingredient(SQUARED_DISPLACEMENT, error_factor=2.0),
                Ingredient(quartic_displacement(dimension)),
            ),
        ),
        # <v(0).v> is over all initial velocities: v(0) itself takes the direction out
        "velocity_autocorrelation": AveragedOutput(
            (velocity_autocorrelation,), (Ingredient(VELOCITY_ALONG_START, start_harmonic=0),)
        ),
        "diffusion_coefficient": AveragedOutput(
            (diffusion_coefficient, msd_slope), (Ingredient(MSD_SLOPE),)
        ),
        "mean_displacement": AveragedOutput(
            (mean_displacement,), (Ingredient(DISPLACEMENT_ALONG_START),)
        ),
        "mean_velocity": AveragedOutput((mean_velocity,), (Ingredient(VELOCITY_ALONG_START),)),
        "velocity_tensor": AveragedOutput(
            (velocity_tensor,), (squared_speed, Ingredient(speed_power(2.0, 2)))
        ),
    }


# -- the velocity ----------------------------------------------------------------------------------


def thermal_speed(averages: Averages) -> FloatArray:
    """Return v0 = sqrt(<v^2>) in U, shape (n_times,) (paper, label ``v0defi``)."""
    return np.asarray(np.exp(averages.log_reference) * np.sqrt(averages.power(2.0)))


def temperature(averages: Averages) -> FloatArray:
    """Return <v^2>/d in m U^2, shape (n_times,) (paper, label ``thermo``)."""
    square = np.exp(averages.log_reference) ** 2 * averages.power(2.0)
    return np.asarray(square / averages.law.dimension)


def a2(averages: Averages) -> FloatArray:
    """Return <v^4> d/((d+2) <v^2>^2) - 1, shape (n_times,) (paper, label ``sonine5``)."""
    gaussian = averages.law.dimension / (averages.law.dimension + 2.0)
    return np.asarray(gaussian * averages.power(4.0) / averages.power(2.0) ** 2 - 1.0)


def mean_velocity(averages: Averages) -> FloatArray:
    """Return (<v_x>, <v_y>) in U, shape (n_times, 2), from harmonic 1; in space (n_times, 3)."""
    along = np.exp(averages.log_reference) * averages.power(1.0, 1)
    return vector_of_harmonic(averages.law, along)


def velocity_tensor(averages: Averages) -> FloatArray:
    """Return <v_i v_j> in U^2 from harmonics 0 and 2: (n_times, 2, 2), in space (n_times, 3, 3)."""
    square_unit = np.exp(averages.log_reference) ** 2
    trace = square_unit * averages.power(2.0)
    second = square_unit * averages.power(2.0, 2)
    d = averages.law.dimension
    tensor = np.zeros((averages.times.size, d, d))
    tensor[:, 0, 0] = (trace + (d - 1.0) * second.real) / d
    for i in range(1, d):  # in space the rest is shared by y and z
        tensor[:, i, i] = (trace - second.real) / d
    off_diagonal = -0.5 * second.imag  # in space 0
    tensor[:, 0, 1] = off_diagonal
    tensor[:, 1, 0] = off_diagonal
    return tensor


def velocity_autocorrelation(averages: Averages) -> FloatArray:
    """Return <v(0) . v(t)> in U^2, (n_times,); negative where most bounces go backwards."""
    average = averages.average(VELOCITY_ALONG_START, start_harmonic=0, start_power=1.0)
    log_unit = averages.reference.log_initial + averages.log_reference
    return np.asarray(average * np.exp(log_unit))


# -- collisions and the displacement ---------------------------------------------------------------


def collisions(averages: Averages) -> FloatArray:
    """Return the mean number of collisions of a tracer since t = 0, shape (n_times,)."""
    return np.array(averages.average(MEAN_COLLISIONS))


def mean_displacement(averages: Averages) -> FloatArray:
    """Return <r>(t) of a directed start in d, shape (n_times, 2), in space (n_times, 3)."""
    along = averages.average(DISPLACEMENT_ALONG_START, leading=1)
    return vector_of_harmonic(averages.law, along * _flown(averages))


def root_mean_square_displacement(averages: Averages) -> FloatArray:
    """Return sqrt(<r^2>)(t) in d, shape (n_times,); also where <r^2> is out of range."""
    square = averages.average(SQUARED_DISPLACEMENT, leading=2)
    return np.asarray(np.sqrt(square) * _flown(averages))


def msd(averages: Averages) -> FloatArray:
    """Return <r^2>(t) in d^2, shape (n_times,)."""
    with np.errstate(over="ignore", under="ignore"):
        return root_mean_square_displacement(averages) ** 2


def kurtosis(averages: Averages) -> FloatArray:
    """Return <r^4>/<r^2>^2, shape (n_times,); at t = 0 its limit, <v^4>/<v^2>^2."""
    if averages.law.is_elastic:
        # late it stands still, and fourth powers of v t/l overflow: earlier times do as well
        log_speed = averages.reference.log_initial
        log_latest = LARGEST_LOG / 6.0 - log_speed + math.log(averages.mean_free_path)
        latest = math.exp(min(log_latest, LARGEST_LOG))
        if averages.times[-1] > latest:
            averages = averages.at_times(np.minimum(averages.times, latest))
    second = averages.average(SQUARED_DISPLACEMENT, leading=2)
    fourth = averages.average(quartic_displacement(averages.law.dimension), leading=4)
    return np.asarray(fourth / second**2)


def diffusion_coefficient(averages: Averages) -> FloatArray:
    """Return D(t) = d<r^2>/dt/(2 d) in d U, shape (n_times,).

    The elastic D tends to (3/8) l <v> in the plane and (1/3) l <v> in space.
    """
    slope = averages.average(MSD_SLOPE, leading=1)
    with np.errstate(over="ignore", under="ignore"):
        speed = np.exp(averages.log_reference) / (2.0 * averages.law.dimension)
        return np.asarray(slope * _flown(averages) * speed)


def msd_slope(averages: Averages) -> FloatArray:
    """Return d<r^2>/d ln t in d^2, shape (n_times,).

    That of tracers that cool tends to 2 l^2/(kappa (1 - <cos chi>)).
    """
    slope = averages.average(MSD_SLOPE, leading=1)
    flown = _flown(averages)
    with np.errstate(over="ignore", under="ignore"):
        return np.asarray(slope * flown * flown)


def _flown(averages: Averages) -> FloatArray:
    """Return v_ref t in d, (n_times,): averages of T^-n y times its n-th power do not underflow."""
    return np.asarray(np.exp(averages.log_reference) * averages.times)


def vector_of_harmonic(law: CollisionLaw, along: NumberArray) -> FloatArray:
    """Return the vector of which `along`, (n_times,), is harmonic 1: shape (n_times, dimension).

    In space the harmonic is real, and the vector along the x axis.
    """
    vector = np.zeros((along.size, law.dimension))
    vector[:, 0] = along.real
    vector[:, 1] = -along.imag
    return vector
