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

from kinetics.crosscheck.compare import judge, theory
from kinetics.crosscheck.compare.causes import explained, start_in_words, wrong_unit
from kinetics.crosscheck.compare.fit import SECOND_MOMENTS, Fit, components_of, fit
from kinetics.crosscheck.compare.result import Comparison, Parameter
from kinetics.crosscheck.compare.statistics import chance, errors, hotelling, spread_out
from kinetics.crosscheck.compare.theory import AVERAGES, Expectation, Point
from kinetics.crosscheck.data.read import read_sample
from kinetics.crosscheck.data.sample import X2, Sample
from kinetics.crosscheck.data.tracks import Table
from kinetics.crosscheck.words import DIFFERS_ABOVE, numeral
from kinetics.errors import InputError
from kinetics.validation import check_positive, check_restitution, one_of, real_number, refuse

if TYPE_CHECKING:
    from kinetics import Solution
    from particles import Ensemble

HISTOGRAM_TIMES = 6
"""Times at which densities are compared, at most: each takes the solver some 0.1 s."""
COLLISIONS_BEFORE, DISPLACEMENT_TIMES = 3.0, 3
"""Time in l/U from which on the density of the displacement is compared, at most at so many times,
the last: before, sharp fronts take the solver long, and few tracers have collided."""
DENSITY_RTOL, DISPLACEMENT_RTOL = 1e-6, 1e-4
"""Asked of the solver for densities; those of the displacement cost more."""
_GAUSSIAN_ABOVE = 1e-3
"""p-value from which on speeds at time 0 may be a Gaussian's."""
_SCAN = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99)
_OWN_START = "The theory starts from the data's own speeds: early densities' p-values are too high."


def compare_data(
    data: "str | PathLike[str] | Sequence[Any] | Mapping[str, Any] | Ensemble | Sample | Any",
    restitution: float | None = None, number_density: float | None = None, initial: str = "auto",
    positions: str = "auto", speed_unit: float | str = 1.0, diameter: float = 1.0,
    explain: bool = True, time_unit: float | None = None,
    columns: Mapping[str, str] | str | None = None, timestep: float | None = None,
    tangential_restitution: float | None = None, dimension: int | None = None,
    bin_times: float | None = None, field: float = 0.0, show_progress: bool = False,
    type: str | int | None = None,
) -> Comparison:  # fmt: skip
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
        restitution and number_density are needed, and causes are not looked for
    explain : test what may explain a difference; False is quicker
    show_progress : count the files that are read, on a terminal

    Raises
    ------
    InputError (a ValueError) : data that cannot be used, numbers out of range, and where the data
        cannot tell what was not given
    """
    if (sources := _sources(data)) is not None:
        sample = read_sample(
            sources, show_progress, positions=positions, speed_unit=speed_unit, diameter=diameter,
            time_unit=time_unit, columns=columns, timestep=timestep, dimension=dimension,
            bin_times=bin_times, with_field=field != 0, type=type,
        )  # fmt: skip
        if number_density is not None:  # checked once more below, as it is then
            number_density = check_positive("number_density", number_density)
            number_density *= diameter**sample.law.dimension
    else:
        sample = _sample_of(data)
    law, told, path, found = sample.law, sample.told, None, None
    if tangential_restitution is not None:
        checked = real_number("tangential_restitution", tangential_restitution, 0.0, 1.0)
        law = replace(law, tangential_restitution=checked)
    if dimension is not None and dimension != law.dimension:
        refuse("dimension", dimension, f"the data are of dimension {law.dimension}")
    if field:
        law = replace(law, field=real_number("field", field, 0.0))
        if sample.sums.shape[2] <= X2:
            refuse("field", field, "the data are not of tracers in a field")
    sample = replace(sample, law=law)
    restitution = told.get("restitution") if restitution is None else restitution
    number_density = told.get("number_density") if number_density is None else number_density
    if restitution is not None:
        restitution = check_restitution(restitution)
    if number_density is not None:
        path = law.free_path(check_positive("number_density", number_density))
    start = _start(sample, told.get("initial", "auto") if initial == "auto" else initial)
    if restitution is None or path is None:
        if law.field:
            raise InputError("field: restitution and number_density must be given with it")
        found = fitted_to(sample, restitution, path, start)
        expectation, point = found.expectation, found.point
    else:
        expectation = Expectation(sample, theory.IN_FIELD if law.field else AVERAGES)
        point = Point(restitution, path, start)
    return _judged(judge.Both(expectation, point, found, _densities(point, sample)), explain)


def _judged(both: judge.Both, explain: bool) -> Comparison:
    """The rows, tests, verdict and explanations of data and theory side by side."""
    sample, start = both.sample, both.point.start
    rows, tests = tuple(judge.rows_of(both)), tuple(judge.tests_of(both))
    # Rows without spread no test can hold.
    words = [*(test.verdict for test in tests), *(r.verdict for r in rows if r.sigmas is None)]
    verdict, unit = judge.worst_of(words), wrong_unit(sample, start)
    explanations = tuple(explained(both, verdict, unit)) if explain else ()
    likely = (x for x in explanations[:1] if x.outcome == "explains" and x.headline)
    best = unit or next(likely, None)
    note = (_OWN_START,) if both.point.own_start and both.histograms else ()
    tracers, groups = (0, 0) if sample.tabulated else (int(sample.samples.max()), sample.groups)
    return Comparison(
        verdict=verdict, summary=judge.summary(both, tests, verdict, best, start_in_words(start)),
        parameters=_parameters(both, unit is not None), initial=start_in_words(start),
        samples=tracers, groups=groups, grouping=sample.grouping, names=sample.names,
        warnings=(*sample.warnings, *note), tests=tests, explanations=explanations, numbers=rows,
    )  # fmt: skip


def _sources(data: Any) -> list[Any] | None:
    """Files as paths and columns as tables; None for what is neither."""
    if isinstance(data, list | tuple):
        every = [_sources(one) for one in data]
        return None if None in every else [one for found in every if found for one in found]
    if isinstance(data, str | PathLike):
        return [Path(data)]
    if hasattr(data, "columns") and hasattr(data, "iloc"):  # a DataFrame
        data = {name: data[name].to_numpy() for name in data.columns}
    return [Table(data)] if isinstance(data, Mapping) else None


def _sample_of(data: Any) -> Sample:
    """The sample of a run of `simulate`, lengths in d; InputError for anything else."""
    if isinstance(data, Sample):
        return data
    from particles import Ensemble

    if not isinstance(data, Ensemble):
        refuse("data", data, "it must be a file, several files, columns or a run of simulate")
    from kinetics.crosscheck.data.summaries import from_ensemble

    return from_ensemble(data).rescaled(1.0, data.medium.diameter)


def _parameters(both: judge.Both, wrong_unit: bool) -> dict[str, Parameter]:
    """The numbers of the theory; those that were fitted have standard errors."""
    point, law, found = both.point, both.sample.law, both.found
    left, why = found.chi_square if found else None, "a unit is wrong" if wrong_unit else ""
    if left is not None and not why and left.p_value < chance(DIFFERS_ABOVE):
        why = f"the model does not fit (p = {numeral(left.p_value, '.2g')})"

    def parameter(name: str, value: float, told: str = "told", fitted: str = "") -> Parameter:
        if found is None or name not in found.free:
            return Parameter(value, None, told)
        if why:
            used = numeral(value, ".5g")
            return Parameter(None, None, f"no value: {why}; the theory that is shown has {used}")
        at, error = found.value(name)
        words = f"{fitted}fitted to v₀ and ⟨r²⟩ over time"
        return Parameter(value, error * value / at if at else error, words)

    by_path = "1/(2dl)" if law.dimension == 2 else "1/(πd²l)"
    return {
        "restitution": parameter("restitution", point.restitution),
        "number_density": parameter("path", law.free_path(point.path), fitted=f"{by_path}, l "),
        "mean_free_path": parameter("path", point.path, by_path.replace("l", "ρ₀")),
    }


def _densities(point: Point, sample: Sample) -> "dict[str, Solution]":
    """The densities by name, that of the displacement at late times and from a named start."""
    from kinetics import SolverStatus

    if sample.tabulated or not sample.law.smooth_disks:
        return {}
    later, found = sample.times[sample.times > 0], {}
    times = later[spread_out(later.size, HISTOGRAM_TIMES)]
    if times.size:
        found[theory.SPEED] = theory.solved(point, sample.law, times, (theory.SPEED,), DENSITY_RTOL)
    late = times[times > COLLISIONS_BEFORE * point.path][-DISPLACEMENT_TIMES:]
    # From hundreds of single speeds it would take long.
    if late.size and not point.own_start:
        known = theory.solved(point, sample.law, late, (theory.DISPLACEMENT,), DISPLACEMENT_RTOL)
        if known.status is SolverStatus.CONVERGED:  # or it would be judged wrongly
            found[theory.DISPLACEMENT] = known
    return found


# -- what was not told -----------------------------------------------------------------------------


def _start(sample: Sample, initial: str) -> Any:
    field = sample.law.field
    if one_of("initial", initial, ("auto", "gaussian", "monoenergetic", "data", "rest")) == "rest":
        if not field:
            refuse("initial", initial, "without a field nothing would move")
        return initial
    if initial in ("gaussian", "monoenergetic"):
        return initial
    if sample.start is None:
        if initial == "data":
            refuse("initial", initial, "there are no velocities at time 0")
        return "gaussian"
    squares = sample.start.squares
    if squares.size == 0:
        if not field:
            raise InputError("data: every speed at time 0 is zero; nothing will move")
        return "rest"
    if initial == "auto":
        if np.all(np.abs(squares - 1) < 1e-6):
            return "monoenergetic"
        if squares.size > 1 and gaussian_p_value(sample) >= _GAUSSIAN_ABOVE:
            return "gaussian"
    if field:
        refuse("initial", initial, "in a field the start must be rest, gaussian or monoenergetic")
    return theory.SampledStart(sample.start)


def gaussian_p_value(sample: Sample) -> float:
    """p-value of <v^2> and <v^4> at time 0 under the Gaussian start."""
    expectation = Expectation(sample.at([0]), ("thermal_speed", "a2"))
    data = expectation.values[:, 0] - [np.sqrt(sample.law.dimension), 0.0]
    result = hotelling(data, expectation.replicates[:, :, 0])
    return 0.0 if result is None else result.p_value


def fitted_to(sample: Sample, restitution: float | None, path: float | None, start: Any) -> Fit:
    """Restitution and l, whichever is None, by a fit. InputError where the data cannot tell."""
    words = {"restitution": "restitution", "path": "number_density"}
    free = [name for name, told in zip(words, (restitution, path), strict=True) if told is None]
    wanted = " and ".join(words[name] for name in free)
    expectation, groups = Expectation(sample, AVERAGES), sample.groups
    usable = judge.with_spread(errors(expectation.replicates), expectation.values)
    usable &= sample.times > 0  # the start does not depend on what is looked for
    components = components_of(AVERAGES, usable, groups, len(free))
    if components[0].size < len(free) or groups < len(free) + 3:
        raise InputError(f"data: too few times or groups ({groups}) to find {wanted}; give it")
    # l to start from: a third of the largest root mean square displacement
    msd = expectation.values[AVERAGES.index("msd")]
    size = math.sqrt(max(msd[np.isfinite(msd)], default=9.0)) / 3
    guess = math.log(min(max(size, 1e-6), 1e6))
    e, told = (0.5 if restitution is None else restitution), path or math.exp(guess)
    known = Point(e, told, start)
    starts: list[list[float]] = [[e] for e in _SCAN]
    if path is None:
        starts = [[guess + shift] for shift in (-1.5, 0.0, 1.5)]
        if restitution is None:
            starts = [[e, guess + shift] for e in _SCAN[1::2] for shift in (-1.0, 1.0)]
    # Without the other averages, which cost more, until the place is known.
    second = Expectation(sample, SECOND_MOMENTS)
    mine = usable[np.isin(AVERAGES, SECOND_MOMENTS)]
    only = components_of(SECOND_MOMENTS, mine, groups, len(free))
    if near := fit(second, known, free, only, starts):
        at = {"restitution": near.point.restitution, "path": math.log(near.point.path)}
        starts = [[at[name] for name in free]]
    found = fit(expectation, known, free, components, starts)
    if found is None or not np.all(np.isfinite(found.errors)):
        raise InputError(f"data: {wanted} could not be fitted; give it")
    return found
