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
from numpy.typing import NDArray

from kinetics.crosscheck.comparison import theory
from kinetics.crosscheck.comparison.data_and_theory import NO_SPREAD, histogram_times
from kinetics.crosscheck.comparison.fit import (
    SECOND_MOMENTS,
    Fit,
    Model,
    Unknown,
    components_of,
    fit,
)
from kinetics.crosscheck.comparison.judging import compare
from kinetics.crosscheck.comparison.result import Comparison
from kinetics.crosscheck.comparison.sample import R2, X2, N, Sample
from kinetics.crosscheck.comparison.statistics import errors, hotelling
from kinetics.errors import InputError
from kinetics.validation import check_positive, check_restitution, one_of, real_number, refuse

if TYPE_CHECKING:
    from kinetics import Solution
    from particles import Ensemble

Array = NDArray[np.float64]

STARTS = ("auto", "gaussian", "monoenergetic", "data", "rest")
COLLISIONS_BEFORE = 3.0
"""Time in l/U from which on the density of the displacement is compared. Before, sharp fronts take
the solver long, and the displacement says no more than the speeds: few tracers have collided."""
DISPLACEMENT_TIMES = 3
"""Times at which it is compared, at most: the last of the densities' times, since they cost
most."""
_GAUSSIAN_ABOVE = 1e-3
"""p-value from which on speeds at time 0 may be a Gaussian's."""
_SCAN = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99)
_LONGEST_PATH = 1e9


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
    columns: Mapping[str, str] | None = None,
    timestep: float | None = None,
    tangential_restitution: float | None = None,
    dimension: int | None = None,
    bin_times: float | None = None,
    field: float = 0.0,
    show_progress: bool = False,
) -> Comparison:
    """Compare particle data with the kinetic equation, as `lorentz compare` does: kinetics.compare.

    Parameters
    ----------
    data : a file, several files (see data.columns.FORMATS), a DataFrame or a dictionary of arrays
        with columns time, x, y, vx, vy (in space also z, vz) and, where known, tracer and medium,
        (n,) each; arrays times (n_times,), positions and velocities (n_times, n_tracers,
        dimension); a table of averages time, v0, v0_error, msd, msd_error, (n_times,) each; a run
        of `simulate`, or a Sample
    restitution : 0 to 1; None: as an Ensemble says, or fitted to the data
    number_density : in the data's unit of length to the power -2 (-3 in space); None: as above
    initial : "gaussian", "monoenergetic", "data" (the speeds at time 0), or "auto": the first of
        these that the speeds at time 0 allow; a Gaussian, where there are none. In a field "rest"
    positions, speed_unit, diameter, time_unit, columns, timestep, dimension, bin_times : of files
        and of columns in memory, see data.columns.Asked
    tangential_restitution : 0 to 1; None: as an Ensemble says, or 1. With another than 1, and for
        runs in space, averages are compared and densities are not
    field : a uniform acceleration along +x in U^2/d, of files and columns in memory. With a field
        restitution and number_density are needed
    explain : test what may explain a difference, and prepare figures; False is quicker
    show_progress : count the rows that are read, on a terminal

    Raises
    ------
    InputError (a ValueError) : data that cannot be used, numbers out of range, and where the data
        cannot tell what was not given
    """
    if (sources := _sources(data)) is not None:
        from kinetics.crosscheck.comparison.data.read import read_sample

        data = read_sample(
            sources, show_progress, positions=positions, speed_unit=speed_unit, diameter=diameter,
            time_unit=time_unit, columns=columns, timestep=timestep, dimension=dimension,
            bin_times=bin_times, with_field=field != 0,
        )  # fmt: skip
        if number_density is not None:
            number_density = in_diameters(number_density, diameter, data.law.dimension)
    elif not isinstance(data, Sample):
        data = _of_run(data)
    data = _with_law(data, tangential_restitution, dimension, field)
    return compare_sample(data, restitution, number_density, initial, explain)


def _of_run(data: Any) -> Sample:
    """The sample of a run of `simulate`; InputError for anything else."""
    from particles import Ensemble

    if not isinstance(data, Ensemble):
        refuse("data", data, "it must be a file, several files, columns or a run of simulate")
    from kinetics.crosscheck.comparison.data.ensemble_files import from_ensemble

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


def _sources(data: Any) -> list[Any] | None:
    """Files as paths and columns as tables; None for what is neither."""
    from kinetics.crosscheck.comparison.data.columns import Table

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


def in_diameters(number_density: float, diameter: float, dimension: int = 2) -> float:
    """A number density per d^2, or d^3, from one in the unit that the diameter is given in.

    InputError where it is beyond double precision.
    """
    number_density = check_positive("number_density", number_density)
    found = number_density * diameter * diameter
    if dimension == 3:
        found *= diameter
    if not 0.0 < found < math.inf:
        allowed = f"at diameter {diameter:g} it is {found:g} d^-{dimension}"
        refuse("number_density", number_density, allowed)
    return found


def compare_sample(
    sample: Sample,
    restitution: float | None = None,
    number_density: float | None = None,
    initial: str = "auto",
    explain: bool = True,
) -> Comparison:
    """Compare a sample with the kinetic equation; number_density in d^-2, the rest as above."""
    told = sample.told
    restitution = told.get("restitution") if restitution is None else restitution
    number_density = told.get("number_density") if number_density is None else number_density
    path = None
    if restitution is not None:
        restitution = check_restitution(restitution)
    if number_density is not None:
        path = sample.law.free_path(check_positive("number_density", number_density))
    start = _start(sample, told.get("initial", "auto") if initial == "auto" else initial)
    found = None
    if sample.law.field and (restitution is None or path is None or sample.tabulated):
        raise InputError("field: restitution and number_density must be given, nothing is fitted")
    if restitution is None or path is None:
        found = fitted_to(sample, restitution, path, start)
        values = dict(zip(found.names, found.values, strict=True))
        restitution = float(values["restitution"]) if restitution is None else restitution
        path = float(np.exp(values["log_path"])) if path is None else path
    system = theory.System(restitution, path, start, sample.law)
    solution = theory.solved_averages(system, sample.times, theory.names_for(sample.law))
    rows = sample.law.smooth_disks and not sample.tabulated
    densities = _densities(system, sample) if rows else {}
    return compare(solution, sample, explain, densities, found)


def _densities(system: theory.System, sample: Sample) -> "dict[str, Solution]":
    """The densities by name, that of the displacement at late times and from a named start."""
    from kinetics import SolverStatus

    times = sample.times[histogram_times(sample)]
    found = {}
    if times.size:
        found[theory.SPEED] = theory.solved(system, times, (theory.SPEED,), theory.DENSITY_RTOL)
    late = times[times > COLLISIONS_BEFORE * system.free_path][-DISPLACEMENT_TIMES:]
    # From hundreds of single speeds it would take long.
    if late.size and not isinstance(system.start, theory.SampledStart):
        known = theory.solved(system, late, (theory.DISPLACEMENT,), theory.DISPLACEMENT_RTOL)
        if known.status is SolverStatus.CONVERGED:  # or it would be judged wrongly
            found[theory.DISPLACEMENT] = known
    return found


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
    """Restitution and ln l, whichever is None, by a fit. InputError where the data cannot tell."""
    unknowns = []
    if restitution is None:
        unknowns.append(Unknown("restitution", 0.0, 1.0))
    if path is None:
        unknowns.append(Unknown("log_path", -20.0, float(np.log(_LONGEST_PATH))))
    words = {"restitution": "restitution", "log_path": "number density"}
    wanted = " and ".join(words[one.name] for one in unknowns)
    expectation = theory.Expectation(sample, theory.AVERAGES)
    groups = sample.groups
    spread = errors(expectation.replicates)
    with np.errstate(invalid="ignore"):
        usable = (spread > NO_SPREAD * np.abs(expectation.values)) & np.isfinite(spread)
    usable &= sample.times > 0  # the start does not depend on what is looked for
    components = components_of(theory.AVERAGES, usable, sample, len(unknowns))
    if components.tested.size < len(unknowns) or groups < len(unknowns) + 3:
        raise InputError(
            f"data: {wanted} cannot be found in so few times and groups "
            f"({groups} groups); give --restitution and --number-density"
        )

    def model_of(expectation: theory.Expectation) -> Model:
        def model(at: Array) -> tuple[Array, Array]:
            e = float(at[0]) if restitution is None else restitution
            length = float(np.exp(at[-1])) if path is None else path
            return expectation.theory(e, length, start)

        return model

    guess = _early_log_path(sample)
    starts: list[list[float]] = [[e] for e in _SCAN]
    if path is None:
        starts = [[guess + shift] for shift in (-1.5, 0.0, 1.5)]
        if restitution is None:
            starts = [[e, guess + shift] for e in _SCAN[1::2] for shift in (-1.0, 1.0)]
    if components.logarithms:  # without the others, which cost more, until the place is known
        second = theory.Expectation(sample, SECOND_MOMENTS)
        mine = usable[np.isin(theory.AVERAGES, SECOND_MOMENTS)]
        only = components_of(SECOND_MOMENTS, mine, sample, len(unknowns))
        near = fit(unknowns, model_of(second), (second.values, second.replicates), only, starts)
        starts = starts if near is None else [near.values.tolist()]
    data = expectation.values, expectation.replicates
    found = fit(unknowns, model_of(expectation), data, components, starts)
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
