"""Runs both simulations and the solver for a gas that is left alone, and makes a `CoolingCase`.

d is the diameter of a scatterer and of the tracer, U the standard deviation of one component of the
initial velocity.
"""

import math
import warnings
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

import kinetics
from kinetics import Scene, Solution, sonine
from kinetics.collision import CollisionLaw
from kinetics.collision.medium import HIGHEST_DENSITY
from kinetics.crosscheck.data.ensembles import sample_of_ensemble
from kinetics.crosscheck.data.sample import R2, V2, N
from kinetics.crosscheck.data.sample import errors as jackknife_error
from kinetics.crosscheck.report import estimates
from kinetics.crosscheck.report.cases import (
    EXACT,
    FIT,
    FREE,
    KINETIC,
    OVER_TIME,
    SOLVER,
    SONINE,
    CoolingCase,
    CoolingSolutions,
    DensityTest,
    FloatArray,
    Measured,
    Place,
    SampleSize,
    ScalingStates,
    Values,
)
from kinetics.crosscheck.report.estimates import DISTANCES, POSITION_EDGES, SPEED_EDGES, SPEEDS
from kinetics.crosscheck.report.progress import Progress
from kinetics.crosscheck.report.systems import Cooling
from kinetics.errors import ModelWarning, ToleranceWarning
from kinetics.numerics.gauss import panels_between
from kinetics.validation import refuse
from particles import BoltzmannGrad, Ensemble, HardDisks, HardSpheres, Medium, outputs, simulate

#: Last time in d/U of the equation alone, or ten times that of the simulation where that is later.
#: Chosen: far beyond the report's simulations, so that figures show what is reached in the end.
LATEST_TIME = 1e9
#: Output times up to there. Chosen: about six in a decade.
N_LATE_TIMES = 55
#: Times in d/U at which <r^2> of a printed formula is its limit a + b ln t, to rounding:
#: of two of them a and b follow. Chosen: far apart, and within the range of doubles.
LIMIT_TIMES = np.array([1e150, 1e300])
#: Independent groups of the Boltzmann-Grad tracers. An error from 100 groups is known to 7 %.
FREE_GROUPS = 100
#: Gauss nodes in a bin over which F(c) is averaged. Chosen: shares of bins, over the largest, then
#: change by less than 2e-9 with more nodes (disks and spheres, e = 0.4, 0.7, 0.9), and with half of
#: them by 2e-6; the error of the solver is 1e-7.
NODES_PER_BIN = 8
#: Samples that a bin must expect to be compared at all, where bins are not merged. Chosen: at
#: 50 the distribution of the count is close to a Gaussian.
MIN_SAMPLES_PER_BIN = 50
#: Columns of the final states of tracers that are no components of the displacement.
NOT_DISPLACEMENT = [outputs.LN_SPEED, outputs.LN_TIME, outputs.FINAL_COLLISIONS]


@dataclass(frozen=True)
class CoolingRun:
    """One restitution of a system, and when it is looked at.

    Parameters
    ----------
    system : what is run
    restitution, law : of the collisions
    times : output times in d/U
    early : index of the time from which on late rates are measured, a tenth of the last
    seed : of the Boltzmann-Grad run; that among hard scatterers has the next
    """

    system: Cooling
    restitution: float
    law: CollisionLaw
    times: FloatArray
    early: int
    seed: int

    @staticmethod
    def of(system: Cooling, index: int) -> "CoolingRun":
        """Return the run of the restitution of this index."""
        restitution = system.restitutions[index]
        last = system.final_times[index]
        times = np.geomspace(min(1.0, last / 10), last, system.n_times)
        early = int(np.searchsorted(times, last / 10))
        seed = system.seed + 2 * index
        return CoolingRun(system, restitution, system.law(restitution), times, early, seed)

    def follow(self, medium: Medium, seed: int, media: int, tracers: int) -> Ensemble:
        """Follow tracers in a medium: so many configurations, or groups, of so many tracers."""
        return simulate(
            medium,
            restitution=self.restitution,
            times=self.times,
            seed=seed,
            workers=self.system.workers,
            media=media,
            tracers=tracers,
            observables=("finals",),
            tangential_restitution=self.system.tangential_restitution,
        )

    def follow_among_hard(self) -> Ensemble:
        """Follow tracers among hard disks, or spheres; refuse times before any collision."""
        system = self.system
        medium: Medium
        if system.dimension == 3:
            medium = HardSpheres(system.number_density, count=system.count)
        else:
            medium = HardDisks(system.number_density, count=system.count)
        ensemble = self.follow(medium, self.seed + 1, system.media, system.tracers)
        if not np.isfinite(ensemble.mean_free_path.value):
            last = float(self.times[-1])
            refuse("until", last, f"no tracer among {system.hard} has collided by then, some must")
        return ensemble

    def follow_free(self) -> Ensemble:
        """Follow tracers of the dilute limit, with random free paths."""
        system = self.system
        groups = min(FREE_GROUPS, system.free_tracers // 2)
        # mypy takes no int for the dimension, which is 2 or 3
        medium = BoltzmannGrad(system.number_density, dimension=3 if system.dimension == 3 else 2)
        return self.follow(medium, self.seed, groups, system.free_tracers // groups)


def run_cooling(system: Cooling, tell: Progress) -> list[CoolingCase]:
    """Run everything for each restitution; ValueError for what cannot be simulated."""
    with ThreadPoolExecutor(1) as beside:  # the solver works while tracers are followed
        cases = []
        for index in range(len(system.restitutions)):
            run = CoolingRun.of(system, index)
            cases.append(_run_case(run, tell, beside))
        return cases


def _run_case(run: CoolingRun, tell: Progress, beside: ThreadPoolExecutor) -> CoolingCase:
    """Run both simulations and the solver; tell progress three times."""
    system = run.system
    name = f"e = {run.restitution:g}"
    tell(f"{name}: {system.hard}")
    solving: Future[CoolingSolutions] = beside.submit(solve_all, run)
    hard = run.follow_among_hard()
    tell(f"{name}: {FREE} particles")
    free = run.follow_free()
    tell(f"{name}: kinetic equation")
    solutions = solving.result()
    shares = BinShares.of(solutions, system.dimension)
    measured: dict[str, dict[str, Measured]] = {}
    sizes: dict[str, SampleSize] = {}
    tests: dict[str, dict[str, DensityTest]] = {}
    for source, ensemble in ((FREE, free), (system.hard, hard)):
        states = FinalStates.of(ensemble)
        measured[source] = _measure(ensemble, states, run)
        sizes[source] = SampleSize(ensemble.media, ensemble.tracers)
        tests[source] = _density_tests(states, shares)
    places = {name: Place("time", run.times) for name in OVER_TIME}
    places["scaled_vdf"] = Place("c", SPEEDS)
    places["position"] = Place("distance", DISTANCES)
    return CoolingCase(
        system=_name_of(system),
        value=run.restitution,
        dimension=system.dimension,
        times=run.times,
        measured=measured,
        theory=_theory(run, solutions, shares),
        sizes=sizes,
        places=places,
        early=run.early,
        solutions=solutions,
        tests=tests,
    )


def _name_of(system: Cooling) -> str:
    """Return what the rows call the system."""
    if system.is_smooth:
        return system.scatterers
    return f"rough {system.scatterers}"


# -- the solver ------------------------------------------------------------------------------------
def solve_quietly(scene: Scene, rtol: float) -> Solution:
    """Solve a scene without warnings: a page of rows shows what deviates."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ToleranceWarning)
        warnings.simplefilter("ignore", ModelWarning)
        return kinetics.solve(scene, rtol=rtol)


def solve_all(run: CoolingRun) -> CoolingSolutions:
    """Solve the equation at the times of the particles and much later, and among hard disks."""
    system = run.system
    rtol = system.rtol

    def solve(times: FloatArray, names: tuple[str, ...], rtol: float, **medium: str) -> Solution:
        arguments: dict[str, Any] = {**run.law.arguments, **medium}
        density = system.number_density
        scene = Scene(number_density=density, times=times, outputs=names, **arguments)
        return solve_quietly(scene, rtol)

    scaling = None
    if not run.law.is_elastic:
        scaling = ScalingStates(
            exact=kinetics.ScalingSolution(**run.law.arguments),
            solved=kinetics.solve_scaled(**run.law.arguments, rtol=rtol),
        )
    last = max(LATEST_TIME, 10 * run.times[-1])
    late_times = np.geomspace(run.times[0], last, N_LATE_TIMES)
    dense = None
    # the paper's law: smooth disks in the plane
    if system.is_papers_law and system.number_density <= HIGHEST_DENSITY:
        averages = ("thermal_speed", "a2", "msd")
        dense = solve(run.times, averages, rtol, scatterers="hard disks")
    return CoolingSolutions(
        scaling=scaling,
        dense=dense,
        kinetic=solve(run.times, (*OVER_TIME, "speed_density"), rtol),
        late=solve(late_times, (*OVER_TIME, "diffusion_coefficient"), rtol),
        position=solve(run.times[-1:], ("msd", "position_density"), system.position_rtol),
    )


def last_vdf(solution: Solution, c: FloatArray) -> FloatArray:
    """Return F(c) of a solution at its last time, from its radial density over v = c v0(t)."""
    dimension = solution.scene.dimension
    v0 = float(solution.thermal_speed[-1])
    surface = dimension * estimates.unit_ball(dimension) * c ** (dimension - 1)
    return np.asarray(v0 * solution.speed_density(c * v0)[-1] / surface)


@dataclass(frozen=True)
class BinShares:
    """Shares of the tracers that the equation expects in each bin of c and of R."""

    speed: FloatArray
    position: FloatArray
    dimension: int

    @staticmethod
    def of(solutions: CoolingSolutions, dimension: int) -> "BinShares":
        """Return the shares at the last time."""
        c, weight = panels_between(SPEED_EDGES, NODES_PER_BIN)
        radial = dimension * c ** (dimension - 1) * last_vdf(solutions.kinetic, c) * weight
        position = solutions.position
        edges = POSITION_EDGES * math.sqrt(float(position.msd[-1]))
        per_ball = radial.reshape(-1, NODES_PER_BIN).sum(axis=1)
        return BinShares(
            speed=estimates.unit_ball(dimension) * per_ball,
            position=position.position_fraction(edges)[-1],
            dimension=dimension,
        )

    @property
    def vdf(self) -> FloatArray:
        """F(c), averaged over the area, or the volume, of each bin."""
        return self.speed / estimates.shell_volumes(SPEED_EDGES, self.dimension)

    @property
    def position_density(self) -> FloatArray:
        """G(R), averaged over each bin."""
        return self.position / np.diff(POSITION_EDGES)


def _theory(
    run: CoolingRun, solutions: CoolingSolutions, shares: BinShares
) -> dict[str, dict[str, Values]]:
    """Return what everybody says, by who says it and observable."""
    averages = {name: getattr(solutions.kinetic, name) for name in OVER_TIME}
    half_rate = run.system.half_rate  # 1/(2 l)
    theory: dict[str, dict[str, Values]] = {
        KINETIC: {
            **averages,
            **estimates.late_rates(run.times, averages, run.early, half_rate),
            "free_path": 0.5 / half_rate,
            "position": shares.position_density,
            "scaled_vdf": shares.vdf,
        }
    }
    if solutions.scaling is not None:
        exact = solutions.scaling.exact
        solved = solutions.scaling.solved
        mean_free_path = solutions.late.scene.mean_free_path
        slope = exact.diffusion_slope * mean_free_path**2  # from l^2 to d^2
        theory[EXACT] = {
            "cooling_rate": exact.cooling_rate,
            "a2": exact.a2,
            "msd_slope": slope,
        }
        theory[SOLVER] = {"cooling_rate": solved.cooling_rate, "a2": solved.a2}
    if run.system.is_papers_law:
        theory |= _printed_formulas(run)
    return theory


def _printed_formulas(run: CoolingRun) -> dict[str, dict[str, Values]]:
    """Return what the paper's formulas say."""
    e = run.restitution
    density = run.system.number_density
    fit: dict[str, Values] = {
        "cooling_rate": float(sonine.cooling_rate_fitted(e)),
        "msd": sonine.msd_random_walk(run.times, e, density),
    }
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a report shows that there is no root
        expansion: dict[str, Values] = {
            "cooling_rate": float(sonine.cooling_rate(e)),
            "a2": float(sonine.a2(e)),
            "msd": sonine.msd_sonine(run.times, e, density),
        }
        expansion_rise = np.diff(sonine.msd_sonine(LIMIT_TIMES, e, density))
    if e < 1:
        log_time = np.diff(np.log(LIMIT_TIMES))
        fit_rise = np.diff(sonine.msd_random_walk(LIMIT_TIMES, e, density))
        fit["msd_slope"] = float((fit_rise / log_time)[0])
        expansion["msd_slope"] = float((expansion_rise / log_time)[0])
    return {FIT: fit, SONINE: expansion}


# -- the particles ---------------------------------------------------------------------------------
@dataclass(frozen=True)
class FinalStates:
    """Speeds and distances of the tracers of a run at its end, (n_groups, n_in_group)."""

    speeds: FloatArray
    distances: FloatArray

    @staticmethod
    def of(ensemble: Ensemble) -> "FinalStates":
        """Return those of an ensemble.

        Tracers have come to rest, and have speed 0, where in the corner between two scatterers they
        hit one after the other without end.
        """
        finals = ensemble.finals.reshape(ensemble.media, ensemble.tracers, -1)
        speeds = np.exp(finals[..., outputs.LN_SPEED])
        trapped = ensemble.statuses.trap_tracers
        speeds[trapped[:, 0], trapped[:, 1]] = 0.0
        displacements = np.delete(finals, NOT_DISPLACEMENT, axis=-1)
        return FinalStates(speeds, np.linalg.norm(displacements, axis=-1))


def _measure(ensemble: Ensemble, states: FinalStates, run: CoolingRun) -> dict[str, Measured]:
    """Return everything that is measured in a run."""
    times = run.times
    measured: dict[str, Measured] = {}
    values: dict[str, FloatArray] = {}
    for name in OVER_TIME:
        measured[name] = Measured.of(getattr(ensemble, name))
        values[name] = measured[name].value
    half_rate = run.system.half_rate  # 1/(2 l)
    rates = estimates.late_rates(times, values, run.early, half_rate)
    sums = sample_of_ensemble(ensemble).sums  # of each configuration
    without = np.moveaxis(sums.sum(axis=0) - sums, -1, 0)
    replicates = estimates.late_rates(
        times,
        {
            "thermal_speed": np.sqrt(without[V2] / without[N]),
            "msd": without[R2] / without[N],
        },
        run.early,
        half_rate,
    )
    for name, rate in rates.items():
        measured[name] = Measured(rate, jackknife_error(replicates[name]))
    shells = estimates.shell_volumes(SPEED_EDGES, run.system.dimension)
    trapped = np.asarray(float(ensemble.statuses.trapped))  # how many, exactly: without an error
    measured |= {
        "free_path": Measured.of(ensemble.mean_free_path),
        "scaled_vdf": estimates.scaled_density(states.speeds, SPEED_EDGES, shells),
        "position": estimates.scaled_density(
            states.distances, POSITION_EDGES, np.diff(POSITION_EDGES)
        ),
        "trapped": Measured(trapped, np.asarray(np.nan)),
    }
    return measured


def _density_tests(states: FinalStates, shares: BinShares) -> dict[str, DensityTest]:
    """Return F(c) and G(R) in bins so wide that a difference of a tenth shows in each of them.

    Each has `estimates.MIN_SAMPLES_PER_TEST` samples.
    """
    dimension = shares.dimension
    vdf_volumes = estimates.shell_volumes(SPEED_EDGES, dimension)
    return {
        "scaled_vdf": _density_test(states.speeds, SPEED_EDGES, shares.speed, vdf_volumes, "c"),
        "position": _density_test(
            states.distances,
            POSITION_EDGES,
            shares.position,
            np.diff(POSITION_EDGES),
            "distance",
        ),
    }


def _density_test(
    samples: FloatArray, edges: FloatArray, shares: FloatArray, measure: FloatArray, name: str
) -> DensityTest:
    """Return a density in merged bins; in all bins of some samples where they do not suffice.

    Samples are divided by their own root mean square: speeds become c, distances R.

    Parameters
    ----------
    samples : speeds in U or distances in d, shape (n_groups, n_in_group)
    edges : of the bins in c or R
    shares : of the samples that the theory expects in each bin
    measure : length, area or volume of each bin
    name : "c" or "distance"
    """
    chosen = estimates.merge_bins(shares, samples.size)
    if chosen is None:
        enough = samples.size * shares >= MIN_SAMPLES_PER_BIN
        theory = np.where(enough, shares / measure, np.nan)
        place = Place(name, (edges[1:] + edges[:-1]) / 2)
        return DensityTest(estimates.scaled_density(samples, edges, measure), theory, place)
    end = chosen[-1]
    wide_edges = edges[chosen]
    wide_measure = np.add.reduceat(measure[:end], chosen[:-1])
    wide_shares = np.add.reduceat(shares[:end], chosen[:-1])
    return DensityTest(
        estimates.scaled_density(samples, wide_edges, wide_measure),
        wide_shares / wide_measure,
        Place(name, (wide_edges[1:] + wide_edges[:-1]) / 2),
    )
