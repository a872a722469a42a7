"""What every answer must keep, whatever was asked: the invariants of the stability sweep.

d is the diameter of a scatterer and of the tracer, U the standard deviation of one component of the
initial velocity; v0 is the thermal speed, the root mean square speed at a time. Begin with
`invariants`, of solutions, or `of_particles`.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics import Solution
from kinetics.numerics.gauss import panels_between
from particles import Ensemble

FloatArray = NDArray[np.float64]

#: Logarithms of v/v0 over which the mass of a density of speeds is summed. Measured in the quick
#: sweep: half or an eighth as many points give the same mass to 2 % of its deviation from 1, or to
#: 1e-12. From 1e-9 on the mass of the widest density (e = et = 1e-7) lacks 3e-8, from 1e-6 on 0.8;
#: up to 30 it lacks 1e-4.
LOG_SPEEDS = np.linspace(math.log(1e-12), math.log(1e3), 30_001)
#: Thermal speed in U above which f(v) is checked. Derived: v^2 at the lowest speed of LOG_SPEEDS is
#: then above 1e-304, and the smallest normal double is 2e-308.
MIN_THERMAL_SPEED = 1e-140
#: Thermal speed in U below which f(v) is checked. Derived: v^2 at the highest speed of LOG_SPEEDS
#: is then below 1e286, and the largest double is 2e308.
MAX_THERMAL_SPEED = 1e140
#: Edges of the panels in R over which moments of G(R) are summed. Measured in the quick sweep: with
#: half or twice the panels, the nodes or the largest R, <R^0> is 1 to 8e-5 and <R^2> to 0.04, of
#: which 0.01 and 0.1 are allowed: it is the error of G, not of the sum.
RADIUS_EDGES = np.concatenate([[0.0], np.geomspace(1e-2, 30.0, 60)])
#: Gauss nodes in each of these panels; measured with them.
NODES_PER_PANEL = 12
#: Wave numbers in 1/d at which |F| <= 1 is looked at; the first must be 0, where F = 1 is. Chosen:
#: 0, one whose square underflows, and usual ones.
WAVE_NUMBERS = [0.0, 1e-300, 1e-3, 0.1, 2.0]
#: Errors of an answer that an invariant of averages and of F may be violated by, beside rounding.
#: Chosen: the answer's own, doubled for a difference, and doubled again as a margin. In the quick
#: sweep 0.25 of them suffices, without rounding.
SLACK_FACTOR = 4.0
#: Relative error of rounding by which an invariant may be violated, beside. Measured in the quick
#: sweep: at most 1.5e-13, for <v^0> = 1.
ROUNDING = 1e-12
#: Errors of an answer by which f(v) may be negative, over its peak. Measured in the sweep: at most
#: 0.4, with 8 nodes.
SPEED_DENSITY_FACTOR = 1.5
#: Peak of the density of ln v that stands for one of 0, as where no tracer has collided: nothing is
#: divided by 0. Chosen: far below all peaks.
LEAST_PEAK = 1e-300
#: Errors of an answer by which the mass of f(v), or <R^0>, may differ from 1: the error is that of
#: a density at one place, and the mass is a sum of many. Measured in the sweep: 9.9 of f(v) at
#: e = et = 1e-7 and t = 1e3 d/U, and 0.11 of <R^0>.
MASS_FACTOR = 10.0
#: Errors of an answer by which <R^2> may differ from 1: the weight R^2 is large where G is small.
#: Measured in the sweep: at most 36, of measured bounces in space.
MEAN_SQUARE_FACTOR = 100.0


@dataclass(frozen=True)
class Violation:
    """How far an invariant is violated, and what is allowed; neither is negative."""

    size: float
    allowed: float

    @property
    def is_allowed(self) -> bool:
        """Whether it is; NaN is not."""
        return self.size <= self.allowed


#: Name of an invariant -> its violation.
Violations = dict[str, Violation]


@dataclass(frozen=True)
class Outcome:
    """What a run gave.

    Parameters
    ----------
    asked : the error asked for; infinite where none was
    reached : the error reached; NaN where there is no reference, infinite for no finite answer
    converged : as the status claims
    """

    asked: float = math.inf
    reached: float = math.nan
    converged: bool = True
    invariants: Mapping[str, Violation] = field(default_factory=dict)
    note: str = ""

    @property
    def violated(self) -> str | None:
        """The first invariant that is violated; None if all are kept."""
        for name, violation in self.invariants.items():
            if not violation.is_allowed:
                return name
        return None


def excess(values: ArrayLike) -> float:
    """Return how far the largest value is above 0; 0 if it is not; infinite if one is no number."""
    largest = float(np.max(values, initial=-math.inf))
    if math.isnan(largest):
        return math.inf
    return max(0.0, largest)


def largest_error(*errors: ArrayLike) -> float:
    """Return the largest of these errors in size; infinite where one is not finite."""
    sizes = np.abs(np.concatenate([np.ravel(error) for error in errors]))
    if not np.all(np.isfinite(sizes)):
        return math.inf
    return float(sizes.max())


def invariants(solution: Solution) -> Violations:
    """Return what a Solution must keep, of those outputs that it has, within its own error."""
    violations: Violations = {}
    for name, values in solution.values.items():
        count = float(np.sum(~np.isfinite(values)))
        violations[f"{name} is finite"] = Violation(count, 0.0)
    if any(violation.size for violation in violations.values()):
        return violations
    outputs = solution.scene.outputs
    violations |= _of_distributions(solution)
    # The scenes of the sweep have no drive but a field: without it speeds can only fall.
    if not solution.scene.field:
        violations |= _of_cooling(solution)
        if "speed_density" in outputs:
            violations |= _of_speed_density(solution)
    if "position_density" in outputs:
        violations |= _of_position_density(solution)
    if "intermediate_scattering" in outputs:
        violations |= _of_scattering(solution)
    return violations


def _error_of(solution: Solution) -> float:
    """Return the error that a solution claims or was asked for, the larger."""
    return float(max(solution.rtol, solution.error_estimate))


def _slack_of(solution: Solution) -> float:
    """Return by how much its averages may violate an invariant."""
    return SLACK_FACTOR * _error_of(solution) + ROUNDING


def _of_distributions(solution: Solution) -> Violations:
    """Return bounds that every distribution keeps: <v^4> >= <v^2>^2, and <r^4> >= <r^2>^2.

    In the name of the first, d is the dimension.
    """
    slack = _slack_of(solution)
    dimension = solution.scene.dimension
    values = solution.values
    violations: Violations = {}
    if "a2" in values:
        below = excess(-2.0 / (dimension + 2.0) - values["a2"])
        violations["a2 >= -2/(d + 2)"] = Violation(below, slack)
    if "kurtosis" in values:
        violations["kurtosis >= 1"] = Violation(excess(1.0 - values["kurtosis"]), slack)
    return violations


def _of_cooling(solution: Solution) -> Violations:
    """Return what averages keep without a field: speeds fall, distances and collisions do not."""
    slack = _slack_of(solution)
    values = solution.values
    is_begin = np.asarray(solution.times) == 0.0
    norm = largest_error(solution.moment(0.0) - 1.0)
    violations = {"<v^0> = 1": Violation(norm, slack)}

    def largest_fall(x: FloatArray) -> float:
        with np.errstate(all="ignore"):
            return excess(x[:-1] - x[1:] * (1.0 + slack))

    for name in ("thermal_speed", "temperature"):
        if name in values:
            growth = largest_fall(values[name][::-1])
            violations[f"{name} does not grow"] = Violation(growth, 0.0)
    for name in ("collisions", "msd"):
        if name in values:
            fall = largest_fall(values[name])
            violations[f"{name} does not fall"] = Violation(fall, 0.0)
            at_begin = excess(values[name][is_begin])
            violations[f"{name} begins at 0"] = Violation(at_begin, 0.0)
    # Bounces that throw tracers back and nearly stop them make D negative. Smooth scatterers, which
    # keep the tangential velocity, do not, in no case of the sweep.
    law = solution.scene.law
    is_forward = law.tangential_restitution == 1.0 or law.mean_cosine >= 0.0
    if "diffusion_coefficient" in values and is_forward:
        below = excess(np.negative(values["diffusion_coefficient"]))
        violations["D not negative"] = Violation(below, slack)
    return violations


def _of_speed_density(solution: Solution) -> Violations:
    """Return that f(v) is not negative, and has all of the mass that is not uncollided."""
    error = _error_of(solution)
    uncollided = solution.uncollided
    violations: Violations = {}
    for index, thermal_speed in enumerate(np.sqrt(solution.moment(2.0))):
        if not MIN_THERMAL_SPEED < thermal_speed < MAX_THERMAL_SPEED:
            continue
        speeds = np.exp(LOG_SPEEDS) * thermal_speed
        density = speeds * solution.speed_density(speeds)[index]  # of ln v
        mass = float(np.trapezoid(density, LOG_SPEEDS)) + uncollided[index]
        below = excess(-density / max(density.max(), LEAST_PEAK))
        allowed_below = SPEED_DENSITY_FACTOR * error
        violations[f"density not negative, time {index}"] = Violation(below, allowed_below)
        violations[f"mass, time {index}"] = Violation(abs(mass - 1.0), MASS_FACTOR * error)
    return violations


def _of_position_density(solution: Solution) -> Violations:
    """Return that G(R) is not negative, and that <R^0> and <R^2> are 1, where it has no front.

    A front is what has not collided of a start of sharp speeds: G leaves it out.
    """
    error = _error_of(solution)
    radii, weights = panels_between(RADIUS_EDGES, NODES_PER_PANEL)
    _, front_shares = solution.ballistic_front
    is_smooth = (np.asarray(solution.times) > 0.0) & (front_shares.sum(axis=1) == 0.0)
    violations: Violations = {}
    for index in map(int, np.flatnonzero(is_smooth)):
        density = solution.scaled_position_density(radii)[index]
        # Where G is negative it is by its own error at most; 0.04 of it was measured in the sweep.
        violations[f"G not negative, time {index}"] = Violation(excess(-density), error)
        for power, factor in ((0, MASS_FACTOR), (2, MEAN_SQUARE_FACTOR)):
            moment = float(density @ (weights * radii**power))
            violation = Violation(abs(moment - 1.0), factor * error)
            violations[f"<R^{power}> = 1, time {index}"] = violation
    return violations


def _of_scattering(solution: Solution) -> Violations:
    """Return that the scattering function is 1 at k = 0, and not larger."""
    slack = _slack_of(solution)
    scattering = solution.intermediate_scattering(WAVE_NUMBERS)
    at_zero = scattering[:, 0]  # as the first of WAVE_NUMBERS is 0
    return {
        "|F| <= 1": Violation(excess(np.abs(scattering) - 1.0), slack),
        "F(0) = 1": Violation(largest_error(at_zero - 1.0), slack),
    }


def of_particles(ensemble: Ensemble) -> Violations:
    """Return what an Ensemble must keep."""
    statuses = ensemble.statuses
    ended = statuses.finished + statuses.collision_cap + statuses.trapped + statuses.escaped
    lost = float(abs(ended - ensemble.media * ensemble.tracers))
    violations = {"tracers are accounted for": Violation(lost, 0.0)}
    if not ensemble.times.size:
        return violations
    for name in ("thermal_speed", "msd", "collisions"):
        sampled = getattr(ensemble, name).value[ensemble.samples > 0]
        count = float(np.sum(~np.isfinite(sampled)))
        violations[f"{name} is finite"] = Violation(count, 0.0)
    return violations
