"""Runs the solver and the particles in a uniform field, and reduces the runs to averages.

Lengths in the mean free path l, accelerations in that of the field; tracers start at rest. The
particles are those of the Boltzmann-Grad limit, which the equation is about.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kinetics import CollisionLaw, FieldState, Scene, Solution, solve, solve_field
from kinetics.crosscheck.report.case import Array, Measured
from kinetics.crosscheck.report.field_settings import FieldSettings
from kinetics.crosscheck.report.observables import jackknife_error
from particles import BoltzmannGrad, Ensemble, simulate

FORGOTTEN = 10.0
"""Relaxation times after which the start is forgotten: a part e^-10 of it is left."""
LONGER = 3.0
"""The last time of a run over the time at which the start is forgotten."""
LOOKS = 9
"""Times between these two, at which velocities are averaged."""
APPROACH_TIMES = np.geomspace(0.1, 40.0, 33)
"""Of the approach to the steady state, in sqrt(l/g)."""


@dataclass(frozen=True)
class SteadyCase:
    """Solver and particles in the steady state of one restitution and dimension.

    `values` are the averages of the particles by the names of `field_rows.OBSERVABLES`, each of
    shape (). They were followed from rest, and measured between the two times.
    """

    restitution: float
    dimension: int
    state: FieldState
    tracers: int
    groups: int
    measured_from: float
    measured_to: float
    values: dict[str, Measured]

    @property
    def law(self) -> CollisionLaw:
        """The collision law."""
        return self.state.law


@dataclass(frozen=True)
class ApproachCase:
    """Solver and particles over time, from rest; arrays of shape (n_times,)."""

    restitution: float
    dimension: int
    state: FieldState
    times: Array
    drift: Array  # the solver's <v_z>
    square: Array  # its <v^2>
    tracers: int
    groups: int
    measured_drift: Measured
    measured_square: Measured


@dataclass(frozen=True)
class SteadyLine:
    """The solver over the restitution, for one dimension; arrays of shape (n,)."""

    dimension: int
    restitutions: Array
    drift: Array
    parallel: Array
    perpendicular: Array


def unit_density(dimension: int) -> float:
    """The number density at which l = d, so that lengths in d are lengths in l."""
    return 0.5 if dimension == 2 else 1.0 / math.pi


def solver_line(dimension: int, settings: FieldSettings) -> SteadyLine:
    """Drift and dispersion at the restitutions of the line."""
    at = np.unique([*settings.line, *settings.restitutions])
    states = [solve_field(float(e), dimension, rtol=1e-6) for e in at]
    return SteadyLine(
        dimension,
        at,
        np.array([state.drift for state in states]),
        np.array([state.diffusion_parallel for state in states]),
        np.array([state.diffusion_perpendicular for state in states]),
    )


def relaxation_time(state: FieldState) -> float:
    """About how long the energy remembers, in sqrt(l/g).

    From d<v^2>/dt = 2 u - lambda(2) <v^3>, whose last term varies by 3/2 of <v^2>, relatively.
    """
    return 1.0 / (1.5 * float(state.law.decay_rate(2.0)) * state.mean_speed)


def steady_case(restitution: float, dimension: int, settings: FieldSettings) -> SteadyCase:
    """Solve, follow particles until they have forgotten their start, and average from there on."""
    state = solve_field(restitution, dimension, rtol=settings.rtol)
    first = FORGOTTEN * relaxation_time(state)
    times = np.linspace(first, LONGER * first, LOOKS)
    tracers = tracers_for(state, float(times[-1]), settings)
    run = _followed(state, times, tracers, settings, ("positions", "velocities"))
    return SteadyCase(
        restitution=restitution,
        dimension=dimension,
        state=state,
        tracers=run.media * run.tracers,
        groups=run.media,
        measured_from=float(times[0]),
        measured_to=float(times[-1]),
        values=steady_values(run, state.law),
    )


def tracers_for(state: FieldState, last: float, settings: FieldSettings) -> int:
    """In each group, so that all make about as many collisions as the settings say."""
    wanted = settings.collisions / (last * state.mean_speed)
    return max(2, round(min(wanted, settings.most_tracers) / settings.groups))


def _followed(
    state: FieldState,
    times: Array,
    tracers: int,
    settings: FieldSettings,
    observables: tuple[str, ...] = (),
) -> Ensemble:
    d = state.dimension
    medium = BoltzmannGrad(unit_density(d), dimension=3 if d == 3 else 2)
    seed = settings.seed + 1000 * d + round(1e6 * float(state.restitution))
    return simulate(
        medium, float(state.restitution), "rest", times, media=settings.groups, tracers=tracers,
        seed=seed, workers=settings.workers, field=1.0, observables=observables,
    )  # fmt: skip


def steady_values(run: Ensemble, law: CollisionLaw) -> dict[str, Measured]:
    """Averages over late times and over tracers, with the jackknife error over the groups.

    What should be 1 by an exact relation is formed before the error is taken, since both of its
    sides come from the same tracers.
    """
    d, n = law.dimension, run.times.size
    v = run.velocities.reshape(n, run.media, run.tracers, d)
    r = run.positions.reshape(n, run.media, run.tracers, d)[[0, -1]]
    speed, along = np.linalg.norm(v, axis=-1), v[..., 0]

    def mean(x: Array) -> Array:
        """Of each group: over the times, the first axis, and over its tracers, the last."""
        return np.asarray(x.mean(axis=(0, 2)))

    sums = {
        "v_z": mean(along), "v": mean(speed), "v^2": mean(speed**2), "v^3": mean(speed**3),
        "v^4": mean(speed**4), "v_z^2": mean(along**2), "v v_z": mean(speed * along),
        "cos": mean(along / speed),
    }  # fmt: skip
    for k in (0, 1):
        sums[f"z{k}"] = mean(r[k : k + 1, ..., 0])
        sums[f"zz{k}"] = mean(r[k : k + 1, ..., 0] ** 2)
        sums[f"xx{k}"] = mean((r[k : k + 1, ..., 1:] ** 2).mean(axis=-1))
    elapsed = float(run.times[-1] - run.times[0])
    return {name: jackknifed(sums, of) for name, of in _quantities(law, elapsed).items()}


def _quantities(
    law: CollisionLaw, elapsed: float
) -> dict[str, Callable[[dict[str, Array]], Array]]:
    """What is compared, as functions of the averages of `steady_values`."""
    loss = {p: float(law.decay_rate(float(p))) for p in (1, 2, 3)}
    return {
        "drift": lambda s: (s["z1"] - s["z0"]) / elapsed,
        "mean_square_speed": lambda s: s["v^2"],
        "mean_square_along": lambda s: s["v_z^2"],
        "mean_speed": lambda s: s["v"],
        "diffusion_parallel": lambda s: (
            (s["zz1"] - s["z1"] ** 2 - s["zz0"] + s["z0"] ** 2) / (2 * elapsed)
        ),
        "diffusion_perpendicular": lambda s: (s["xx1"] - s["xx0"]) / (2 * elapsed),
        "momentum": lambda s: s["v v_z"],
        "energy": lambda s: loss[2] * s["v^3"] / (2 * s["v_z"]),
        "cube": lambda s: loss[3] * s["v^4"] / (3 * s["v v_z"]),
        "direction": lambda s: s["cos"] / (loss[1] * s["v^2"]),
    }


def jackknifed(sums: dict[str, Array], of: Callable[[dict[str, Array]], Array]) -> Measured:
    """A function of averages that are given for each of n groups, and its standard error."""
    n = len(next(iter(sums.values())))
    value = of({name: np.asarray(x.mean()) for name, x in sums.items()})
    without = {name: (x.sum() - x) / (n - 1) for name, x in sums.items()}
    return Measured(np.asarray(value), jackknife_error(of(without)))


def approach_case(restitution: float, dimension: int, settings: FieldSettings) -> ApproachCase:
    """Solver and particles from rest, at `APPROACH_TIMES`."""
    state = solve_field(restitution, dimension, rtol=settings.rtol)
    tracers = tracers_for(state, float(APPROACH_TIMES[-1]), settings)
    run = _followed(state, APPROACH_TIMES, tracers, settings)
    second = run.thermal_speed
    solved = _over_time(state, settings)
    return ApproachCase(
        restitution=restitution,
        dimension=dimension,
        state=state,
        times=APPROACH_TIMES,
        drift=solved.mean_velocity[:, 0],
        square=solved.thermal_speed**2,
        tracers=run.media * run.tracers,
        groups=run.media,
        measured_drift=Measured(run.drift.value, run.drift.error),
        measured_square=Measured(second.value**2, 2 * second.value * second.error),
    )


def _over_time(state: FieldState, settings: FieldSettings) -> Solution:
    scene = Scene(
        **state.law.arguments,
        number_density=unit_density(state.dimension),
        field=1.0,
        initial="rest",
        times=APPROACH_TIMES,
        outputs=("mean_velocity", "thermal_speed"),
    )
    return solve(scene, rtol=settings.time_rtol)
