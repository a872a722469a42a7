"""The error of the equation itself, beside the solver's: of every output of a scene.

For dilute scatterers the equation is exact, and the error 0. At a finite density it is what
`kinetics.collision.measured_errors` states. Begin with :func:`model_errors`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Protocol

import numpy as np

from kinetics.collision.measured_errors import stated_error
from kinetics.collision.medium import TESTED_DENSITY
from kinetics.numerics import FloatArray
from kinetics.scene import Scene

#: Accuracy of the initial speed that sets the unit of time. Chosen: errors vary slowly with time.
RTOL_OF_SPEED = 1e-6


class Solved(Protocol):
    """What the sizes of errors need of a solution; see `kinetics.Solution`."""

    @property
    def scene(self) -> Scene:
        """The scene that was solved."""

    @property
    def values(self) -> Mapping[str, FloatArray]:
        """Averages over the tracers at each time, by name; the time is the first axis."""

    @property
    def model_error(self) -> Mapping[str, FloatArray]:
        """The relative errors, by name."""

    @property
    def root_mean_square_displacement(self) -> FloatArray:
        """sqrt(<r^2>) in d, shape (n_times,)."""

    def moment(self, p: float) -> FloatArray:
        """<v^p>(t) in U^p, shape (n_times,)."""


def model_errors(scene: Scene, names: Iterable[str]) -> dict[str, FloatArray]:
    """Return the relative error of the equation for outputs of a scene, (n_times,) each.

    Parameters
    ----------
    names : of arrays, or of functions, of a Solution
    """
    n_times = np.size(scene.times)
    if scene.scatterers == "dilute":
        return {name: np.zeros(n_times) for name in names}
    medium = scene.law.medium
    assert medium is not None  # as scatterers are not dilute
    times = _times_in_paths(scene)
    errors = {}
    for name in names:
        errors[name] = stated_error(name, medium, times)
        if name == "velocity_tensor" and scene.state.highest_harmonic != 0:
            errors[name] = np.full(n_times, np.nan)  # its second harmonic was not measured
    return errors


def absolute_errors(solution: Solved) -> dict[str, FloatArray]:
    """Return the errors of averages in their own units, of the shapes of these."""
    errors = {}
    for name, values in solution.values.items():
        error = _size(solution, name) * solution.model_error[name]
        errors[name] = np.broadcast_to(
            error.reshape(error.shape + (1,) * (values.ndim - 1)), values.shape
        )
    return errors


def summary(errors: Mapping[str, FloatArray]) -> str:
    """Return the largest error over the times of each output, in words."""
    figures = []
    for name, error in errors.items():
        largest = float(np.max(error, initial=0.0))
        figure = "not measured" if np.isnan(largest) else f"{100.0 * largest:.2g} %"
        figures.append(f"{name} {figure}")
    return ", ".join(figures)


def warning_of_density(solution: Solved) -> str:
    """Return a warning of a density above those that the equation was fitted to; perhaps empty."""
    scene = solution.scene
    density = scene.density_in_diameters
    if scene.scatterers == "dilute" or density <= TESTED_DENSITY:
        return ""
    return (
        f"number_density: n = {density:g} is above {TESTED_DENSITY:g}, up to which the equation "
        f"was fitted; its own error is up to: {summary(solution.model_error)} (model_error)"
    )


def _times_in_paths(scene: Scene) -> FloatArray:
    """Return times over those in which a tracer of the start flies 1/(2 rho d), as of a Gaussian.

    Errors were measured from Gaussian starts, whose v_rms is sqrt(2) U.
    """
    speed = np.exp(_log_start_speed(scene))
    rate = 2.0 * scene.number_density * scene.diameter * speed
    return np.asarray(rate * np.asarray(scene.times))


def _log_start_speed(scene: Scene) -> float:
    """Return the logarithm of the start's v_rms over that of a Gaussian."""
    speeds = scene.state.harmonic(0, RTOL_OF_SPEED)
    assert speeds is not None  # the isotropic part of a state is there
    return 0.5 * (speeds.log_second_moment() - float(np.log(2.0)))


def _size(solution: Solved, name: str) -> FloatArray:
    """Return what the error of an average is relative to, in its unit, shape (n_times,)."""
    values = np.asarray(solution.values[name])
    if name == "a2":
        return np.asarray(1.0 + values)
    if name == "mean_displacement":
        return solution.root_mean_square_displacement
    if name == "mean_velocity":
        return np.sqrt(solution.moment(2.0))
    if name == "velocity_autocorrelation":
        rms_at_start = np.sqrt(2.0) * np.exp(_log_start_speed(solution.scene))
        return np.asarray(rms_at_start * np.sqrt(solution.moment(2.0)))
    return np.abs(values).reshape(values.shape[0], -1).max(axis=1)
