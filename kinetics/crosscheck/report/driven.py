"""Runs particles and the solver for driven tracers, and makes a `DrivenCase`.

Averages over time, and in the steady state averages over the groups of tracers and their exact
balances. Lengths are in l, times in l/U; in a field sqrt(g l) and sqrt(l/g).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

import kinetics
from kinetics import Scene, Solution
from kinetics.collision import law_of
from kinetics.crosscheck.report.cases import (
    EXACT,
    FREE,
    SOLVER,
    DrivenCase,
    FloatArray,
    Measured,
    Place,
    SampleSize,
    Values,
)
from kinetics.crosscheck.report.cooling import solve_quietly
from kinetics.crosscheck.report.estimates import jackknifed
from kinetics.crosscheck.report.progress import Progress
from kinetics.crosscheck.report.systems import Driven, half_cross_section
from kinetics.driven.driven_state import DrivenState
from particles import BoltzmannGrad, Ensemble, simulate

#: Field in U^2/l in which the drift of tracers is compared that something else drives; the drives
#: are 1. The origin is not recorded.
WEAK_FIELD = 0.3
#: Tolerance of the drift in the weak field, which is compared with particles alone.
WEAK_FIELD_RTOL = 1e-6
#: Output times without a steady state, in l/U.
DECAY_TIMES = np.geomspace(0.1, 1000.0, 25)
#: Output times before the steady state, the last of which is its beginning, and later ones.
N_TRANSIENT_TIMES = 14
STEADY_TIMES = np.linspace(1.5, 4.0, 6)  # in the time of its beginning
#: Decay times of the energy after which the start is forgotten: e^-10 of it is left.
DECAYS_UNTIL_STEADY = 10.0
#: Smallest tracers in a group: a variance takes two.
MIN_TRACERS = 2
#: Moments <v^p cos^k> of particles and of the steady state: name -> p, k.
MOMENTS = {
    "<v>": (1, 0),
    "<v^2>": (2, 0),
    "<v^3>": (3, 0),
    "<v^4>": (4, 0),
    "<v^5>": (5, 0),
    "<v cos>": (1, 1),
    "<v^2 cos>": (2, 1),
    "<v^3 cos>": (3, 1),
}
# Growths of the displacement while the state is steady, beside the moments.
MEAN_GROWTH = "<x>"
PARALLEL_GROWTH = "var(x)"
PERPENDICULAR_GROWTH = "<y^2>"
WEAK_GROWTH = "<x> in a weak field"


@dataclass(frozen=True)
class DrivenRun:
    """One value of the parameter of a system, and when it is looked at.

    Parameters
    ----------
    state : the steady state; None where nothing drives
    times : output times
    first : index of the time from which on the state is steady
    """

    system: Driven
    value: float
    state: DrivenState | None
    times: FloatArray
    first: int

    @staticmethod
    def of(system: Driven, value: float) -> "DrivenRun":
        """Return the run of a value: its steady state decides the times."""
        if not system.drive:
            return DrivenRun(system, value, None, DECAY_TIMES, 0)
        d = system.dimension
        state = kinetics.solve_steady(system.law(value), d, **system.drive, rtol=system.rtol)
        # Without gains d<v^2>/dt = -lambda(2) <v^3>, which varies by 3/2 of <v^2>, relatively.
        rate = 1.5 * float(law_of(value, 1.0, d).decay_rate(2.0) * state.moment(1.0))
        begin = DECAYS_UNTIL_STEADY / rate
        transient = np.geomspace(begin / 60, begin, N_TRANSIENT_TIMES)
        times = np.append(transient, begin * STEADY_TIMES)
        return DrivenRun(system, value, state, times, N_TRANSIENT_TIMES - 1)

    @property
    def number_density(self) -> float:
        """The density at which l = d, so that lengths in d are lengths in l."""
        return 0.5 / half_cross_section(self.system.dimension)

    @property
    def elapsed(self) -> float:
        """Time during which the state is steady."""
        return float(self.times[-1] - self.times[self.first])

    @property
    def averages(self) -> tuple[str, ...]:
        """Outputs over time."""
        if "field" in self.system.drive:
            return ("mean_velocity", "collisions")
        return ("thermal_speed", "a2", "msd", "collisions")

    def solve(self) -> Solution:
        """Solve the equation over time."""
        system = self.system
        drive: dict[str, Any] = dict(system.drive)
        scene = Scene(
            system.law(self.value),
            self.number_density,
            times=self.times,
            outputs=self.averages,
            dimension=system.dimension,
            initial=system.initial,
            **drive,
        )
        return solve_quietly(scene, system.time_rtol)

    def follow(self, tracers: float, times: FloatArray, seed: int, **drive: float) -> Ensemble:
        """Follow particles of the dilute limit; `drive` is added to what drives them."""
        system = self.system
        medium = BoltzmannGrad(self.number_density, dimension=3 if system.dimension == 3 else 2)
        arguments: dict[str, Any] = {**system.drive, "initial": system.initial, **drive}
        return simulate(
            medium,
            system.law(self.value),
            times=times,
            media=system.groups,
            tracers=max(MIN_TRACERS, round(tracers / system.groups)),
            seed=system.seed + seed + 1000 * system.dimension + round(1e6 * self.value),
            workers=system.workers,
            observables=("positions", "velocities"),
            **arguments,
        )


def run_driven(system: Driven, tell: Progress) -> list[DrivenCase]:
    """Run everything for each value of the parameter; ValueError for what cannot be simulated."""
    return [_run_case(system, value, tell) for value in system.values]


def _run_case(system: Driven, value: float, tell: Progress) -> DrivenCase:
    """Run particles and the solver; tell progress twice."""
    case_name = f"{system.parameter} = {value:g} among {system.scatterers}"
    tell(f"{case_name}: kinetic equation")
    run = DrivenRun.of(system, value)
    solution = run.solve()
    tell(f"{case_name}: {FREE} particles")
    tracers = min(system.collisions / float(solution.collisions[-1]), system.most_tracers)
    ensemble = run.follow(tracers, run.times, 0)
    over_time: dict[str, FloatArray] = {}
    measured: dict[str, Measured] = {}
    for name in run.averages:
        over_time[name] = np.asarray(getattr(solution, name))
        if name != "mean_velocity":
            measured[name] = Measured.of(getattr(ensemble, name))
    if "field" in system.drive:
        over_time["drift_from_rest"] = over_time.pop("mean_velocity")[:, 0]
        measured["drift_from_rest"] = Measured.of(ensemble.drift)
    theory: dict[str, dict[str, Values]] = {SOLVER: {**over_time}, EXACT: {}}
    if run.state is not None:
        _add_steady_state(run, run.state, ensemble, tracers, measured, theory)
    return DrivenCase(
        system=f"{system.scatterers}, {system.name}",
        value=value,
        dimension=system.dimension,
        times=run.times,
        measured={FREE: measured},
        theory=theory,
        sizes={FREE: SampleSize(ensemble.media, ensemble.tracers)},
        places={name: Place("time", run.times) for name in over_time},
        state=run.state,
    )


def _add_steady_state(
    run: DrivenRun,
    state: DrivenState,
    ensemble: Ensemble,
    tracers: float,
    measured: dict[str, Measured],
    theory: dict[str, dict[str, Values]],
) -> None:
    """Add what is compared in the steady state to what is measured, and to the theory."""
    system = run.system
    by_group = _moments(ensemble, run.first) | _growths(ensemble, run.first)
    expected = {name: np.asarray(state.moment(float(p), k)) for name, (p, k) in MOMENTS.items()}
    elapsed = run.elapsed
    expected[MEAN_GROWTH] = np.asarray(state.drift * elapsed)
    expected[PARALLEL_GROWTH] = np.asarray(2 * elapsed * state.diffusion_parallel)
    expected[PERPENDICULAR_GROWTH] = np.asarray(2 * elapsed * state.diffusion_perpendicular)
    if "field" not in system.drive:
        begin_and_end = run.times[[run.first, -1]]
        weak = run.follow(tracers, begin_and_end, 1, field=WEAK_FIELD)
        by_group[WEAK_GROWTH] = _growths(weak, 0)[MEAN_GROWTH]
        in_weak_field = kinetics.solve_steady(
            system.law(run.value),
            system.dimension,
            **system.drive,
            field=WEAK_FIELD,
            rtol=WEAK_FIELD_RTOL,
        )
        expected[WEAK_GROWTH] = np.asarray(in_weak_field.drift * elapsed)
    quantities = partial(_steady_averages, run)
    solved = quantities(expected)
    measured |= jackknifed(by_group, quantities)
    theory[SOLVER] |= solved
    theory[EXACT] = {name: 1.0 for name in ("energy", "fourth") if name in solved}
    if "field" in system.drive:
        own_momentum = 1.5 if system.dimension == 2 else 2.0
        theory[EXACT]["momentum"] = own_momentum / (1.0 + run.value)
    if "bath_speed" in system.drive:
        square = _bath_temperature(run)
        theory[EXACT] = _exact_in_a_bath(run)
        theory[SOLVER]["steady_rate"] = state.collision_rate
        theory[SOLVER]["einstein"] = state.mobility * square / state.diffusion_coefficient


def _bath_temperature(run: DrivenRun) -> float:
    """Return <v_x^2> = w^2 (1 + e)/(1 - e) in a bath of infinitely heavy scatterers."""
    bath_speed = run.system.drive["bath_speed"]
    return float(bath_speed**2 * (1.0 + run.value) / (1.0 - run.value))


def _exact_in_a_bath(run: DrivenRun) -> dict[str, Values]:
    """Return the exact averages: the state is Maxwellian, and the relative velocity Gaussian."""
    dimension = run.system.dimension
    square = _bath_temperature(run)
    relative_speed = math.sqrt(square + run.system.drive["bath_speed"] ** 2)
    mean_of_unit = math.pi / 2 if dimension == 2 else 8 / math.pi
    return {
        "steady_speed": math.sqrt(dimension * square),
        "steady_a2": 0.0,
        "steady_rate": relative_speed * math.sqrt(mean_of_unit),
        "einstein": 1.0,
    }


def _vectors(ensemble: Ensemble, name: str) -> FloatArray:
    """Return its velocities or positions, (n_times, n_groups, n_in_group, d)."""
    vectors: FloatArray = getattr(ensemble, name)
    return vectors.reshape(len(vectors), ensemble.media, ensemble.tracers, -1)


def _moments(ensemble: Ensemble, first: int) -> dict[str, FloatArray]:
    """Return the moments of each group, averaged from the time of index `first` on."""
    velocities = _vectors(ensemble, "velocities")[first:]
    speeds = np.linalg.norm(velocities, axis=-1)
    along = velocities[..., 0]
    return {
        name: np.asarray((speeds ** (p - k) * along**k).mean((0, 2)))
        for name, (p, k) in MOMENTS.items()
    }


def _growths(ensemble: Ensemble, first: int) -> dict[str, FloatArray]:
    """Return how <x>, the variance of x and <y^2> of each group grow from this time to the last.

    Groups share the law: their means of x differ by chance alone, which the variance leaves out.
    """
    positions = _vectors(ensemble, "positions")[[first, -1]]
    along = positions[..., 0]
    variance = (along - along.mean(axis=(1, 2), keepdims=True)) ** 2
    across = (positions[..., 1:] ** 2).mean(axis=-1)

    def growth(quantity: FloatArray) -> FloatArray:
        return np.asarray(np.diff(quantity.mean(axis=2), axis=0)[0])

    return {
        MEAN_GROWTH: growth(along),
        PARALLEL_GROWTH: growth(variance),
        PERPENDICULAR_GROWTH: growth(across),
    }


def _steady_averages(run: DrivenRun, averages: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """Return what is compared in the steady state, of moments and growths by name."""
    system = run.system
    d = system.dimension
    elapsed = run.elapsed
    acceleration = system.drive.get("field", 0.0)
    noise = system.drive.get("heating", 0.0)
    parallel = averages[PARALLEL_GROWTH]
    perpendicular = averages[PERPENDICULAR_GROWTH]
    quantities: dict[str, FloatArray] = {}
    if acceleration:
        quantities["drift"] = averages[MEAN_GROWTH] / elapsed
        quantities["mean_square_speed"] = averages["<v^2>"]
        quantities["mean_speed"] = averages["<v>"]
        quantities["diffusion_parallel"] = parallel / (2 * elapsed)
        quantities["diffusion_perpendicular"] = perpendicular / (2 * elapsed)
        quantities["momentum"] = averages["<v^2 cos>"]
    else:
        fourth = d / (d + 2) * averages["<v^4>"] / averages["<v^2>"] ** 2
        quantities["steady_speed"] = np.sqrt(averages["<v^2>"])
        quantities["steady_a2"] = fourth - 1
        quantities["diffusion"] = (parallel + (d - 1) * perpendicular) / (2 * d * elapsed)
        quantities["weak_drift"] = averages[WEAK_GROWTH] / (elapsed * WEAK_FIELD)
    if acceleration or noise:  # <v^2> and <v^4> do not change
        law = law_of(run.value, 1.0, d)
        gain = 2 * acceleration * averages["<v cos>"] + 2 * d * noise
        gain_of_fourth = (
            4 * acceleration * averages["<v^3 cos>"] + 4 * (d + 2) * noise * averages["<v^2>"]
        )
        quantities["energy"] = law.decay_rate(2.0) * averages["<v^3>"] / gain
        quantities["fourth"] = law.decay_rate(4.0) * averages["<v^5>"] / gain_of_fourth
    return quantities
