"""The stability sweep: solvers and particles at their limits, a verdict for each case.

One table of scenes (`all_cases`), one list of what every answer must keep (`invariants` of
solutions, `of_particles` of runs), and references: what is known apart from the solver (`limits`,
`mixture`, `kept`), or a `tighter` solution. `run_stress` runs the cases, `StressReport` shows them.
The tests with random arguments, in tests/fuzz, ask for the same invariants.

A law is a restitution, which stands for smooth disks, or a `CollisionLaw`.
"""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from functools import cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.crosscheck import references
from kinetics.crosscheck.files import dumps, markdown_table
from kinetics.errors import InputError, ToleranceWarning
from kinetics.numerics.gauss import panels_between

FloatArray = NDArray[np.float64]
Law = float | CollisionLaw
Violations = dict[str, tuple[float, float]]
"""Name of an invariant -> how far it is violated, and what is allowed; neither is negative."""

FORMAT = "inelastic-lorentz stress 2"
HOLDS, CAREFUL, SAYS_SO = "holds", "too careful", "says so"
MISSED, BROKEN, SLOW = "missed", "broken", "slow"
VERDICTS = {
    HOLDS: "a finite answer within the error asked for, and every invariant kept",
    CAREFUL: "the error asked for was reached, though the status says that it was not",
    SAYS_SO: "the status says that the error asked for was not reached; nothing shows that it was",
    MISSED: "the error asked for was not reached, and the status claims that it was",
    BROKEN: "not finite, an invariant violated, a warning, or an exception",
    SLOW: "the answer took longer than a stress case may",
}
LONGEST = 60.0  # s of processor time that one case may take

# -- a case and its verdict -----------------------------------------------------------------------


@dataclass(frozen=True)
class Outcome:
    """What a run gave."""

    asked: float = math.inf  # where no error was asked for
    reached: float = math.nan  # where there is no reference; infinite for no finite answer
    converged: bool = True  # as the status claims
    in_part: bool = False  # reached is of a part of the answer, and shows nothing of the rest
    known_to: float = 0.0  # the error of the reference itself
    invariants: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    note: str = ""


@dataclass(frozen=True)
class Case:
    """A case that has not been run."""

    group: str
    name: str
    work: Callable[[], Outcome]


@dataclass(frozen=True)
class StressCase:
    """One row; `invariant` is the worst one. `seconds` are of processor time."""

    group: str
    name: str
    verdict: str
    asked: float
    reached: float
    invariant: str
    violation: float
    allowed: float
    seconds: float
    note: str

    @property
    def accepted(self) -> bool:
        """Whether it ended as it must."""
        return self.verdict in (HOLDS, CAREFUL, SAYS_SO)


def judge(outcome: Outcome, seconds: float) -> str:
    """The verdict on a run that ended without an exception."""
    kept = all(violation <= allowed for violation, allowed in outcome.invariants.values())
    if math.isinf(outcome.reached) or not kept:
        return BROKEN
    if outcome.converged and outcome.reached > outcome.asked:
        return MISSED
    if seconds > LONGEST:
        return SLOW
    if outcome.converged:
        return HOLDS
    shown = outcome.reached + outcome.known_to <= outcome.asked < math.inf
    return CAREFUL if shown and not outcome.in_part else SAYS_SO


def attempt(case: Case, clock: Callable[[], float] = time.process_time) -> StressCase:
    """Run one case; nothing that it does stops the sweep, except an interruption."""
    begin, outcome = clock(), Outcome()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", ToleranceWarning)  # the status is looked at
            outcome = case.work()
        verdict, note = judge(outcome, clock() - begin), outcome.note
    except Exception as met:  # whatever it is, it is the finding
        verdict, note = BROKEN, f"{type(met).__name__}: {met}"

    def share(name: str) -> float:  # of what is allowed, used up
        violation, allowed = outcome.invariants[name]
        used = violation / allowed if allowed else math.inf if violation else 0.0
        return math.inf if math.isnan(used) else used

    worst = max(outcome.invariants, key=share, default="")
    return StressCase(
        case.group, case.name, verdict, outcome.asked, outcome.reached, worst,
        *outcome.invariants.get(worst, (0.0, 0.0)), clock() - begin, " ".join(note.split())[:240],
    )  # fmt: skip


# -- what every answer must keep ------------------------------------------------------------------


def below(values: Any, least: float = 0.0) -> float:
    """How far the smallest value is below the least that is allowed; 0 if it is not."""
    return max(0.0, least - float(np.min(values, initial=math.inf)))


def above(values: Any, most: float = 1.0) -> float:
    """How far the largest value is above the most that is allowed; 0 if it is not."""
    return max(0.0, float(np.max(values, initial=-math.inf)) - most)


def largest(*errors: Any) -> float:
    """The largest of these errors in size; infinite where one is not finite."""
    sizes = np.abs(np.concatenate([np.ravel(error) for error in errors]))
    return float(sizes.max()) if np.all(np.isfinite(sizes)) else math.inf


def invariants(found: Any) -> Violations:
    """What a `kinetics.Solution` must keep, of those outputs that it has, within its own error."""
    scene, values, times = found.scene, found.values, np.asarray(found.times)
    error = max(found.rtol, found.error_estimate)
    slack = 4.0 * error + 1e-12 if math.isfinite(error) else math.inf
    infinite = {name: float(np.sum(~np.isfinite(array))) for name, array in values.items()}
    kept: Violations = {f"{name} is finite": (n, 0.0) for name, n in infinite.items()}
    if any(infinite.values()):
        return kept

    def keep(
        name: str, needs: str, violation: Callable[..., float], allowed: float = slack
    ) -> None:
        if all(n in values for n in needs.split()):
            with np.errstate(all="ignore"):
                kept[name] = violation(*(values[n] for n in needs.split())), allowed

    def share(part: Any, whole: Any) -> Any:  # of what is no rounded number, after the start
        there = (np.abs(whole) > 1e-290) & (times > 1e-100)
        return part[there] / whole[there]

    def growth(x: Any, y: Any) -> float:
        return above(y - x * (1.0 + slack), 0.0)

    d, law, falls = scene.dimension, scene.law, not scene.field
    for name in ("thermal_speed", "temperature") if falls else ():
        keep(f"{name} does not grow", name, lambda v: growth(v[:-1], v[1:]), 0.0)
    for name in ("collisions", "msd") if falls else ():
        keep(f"{name} does not fall", name, lambda n: growth(n[1:], n[:-1]), 0.0)
        keep(f"{name} begins at 0", name, lambda n: above(n[times == 0.0], 0.0), 0.0)
    # there is no distribution beyond: <v^4> >= <v^2>^2, and <r^4> >= <r^2>^2
    keep("a2 >= -2/(d + 2)", "a2", lambda a2: below(a2, -2.0 / (d + 2.0)))
    keep("kurtosis >= 1", "kurtosis", lambda kurtosis: below(kurtosis, 1.0))
    keep("T = v0^2/d", "temperature thermal_speed",
         lambda T, v0: above(np.abs(share(d * T, v0**2) - 1.0), 0.0))  # fmt: skip
    if falls and times[0] == 0.0:
        keep("|<v(0).v>| <= <v^2>", "velocity_autocorrelation", lambda c: above(np.abs(c / c[0])))
        keep("<r^2> <= <v^2> t^2", "msd velocity_autocorrelation",
             lambda r2, c: above(share(r2, np.minimum(c[0] * times * times, 1e300))))  # fmt: skip
    # bounces that throw tracers back and nearly stop them make D negative
    if falls and (law.tangential_restitution == 1.0 or law.mean_cosine >= 0.0):
        keep("D not negative", "diffusion_coefficient", below, 0.0)
    keep("<v>^2 <= <v^2>", "mean_velocity thermal_speed",
         lambda v, v0: above(share(np.linalg.norm(v, axis=1), v0)))  # fmt: skip
    keep("<r>^2 <= <r^2>", "mean_displacement msd",
         lambda r, r2: above(share((r**2).sum(axis=1), r2)))  # fmt: skip
    keep("<v v> positive", "velocity_tensor", lambda tensor: below(share(
        np.linalg.eigvalsh(tensor)[:, 0], np.trace(tensor, axis1=1, axis2=2))))  # fmt: skip
    if falls:
        kept["<v^0> = 1"] = float(np.max(np.abs(found.moment(0.0) - 1.0))), slack
    if "speed_density" in scene.outputs and falls:
        x, shares = np.linspace(math.log(1e-8), math.log(1e3), 20_001), found.uncollided
        kept["uncollided"] = above(shares), 1e-12
        for i, v0 in enumerate(np.sqrt(found.moment(2.0))):
            if not 1e-140 < v0 < 1e140:
                continue
            f = np.exp(x) * v0 * found.speed_density(np.exp(x) * v0)[i]
            kept[f"density not negative, time {i}"] = below(f / max(f.max(), 1e-300)), 1.5 * error
            mass = abs(float(np.trapezoid(f, x)) + shares[i] - 1.0)
            rough = 0.0 if scene.initial == "gaussian" else 0.01
            kept[f"mass, time {i}"] = mass, 10.0 * error + rough
    if "position_density" in scene.outputs:
        R, weight = panels_between(np.concatenate([[0.0], np.geomspace(1e-2, 30.0, 60)]), 12)
        front = found.ballistic_front[1].sum(axis=1)
        for j in np.flatnonzero((times > 0.0) & (front == 0.0)):
            i = int(j)
            g = found.scaled_position_density(R)[i]
            for p, allowed in ((0, 10.0 * error), (2, 100.0 * error)):
                kept[f"<R^{p}> = 1, time {i}"] = abs(float(g @ (weight * R**p)) - 1.0), allowed
            kept[f"G not negative, time {i}"] = below(g), error
    if "intermediate_scattering" in scene.outputs:
        F = found.intermediate_scattering([0.0, 1e-300, 1e-3, 0.1, 2.0])
        kept["|F| <= 1"] = above(np.abs(F)), slack
        kept["F(0) = 1"] = float(np.max(np.abs(F[:, 0] - 1.0))), slack
    return kept


def of_particles(run: Any, first: Any = None) -> Violations:
    """What a `particles.Ensemble` must keep; first : speeds of its tracers, if finals are kept."""
    s = run.statuses
    total = run.media * run.tracers
    ended = s.finished + s.collision_cap + s.trapped + s.escaped
    kept = {"tracers are accounted for": (float(abs(ended - total)), 0.0)}
    for name in ("thermal_speed", "msd", "collisions") if run.times.size else ():
        value = getattr(run, name).value[run.samples > 0]
        kept[f"{name} is finite"] = float(np.sum(~np.isfinite(value))), 0.0
    if first is not None:
        kept["finals are finite"] = float(np.sum(np.isnan(run.finals))), 0.0
        kept["no speed grows"] = above(run.finals[:, 0] - np.log(first), 0.0), 1e-9
    return kept


# -- laws, starts, and what is known of them ------------------------------------------------------

RESTITUTIONS = (
    0.0, 1e-10, 1e-8, 1e-4, 0.01, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.99, 0.999,
    1.0 - 1e-6, 1.0 - 1e-10, 1.0,
)  # fmt: skip
FEWER = (0.0, 1e-10, 1e-4, 0.2, 0.7, 0.99, 1.0 - 1e-6, 1.0 - 1e-10, 1.0)
TIMES = np.array([0.0, 1e-300, 1e-3, 1.0, 1e3, 1e8, 1e30, 1e300])


def as_law(law: Law) -> CollisionLaw:
    """The collision law; a restitution is that of smooth disks."""
    return law if isinstance(law, CollisionLaw) else CollisionLaw(law)


def label_of(law: Law) -> str:
    """A law as the name of a case has it."""
    if not isinstance(law, CollisionLaw):
        return f"e = {law:g}" if law < 0.9995 or law == 1.0 else f"e = 1 - {1.0 - law:.0e}"
    kind = "disks" if law.dimension == 2 else "spheres"
    if law.restitution is None:
        return f"{kind}, {law.quadrature.weight.size} samples"
    rough = f", et = {law.tangential_restitution:g}"
    return f"{kind}, {label_of(law.restitution)}{rough * (law.tangential_restitution != 1.0)}"


@cache
def other_laws(quick: bool) -> tuple[CollisionLaw, ...]:
    """Laws that are not smooth disks: spheres, rough scatterers, samples, a mixture of two."""
    near = 1.0 - 1e-10
    laws = [(e, 1.0, 3) for e in (0.0, 0.7, near)] + [(0.5, 0.5, 3), (0.5, 0.0, 2)]
    laws += [(0.7, 0.8, 2), (0.7, 0.8, 3)]
    if not quick:
        laws += [(e, 1.0, 3) for e in (1e-10, 1e-4, 0.2, 0.99, 1.0 - 1e-6, 1.0)]
        laws += [(x, x, 2) for x in (1e-7, 1e-4, 0.01, 0.5, near)]  # all bounces lose as much
        laws += [(1.0, 0.0, 2), (0.5, 0.0, 3), (1e-10, 0.5, 3), (0.5, 1e-10, 2)]
        laws += [(0.0, 0.8, 2), (1.0, 0.8, 2), (0.7, near, 2), (0.0, 0.8, 3), (1.0, 0.8, 3)]
    # a third of the bounces keeps the speed
    bounces = [0.2, 0.3, 0.2, 0.3], [0.9, 0.5, 1.0, 1.0], [-1.0, 0.0, 0.5, 1.0]
    two = [CollisionLaw(e).quadrature for e in (0.9, 0.4)]
    weight, ratio, cosine = (
        np.concatenate([getattr(q, n) for q in two]) for n in ("weight", "ratio", "cosine")
    )
    samples = (CollisionLaw.from_samples(*bounces, dimension=d) for d in (2, 3))
    mixture = CollisionLaw.from_samples(0.5 * weight, ratio, cosine, 2)
    return (*(CollisionLaw(*law) for law in laws), *samples, mixture)


def forgets(law: CollisionLaw) -> bool:
    """Whether late averages forget the start, to 1e-20 of them.

    Where all bounces take the same share of the speed (et = e), averages go on oscillating in ln t
    by about exp(-pi^2/(2 kappa)).
    """
    return law.least_loss < law.largest_loss or law.mean_log_loss < 0.1


@cache
def scaling_state(law: Law) -> Any:
    """The closed form, which shares nothing with the solvers."""
    from kinetics import ScalingSolution

    return ScalingSolution(**as_law(law).arguments)


def tail(v: Any) -> Any:
    """A speed density that falls as v^-6."""
    with np.errstate(under="ignore"):
        return 5.0 * np.asarray(v) * np.hypot(1.0, v) ** -7.0


@cache
def starts() -> dict[str, tuple[Any, FloatArray, FloatArray]]:
    """Initial states by name, with speeds and weights that stand for them, none of the solver's."""
    from kinetics import Beam, Gaussian, SpeedSamples, SpeedTable

    def smooth(low: float, high: float, f: Callable[[FloatArray], Any]) -> tuple[Any, Any]:
        x, w = panels_between(np.linspace(low, high, math.ceil(2.0 * (high - low)) + 1), 16)
        return np.exp(x), w * np.exp(x) * f(np.exp(x))  # panels of width 1/2 in ln v

    def two_temperatures(v: FloatArray) -> Any:  # deviations 1 and 1e-3
        from scipy.special import i0e

        return v / 1e-3 * np.exp(-0.5 * v * v) * i0e(0.25 * (1e6 - 1.0) * v * v)

    one, half = (np.ones(1), np.ones(1)), np.array([0.5, 0.5])
    step = SpeedTable([1.0, 1.0 + 1e-9, 2.0, 2.0 + 1e-9], [0.0, 1.0, 1.0, 0.0])
    return {
        "monoenergetic": ("monoenergetic", *one),
        "gaussian": ("gaussian", *smooth(-18.0, 2.5, lambda v: v * np.exp(-0.5 * v * v))),
        "beam": (Beam(0.3), *one),
        "step": (step, *panels_between(np.linspace(1.0, 2.0, 5), 16)),
        "two delta peaks": (SpeedSamples([0.01, 1.0]), np.array([0.01, 1.0]), half),
        "speeds 1e-100 and 1": (SpeedSamples([1e-100, 1.0]), np.array([1e-100, 1.0]), half),
        "uniform from 0": (SpeedTable([0.0, 1.0], [1.0, 1.0]), *smooth(-36.0, 0.0, np.ones_like)),
        "tail v^-6": (tail, *smooth(-18.0, 36.0, tail)),
        "two temperatures": (Gaussian(1.0, 1e-3), *smooth(-25.0, 2.5, two_temperatures)),
    }


def solved(law: Law, start: Any, times: Any, outputs: Any, rtol: float, **more: Any) -> Any:
    """The Solution; start : a name in `starts`, or a state; more : of the scene and of `solve`."""
    import kinetics

    law = as_law(law)
    options = {name: more.pop(name) for name in ("method", "nodes") if name in more}
    state = starts()[start][0] if isinstance(start, str) and start in starts() else start
    if start == "beam" and law.dimension == 3:  # in space, along the axis of symmetry
        state = kinetics.Beam(0.0)
    scene = kinetics.Scene(law, initial=state, times=times, outputs=outputs, **more)
    return kinetics.solve(scene, rtol, **options)


def limits(found: Any, start: str) -> float:
    """Error of v0, a2 and the slope of <r^2> where they are their limits; NaN if nowhere.

    v0 changes by less than v t/l at first, and is that of the scaling state from a few
    l/(kappa v t) on; `start`: "gaussian" or "monoenergetic", times the speed of the scene's state.
    """
    scene, law, errors = found.scene, found.scene.law, []
    d, path = law.dimension, scene.mean_free_path
    exact = scaling_state(law) if not law.is_elastic and forgets(law) else None
    gaussian = start == "gaussian"
    speed = getattr(scene.state, "deviation_x", getattr(scene.state, "speed", 1.0))
    first = speed * (math.sqrt(d) if gaussian else 1.0)
    for i, t in enumerate(found.times):
        # ln(v t/l): v t may overflow
        x = math.log(first) + math.log(t) - math.log(path) if t else -math.inf
        if x < math.log(0.01 * found.rtol) or law.is_elastic:
            v0, a2 = first, 1.0 if gaussian else d / (d + 2.0)
        elif exact and x > math.log(1e3 / found.rtol) - math.log(law.mean_log_loss):
            v0, a2 = 2.0 * (path / float(t)) / exact.cooling_rate, 1.0 + exact.a2
        else:
            continue
        if v0 > 1e-290:  # else at the end of the doubles
            errors += [abs(found.thermal_speed[i] / v0 - 1.0), abs((1.0 + found.a2[i]) / a2 - 1.0)]
    if "diffusion_coefficient" in found.values and exact:
        errors.append(abs(found.msd_slope[-1] / path**2 / exact.diffusion_slope - 1.0))
    return max(errors, default=math.nan)


def tighter(found: Any, start: Any) -> float:
    """Difference to the same scene solved for a hundredth of the error; NaN if it is not known."""
    finer = again(found, 0.01 * found.rtol)
    return apart(found, finer) if finer.error_estimate <= 0.3 * found.rtol else math.nan


def again(found: Any, rtol: float) -> Any:
    """The scene of a Solution once more, to another rtol, with the thermal speed."""
    from dataclasses import replace

    import kinetics

    outputs = dict.fromkeys(("thermal_speed", *found.scene.outputs))
    return kinetics.solve(replace(found.scene, outputs=tuple(outputs)), rtol)


def apart(found: Any, finer: Any) -> float:
    """The largest error of a Solution, a finer one of the same scene taken as exact.

    Averages relative to their size (a2 to 1 + a2, vectors to their lengths), densities relative to
    their maximum, those of the speed below 1e-2 of the thermal speed as densities of ln v.
    """
    v0, errors = finer.thermal_speed, []
    with np.errstate(all="ignore"):
        for name, values in found.values.items():
            exact = finer.values[name]
            size = np.abs(exact)
            if name in ("mean_velocity", "velocity_tensor", "velocity_autocorrelation"):
                power = 1 if name == "mean_velocity" else 2
                size = v0**power if name != "velocity_autocorrelation" else v0[0] * v0
                size = size.reshape(-1, *(1,) * (exact.ndim - 1))
            elif exact.ndim > 1:
                size = np.linalg.norm(exact, axis=1, keepdims=True)
            change = np.abs(values - exact) / (1.0 + exact if name == "a2" else size)
            errors.append(np.where(np.abs(values - exact) < 1e-300, 0.0, change))
    c, R = np.concatenate([[0.0], np.geomspace(1e-8, 30.0, 4000)]), np.linspace(0.0, 8.0, 400)
    for i, unit in enumerate(v0):
        if "speed_density" in found.scene.outputs:
            f, exact = (one.speed_density(unit * c)[i] for one in (found, finer))
            errors.append((f - exact) * np.minimum(1.0, c / 1e-2) / exact.max())
        if "position_density" in found.scene.outputs and found.times[i] > 0.0:
            f, exact = (one.scaled_position_density(R)[i] for one in (found, finer))
            errors.append(f - exact)
    return largest(*errors, 0.0)


def kept(found: Any, start: str) -> float:
    """Error against the kept references."""
    horizon = "long" if found.times[-1] > 1e3 else "short"
    e = found.scene.restitution
    names = ("thermal_speed", "a2")
    return _difference(found, *(references.kept(name, e, start, horizon) for name in names))


def mixture(found: Any, start: str) -> float:
    """Error of v0 and a2 against the mean over the speeds of the start, each at scaled times.

    The equation is linear, and speeds times s are times divided by s.
    """
    _, v, w = starts()[start]
    # fourth powers of late speeds of 1e-30 and less underflow
    middle = (found.times > 0.0) & (found.times <= 1e30)
    gaussian, paths = 1.0 + 2.0 / found.scene.dimension, np.outer(found.times[middle], v)
    known, where = np.unique(paths, return_inverse=True)
    one = solved(found.scene.law, "monoenergetic", known, ("thermal_speed", "a2"), 1e-13)
    with np.errstate(under="ignore"):
        square = (one.thermal_speed**2)[where].reshape(paths.shape)
        fourth = gaussian * square**2 * (1.0 + one.a2[where].reshape(paths.shape))
        second, fourth = square @ (w * v**2), fourth @ (w * v**4)
    return _difference(found, np.sqrt(second), fourth / gaussian / second**2 - 1.0, middle)


def _difference(found: Any, v0: FloatArray, a2: FloatArray, at: Any = slice(None)) -> float:
    with np.errstate(all="ignore"):
        return largest(found.thermal_speed[at] / v0 - 1.0, (1.0 + found.a2[at]) / (1.0 + a2) - 1.0)


# -- work of the cases: solvers -------------------------------------------------------------------


def _scene(
    reference: Callable[[Any, Any], float], law: Law, start: Any, times: Any, outputs: Any,
    rtol: float, **more: Any,
) -> Outcome:  # fmt: skip
    """A scene against a reference; scale : times the speeds of the start."""
    from kinetics import Gaussian, Monoenergetic

    state, scale = start, more.pop("scale", 1.0)
    if scale != 1.0:
        state = Gaussian(scale, scale) if start == "gaussian" else Monoenergetic(scale)
    try:
        found = solved(law, state, times, outputs, rtol, **more)
        reached = reference(found, start)
    except InputError as refused:
        if not more.get("field"):
            raise
        # fast starts in a field of which next to nothing is left
        return Outcome(rtol, converged=False, note=str(refused))
    done = found.status.name == "CONVERGED"
    # references in doubles, and averages over a start, may add 1e-13
    return Outcome(
        rtol + 1e-13, reached, done, in_part=reference is limits, invariants=invariants(found),
        note=f"estimate {found.error_estimate:.0e}",
    )  # fmt: skip


def _scaled(law: Law, rtol: float, nodes: int | None = None) -> Outcome:
    """h, a2 and F, relative to itself, against closed forms; norm, <c^2> = 1 and sign of F."""
    from kinetics import solve_scaled

    c, known = np.geomspace(0.05, 30.0, 400), scaling_state(law)  # et = 0: slow nearer to 0
    state = solve_scaled(as_law(law), rtol, nodes)
    exact = known.vdf(c)
    seen = exact > 1e-95 * exact[c > 0.3].max()  # the solver ends at 1e-100
    F = np.where(seen, state.reached_vdf(c), 0.0)  # 0 where few nodes do not reach
    h, a2 = state.cooling_rate / known.cooling_rate, (1.0 + state.a2) / (1.0 + known.a2)
    reached = largest(h - 1.0, a2 - 1.0, F[seen] / exact[seen] - 1.0)
    done = state.status.name == "CONVERGED"
    claimed = max(rtol, 1e-12) if done else math.inf
    kept = {f"<c^{p:g}> = 1": (abs(state.moment(p) - 1.0), claimed) for p in (0.0, 2.0)}
    kept["F not negative"] = below(F), 0.0
    # ScalingSolution.vdf promises 1e-12
    return Outcome(rtol, reached, done, known_to=1e-12, invariants=kept,
                   note=f"estimate {state.error_estimate:.1e}")  # fmt: skip


def _conservative(law: Law, start: str, nodes: int) -> Outcome:
    """The conservative scheme: sign of the density, its mass, and its distribution function, whose
    error is stated, against twice as many nodes.

    At 1e-13 the scheme serves all times itself. Its density is linear in ln v between nodes: the
    integrals are by the trapezoid rule with many points for each node.
    """
    found, finer = (
        solved(law, start, [0.5, 30.0, 1e3], ("speed_density", "thermal_speed"), 1e-13,
               method="conservative", nodes=n)
        for n in (nodes, 2 * nodes)
    )  # fmt: skip
    v0, estimate = found.thermal_speed, found.error_estimate
    v = np.geomspace(1e-8 * v0[-1], 1e6 * v0[0], max(200_001, 400 * nodes + 1))
    f = found.speed_density(v)
    slower, known = (
        np.cumsum(one * v * math.log(v[1] / v[0]), axis=1) for one in (f, finer.speed_density(v))
    )
    mass = slower[:, -1] + found.uncollided
    claims = float(found.status.name == "CONVERGED")  # no number of nodes reaches 1e-13
    kept = {"density not negative": (below(f), 0.0), "status says so": (claims, 0.0)}
    # the interpolation between nodes adds to the scheme's own error
    asked = max(1.5 * estimate, 1e-5)
    return Outcome(asked, largest(slower - known, mass - 1.0), invariants=kept,
                   note=f"estimate {estimate:.0e}")  # fmt: skip


def _scattering(law: Law, start: str, t: float) -> Outcome:
    """F(k, t) for small k, F = 1 - k^2 <r^2>/(2 d), and in free flight."""
    from scipy.special import j0

    law = as_law(law)
    found = solved(law, start, [t], ("intermediate_scattering", "msd"), 1e-9)
    width = math.sqrt(found.msd[0])
    small = 1e-4 / max(1.0, width)  # the next term is of order (k^2 <r^2>)^2
    k = np.array([small, 1e-3, 0.1, 2.0])
    F, along = (found.intermediate_scattering(k, direction=at)[0] for at in (None, 0.3))
    errors = [F[0] - 1.0 + (small * width) ** 2 / (2.0 * law.dimension)]
    if t <= 1e-12 / found.scene.mean_free_path:
        wave = j0(k * t) if law.dimension == 2 else np.sinc(k * t / math.pi)
        free = np.exp(-0.5 * (k * t) ** 2) if start == "gaussian" else wave
        errors.append(F - free)
    # nothing is known of k l of order 1
    reached = largest(*errors, 0.0 * F, 0.0 * along)  # all of it is finite
    return Outcome(1e-8, reached, found.status.name == "CONVERGED", in_part=True,
                   invariants=invariants(found))  # fmt: skip


def _steady(law: Law, rtol: float) -> Outcome:
    """The steady state against <v^2 cos> = 1/lambda_1(1) and 2 <v_x> = lambda(2) <v^3>, exact."""
    from kinetics import solve_field

    found = solve_field(law, rtol=rtol)
    return Outcome(rtol + 1e-12, largest(steady_errors(found)), found.status.name == "CONVERGED",
                   invariants={"<v_x>^2 <= <v_x^2>": (
                       above(found.drift / math.sqrt(found.mean_square_along)), 0.0)})  # fmt: skip


def steady_errors(found: Any) -> tuple[float, float]:
    """Errors of a FieldState in two exact relations; infinite where a number is not finite."""
    fixed = found.moment(2.0, 1) * float(found.law.harmonic_decay_rate(1.0, 1)) - 1.0
    energy = float(found.law.decay_rate(2.0)) * found.moment(3.0) / (2.0 * found.drift) - 1.0
    finite = math.isfinite(fixed + energy + found.mean_square_speed + found.mean_speed)
    return (abs(fixed), abs(energy)) if finite else (math.inf, math.inf)


# -- work of the cases: particles -----------------------------------------------------------------


def _run(medium: Any, e: float, **options: Any) -> Any:
    """A run of one thread with final states, of tracers of speed 1 where nothing else is said."""
    from particles import simulate

    usual: dict[str, Any] = {"initial": "monoenergetic", "media": 1, "workers": 1}
    usual["observables"] = ("finals",)
    return simulate(medium, e, **(usual | options))


def _medium(kind: str, density: float) -> Any:
    import particles

    if kind.startswith("BoltzmannGrad"):
        return particles.BoltzmannGrad(density, dimension=3 if "space" in kind else 2)
    return getattr(particles, kind)(density, count=2_000)


def _of_run(run: Any, more: Violations, first: Any = 1.0) -> Outcome:
    note = f"{run.collision_total} collisions, {run.statuses.trapped} trapped"
    return Outcome(invariants=of_particles(run, first) | more, note=note)


def _dense(kind: str, density: float, e: float, et: float) -> Outcome:
    """Many tracers; one and two threads give the same bits."""
    one, two = (
        _run(_medium(kind, density), e, times=[1.0, 100.0, 1e4], media=3, tracers=30, seed=5,
             max_collisions=2_000, workers=workers, tangential_restitution=et)
        for workers in (1, 2)
    )  # fmt: skip
    same = np.array_equal(one.finals, two.finals)
    more = {"no tracer escapes": (float(one.statuses.escaped), 0.0)}
    return _of_run(one, more | {"threads do not matter": (float(not same), 0.0)})


def _many(kind: str, law: CollisionLaw, collisions: int) -> Outcome:
    """Speeds as the losses of so many collisions make them."""
    run = _run(_medium(kind, 0.04), law.restitution or 0.0, max_collisions=collisions, media=2,
               tracers=2, seed=9, tangential_restitution=law.tangential_restitution)  # fmt: skip
    logarithm, done = run.finals[:, 0], run.finals[:, 4]
    more = {"collisions are counted": (float(abs(done.sum() - run.collision_total)), 0.0)}
    if law.is_elastic:
        more["speed is kept"] = (float(np.max(np.abs(logarithm))), 1e-9)
    elif kind.startswith("BoltzmannGrad"):
        # 6 standard errors of the mean of -ln s over independent collisions, whose deviation is
        # below the largest loss, or of the order of kappa if that is infinite
        kappa = law.mean_log_loss
        spread = law.largest_loss if math.isfinite(law.largest_loss) else 2.0 * kappa
        apart = float(np.max(np.abs(-logarithm / done - kappa)))
        more["mean loss is kappa"] = (apart, 6.0 * spread / math.sqrt(float(done.min())))
    return _of_run(run, more)


def _grazing(e: float, gap: float) -> Outcome:
    """A tracer flies past one disk, its centre 1 + gap from the path: it hits if gap < 0."""
    from particles import Positions

    medium = Positions(np.array([[15.0, 11.0 + gap]]), box_side=20.0, start=(10.0, 10.0))
    run = _run(medium, e, initial=np.array([[1.0, 0.0]]), times=[4.0, 8.0, 1e3], tracers=1,
               max_collisions=10_000)  # fmt: skip
    collisions, clear = float(run.collisions.value[1]), abs(gap) > 1.5e-13  # else rounding decides
    more = {"not twice": (above(collisions), 0.0)}
    if clear:
        more["it hits if it must"] = abs(collisions - float(gap < 0.0)), 0.0
    if gap < 0.0 and clear:  # impact parameter 1 + gap: s^2 = e^2 + (1 - e^2) y^2
        s = math.sqrt(e * e + (1.0 - e * e) * (1.0 + gap) ** 2)
        more["speed after it"] = (abs(float(run.thermal_speed.value[1]) - s), 1e-12)
    return _of_run(run, more)


def _corner(e: float, gap: float) -> Outcome:
    """Tracers fly along the middle, and beside it, into the corner of two circles that cross."""
    from particles import Positions

    half = 1.0 - 0.5 * gap
    disks = np.array([[15.0, 10.0 + half], [15.0, 10.0 - half]])
    velocity = np.array([[1.0, 0.0], [1.0, 1e-9], [1.0, 0.01]])
    run = _run(Positions(disks, box_side=20.0, start=(10.0, 10.0)), e, initial=velocity, tracers=3,
               times=[1.0, 100.0, 1e5], max_collisions=100_000)  # fmt: skip
    first = np.hypot(*velocity.T)
    kept = float(np.max(np.abs(run.finals[:, 0] - np.log(first))))
    more = {"speed is kept": (kept, 1e-9), "none is trapped": (float(run.statuses.trapped), 0.0)}
    return _of_run(run, more if e == 1.0 else {}, first)


# -- the table of scenes --------------------------------------------------------------------------


def all_cases(quick: bool) -> list[Case]:
    """Every case of a sweep, not run."""
    cases = []
    for group, name, work, *arguments in (*_of_solvers(quick), *_of_particles(quick)):
        more = arguments.pop() if isinstance(arguments[-1], dict) else {}
        cases.append(Case(group, name, partial(work, *arguments, **more)))
    return cases


def _of_solvers(quick: bool) -> Iterator[Any]:
    law: Any
    n: Any
    times: Any
    more: Any
    others = other_laws(quick)
    plain: list[Law] = list(FEWER if quick else RESTITUTIONS)
    laws: list[Law] = [*plain, *others]
    cooling = [law for law in laws if not as_law(law).is_elastic]
    v, both = ("thermal_speed", "a2"), references.STARTS
    for law in cooling:
        for rtol in (1e-4, 1e-12) if quick else (1e-1, 1e-3, 1e-6, 1e-9, 1e-12):
            yield "scaled equation", f"{label_of(law)}, rtol {rtol:.0e}", _scaled, law, rtol
    for e in (0.0, 0.2, 0.7, 0.99):
        for n in (8, 16, 64, 256) if quick else (8, 12, 16, 32, 64, 256, 1024, 4096):
            name = f"{label_of(e)}, {n} nodes"
            yield "scaled equation, nodes given", name, _scaled, e, 1e-12, n
        for start, horizon in ((s, h) for s in both for h in references.HORIZONS):
            for rtol in (1e-3, 1e-6, 1e-12):
                name = f"{label_of(e)}, {start}, kept references, {horizon}, rtol {rtol:.0e}"
                yield "cooling", name, _scene, kept, e, start, references.times(horizon), v, rtol
    for law in laws:
        for start in both:
            for what, x in (("scale", 1e-150), ("scale", 1.0), ("scale", 1e150),
                            ("number_density", 1e150), ("diameter", 1e-150)):  # fmt: skip
                # refused: elastic tracers do not slow down, v t/l overflows
                if x == 1.0 or (law in plain and law != 1.0):
                    # else, and if elastic, <r^2> leaves the doubles
                    more = ("msd",) if x == 1.0 and law in cooling else ()
                    outputs = (*v, "temperature", "collisions", *more)
                    name = f"{label_of(law)}, {start}, {what} {x:g}, t to 1e300"
                    scene = (law, start, TIMES, outputs, 1e-9, {what: x})
                    yield "cooling", name, _scene, limits, *scene
    for law in (0.0, 0.2, 1.0 - 1e-6, *others) if quick else laws:
        for start in starts() if law in plain else ("two delta peaks",):
            yield "starts", f"{label_of(law)}, {start}", _scene, mixture, law, start, TIMES, v, 1e-8
    few = (0.0, 0.7, 0.99) if quick else (0.0, 1e-10, 1e-4, 0.2, 0.5, 0.7, 0.9, 0.99, 0.999)
    f = ("thermal_speed", "speed_density")
    for law in (*few, 1.0, *(law for law in others if law.mean_log_loss > 1e-4)):
        # where bounces multiply the speed by single values, a sharp start is refused
        single = as_law(law).least_loss == as_law(law).largest_loss > 0.0
        sharp = as_law(law).restitution is not None and not single
        for n in (8, 64, 512, None) if law in few else (None,) if law in others else ():
            name, more = f"{label_of(law)}, gaussian, {n or 'its own'} nodes", {"nodes": n}
            times = [0.5, 30.0, 1e3]
            yield "spectral density", name, _scene, tighter, law, "gaussian", times, f, 1e-6, more
        for n in (8, 64, 512) if law in few else (512,) if law in others else ():
            for start in ("gaussian", "monoenergetic", "step", "two delta peaks", "tail v^-6"):
                if sharp or start in ("gaussian", "step"):
                    name = f"{label_of(law)}, {start}, {n} nodes"
                    yield "conservative density", name, _conservative, law, start, n
    r = ("msd", "velocity_autocorrelation", "diffusion_coefficient")
    fourth = ("kurtosis", "mean_displacement", "mean_velocity", "velocity_tensor")
    for law in laws:
        times = TIMES if law in cooling else TIMES[:-1]
        for start in both if quick or law not in plain else starts():
            for rtol in (1e-9,) if quick else (1e-3, 1e-9):
                outputs = (*v, *r) if start == "tail v^-6" else (*v, *r, *fourth)
                name = f"{label_of(law)}, {start}, t to 1e300, rtol {rtol:.0e}"
                yield "moments of position", name, _scene, tighter, law, start, times, outputs, rtol
    for law in (0.2, 0.7, 1.0 - 1e-10, 1.0, *others):
        own, position = law in plain, ("msd", "position_density")
        for t in (1e-300, 1e3, 1e150) if own else (1e3,) if quick else (1e-300, 1e3, 1e8):
            name = f"{label_of(law)}, gaussian, t = {t:g}"
            yield "position density", name, _scene, tighter, law, "gaussian", [t], position, 1e-3
        for start in ("gaussian", "beam"):
            for t in (0.0, 1e-300, 1.0, 1e3, 1e150) if own else (1.0,) if quick else (1.0, 1e3):
                name = f"{label_of(law)}, {start}, t = {t:g}"
                yield "scattering function", name, _scattering, law, start, t
    for law in (0.0, 1.0 - 1e-10) if quick else cooling:
        for rtol in (1e-6,) if quick else (1e-3, 1e-6, 1e-10):
            yield "steady state", f"{label_of(law)}, rtol {rtol:.0e}", _steady, law, rtol
    outputs = ("mean_velocity", "thermal_speed", "mean_displacement", "collisions")
    for e in (0.7,) if quick else (0.0, 1e-10, 0.7, 1.0 - 1e-10, 1.0):
        for start in ("rest",) if quick else ("rest", "gaussian", "beam"):
            for g in (1e12,) if quick else (1e-12, 1.0, 1e12):
                times = np.array([1e-3, 0.1, 1.0, 10.0]) * math.sqrt(12.5 / g)  # sqrt(l/g)
                scene = (e, start, times, outputs, 1e-3, {"field": g})
                name = f"{label_of(e)}, {start}, field {g:g}"
                yield "over time in a field", name, _scene, tighter, *scene


def _of_particles(quick: bool) -> Iterator[Any]:
    # the last is that at which the plane falls apart: rho pi d^2 = 1.128
    media = [("Poisson", rho) for rho in (0.01, 0.2, 0.35, 0.359)]
    media += [("HardDisks", rho) for rho in (0.01, 0.2, 0.65)] + [("BoltzmannGrad", 0.04)]
    media += [("HardSpheres", 0.3), ("PoissonSpheres", 0.03), ("BoltzmannGrad in space", 0.04)]
    for e, et in ((0.0, 1.0), (0.5, 0.8), (1.0, 1.0)) if quick else (
        (0.0, 1.0), (0.2, 1.0), (0.5, 1.0), (0.5, 0.8), (0.5, 0.0), (1.0, 1.0), (1.0, 0.8)
    ):  # fmt: skip
        for kind, rho in media:
            name = f"e = {e:g}, et = {et:g}, {kind}, {rho:.3g}"
            yield "density", name, _dense, kind, rho, e, et
    many = 100_000 if quick else 1_000_000
    for law in (CollisionLaw(*arguments) for arguments in (
        (0.9, 1.0, 2), (1.0 - 1e-10, 1.0, 2), (1.0, 1.0, 2), (0.9, 0.8, 2), (1.0, 0.8, 2),
        (0.9, 1.0, 3), (0.9, 0.8, 3), (0.5, 0.0, 3), (1.0, 1.0, 3),
    )):  # fmt: skip
        smooth_disks = law.dimension == 2 and law.tangential_restitution == 1.0
        free = "BoltzmannGrad" + (" in space" if law.dimension == 3 else "")
        for kind in ("HardDisks", free) if smooth_disks else (free,):
            name = f"{label_of(law)}, {kind}, {many:.0e} collisions of each of 4 tracers"
            yield "many collisions", name, _many, kind, law, many
    for e in (0.0, 1e-10, 0.5, 1.0 - 1e-10, 1.0):
        for gap in (-1e-3, -1e-8, -1e-12, -1e-15, 0.0, 1e-15, 1e-12, 1e-8, 1e-3):
            name = f"{label_of(e)}, passing the circle at {gap:+.0e} d"
            yield "grazing", name, _grazing, e, gap
        for gap in (0.0, 1e-15, 1e-9, 1e-3, 0.3):
            name = f"{label_of(e)}, into a corner, circles {gap:.0e} d inside one another"
            yield "corners", name, _corner, e, gap


# -- run and report -------------------------------------------------------------------------------


def run_stress(
    quick: bool = False, groups: Iterable[str] | None = None,
    progress: Callable[[str, int], None] = lambda group, total: None,
    interrupted: Callable[[StressReport], None] = lambda report: None,
) -> StressReport:  # fmt: skip
    """Run the sweep, or the named groups of it.

    progress(name of the group, number of cases in all) is called before each case. After Ctrl-C or
    SIGTERM interrupted(report of the cases that have been run) is called, and the exception goes
    on. Raises InputError for a group that does not exist.
    """
    chosen = all_cases(quick)
    if groups is not None:
        wanted, known = set(groups), dict.fromkeys(case.group for case in chosen)
        for group in sorted(wanted - set(known)):
            raise InputError(f"groups: got {group!r}; known are {', '.join(map(repr, known))}")
        chosen = [case for case in chosen if case.group in wanted]
    begin, processor = time.perf_counter(), time.process_time()
    found: list[StressCase] = []

    def report() -> StressReport:
        seconds, of_processor = time.perf_counter() - begin, time.process_time() - processor
        return StressReport(tuple(found), quick, seconds, of_processor, len(chosen) - len(found))

    try:
        for case in chosen:
            progress(case.group, len(chosen))
            found.append(attempt(case))
    except (KeyboardInterrupt, SystemExit):
        interrupted(report())
        raise
    return report()


@dataclass(frozen=True)
class StressReport:
    """All cases of a sweep, in the order in which they were run.

    not_run : how many more an interruption left out
    """

    cases: tuple[StressCase, ...]
    quick: bool
    seconds: float
    processor_seconds: float
    not_run: int = 0

    @property
    def rejected(self) -> tuple[StressCase, ...]:
        """Those that ended as they must not."""
        return tuple(c for c in self.cases if not c.accepted)

    def to_json(self) -> str:
        """One strict JSON document; what is not finite is null."""
        return dumps({"format": FORMAT, "verdicts": VERDICTS, **asdict(self)})

    def files(self) -> dict[str, str]:
        """What ``lorentz stress -o`` writes, by name."""
        return {"stress.json": self.to_json(), "stress.md": self.markdown(every_case=True)}

    def markdown(self, every_case: bool = False) -> str:
        """A row for each group; then the cases that are not accepted, or every case."""
        more = f" Interrupted: {self.not_run} more were not run." if self.not_run else ""
        lines = [
            f"# Stability sweep{' (quick)' * self.quick}", "",
            f"{len(self.cases)} cases in {self.seconds:.0f} s, {self.processor_seconds:.0f} s of "
            f"processor time; {len(self.rejected)} did not end as they must.{more}", "",
        ]  # fmt: skip
        rows = []
        for group in (*dict.fromkeys(c.group for c in self.cases), "all"):
            cases = [c for c in self.cases if group in (c.group, "all")]
            counts = {v: str(sum(c.verdict == v for c in cases) or "") for v in VERDICTS}
            slow = max(cases, key=lambda c: c.seconds, default=None)
            slowest = f"{slow.seconds:.2f} s: {slow.name}" if slow else ""
            rows.append({"group": group, "cases": str(len(cases)), **counts, "slowest": slowest})
        lines += [*markdown_table(rows), *(f"- {v}: {text}" for v, text in VERDICTS.items()), ""]
        for title, shown in (
            ("Cases that did not end as they must", self.rejected),
            ("Every case", self.cases if every_case else ()),
        ):
            if shown:
                cells = [
                    {n: x if isinstance(x, str) else "" if math.isnan(x) else f"{x:.1e}"
                     for n, x in ({"verdict": ""} | vars(case)).items() if n != "seconds"}
                    for case in shown
                ]  # fmt: skip
                lines += [f"## {title}", "", *markdown_table(cells)]
        return "\n".join(lines) + "\n"
