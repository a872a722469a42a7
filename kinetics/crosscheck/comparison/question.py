"""What was not told, found in the data: restitution, density, and the start."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.comparison.fit import Fit, choose_components, fit
from kinetics.crosscheck.comparison.result import Comparison, Parameter
from kinetics.crosscheck.comparison.sample import Sample
from kinetics.crosscheck.comparison.statistics import errors, hotelling
from kinetics.crosscheck.comparison.theory import (
    DENSITY_RTOL,
    DISPLACEMENT,
    DISPLACEMENT_RTOL,
    RTOL,
    SPEED,
    Expectation,
    SampledStart,
    averages,
    sampled_start,
    scene,
)
from kinetics.errors import InputError, check_positive, check_restitution

if TYPE_CHECKING:
    from kinetics import Solution

Array = NDArray[np.float64]

STARTS = ("auto", "gaussian", "monoenergetic", "data")
COLLISIONS_BEFORE = 3.0
"""Time in l/U from which on the displacement's density is compared: sharp fronts are costly, and
while nearly nobody has collided it says what the speeds say."""
DISPLACEMENT_TIMES = 3
"""Times at which it is compared, at most: the last of the densities' times."""
_GAUSSIAN_ABOVE = 1e-3
"""p-value from which on speeds at time 0 may be a Gaussian's."""
_SCAN = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99)
_LONGEST_PATH = 1e9


@dataclass(frozen=True, eq=False)
class Question:
    """A scene for a sample, with where its numbers come from; `found` where some were fitted."""

    restitution: float
    free_path: float
    initial: Any
    parameters: dict[str, Parameter]
    found: Fit | None

    def solve(self, times: Array) -> "Solution":
        """The solution with every average that can be compared."""
        return self._solve(times, averages(), RTOL)

    def solve_densities(self, times: Array) -> "dict[str, Solution]":
        """The densities at these times by name, that of the displacement at late ones.

        And only from a start with a name.
        """
        from kinetics import SolverStatus

        found = {}
        if times.size:
            found[SPEED] = self._solve(times, (SPEED,), DENSITY_RTOL)
        late = times[times > COLLISIONS_BEFORE * self.free_path][-DISPLACEMENT_TIMES:]
        # From hundreds of single speeds it would take long.
        if late.size and not isinstance(self.initial, SampledStart):
            displacements = self._solve(late, (DISPLACEMENT,), DISPLACEMENT_RTOL)
            if displacements.status is SolverStatus.CONVERGED:  # or it would be judged wrongly
                found[DISPLACEMENT] = displacements
        return found

    def _solve(self, times: Array, outputs: tuple[str, ...], rtol: float) -> "Solution":
        from kinetics import solve

        asked = scene(self.restitution, self.free_path, self.initial, times, outputs)
        return solve(asked, rtol=rtol)


def compare_sample(
    sample: Sample,
    restitution: float | None = None,
    number_density: float | None = None,
    initial: str = "auto",
    explain: bool = True,
) -> Comparison:
    """Hold a sample against the kinetic equation; None is taken from an Ensemble's own words, or
    else found in the data.

    initial : "gaussian", "monoenergetic", "data" (its speeds at time 0), or "auto": the first of
        these that the speeds at time 0 allow; a Gaussian, where there are none. InputError for
        numbers out of range, and where the data cannot tell what was not told.
    """
    from kinetics.crosscheck.comparison.differences import histogram_times
    from kinetics.crosscheck.comparison.judging import compare

    if restitution is None:
        restitution = sample.told.get("restitution")
    if number_density is None:
        number_density = sample.told.get("number_density")
    if initial == "auto":
        initial = sample.told.get("initial", "auto")
    question = ask(sample, restitution, number_density, initial)
    solution = question.solve(sample.times)
    densities = question.solve_densities(sample.times[histogram_times(sample)])
    return compare(solution, sample, explain, densities, question.parameters, question.found)


def ask(
    sample: Sample, restitution: float | None, number_density: float | None, initial: str
) -> Question:
    """The question that a sample puts to the solver."""
    if restitution is not None:
        restitution = check_restitution(restitution)
    path = None
    if number_density is not None:
        path = 1 / (2 * check_positive("number_density", number_density))
    if initial not in STARTS:
        raise InputError(f"initial: got {initial!r}; it must be one of {', '.join(STARTS)}")
    start = _start(sample, initial)
    found = None
    if restitution is None or path is None:
        found = find(sample, restitution, path, start)
        values = dict(zip(found.names, found.values, strict=True))
        restitution = float(values["restitution"]) if restitution is None else restitution
        path = float(np.exp(values["log_path"])) if "log_path" in values else path
    assert restitution is not None
    assert path is not None
    return Question(restitution, path, start, _parameters(restitution, path, found), found)


def _parameters(restitution: float, path: float, found: Fit | None) -> dict[str, Parameter]:
    errors = {} if found is None else dict(zip(found.names, found.errors, strict=True))
    e, l_error = errors.get("restitution"), errors.get("log_path")
    density = 1 / (2 * path)
    fitted = "fitted to the averages over time"
    return {
        "restitution": Parameter(
            restitution, None if e is None else float(e), "told" if e is None else fitted
        ),
        "number_density": Parameter(
            density,
            None if l_error is None else float(l_error) * density,
            "told" if l_error is None else f"1/(2dl), l {fitted}",
        ),
        "mean_free_path": Parameter(
            path,
            None if l_error is None else float(l_error) * path,
            "1/(2dρ₀)" if l_error is None else fitted,
        ),
    }


def _start(sample: Sample, initial: str) -> Any:
    if initial in ("gaussian", "monoenergetic"):
        return initial
    if sample.start is None:
        if initial == "data":
            raise InputError("initial: 'data' needs velocities at time 0, and there are none")
        return "gaussian"
    squares = sample.start.squares
    if squares.size == 0:
        raise InputError("data: every speed at time 0 is zero; nothing will move")
    if initial == "auto":
        if np.all(np.abs(squares - 1) < 1e-6):
            return "monoenergetic"
        if gaussian_p_value(sample) >= _GAUSSIAN_ABOVE:
            return "gaussian"
    return sampled_start(sample)


def gaussian_p_value(sample: Sample) -> float:
    """p-value of the speeds at time 0 under the Gaussian start: <v^2> = 2 U^2 and <v^4> = 8 U^4."""
    expectation = Expectation(sample.at([0]), ("thermal_speed", "a2"))
    data = expectation.values[:, 0] - [np.sqrt(2), 0.0]
    result = hotelling(data, expectation.replicates[:, :, 0])
    return 0.0 if result is None else result.p_value


def theory_of(
    expectation: Expectation,
    names: Sequence[str],
    at: Array,
    restitution: float | None,
    path: float | None,
    initial: Any,
) -> tuple[Array, Array]:
    """The theory at fitted parameters, the others as told; see Expectation.theory."""
    values = dict(zip(names, at, strict=True))
    e = float(values.get("restitution", restitution if restitution is not None else np.nan))
    log_path = values.get("log_path")
    return expectation.theory(
        e, float(np.exp(log_path)) if log_path is not None else float(path or np.nan), initial
    )


def find(sample: Sample, restitution: float | None, path: float | None, initial: Any) -> Fit:
    """Fit what is None. InputError where the data cannot tell it."""
    names = [
        name for name, value in (("restitution", restitution), ("log_path", path)) if value is None
    ]
    expectation = Expectation(sample, averages())
    groups = sample.groups
    flat = expectation.replicates.reshape(groups, -1)
    spread = errors(flat).reshape(expectation.values.shape)
    with np.errstate(invalid="ignore"):
        usable = (spread > 1e-9 * np.abs(expectation.values)) & np.isfinite(spread)
    usable &= sample.times > 0  # the start does not depend on what is looked for
    components = choose_components(usable, groups, len(names))
    wanted = " and ".join("restitution" if n == "restitution" else "number density" for n in names)
    if components.size < len(names) or groups < len(names) + 3:
        raise InputError(
            f"data: {wanted} cannot be found in so few times and groups "
            f"({groups} groups); give --restitution and --number-density"
        )

    def model(at: Array) -> tuple[Array, Array]:
        values, moved = theory_of(expectation, names, at, restitution, path, initial)
        return values.ravel(), moved.reshape(*moved.shape[:-2], -1)

    guess = np.log(_early_path(sample))
    starts: list[list[float]]
    if names == ["restitution"]:
        starts = [[e] for e in _SCAN]
    elif names == ["log_path"]:
        starts = [[guess + shift] for shift in (-1.5, 0.0, 1.5)]
    else:
        starts = [[e, guess + shift] for e in _SCAN[1::2] for shift in (-1.0, 1.0)]
    limits = {"restitution": (0.0, 1.0), "log_path": (-20.0, float(np.log(_LONGEST_PATH)))}
    found = fit(
        names, model, (expectation.values.ravel(), flat), components, starts,
        [limits[n][0] for n in names], [limits[n][1] for n in names],
    )  # fmt: skip
    if found is None or not np.all(np.isfinite(found.errors)):
        raise InputError(f"data: {wanted} could not be fitted; give it as an option")
    return found


def _early_path(sample: Sample) -> float:
    """A free path to start from: where <r^2> stops growing as t^2, or the size of r at the end."""
    total = sample.sums.sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        msd = sample.length_scale**2 * total[:, 3] / total[:, 0]
    size = float(np.sqrt(np.nanmax(msd))) if np.any(np.isfinite(msd)) else 1.0
    return min(max(size / 3, 1e-6), 1e6)
