"""Runs the solver and the particles on every system, and reduces what they give to `Case` values.

Rows, figures and the findings read nothing else, whatever the system.
"""

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

import kinetics
from kinetics import Scene, Solution, sonine
from kinetics.collision import CollisionLaw, law_in_medium, law_of
from kinetics.collision.medium import HIGHEST_DENSITY
from kinetics.crosscheck.compare.statistics import errors as jackknife_error
from kinetics.crosscheck.report.systems import SCATTERERS, Cooling, Driven, Falling, System
from kinetics.crosscheck.report.systems import half_cross_section as half_section
from kinetics.errors import ToleranceWarning
from kinetics.numerics.gauss import panels_between
from kinetics.validation import refuse
from particles import BoltzmannGrad, Ensemble, HardDisks, HardSpheres, Medium, simulate

KINETIC, RESCALED = "kinetic equation", "kinetic equation, measured l"
EXACT, SOLVER, FIT, SONINE = "exact", "solver", "paper's fit", "Sonine"
FREE, LIMIT = "Boltzmann-Grad", "limit e → 1"
# what the theory of a finite density knows, each with what the one before it has
PATH, LEADING, FIRST, FITTED = "free path", "leading order", "first order", "fitted second order"
AVERAGES = "thermal_speed a2 msd kurtosis"  # without a field, at each time
OVER_TIME = tuple(AVERAGES.split())
FALL: dict[str, Any] = {"initial": "rest", "field": 1.0}  # how tracers start in a field
LATEST = 1e9  # last time in d/U of the equation alone
# of the approach to the steady state in a field, in sqrt(l/g)
APPROACH_TIMES = np.geomspace(0.1, 40.0, 33)
# bins of c = v/v0 for F(c), and of R = r/sqrt(<r^2>) for G(R)
SPEED_EDGES = np.concatenate([np.linspace(0.0, 2.0, 21), np.linspace(2.25, 6.0, 16)])
POSITION_EDGES = np.concatenate([np.linspace(0.0, 3.0, 31), np.linspace(3.25, 6.0, 12)])
SPEEDS, DISTANCES = ((edges[1:] + edges[:-1]) / 2 for edges in (SPEED_EDGES, POSITION_EDGES))
LEAST_EXPECTED = 50  # samples in a bin before its jackknife error is trusted

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
    differences : standard errors of the hard scatterers minus `RESCALED`, which both change
    solved : the solutions behind, which figures draw between the points
    """

    system: str
    restitution: float
    dimension: int
    times: Array
    measured: dict[str, dict[str, Measured]]
    theory: dict[str, dict[str, Any]]
    runs: dict[str, Ensemble]
    places: Mapping[str, tuple[str, Array]] = {}
    differences: Mapping[str, Array] = {}
    solved: Any = None

    @property
    def cools(self) -> bool:
        """Whether there is a scaling state: the law is not elastic."""
        return getattr(self.solved, "exact", None) is not None

    def samples(self, source: str) -> int:
        """How many tracers a source has."""
        return self.runs[source].media * self.runs[source].tracers


class Results(NamedTuple):
    """Everything that was run: the cases, and what varies another parameter, by name."""

    system: System
    cases: Sequence[Case]
    more: dict[str, Any]

    @property
    def cooling(self) -> list[Case]:
        """The cases that cool."""
        return [case for case in self.cases if case.cools]


# -- numbers of one run or solution ----------------------------------------------------------------
def contact_value(number_density: float, dimension: int = 2) -> float:
    """The pair correlation at contact, g(d), by which the mean free path is divided.

    Of hard disks: D. Henderson, Mol. Phys. 30, 971 (1975); number_density in d^-2. Of hard spheres:
    N. F. Carnahan and K. E. Starling, J. Chem. Phys. 51, 635 (1969); in d^-3.
    """
    x = math.pi * number_density / (2 * dimension)  # their share of the plane, or of space
    return (1 - x / 2) / (1 - x) ** 3 if dimension == 3 else (1 - 7 * x / 16) / (1 - x) ** 2


def rates(
    times: Array, averages: Mapping[str, Array], early: int, half_rate: float
) -> dict[str, Array]:
    """h from 1/v0, and d<r^2>/d ln t, between index `early` and the last time; half_rate 1/2l."""
    (first, last), (r1, r2) = (averages[n][[early, -1]] for n in ("thermal_speed", "msd"))
    slope = (1 / last - 1 / first) / (times[-1] - times[early])
    spread = (r2 - r1) / np.log(times[-1] / times[early])
    return {"cooling_rate": np.asarray(slope / half_rate), "msd_slope": np.asarray(spread)}


def ball(dimension: int) -> float:
    """Area of the unit circle, or volume of the unit sphere."""
    return math.pi if dimension == 2 else 4 * math.pi / 3


def gaussian_vdf(c: ArrayLike, dimension: int) -> Array:
    """The Gaussian F(c) with <c^2> = 1: a density in the plane, or in space."""
    d = dimension
    return np.asarray((d / 2 / math.pi) ** (d / 2) * np.exp(-d / 2 * np.square(c)))


def bin_measure(dimension: int) -> Array:
    """Area, or volume, of each bin of c."""
    return np.asarray(ball(dimension) * np.diff(SPEED_EDGES**dimension))


def last_vdf(solution: Solution) -> Callable[[Array], Array]:
    """F(c) of a solution at its last time, from its radial density over v = c v0(t)."""
    v0, d = float(solution.thermal_speed[-1]), solution.scene.dimension
    surface, power = d * ball(d), d - 1
    return lambda c: v0 * solution.speed_density(c * v0)[-1] / (surface * c**power)


def bin_average(vdf: Callable[[Array], ArrayLike], dimension: int) -> Array:
    """F(c) averaged over the area, or volume, of each bin of c, by 8 Gauss points in each."""
    c, weight = panels_between(SPEED_EDGES, 8)
    shares = dimension * c ** (dimension - 1) * np.asarray(vdf(c)) * weight
    return np.asarray(shares.reshape(-1, 8).sum(axis=1) / np.diff(SPEED_EDGES**dimension))


def filled(density: Array, samples: int, measure: Array) -> Array:
    """The density in those bins in which it expects enough samples, NaN in others."""
    return np.where(samples * density * measure >= LEAST_EXPECTED, density, np.nan)


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
    if isinstance(system, Falling):
        return _in_field(system, tell)
    if isinstance(system, Driven):
        return Results(system, [_driven(x, system, tell) for x in system.restitutions], {})
    with ThreadPoolExecutor(1) as beside:  # the solver works while tracers are followed
        ends = zip(system.restitutions, system.final_times, strict=True)
        cases = [cooling_case(system, e, last, tell, beside) for e, last in ends]
    return Results(system, cases, {})


def cooling_case(
    system: Cooling, e: float, last: float, tell: Tell, beside: ThreadPoolExecutor
) -> Case:
    """Both simulations and the equation until the last time, in d/U. Calls `tell` three times."""
    law, d, half_rate = system.law(e), system.dimension, system.half_rate
    times = np.geomspace(min(1.0, last / 10), last, system.n_times)
    early = int(np.searchsorted(times, last / 10))
    seed, hard = system.seed + 2 * system.restitutions.index(e), f"hard {system.scatterers}"
    free_media = BoltzmannGrad(system.number_density, dimension=3 if d == 3 else 2)
    packed_media: Any = HardSpheres if d == 3 else HardDisks

    def followed(medium: Medium, seed: int, media: int, tracers: int) -> Ensemble:
        return simulate(
            medium, restitution=e, times=times, seed=seed, workers=system.workers, media=media,
            tracers=tracers, observables=("finals",),
            tangential_restitution=system.tangential_restitution,
        )  # fmt: skip

    tell(f"e = {e:g}: {hard}")
    solving = beside.submit(_solutions, law, times, system)
    medium = packed_media(system.number_density, count=system.count)
    packed = followed(medium, seed + 1, system.media, system.tracers)
    path = float(packed.mean_free_path.value)
    if not np.isfinite(path):
        refuse("until", last, f"no tracer among {hard} has collided by then, some must")
    tell(f"e = {e:g}: {FREE} particles")
    groups = min(100, system.free_tracers // 2)  # independent ones, for the jackknife
    free = followed(free_media, seed, groups, system.free_tracers // groups)
    tell(f"e = {e:g}: kinetic equation")
    found = solving.result()
    thinner = 1 / (2 * path) / half_section(d)
    found.rescaled = _solved(law, thinner, times, f"{AVERAGES} speed_density", system.rtol)
    found.early = early
    measured, differences = _reduced(packed, early, half_rate, found.rescaled)
    position, edges = found.position, POSITION_EDGES
    shares = position.position_fraction(edges * math.sqrt(float(position.msd[-1])))[-1]
    theory: dict[str, dict[str, Any]] = {
        name: _over_time(solution, early, half_rate)
        | {"scaled_vdf": bin_average(last_vdf(solution), d)}
        for name, solution in ((KINETIC, found.kinetic), (RESCALED, found.rescaled))
    }
    theory[KINETIC] |= {"free_path": 0.5 / half_rate, "position": shares / np.diff(edges)}
    theory["contact"] = {"free_path": 0.5 / half_rate / contact_value(system.number_density, d)}
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
        {FREE: _reduced(free, early, half_rate)[0], hard: measured}, theory,
        {FREE: free, hard: packed}, places, differences, found,
    )  # fmt: skip


def _solved(law: Any, density: float, times: Array, outputs: str, rtol: float, **more: Any) -> Any:
    """The kinetic equation from a Gaussian start; times in d/U, density in d^-2 or d^-3."""
    told = law.arguments if isinstance(law, CollisionLaw) else {"restitution": law}
    told |= {"number_density": density, "times": times, "outputs": tuple(outputs.split())}
    with warnings.catch_warnings():  # a page of rows shows what deviates
        warnings.simplefilter("ignore", ToleranceWarning)
        return kinetics.solve(Scene(**told, **more), rtol=rtol)


def _solutions(law: CollisionLaw, times: Array, system: Cooling) -> SimpleNamespace:
    """The equation at the times of the particles and much later, in place, and among hard disks."""
    density, rtol = system.number_density, system.rtol
    found = SimpleNamespace(exact=None, scaled=None, dense=None, dense_slope=None, levels={})
    if not law.is_elastic:  # the scaling state, in closed form and as solved
        found.exact = kinetics.ScalingSolution(**law.arguments)
        found.scaled = kinetics.solve_scaled(**law.arguments, rtol=rtol)
    found.kinetic = _solved(law, density, times, f"{AVERAGES} speed_density", rtol)
    late = np.geomspace(times[0], max(LATEST, 10 * times[-1]), 55)
    found.late = _solved(law, density, late, f"{AVERAGES} diffusion_coefficient", rtol)
    place, last = "msd position_density", times[-1:]
    found.position = _solved(law, density, last, place, system.position_rtol)
    if not system.is_papers_law or density > HIGHEST_DENSITY:
        return found
    outputs, medium = "thermal_speed a2 msd", {"scatterers": "hard disks"}
    found.dense = _solved(law, density, times, outputs, rtol, **medium)
    if found.exact is not None:
        ends = np.array([LATEST / 10, LATEST])
        found.dense_slope = _slope(ends, _solved(law, density, ends, outputs, rtol, **medium).msd)
    # <r^2> at the last time, in d^2, by what is known of hard disks
    leading = law_in_medium(law, "hard disks", density, 1.0, "leading")
    thinner = 0.5 / leading.mean_free_path(density, 1.0)
    found.levels[PATH] = _solved(law, thinner, last, "msd", rtol).msd[-1]
    for name, order in ((LEADING, "leading"), (FIRST, "first"), (FITTED, "second")):
        one = _solved(law, density, last, "msd", rtol, density_order=order, **medium)
        found.levels[name] = one.msd[-1]
    return found


def _slope(times: Array, msd: Array) -> float:
    return float((msd[-1] - msd[0]) / np.log(times[-1] / times[0]))


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
            found[source]["msd_slope"] = _slope(late, msd(late, e, density))
    return found


def _over_time(source: Any, early: int, half_rate: float) -> dict[str, Any]:
    """Averages over time of a solution or a run, and the rates of its last decade."""
    values = {name: getattr(source, name) for name in OVER_TIME}
    averages = {name: np.asarray(getattr(x, "value", x)) for name, x in values.items()}
    return averages | rates(source.times, averages, early, half_rate)


def _reduced(
    run: Ensemble, early: int, half_rate: float, rescaled: Solution | None = None
) -> tuple[dict[str, Measured], dict[str, Array]]:
    """All that is measured, and the errors of data minus theory with the run's own free path l.

    Both change when a configuration is left out: the theory by its derivative in ln l, as v0 and a2
    depend on t/l alone, and <r^2> is l^2 times a function of t/l.
    """
    d, by_group = run.medium.dimension, run.finals.reshape(run.media, run.tracers, -1)
    log_speed, _, *place = np.moveaxis(by_group, -1, 0)
    place.pop(2)  # collisions
    speeds, distances = np.exp(log_speed), np.hypot(*place[:2])
    caught = run.statuses.trap_tracers
    speeds[caught[:, 0], caught[:, 1]] = 0.0  # at rest in a corner
    for third in place[2:]:
        distances = np.hypot(distances, third)
    parts = _without_each(run)
    replicates = [_over_time(part, early, half_rate) for part in parts]
    found = _over_time(run, early, half_rate)

    def errors(rows: list[dict[str, Array]], *names: str) -> dict[str, Array]:
        return {n: jackknife_error(np.array([row[n] for row in rows])) for n in names}

    of_rates = errors(replicates, "cooling_rate", "msd_slope")
    bins = np.diff(POSITION_EDGES)
    measured = {
        **{name: Measured.of(getattr(run, name)) for name in OVER_TIME},
        **{name: Measured(found[name], error) for name, error in of_rates.items()},
        "free_path": Measured.of(run.mean_free_path),
        "scaled_vdf": scaled_density(speeds, SPEED_EDGES, bin_measure(d)),
        "position": scaled_density(distances, POSITION_EDGES, bins),
        "trapped": Measured(np.asarray(float(run.statuses.trapped)), np.asarray(np.nan)),
    }
    if rescaled is None:
        return measured, {}
    theory = {name: np.asarray(getattr(rescaled, name)) for name in OVER_TIME}
    per_log_path = {
        name: (2 * values if name == "msd" else 0) - np.gradient(values, np.log(run.times))
        for name, values in theory.items()
    }
    log_path, apart = np.log(float(run.mean_free_path.value)), []
    for part, values in zip(parts, replicates, strict=True):
        moved = np.log(float(part.mean_free_path.value)) - log_path
        expected = {name: value + moved * per_log_path[name] for name, value in theory.items()}
        expected |= rates(run.times, expected, early, half_rate)
        apart.append({name: values[name] - expected[name] for name in values})
    return measured, errors(apart, *apart[0])


def _without_each(run: Ensemble) -> list[Ensemble]:
    """The ensemble without one of its configurations, of whose sums its averages are made."""
    sums = {name: run.arrays[name] for name in ("moments", "path_sums")}
    rest = {name: array.sum(axis=0) - array for name, array in sums.items()}
    return [
        replace(run, arrays={**run.arrays, **{n: rest[n][k][None] for n in sums}})
        for k in range(run.media)
    ]


def picture(system: Any) -> tuple[Ensemble, str]:
    """A few tracers among hard disks whose paths are drawn, and which they are in words."""
    many: dict[str, Any] = {"media": 2, "seed": system.seed, "workers": 1}
    if system.in_field:
        e, density, until = 0.5, 0.06, 150.0
        run = simulate(HardDisks(density, 2000), e, times=[until], tracers=4, field=0.12, **many)
        return run, f"e = {e:g}, with the field, g l = U², to the right until {until:g} d/U"
    # near the middle: tracers stay near at e = 0, and fly far at 1
    e = min(system.restitutions, key=lambda each: abs(each - 0.7))
    until = system.final_times[system.restitutions.index(e)]
    medium = HardDisks(system.number_density, min(system.count, 2000))
    run = simulate(
        medium, e, times=[until], tracers=3, observables=("finals",),
        tangential_restitution=system.tangential_restitution, **many,
    )  # fmt: skip
    return run, f"e = {e:g}, until {until:g} d/U or 20 bounces"


# -- tracers in a uniform field --------------------------------------------------------------------
def _in_field(system: Falling, tell: Tell) -> Results:
    cases: list[Case] = []
    more: dict[str, Any] = {"lines": {}, "approach": []}
    for d in system.dimensions:
        tell(f"{SCATTERERS[d]}: solver")
        at = np.unique([*system.line, *system.restitutions])
        states = [kinetics.solve_field(float(e), d, rtol=1e-6) for e in at]
        names = ("drift", "diffusion_parallel", "diffusion_perpendicular")
        line = {name: np.array([getattr(state, name) for state in states]) for name in names}
        more["lines"][d] = {"restitution": at, **line}
        for e in system.restitutions:
            tell(f"{SCATTERERS[d]}, e = {e:g}")
            cases.append(_steady(e, d, system))
        for e in system.approach or ():
            tell(f"{SCATTERERS[d]}, e = {e:g}: from rest")
            more["approach"].append(_from_rest(e, d, system))
    return Results(system, [*cases, *more["approach"]], more)


def _dilute(
    restitution: Any, parameter: float, d: int, times: Array, each: float,
    system: Falling | Driven, observables: Sequence[str], beside: int = 0, **more: Any,
) -> Ensemble:  # fmt: skip
    """So many tracers, of about `each` collisions, that they make the collisions asked for."""
    wanted = system.collisions / each
    tracers = max(2, round(min(wanted, system.most_tracers) / system.groups))
    # the density at which l = d, so that lengths in d are lengths in l
    medium = BoltzmannGrad(0.5 / half_section(d), dimension=3 if d == 3 else 2)
    seed = system.seed + beside + 1000 * d + round(1e6 * parameter)
    return simulate(
        medium, restitution, times=times, media=system.groups, tracers=tracers, seed=seed,
        workers=system.workers, observables=observables, **more,
    )  # fmt: skip


def _vectors(run: Ensemble, name: str) -> Array:
    """Its velocities or positions, (n_times, n_groups, n_in_group, d)."""
    found: Array = getattr(run, name)
    return found.reshape(len(found), run.media, run.tracers, -1)


def _steady(restitution: float, dimension: int, system: Falling) -> Case:
    """Solve, follow particles until they have forgotten their start, and average from there on."""
    state = kinetics.solve_field(restitution, dimension, rtol=system.rtol)
    # d<v^2>/dt = 2 u - lambda(2) <v^3>, whose last term varies by 3/2 of <v^2>, relatively: after
    # ten such times e^-10 of the start is left, as far as the energy remembers it
    first = 10.0 / (1.5 * float(state.law.decay_rate(2.0)) * state.mean_speed)
    times = np.linspace(first, 3.0 * first, 9)
    each, both = float(times[-1]) * state.mean_speed, ("positions", "velocities")
    run = _dilute(restitution, restitution, dimension, times, each, system, both, **FALL)
    law, v, r = state.law, _vectors(run, "velocities"), _vectors(run, "positions")
    speed, along = np.linalg.norm(v, axis=-1), v[..., 0]
    s: dict[Any, Array] = {(p, 0): speed**p for p in (1, 2, 3, 4)}
    s |= {(0, 1): along / speed, (1, 1): along, (2, 1): speed * along, (2, 2): along**2}
    for k, at in enumerate((r[:1], r[-1:])):
        z = at[..., 0]
        s |= {f"z{k}": z, f"zz{k}": z**2, f"xx{k}": (at[..., 1:] ** 2).mean(axis=-1)}
    s = {name: x.mean(axis=(0, 2)) for name, x in s.items()}  # of each group
    elapsed = float(run.times[-1] - run.times[0])

    def quantities(s: Mapping[Any, Array]) -> dict[str, Array]:
        along = s["zz1"] - s["z1"] ** 2 - s["zz0"] + s["z0"] ** 2
        return {
            "drift": (s["z1"] - s["z0"]) / elapsed,
            "mean_square_speed": s[2, 0],
            "mean_square_along": s[2, 2],
            "mean_speed": s[1, 0],
            "diffusion_parallel": along / (2 * elapsed),
            "diffusion_perpendicular": (s["xx1"] - s["xx0"]) / (2 * elapsed),
            **relations(law, lambda p, k: s[p, k]),
        }

    measured = jackknifed(s, quantities)
    averages = {name: float(getattr(state, name)) for name in [*measured][:6]}
    solved, exact = exact_relations(state)
    theory = {SOLVER: averages | solved, EXACT: exact}
    theory[LIMIT] = near_elastic(restitution, dimension)
    name, d = f"{SCATTERERS[dimension]} in a field", dimension
    return Case(name, restitution, d, times, {FREE: measured}, theory, {FREE: run}, solved=state)


def relations(law: CollisionLaw, moment: Callable[[int, int], Any]) -> dict[str, Any]:
    """What moments <v^p cos^k> give for 1/lambda_1(1), and then for 1: the equations for the
    moments v v_z, v^2, v^3 and v, which do not change.
    """
    loss = {p: float(law.decay_rate(float(p))) for p in (1, 2, 3)}
    return {
        "momentum": moment(2, 1),
        "energy": loss[2] * moment(3, 0) / (2 * moment(1, 1)),
        "cube": loss[3] * moment(4, 0) / (3 * moment(2, 1)),
        "direction": moment(0, 1) / (loss[1] * moment(2, 0)),
    }


def exact_relations(state: Any) -> tuple[dict[str, float], dict[str, float]]:
    """Both sides of `relations`, solver and closed form, and those of ln v and 1/v besides."""
    law, moment, e = state.law, state.moment, float(state.restitution)
    solved = relations(law, moment)
    solved["logarithm"] = moment(-1, 1) / (law.mean_log_loss * moment(1, 0))
    if e > 0.0:
        solved["inverse"] = moment(-2, 1) / -float(law.decay_rate(-1.0))
    exact = dict.fromkeys(solved, 1.0)
    exact["momentum"] = (1.5 if state.dimension == 2 else 2.0) / (1.0 + e)
    return solved, exact


def near_elastic(restitution: Any, dimension: int) -> dict[str, Any]:
    """The limiting laws as collisions become elastic, in sqrt(g l) and sqrt(g l^3).

    With eps = 1 - e^2 speeds are distributed as exp(-a v^4) and grow as eps^(-1/4); u = lambda(2)
    <v^3>/2. Across the field a tracer diffuses as without one, with the mean speed; along it no
    closed form is known, and the number is the solver's as e -> 1.
    """
    fall, loss, turn, along = {
        2: (2 / 9, 2 / 3, 4 / 3, 0.176205),
        3: (3 / 16, 1 / 2, 1.0, 0.202982),
    }[dimension]  # a/eps, lambda(2)/eps, lambda_1(0) at e = 1, D along eps^(1/4)
    d, eps = dimension, 1.0 - np.square(np.asarray(restitution, dtype=float))

    def moment(p: int) -> float:
        return fall ** (-p / 4) * math.gamma((p + d) / 4) / math.gamma(d / 4)

    with np.errstate(divide="ignore"):
        return {
            "drift": loss * moment(3) / 2 * eps**0.25,
            "diffusion_parallel": along * eps**-0.25,
            "diffusion_perpendicular": moment(1) / (d * turn) * eps**-0.25,
        }


def _from_rest(restitution: float, dimension: int, system: Falling) -> Case:
    """Solver and particles from rest, at `APPROACH_TIMES`."""
    times = APPROACH_TIMES
    state = kinetics.solve_field(restitution, dimension, rtol=system.rtol)
    each, density = float(times[-1]) * state.mean_speed, 0.5 / half_section(dimension)
    run = _dilute(restitution, restitution, dimension, times, each, system, (), **FALL)
    names = "mean_velocity thermal_speed"
    solved = _solved(state.law, density, times, names, system.time_rtol, **FALL)
    second = Measured.of(run.thermal_speed)
    measured = {
        "drift_from_rest": Measured.of(run.drift),
        "square_from_rest": Measured(second.value**2, 2 * second.value * second.error),
    }
    theory = {SOLVER: {
        "drift_from_rest": solved.mean_velocity[:, 0],
        "square_from_rest": solved.thermal_speed**2,
    }}  # fmt: skip
    places = {name: ("time", times) for name in measured}
    name, ran = f"{SCATTERERS[dimension]} in a field", {FREE: run}
    found = {FREE: measured}
    return Case(name, restitution, dimension, times, found, theory, ran, places, solved=state)


# -- driven tracers, and a restitution of the impact speed -----------------------------------------
def _driven(parameter: float, system: Driven, tell: Tell) -> Case:
    """The equation over time and particles, and the steady state where something drives."""
    d, drive, law = system.dimension, system.drive, system.law(parameter)
    of = f"{system.parameter} = {parameter:g} among {system.scatterers}"
    tell(f"{of}: kinetic equation")
    state: Any = kinetics.solve_steady(law, d, **drive, rtol=system.rtol) if drive else None
    times, first, at = np.geomspace(0.1, 1000.0, 25), 0, 12  # F(c) at t = 10
    if state is not None:
        # as in `_steady`: after `start` the energy has forgotten how it began
        rate = law_of(parameter, 1.0, d).decay_rate(2.0) * state.moment(1.0)
        start, first, at = 10.0 / (1.5 * float(rate)), 13, -1
        times = np.append(np.geomspace(start / 60, start, 14), start * np.linspace(1.5, 4.0, 6))
    names, rtol = "thermal_speed a2 msd collisions", system.time_rtol
    density = 0.5 / half_section(d)
    averages = _solved(law, density, times, names, rtol, dimension=d, **drive)
    said = {name: getattr(averages, name) for name in names.split()}
    places = {name: ("time", times) for name in said} | {"scaled_vdf": ("c", SPEEDS)}
    speeds = None
    if state is None:  # later the solver knows the density of speeds less well
        names = "thermal_speed speed_density"
        speeds = _solved(law, density, times[[at]], names, rtol, dimension=d)
    vdf = steady_vdf(state) if speeds is None else last_vdf(speeds)
    tell(f"{of}: {FREE} particles")
    each = float(averages.collisions[-1])
    followed: Any = partial(_dilute, law, parameter, d, each=each, system=system, **drive)
    run = followed(times, observables=("positions", "velocities"))
    measured = {name: Measured.of(getattr(run, name)) for name in said}
    speed, r = np.linalg.norm(_vectors(run, "velocities"), axis=-1), _vectors(run, "positions")
    measured["scaled_vdf"] = scaled_density(speed[at], SPEED_EDGES, bin_measure(d))
    said["scaled_vdf"] = filled(bin_average(vdf, d), run.media * run.tracers, bin_measure(d))
    theory: dict[str, dict[str, Any]] = {SOLVER: said, EXACT: {}}
    if state is not None:
        end, weak = times[[first, -1]], {"field": system.field}
        drifting = followed(end, observables=("positions",), beside=1, **weak)
        x = _vectors(drifting, "positions")[..., 0].mean(axis=2)
        elapsed = float(end[1] - end[0])
        s = {f"v^{p}": (speed[first:] ** p).mean(axis=(0, 2)) for p in (2, 3, 4, 5)}
        s |= {"r": (r[-1] ** 2 - r[first] ** 2).sum(axis=-1).mean(axis=1), "x": x[1] - x[0]}
        quantities = partial(_steady_averages, elapsed, parameter, system)
        measured |= jackknifed(s, quantities)
        pushed = kinetics.solve_steady(law, d, **drive, **weak, rtol=1e-6)
        moments = {f"v^{p}": state.moment(float(p)) for p in (2, 3, 4, 5)}
        moments |= {"r": 2 * d * elapsed * state.diffusion_coefficient, "x": pushed.drift * elapsed}
        theory[SOLVER] |= quantities(moments)
        theory[EXACT] = dict.fromkeys(("noise_energy", "noise_fourth"), 1.0)
        if w := system.bath_speed:
            square = w**2 * (1.0 + parameter) / (1.0 - parameter)
            # of the relative velocity, which is Gaussian
            rate = math.sqrt(square + w**2) * math.sqrt(math.pi / 2 if d == 2 else 8 / math.pi)
            theory[EXACT] = {"steady_speed": math.sqrt(d * square), "steady_a2": 0.0,
                             "steady_rate": rate, "einstein": 1.0}  # fmt: skip
            ratio = state.mobility * square / state.diffusion_coefficient
            theory[SOLVER] |= {"steady_rate": state.collision_rate, "einstein": ratio}
    solved = SimpleNamespace(state=state, vdf=vdf, speeds=speeds)
    kind, ran = f"{system.scatterers}, {system.name}", {FREE: run}
    return Case(kind, parameter, d, times, {FREE: measured}, theory, ran, places, solved=solved)


def steady_vdf(state: Any) -> Callable[[Array], Array]:
    """F(c) of a steady state without a field."""
    v0, d = state.thermal_speed, state.dimension
    return lambda c: v0**d * state.vdf(np.ravel(c) * v0)[:, 0].reshape(np.shape(c))


def _steady_averages(
    elapsed: float, restitution: float, system: Driven, s: Mapping[str, Any]
) -> dict[str, Array]:
    """What is compared in the steady state, of moments <v^p>, and growths of <r^2> and <x>."""
    d, law = system.dimension, law_of(restitution, 1.0, system.dimension)
    found = {
        "steady_speed": np.sqrt(s["v^2"]),
        "steady_a2": d / (d + 2) * s["v^4"] / s["v^2"] ** 2 - 1,
        "diffusion": s["r"] / (2 * d * elapsed),
        "weak_drift": s["x"] / (elapsed * system.field),
    }
    if noise := system.heating:
        found["noise_energy"] = law.decay_rate(2.0) * s["v^3"] / (2 * d * noise)
        fourth = 4 * (d + 2) * noise * s["v^2"]
        found["noise_fourth"] = law.decay_rate(4.0) * s["v^5"] / fourth
    return found
