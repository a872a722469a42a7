"""Runs of the package's own simulator, in memory or in their files, as a sample."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kinetics.crosscheck.comparison.data.columns import shown
from kinetics.crosscheck.comparison.data.frames import rows_of
from kinetics.crosscheck.comparison.reduction import Reduction
from kinetics.crosscheck.comparison.sample import R4, Binned, Law, Sample
from kinetics.errors import InputError

if TYPE_CHECKING:
    from particles.ensemble import Ensemble


def is_ensemble(path: Path) -> bool:
    """Whether a file is a run of `lorentz simulate` or Ensemble.save."""
    if path.suffix.lower() not in (".h5", ".hdf5", ".h5md") or not path.is_file():
        return False
    import h5py

    try:
        with h5py.File(path, "r") as file:
            return "plan" in file.attrs
    except OSError:
        return False  # the reader of columns says what is wrong


def read_ensemble(path: Path) -> Sample:
    """The sample of a finished run in a file, lengths in d; InputError for a damaged one."""
    from particles import Ensemble

    try:
        run = Ensemble.load(path)
    except ValueError as error:
        raise InputError(" ".join(str(error).split())) from None
    return from_ensemble(run, shown(path.name)).rescaled(1.0, run.medium.diameter)


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
    reduction = Reduction(grouping, with_field=bool(ensemble.field))
    positions, velocities = ensemble.positions, ensemble.velocities
    for k, time in enumerate(ensemble.times):
        there = np.isfinite(velocities[k, :, 0])
        rows = rows_of(name, float(time), positions[k, there], velocities[k, there], label[there])
        reduction.add(replace(rows, medium=label[there] // ensemble.tracers))
    return reduction.sample((name,))


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
