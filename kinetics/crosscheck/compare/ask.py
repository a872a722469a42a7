"""From data to a comparison: what is not given (restitution, density, start) is found in the data.

`compare_data` is what the command `lorentz compare` does.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.collision.impact import impact_restitution
from kinetics.crosscheck.compare.answer import answered
from kinetics.crosscheck.compare.fit import SECOND_MOMENTS, Fit, fit, hotelling, media_of, spread_in
from kinetics.crosscheck.compare.result import Comparison
from kinetics.crosscheck.compare.theory import BEAM, Expectation, Point, SampledStart, averages_of
from kinetics.crosscheck.data.ensembles import sample_of_ensemble
from kinetics.crosscheck.data.reading import read_sample
from kinetics.crosscheck.data.sample import VX, X2, Law, Sample, errors
from kinetics.crosscheck.data.tracks import MAX_SIZE
from kinetics.crosscheck.words import numeral
from kinetics.errors import InputError
from kinetics.validation import check_positive, check_restitution, one_of, refuse

_SCAN = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99)


def compare_data(
    data: str | PathLike[str] | Sequence[Any] | Mapping[str, Any] | Sample | Any,
    restitution: Any = None, number_density: float | None = None, initial: str = "auto",
    positions: str = "auto", speed_unit: float = 1.0, diameter: float = 1.0,
    explain: bool = True, time_unit: float | None = None,
    columns: Mapping[str, str] | str | None = None, timestep: float | None = None,
    tangential_restitution: float | None = None, dimension: int | None = None,
    field: float = 0.0, type: str | int | None = None, scatterers: str = "auto",
    fitted: bool = False, bath_speed: float = 0.0, heating: float = 0.0, drag: float = 0.0,
    capture_speed: float = 0.0, mass_ratio: float = math.inf,
    frame_interval: float | None = None, decimal: str = ".",
) -> Comparison:  # fmt: skip
    """Compare particle data with the kinetic equation, as `lorentz compare` does: kinetics.compare.

    Parameters
    ----------
    data : a file, several files (as `lorentz compare --help` says), a DataFrame or a dictionary of
        arrays with columns time, x, y, vx, vy (in space also z, vz) and, where known, tracer and
        medium, (n,) each; arrays times (n_times,), positions and velocities (n_times, n_tracers,
        dimension), and tracer and medium (n_tracers,); a run of `simulate`
    restitution : 0 to 1, or of the impact speed as in a Scene; None: as a run says, or fitted
    number_density : in the data's unit of length to the power -2 (-3 in space); None: as above
    initial : "gaussian", "monoenergetic", "beam" (all with the velocity U along x), "data" (the
        speeds at time 0), or "auto": the first of these that the velocities at time 0 allow; a
        Gaussian, where there are none. In a field "rest"
    positions, speed_unit, diameter, time_unit, columns, timestep, frame_interval, dimension, type,
        decimal : of files and of columns in memory, as the options of that command
    tangential_restitution : None: as a run says, or 1. With another, and in space, averages are
        compared and densities are not
    explain : test what may explain a difference; False is quicker
    scatterers : "dilute" (the kinetic equation), "hard disks" or "overlapping" (see Scene), or
        "auto": as a run says, or the likeliest for the data. But for smooth disks "dilute"
    fitted : fit restitution and density also where a run says them
    field, bath_speed, heating, drag, capture_speed, mass_ratio : as in a Scene, in U and d, or as a
        run says. Restitution and number_density are then needed, and no cause is looked for, but,
        in a field, whether components are exchanged

    InputError (a ValueError) for data that cannot be used, or that cannot tell what is not given.
    """
    if (sources := _sources(data)) is not None:
        sample = read_sample(
            sources, positions=positions, speed_unit=speed_unit, diameter=diameter,
            time_unit=time_unit, columns=columns, timestep=timestep, dimension=dimension,
            with_axes=field != 0 or initial == "beam", type=type, frame_interval=frame_interval,
            decimal=decimal, check_motion=not (field or bath_speed or heating),
        )  # fmt: skip
    else:
        sample = data if isinstance(data, Sample) else sample_of_ensemble(data)
    told, path = sample.told, None
    if sample.times.size and sample.times[-1] > MAX_SIZE:  # v^4 would underflow
        refuse("times", float(sample.times[-1]), f"they must be below {MAX_SIZE:g} d/U")
    restitution = told.get("restitution") if restitution is None else restitution
    if dimension is not None and dimension != sample.law.dimension:
        refuse("dimension", dimension, f"the data are of dimension {sample.law.dimension}")
    if (field or initial == "beam") and sample.sums.shape[2] <= X2:
        name, value = ("field", field) if field else ("initial", initial)
        refuse(name, value, "the data have no means along x; files and runs with velocities have")
    impact = impact_restitution(restitution)
    asked: Any = {
        "field": field, "bath_speed": bath_speed, "heating": heating, "drag": drag,
        "capture_speed": capture_speed, "mass_ratio": mass_ratio,
    }  # fmt: skip
    changed = {name: x for name, x in asked.items() if x != getattr(Law, name)}
    if tangential_restitution is not None:
        changed["tangential_restitution"] = tangential_restitution
    law = replace(sample.law, restitution=impact, **changed)
    initial = told.get("initial", "auto") if initial == "auto" else initial
    sample = replace(sample, law=law)
    start = _start(sample, initial)
    if initial == "auto" and isinstance(start, SampledStart) and not sample.units:
        squares, counts = start.bins
        unit = math.sqrt(float(squares @ counts) / counts.sum() / law.dimension)
        if abs(math.log(unit)) > 0.2:
            said = f"Speeds at time 0 are those of U = {numeral(unit, '.4g')} of the data's unit"
            sample = replace(sample, warnings=(*sample.warnings, f"{said}; is it --speed-unit?"))
    if number_density is not None:
        number_density = check_positive("number_density", number_density)
        number_density *= (diameter if sources else 1.0) ** law.dimension
    if fitted:
        restitution = None
    elif number_density is None:
        number_density = told.get("number_density")
    if restitution is not None:
        restitution = check_restitution(restitution) if impact is None else impact
    if number_density is not None:
        path = law.free_path(number_density)
    one_of("scatterers", scatterers, ("auto", "dilute", "hard disks", "overlapping"))
    if scatterers not in ("auto", "dilute") and not law.smooth_disks:
        refuse("scatterers", scatterers, "of others than smooth disks it must be 'dilute'")
    point = None if restitution is None or path is None else Point(restitution, path, start)
    if (law.field or law.is_driven) and point is None:
        raise InputError("restitution: with a field or a drive it and the density must be given")
    media = media_of(sample, scatterers, point)
    if scatterers == "auto" and "scatterers" in told:
        # Of disks of another size than the tracer, or denser ones, there is no other theory.
        has_theory = told["scatterers"] in media_of(sample, "every", point)
        media = [told["scatterers"] if has_theory else "dilute"]
    return answered(sample, _fits(sample, restitution, path, start, media), media, explain)


def fit_data(data: Any, **told: Any) -> Comparison:
    """Restitution and number density of particle data, with errors: `lorentz fit`, kinetics.fit.

    The same as `compare` with neither of them told, and no causes looked for. The result has
    `parameters`, their `covariance`, the `medium` that was taken, and the figure "confidence".
    """
    for name in {"restitution", "number_density"} & {*told}:
        refuse(name, told[name], "it is what is fitted; compare takes it")
    return compare_data(data, explain=False, fitted=True, **told)


def _sources(data: Any) -> list[Any] | None:
    """Files as paths, and columns by name; None for what is neither."""
    if isinstance(data, list | tuple):
        every = [_sources(one) for one in data]
        return None if None in every else [one for found in every if found for one in found]
    if isinstance(data, str | PathLike):
        return [Path(data)]
    if hasattr(data, "columns") and hasattr(data, "iloc"):  # a DataFrame
        data = {name: data[name] for name in data.columns}
    return [data] if isinstance(data, Mapping) else None


def _start(sample: Sample, initial: str) -> Any:
    """The start as a Scene has it."""
    law, names = sample.law, ("auto", "gaussian", "monoenergetic", "beam", "data", "rest")
    gains = law.field or law.bath_speed or law.heating
    if one_of("initial", initial, names) == "rest" and not gains:
        refuse("initial", initial, "without a field, a bath or heating nothing would move")
    if initial not in ("auto", "data"):
        return BEAM if initial == "beam" else initial
    if sample.start is None:
        if initial == "data":
            refuse("initial", initial, "there are no velocities at time 0")
        return "gaussian"
    squares = sample.start.squares
    if squares.size == 0:
        if not gains:
            raise InputError("data: every speed at time 0 is zero; nothing will move")
        return "rest"
    if initial == "auto":
        if np.all(np.abs(squares - 1) < 1e-6):
            first = sample.sums[:, 0].sum(axis=0)
            along = first.size > X2 and not law.field and first[VX] > (1 - 1e-6) * sample.samples[0]
            return BEAM if along else "monoenergetic"
        at_start = Expectation(sample, ("thermal_speed", "a2"))
        away = at_start.values[:, 0] - [np.sqrt(law.dimension), 0.0]
        test = hotelling(away, at_start.replicates[:, :, 0])
        if squares.size > 1 and test and test.p_value >= 1e-3:
            return "gaussian"
    if law.field:
        refuse("initial", initial, "in a field the start must be rest, gaussian or monoenergetic")
    return SampledStart(sample.start)


def _fits(
    sample: Sample, restitution: Any, path: float | None, start: Any, media: Sequence[str]
) -> list[Fit]:
    """Restitution and l, whichever is None, by a fit in each medium; or InputError."""
    words = {"restitution": "restitution", "path": "number_density"}
    free = [name for name, told in zip(words, (restitution, path), strict=True) if told is None]
    wanted, groups = " and ".join(words[name] for name in free), sample.groups
    measured = Expectation(sample, averages_of(sample.law, start))
    # not time 0: the start does not depend on what is looked for
    usable = spread_in(errors(measured.replicates), measured.values) & (sample.times > 0)
    complete = sample.is_complete
    if not sample.law.capture_speed and np.count_nonzero(complete & (sample.times > 0)) >= 3:
        usable &= complete  # the tracers that are left may be no fair sample
    starts: list[list[float]] = [[]]
    known = Point(restitution or 0.0, path or 1.0, start)
    if free:
        second = usable[np.isin(measured.names, SECOND_MOMENTS)]
        if np.count_nonzero(second) < len(free) or groups < len(free) + 3:
            raise InputError(f"data: too few times or groups ({groups}) to find {wanted}; give it")
        # l to start from: a third of the largest root mean square displacement
        msd = measured.values[measured.names.index("msd")]
        size = math.sqrt(max(msd[np.isfinite(msd)], default=9.0)) / 3
        guess = math.log(min(max(size, 1e-6), 1e6))
        known = Point(0.5 if restitution is None else restitution, path or math.exp(guess), start)
        starts = [[e] for e in _SCAN]
        if path is None:
            starts = [[guess + shift] for shift in (-1.5, 0.0, 1.5)]
            if restitution is None:
                starts = [[e, guess + shift] for e in _SCAN[1::2] for shift in (-1.0, 1.0)]
        # Without the other averages, which cost more, until the place is known.
        of_second = Expectation(sample, SECOND_MOMENTS)
        if near := fit(of_second, known, free, second, starts, len(free)):
            starts = [near.at.tolist()]
    tried = (
        fit(measured, known._replace(scatterers=medium), free, usable, starts, len(free))
        for medium in media
    )
    found = [one for one in tried if one is not None and np.all(np.isfinite(one.covariance))]
    if not found:
        raise InputError(f"data: {wanted} could not be fitted; give it")
    return found
