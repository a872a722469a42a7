"""The stability sweep: solvers and particles at their limits, a verdict for each case.

One table of scenes (`all_cases`), one list of what every answer must keep (`invariants` of solutions,
`of_particles` of runs), and references that are known apart from the solver (`limits`, `mixture`,
kept values) or are a tighter solution. `run_stress` runs the cases and `StressReport` shows them.
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
from kinetics.errors import InputError
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
    """What a run gave.

    asked : the error asked for; infinite where none was
    reached : against a reference; NaN where there is none, infinite where the answer is not finite
    converged : whether the status claims what was asked for
    in_part : whether ``reached`` is of a part of the answer: it may show that a claim is wrong, not
        that an answer without one is right
    known_to : the error of the reference itself
    """

    asked: float = math.inf
    reached: float = math.nan
    converged: bool = True
    in_part: bool = False
    known_to: float = 0.0
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
            outcome = case.work()
        verdict, note = judge(outcome, clock() - begin), outcome.note
    except Exception as met:  # whatever it is, it is the finding
        verdict, note = BROKEN, f"{type(met).__name__}: {met}"
    worst = max(outcome.invariants, key=lambda n: _share(*outcome.invariants[n]), default="")
    return StressCase(
        case.group, case.name, verdict, outcome.asked, outcome.reached, worst,
        *outcome.invariants.get(worst, (0.0, 0.0)), clock() - begin, " ".join(note.split())[:240],
    )  # fmt: skip


def _share(violation: float, allowed: float) -> float:
    """How much of what is allowed is used up; infinite where nothing is."""
    if math.isnan(violation):
        return math.inf
    return violation / allowed if allowed else (math.inf if violation else 0.0)


# -- what every answer must keep ------------------------------------------------------------------


def below(values: Any, least: float = 0.0) -> float:
    """How far the smallest value is below the least that is allowed; 0 if it is not."""
    return max(0.0, least - float(np.min(values, initial=math.inf)))


def above(values: Any, most: float = 1.0) -> float:
    """How far the largest value is above the most that is allowed; 0 if it is not."""
    return max(0.0, float(np.max(values, initial=-math.inf)) - most)


def invariants(found: Any) -> Violations:
    """What a `kinetics.Solution` must keep, of those outputs that it has, within its own error."""
    scene, values, times = found.scene, found.values, np.asarray(found.times)
    estimate = found.error_estimate if math.isfinite(found.error_estimate) else math.inf
    slack = 4.0 * max(found.rtol, estimate) + 1e-12
    d, g, later = scene.dimension, scene.field, times > 1e-100
    wrong = [name for name, array in values.items() if not np.all(np.isfinite(array))]
    kept: Violations = {"finite": (float(len(wrong)), 0.0)}
    if wrong:
        return kept
    # squares of speeds below 1e-150 are rounded numbers
    speed = values.get("thermal_speed", np.zeros(times.size))
    seen = speed > 1e-145
    with np.errstate(all="ignore"):
        for name in ("thermal_speed", "temperature") if not g else ():
            if name in values:
                grown = np.nan_to_num(values[name][1:] / values[name][:-1], nan=1.0) - 1.0
                kept[f"{name} does not grow"] = above(grown, 0.0), slack
        for name in ("collisions", "msd"):
            if name in values:
                fall = -np.diff(values[name]) / np.maximum(values[name][1:], 1e-300)
                kept[f"{name} does not fall"] = above(fall, 0.0), slack
                kept[f"{name} begins at 0"] = above(values[name][times == 0.0], 0.0), 0.0
        if "a2" in values:  # there is no distribution below: <v^4> >= <v^2>^2
            kept["a2 >= -2/(d + 2)"] = below(values["a2"], -2.0 / (d + 2.0)), slack
        if "temperature" in values and seen.any():
            off = d * values["temperature"][seen] / speed[seen] ** 2 - 1.0
            kept["T = v0^2/d"] = above(np.abs(off), 0.0), slack
        if "velocity_autocorrelation" in values and not g and times[0] == 0.0:
            start = float(values["velocity_autocorrelation"][0])  # <v(0)^2>
            correlation = np.abs(values["velocity_autocorrelation"]) / start
            kept["|<v(0).v>| <= <v^2>"] = above(correlation), slack
            if "msd" in values:
                ballistic = np.nan_to_num(values["msd"] / (start * times * times), posinf=0.0)
                kept["<r^2> <= <v^2> t^2"] = above(ballistic[later]), slack
        # bounces that throw tracers back and nearly stop them make D negative
        ahead = scene.law.tangential_restitution == 1.0 or scene.law.mean_cosine >= 0.0
        if "diffusion_coefficient" in values and ahead and not g:
            kept["D not negative"] = below(values["diffusion_coefficient"]), 0.0
        if "kurtosis" in values:
            kept["kurtosis >= 1"] = below(values["kurtosis"], 1.0), slack
        if "velocity_tensor" in values:
            tensor = values["velocity_tensor"]
            trace = np.trace(tensor, axis1=1, axis2=2)
            full = trace > 1e-290
            parts = np.linalg.eigvalsh(tensor[full] / trace[full, None, None])
            kept["<v v> positive"] = below(parts), slack
        if "mean_velocity" in values and seen.any():
            mean = np.linalg.norm(values["mean_velocity"], axis=1)[seen] / speed[seen]
            kept["<v>^2 <= <v^2>"] = above(mean), slack
        if "mean_displacement" in values and "msd" in values:
            far = np.nan_to_num((values["mean_displacement"] ** 2).sum(axis=1) / values["msd"])
            kept["<r>^2 <= <r^2>"] = above(far[later]), slack
    if not g:
        kept["<v^0> = 1"] = float(np.max(np.abs(found.moment(0.0) - 1.0))), slack
    return kept


def of_density(found: Any, mass: bool = True) -> Violations:
    """What the speed density of a Solution must keep, in units of its largest value."""
    error = max(found.rtol, found.error_estimate)
    low, apart, x = 0.0, 0.0, np.linspace(math.log(1e-8), math.log(1e3), 20_001)
    shares = found.uncollided
    for i, v0 in enumerate(np.sqrt(found.moment(2.0))):
        f = np.exp(x) * v0 * found.speed_density(np.exp(x) * v0)[i]
        low = max(low, below(f / max(f.max(), 1e-300)))
        apart = max(apart, abs(float(np.trapezoid(f, x)) + shares[i] - 1.0))
    kept = {"density not negative": (low, 1.5 * error), "uncollided": (above(shares), 1e-12)}
    return kept | ({"mass": (apart, 3.0 * error + 1e-9)} if mass else {})


def of_position(found: Any) -> Violations:
    """What G(R) of a Solution with the outputs msd and position_density must keep, at one time."""
    claimed = max(found.rtol, found.error_estimate)
    edges = np.concatenate([[0.0], np.geomspace(1e-2, 30.0, 60)])
    R, weight = panels_between(edges, 12)
    g = found.scaled_position_density(R)[0]
    norm, second = (float(g @ (weight * R**p)) for p in (0, 2))
    ends = found.scaled_position_density([0.0, 1e300])[0]
    return {
        "norm of G": (abs(norm - 1.0), 10.0 * claimed),
        "<R^2> = 1": (abs(second - 1.0), 100.0 * claimed),
        "G not negative": (below(g), claimed),
        "G(0) = G(infinity) = 0": (float(np.max(np.abs(ends))), claimed),
    }


def of_particles(run: Any, first: Any = None) -> Violations:
    """What a `particles.Ensemble` must keep; first : speeds of its tracers, where finals are kept."""
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
ROUNDING = 1e-13  # that references in doubles, and averages over a start, may add
SHARE = 0.3  # of an rtol: the most that the error estimate of a tighter solution may be


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
    weight, *both = (np.concatenate([getattr(q, n) for q in two]) for n in ("weight", "ratio", "cosine"))
    samples = (CollisionLaw.from_samples(*bounces, dimension=d) for d in (2, 3))
    mixture = CollisionLaw.from_samples(0.5 * weight, *both, 2)
    return (*(CollisionLaw(*law) for law in laws), *samples, mixture)


def forgets(law: CollisionLaw) -> bool:
    """Whether late averages forget the start, to 1e-20 of them.

    Where all bounces take the same share of the speed (et = e), averages go on oscillating in ln t
    by about exp(-pi^2/(2 kappa)).
    """
    return law.least_loss < law.largest_loss or law.mean_log_loss < 0.1


@cache
def scaling(law: CollisionLaw) -> tuple[float, float, float, float]:
    """h, 1 + a2, kappa and d<r^2>/d ln t in l^2 of the scaling state; not elastic.

    In 30 digits, so that no e is near a limit of doubles: integrals over the impact parameter y
    from 0 to 1, s^2 = e^2 + (et^2 - e^2) y^2 and s cos(chi) = -e + (e + et) y^2, y uniform among
    disks, y^2 among spheres; sums for samples. 1 + a2 = 6 d/(d+2) kappa lambda(1)/(lambda(2)
    lambda(3)) in any dimension.
    """
    import mpmath as mp

    d, q = law.dimension, law.quadrature
    with mp.workdps(30):
        e, et = mp.mpf(law.restitution or 0.0), mp.mpf(float(law.tangential_restitution or 0.0))
        edges = [0, *(mp.mpf(10) ** -k for k in range(12, 0, -1)), mp.mpf(1) / 2, 1]
        terms = [] if law.restitution is not None else [
            tuple(mp.mpf(float(x)) for x in row)
            for row in zip(q.weight / q.weight.sum(), q.ratio, q.cosine, strict=True)
        ]  # fmt: skip

        def mean(f: Callable[[Any, Any], Any]) -> Any:
            def at(y: Any) -> Any:
                s = mp.sqrt(e**2 * (1 - y**2) + et**2 * y**2)
                return f(s, (-e * (1 - y**2) + et * y**2) / s) * (1 if d == 2 else 2 * y)

            return mp.fsum(w * f(s, c) for w, s, c in terms) if terms else mp.quad(at, edges)

        one, two, three = (mean(lambda s, _, p=p: 1 - s**p) for p in (1, 2, 3))
        kappa, turn = mean(lambda s, _: -mp.log(s)), mean(lambda _, c: 1 - c)
        a2 = mp.mpf(6 * d) / (d + 2) * kappa * one / (two * three)
        return tuple(map(float, (2 * mp.sqrt(kappa * one), a2, kappa, 2 / (kappa * turn))))  # type: ignore[return-value]


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
        "two temperatures, 1e-3 and 1": (Gaussian(1.0, 1e-3), *smooth(-25.0, 2.5, two_temperatures)),
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


def limits(found: Any, first: tuple[float, float]) -> float:
    """Error of v0, a2 (and of the last slope of <r^2>) where they are their limits; NaN if nowhere.

    first : v0 and a2 of the start. v0 changes by less than v t/l at first, and is that of the
    scaling state from a few l/(kappa v t) on.
    """
    law, path, rtol = found.scene.law, found.scene.mean_free_path, found.rtol
    errors = []
    cools = not law.is_elastic and forgets(law)
    h, one_a2, kappa, slope = scaling(law) if cools else (math.nan,) * 4
    for t, v0, a2 in zip(found.times, found.thermal_speed, found.a2, strict=True):
        # ln(v t/l): v t may overflow
        x = -math.inf if t == 0.0 else math.log(first[0]) + math.log(t) - math.log(path)
        if x < math.log(0.01 * rtol) or law.is_elastic:
            errors += [abs(v0 / first[0] - 1.0), abs((1.0 + a2) / (1.0 + first[1]) - 1.0)]
        elif cools and x > math.log(1e3 / rtol) - math.log(kappa):
            expected = 2.0 * (path / float(t)) / h
            if expected > 1e-290:  # above the end of the doubles
                errors += [abs(v0 / expected - 1.0), abs((1.0 + a2) / one_a2 - 1.0)]
    if "diffusion_coefficient" in found.values and cools:
        errors.append(abs(found.msd_slope[-1] / path**2 / slope - 1.0))
    return max(errors, default=math.nan)


def mixture(law: Law, start: str, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """v0 and a2 of a start as the mean over its speeds, of a monoenergetic one at scaled times.

    The equation is linear, and speeds times s are times divided by s. Shape (n_times,) each.
    """
    _, v, w = starts()[start]
    gaussian, paths = 1.0 + 2.0 / as_law(law).dimension, np.outer(times, v)
    known, where = np.unique(paths, return_inverse=True)
    one = solved(law, "monoenergetic", known, ("thermal_speed", "a2"), 1e-13)
    with np.errstate(under="ignore"):
        square = (one.thermal_speed**2)[where].reshape(paths.shape)
        fourth = gaussian * square**2 * (1.0 + one.a2[where].reshape(paths.shape))
        second, fourth = square @ (w * v**2), fourth @ (w * v**4)
    return np.sqrt(second), fourth / gaussian / second**2 - 1.0


def difference(found: Any, v0: FloatArray, a2: FloatArray, at: Any = slice(None)) -> float:
    """Largest relative error of the thermal speeds, and of 1 + a2."""
    with np.errstate(all="ignore"):
        errors = [found.thermal_speed[at] / v0 - 1.0, (1.0 + found.a2[at]) / (1.0 + a2) - 1.0]
    worst = float(np.max(np.abs(errors)))
    return worst if math.isfinite(worst) else math.inf


def _outcome(found: Any, reached: float, asked: float = 0.0, **more: Any) -> Outcome:
    kept = invariants(found) | more.pop("invariants", {})
    return Outcome(
        asked or found.rtol + ROUNDING, reached, found.status.name == "CONVERGED", invariants=kept,
        note=f"estimate {found.error_estimate:.0e}", **more,
    )  # fmt: skip


# -- work of the cases: solvers -------------------------------------------------------------------


def _scaled(law: Law, rtol: float, nodes: int | None = None) -> Outcome:
    """h, a2 and F, relative to itself, against closed forms; norm, <c^2> = 1 and sign of F."""
    from kinetics import ScalingSolution, solve_scaled

    c, (h, one_a2, *_) = np.geomspace(1e-3, 30.0, 400), scaling(as_law(law))
    state = solve_scaled(as_law(law), rtol, nodes)
    F, exact = state.vdf(c), ScalingSolution(**as_law(law).arguments).vdf(c)
    seen = exact > 1e-290  # rounded numbers below
    errors = [state.cooling_rate / h - 1.0, (1.0 + state.a2) / one_a2 - 1.0]
    reached = float(np.abs([*errors, *(F[seen] / exact[seen] - 1.0)]).max())
    done = state.status.name == "CONVERGED"
    claimed = max(rtol, 1e-12) if done else math.inf
    kept = {f"<c^{p:g}> = 1": (abs(state.moment(p) - 1.0), claimed) for p in (0.0, 2.0)}
    kept["F not negative"] = below(F), 0.0
    reached = reached if math.isfinite(reached) else math.inf
    # ScalingSolution.vdf promises 1e-12
    return Outcome(rtol, reached, done, known_to=1e-12, invariants=kept,
                   note=f"estimate {state.error_estimate:.1e}")  # fmt: skip


def _cooling(law: Law, start: str, sizes: dict[str, float]) -> Outcome:
    """v0 and a2 against their limits at early and at late times, of any size of scene."""
    from kinetics import Gaussian, Monoenergetic

    scale, d = sizes.get("scale", 1.0), as_law(law).dimension
    medium = {name: size for name, size in sizes.items() if name != "scale"}
    state = Gaussian(scale, scale) if start == "gaussian" else Monoenergetic(scale)
    outputs = ["thermal_speed", "a2", "temperature", "collisions"]
    if not as_law(law).is_elastic and sizes == {"scale": 1.0}:  # else <r^2> leaves the doubles
        outputs.append("msd")
    found = solved(law, state, TIMES, outputs, 1e-9, **medium)
    first = (math.sqrt(d) * scale, 0.0) if start == "gaussian" else (scale, d / (d + 2.0) - 1.0)
    return _outcome(found, limits(found, first), in_part=not forgets(as_law(law)))


def _kept(e: float, start: str, horizon: str, rtol: float) -> Outcome:
    """v0 and a2 against the kept references."""
    found = solved(e, start, references.times(horizon), ("thermal_speed", "a2"), rtol)
    names = ("thermal_speed", "a2")
    exact = (references.kept(name, e, start, horizon) for name in names)
    return _outcome(found, difference(found, *exact))


def _rough(law: Law, start: str) -> Outcome:
    """v0 and a2 of a start: first value, mixture at all times, and late limit."""
    found = solved(law, start, TIMES, ("thermal_speed", "a2"), 1e-8)
    # fourth powers of late speeds of 1e-30 and less underflow in the mixture
    middle = (TIMES > 0.0) & (TIMES <= 1e30)
    reached = difference(found, *mixture(law, start, TIMES[middle]), middle)
    d, (_, v, w) = as_law(law).dimension, starts()[start]
    with np.errstate(under="ignore"):
        second, fourth = float(w @ v**2), float(w @ v**4)
    a2 = fourth / ((d + 2.0) / d * second**2) - 1.0
    # the first time and the last: by then, the slowest have met 1e140 scatterers
    ends = found.at([0.0, 1e300])
    return _outcome(found, max(reached, limits(ends, (math.sqrt(second), a2))))


def _spectral(law: Law, start: str, nodes: int | None) -> Outcome:
    """The speed density against a tighter one, relative to its maximum.

    Below 1e-2 of the thermal speed it is the density of ln v that keeps its accuracy.
    """
    times, outputs, rtol = [0.5, 30.0, 1e3], ("speed_density", "thermal_speed"), 1e-6
    found = solved(law, start, times, outputs, rtol, nodes=nodes)
    finer = solved(law, start, times, outputs, 0.01 * rtol)
    c = np.concatenate([[0.0], np.geomspace(1e-8, 30.0, 4000)])
    reached = 0.0
    for i, v0 in enumerate(finer.thermal_speed):
        f, exact = (one.speed_density(v0 * c)[i] for one in (found, finer))
        apart = np.abs(f - exact) * np.minimum(1.0, c / 1e-2) / exact.max()
        reached = max(reached, float(apart.max()) if np.all(np.isfinite(apart)) else math.inf)
    known = finer.error_estimate <= SHARE * rtol or math.isinf(reached)
    return _outcome(found, reached if known else math.nan, rtol, invariants=of_density(found))


def _late(law: Law, start: str) -> Outcome:
    """f(v) at t = 0 is the start, at t = 1e300 the scaling state, without overflow anywhere."""
    from kinetics import ScalingSolution

    law, rtol = as_law(law), 1e-4
    d, gaussian = law.dimension, start == "gaussian"
    found = solved(law, start, [0.0, 1e-300, 1e150, 1e300], ("speed_density", "thermal_speed"), rtol)
    c, unit = np.geomspace(1e-3, 20.0, 300), law.unit_surface * np.geomspace(1e-3, 20.0, 300) ** (d - 1)
    first = unit * (0.5 * d / math.pi) ** (0.5 * d) * np.exp(-0.5 * d * c * c) * gaussian
    expected = [first, first]
    if law.is_elastic or forgets(law):
        expected += [first if law.is_elastic else unit * ScalingSolution(**law.arguments).vdf(c)] * 2
    reached = 0.0
    for i, exact in enumerate(expected):
        v0 = math.sqrt(d) if gaussian else 1.0
        if i > 1 and not law.is_elastic:
            v0 = 2.0 * found.scene.mean_free_path / float(found.times[i]) / scaling(law)[0]
        apart = np.abs(v0 * found.speed_density(v0 * c)[i] - exact) / max(1.0, exact.max())
        reached = max(reached, float(apart.max()) if np.all(np.isfinite(apart)) else math.inf)
    everywhere = found.speed_density(np.array([0.0, 1e-300, 1.0, 1e300]))
    marginal = found.velocity_component_density(np.array([-1e300, 0.0, 1e300]))
    finite = np.all(np.isfinite(everywhere)) and np.all(np.isfinite(marginal))
    peak = np.array([float(not gaussian)] * 2 + [float(not gaussian and law.is_elastic)] * 2)
    kept = {
        "density not negative": (below(everywhere), rtol),
        "uncollided": (float(np.max(np.abs(found.uncollided - peak))), 1e-12),
    }
    return _outcome(found, reached if finite else math.inf, rtol, invariants=kept,
                    in_part=len(expected) < 4)  # fmt: skip


def _conservative(law: Law, start: str, nodes: int) -> Outcome:
    """The conservative scheme: sign of the density, its mass, and <v^2> as averaged.

    At 1e-13 the scheme serves all times itself. Its density is linear in ln v between nodes: the
    integrals are by the trapezoid rule with many points for each node.
    """
    found = solved(law, start, [0.5, 30.0, 1e3], ("speed_density", "thermal_speed"), 1e-13,
                   method="conservative", nodes=nodes)  # fmt: skip
    v0, estimate = found.thermal_speed, found.error_estimate
    v = np.geomspace(1e-8 * v0[-1], 1e6 * v0[0], max(200_001, 200 * nodes + 1))
    f = found.speed_density(v)
    weight = f * v * math.log(v[1] / v[0])
    mass, energy = (weight @ v**p + found.uncollided for p in (0.0, 2.0))
    reached = float(np.max(np.abs([energy / v0**2 - 1.0, mass - 1.0])))
    claims = float(found.status.name == "CONVERGED")  # no number of nodes reaches 1e-13
    kept = {"density not negative": (below(f), 0.0), "status says so": (claims, 0.0)}
    # the interpolation between nodes adds to the scheme's own error
    asked = max(3.0 * estimate, 1e-5) if estimate < 1.0 else math.inf
    return Outcome(asked, reached if math.isfinite(reached) else math.inf, invariants=kept,
                   note=f"estimate {estimate:.0e}")  # fmt: skip


def _moments(law: Law, start: str, rtol: float) -> Outcome:
    """Moments of the displacement: the late slope, and bounds that any motion keeps."""
    outputs = ["msd", "velocity_autocorrelation", "diffusion_coefficient", "thermal_speed", "a2"]
    if start != "tail v^-6":  # it has no fourth moment
        outputs += ["kurtosis", "mean_displacement", "mean_velocity", "velocity_tensor"]
    law = as_law(law)
    times = TIMES[TIMES < 1e200] if law.is_elastic else TIMES
    found = solved(law, start, times, outputs, rtol)
    late = found.msd_slope[-1] / found.scene.mean_free_path**2
    known = not law.is_elastic and forgets(law)
    return _outcome(found, abs(late / scaling(law)[3] - 1.0) if known else math.nan)


def _position(law: Law, t: float) -> Outcome:
    """G(R) of a Gaussian start against a tighter one."""
    rtol, outputs = 1e-3, ("msd", "position_density")
    found, finer = (solved(law, "gaussian", [t], outputs, r) for r in (rtol, 0.01 * rtol))
    R = np.linspace(0.0, 8.0, 400)
    unit = math.sqrt(found.msd[0] / finer.msd[0]) if found.msd[0] > 1e-290 else 1.0
    g, tight = found.scaled_position_density(R)[0], finer.scaled_position_density(unit * R)[0]
    reached = float(np.max(np.abs(g - unit * tight)))
    known = finer.error_estimate <= SHARE * rtol or not math.isfinite(reached)
    return _outcome(found, (reached if math.isfinite(reached) else math.inf) if known else math.nan,
                    rtol, in_part=not known, invariants=of_position(found))  # fmt: skip


def _scattering(law: Law, start: str, t: float) -> Outcome:
    """F at k = 0, for small k and in free flight, and that it is no larger than 1."""
    from scipy.special import j0

    from kinetics import ToleranceWarning

    law, rtol = as_law(law), 1e-9
    msd = ("msd",) if not law.is_elastic or t < 1e200 else ()
    found = solved(law, start, [t], ("intermediate_scattering", *msd), rtol)
    width = math.sqrt(found.msd[0]) if msd else math.inf
    # F = 1 - k^2 <r^2>/(2 d) + ..., whose next term is of order (k^2 <r^2>)^2
    small = 1e-4 / max(1.0, width)
    k = np.array([0.0, 1e-300, 1e-150 if width < 1e100 else 0.0, small, 1e-3, 0.1, 2.0])
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("error")
        warnings.simplefilter("always", ToleranceWarning)
        F = found.intermediate_scattering(k)[0]
        along = found.intermediate_scattering(k, direction=0.3)[0]
    errors = np.abs(F[:3] - 1.0).tolist()
    if math.isfinite(width):
        errors.append(abs(F[3] - 1.0 + (small * width) ** 2 / (2.0 * law.dimension)))
    if t <= 1e-12 / found.scene.mean_free_path:
        wave = j0(k * t) if law.dimension == 2 else np.sinc(k * t / math.pi)
        errors += np.abs(F - (np.exp(-0.5 * (k * t) ** 2) if start == "gaussian" else wave)).tolist()
    reached = float(max(errors)) if np.all(np.isfinite([F, along])) else math.inf
    kept = {"|F| <= 1": (above(np.abs([F, along])), 10.0 * rtol)}
    # nothing is known of k l of order 1
    done = found.status.name == "CONVERGED" and not said
    return Outcome(10.0 * rtol, reached, done, in_part=True, invariants=kept)


def _steady(law: Law, rtol: float) -> Outcome:
    """The steady state against <v^2 cos> = 1/lambda_1(1) and 2 <v_x> = lambda(2) <v^3>, exact."""
    from kinetics import solve_field

    found = solve_field(law, rtol=rtol)
    return Outcome(rtol + 1e-12, max(steady_errors(found)), found.status.name == "CONVERGED",
                   invariants={"<v_x>^2 <= <v_x^2>": (
                       above(found.drift / math.sqrt(found.mean_square_along)), 0.0)})  # fmt: skip


def steady_errors(found: Any) -> tuple[float, float]:
    """Errors of a FieldState in two exact relations; infinite where a number is not finite."""
    fixed = found.moment(2.0, 1) * float(found.law.harmonic_decay_rate(1.0, 1)) - 1.0
    energy = float(found.law.decay_rate(2.0)) * found.moment(3.0) / (2.0 * found.drift) - 1.0
    finite = math.isfinite(fixed + energy + found.mean_square_speed + found.mean_speed)
    return (abs(fixed), abs(energy)) if finite else (math.inf, math.inf)


def _in_field(e: float, start: str, field: float) -> Outcome:
    """Averages over time, up to 10 sqrt(l/g), against a tighter solution.

    Elastic tracers keep <v^2> - 2 g <x>; the others lose some of it.
    """
    from kinetics import Beam

    initial: Any = Beam(2.0, "monoenergetic") if start == "beam" else start
    outputs, rtol = ("mean_velocity", "thermal_speed", "mean_displacement", "collisions"), 1e-3
    times = np.array([1e-3, 0.1, 1.0, 10.0]) * math.sqrt(references.MEAN_FREE_PATH / field)
    try:
        found, finer = (solved(e, initial, times, outputs, r, field=field) for r in (rtol, 0.1 * rtol))
    except InputError as refused:  # fast starts of which next to nothing is left
        return Outcome(rtol, converged=False, note=str(refused))
    first = {"rest": 0.0, "gaussian": 2.0, "beam": 1.0}[start]
    given, square = 2.0 * field * found.mean_displacement[:, 0], found.thermal_speed**2
    gained = (square - first - given) / (np.maximum(square, first) + np.abs(given))
    apart = np.linalg.norm(found.mean_velocity - finer.mean_velocity, axis=1) / finer.thermal_speed
    changes = apart, np.abs(found.thermal_speed / finer.thermal_speed - 1.0)
    reached = float(np.max(np.abs(gained)) if e == 1.0 else np.max(changes))
    kept = {"no more energy than the field gives": (above(gained, 0.0), 3.0 * rtol)}
    return _outcome(found, reached if math.isfinite(reached) else math.inf, rtol, invariants=kept)


# -- work of the cases: particles -----------------------------------------------------------------

PERCOLATION = 0.359  # Poisson disks per d^2 at which the plane falls apart: rho pi d^2 = 1.128


def _run(medium: Any, e: float, **options: Any) -> Any:
    """A run of one thread with final states, of tracers of speed 1 where nothing else is said."""
    from particles import simulate

    usual = {"initial": "monoenergetic", "media": 1, "workers": 1, "observables": ("finals",)}
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
        kappa = scaling(law)[2]
        spread = law.largest_loss if math.isfinite(law.largest_loss) else 2.0 * kappa
        apart = float(np.max(np.abs(-logarithm / done - kappa)))
        more["mean loss is kappa"] = (apart, 6.0 * spread / math.sqrt(float(done.min())))
    return _of_run(run, more)


def _thin(rho: float, t: float) -> Outcome:
    """Before they meet anything, tracers are at v t, however far the next disk is."""
    run = _run(_medium("HardDisks", rho), 0.5, times=[t], media=2, tracers=20, seed=3)
    more = {"none has collided": (float(run.collisions.value[0]), 0.0)}
    return Outcome(1e-9, abs(float(run.msd.value[0]) / t**2 - 1.0), invariants=of_particles(run) | more)


def _outside(e: float) -> Outcome:
    """No tracer ends inside a disk."""
    from particles import Positions

    side = 60.0
    disks, centre = np.random.default_rng(3).uniform(0.0, side, (400, 2)), np.full(2, 0.5 * side)
    disks = disks[np.hypot(*(disks - centre).T) > 1.0]
    run = _run(Positions(disks, box_side=side), e, times=[1e4], tracers=300, max_collisions=3_000)
    apart = (run.finals[:, 2:4] + centre)[:, None, :] - disks
    apart -= side * np.round(apart / side)
    # a place is known to the rounding of the distance from the start
    allowed = 1e-12 * max(np.abs(run.finals[:, 2:4]).max(), 100.0)
    return _of_run(run, {"depth inside a disk": (below(np.hypot(*apart.T), 1.0), allowed)})


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
    rows = [*_of_solvers(quick), *_of_particles(quick)]
    return [Case(group, name, partial(work, *arguments)) for group, name, work, *arguments in rows]


def _of_solvers(quick: bool) -> Iterator[Any]:
    laws: list[Law] = [*(FEWER if quick else RESTITUTIONS), *other_laws(quick)]
    cooling: list[Law] = [law for law in laws if not as_law(law).is_elastic]
    plain = [e for e in laws if isinstance(e, float)]
    some = (0.0, 0.7, 0.99) if quick else (0.0, 1e-10, 1e-4, 0.2, 0.5, 0.7, 0.9, 0.99, 0.999)
    others = [law for law in other_laws(quick) if law.mean_log_loss > 1e-4]
    dense = [*((law, 1.0 - 1e-10) for law in ()), *some, *others]
    both = references.STARTS
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
                yield "cooling", name, _kept, e, start, horizon, rtol
    for law in laws:
        for start in both:
            for what, x in (("scale", 1e-150), ("scale", 1.0), ("scale", 1e150),
                            ("number_density", 1e150), ("diameter", 1e-150)):  # fmt: skip
                # refused: elastic tracers do not slow down, v t/l overflows
                if x == 1.0 or (law in plain and law != 1.0):
                    name = f"{label_of(law)}, {start}, {what} {x:g}, t to 1e300"
                    yield "cooling", name, _cooling, law, start, {what: x}
    for law in (0.0, 0.2, 1.0 - 1e-6, *other_laws(quick)) if quick else laws:
        for start in starts() if law in plain else ("two delta peaks",):
            yield "starts", f"{label_of(law)}, {start}", _rough, law, start
    for law in dense:
        # where bounces multiply the speed by single values, a sharp start is refused
        single = as_law(law).least_loss == as_law(law).largest_loss > 0.0
        sharp = as_law(law).restitution is not None and not single
        for n in (8, 64, 512, None) if law in some else (None,):
            name = f"{label_of(law)}, gaussian, {n or 'its own'} nodes"
            yield "spectral density", name, _spectral, law, "gaussian", n
        for start in both if sharp else ("gaussian",):
            yield "late density", f"{label_of(law)}, {start}, t to 1e300", _late, law, start
        for n in (8, 64, 512) if law in some else (512,):
            for start in ("gaussian", "monoenergetic", "step", "two delta peaks", "tail v^-6"):
                if sharp or start in ("gaussian", "step"):
                    name = f"{label_of(law)}, {start}, {n} nodes"
                    yield "conservative density", name, _conservative, law, start, n
    yield "late density", "e = 1, monoenergetic, t to 1e300", _late, 1.0, "monoenergetic"
    for law in laws:
        for start in ("gaussian", "beam") if quick or law not in plain else starts():
            for rtol in (1e-9,) if quick else (1e-3, 1e-9, 1e-12):
                name = f"{label_of(law)}, {start}, t to 1e300, rtol {rtol:.0e}"
                yield "moments of position", name, _moments, law, start, rtol
    few: list[Law] = [0.2, 0.7, 1.0 - 1e-10, 1.0, *other_laws(quick)]
    for law in few:
        own = law in plain
        for t in (1e-300, 1e3, 1e300) if own else (1e3,) if quick else (1e-300, 1e3, 1e8):
            yield "position density", f"{label_of(law)}, gaussian, t = {t:g}", _position, law, t
        for start in ("gaussian", "beam"):
            for t in (0.0, 1e-300, 1.0, 1e3, 1e300) if own else (1.0,) if quick else (1.0, 1e3):
                name = f"{label_of(law)}, {start}, t = {t:g}"
                yield "scattering function", name, _scattering, law, start, t
    for law in (0.0, 1.0 - 1e-10) if quick else cooling:
        for rtol in (1e-6,) if quick else (1e-3, 1e-6, 1e-10):
            yield "steady state", f"{label_of(law)}, rtol {rtol:.0e}", _steady, law, rtol
    for e in (0.7,) if quick else (0.0, 1e-10, 0.7, 1.0 - 1e-10, 1.0):
        for start in ("rest",) if quick else ("rest", "gaussian", "beam"):
            for g in (1e12,) if quick else (1e-12, 1.0, 1e12):
                name = f"{label_of(e)}, {start}, field {g:g}"
                yield "over time in a field", name, _in_field, e, start, g


def _of_particles(quick: bool) -> Iterator[Any]:
    media = [("Poisson", rho) for rho in (0.01, 0.2, 0.35, PERCOLATION)]
    media += [("HardDisks", rho) for rho in (0.01, 0.2, 0.65)] + [("BoltzmannGrad", 0.04)]
    media += [("HardSpheres", 0.3), ("PoissonSpheres", 0.1 / math.pi), ("BoltzmannGrad in space", 0.04)]
    for e, et in ((0.0, 1.0), (0.5, 0.8), (1.0, 1.0)) if quick else (
        (0.0, 1.0), (0.2, 1.0), (0.5, 1.0), (0.5, 0.8), (0.5, 0.0), (0.99, 1.0), (1.0, 1.0), (1.0, 0.8)
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
    for rho, t in ((rho, t) for rho in (1e-4, 1e-6, 1e-8) for t in (1e-3, 1.0, 10.0)):
        yield "thin media", f"HardDisks, {rho:g} per d^2, t = {t:g}", _thin, rho, t
    for e in (0.0, 0.5, 0.9, 1.0):
        yield "no tracer inside a disk", f"e = {e:g}, 400 random disks", _outside, e
    for e in (0.0, 1e-10, 0.5, 1.0 - 1e-10, 1.0):
        for gap in (-1e-3, -1e-8, -1e-12, -1e-15, 0.0, 1e-15, 1e-12, 1e-8, 1e-3):
            name = f"{label_of(e)}, passing the circle at {gap:+.0e} d"
            yield "grazing", name, _grazing, e, gap
        for gap in (0.0, 1e-15, 1e-9, 1e-3, 0.3):
            name = f"{label_of(e)}, into a corner, circles {gap:.0e} d inside one another"
            yield "corners", name, _corner, e, gap


# -- run and report -------------------------------------------------------------------------------


def run_stress(
    quick: bool = False,
    groups: Iterable[str] | None = None,
    progress: Callable[[str, int], None] | None = None,
    interrupted: Callable[[StressReport], None] | None = None,
) -> StressReport:
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
            if progress is not None:
                progress(case.group, len(chosen))
            found.append(attempt(case))
    except (KeyboardInterrupt, SystemExit):
        if interrupted is not None:
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
        for title, cases in (
            ("Cases that did not end as they must", self.rejected),
            ("Every case", self.cases if every_case else ()),
        ):
            if cases:
                lines += [f"## {title}", "", *markdown_table([_cells(c) for c in cases])]
        return "\n".join(lines) + "\n"


def _cells(case: StressCase) -> dict[str, str]:
    names = ("verdict", "group", "name", "asked", "reached", "invariant", "violation", "allowed", "note")
    values = ((name, getattr(case, name)) for name in names)
    return {n: x if isinstance(x, str) else "" if x != x else f"{x:.1e}" for n, x in values}
