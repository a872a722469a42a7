"""The works of the stability sweep: each runs a solver or particles, and gives an `Outcome`.

A work compares an answer with digits known apart from the solver (`error_to_references`, closed
forms, exact balances), or with a solution to a tighter tolerance (`error_to_tighter`).
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

import kinetics
import particles
from kinetics import Beam, Gaussian, Monoenergetic, Solution, SpeedSamples, SpeedTable
from kinetics.collision import CollisionLaw
from kinetics.crosscheck import references
from kinetics.crosscheck.stress_invariants import (
    FloatArray,
    Outcome,
    Violation,
    Violations,
    excess,
    invariants,
    largest_error,
    of_particles,
)
from kinetics.driven.driven_state import DrivenState


def _tail(v: ArrayLike) -> FloatArray:
    """Return the density of a start whose <v^6> is infinite."""
    speeds = np.asarray(v)
    return np.asarray(5.0 * speeds * np.hypot(1.0, speeds) ** -7.0)


#: Starts of other units, directed, and rough, beside those that have a name.
STARTS: Mapping[str, Any] = {
    "gaussian of 1e-150": Gaussian(1e-150, 1e-150),
    "speed 1e150": Monoenergetic(1e150),
    "beam along x": Beam(0.0),
    "step": SpeedTable([1.0, 1.0 + 1e-9, 2.0, 2.0 + 1e-9], [0.0, 1.0, 1.0, 0.0]),
    "two peaks": SpeedSamples([0.01, 1.0]),
    "speeds 1e-100 and 1": SpeedSamples([1e-100, 1.0]),
    "tail v^-6": _tail,
}
#: Last time in d/U of the short horizon of `references`, with a margin.
SHORT_HORIZON_UNTIL = 1e3
#: Share of the error that the finer solution is asked for.
TIGHTER = 0.01
#: Share of the error below which it must estimate its own, or the error is not known.
TIGHTER_MUST_REACH = 0.3
#: Values below which a difference is none: products of such numbers underflow.
TINY = 1e-300
#: c at which speed densities are compared.
COMPARED_SPEEDS = np.concatenate([[0.0], np.geomspace(1e-8, 30.0, 4000)])
#: c below which they are compared as densities of ln v.
LOGARITHMIC_BELOW = 1e-2
#: R at which position densities are, and k in 1/d at which scattering functions are.
COMPARED_RADII = np.linspace(0.0, 8.0, 400)
#: k in 1/d at which scattering functions are compared.
COMPARED_WAVE_NUMBERS = [1e-3, 0.1, 2.0]
#: Directions in radians of the wave vector; None: averaged.
COMPARED_DIRECTIONS = (None, 0.3)
#: c at which F(c) is compared. With a tangential restitution of 0 the series is slow nearer to 0.
SCALED_SPEEDS = np.geomspace(0.05, 30.0, 400)
#: F over its peak down to which it is compared: the solver ends at 1e-100.
MIN_SCALED_DENSITY = 1e-95
#: c above which the peak of F is looked for. The origin is not recorded.
PEAK_ABOVE = 0.3
#: Error that references, or the solver's own promise in doubles, may add.
ROUNDING = 1e-12
#: The same of averages over time.
ROUNDING_OVER_TIME = 1e-13
#: Error of a balance over the tolerance that is allowed. The origin is not recorded.
BALANCE_FACTOR = 20.0


class Answer(Protocol):
    """What the answers of all solvers have."""

    @property
    def status(self) -> Any:
        """The status."""

    @property
    def error_estimate(self) -> float:
        """The error that the solver estimates."""


def _outcome(
    answer: Answer, asked: float, reached: float, violations: Violations, rounding: float
) -> Outcome:
    """Return the outcome of a solver's answer."""
    return Outcome(
        asked=asked + rounding,
        reached=reached,
        converged=answer.status.name == "CONVERGED",
        invariants=violations,
        note=f"estimate {answer.error_estimate:.0e}",
    )


# -- scenes over time ------------------------------------------------------------------------------
def error_to_references(solution: Solution) -> float:
    """Return the error of v0 and a2 against the kept digits."""
    scene = solution.scene
    horizon = "long" if solution.times[-1] > SHORT_HORIZON_UNTIL else "short"
    key = (scene.restitution, scene.initial, horizon)
    speeds = references.kept("thermal_speed", *key)
    coefficients = references.kept("a2", *key)
    speed_errors = solution.thermal_speed / speeds - 1.0
    return largest_error(speed_errors, (1.0 + solution.a2) / (1.0 + coefficients) - 1.0)


def error_to_tighter(solution: Solution) -> float:
    """Return the difference to a solution for a hundredth of the error; NaN if it is not known."""
    finer = solve_again(solution, TIGHTER * solution.rtol)
    if finer.error_estimate > TIGHTER_MUST_REACH * solution.rtol:
        return math.nan
    return largest_difference(solution, finer)


def solve_again(solution: Solution, rtol: float) -> Solution:
    """Solve the scene of a Solution once more, to another rtol, with the thermal speed."""
    outputs = tuple(dict.fromkeys(("thermal_speed", *solution.scene.outputs)))
    return kinetics.solve(replace(solution.scene, outputs=outputs), rtol)


def largest_difference(solution: Solution, finer: Solution) -> float:
    """Return the largest error of a Solution, a finer one of the same scene taken as exact.

    Averages relative to their size (vectors to their largest component), densities to their
    maximum, those of the speed below 1e-2 of the thermal speed as densities of ln v.
    """
    errors: list[ArrayLike] = [0.0]
    with np.errstate(all="ignore"):
        errors += _errors_of_averages(solution, finer)
    errors += _errors_of_densities(solution, finer)
    if "intermediate_scattering" in solution.scene.outputs:
        for direction in COMPARED_DIRECTIONS:
            coarse = solution.intermediate_scattering(COMPARED_WAVE_NUMBERS, direction=direction)
            fine = finer.intermediate_scattering(COMPARED_WAVE_NUMBERS, direction=direction)
            errors.append(np.subtract(coarse, fine))
    return largest_error(*errors)


def _errors_of_averages(solution: Solution, finer: Solution) -> list[FloatArray]:
    """Return the errors of all averages, each relative to its size."""
    thermal_speed = finer.thermal_speed
    sizes: dict[str, ArrayLike] = {"a2": 1.0, "mean_velocity": thermal_speed[:, None]}
    start = solution.scene.state.harmonic(0, 1e-14)
    if start is not None:
        first_speed = math.exp(0.5 * start.log_second_moment())
        sizes["velocity_autocorrelation"] = first_speed * thermal_speed
    errors = []
    for name, values in solution.values.items():
        exact = np.abs(finer.values[name])
        change = np.abs(values - finer.values[name])
        largest = exact.max(axis=tuple(range(1, exact.ndim)), keepdims=True)
        relative = change / np.asarray(sizes.get(name, largest))
        errors.append(np.where(change < TINY, 0.0, relative))
    return errors


def _errors_of_densities(solution: Solution, finer: Solution) -> list[FloatArray]:
    """Return the errors of the densities of speeds and positions at each time."""
    outputs = solution.scene.outputs
    errors = []
    for index, thermal_speed in enumerate(finer.thermal_speed):
        if "speed_density" in outputs:
            speeds = thermal_speed * COMPARED_SPEEDS
            density = solution.speed_density(speeds)[index]
            exact = finer.speed_density(speeds)[index]
            weight = np.minimum(1.0, COMPARED_SPEEDS / LOGARITHMIC_BELOW)
            errors.append((density - exact) * weight / exact.max())
        if "position_density" in outputs and solution.times[index] > 0.0:
            coarse = solution.scaled_position_density(COMPARED_RADII)[index]
            errors.append(coarse - finer.scaled_position_density(COMPARED_RADII)[index])
    return errors


def scene(
    law: CollisionLaw,
    start: str,
    times: Sequence[float] | FloatArray,
    outputs: tuple[str, ...],
    rtol: float,
    nodes: int | None = None,
    reference: Callable[[Solution], float] = error_to_tighter,
    **sizes: float,
) -> Outcome:
    """Solve a scene over time; `reference` gives its error, `sizes` are further arguments."""
    arguments: dict[str, Any] = {"initial": STARTS.get(start, start), **sizes}
    question = kinetics.Scene(law, times=times, outputs=outputs, **arguments)
    solution = kinetics.solve(question, rtol, nodes=nodes)
    reached = reference(solution)
    return _outcome(solution, rtol, reached, invariants(solution), ROUNDING_OVER_TIME)


# -- the scaling state -----------------------------------------------------------------------------
def scaled(law: CollisionLaw, rtol: float, nodes: int | None = None) -> Outcome:
    """Solve for h, a2 and F, relative to itself, against closed forms that share nothing with it.

    The invariants are norm, <c^2> = 1 and sign of F.
    """
    closed = kinetics.ScalingSolution(**law.arguments)
    state = kinetics.solve_scaled(law, rtol, nodes)
    exact = closed.vdf(SCALED_SPEEDS)
    peak = exact[SCALED_SPEEDS > PEAK_ABOVE].max()
    is_compared = exact > MIN_SCALED_DENSITY * peak
    density = np.where(is_compared, state.reached_vdf(SCALED_SPEEDS), 0.0)
    reached = largest_error(
        state.cooling_rate / closed.cooling_rate - 1.0,
        (1.0 + state.a2) / (1.0 + closed.a2) - 1.0,
        density[is_compared] / exact[is_compared] - 1.0,
    )
    claimed = math.inf
    if state.status.name == "CONVERGED":
        claimed = max(rtol, ROUNDING)
    violations = {}
    for power in (0.0, 2.0):
        error = abs(state.moment(power) - 1.0)
        violations[f"<c^{power:g}> = 1"] = Violation(error, claimed)
    violations["F not negative"] = Violation(excess(-density), 0.0)
    return _outcome(state, rtol, reached, violations, ROUNDING)


# -- steady states ---------------------------------------------------------------------------------
def steady_errors(state: Any) -> tuple[float, float]:
    """Return errors of a FieldState in <v^2 cos> = 1/lambda_1(1) and 2 <v_x> = lambda(2) <v^3>."""
    momentum = state.moment(2.0, 1) * float(state.law.harmonic_decay_rate(1.0, 1)) - 1.0
    energy_loss = float(state.law.decay_rate(2.0)) * state.moment(3.0)
    energy = energy_loss / (2.0 * state.drift) - 1.0
    if not math.isfinite(momentum + energy + state.mean_square_speed + state.mean_speed):
        return math.inf, math.inf
    return abs(momentum), abs(energy)


def steady(law: CollisionLaw, rtol: float) -> Outcome:
    """Solve for the steady state in a field, against two exact relations."""
    state = kinetics.solve_field(law, rtol=rtol)
    variance = excess(state.drift**2 - state.mean_square_along)
    violations = {"<v_x>^2 <= <v_x^2>": Violation(variance, 0.0)}
    return _outcome(state, rtol, largest_error(steady_errors(state)), violations, ROUNDING)


def balances(state: DrivenState) -> list[float]:
    """Return what a driven state misses in its exact relations, relative to their terms."""
    share = 1.0
    if math.isfinite(state.mass_ratio):
        share = state.mass_ratio / (1.0 + state.mass_ratio)
    recoil = share * (1.0 + state.restitution)  # 1 + e*
    if not state.bath_speed:
        return _balances_without_bath(state, recoil)
    if state.heating or state.drag or state.field:
        return []
    # A Maxwellian, and the Einstein relation.
    square = state.bath_speed**2 * recoil / (2.0 - recoil)
    einstein = state.mobility * square / state.diffusion_coefficient
    speed_ratio = state.thermal_speed**2 / (state.dimension * square)
    return [speed_ratio - 1.0, state.a2, einstein - 1.0]


def _balances_without_bath(state: DrivenState, recoil: float) -> list[float]:
    """Return what the energy balance misses, and in a field that of the momentum."""
    mean_square_cosine = 2 / 3 if state.dimension == 2 else 1 / 2  # of an impact
    gained = 2.0 * state.heating * state.dimension
    if state.field:
        gained += 2.0 * state.field * state.moment(1.0, 1)
    lost_in_impacts = (2.0 - recoil) * recoil * mean_square_cosine * state.moment(3.0)
    lost = 2.0 * state.drag * state.moment(2.0) + lost_in_impacts
    missed = [gained / lost - 1.0]
    if state.field:
        momentum_lost = recoil * mean_square_cosine * state.moment(2.0, 1)
        missed.append((momentum_lost + state.drag * state.drift) / state.field - 1.0)
    return missed


def driven(rtol: float, **system: Any) -> Outcome:
    """Solve for the steady state of a driven tracer, against balances and a tighter solution."""
    state = kinetics.solve_steady(**system, rtol=rtol)
    finer = kinetics.solve_steady(**system, rtol=0.1 * rtol)
    errors = [state.a2 - finer.a2, (state.drift - finer.drift) / finer.thermal_speed]
    for name in ("thermal_speed", "collision_rate", "diffusion_coefficient", "mobility"):
        errors.append(getattr(state, name) / getattr(finer, name) - 1.0)
    missed = largest_error(balances(state), 0.0)
    below = excess(-2.0 / (state.dimension + 2.0) - state.a2)
    violations = {
        "balances": Violation(missed, BALANCE_FACTOR * max(rtol, state.error_estimate)),
        "a2 >= -2/(d + 2)": Violation(below, 0.0),
    }
    asked = rtol + finer.error_estimate
    return _outcome(state, asked, largest_error(errors), violations, ROUNDING)


# -- particles -------------------------------------------------------------------------------------
def fly(law: CollisionLaw, medium: str) -> Outcome:
    """Follow tracers of speed 1 in a dense or a dilute medium, named "HardDisks 0.2"."""
    kind, density = medium.split()
    size: dict[str, int] = {"count": 2_000}
    if kind == "BoltzmannGrad":
        size = {"dimension": law.dimension}
    ensemble = particles.simulate(
        getattr(particles, kind)(float(density), **size),
        law.restitution or 0.0,
        "monoenergetic",
        [1.0, 100.0, 1e4],
        media=3,
        tracers=30,
        max_collisions=2_000,
        seed=5,
        workers=1,
        observables=("finals",),
        tangential_restitution=law.tangential_restitution or 0.0,
    )
    log_loss = -ensemble.finals[:, 0]
    collisions = ensemble.finals[:, 4]
    n_unknown = float(np.sum(np.isnan(ensemble.finals)))
    miscounted = float(abs(collisions.sum() - ensemble.collision_total))
    violations = of_particles(ensemble)
    violations["finals are finite"] = Violation(n_unknown, 0.0)
    violations["no speed grows"] = Violation(excess(-log_loss), 1e-9)
    violations["no tracer escapes"] = Violation(float(ensemble.statuses.escaped), 0.0)
    violations["collisions are counted"] = Violation(miscounted, 0.0)
    if law.is_elastic:
        violations["speed is kept"] = Violation(largest_error(log_loss), 1e-9)
    note = f"{ensemble.collision_total} collisions, {ensemble.statuses.trapped} trapped"
    return Outcome(invariants=violations, note=note)
