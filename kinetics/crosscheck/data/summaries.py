"""Samples of what is summed up already: tables of averages, and runs of the package's simulator.

A table such as `t,v0,v0_error,msd,msd_error` says nothing of single tracers. Its sample has groups
that are made up: their mean is the average of the table, and their spread gives its standard error.
Errors of different averages and times are made independent, as the table does not say how they are
correlated.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.data.sample import R2, R4, V2, V4, Binned, Law, N, Sample, reduced
from kinetics.crosscheck.data.tracks import MOST_TIMES, Averages, Tracks, name_of
from kinetics.errors import InputError

if TYPE_CHECKING:
    from particles.ensemble import Ensemble

Array = NDArray[np.float64]

GROUPS = 1000
"""Groups that are made up: so many that errors are as good as exact."""


def of_averages(table: Averages, names: tuple[str, ...], law: Law) -> Sample:
    """The sample of a table, in its own units; InputError for one that cannot be used."""
    where = ", ".join(names)
    order = np.argsort(table.columns["time"])
    columns = {name: np.asarray(values, float)[order] for name, values in table.columns.items()}
    times = columns.pop("time")
    if not times.size or times[0] < 0 or np.any(np.diff(times) <= 0) or times.size > MOST_TIMES:
        raise InputError(
            f"{where}: a table of averages needs 1 to {MOST_TIMES} different times, not negative"
        )
    for name, values in columns.items():
        if name.startswith("error of ") and np.any(values < 0):
            raise InputError(f"{where}: an {name} is negative")
    sums, left_out = _sums(columns, law)
    if not np.any(np.isfinite(sums[0, :, [V2, R2]])):
        raise InputError(f"{where}: no average has a value and a standard error above 0")
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
    spread = _Spread(first.size * len(columns))
    sums = np.full((GROUPS, first.size, 5), np.nan)
    sums[..., N] = 1.0
    relative: dict[int, Array] = {}
    for name, column, power in (
        ("thermal_speed", V2, 2.0), ("mean_square_speed", V2, 1.0), ("msd", R2, 1.0)
    ):  # fmt: skip
        if name in columns and column not in relative:
            value, error = _usable(columns, name)
            relative[column] = spread.of(power * error / value)
            sums[..., column] = value**power * (1 + relative[column])
    left_out = []
    for name, column, second in (("a2", V4, V2), ("kurtosis", R4, R2)):
        if name not in columns:
            continue
        if second not in relative:
            left_out.append(name)
            continue
        value, error = _usable(columns, name)
        size = law.gaussian * (1 + value) if name == "a2" else value
        unit = law.gaussian if name == "a2" else 1.0
        mean = sums[..., second].mean(axis=0)
        # The ratio to the squared second moment has the spread that the table gives it.
        wanted = spread.of(unit * error / size) + 2 * relative[second]
        sums[..., column] = size * mean**2 * (1 + wanted)
    return sums, left_out


def _usable(columns: Mapping[str, Array], name: str) -> tuple[Array, Array]:
    value, error = columns[name], columns[f"error of {name}"]
    good = np.isfinite(value) & (error > 0) & (np.isfinite(error)) & ((value > 0) | (name == "a2"))
    return np.where(good, value, np.nan), np.where(good, error, np.nan)


class _Spread:
    """Deviations of groups from their mean, which are orthogonal for different averages."""

    def __init__(self, most: int) -> None:
        rng = np.random.default_rng(0)
        free = rng.normal(size=(GROUPS, min(most + 1, GROUPS - 1)))
        free[:, 0] = 1.0
        self._axes, _ = np.linalg.qr(free)
        self._next = 1

    def of(self, relative: Any) -> Any:
        """Deviations (GROUPS, n) whose mean is 0 and has these standard errors (n,)."""
        at = 1 + (self._next - 1 + np.arange(relative.size)) % (self._axes.shape[1] - 1)
        self._next += relative.size
        return self._axes[:, at] * relative * np.sqrt(GROUPS * (GROUPS - 1))


# -- runs of the simulator -------------------------------------------------------------------------


def is_ensemble(path: Any) -> bool:
    """Whether a source is a file of `lorentz simulate` or Ensemble.save."""
    if not isinstance(path, Path) or path.suffix.lower() not in (".h5", ".hdf5", ".h5md"):
        return False
    import h5py

    try:
        if not path.is_file():
            return False
        with h5py.File(path, "r") as file:
            return "plan" in file.attrs
    except (OSError, ValueError):
        return False  # the reader of columns says what is wrong


def read_ensemble(path: Path) -> Sample:
    """The sample of a finished run in a file, lengths in d; InputError for a damaged one."""
    from particles import Ensemble

    try:
        run = Ensemble.load(path)
    except ValueError as error:
        raise InputError(" ".join(str(error).split())) from None
    return from_ensemble(run, name_of(Path(path.name))).rescaled(1.0, run.medium.diameter)


def from_ensemble(ensemble: "Ensemble", name: str = "ensemble") -> Sample:
    """The sums of a particle run, in its own unit of length.

    With stored velocities and positions, histograms are by configuration. InputError for a run
    without output times or with fewer than two groups.
    """
    from particles import BoltzmannGrad

    times = np.asarray(ensemble.times)
    if times.size == 0 or ensemble.moments.size == 0:
        raise InputError(f"{name}: this run has no output times; simulate(..., times=...)")
    # Tracers of a Boltzmann-Grad run share no scatterers: each of them is independent.
    free = isinstance(ensemble.medium, BoltzmannGrad)
    stored = ensemble.arrays
    law = Law(ensemble.tangential_restitution, ensemble.medium.dimension, ensemble.field)
    if "raw/velocities" in stored and "raw/positions" in stored:
        found = _from_tracers(ensemble, name, "tracer" if free else "medium")
    else:
        found = _from_sums(ensemble, name, times, free)
    if found.groups < 2:
        raise InputError(f"{name}: has one configuration; standard errors need at least two")
    plan = ensemble.plan
    told: dict[str, Any] = {
        "restitution": ensemble.restitution,
        "number_density": ensemble.number_density,
    }
    if plan.velocities is None:
        told["initial"] = "monoenergetic" if plan.monoenergetic else "gaussian"
    if plan.rest:
        told["initial"] = "rest"
    return replace(found, capped=plan.max_collisions, free=free, told=told, law=law)


def _from_tracers(ensemble: "Ensemble", name: str, grouping: str) -> Sample:
    label = np.arange(ensemble.media * ensemble.tracers)
    velocity = np.asarray(ensemble.velocities)
    tracks = Tracks(np.asarray(ensemble.times), np.asarray(ensemble.positions), velocity)
    group = label // ensemble.tracers if grouping == "medium" else label
    return reduced(tracks, group, (name,), grouping, bool(ensemble.field))


def _from_sums(ensemble: "Ensemble", name: str, times: Any, free: bool) -> Sample:
    """From the sums that every run keeps."""
    unit = ensemble.medium.diameter
    sums = np.asarray(ensemble.moments[:, :, : R4 + 1])
    if ensemble.field:  # v_x, x and x^2 of the sums of a field
        found, dimension = ensemble.arrays["field_sums"], ensemble.medium.dimension
        half = found.shape[2] // 2
        along = found[:, :, [0, half, half + dimension]]
        sums = np.concatenate([sums, along], axis=2)
    return Sample(
        names=(name,),
        times=times,
        sums=sums,
        speed_scale=1.0 / ensemble.plan.scales(),
        length_scale=np.full(times.size, unit),
        speeds=_histogram(ensemble, "speed_histogram", free),
        displacements=_histogram(ensemble, "displacement_histogram", free),
        start=None,
        at_rest=np.asarray(ensemble.trapped),
        grouping="medium",
    )


def _histogram(ensemble: "Ensemble", name: str, free: bool) -> Binned | None:
    key = f"histograms/{name}/sums"
    if key not in ensemble.arrays:
        return None
    found = getattr(ensemble, name)
    totals = ensemble.arrays[key][0]
    n = totals.sum(axis=1)
    effect = np.ones(len(totals))
    if not free:
        p, error = found.probability.value, found.probability.error
        # The variance over the binomial one, of bins with counts enough for both to be known.
        used = totals[:, 1:-1] >= 20
        with np.errstate(invalid="ignore", divide="ignore"):
            binomial = np.where(used, p * (1 - p) / n[:, None], 0.0).sum(axis=1)
            effect = np.where(used, error**2, 0.0).sum(axis=1) / binomial
        effect = np.where(np.isfinite(effect), np.maximum(effect, 1.0), 1.0)
    edges = np.broadcast_to(found.edges, (len(totals), found.edges.size))
    return Binned(np.asarray(edges), totals, None, effect)
