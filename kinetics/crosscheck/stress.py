"""The stability sweep: solvers and particles at their limits, a verdict for each case.

A row of the table in `all_cases` is the name of a group, the work of its cases, and the values of
each argument of the work; every choice of these is a case. The work gives an `Outcome`: the error
asked for, the error reached, against `digits` known apart from the solver or against a `tighter`
solution, and what every answer must keep (`invariants`, `of_particles`).
"""

import math
import time
import warnings
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

import kinetics
import particles
from kinetics import Beam, Gaussian, Monoenergetic, SpeedSamples, SpeedTable
from kinetics.collision import CollisionLaw
from kinetics.crosscheck import references
from kinetics.crosscheck.files import dumps, markdown_table
from kinetics.errors import InputError, ToleranceWarning
from kinetics.numerics.gauss import panels_between

Violations = dict[str, tuple[float, float]]
"""Name of an invariant -> how far it is violated, and what is allowed; neither is negative."""

FORMAT = "inelastic-lorentz stress 2"
HOLDS, SAYS_SO, MISSED, BROKEN = "holds", "says so", "missed", "broken"
VERDICTS = {
    HOLDS: "a finite answer within the error asked for, and every invariant kept",
    SAYS_SO: "the status says that the error asked for was not reached",
    MISSED: "the error asked for was not reached, and the status claims that it was",
    BROKEN: "not finite, an invariant violated, a warning, an exception, or a minute's work",
}
ACCEPTED = (HOLDS, SAYS_SO)


# -- a case and its verdict -----------------------------------------------------------------------
class Outcome(NamedTuple):
    """What a run gave."""

    asked: float = math.inf  # where no error was asked for
    reached: float = math.nan  # where there is no reference; infinite for no finite answer
    converged: bool = True  # as the status claims
    invariants: Mapping[str, tuple[float, float]] = {}
    note: str = ""


class Case(NamedTuple):
    """A case that has not been run."""

    group: str
    name: str
    work: Callable[[], Outcome]


def judge(outcome: Outcome, seconds: float, longest: float = 60.0) -> str:
    """The verdict on a run that ended without an exception, in so many s of processor time."""
    kept = all(violation <= allowed for violation, allowed in outcome.invariants.values())
    if math.isinf(outcome.reached) or not kept or seconds > longest:
        return BROKEN
    if not outcome.converged:
        return SAYS_SO
    return MISSED if outcome.reached > outcome.asked else HOLDS


def attempt(case: Case) -> dict[str, Any]:
    """The row of one case, with what it violates; only an interruption stops the sweep."""
    begin, outcome = time.process_time(), Outcome()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", ToleranceWarning)  # the status is looked at
            outcome = case.work()
        verdict, note = judge(outcome, time.process_time() - begin), outcome.note
    except Exception as met:  # whatever it is, it is the finding
        verdict, note = BROKEN, f"{type(met).__name__}: {met}"

    violated = ((name, x) for name, x in outcome.invariants.items() if not x[0] <= x[1])
    worst, (violation, allowed) = next(violated, ("", (0.0, 0.0)))
    return {
        "group": case.group, "name": case.name, "verdict": verdict, "asked": outcome.asked,
        "reached": outcome.reached, "invariant": worst, "violation": violation, "allowed": allowed,
        "seconds": time.process_time() - begin, "note": " ".join(note.split())[:240],
    }  # fmt: skip


# -- what every answer must keep ------------------------------------------------------------------
def excess(values: Any) -> float:
    """How far the largest value is above 0; 0 if it is not."""
    return max(0.0, float(np.max(values, initial=-math.inf)))


def largest(*errors: Any) -> float:
    """The largest of these errors in size; infinite where one is not finite."""
    sizes = np.abs(np.concatenate([np.ravel(error) for error in errors]))
    return float(sizes.max()) if np.all(np.isfinite(sizes)) else math.inf


def invariants(found: Any) -> Violations:
    """What a `kinetics.Solution` must keep, of those outputs that it has, within its own error."""
    scene, values, times = found.scene, found.values, np.asarray(found.times)
    error = max(found.rtol, found.error_estimate)
    slack, d, law = 4.0 * error + 1e-12, scene.dimension, scene.law
    kept: Violations = {
        f"{name} is finite": (float(np.sum(~np.isfinite(array))), 0.0)
        for name, array in values.items()
    }
    if any(count for count, _ in kept.values()):
        return kept

    def keep(name: str, of: str, violation: Callable[[Any], Any], most: float = slack) -> None:
        if of in values:
            with np.errstate(all="ignore"):
                kept[name] = excess(violation(values[of])), most

    def falls(x: Any) -> Any:  # by more than the error
        return x[:-1] - x[1:] * (1.0 + slack)

    # there is no distribution beyond: <v^4> >= <v^2>^2, and <r^4> >= <r^2>^2
    keep("a2 >= -2/(d + 2)", "a2", lambda a2: -2.0 / (d + 2.0) - a2)
    keep("kurtosis >= 1", "kurtosis", lambda kurtosis: 1.0 - kurtosis)
    if not scene.field:
        kept["<v^0> = 1"] = largest(found.moment(0.0) - 1.0), slack
        for name in ("thermal_speed", "temperature"):
            keep(f"{name} does not grow", name, lambda v: falls(v[::-1]), 0.0)
        for name in ("collisions", "msd"):
            keep(f"{name} does not fall", name, falls, 0.0)
            keep(f"{name} begins at 0", name, lambda n: n[times == 0.0], 0.0)
        # bounces that throw tracers back and nearly stop them make D negative
        if law.tangential_restitution == 1.0 or law.mean_cosine >= 0.0:
            keep("D not negative", "diffusion_coefficient", np.negative)
    if "speed_density" in scene.outputs and not scene.field:
        x, uncollided = np.linspace(math.log(1e-12), math.log(1e3), 30_001), found.uncollided
        for i, v0 in enumerate(np.sqrt(found.moment(2.0))):
            if 1e-140 < v0 < 1e140:
                f = np.exp(x) * v0 * found.speed_density(np.exp(x) * v0)[i]
                mass = float(np.trapezoid(f, x)) + uncollided[i]
                below = excess(-f / max(f.max(), 1e-300))
                kept[f"density not negative, time {i}"] = below, 1.5 * error
                kept[f"mass, time {i}"] = abs(mass - 1.0), 10.0 * error
    if "position_density" in scene.outputs:
        R, weight = panels_between(np.concatenate([[0.0], np.geomspace(1e-2, 30.0, 60)]), 12)
        front = found.ballistic_front[1].sum(axis=1)
        for i in map(int, np.flatnonzero((times > 0.0) & (front == 0.0))):
            g = found.scaled_position_density(R)[i]
            kept[f"G not negative, time {i}"] = excess(-g), error
            for p, allowed in ((0, 10.0 * error), (2, 100.0 * error)):
                kept[f"<R^{p}> = 1, time {i}"] = abs(float(g @ (weight * R**p)) - 1.0), allowed
    if "intermediate_scattering" in scene.outputs:
        F = found.intermediate_scattering([0.0, 1e-300, 1e-3, 0.1, 2.0])
        kept["|F| <= 1"] = excess(np.abs(F) - 1.0), slack
        kept["F(0) = 1"] = largest(F[:, 0] - 1.0), slack
    return kept


def of_particles(run: Any) -> Violations:
    """What a `particles.Ensemble` must keep."""
    s = run.statuses
    ended = s.finished + s.collision_cap + s.trapped + s.escaped
    kept = {"tracers are accounted for": (float(abs(ended - run.media * run.tracers)), 0.0)}
    for name in ("thermal_speed", "msd", "collisions") if run.times.size else ():
        value = getattr(run, name).value[run.samples > 0]
        kept[f"{name} is finite"] = float(np.sum(~np.isfinite(value))), 0.0
    return kept


# -- starts, and references ------------------------------------------------------------------------
STARTS: dict[str, Any] = {  # of other units, directed, and rough, beside those that have a name
    "gaussian of 1e-150": Gaussian(1e-150, 1e-150),
    "speed 1e150": Monoenergetic(1e150),
    "beam along x": Beam(0.0),
    "step": SpeedTable([1.0, 1.0 + 1e-9, 2.0, 2.0 + 1e-9], [0.0, 1.0, 1.0, 0.0]),
    "two peaks": SpeedSamples([0.01, 1.0]),
    "speeds 1e-100 and 1": SpeedSamples([1e-100, 1.0]),
    "tail v^-6": lambda v: 5.0 * np.asarray(v) * np.hypot(1.0, v) ** -7.0,
}


def digits(found: Any) -> float:
    """Error of v0 and a2 against the kept references."""
    scene, horizon = found.scene, "long" if found.times[-1] > 1e3 else "short"
    v0, a2 = (
        references.kept(name, scene.restitution, scene.initial, horizon)
        for name in ("thermal_speed", "a2")
    )
    return largest(found.thermal_speed / v0 - 1.0, (1.0 + found.a2) / (1.0 + a2) - 1.0)


def tighter(found: Any) -> float:
    """Difference to the same scene solved for a hundredth of the error; NaN if it is not known."""
    finer = again(found, 0.01 * found.rtol)
    return apart(found, finer) if finer.error_estimate <= 0.3 * found.rtol else math.nan


def again(found: Any, rtol: float) -> Any:
    """The scene of a Solution once more, to another rtol, with the thermal speed."""
    outputs = tuple(dict.fromkeys(("thermal_speed", *found.scene.outputs)))
    return kinetics.solve(replace(found.scene, outputs=outputs), rtol)


def apart(found: Any, finer: Any) -> float:
    """The largest error of a Solution, a finer one of the same scene taken as exact.

    Averages relative to their size (vectors to their largest component), densities to their
    maximum, those of the speed below 1e-2 of the thermal speed as densities of ln v.
    """
    v0, errors = finer.thermal_speed, list[Any]([0.0])
    with np.errstate(all="ignore"):
        at_zero = math.exp(0.5 * found.scene.state.harmonic(0, 1e-14).log_second_moment())
        sizes = {"a2": 1.0, "mean_velocity": v0[:, None], "velocity_autocorrelation": at_zero * v0}
        for name, values in found.values.items():
            change, exact = np.abs(values - finer.values[name]), np.abs(finer.values[name])
            size = exact.max(axis=tuple(range(1, exact.ndim)), keepdims=True)
            errors.append(np.where(change < 1e-300, 0.0, change / sizes.get(name, size)))
    outputs, both = found.scene.outputs, (found, finer)
    c, R = np.concatenate([[0.0], np.geomspace(1e-8, 30.0, 4000)]), np.linspace(0.0, 8.0, 400)
    for i, unit in enumerate(v0):
        if "speed_density" in outputs:
            f, exact = (one.speed_density(unit * c)[i] for one in both)
            errors.append((f - exact) * np.minimum(1.0, c / 1e-2) / exact.max())
        if "position_density" in outputs and found.times[i] > 0.0:
            errors.append(np.subtract(*(one.scaled_position_density(R)[i] for one in both)))
    for at in (None, 0.3) if "intermediate_scattering" in outputs else ():
        k = [1e-3, 0.1, 2.0]
        errors.append(np.subtract(*(x.intermediate_scattering(k, direction=at) for x in both)))
    return largest(*errors)


def steady_errors(found: Any) -> tuple[float, float]:
    """Errors of a FieldState in <v^2 cos> = 1/lambda_1(1) and 2 <v_x> = lambda(2) <v^3>."""
    fixed = found.moment(2.0, 1) * float(found.law.harmonic_decay_rate(1.0, 1)) - 1.0
    energy = float(found.law.decay_rate(2.0)) * found.moment(3.0) / (2.0 * found.drift) - 1.0
    finite = math.isfinite(fixed + energy + found.mean_square_speed + found.mean_speed)
    return (abs(fixed), abs(energy)) if finite else (math.inf, math.inf)


# -- work of the cases ----------------------------------------------------------------------------
def outcome(
    asked: float, reached: float, found: Any, kept: Violations, adds: float = 1e-12
) -> Outcome:
    """Of a solver's answer; adds : what its reference, or its own promise in doubles, may add."""
    done, note = found.status.name == "CONVERGED", f"estimate {found.error_estimate:.0e}"
    return Outcome(asked + adds, reached, done, kept, note)


def scene(
    law: CollisionLaw, start: str, times: Any, outputs: tuple[str, ...], rtol: float,
    nodes: Any = None, reference: Callable[[Any], float] = tighter, **sizes: Any,
) -> Outcome:  # fmt: skip
    """A scene over time against a reference."""
    state: Any = STARTS.get(start, start)
    asked = kinetics.Scene(law, initial=state, times=times, outputs=outputs, **sizes)
    found = kinetics.solve(asked, rtol, nodes=nodes)
    return outcome(rtol, reference(found), found, invariants(found), 1e-13)


def scaled(law: CollisionLaw, rtol: float, nodes: int | None = None) -> Outcome:
    """h, a2 and F, relative to itself, against closed forms; norm, <c^2> = 1 and sign of F."""
    known = kinetics.ScalingSolution(**law.arguments)  # which shares nothing with the solver
    c = np.geomspace(0.05, 30.0, 400)  # et = 0: slow nearer to 0
    state, exact = kinetics.solve_scaled(law, rtol, nodes), known.vdf(c)
    seen = exact > 1e-95 * exact[c > 0.3].max()  # the solver ends at 1e-100
    F = np.where(seen, state.reached_vdf(c), 0.0)  # 0 where few nodes do not reach
    h, a2 = state.cooling_rate / known.cooling_rate, (1.0 + state.a2) / (1.0 + known.a2)
    reached = largest(h - 1.0, a2 - 1.0, F[seen] / exact[seen] - 1.0)
    claimed = max(rtol, 1e-12) if state.status.name == "CONVERGED" else math.inf
    kept = {f"<c^{p:g}> = 1": (abs(state.moment(p) - 1.0), claimed) for p in (0.0, 2.0)}
    kept["F not negative"] = excess(-F), 0.0
    return outcome(rtol, reached, state, kept)


def steady(law: CollisionLaw, rtol: float) -> Outcome:
    """The steady state in a field against two exact relations."""
    found = kinetics.solve_field(law, rtol=rtol)
    kept = {"<v_x>^2 <= <v_x^2>": (excess(found.drift**2 - found.mean_square_along), 0.0)}
    return outcome(rtol, largest(steady_errors(found)), found, kept)


def balances(state: Any) -> list[float]:
    """What a DrivenState misses in its exact relations, relative to their parts."""
    d, moment = state.dimension, state.moment
    share = 1.0 if math.isinf(state.mass_ratio) else state.mass_ratio / (1.0 + state.mass_ratio)
    k = share * (1.0 + state.restitution)  # 1 + e*
    w, noise, drag, g = state.bath_speed, state.heating, state.drag, state.field
    if w and not (noise or drag or g):  # a Maxwellian, and the Einstein relation
        square = w * w * k / (2.0 - k)
        einstein = state.mobility * square / state.diffusion_coefficient
        return [state.thermal_speed**2 / (d * square) - 1.0, state.a2, einstein - 1.0]
    if w:
        return []
    a, cosine = (2.0 - k) * k, 2 / 3 if d == 2 else 1 / 2  # <cos^2> of an impact
    gained = 2.0 * noise * d + (2.0 * g * moment(1.0, 1) if g else 0.0)
    missed = [gained / (2.0 * drag * moment(2.0) + a * cosine * moment(3.0)) - 1.0]
    if g:  # of the momentum
        missed.append((k * cosine * moment(2.0, 1) + drag * state.drift) / g - 1.0)
    return missed


def driven(rtol: float, **system: Any) -> Outcome:
    """The steady state of a driven tracer against its balances and a tighter solution."""
    found, finer = (kinetics.solve_steady(**system, rtol=x) for x in (rtol, 0.1 * rtol))
    names = ("thermal_speed", "collision_rate", "diffusion_coefficient", "mobility")
    missed = [getattr(found, n) / getattr(finer, n) - 1.0 for n in names]
    missed += [found.a2 - finer.a2, (found.drift - finer.drift) / finer.thermal_speed]
    kept = {"balances": (largest(balances(found), 0.0), 20.0 * max(rtol, found.error_estimate))}
    kept["a2 >= -2/(d + 2)"] = excess(-2.0 / (found.dimension + 2.0) - found.a2), 0.0
    return outcome(rtol + finer.error_estimate, largest(missed), found, kept)


def fly(law: CollisionLaw, medium: str) -> Outcome:
    """Tracers of speed 1 in a dense or a dilute medium."""
    kind, density = medium.split()
    size: Any = {"dimension": law.dimension} if kind == "BoltzmannGrad" else {"count": 2_000}
    run = particles.simulate(
        getattr(particles, kind)(float(density), **size), law.restitution or 0.0, "monoenergetic",
        [1.0, 100.0, 1e4], media=3, tracers=30, max_collisions=2_000, seed=5, workers=1,
        observables=("finals",), tangential_restitution=law.tangential_restitution or 0.0,
    )  # fmt: skip
    lost, done = -run.finals[:, 0], run.finals[:, 4]
    kept = of_particles(run)
    kept["finals are finite"] = float(np.sum(np.isnan(run.finals))), 0.0
    kept["no speed grows"] = excess(-lost), 1e-9
    kept["no tracer escapes"] = float(run.statuses.escaped), 0.0
    kept["collisions are counted"] = float(abs(done.sum() - run.collision_total)), 0.0
    if law.is_elastic:
        kept["speed is kept"] = largest(lost), 1e-9
    note = f"{run.collision_total} collisions, {run.statuses.trapped} trapped"
    return Outcome(invariants=kept, note=note)


# -- the table ------------------------------------------------------------------------------------
def all_cases(quick: bool) -> list[Case]:
    """Every choice of the values in each row of the table; of a quick sweep every fifth."""
    cases: list[Case] = []

    def row(group: str, work: Callable[..., Outcome], **axes: Iterable[Any]) -> None:
        for values in list(product(*axes.values()))[:: 5 if quick else 1]:
            some = dict(zip(axes, values, strict=True))
            name = ", ".join(f"{n} = {x[-1] if n == 'times' else x}" for n, x in some.items())
            cases.append(Case(group, name, partial(work, **some)))

    def laws(*restitutions: float, et: float = 1.0, d: int = 2) -> list[CollisionLaw]:
        return [CollisionLaw(e, et, d) for e in restitutions]

    near = 1.0 - 1e-10
    slow = laws(0.7, 1e-10, 1e-8, 1e-4, 0.01, 0.2, 0.3, 0.5, 0.0, 0.9, 0.99, 0.999, 1 - 1e-6, near)
    others = laws(0.0, 1e-10, 0.2, 0.7, 0.99, near, d=3) + laws(0.5, et=0.0) + laws(1e-7, et=1e-7)
    others += laws(0.7, 0.0, 1.0, et=0.8) + laws(0.7, 0.0, 1.0, et=0.8, d=3) + laws(0.5, et=0.5)
    # a third of the bounces keeps the speed
    bounces = [0.2, 0.3, 0.2, 0.3], [0.9, 0.5, 1.0, 1.0], [-1.0, 0.0, 0.5, 1.0]
    others += [CollisionLaw.from_samples(*bounces, dimension=d) for d in (2, 3)]
    lossy, elastic = [law for law in others if law.mean_log_loss > 1e-4], laws(1.0) + laws(1.0, d=3)
    cooling, four = slow + others, laws(0.7, 0.0, 0.2, 0.99)  # of four digits are kept

    row("scaled equation", scaled, law=cooling, rtol=(1e-4, 1e-12))
    row("scaled equation", partial(scaled, rtol=1e-12), law=four, nodes=(8, 16, 64, 256))

    both, v = references.STARTS, ("thermal_speed", "a2", "collisions")
    work = partial(scene, reference=digits, outputs=v)
    horizons = [references.times(horizon) for horizon in references.HORIZONS]
    row("cooling", work, law=four, start=both, times=horizons, rtol=(1e-3, 1e-6, 1e-12))
    times = np.array([0.0, 1e-300, 1e-3, 1.0, 1e3, 1e8, 1e30, 1e300])
    work = partial(scene, times=times, outputs=(*v, "temperature"), rtol=1e-9)
    row("cooling", work, law=slow, start=("speed 1e150", "gaussian of 1e-150"))
    row("cooling", work, law=slow, start=both, number_density=[1e150])
    row("cooling", work, law=slow, start=both, diameter=[1e-150])
    r = (*v, "msd", "velocity_autocorrelation", "diffusion_coefficient")
    row("averages", partial(work, outputs=r), law=slow, start=["tail v^-6"])  # <v^6> is infinite
    every = (*r, "kurtosis", "mean_displacement", "mean_velocity", "velocity_tensor")
    work = partial(work, outputs=every)
    rough = "beam along x", "step", "two peaks", "speeds 1e-100 and 1"
    row("averages", work, law=cooling, start=both)
    row("averages", work, law=slow, start=rough)
    # elastic tracers do not slow down: v t/l overflows later
    row("averages", partial(work, times=times[:-1]), law=elastic, start=both)

    work = partial(scene, start="gaussian", times=[0.5, 30.0, 1e3],
                   outputs=("thermal_speed", "speed_density"), rtol=1e-6)  # fmt: skip
    row("spectral density", work, law=slow, nodes=(512, 64, 8))
    row("spectral density", work, law=[*slow, *lossy, *elastic])
    own, begin = laws(0.7, 0.2, near, 1.0), ("gaussian", "beam along x")
    work = partial(scene, start="gaussian", outputs=("msd", "position_density"), rtol=1e-3)
    row("position density", work, law=own, times=([1e-300], [1e3], [1e150]))
    row("position density", work, law=others, times=([1e3],))
    work = partial(scene, outputs=("msd", "intermediate_scattering"), rtol=1e-6)
    row("scattering function", work, law=own, start=begin, times=([1.0], [1e-300], [1e3], [1e150]))
    row("scattering function", work, law=others, start=begin, times=([1.0],))

    row("steady state", steady, law=cooling, rtol=(1e-3, 1e-6))
    outputs = ("thermal_speed", "mean_velocity", "mean_displacement", "collisions")
    work = partial(scene, outputs=outputs, rtol=1e-3)
    for g in (1e12, 1.0, 1e-12):
        at = np.array([1e-3, 0.1, 1.0, 10.0]) * math.sqrt(12.5 / g)  # sqrt(l/g)
        row(
            "over time in a field", work, law=laws(0.7), start=("rest", *both), times=[at],
            field=[g],
        )  # fmt: skip

    many = {"restitution": (0.6, 0.0, 0.99), "mass_ratio": (3.0, math.inf, 0.3),
            "dimension": (2, 3), "rtol": (1e-4, 1e-8)}  # fmt: skip
    row("driven", driven, bath_speed=(0.5, 10.0), **many)
    row("driven", driven, heating=[0.1], drag=(0.1, 2.0), **many)
    row("driven", driven, field=[0.2], drag=(0.1, 2.0), **many)
    row("driven", driven, bath_speed=[1.0], heating=[0.3], drag=[0.3], field=[1.0], **many)

    # the last Poisson medium is that at which the plane falls apart: rho pi d^2 = 1.128
    plane = [f"Poisson {rho}" for rho in (0.01, 0.2, 0.35, 0.359)]
    plane += [f"HardDisks {rho}" for rho in (0.01, 0.2, 0.65)] + ["BoltzmannGrad 0.04"]
    space = ["HardSpheres 0.3", "PoissonSpheres 0.03", "BoltzmannGrad 0.04"]
    for d, media in ((2, plane), (3, space)):
        row("density", fly, law=laws(0.5, et=0.8, d=d) + laws(0.0, 1.0, d=d), medium=media)
    return cases


# -- run and report -------------------------------------------------------------------------------
@dataclass
class StressReport:
    """The cases of a sweep as they were run, how many were not; s, and s of processor time."""

    quick: bool
    not_run: int
    cases: list[dict[str, Any]] = field(default_factory=list)
    seconds: float = 0.0
    processor_seconds: float = 0.0

    @property
    def rejected(self) -> list[dict[str, Any]]:
        """Those that ended as they must not."""
        return [case for case in self.cases if case["verdict"] not in ACCEPTED]

    def to_json(self) -> str:
        """One strict JSON document; what is not finite is null."""
        return dumps({"format": FORMAT, "verdicts": VERDICTS, **vars(self)})

    def markdown(self) -> str:
        """A row for each group; then the cases that are not accepted."""
        text = (
            f"# Stability sweep{' (quick)' * self.quick}\n\n{len(self.cases)} cases in "
            f"{self.seconds:.0f} s, {self.processor_seconds:.0f} s of processor time; "
            f"{len(self.rejected)} did not end as they must, {self.not_run} were not run.\n\n"
        )
        if self.cases:
            frame = pd.DataFrame(self.cases)
            counts = pd.crosstab(frame["group"], frame["verdict"], margins=True, margins_name="all")
            counts = counts.reindex(columns=["all", *VERDICTS], fill_value=0)
            slowest = frame.groupby("group")["seconds"].max()
            counts["slowest [s]"] = slowest.reindex(counts.index, fill_value=slowest.max())
            text += markdown_table(counts.reset_index()) + "\n"
        text += "".join(f"- {verdict}: {meaning}\n" for verdict, meaning in VERDICTS.items())
        if self.rejected:
            text += f"\n## Rejected cases\n\n{markdown_table(pd.DataFrame(self.rejected))}"
        return text


def run_stress(
    quick: bool = False, groups: Collection[str] | None = None,
    progress: Callable[[str, int], None] = lambda group, total: None,
    interrupted: Callable[[StressReport], None] = lambda report: None,
) -> StressReport:  # fmt: skip
    """Run the sweep, or the named groups; progress(group, number of cases) before each case.

    interrupted(report of what has been run) is called after Ctrl-C or SIGTERM, which goes on.
    """
    chosen = all_cases(quick)
    names = dict.fromkeys(case.group for case in chosen)
    for group in set(groups or ()) - set(names):
        raise InputError(f"groups: got {group!r}; known are {', '.join(map(repr, names))}")
    chosen = [case for case in chosen if groups is None or case.group in groups]
    report = StressReport(quick, len(chosen))
    begin, processor = time.perf_counter(), time.process_time()
    try:
        for case in chosen:
            progress(case.group, len(chosen))
            report.cases.append(attempt(case))
            report.not_run -= 1
            report.seconds = time.perf_counter() - begin
            report.processor_seconds = time.process_time() - processor
    except (KeyboardInterrupt, SystemExit):
        interrupted(report)
        raise
    return report
