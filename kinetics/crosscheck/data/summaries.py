"""Samples of what is summed up already: tables of averages, and runs of the package's simulator.

The sample of a table such as `t,v0,v0_error,msd,msd_error` has groups that are made up: their mean
is the average of the table, and their spread gives its standard error. Errors of different averages
and times are made independent, as the table does not say how they are correlated.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.data.sample import R2, R4, V2, V4, Law, N, Sample, reduced
from kinetics.crosscheck.data.tracks import MOST_TIMES, Averages, Tracks, bad, name_of
from kinetics.errors import InputError, short

Array = NDArray[np.float64]

EXACT = 1e-6  # Relative error of averages of a Solution, which have none beside them
GROUPS = 1000  # groups that are made up: so many that errors are as good as exact


def of_averages(table: Averages, names: tuple[str, ...], law: Law) -> Sample:
    """The sample of a table, in its own units; InputError for one that cannot be used."""
    where, columns = ", ".join(names), dict(table.columns)
    order = np.argsort(columns["time"])
    columns = {name: np.asarray(values, float)[order] for name, values in columns.items()}
    times = columns.pop("time")
    bare = [name for name in columns if f"error of {name}" not in columns and "error" not in name]
    columns |= {f"error of {name}": EXACT * np.abs(columns[name]) for name in bare}
    if times[0] < 0 or np.any(np.diff(times) <= 0) or times.size > MOST_TIMES:
        bad(f"{where}: times", short(times), f"1 to {MOST_TIMES} different times, not negative")
    for name, values in columns.items():
        if name.startswith("error of ") and np.any(values < 0):
            bad(where, f"an {name} of {np.nanmin(values):g}", "not negative")
    sums, left_out = _sums(columns, law)
    if not np.any(np.isfinite(sums[0, :, [V2, R2]])):
        bad(where, "no average with a standard error above 0", "one at least")
    warnings: tuple[str, ...] = (
        "A table of averages does not say how errors at different times are correlated. The "
        "p-value of an average is that of the time that differs most, times the number of times, "
        "which holds for any correlation. Errors of fitted numbers are those for "
        "the worst correlation.",
    )
    if left_out:
        warnings += (
            f"{' and '.join(left_out)} cannot be used without the second moment (v0 or msd) beside "
            "it, and was left out.",
        )
    ones = np.ones(times.size)
    return Sample(
        names, times, sums, ones, ones, None, None, None, np.zeros(times.size, np.int64), "table",
        law, warnings=warnings, tabulated=True,
    )  # fmt: skip


def _sums(columns: Mapping[str, Array], law: Law) -> tuple[Array, list[str]]:
    """The sums of the made-up groups, (GROUPS, n_times, 5), and averages that cannot be used."""
    (first, *_) = columns.values()
    most = min(first.size * len(columns), GROUPS - 2)
    free = np.random.default_rng(0).normal(size=(GROUPS, most + 1))
    free[:, 0] = 1.0
    axes, used = np.linalg.qr(free)[0][:, 1:], 0
    sums, left_out = np.full((GROUPS, first.size, 5), np.nan), []
    sums[..., N] = 1.0
    relative: dict[int, Array] = {}  # deviations of the groups from second moments
    for name, column, second, power in (
        ("thermal_speed", V2, None, 2.0), ("mean_square_speed", V2, None, 1.0),
        ("msd", R2, None, 1.0), ("a2", V4, V2, 1.0), ("kurtosis", R4, R2, 1.0),
    ):  # fmt: skip
        if name not in columns or column in relative:
            continue
        if second is not None and second not in relative:
            left_out.append(name)
            continue
        value, error = columns[name], columns[f"error of {name}"]
        good = np.isfinite(value) & (error > 0) & np.isfinite(error)
        value = np.where(good & ((value > 0) | (name == "a2")), value, np.nan)
        # of mean 0, and orthogonal for different averages and times
        spread = axes[:, (used + np.arange(value.size)) % most]
        spread = spread * np.where(good, error, np.nan) * np.sqrt(GROUPS * (GROUPS - 1))
        used += value.size
        if name == "a2":
            value, spread = law.gaussian * (1 + value), law.gaussian * spread
        if second is None:
            relative[column] = power * spread / value
            sums[..., column] = value**power * (1 + relative[column])
        else:  # the ratio to the squared second moment has the spread that the table gives it
            wanted = spread / value + 2 * relative[second]
            sums[..., column] = value * sums[..., second].mean(axis=0) ** 2 * (1 + wanted)
    return sums, left_out


def read_ensemble(path: Path) -> Sample:
    """The sample of a finished run in a file, lengths in d; InputError for a damaged one."""
    from particles import Ensemble

    try:
        run = Ensemble.load(path)
    except ValueError as error:
        raise InputError(" ".join(str(error).split())) from None
    return from_ensemble(run, name_of(Path(path.name)))


def from_ensemble(ensemble: Any, name: str = "ensemble") -> Sample:
    """The sums of a run, lengths in d; counts in bins too, where velocities and positions are kept.

    InputError for a run without output times or with fewer than two groups.
    """
    from particles import BoltzmannGrad, HardDisks, Poisson

    times, medium, plan = np.asarray(ensemble.times), ensemble.medium, ensemble.plan
    if times.size == 0 or ensemble.moments.size == 0:
        bad(name, "a run without output times", "made by simulate(..., times=...)")
    if ensemble.mass_ratio < math.inf:
        bad(name, f"mass_ratio = {ensemble.mass_ratio:g}", "fixed scatterers, mass_ratio = inf")
    # Tracers of a Boltzmann-Grad run share no scatterers: each of them is independent.
    free, stored = isinstance(medium, BoltzmannGrad), ensemble.arrays
    if "raw/velocities" in stored and "raw/positions" in stored:
        place, velocity = np.asarray(ensemble.positions), np.asarray(ensemble.velocities)
        label = np.arange(place.shape[1]) // (1 if free else ensemble.tracers)
        tracks, by = Tracks(times, place, velocity), "tracer" if free else "medium"
        found = reduced(tracks, label, (name,), by, bool(ensemble.field))
    else:  # from the sums that every run keeps: the averages alone
        sums = np.asarray(ensemble.moments[:, :, : R4 + 1])
        if ensemble.field:  # v_x, x and x^2 of the sums of a field
            more = stored["field_sums"]
            half = more.shape[2] // 2
            more = more[:, :, [0, half, half + medium.dimension]]
            sums = np.concatenate([sums, more], axis=2)
        found = Sample(
            (name,), times, sums, 1.0 / plan.scales(), np.full(times.size, medium.diameter),
            None, None, None, np.asarray(ensemble.trapped), "medium",
        )  # fmt: skip
    if found.groups < 2:
        bad(name, "one configuration", "two at least, for standard errors")
    told: dict[str, Any] = {
        "restitution": ensemble.restitution,
        "number_density": ensemble.number_density,
    }
    if plan.rest or plan.velocities is None:
        start = "monoenergetic" if plan.monoenergetic else "gaussian"
        told["initial"] = "rest" if plan.rest else start
    for kind, scatterers in ((HardDisks, "hard disks"), (Poisson, "overlapping")):
        if isinstance(medium, kind):
            told["scatterers"] = scatterers
    law = Law(ensemble.tangential_restitution, medium.dimension, ensemble.field)
    return replace(found, free=free, told=told, law=law).rescaled(1.0, medium.diameter)
