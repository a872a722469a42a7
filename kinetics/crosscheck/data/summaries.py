"""Samples of what is summed up already: tables of averages, and runs of the package's simulator.

A table such as `t,v0,v0_error,msd,msd_error` says nothing of single tracers. Its sample has groups
that are made up: their mean is the average of the table, and their spread gives its standard error.
Errors of different averages and times are made independent, as the table does not say how they are
correlated.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.data.sample import R2, R4, V2, V4, Law, N, Sample, reduced
from kinetics.crosscheck.data.tracks import MOST_TIMES, Averages, Tracks, bad, name_of
from kinetics.errors import InputError, short

if TYPE_CHECKING:
    from particles.ensemble import Ensemble

Array = NDArray[np.float64]

EXACT = 1e-6
"""Relative error of averages of a Solution, which have none beside them."""
GROUPS = 1000
"""Groups that are made up: so many that errors are as good as exact."""


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
    warnings = [
        "A table of averages does not say how errors at different times are correlated. The "
        "p-value of an average is that of the time that differs most, times the number of times, "
        "which holds for any correlation. Errors of fitted numbers are those for "
        "the worst correlation."
    ]
    if left_out:
        warnings.append(
            f"{' and '.join(left_out)} cannot be used without the second moment (v0 or msd) beside "
            "it, and was left out."
        )
    ones = np.ones(times.size)
    return Sample(
        names, times, sums, ones, ones, None, None, None, np.zeros(times.size, np.int64), "table",
        law, warnings=tuple(warnings), tabulated=True,
    )  # fmt: skip


def _sums(columns: Mapping[str, Array], law: Law) -> tuple[Array, list[str]]:
    """The sums of the made-up groups, (GROUPS, n_times, 5), and averages that cannot be used."""
    (first, *_) = columns.values()
    most = min(first.size * len(columns), GROUPS - 2)
    free = np.random.default_rng(0).normal(size=(GROUPS, most + 1))
    free[:, 0] = 1.0
    axes, used = np.linalg.qr(free)[0][:, 1:], 0

    def usable(name: str) -> tuple[Array, Array]:
        """The average, and deviations of the groups, as far as both are known.

        Their mean is 0, and they are orthogonal for different averages and times.
        """
        nonlocal used
        value, error = columns[name], columns[f"error of {name}"]
        good = (
            np.isfinite(value) & (error > 0) & np.isfinite(error) & ((value > 0) | (name == "a2"))
        )
        mine = axes[:, (used + np.arange(value.size)) % most]
        used += value.size
        spread = mine * np.where(good, error, np.nan) * np.sqrt(GROUPS * (GROUPS - 1))
        return np.where(good, value, np.nan), spread

    sums = np.full((GROUPS, first.size, 5), np.nan)
    sums[..., N] = 1.0
    relative: dict[int, Array] = {}
    for name, column, power in (
        ("thermal_speed", V2, 2.0), ("mean_square_speed", V2, 1.0), ("msd", R2, 1.0)
    ):  # fmt: skip
        if name in columns and column not in relative:
            value, spread = usable(name)
            relative[column] = power * spread / value
            sums[..., column] = value**power * (1 + relative[column])
    left_out = []
    for name, column, second in (("a2", V4, V2), ("kurtosis", R4, R2)):
        if name in columns and second not in relative:
            left_out.append(name)
        elif name in columns:
            value, spread = usable(name)
            if name == "a2":
                value, spread = law.gaussian * (1 + value), law.gaussian * spread
            # The ratio to the squared second moment has the spread that the table gives it.
            wanted = spread / value + 2 * relative[second]
            sums[..., column] = value * sums[..., second].mean(axis=0) ** 2 * (1 + wanted)
    return sums, left_out


# -- runs of the simulator -------------------------------------------------------------------------


def read_ensemble(path: Path) -> Sample:
    """The sample of a finished run in a file, lengths in d; InputError for a damaged one."""
    from particles import Ensemble

    try:
        run = Ensemble.load(path)
    except ValueError as error:
        raise InputError(" ".join(str(error).split())) from None
    return from_ensemble(run, name_of(Path(path.name)))


def from_ensemble(ensemble: "Ensemble", name: str = "ensemble") -> Sample:
    """The sums of a particle run, lengths in d.

    With stored velocities and positions densities are compared too. InputError for a run
    without output times or with fewer than two groups.
    """
    from particles import BoltzmannGrad, HardDisks, Poisson

    times = np.asarray(ensemble.times)
    if times.size == 0 or ensemble.moments.size == 0:
        bad(name, "a run without output times", "made by simulate(..., times=...)")
    # Tracers of a Boltzmann-Grad run share no scatterers: each of them is independent.
    free, stored = isinstance(ensemble.medium, BoltzmannGrad), ensemble.arrays
    if "raw/velocities" in stored and "raw/positions" in stored:
        place, velocity = np.asarray(ensemble.positions), np.asarray(ensemble.velocities)
        label = np.arange(place.shape[1]) // (1 if free else ensemble.tracers)
        grouping = "tracer" if free else "medium"
        found = reduced(
            Tracks(times, place, velocity), label, (name,), grouping, bool(ensemble.field)
        )
    else:
        found = _from_sums(ensemble, name, times)
    if ensemble.mass_ratio < math.inf:
        bad(name, f"mass_ratio = {ensemble.mass_ratio:g}", "fixed scatterers, mass_ratio = inf")
    if ensemble.plan.driven or ensemble.plan.varies:
        bad(name, "a driven run, or one whose restitution varies", "fixed scatterers, one e")
    if found.groups < 2:
        bad(name, "one configuration", "two at least, for standard errors")
    plan = ensemble.plan
    told: dict[str, Any] = {
        "restitution": ensemble.restitution,
        "number_density": ensemble.number_density,
    }
    if plan.velocities is None:
        told["initial"] = "monoenergetic" if plan.monoenergetic else "gaussian"
    if plan.rest:
        told["initial"] = "rest"
    for kind, scatterers in ((HardDisks, "hard disks"), (Poisson, "overlapping")):
        if isinstance(ensemble.medium, kind):
            told["scatterers"] = scatterers
    law = Law(ensemble.tangential_restitution, ensemble.medium.dimension, ensemble.field)
    found = replace(found, free=free, told=told, law=law)
    return found.rescaled(1.0, ensemble.medium.diameter)


def _from_sums(ensemble: "Ensemble", name: str, times: Any) -> Sample:
    """From the sums that every run keeps: the averages alone."""
    sums = np.asarray(ensemble.moments[:, :, : R4 + 1])
    if ensemble.field:  # v_x, x and x^2 of the sums of a field
        found, dimension = ensemble.arrays["field_sums"], ensemble.medium.dimension
        half = found.shape[2] // 2
        sums = np.concatenate([sums, found[:, :, [0, half, half + dimension]]], axis=2)
    return Sample(
        (name,), times, sums, 1.0 / ensemble.plan.scales(),
        np.full(times.size, ensemble.medium.diameter),
        None, None, None, np.asarray(ensemble.trapped), "medium",
    )  # fmt: skip
