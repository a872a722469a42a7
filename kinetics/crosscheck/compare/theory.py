"""What the kinetic equation says of components of data at a `Point`: begin with `Theory`."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision.measured_errors import MEASURED_ORDER, stated_error
from kinetics.collision.medium import Medium
from kinetics.crosscheck.compare.frames_theory import mean_square_between_frames
from kinetics.crosscheck.compare.measured import Layout
from kinetics.crosscheck.compare.observables import BETWEEN_FRAMES, MEAN_SPEED, OBSERVABLES, Array
from kinetics.crosscheck.compare.point import Point
from kinetics.crosscheck.data.sample import Law
from kinetics.errors import ModelWarning, ToleranceWarning
from kinetics.scene import Scene
from kinetics.solution import Solution
from kinetics.solving import solve

#: Solutions that a theory keeps. Chosen: a fit looks at some tens of points.
MAX_KEPT = 64
#: The stated error of the equation is the largest that simulations saw: taken to be so many of its
#: standard deviations. Chosen: of some hundred points the largest is beyond two of a Gaussian.
DEVIATIONS_STATED = 2.0
#: Correlation of the errors of v0 and of <r^2>: both are one error of the collision rate. Measured
#: by tests/kinetics/measurements/density.py.
RATE_CORRELATION = 0.9
#: Errors of the theory at two times are correlated by exp(-3 x^2), x the decades between them.
#: Measured as above: they are smooth over 0.4 of a decade. Those of two pairs of frames are so too
#: in the decades between s + l of the earlier frames s: with one later frame 0.9, 0.7 and 0.6 of
#: them is common at 0.1, 0.3 and 0.5 decades (simulations as of `BETWEEN_FRAMES_ERROR`).
DECAY_OF_CORRELATION = 3.0
#: Relative standard deviation of the theory of the mean square between two frames over n. Measured
#: at e = 0.4, 0.7 and 0.9 and n = 0.02, 0.04 and 0.1 with 150,000 to 500,000 tracers, each among
#: hard disks of its own, up to 32 l/U: the root mean square is 0.09, the largest 0.3.
BETWEEN_FRAMES_ERROR = 0.25
#: It has grown to 1 - 1/e of its size after this many mean free paths: there is none before there
#: are collisions. Chosen: simulations show it in full from 0.1 l/U on.
ERROR_GROWS_IN = 0.1
#: Speeds at which a density is summed for a mean, from this fraction of the least thermal speed on.
LOWEST_SPEED = 1e-4
#: Up to this speed in U.
HIGHEST_SPEED = 8.0
#: So many of them: the mean is right to 1e-5.
N_SPEEDS = 400


def solve_at(
    point: Point, law: Law, times: Array, outputs: Sequence[str], rtol: float | None = None
) -> Solution:
    """Solve the equation of a point; times in d/U; those who ask look at the status.

    Parameters
    ----------
    outputs : names of outputs of a Scene
    rtol : of the solver; None for that of averages
    """
    system = {name: value for name, value in vars(law).items() if name != "restitution"}
    scene = Scene(
        restitution=point.restitution,
        number_density=law.free_path(point.path),
        initial=point.start,
        times=times,
        scatterers=point.scatterers,
        outputs=tuple(dict.fromkeys(outputs)),
        **system,
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ToleranceWarning)
        warnings.simplefilter("ignore", ModelWarning)  # the covariance has it
        return solve(scene, rtol=law.rtol if rtol is None else rtol)


def mean_speeds(point: Point, law: Law, times: Array) -> Array:
    """Return <v> at each time, from the density of the speed; times in d/U."""
    solution = solve_at(point, law, times, ("speed_density", "thermal_speed"))
    slowest = LOWEST_SPEED * float(np.min(solution.thermal_speed))
    speeds = np.geomspace(slowest, HIGHEST_SPEED, N_SPEEDS)
    density = np.asarray(solution.speed_density(speeds))
    weighted = density * speeds  # in the logarithm of the speed
    steps = np.log(speeds)
    of_speed = np.trapezoid(weighted * speeds, steps, axis=1)
    return np.asarray(of_speed / np.trapezoid(weighted, steps, axis=1))


class Theory:
    """The theory of some components; it keeps the solutions of the last `MAX_KEPT` motions.

    Parameters
    ----------
    layout : what the components are
    has_velocities : whether velocities were measured: then a position error is one of the
        displacement, of positions alone it is one of each position
    """

    def __init__(self, layout: Layout, has_velocities: bool = True) -> None:
        self.layout = layout
        self.has_velocities = has_velocities
        self._motions: dict[tuple[Any, ...], Array] = {}

    def values(self, point: Point) -> Array:
        """Return the theory of each component, as the data have it, shape (n_components,)."""
        return self._as_measured(self._motion(point), point)

    def _motion(self, point: Point) -> Array:
        """Return the theory of the motion itself, in d and U; units of the data enter its clock."""
        key = (
            point.restitution,
            point.path,
            id(point.start),
            point.scatterers,
            point.clock,
            point.time_offset,
        )
        if key not in self._motions:
            if len(self._motions) >= MAX_KEPT:
                self._motions.pop(next(iter(self._motions)))
            self._motions[key] = self._solve_motion(point)
        return self._motions[key]

    def _solve_motion(self, point: Point) -> Array:
        layout = self.layout
        times = point.true_times(layout.times)
        outputs = {name: OBSERVABLES[name].output or name for name in layout.names}
        outputs.pop(MEAN_SPEED, None)
        parts: list[Array] = []
        if outputs:
            solution = solve_at(point, layout.law, times, tuple(outputs.values()))
        for name in layout.names:
            if name == MEAN_SPEED:
                parts.append(mean_speeds(point, layout.law, times))
            else:
                values = np.asarray(getattr(solution, outputs[name]), float)
                for index in reversed(OBSERVABLES[name].component):
                    values = values[..., index]
                parts.append(values)
        if layout.pairs is not None:
            pairs = layout.pairs
            squares = mean_square_between_frames(
                point, layout.law, times[pairs.earlier], times[pairs.later], solve_at
            )
            parts.append(squares)
        return np.concatenate(parts)

    def _as_measured(self, motion: Array, point: Point) -> Array:
        """Return the theory as data in other units, with noise or with tracers at rest have it.

        `pool._simulated_sums` does the same to simulated tracers.
        """
        layout = self.layout
        moving = 1.0 - point.at_rest
        values = motion.copy()
        values[layout.is_of("drift", MEAN_SPEED)] *= moving * point.speed_unit
        values[layout.is_of("mean_displacement")] *= moving * point.length_unit
        is_later = layout.time > 0.0
        noise_of_speed = np.where(is_later, point.velocity_noise, 0.0)
        noise_of_place = np.where(is_later, point.position_noise, 0.0)
        if not self.has_velocities:  # of both positions
            noise_of_place = 2.0 * noise_of_place

        speed = layout.is_of("thermal_speed")
        square = motion[speed] ** 2
        values[speed] = np.sqrt(
            self._second(square, noise_of_speed[speed], point.speed_unit, moving)
        )
        a2 = layout.is_of("a2")
        if np.any(a2):
            gaussian = layout.law.gaussian
            ratio = gaussian * (motion[a2] + 1.0)
            noise = noise_of_speed[a2]
            changed = self._ratio(ratio, square, noise, point.speed_unit, moving)
            values[a2] = changed / gaussian - 1.0
        msd = layout.is_of("msd")
        square = motion[msd]
        values[msd] = self._second(square, noise_of_place[msd], point.length_unit, moving)
        kurtosis = layout.is_of("kurtosis")
        if np.any(kurtosis):
            noise = noise_of_place[kurtosis]
            ratio = motion[kurtosis]
            values[kurtosis] = self._ratio(ratio, square, noise, point.length_unit, moving)
        frames = layout.is_of(BETWEEN_FRAMES)
        values[frames] = self._second(
            motion[frames], noise_of_place[frames], point.length_unit, moving
        )
        return values

    def _second(self, square: Array, noise: Array, unit: float, moving: float) -> Array:
        """Return a mean square in the data's unit, with noise of each component, of all tracers."""
        return np.asarray(moving * unit**2 * square + self.layout.law.dimension * noise)

    def _ratio(
        self, ratio: Array, square: Array, noise: Array, unit: float, moving: float
    ) -> Array:
        """Return <x^4>/<x^2>^2 with Gaussian noise of each component, of all tracers."""
        if moving == 1.0 and not np.any(noise):
            return ratio
        d = self.layout.law.dimension
        second = moving * unit**2 * square
        fourth = moving * unit**4 * ratio * square**2
        fourth = fourth + 2.0 * (d + 2) * second * noise + d * (d + 2) * noise**2
        total = self._second(square, noise, unit, moving)
        positive = np.where(total > 0.0, total, np.inf)
        return np.where(total > 0.0, fourth / positive**2, ratio)

    def is_exact(self, point: Point) -> NDArray[np.bool_]:
        """Return where an average has no scatter: speeds of elastic tracers that have one speed."""
        law = self.layout.law
        conserves_speed = (
            point.restitution == 1.0
            and law.tangential_restitution == 1.0
            and not law.field
            and not law.is_driven
        )
        is_changed = bool(point.at_rest or point.velocity_noise)
        if not (conserves_speed and point.has_one_speed) or is_changed:
            return np.zeros(self.layout.size, bool)
        return self.layout.is_of("thermal_speed", "a2")

    def own_covariance(self, point: Point, values: Array) -> Array | None:
        """Return the covariance of the error of the theory itself; None among dilute scatterers.

        It is of shape (n_components, n_components). Standard deviations are those that
        `kinetics.collision.measured_errors` states, over `DEVIATIONS_STATED`.
        """
        if point.scatterers == "dilute":
            return None
        layout = self.layout
        times = point.true_times(layout.times)
        later = times[layout.time_index]
        earlier = times[layout.earlier_index]
        relative = np.zeros(layout.size)
        for name in layout.all_names:
            if name != BETWEEN_FRAMES:
                relative[layout.is_of(name)] = relative_error(name, point, layout.law, times)
        frames = layout.is_of(BETWEEN_FRAMES)
        growth = -np.expm1(-later[frames] / (ERROR_GROWS_IN * point.path))
        relative[frames] = BETWEEN_FRAMES_ERROR * layout.law.free_path(point.path) * growth
        sizes = self._sizes_of_error(values)
        error = relative * np.where(np.isfinite(sizes), sizes, 0.0)
        correlation = correlation_over_time(later) * correlation_over_time(earlier + point.path)
        same = layout.observable[:, None] == layout.observable
        rate = layout.is_of("thermal_speed", MEAN_SPEED, "msd")
        correlation = np.where(same, correlation, 0.0) + np.where(
            (rate[:, None] & rate) & ~same, RATE_CORRELATION * correlation, 0.0
        )
        return np.asarray(correlation * np.outer(error, error))

    def _sizes_of_error(self, values: Array) -> Array:
        """Return what the error of each component is relative to, in the unit of the data."""
        layout = self.layout
        sizes = layout.sizes(values)
        drift = layout.is_of("drift")
        if np.any(drift):
            sizes[drift] = values[layout.is_of("thermal_speed")]
        displacement = layout.is_of("mean_displacement")
        if np.any(displacement):
            sizes[displacement] = np.sqrt(values[layout.is_of("msd")])
        return sizes


def relative_error(name: str, point: Point, law: Law, times: Array) -> Array:
    """Return the relative standard deviation of the theory of an average, shape (n_times,).

    times : in d/U, on the true clock
    """
    density = law.free_path(point.path)
    medium = Medium(point.scatterers, density, point.restitution, MEASURED_ORDER)
    output = OBSERVABLES[name].output or name
    stated = stated_error(output, medium, times / point.path)
    return np.asarray(stated / DEVIATIONS_STATED)


def correlation_over_time(times: Array) -> Array:
    """Return the correlation of the errors of the theory at times, shape (n_times, n_times)."""
    decades = np.log10(np.where(times > 0.0, times, 1.0))
    return np.asarray(np.exp(-DECAY_OF_CORRELATION * (decades[:, None] - decades) ** 2))
