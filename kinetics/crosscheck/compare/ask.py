"""From data to a comparison: what is not given (restitution, density, start) is found in the data.

`compare_data` is what the command `lorentz compare` does.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kinetics.crosscheck.compare import theory
from kinetics.crosscheck.compare.causes import notes_of, tested_causes, wrong_unit
from kinetics.crosscheck.compare.fit import SECOND_MOMENTS, Fit, components_of, fit
from kinetics.crosscheck.compare.judge import (
    NO_SPREAD,
    Both,
    histogram_times,
    overall,
    rows_of,
    side_by_side,
    summary,
    tests_of,
)
from kinetics.crosscheck.compare.result import (
    OUTCOMES,
    Comparison,
    Explanation,
    Parameter,
    columns_of,
)
from kinetics.crosscheck.compare.statistics import chance, errors, hotelling
from kinetics.crosscheck.compare.theory import Point
from kinetics.crosscheck.data.read import read_sample
from kinetics.crosscheck.data.sample import R2, X2, N, Sample
from kinetics.crosscheck.data.tracks import Table
from kinetics.crosscheck.words import DIFFERS_ABOVE, Verdict, numeral
from kinetics.errors import InputError, short
from kinetics.validation import check_positive, check_restitution, one_of, real_number, refuse

if TYPE_CHECKING:
    from kinetics import Scene, Solution
    from particles import Ensemble

STARTS = ("auto", "gaussian", "monoenergetic", "data", "rest")
COLLISIONS_BEFORE = 3.0
"""Time in l/U from which on the density of the displacement is compared. Before, sharp fronts take
the solver long, and the displacement says no more than the speeds: few tracers have collided."""
DISPLACEMENT_TIMES = 3
"""Times at which it is compared, at most: the last of the densities' times, as they cost most."""
DENSITY_RTOL, DISPLACEMENT_RTOL = 1e-6, 1e-4
"""Asked of the solver for densities; those of the displacement cost more."""
_GAUSSIAN_ABOVE = 1e-3
"""p-value from which on speeds at time 0 may be a Gaussian's."""
_SCAN = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99)


def compare_data(
    data: "str | PathLike[str] | Sequence[Any] | Mapping[str, Any] | Ensemble | Sample | Any",
    restitution: float | None = None,
    number_density: float | None = None,
    initial: str = "auto",
    positions: str = "auto",
    speed_unit: float | str = 1.0,
    diameter: float = 1.0,
    explain: bool = True,
    time_unit: float | None = None,
    columns: Mapping[str, str] | str | None = None,
    timestep: float | None = None,
    tangential_restitution: float | None = None,
    dimension: int | None = None,
    bin_times: float | None = None,
    field: float = 0.0,
    show_progress: bool = False,
    type: str | int | None = None,
) -> Comparison:
    """Compare particle data with the kinetic equation, as `lorentz compare` does: kinetics.compare.

    Parameters
    ----------
    data : a file, several files (see data.formats.FORMATS), a DataFrame or a dictionary of arrays
        with columns time, x, y, vx, vy (in space also z, vz) and, where known, tracer and medium,
        (n,) each; arrays times (n_times,), positions and velocities (n_times, n_tracers,
        dimension); a table of averages time, v0, v0_error, msd, msd_error, (n_times,) each; a run
        of `simulate`, or a Sample
    restitution : 0 to 1; None: as an Ensemble says, or fitted to the data
    number_density : in the data's unit of length to the power -2 (-3 in space); None: as above
    initial : "gaussian", "monoenergetic", "data" (the speeds at time 0), or "auto": the first of
        these that the speeds at time 0 allow; a Gaussian, where there are none. In a field "rest"
    positions, speed_unit, diameter, time_unit, columns, timestep, dimension, bin_times, type : of
        files and of columns in memory, see data.tracks.Asked
    tangential_restitution : 0 to 1; None: as an Ensemble says, or 1. With another than 1, and for
        runs in space, averages are compared and densities are not
    field : a uniform acceleration along +x in U^2/d, of files and columns in memory. With a field
        restitution and number_density are needed
    explain : test what may explain a difference, and prepare figures; False is quicker
    show_progress : count the files that are read, on a terminal

    Raises
    ------
    InputError (a ValueError) : data that cannot be used, numbers out of range, and where the data
        cannot tell what was not given
    """
    sources = _sources(data)
    if sources is not None:
        sample = read_sample(
            sources, show_progress, positions=positions, speed_unit=speed_unit, diameter=diameter,
            time_unit=time_unit, columns=columns, timestep=timestep, dimension=dimension,
            bin_times=bin_times, with_field=field != 0, type=type,
        )  # fmt: skip
        if number_density is not None:
            dimension = sample.law.dimension
            number_density = check_positive("number_density", number_density)
            scaled = number_density * diameter**dimension
            if not 0.0 < scaled < math.inf:
                allowed = f"at diameter {diameter:g} it is {scaled:g} d^-{dimension}"
                refuse("number_density", number_density, allowed)
            number_density = scaled
    else:
        sample = _sample_of(data)
    sample = _with_law(sample, tangential_restitution, dimension, field)
    return compare_sample(sample, restitution, number_density, initial, explain)


def _sources(data: Any) -> list[Any] | None:
    """Files as paths and columns as tables; None for what is neither."""
    if isinstance(data, list | tuple):
        every = [_sources(one) for one in data]
        return None if None in every else [one for found in every if found for one in found]
    if isinstance(data, str | PathLike):
        return [Path(data)]
    if isinstance(data, Mapping):
        return [Table(data)]
    if hasattr(data, "columns") and hasattr(data, "iloc"):  # a DataFrame
        return [Table({name: data[name].to_numpy() for name in data.columns})]
    return None


def _sample_of(data: Any) -> Sample:
    """The sample of a run of `simulate`, lengths in d; InputError for anything else."""
    if isinstance(data, Sample):
        return data
    from particles import Ensemble

    if not isinstance(data, Ensemble):
        refuse("data", data, "it must be a file, several files, columns or a run of simulate")
    from kinetics.crosscheck.data.summaries import from_ensemble

    return from_ensemble(data).rescaled(1.0, data.medium.diameter)


def _with_law(
    sample: Sample, tangential_restitution: float | None, dimension: int | None, field: float
) -> Sample:
    """The sample, compared with the law of this tangential restitution, in this field."""
    law = sample.law
    if tangential_restitution is not None:
        allowed = "it must be a number from 0 (all tangential velocity lost) to 1 (smooth)"
        name = "tangential_restitution"
        checked = real_number(name, tangential_restitution, 0.0, 1.0, allowed)
        law = replace(law, tangential_restitution=checked)
    if dimension is not None and dimension != law.dimension:
        refuse("dimension", dimension, f"the data are of dimension {law.dimension}")
    if field:
        allowed = "it must be a finite number, 0 or more: the field is along +x"
        law = replace(law, field=real_number("field", field, 0.0, allowed=allowed))
        if sample.sums.shape[2] <= X2:
            refuse("field", field, "the run is one without a field")
    return replace(sample, law=law)


def compare_sample(
    sample: Sample,
    restitution: float | None = None,
    number_density: float | None = None,
    initial: str = "auto",
    explain: bool = True,
) -> Comparison:
    """Compare a sample with the kinetic equation; number_density in d^-2, the rest as above."""
    told, law, path = sample.told, sample.law, None
    restitution = told.get("restitution") if restitution is None else restitution
    number_density = told.get("number_density") if number_density is None else number_density
    if restitution is not None:
        restitution = check_restitution(restitution)
    if number_density is not None:
        path = law.free_path(check_positive("number_density", number_density))
    start = _start(sample, told.get("initial", "auto") if initial == "auto" else initial)
    if law.field and (restitution is None or path is None or sample.tabulated):
        raise InputError("field: restitution and number_density must be given, nothing is fitted")
    found = None
    if restitution is None or path is None:
        found = fitted_to(sample, restitution, path, start)
        point = found.point
    else:
        point = Point(restitution, path, start)
    names = tuple(theory.IN_FIELD) if law.field else theory.AVERAGES
    solution = theory.solved_averages(point, law, sample.times, names)
    densities = _densities(point, sample) if law.smooth_disks and not sample.tabulated else {}
    return _judged(side_by_side(solution, sample, names, found, densities), explain)


def _judged(both: Both, explain: bool) -> Comparison:
    """The rows, tests, verdict and explanations of data and theory side by side."""
    sample, scene = both.sample, both.solution.scene
    rows, tests = rows_of(both), tuple(tests_of(both))
    verdict = overall(rows, tests)
    unit = wrong_unit(sample, scene.initial)
    explanations, figures = _explained(both, verdict, unit) if explain else ((), {})
    first = explanations[0] if explanations else None
    best = unit or (first if first and first.outcome == "explains" and first.headline else None)
    start = start_in_words(scene.initial)
    return Comparison(
        verdict=verdict,
        summary=summary(both, tests, verdict, best, start),
        columns=columns_of(rows),
        tests=tests,
        explanations=explanations,
        parameters=_parameters(scene, both.found, unit),
        initial=start,
        samples=0 if sample.tabulated else int(sample.samples.max()),
        groups=0 if sample.tabulated else sample.groups,
        grouping=sample.grouping,
        warnings=sample.warnings,
        names=sample.names,
        figures=figures,
    )


def _explained(
    both: Both, verdict: Verdict, unit: Explanation | None
) -> tuple[tuple[Explanation, ...], dict[str, Any]]:
    """What explains a difference, the likeliest first; and the data of the figures."""
    from kinetics.crosscheck.compare.page import figures_of

    if unit is not None:
        return (unit,), figures_of(both)
    if both.sample.law.field:
        text = (
            "In a field the averages along and across it are compared; what may explain a "
            "difference is not looked for. Relative differences are of the "
            "largest value of all times."
        )
        return (Explanation("field", "noted", text, False),), figures_of(both)
    tested, expected = list[Explanation](), None
    if verdict in (Verdict.DIFFERS, Verdict.UNCLEAR):
        tested, expected = tested_causes(both)
    # Python's sort keeps the order of those of one outcome: the likeliest stays first.
    ordered = sorted([*tested, *notes_of(both)], key=lambda item: [*OUTCOMES].index(item.outcome))
    return tuple(ordered), figures_of(both, expected)


def _parameters(
    scene: "Scene", found: Fit | None, unit: Explanation | None
) -> dict[str, Parameter]:
    """The numbers of the scene; those that were fitted have standard errors."""
    free, left = (found.free, found.chi_square) if found else ((), None)
    rejected = left is not None and left.p_value < chance(DIFFERS_ABOVE)
    words = "fitted to v₀ and ⟨r²⟩ over time"

    def parameter(name: str, value: float, told: str, fitted: str) -> Parameter:
        if name not in free or found is None:
            return Parameter(value, None, told)
        if unit is not None or rejected:
            why = "a unit is wrong"
            if unit is None and left is not None:
                why = (
                    f"the model does not fit (chi-square {numeral(left.value, '.4g')} with "
                    f"{left.freedom} degrees of freedom, p = {numeral(left.p_value, '.2g')})"
                )
            used = numeral(value, ".5g")
            return Parameter(None, None, f"no value: {why}; the theory that is shown has {used}")
        fit_value, error = found.value(name)
        return Parameter(value, error * value / fit_value if fit_value else error, fitted)

    inverse = "1/(2dρ₀)" if scene.dimension == 2 else "1/(πd²ρ₀)"
    by_density = f"{inverse.replace('ρ₀', 'l')}, l {words}"
    return {
        "restitution": parameter("restitution", scene.restitution, "told", words),
        "number_density": parameter("path", scene.number_density, "told", by_density),
        "mean_free_path": parameter("path", scene.mean_free_path, inverse, words),
    }


def _densities(point: Point, sample: Sample) -> "dict[str, Solution]":
    """The densities by name, that of the displacement at late times and from a named start."""
    from kinetics import SolverStatus

    times, law = sample.times[histogram_times(sample)], sample.law
    found = {}
    if times.size:
        found[theory.SPEED] = theory.solved(point, law, times, (theory.SPEED,), DENSITY_RTOL)
    late = times[times > COLLISIONS_BEFORE * point.path][-DISPLACEMENT_TIMES:]
    # From hundreds of single speeds it would take long.
    if late.size and not isinstance(point.start, theory.SampledStart):
        known = theory.solved(point, law, late, (theory.DISPLACEMENT,), DISPLACEMENT_RTOL)
        if known.status is SolverStatus.CONVERGED:  # or it would be judged wrongly
            found[theory.DISPLACEMENT] = known
    return found


# -- what was not told -----------------------------------------------------------------------------


def _start(sample: Sample, initial: str) -> Any:
    field = sample.law.field
    if one_of("initial", initial, STARTS) == "rest" and not field:
        refuse("initial", initial, "without a field nothing would move")
    if initial in ("gaussian", "monoenergetic", "rest"):
        return initial
    if sample.start is None:
        if initial == "data":
            raise InputError("initial: 'data' needs velocities at time 0, and there are none")
        return "gaussian"
    squares = sample.start.squares
    if squares.size == 0 and field:
        return "rest"
    if squares.size == 0:
        raise InputError("data: every speed at time 0 is zero; nothing will move")
    if initial == "auto":
        if np.all(np.abs(squares - 1) < 1e-6):
            return "monoenergetic"
        if gaussian_p_value(sample) >= _GAUSSIAN_ABOVE:
            return "gaussian"
    if field:
        raise InputError(
            "initial: in a field it must be rest, gaussian or monoenergetic; the speeds at time 0 "
            "are none of these"
        )
    return theory.SampledStart(sample.start)


def gaussian_p_value(sample: Sample) -> float:
    """p-value of the speeds at time 0 under the Gaussian start: <v^2> = 2 U^2 and <v^4> = 8 U^4.

    In space 3 U^2 and 15 U^4. 0 where all speeds are the same.
    """
    if sample.start is not None and sample.start.squares.size < 2:
        return 0.0
    expectation = theory.Expectation(sample.at([0]), ("thermal_speed", "a2"))
    data = expectation.values[:, 0] - [np.sqrt(sample.law.dimension), 0.0]
    result = hotelling(data, expectation.replicates[:, :, 0])
    return 0.0 if result is None else result.p_value


def fitted_to(sample: Sample, restitution: float | None, path: float | None, start: Any) -> Fit:
    """Restitution and l, whichever is None, by a fit. InputError where the data cannot tell."""
    words = {"restitution": "restitution", "path": "number density"}
    free = [name for name, told in zip(words, (restitution, path), strict=True) if told is None]
    wanted = " and ".join(words[name] for name in free)
    expectation = theory.Expectation(sample, theory.AVERAGES)
    groups, spread = sample.groups, errors(expectation.replicates)
    with np.errstate(invalid="ignore"):
        usable = (spread > NO_SPREAD * np.abs(expectation.values)) & np.isfinite(spread)
    usable &= sample.times > 0  # the start does not depend on what is looked for
    components = components_of(theory.AVERAGES, usable, sample, len(free))
    if components.tested.size < len(free) or groups < len(free) + 3:
        raise InputError(
            f"data: {wanted} cannot be found in so few times and groups "
            f"({groups} groups); give --restitution and --number-density"
        )
    guess = _early_log_path(sample)
    told = Point(
        0.5 if restitution is None else restitution,
        math.exp(guess) if path is None else path,
        start,
    )
    starts: list[list[float]] = [[e] for e in _SCAN]
    if path is None:
        starts = [[guess + shift] for shift in (-1.5, 0.0, 1.5)]
        if restitution is None:
            starts = [[e, guess + shift] for e in _SCAN[1::2] for shift in (-1.0, 1.0)]
    if components.logarithms:  # without the others, which cost more, until the place is known
        second = theory.Expectation(sample, SECOND_MOMENTS)
        mine = usable[np.isin(theory.AVERAGES, SECOND_MOMENTS)]
        only = components_of(SECOND_MOMENTS, mine, sample, len(free))
        near = fit(second, told, free, only, starts)
        if near is not None:
            at = {"restitution": near.point.restitution, "path": math.log(near.point.path)}
            starts = [[at[name] for name in free]]
    found = fit(expectation, told, free, components, starts)
    if found is None or not np.all(np.isfinite(found.errors)):
        raise InputError(f"data: {wanted} could not be fitted; give it as an option")
    return found


def _early_log_path(sample: Sample) -> float:
    """ln l to start from: a third of the largest root mean square displacement, in d."""
    total = sample.sums.sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        msd = sample.length_scale**2 * total[:, R2] / total[:, N]
    size = float(np.sqrt(np.nanmax(msd))) if np.any(np.isfinite(msd)) else 1.0
    return float(np.log(min(max(size / 3, 1e-6), 1e6)))


def start_in_words(initial: Any) -> str:
    """The start of a scene as the middle of a sentence."""
    if isinstance(initial, theory.SampledStart):
        return "the data's own speeds at time 0"
    named = {
        "rest": "rest",
        "gaussian": "a Gaussian start",
        "monoenergetic": "a start with all speeds U",
    }
    known = isinstance(initial, str) and initial in named
    return named[initial] if known else f"the start {short(initial)}"
