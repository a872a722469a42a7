"""From data to a comparison: what is not specified (e, density, start, U) is found in the data.

`compare_data` is what the command `lorentz compare` does, `fit_data` what `lorentz fit` does. Both
read the data (`data.reading`), complete what was specified (`Question`), fit the rest in each
medium that the scatterers may be (`_fits`), and judge the fits (`answer`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from inspect import signature
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.collision.impact import impact_restitution
from kinetics.collision.medium import word_for_scatterers
from kinetics.crosscheck.compare.answer import answer
from kinetics.crosscheck.compare.curves import compare_averages
from kinetics.crosscheck.compare.fit import (
    Fit,
    compare_with_point,
    first_estimate,
    fit,
    fitted_components,
)
from kinetics.crosscheck.compare.measured import PAIR_N, PAIR_R2, Layout, Measured
from kinetics.crosscheck.compare.media import media_of
from kinetics.crosscheck.compare.observables import averages_of
from kinetics.crosscheck.compare.parameters import (
    FIRST_RESTITUTIONS,
    combinations_of,
    coordinates_of,
    free_parameter,
)
from kinetics.crosscheck.compare.point import Point
from kinetics.crosscheck.compare.result import Comparison
from kinetics.crosscheck.compare.selection import fit_times, row_times
from kinetics.crosscheck.compare.starts import start_of
from kinetics.crosscheck.data.averages import AveragesTable
from kinetics.crosscheck.data.ensembles import sample_of_ensemble
from kinetics.crosscheck.data.reading import read_data
from kinetics.crosscheck.data.sample import R2, X2, Law, N, Sample
from kinetics.crosscheck.data.tracks import MAX_SIZE
from kinetics.drive import check_strengths
from kinetics.errors import InputError, suggestion
from kinetics.validation import (
    check_flag,
    check_mass_ratio,
    check_positive,
    check_restitution,
    real_number,
    refuse,
)

#: Logarithms of the mean free paths over the root mean square displacement at the end from which a
#: fit begins. The origin of the range is not recorded.
FOLDS_OF_PATH = range(-2, 1)
#: The shortest of these mean free paths, as a logarithm, where there are positions alone, so that l
#: and U are fitted together. The origin of the number is not recorded.
SHORT_PATH_ALONE = -2.5
#: The longest of these mean free paths, as a logarithm, where there are positions alone. The origin
#: of the number is not recorded.
LONG_PATH_ALONE = -1.0
#: Groups that there must be beyond one for each fitted number. The origin is not recorded.
GROUPS_BESIDE = 3
#: Times without missing tracers that a fit needs to leave the other times out.
MIN_COMPLETE_TIMES = 3
#: The number of a point, by the name of the argument that specifies it.
ARGUMENT_OF = {
    "restitution": "restitution",
    "path": "number_density",
    "speed_unit": "speed_unit",
    "position_noise": "localisation_error",
}


def compare_data(
    data: str | PathLike[str] | Sequence[Any] | Mapping[str, Any] | Sample | Any,
    restitution: Any = None,
    number_density: float | None = None,
    initial: str = "auto",
    positions: str = "auto",
    speed_unit: float | None = None,
    diameter: float = 1.0,
    explain: bool = True,
    time_unit: float | None = None,
    columns: Mapping[str, str] | str | None = None,
    timestep: float | None = None,
    tangential_restitution: float | None = None,
    dimension: int | None = None,
    field: float = 0.0,
    type: str | int | None = None,
    scatterers: str = "auto",
    fitted: bool = False,
    bath_speed: float = 0.0,
    heating: float = 0.0,
    drag: float = 0.0,
    capture_speed: float = 0.0,
    mass_ratio: float = math.inf,
    frame_interval: float | None = None,
    decimal: str = ".",
    localisation_error: float | None = None,
    fps: float | None = None,
) -> Comparison:
    """Compare particle data with the kinetic equation, as `lorentz compare` does: kinetics.compare.

    Parameters
    ----------
    data : a file, several files (as `lorentz compare --help` says), a DataFrame or a dictionary of
        arrays with columns time, x, y and, where they were measured, vx, vy (in space also z, vz)
        and, where known, tracer and medium, (n,) each; arrays times (n_times,), positions and
        velocities (n_times, n_tracers, dimension), and tracer and medium (n_tracers,); a run of
        `simulate`
    restitution : 0 to 1, or of the impact speed as in a Scene; None: as a run says, or fitted
    number_density : in the data's unit of length to the power -2 (-3 in space); None: as above
    initial : "gaussian", "monoenergetic" (or "one speed"), "beam" (all with the velocity U along
        x), "data" (or "first frames": the speeds at time 0), or "auto": the first of these that the
        velocities at time 0 allow; a Gaussian, where there are none. In a field "rest"
    speed_unit : U in the data's unit of speed; None: 1, and for positions alone fitted
    localisation_error : for positions alone, standard deviation of the error of a component of a
        position, in the data's unit of length; None: fitted
    positions, diameter, time_unit, columns, timestep, frame_interval, fps, dimension, type, decimal
        : of files and of columns in memory, as the options of that command
    tangential_restitution : None: as a run says, or 1. With another, and in space, averages are
        compared and densities are not
    explain : test what may explain a difference; False is quicker
    scatterers : "dilute" (the kinetic equation), "hard disks" or "overlapping disks" (see Scene),
        or "auto": as a run says, or the likeliest for the data; spheres and rough disks are dilute
    fitted : fit restitution and density also where a run says them
    field, bath_speed, heating, drag, capture_speed, mass_ratio : as in a Scene, in U and d, or as a
        run says. Restitution and number_density are then needed, and no cause is looked for, but,
        in a field, whether components are exchanged

    Returns
    -------
    Comparison

    Raises
    ------
    InputError
        A ValueError: for data that cannot be used, or that cannot tell what is not specified.
    """
    if fps is not None:
        if frame_interval is not None:
            refuse("fps", fps, "frame_interval says the same: specify one of them")
        frame_interval = 1.0 / check_positive("fps", fps)
    explain = check_flag("explain", explain)
    fitted = check_flag("fitted", fitted)
    if not isinstance(initial, str):
        refuse("initial", initial, "it must be the name of a start, such as 'auto'")
    if tangential_restitution is not None:
        allowed = "it must be a number from 0 to 1"
        tangential_restitution = real_number(
            "tangential_restitution", tangential_restitution, 0.0, 1.0, allowed
        )
    strengths = check_strengths(
        field=field,
        bath_speed=bath_speed,
        heating=heating,
        drag=drag,
        capture_speed=capture_speed,
    )
    drives: dict[str, float | None] = {
        **strengths,
        "mass_ratio": check_mass_ratio(mass_ratio),
        "tangential_restitution": tangential_restitution,
    }
    reading = {
        "positions": positions,
        "speed_unit": 1.0 if speed_unit is None else speed_unit,
        "diameter": diameter,
        "time_unit": time_unit,
        "columns": columns,
        "timestep": timestep,
        "dimension": dimension,
        "type": type,
        "frame_interval": frame_interval,
        "decimal": decimal,
        "with_axes": strengths["field"] != 0.0 or initial == "beam",
        "check_motion": not (field or bath_speed or heating),
    }
    sources = _sources(data)
    sample = _read(data, sources, reading)
    if isinstance(sample, AveragesTable):
        if field or bath_speed or heating:
            refuse("field", "a drive", "averages are compared without a field, a bath or heating")
        not_of_averages = {
            "drag": drag,
            "capture_speed": capture_speed,
            "mass_ratio": mass_ratio,
            "tangential_restitution": tangential_restitution,
            "localisation_error": localisation_error,
        }
        for name, value in not_of_averages.items():
            if value not in (None, getattr(Law, name, 0.0)):
                refuse(name, value, "a table of averages is compared without it")
        if number_density is not None:
            number_density = check_positive("number_density", number_density)
            number_density *= diameter ** (dimension or 2)
        return compare_averages(sample, restitution, number_density, initial, scatterers, dimension)
    if dimension is not None and dimension != sample.law.dimension:
        refuse("dimension", dimension, f"the data are of dimension {sample.law.dimension}")
    sample = _with_axes(sample, strengths["field"], initial)
    length_unit = 1.0 if sources is None else diameter  # runs and samples are in d
    if restitution is None and not fitted:
        restitution = sample.told.get("restitution")
    if number_density is not None:
        number_density = check_positive("number_density", number_density)
        number_density *= length_unit**sample.law.dimension
    elif not fitted:
        number_density = sample.told.get("number_density")
    knows_speed = sample.has_velocities or speed_unit is not None or sources is None
    noise = _position_noise(sample, localisation_error, length_unit, sources is None)
    question = Question.of(
        _with_law(sample, restitution, drives),
        restitution,
        number_density,
        initial,
        scatterers,
        knows_speed,
        noise,
    )
    return answer(question.sample, _fits(question), question.media, explain)


#: Options of the command line that have another name in Python, and that name.
PYTHON_NAMES = {"start": "initial", "length_unit": "diameter"}


def fit_data(data: Any, **options: Any) -> Comparison:
    """Restitution and number density of particle data, with errors: `lorentz fit`, kinetics.fit.

    Parameters
    ----------
    data : as in `compare`
    options : arguments of `compare`, but for restitution and number_density, which are fitted. The
        usual ones are `scatterers` ("auto", "dilute", "hard disks"), `initial` ("auto", "gaussian",
        "one speed", "first frames"), `diameter`, `speed_unit` and `time_unit` (d, U and d/U in the
        data's units), `frame_interval` and `columns` for tables, and `localisation_error`

    Returns
    -------
    Comparison
        It has `parameters` with their errors, the `covariance` of restitution and ln(mean free
        path), the `medium` that was taken, and the figure "confidence". No causes are looked for.

    Raises
    ------
    InputError
        A ValueError, as `compare` does, and for an argument that `compare` has not.
    """
    for name in ("restitution", "number_density"):
        if name in options:
            refuse(name, options[name], "it is what is fitted; compare takes it")
    known = [name for name in signature(compare_data).parameters if name != "data"]
    for name in options:
        if name not in known:
            near = suggestion(name, known, PYTHON_NAMES)
            raise InputError(f"{name}: fit has no such argument{near}")
    return compare_data(data, explain=False, fitted=True, **options)


# -- reading ---------------------------------------------------------------------------------------
def _sources(data: Any) -> list[Path | Mapping[str, Any]] | None:
    """Return files as paths and columns by name; None for what is neither."""
    if isinstance(data, list | tuple):
        sources = []
        for item in data:
            of_item = _sources(item)
            if of_item is None:
                return None
            sources += of_item
        return sources
    if isinstance(data, str | PathLike):
        return [Path(data)]
    if hasattr(data, "columns") and hasattr(data, "iloc"):  # a DataFrame
        return [{name: data[name] for name in data.columns}]
    return [data] if isinstance(data, Mapping) else None


def _read(
    data: Any, sources: Sequence[Path | Mapping[str, Any]] | None, reading: dict[str, Any]
) -> Sample | AveragesTable:
    """Return what files or columns hold, the sample of a run, or the sample that the data are."""
    if sources is not None:
        sample = read_data(sources, **reading)
    elif isinstance(data, Sample):
        sample = data
    else:
        sample = sample_of_ensemble(data)
    if isinstance(sample, AveragesTable):
        return sample
    if sample.times.size and sample.times[-1] > MAX_SIZE:  # v^4 would underflow
        refuse("times", float(sample.times[-1]), f"they must be below {MAX_SIZE:g} d/U")
    return sample


def _with_axes(sample: Sample, field: float, initial: str) -> Sample:
    """Return the sample; InputError if means along x are needed, and it has none."""
    needs_axes = field or initial == "beam"
    if needs_axes and sample.sums.shape[2] <= X2:
        needed = "the data have no means along x; files and runs with velocities have"
        if field:
            refuse("field", field, needed)
        refuse("initial", initial, needed)
    return sample


def _with_law(sample: Sample, restitution: Any, drives: dict[str, Any]) -> Sample:
    """Return the sample with what was specified of its system in place of what it says itself."""
    changed = {}
    for name, value in drives.items():
        is_default = value is None or value == getattr(Law, name)
        if not is_default or (name == "tangential_restitution" and value is not None):
            changed[name] = value
    law = replace(sample.law, restitution=impact_restitution(restitution), **changed)
    return replace(sample, law=law)


def _position_noise(
    sample: Sample, localisation_error: float | None, length_unit: float, is_run: bool
) -> float | None:
    """Return the variance of a component of a position in d^2; None if it is to be fitted."""
    if localisation_error is not None:
        error = real_number("localisation_error", localisation_error, 0.0, MAX_SIZE)
        if sample.has_velocities:
            refuse(
                "localisation_error",
                localisation_error,
                "it is of positions alone; with velocities noise is looked for as a cause",
            )
        return (error / length_unit) ** 2
    if sample.has_velocities or is_run:
        return 0.0
    return None


# -- what is asked of the data ---------------------------------------------------------------------
@dataclass(frozen=True, eq=False)
class Question:
    """A sample, and what was specified of it.

    Parameters
    ----------
    sample : at the times of the rows
    point : of the theory, in the first medium, with a guess of what is fitted
    free : the names of the numbers of the point that are fitted
    media : that the scatterers may be
    """

    sample: Sample
    point: Point
    free: tuple[str, ...]
    media: list[str]

    @classmethod
    def of(
        cls,
        sample: Sample,
        restitution: Any,
        number_density: float | None,
        initial: str,
        scatterers: str,
        knows_speed: bool,
        position_noise: float | None,
    ) -> Question:
        """Complete what was specified; InputError where that is impossible.

        Parameters
        ----------
        number_density : in d^-2 (d^-3); None if it is to be fitted
        knows_speed : whether U is known
        position_noise : in d^2; None if it is to be fitted
        """
        law = sample.law
        sample, start = start_of(sample, initial)
        scatterers = word_for_scatterers(scatterers, ("auto",))
        if scatterers not in ("auto", "dilute") and not law.smooth_disks:
            refuse("scatterers", scatterers, "of others than smooth disks it must be 'dilute'")
        if restitution is not None and law.restitution is None:
            restitution = check_restitution(restitution)
        if law.restitution is not None:
            restitution = law.restitution
        specified = {
            "restitution": restitution,
            "path": None if number_density is None else law.free_path(number_density),
            "speed_unit": 1.0 if knows_speed else None,
            "position_noise": position_noise,
        }
        free = tuple(name for name, value in specified.items() if value is None)
        if (law.field or law.is_driven) and free:
            raise InputError(
                "restitution: with a field or a drive it, the density, and for positions alone "
                "speed_unit and localisation_error must be given"
            )
        point = _first_point(sample, specified, start)
        path = specified["path"]
        media = media_of(scatterers, law, path, restitution, sample.free)
        stated = sample.told.get("scatterers")
        if scatterers == "auto" and stated is not None:
            # Of disks of another size than the tracer, or denser ones, there is no other theory.
            media = ["dilute"]
            if stated in media_of("every", law, path, restitution, sample.free):
                media = [stated]
        rows = sample.at_times(row_times(sample))
        return cls(rows, point, free, media)


def _first_point(sample: Sample, specified: dict[str, Any], start: Any) -> Point:
    """Return what was specified as a point, with a guess of what is to be fitted."""
    size = _size(sample)
    guess: dict[str, Any] = {
        "restitution": 0.7,
        "path": size / math.e,
        "speed_unit": _guess_of_speed(sample),
        "position_noise": 0.0,
    }
    for name, value in specified.items():
        if value is not None:
            guess[name] = value
    return Point(start=start, **guess)


def _size(sample: Sample) -> float:
    """Return the largest root mean square displacement in d; 3 where nothing has moved."""
    sums = sample.sums.sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        msd = sums[:, R2] / sums[:, N]
    if sample.pairs is not None:
        of_pairs = sample.pairs.sums.sum(axis=0)
        with np.errstate(invalid="ignore", divide="ignore"):
            msd = np.append(msd, of_pairs[:, PAIR_R2] / of_pairs[:, PAIR_N])
    largest = float(np.max(msd[np.isfinite(msd)], initial=0.0))
    if not 1e-12 < largest < 1e12:
        return 3.0
    return math.sqrt(largest)


def _guess_of_speed(sample: Sample) -> float:
    """Return U in d per unit of the data's time from the displacement in the shortest interval."""
    pairs = sample.pairs
    if pairs is None:
        return 1.0
    interval = sample.times[pairs.later] - sample.times[pairs.earlier]
    from_start = np.flatnonzero(pairs.earlier == pairs.earlier.min())
    first = from_start[int(np.argmin(interval[from_start]))]
    sums = pairs.sums[:, first].sum(axis=0)
    mean_square = float(sums[PAIR_R2] / sums[PAIR_N]) / sample.law.dimension
    if mean_square <= 0.0:
        return 1.0
    return math.sqrt(mean_square) / float(interval[first])


# -- fits ------------------------------------------------------------------------------------------
def _fits(question: Question) -> list[Fit]:
    """Return what was specified, or the fit of the rest, in each medium; or InputError."""
    measured = _measured(question)
    if not question.free:
        points = [question.point.with_values(scatterers=medium) for medium in question.media]
        return [compare_with_point(measured, point) for point in points]
    wanted = " and ".join(ARGUMENT_OF[name] for name in question.free)
    _check_enough(measured, question, wanted)
    starts = _starts(question, measured)
    fits = []
    for medium in question.media:
        point = question.point.with_values(scatterers=medium)
        free = [free_parameter(name, point, measured) for name in question.free]
        fitted = fit(measured, point, free, starts)
        if fitted is not None and np.all(np.isfinite(fitted.covariance)):
            fits.append(fitted)
            starts = [coordinates_of(fitted.point, free).tolist(), *starts]
    if not fits:
        raise InputError(f"data: {wanted} could not be fitted; give it")
    return fits


def _measured(question: Question) -> Measured:
    """Return the averages at the times that a fit and its test look at."""
    sample = question.sample
    complete = np.count_nonzero(sample.is_complete & (sample.times > 0.0))
    only_complete = bool(complete >= MIN_COMPLETE_TIMES) and not sample.law.capture_speed
    path = question.point.path
    if "path" in question.free:  # a path that is too long only leaves early times out
        path = _size(sample)
    times = fit_times(sample, path, only_complete and bool(question.free))
    names = averages_of(sample.law, question.point.starts_along_x)
    if not sample.has_velocities:
        names = tuple(name for name in names if name not in ("drift", "thermal_speed", "a2"))
    return Measured.of(sample.at_times(times), names)


def _check_enough(measured: Measured, question: Question, wanted: str) -> None:
    """Raise InputError where there are too few times, pairs of frames, or groups for a fit."""
    n_free = len(question.free)
    n_groups = measured.sample.groups
    n_components = fitted_components(measured).size
    n_needed = n_free
    what = "times"
    if not measured.has_velocities:
        n_needed = n_free + 1
        what = "pairs of frames"
    if n_components < n_needed:
        raise InputError(f"data: too few {what} ({n_components}) to find {wanted}; give it")
    if n_groups < n_free + GROUPS_BESIDE:
        raise InputError(f"data: too few times or groups ({n_groups}) to find {wanted}; give it")


def _starts(question: Question, measured: Measured) -> Sequence[Sequence[float]]:
    """Return coordinates from which a fit begins.

    Of positions alone the mean square displacement from the first frame finds the place: that
    between all pairs of frames takes the solver long.
    """
    point = question.point
    size = _size(question.sample)
    folds: Sequence[float] = FOLDS_OF_PATH
    if not measured.has_velocities:
        folds = (SHORT_PATH_ALONE, LONG_PATH_ALONE)
    values = {
        "restitution": FIRST_RESTITUTIONS,
        "path": [size * math.exp(fold) for fold in folds],
        "speed_unit": [point.speed_unit],
        "position_noise": [0.0],
    }
    free = [free_parameter(name, point, measured) for name in question.free]
    starts = combinations_of(free, values)
    if measured.has_velocities:
        return starts
    layout = Layout(("msd",), measured.layout.times, measured.layout.law)
    from_first_frame = Measured(replace(measured.sample, pairs=None), layout)
    estimate = first_estimate(from_first_frame, point, free, starts)
    if estimate is None:
        return starts
    return [estimate.tolist()]
