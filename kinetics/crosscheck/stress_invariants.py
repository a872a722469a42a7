"""What every answer must keep, whatever was asked: the invariants of the stability sweep."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics import Solution
from kinetics.numerics.gauss import panels_between
from particles import Ensemble

FloatArray = NDArray[np.float64]

#: Logarithms of v/v0 over which the mass of a density of speeds is summed. The origin of range and
#: number is not recorded.
LOG_SPEEDS = np.linspace(math.log(1e-12), math.log(1e3), 30_001)
#: Thermal speed in U above which v^2 and f(v) can be checked. Derived: 1/v0^2 and v0^2 stay well
#: inside the range of doubles, 1e-308 to 1e308.
MIN_THERMAL_SPEED = 1e-140
#: Thermal speed in U below which v^2 and f(v) can be checked, for the same reason.
MAX_THERMAL_SPEED = 1e140
#: Edges of the panels in R over which moments of G(R) are summed. The origin is not recorded.
RADIUS_EDGES = np.concatenate([[0.0], np.geomspace(1e-2, 30.0, 60)])
#: Gauss nodes in each of these panels. The origin of the number is not recorded.
NODES_PER_PANEL = 12
#: Wave numbers in 1/d at which |F| <= 1 is looked at. Chosen: none, tiny, and usual ones.
WAVE_NUMBERS = [0.0, 1e-300, 1e-3, 0.1, 2.0]
#: Errors of an answer that an invariant may be violated by, beside rounding: the answer's own,
#: doubled for a difference and doubled again. The origin is not recorded.
SLACK_FACTOR = 4.0
#: Relative error of rounding by which an invariant may be violated, beside. The origin is not
#: recorded.
ROUNDING = 1e-12


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
    """Return bounds that every distribution keeps: <v^4> >= <v^2>^2, and <r^4> >= <r^2>^2."""
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

    def falls(x: FloatArray) -> float:
        with np.errstate(all="ignore"):
            return excess(x[:-1] - x[1:] * (1.0 + slack))

    for name in ("thermal_speed", "temperature"):
        if name in values:
            growth = falls(values[name][::-1])
            violations[f"{name} does not grow"] = Violation(growth, 0.0)
    for name in ("collisions", "msd"):
        if name in values:
            violations[f"{name} does not fall"] = Violation(falls(values[name]), 0.0)
            at_begin = excess(values[name][is_begin])
            violations[f"{name} begins at 0"] = Violation(at_begin, 0.0)
    # Bounces that throw tracers back and nearly stop them make D negative.
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
        below = excess(-density / max(density.max(), 1e-300))
        violations[f"density not negative, time {index}"] = Violation(below, 1.5 * error)
        violations[f"mass, time {index}"] = Violation(abs(mass - 1.0), 10.0 * error)
    return violations


def _of_position_density(solution: Solution) -> Violations:
    """Return that G(R) is not negative, and that <R^0> and <R^2> are 1, where it has no front."""
    error = _error_of(solution)
    radii, weights = panels_between(RADIUS_EDGES, NODES_PER_PANEL)
    fronts = solution.ballistic_front[1].sum(axis=1)
    is_smooth = (np.asarray(solution.times) > 0.0) & (fronts == 0.0)
    violations: Violations = {}
    for index in map(int, np.flatnonzero(is_smooth)):
        density = solution.scaled_position_density(radii)[index]
        violations[f"G not negative, time {index}"] = Violation(excess(-density), error)
        for power, allowed in ((0, 10.0 * error), (2, 100.0 * error)):
            moment = float(density @ (weights * radii**power))
            violations[f"<R^{power}> = 1, time {index}"] = Violation(abs(moment - 1.0), allowed)
    return violations


def _of_scattering(solution: Solution) -> Violations:
    """Return that the scattering function is 1 at k = 0, and not larger."""
    slack = _slack_of(solution)
    scattering = solution.intermediate_scattering(WAVE_NUMBERS)
    return {
        "|F| <= 1": Violation(excess(np.abs(scattering) - 1.0), slack),
        "F(0) = 1": Violation(largest_error(scattering[:, 0] - 1.0), slack),
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
