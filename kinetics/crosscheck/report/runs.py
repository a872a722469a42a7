"""Runs the solver and the particles on every system, and reduces what they give to `Case` values.

Rows, figures and the findings read nothing else, whatever the system.
"""

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import kinetics
from kinetics import Scene, Solution, sonine
from kinetics.collision import CollisionLaw, law_of
from kinetics.collision.medium import HIGHEST_DENSITY
from kinetics.crosscheck.data.ensembles import sample_of_ensemble
from kinetics.crosscheck.data.sample import R2, V2, N
from kinetics.crosscheck.data.sample import errors as jackknife_error
from kinetics.crosscheck.report.systems import Cooling, Driven, System
from kinetics.crosscheck.report.systems import half_cross_section as half_section
from kinetics.errors import ToleranceWarning
from kinetics.numerics.gauss import panels_between
from kinetics.validation import refuse
from particles import BoltzmannGrad, Ensemble, HardDisks, HardSpheres, Medium, simulate

KINETIC = "kinetic equation"
EXACT, SOLVER, FIT, SONINE = "exact", "solver", "paper's fit", "Sonine"
FREE = "Boltzmann-Grad"
OVER_TIME = ("thermal_speed", "a2", "msd", "kurtosis")  # without a field, at each time
LATEST = 1e9  # last time in d/U of the equation alone
# bins of c = v/v0 for F(c), and of R = r/sqrt(<r^2>) for G(R)
SPEED_EDGES = np.concatenate([np.linspace(0.0, 2.0, 21), np.linspace(2.25, 6.0, 16)])
POSITION_EDGES = np.concatenate([np.linspace(0.0, 3.0, 31), np.linspace(3.25, 6.0, 12)])
SPEEDS, DISTANCES = ((edges[1:] + edges[:-1]) / 2 for edges in (SPEED_EDGES, POSITION_EDGES))
WEAK_FIELD = 0.3  # in U^2/l, in which the drift of driven tracers is compared

Tell = Callable[[str], None]
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Measured:
    """An estimate with its standard error, of the same shape; NaN where nothing was measured."""

    value: Array
    error: Array

    @staticmethod
    def of(estimate: Any) -> "Measured":
        """Of anything that has both."""
        return Measured(np.asarray(estimate.value), np.asarray(estimate.error))

    @property
    def last(self) -> "Measured":
        """The last one, of shape ()."""
        return Measured(*(np.asarray(np.ravel(x)[-1]) for x in (self.value, self.error)))

    def __truediv__(self, scale: float | Array) -> "Measured":
        return Measured(np.asarray(self.value / scale), np.asarray(self.error / scale))

    def __getitem__(self, where: Any) -> "Measured":
        return Measured(np.asarray(self.value[where]), np.asarray(self.error[where]))


class Case(NamedTuple):
    """What every method gives at one restitution.

    measured : by source and observable, estimates with their errors
    theory : by who says so and observable; arrays where there are several times or bins
    runs : of each source, with independent groups of tracers
    places : of an observable, the name and the values of what it depends on
    solved : the solutions behind, which figures draw between the points
    """

    system: str
    restitution: float
    dimension: int
    times: Array
    measured: dict[str, dict[str, Measured]]
    theory: dict[str, dict[str, Any]]
    runs: dict[str, Any]
    places: Mapping[str, tuple[str, Array]] = {}
    solved: Any = None

    @property
    def cools(self) -> bool:
        """Whether there is a scaling state: the law is not elastic."""
        return getattr(self.solved, "exact", None) is not None

    def samples(self, source: str) -> int:
        """How many tracers a source has."""
        return self.runs[source].media * self.runs[source].tracers


class Results(NamedTuple):
    """Everything that was run."""

    system: System
    cases: Sequence[Case]

    @property
    def cooling(self) -> list[Case]:
        """The cases that cool."""
        return [case for case in self.cases if case.cools]


# -- numbers of one run or solution ----------------------------------------------------------------
def rates(
    times: Array, averages: Mapping[str, Array], early: int, half_rate: float
) -> dict[str, Array]:
    """h from 1/v0, and d<r^2>/d ln t, between index `early` and the last time; half_rate 1/2l.

    averages (..., n_times)
    """
    v, r = (averages[name][..., [early, -1]] for name in ("thermal_speed", "msd"))
    slope = np.diff(1 / v)[..., 0] / (times[-1] - times[early])
    spread = np.diff(r)[..., 0] / np.log(times[-1] / times[early])
    return {"cooling_rate": np.asarray(slope / half_rate), "msd_slope": np.asarray(spread)}


def ball(dimension: int) -> float:
    """Area of the unit circle, or volume of the unit sphere."""
    return math.pi if dimension == 2 else 4 * math.pi / 3


def bin_measure(dimension: int) -> Array:
    """Area, or volume, of each bin of c."""
    return np.asarray(ball(dimension) * np.diff(SPEED_EDGES**dimension))


def last_vdf(solution: Solution) -> Callable[[Array], Array]:
    """F(c) of a solution at its last time, from its radial density over v = c v0(t)."""
    v0, d = float(solution.thermal_speed[-1]), solution.scene.dimension
    surface, power = d * ball(d), d - 1
    return lambda c: v0 * solution.speed_density(c * v0)[-1] / (surface * c**power)


def filled(density: Array, samples: int, measure: Array, least: float = 50.0) -> Array:
    """The density in those bins in which it expects `least` samples, NaN in others."""
    return np.where(samples * density * measure >= least, density, np.nan)


def scaled_density(samples: Array, edges: Array, measure: Array) -> Measured:
    """Density of samples (n_groups, n_in_group) over their own root mean square, per bin.

    edges (n_bins + 1,) of the scaled variable; measure (n_bins,): length or area of each bin.
    """
    every, by_group = np.sort(samples, axis=None), np.sort(samples, axis=1)

    def density(left_out: Array) -> Array:
        n = every.size - left_out.size
        at = edges * np.sqrt((np.sum(every**2) - np.sum(left_out**2)) / n)
        inside = np.diff(np.searchsorted(every, at) - np.searchsorted(left_out, at))
        return np.asarray(inside / n / measure)

    replicates = np.array([density(group) for group in by_group])
    return Measured(density(every[:0]), jackknife_error(replicates))


def jackknifed(
    by_group: Mapping[str, Array], quantities: Callable[[Mapping[str, Array]], dict[str, Array]]
) -> dict[str, Measured]:
    """Quantities of averages, which are given for each group, (n_groups,).

    Both sides of a relation come from the same tracers: their ratio is formed first.
    """
    without = quantities({n: (x.sum() - x) / (x.size - 1) for n, x in by_group.items()})
    found = quantities({n: x.mean() for n, x in by_group.items()})
    return {n: Measured(x, jackknife_error(without[n])) for n, x in found.items()}


# -- a gas that cools ------------------------------------------------------------------------------
def gather(system: System, tell: Tell) -> Results:
    """Run everything that a report of the system needs; ValueError for what cannot be simulated."""
    if isinstance(system, Driven):
        return Results(system, [_driven(x, system, tell) for x in system.restitutions])
    with ThreadPoolExecutor(1) as beside:  # the solver works while tracers are followed
        ends = zip(system.restitutions, system.final_times, strict=True)
        cases = [cooling_case(system, e, last, tell, beside) for e, last in ends]
    return Results(system, cases)


def cooling_case(
    system: Cooling, e: float, last: float, tell: Tell, beside: ThreadPoolExecutor
) -> Case:
    """Both simulations and the equation until the last time, in d/U. Calls `tell` three times."""
    law, d, half_rate = system.law(e), system.dimension, system.half_rate
    times = np.geomspace(min(1.0, last / 10), last, system.n_times)
    early = int(np.searchsorted(times, last / 10))
    seed, hard = system.seed + 2 * system.restitutions.index(e), f"hard {system.scatterers}"
    packed_media: Any = HardSpheres if d == 3 else HardDisks

    def followed(medium: Medium, seed: int, media: int, tracers: int) -> Ensemble:
        return simulate(
            medium, restitution=e, times=times, seed=seed, workers=system.workers, media=media,
            tracers=tracers, observables=("finals",),
            tangential_restitution=system.tangential_restitution,
        )  # fmt: skip

    tell(f"e = {e:g}: {hard}")
    solving = beside.submit(_solutions, law, times, system)
    packed_medium = packed_media(system.number_density, count=system.count)
    packed = followed(packed_medium, seed + 1, system.media, system.tracers)
    if not np.isfinite(packed.mean_free_path.value):
        refuse("until", last, f"no tracer among {hard} has collided by then, some must")
    tell(f"e = {e:g}: {FREE} particles")
    groups = min(100, system.free_tracers // 2)  # independent ones, for the jackknife
    medium = BoltzmannGrad(system.number_density, dimension=3 if d == 3 else 2)
    free = followed(medium, seed, groups, system.free_tracers // groups)
    tell(f"e = {e:g}: kinetic equation")
    found = solving.result()
    found.early = early
    position, edges = found.position, POSITION_EDGES
    shares = position.position_fraction(edges * math.sqrt(float(position.msd[-1])))[-1]
    c, weight = panels_between(SPEED_EDGES, 8)  # F is averaged over each bin's area, or volume
    vdf = d * c ** (d - 1) * last_vdf(found.kinetic)(c) * weight
    solved = {name: getattr(found.kinetic, name) for name in OVER_TIME}
    theory: dict[str, dict[str, Any]] = {KINETIC: solved | rates(times, solved, early, half_rate)}
    theory[KINETIC] |= {
        "free_path": 0.5 / half_rate, "position": shares / np.diff(edges),
        "scaled_vdf": vdf.reshape(-1, 8).sum(axis=1) / np.diff(SPEED_EDGES**d),
    }  # fmt: skip
    if found.exact is not None:
        slope = found.exact.diffusion_slope * found.late.scene.mean_free_path**2
        names = ("cooling_rate", "a2")
        theory[EXACT] = {n: getattr(found.exact, n) for n in names} | {"msd_slope": slope}
        theory[SOLVER] = {n: getattr(found.scaled, n) for n in names}
    if system.is_papers_law:
        theory |= _printed(e, times, system.number_density)
    places = {name: ("time", times) for name in OVER_TIME}
    places |= {"scaled_vdf": ("c", SPEEDS), "position": ("distance", DISTANCES)}
    return Case(
        system.scatterers if system.is_smooth else f"rough {system.scatterers}", e, d, times,
        {name: _reduced(run, early, half_rate) for name, run in ((FREE, free), (hard, packed))},
        theory, {FREE: free, hard: packed}, places, found,
    )  # fmt: skip


def _solved(
    law: Any, density: float, times: Array, outputs: tuple[str, ...], rtol: float, **more: Any
) -> Any:
    """The kinetic equation from a Gaussian start; times in d/U, density in d^-2 or d^-3."""
    told = law.arguments if isinstance(law, CollisionLaw) else {"restitution": law}
    told |= {"number_density": density, "times": times, "outputs": outputs}
    with warnings.catch_warnings():  # a page of rows shows what deviates
        warnings.simplefilter("ignore", ToleranceWarning)
        return kinetics.solve(Scene(**told, **more), rtol=rtol)


def _solutions(law: CollisionLaw, times: Array, system: Cooling) -> SimpleNamespace:
    """The equation at the times of the particles and much later, in place, and among hard disks."""
    density, rtol = system.number_density, system.rtol
    found = SimpleNamespace(exact=None, scaled=None, dense=None)
    if not law.is_elastic:  # the scaling state, in closed form and as solved
        found.exact = kinetics.ScalingSolution(**law.arguments)
        found.scaled = kinetics.solve_scaled(**law.arguments, rtol=rtol)
    found.kinetic = _solved(law, density, times, (*OVER_TIME, "speed_density"), rtol)
    late = np.geomspace(times[0], max(LATEST, 10 * times[-1]), 55)
    found.late = _solved(law, density, late, (*OVER_TIME, "diffusion_coefficient"), rtol)
    place = "msd", "position_density"
    found.position = _solved(law, density, times[-1:], place, system.position_rtol)
    if system.is_papers_law and density <= HIGHEST_DENSITY:
        outputs = OVER_TIME[:3]
        found.dense = _solved(law, density, times, outputs, rtol, scatterers="hard disks")
    return found


def _printed(e: float, times: Array, density: float) -> dict[str, dict[str, Any]]:
    """What the paper's formulas say."""
    found: dict[str, dict[str, Any]] = {
        FIT: {"cooling_rate": float(sonine.cooling_rate_fitted(e))},
        SONINE: {"cooling_rate": float(sonine.cooling_rate(e)), "a2": float(sonine.a2(e))},
    }
    late = np.array([1e150, 1e300])  # d/U, where <r^2> is its limit, a + b ln t, to rounding
    for source, msd in ((FIT, sonine.msd_random_walk), (SONINE, sonine.msd_sonine)):
        found[source]["msd"] = msd(times, e, density)
        if e < 1:
            rise = np.diff(msd(late, e, density)) / np.diff(np.log(late))
            found[source]["msd_slope"] = float(rise[0])
    return found


def _reduced(run: Ensemble, early: int, half_rate: float) -> dict[str, Measured]:
    """All that is measured."""
    d, by_group = run.medium.dimension, run.finals.reshape(run.media, run.tracers, -1)
    # columns: ln v, the direction of v, x, y, collisions, in space z
    speeds = np.exp(by_group[..., 0])
    distances = np.linalg.norm(np.delete(by_group, [0, 1, 4], axis=-1), axis=-1)
    caught = run.statuses.trap_tracers
    speeds[caught[:, 0], caught[:, 1]] = 0.0  # at rest in a corner
    every = sample_of_ensemble(run).sums  # of each configuration
    n, v2, r2 = (np.moveaxis(every.sum(axis=0) - every, -1, 0)[k] for k in (N, V2, R2))
    averages = {n: getattr(run, n) for n in OVER_TIME}
    found = rates(run.times, {n: x.value for n, x in averages.items()}, early, half_rate)
    without = rates(run.times, {"thermal_speed": np.sqrt(v2 / n), "msd": r2 / n}, early, half_rate)
    return {
        **{name: Measured.of(x) for name, x in averages.items()},
        **{name: Measured(x, jackknife_error(without[name])) for name, x in found.items()},
        "free_path": Measured.of(run.mean_free_path),
        "scaled_vdf": scaled_density(speeds, SPEED_EDGES, bin_measure(d)),
        "position": scaled_density(distances, POSITION_EDGES, np.diff(POSITION_EDGES)),
        "trapped": Measured(np.asarray(float(run.statuses.trapped)), np.asarray(np.nan)),
    }  # fmt: skip


# -- driven tracers, and a restitution of the impact speed -----------------------------------------
def _driven(parameter: float, system: Driven, tell: Tell) -> Case:
    """The equation over time and particles, and the steady state where something drives."""
    d, drive, law = system.dimension, system.drive, system.law(parameter)
    of = f"{system.parameter} = {parameter:g} among {system.scatterers}"
    tell(f"{of}: kinetic equation")
    state: Any = kinetics.solve_steady(law, d, **drive, rtol=system.rtol) if drive else None
    times, first = np.geomspace(0.1, 1000.0, 25), 0
    if state is not None:
        # without gains d<v^2>/dt = -lambda(2) <v^3>, which varies by 3/2 of <v^2>, relatively:
        # after ten such times e^-10 of the start is left, as far as the energy remembers it
        rate = law_of(parameter, 1.0, d).decay_rate(2.0) * state.moment(1.0)
        start, first = 10.0 / (1.5 * float(rate)), 13
        times = np.append(np.geomspace(start / 60, start, 14), start * np.linspace(1.5, 4.0, 6))
    density, begin = 0.5 / half_section(d), {**drive, "initial": system.initial}
    names = ("mean_velocity",) if "field" in drive else OVER_TIME[:3]
    names = (*names, "collisions")
    averages = _solved(law, density, times, names, system.time_rtol, dimension=d, **begin)
    tell(f"{of}: {FREE} particles")
    tracers = min(system.collisions / float(averages.collisions[-1]), system.most_tracers)

    def followed(times: Array, beside: int, **more: Any) -> Ensemble:
        # the density at which l = d, so that lengths in d are lengths in l
        return simulate(
            BoltzmannGrad(density, dimension=3 if d == 3 else 2), law, times=times,
            media=system.groups, tracers=max(2, round(tracers / system.groups)),
            seed=system.seed + beside + 1000 * d + round(1e6 * parameter), workers=system.workers,
            observables=("positions", "velocities"), **begin | more,
        )  # fmt: skip

    run = followed(times, 0)
    said = {name: np.asarray(getattr(averages, name)) for name in names}
    measured = {n: Measured.of(getattr(run, n)) for n in said if n != "mean_velocity"}
    if "field" in drive:
        said["drift_from_rest"] = said.pop("mean_velocity")[:, 0]
        measured["drift_from_rest"] = Measured.of(run.drift)
    places = {name: ("time", times) for name in said}
    theory: dict[str, dict[str, Any]] = {SOLVER: said, EXACT: {}}
    if state is not None:
        elapsed = float(times[-1] - times[first])
        v: Any = _vectors(run, "velocities")[first:]
        size: Any = np.linalg.norm(v, axis=-1)
        by = [(1, 0), (2, 0), (3, 0), (4, 0), (5, 0), (1, 1), (2, 1), (3, 1)]  # <v^p cos^k>
        s: dict[Any, Any] = {(q, k): (size ** (q - k) * v[..., 0] ** k).mean((0, 2)) for q, k in by}
        exact: dict[Any, Any] = {(p, k): state.moment(float(p), k) for p, k in s}
        s |= _growth(run, first)
        spread = (state.diffusion_parallel, state.diffusion_perpendicular)
        exact |= {"x": state.drift * elapsed, "xx": 2 * elapsed * spread[0]}
        exact |= {"yy": 2 * elapsed * spread[1]}
        if "field" not in drive:  # the drift in a weak one
            weak = {"field": WEAK_FIELD}
            s["u"] = _growth(followed(times[[first, -1]], 1, **weak), 0)["x"]
            exact["u"] = kinetics.solve_steady(law, d, **drive, **weak, rtol=1e-6).drift * elapsed
        quantities: Any = partial(_steady_averages, elapsed, parameter, system)
        measured |= jackknifed(s, quantities)
        theory[SOLVER] |= quantities(exact)
        theory[EXACT] = dict.fromkeys({"energy", "fourth"} & {*theory[SOLVER]}, 1.0)
        if "field" in drive:
            theory[EXACT]["momentum"] = (1.5 if d == 2 else 2.0) / (1.0 + parameter)
        if w := drive.get("bath_speed"):
            square = w**2 * (1.0 + parameter) / (1.0 - parameter)
            # of the relative velocity, which is Gaussian
            rate = math.sqrt(square + w**2) * math.sqrt(math.pi / 2 if d == 2 else 8 / math.pi)
            theory[EXACT] = {"steady_speed": math.sqrt(d * square), "steady_a2": 0.0,
                             "steady_rate": rate, "einstein": 1.0}  # fmt: skip
            ratio = state.mobility * square / state.diffusion_coefficient
            theory[SOLVER] |= {"steady_rate": state.collision_rate, "einstein": ratio}
    # not the run: its positions and velocities take 100 MB
    kind = f"{system.scatterers}, {system.name}"
    ran = {FREE: SimpleNamespace(media=run.media, tracers=run.tracers)}
    return Case(kind, parameter, d, times, {FREE: measured}, theory, ran, places, state)


def _vectors(run: Ensemble, name: str) -> Array:
    """Its velocities or positions, (n_times, n_groups, n_in_group, d)."""
    found: Array = getattr(run, name)
    return found.reshape(len(found), run.media, run.tracers, -1)


def _growth(run: Ensemble, first: int) -> dict[Any, Array]:
    """Growth of <x>, of the variance of x, and of <y^2>, from this time to the last, of each group.

    Groups share the law: their means of x differ by chance alone, which the variance leaves out.
    """
    r = _vectors(run, "positions")[[first, -1]]
    x = r[..., 0]
    variance = (x - x.mean(axis=(1, 2), keepdims=True)) ** 2
    both = {"x": x, "xx": variance, "yy": (r[..., 1:] ** 2).mean(axis=-1)}
    return {key: np.diff(each.mean(axis=2), axis=0)[0] for key, each in both.items()}


def _steady_averages(
    elapsed: float, restitution: float, system: Driven, s: Mapping[Any, Any]
) -> dict[str, Array]:
    """What is compared in the steady state, of moments <v^p cos^k> by (p, k), and growths."""
    d, law, drive = system.dimension, law_of(restitution, 1.0, system.dimension), system.drive
    g, noise = drive.get("field", 0.0), drive.get("heating", 0.0)
    found: dict[str, Any] = {}
    if g:
        found = {"drift": s["x"] / elapsed, "mean_square_speed": s[2, 0], "mean_speed": s[1, 0],
                 "diffusion_parallel": s["xx"] / (2 * elapsed),
                 "diffusion_perpendicular": s["yy"] / (2 * elapsed),
                 "momentum": s[2, 1]}  # fmt: skip
    else:
        found = {"steady_speed": np.sqrt(s[2, 0]),
                 "steady_a2": d / (d + 2) * s[4, 0] / s[2, 0] ** 2 - 1,
                 "diffusion": (s["xx"] + (d - 1) * s["yy"]) / (2 * d * elapsed),
                 "weak_drift": s["u"] / (elapsed * WEAK_FIELD)}  # fmt: skip
    if g or noise:  # v^2 and v^4 do not change
        gain = 2 * g * s[1, 1] + 2 * d * noise
        fourth = 4 * g * s[3, 1] + 4 * (d + 2) * noise * s[2, 0]
        found["energy"] = law.decay_rate(2.0) * s[3, 0] / gain
        found["fourth"] = law.decay_rate(4.0) * s[5, 0] / fourth
    return found
