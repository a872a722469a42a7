"""How wrong the equation itself is at a finite density: stated errors, from simulations.

The solver's error estimate is of the numerics alone. Among scatterers of a finite density the
equation is of first order in n, the number density times d^2, with fitted terms of the next, so
that a solution that has converged is still off. `measured_errors.json` has deviations of
simulations from the equation, and their standard errors, on a grid of restitutions, densities and
times, in both media; tests/kinetics/measurements/model_error.py makes it again. What is stated is
an envelope of these, no standard deviation:

- of each point of the grid the deviation's size and two standard errors;
- below n = `MEASURED_ONE_BY_ONE_FROM` single deviations are within their standard errors: there it
  is that of the line a + b ln n through deviations over n, of all densities from 0.01 to 0.1;
- between times of the grid the largest of them and of their neighbours, between restitutions, and
  between densities, straight interpolation;
- above the largest restitution below 1 what is of the speed alone has the error of that one at the
  time at which it has lost as much, t (1 - e^2): at e = 1 none;
- it does not fall with the density;
- before the first time of the grid it grows in proportion to the time, after the last it is held;
  so it is below the least restitution;
- below the least density of the envelope its ratio to n grows as ln(1/n).

Errors are relative to `SIZES`. Begin with :func:`stated_error`.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import TypedDict

import numpy as np

from kinetics.collision.medium import Medium
from kinetics.numerics import FloatArray

#: From this density on each deviation stands for itself.
MEASURED_ONE_BY_ONE_FROM = 0.05
#: Lowest density n whose deviations the line is drawn through: lower ones of the grid are for a
#: test.
LINE_FROM = 0.01
#: Highest density n of the line. The origin of the number is not recorded.
LINE_TO = 0.1
#: Densities that a line needs: where fewer were measured, as at late times, it is held in time.
LEAST_POINTS_OF_LINE = 3
#: Densities n below `MEASURED_ONE_BY_ONE_FROM` at which the envelope is made from the line. Chosen:
#: each the double of the one before, as interpolation between them is straight.
LOW_DENSITIES = (0.0025, 0.005, 0.01, 0.02)
#: Standard errors that are added to a deviation. Chosen: 95 % of a Gaussian are within.
STANDARD_ERRORS = 2.0
#: Deviations in the file are in these of n.
UNIT_OF_FILE = 1e-3
#: Order of the theory that was measured.
MEASURED_ORDER = "second"
#: The averages and distributions that are of the speed alone: at e = 1 they have no error.
OF_SPEED = ("thermal_speed", "mean_speed", "a2", "speed_density")

#: What an error is relative to, where that is not the size of the quantity.
SIZES = {
    "a2": "1 + a2",
    "velocity_autocorrelation": "v_rms(0) v_rms(t)",
    "mean_velocity": "v_rms(t)",
    "mean_displacement": "sqrt(<r^2>)",
    "speed_density": "all tracers: the share slower than v, at the worst v",
    "velocity_density": "all tracers: the share slower than v, at the worst v",
    "position_density": "all tracers: the share nearer than r, at the worst r",
    "scaled_position_density": "all tracers: the share nearer than r, at the worst r",
    "intermediate_scattering": "1, at the worst k",
}

#: The measured quantity that an array of a Solution has the error of, where the names differ.
MEASURED_AS = {
    "temperature": "thermal_speed",
    "velocity_tensor": "thermal_speed",
    "msd_slope": "diffusion_coefficient",
    "mean_velocity": "velocity_autocorrelation",
    "velocity_density": "speed_density",
    "scaled_position_density": "position_density",
}
#: Arrays that are the square of what was measured.
SQUARES = ("temperature", "velocity_tensor")


@dataclass(frozen=True, eq=False)
class Envelope:
    """The stated error of one quantity in one medium.

    Parameters
    ----------
    densities, restitutions, times : the grid, rising; times in l/U, l = 1/(2 n) d
    error : relative, shape (n_densities, n_restitutions, n_times)
    """

    densities: FloatArray
    restitutions: FloatArray
    times: FloatArray
    error: FloatArray

    def at(self, density: float, restitution: float, times: FloatArray) -> FloatArray:
        """Return the relative error at times in l/U, shape (n_times,)."""
        highest = self.restitutions[-1]
        if restitution > highest:  # of the speed alone, which is lost as (1 - e^2) t
            times = times * (1.0 - restitution**2) / (1.0 - highest**2)
        at_restitution = _interpolate(restitution, self.restitutions, self.error, axis=1)
        at_density = _interpolate(density, self.densities, at_restitution, axis=0)
        least = self.densities[0]
        if density < least:
            at_density = at_density * (density * math.log(density)) / (least * math.log(least))
        with np.errstate(divide="ignore"):
            of_times = np.interp(np.log(times), np.log(self.times), at_density)
        return np.asarray(of_times * np.minimum(times / self.times[0], 1.0))


def _interpolate(x: float, points: FloatArray, values: FloatArray, axis: int) -> FloatArray:
    """Return values at x, straight between points of an axis and held beyond them."""
    place = float(np.interp(x, points, np.arange(points.size)))
    low = min(int(place), points.size - 2)
    below = np.take(values, low, axis=axis)
    above = np.take(values, low + 1, axis=axis)
    return np.asarray(below + (place - low) * (above - below))


class Document(TypedDict):
    """The file of measured deviations; times are in l/U."""

    times: list[float]
    restitution: list[float]
    density: list[float]
    distributions: list[str]
    times_of_distributions: list[float]
    systems: dict[str, dict[str, list[list[float]]]]


@cache
def _document() -> Document:
    """Return the file of measured deviations."""
    text = files("kinetics.collision").joinpath("measured_errors.json").read_text("utf-8")
    document: Document = json.loads(text)
    return document


@cache
def envelope(quantity: str, scatterers: str) -> Envelope:
    """Return the envelope of a measured quantity among "hard disks" or "overlapping disks" ones."""
    document = _document()
    restitutions = np.array(document["restitution"])
    times = np.array(document["times"])
    is_average = quantity not in document["distributions"]
    if not is_average:
        times = np.array(document["times_of_distributions"])
    densities = np.array(document["density"])
    deviations, errors = _measured(document, quantity, scatterers, densities, times.size)
    is_single = densities >= MEASURED_ONE_BY_ONE_FROM
    bounds = np.abs(deviations) + STANDARD_ERRORS * errors
    bounds = bounds[is_single]
    rising = densities[is_single]
    if is_average:
        is_on_line = (densities >= LINE_FROM) & (densities <= LINE_TO)
        low = np.array(LOW_DENSITIES)
        of_line = _bounds_of_line(
            densities[is_on_line], deviations[is_on_line], errors[is_on_line], low
        )
        bounds = np.concatenate([of_line, bounds])
        rising = np.concatenate([low, rising])
    if quantity in OF_SPEED:  # of elastic tracers there is no error
        is_inelastic = restitutions < 1.0
        bounds = bounds[:, is_inelastic]
        restitutions = restitutions[is_inelastic]
    bounds = _largest_nearby(_held(bounds))
    not_falling = np.maximum.accumulate(rising[:, None, None] * bounds, axis=0)
    return Envelope(rising, restitutions, times, not_falling)


def _measured(
    document: Document, quantity: str, scatterers: str, densities: FloatArray, n_times: int
) -> tuple[FloatArray, FloatArray]:
    """Return deviations over n, and their standard errors, (n_densities, n_restitutions, n_times).

    NaN where nothing was measured.
    """
    restitutions = document["restitution"]
    measured = np.full((2, densities.size, len(restitutions), n_times), np.nan)
    for i, n in enumerate(densities):
        for j, e in enumerate(restitutions):
            system = document["systems"].get(f"{scatterers}, n = {n:g}, e = {e:g}", {})
            if quantity in system:
                rows = UNIT_OF_FILE * np.array(system[quantity])
                measured[:, i, j, : rows.shape[1]] = rows
    return measured[0], measured[1]


def _bounds_of_line(
    densities: FloatArray, deviations: FloatArray, errors: FloatArray, low: FloatArray
) -> FloatArray:
    """Return the bounds at low densities of lines a + b ln n through deviations over n.

    Parameters
    ----------
    densities : of the deviations, shape (n_densities,)
    deviations, errors : over n, shape (n_densities, n_restitutions, n_times)
    low : shape (n_low,)

    Returns
    -------
    array of shape (n_low, n_restitutions, n_times); NaN where few were measured
    """
    bounds = np.full((low.size, *deviations.shape[1:]), np.nan)
    basis = np.stack([np.ones(densities.size), np.log(densities)], axis=1)
    basis_low = np.stack([np.ones(low.size), np.log(low)], axis=1)
    for place in np.ndindex(*deviations.shape[1:]):
        error = errors[:, *place]
        is_used = error > 0.0
        if np.count_nonzero(is_used) < LEAST_POINTS_OF_LINE:
            continue
        weighted = basis[is_used] / error[is_used, None]
        covariance = np.linalg.inv(weighted.T @ weighted)
        line = covariance @ weighted.T @ (deviations[:, *place][is_used] / error[is_used])
        error_of_line = np.sqrt(np.sum((basis_low @ covariance) * basis_low, axis=1))
        bounds[:, *place] = np.abs(basis_low @ line) + STANDARD_ERRORS * error_of_line
    return bounds


def _held(bounds: FloatArray) -> FloatArray:
    """Return bounds with what is missing at late times held from the time before."""
    filled = bounds.copy()
    for time in range(1, bounds.shape[2]):
        before = filled[:, :, time - 1]
        filled[:, :, time] = np.where(np.isnan(filled[:, :, time]), before, filled[:, :, time])
    return filled


def _largest_nearby(bounds: FloatArray) -> FloatArray:
    """Return the largest of each bound and its neighbours in time."""
    padded = np.pad(bounds, ((0, 0), (0, 0), (1, 1)), mode="edge")
    return np.maximum(np.maximum(padded[:, :, :-2], padded[:, :, 2:]), bounds)


def stated_error(name: str, medium: Medium, times: FloatArray) -> FloatArray:
    """Return the error of the equation itself, over the size of the quantity (`SIZES`).

    It is the largest deviation that simulations saw near this point, with two standard errors of
    theirs.

    Parameters
    ----------
    name : of an array, or of a function, of a Solution; or "mean_speed"
    medium : the scatterers, their density and the restitution
    times : in l/U, l = 1/(2 n) d and U that of a Gaussian start, shape (n_times,)

    Returns
    -------
    array of shape (n_times,); NaN at orders of the theory that were not measured
    """
    if medium.order != MEASURED_ORDER:
        return np.full(times.size, np.nan)
    quantity = MEASURED_AS.get(name, name)
    error = envelope(quantity, medium.scatterers).at(medium.density, medium.restitution, times)
    if name in SQUARES:
        return np.asarray((1.0 + error) ** 2 - 1.0)
    return error
