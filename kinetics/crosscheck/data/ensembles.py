"""Samples of runs of the package's simulator."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kinetics.collision.impact import ImpactRestitution, Viscoelastic, impact_restitution
from kinetics.crosscheck.data.options import refuse_data
from kinetics.crosscheck.data.sample import (
    R2,
    R4,
    V2,
    V4,
    Array,
    Law,
    N,
    Sample,
    Stated,
    reduce_tracks,
)
from kinetics.crosscheck.data.tracks import Tracks
from kinetics.validation import refuse

if TYPE_CHECKING:
    from particles import Ensemble

#: Powers of the speed in the sums that every run keeps, by the column of a `Sample`.
SPEED_POWERS = {N: 0, V2: 2, V4: 4, R2: 0, R4: 0}


def sample_of_ensemble(ensemble: object, name: str = "ensemble") -> Sample:
    """Return the sample of a run, lengths in d.

    Counts in bins are in it too, where the run keeps velocities and positions.

    Raises
    ------
    InputError
        It is no run, has no output times or fewer than two groups, or was driven among scatterers
        that have places.
    """
    from dataclasses import replace

    from particles import BoltzmannGrad, Ensemble

    if not isinstance(ensemble, Ensemble):
        refuse("data", ensemble, "it must be a file, several files, columns or a run of simulate")
    diameter = ensemble.medium.diameter
    times = np.asarray(ensemble.times) / diameter
    if times.size == 0 or ensemble.moments.size == 0:
        refuse_data(name, "a run without output times", "made by simulate(..., times=...)")
    # Tracers of a Boltzmann-Grad run share no scatterers: each of them is independent.
    is_free = isinstance(ensemble.medium, BoltzmannGrad)
    has_tracks = {"raw/velocities", "raw/positions"} <= set(ensemble.arrays)
    if has_tracks:
        sample = _from_tracks(ensemble, name, times, is_free)
    else:
        sample = _from_sums(ensemble, name, times)
    if sample.groups < 2:
        refuse_data(name, "one configuration", "two at least, for standard errors")
    restitution = _restitution_of(ensemble)
    law = Law(
        restitution=impact_restitution(restitution),
        dimension=ensemble.medium.dimension,
        bath_speed=ensemble.bath_speed,
        mass_ratio=ensemble.mass_ratio,
        heating=ensemble.heating * diameter,
        drag=ensemble.drag * diameter,
        field=ensemble.field * diameter,
        capture_speed=ensemble.capture_speed,
        tangential_restitution=ensemble.tangential_restitution,
    )
    if law.is_driven and not is_free:
        found = "a driven run among scatterers that have places"
        refuse_data(name, found, "one of BoltzmannGrad")
    stated = _what_the_run_says(ensemble, restitution)
    return replace(sample, free=is_free, told=stated, law=law)


def _from_tracks(ensemble: Ensemble, name: str, times: Array, is_free: bool) -> Sample:
    """Return the sample of a run that keeps velocities and positions."""
    place = np.asarray(ensemble.positions) / ensemble.medium.diameter
    velocity = np.asarray(ensemble.velocities)
    if ensemble.capture_speed > 0.0:  # averages are over those that move
        is_moving = velocity.any(axis=2, keepdims=True)
        velocity = np.where(is_moving, velocity, np.nan)
    label = np.arange(place.shape[1])
    grouping = "tracer"
    if not is_free:
        label = label // ensemble.tracers
        grouping = "medium"
    tracks = Tracks(times, place, velocity)
    return reduce_tracks(tracks, label, (name,), grouping, bool(ensemble.field))


def _from_sums(ensemble: Ensemble, name: str, times: Array) -> Sample:
    """Return the sample of the sums that every run keeps: the averages alone."""
    from particles.outputs import CAUGHT

    unit = 1.0 / ensemble.plan.scales()
    scale = np.stack([unit**power for power in SPEED_POWERS.values()], axis=-1)
    sums = ensemble.moments[:, :, : R4 + 1] * scale
    if ensemble.field:
        sums = np.concatenate([sums, _field_sums(ensemble)], axis=2)
    if ensemble.capture_speed > 0.0:
        sums[:, :, N] -= ensemble.moments[:, :, CAUGHT]
    return Sample(
        names=(name,),
        times=times,
        sums=sums,
        at_rest=np.asarray(ensemble.trapped),
        grouping="medium",
    )


def _field_sums(ensemble: Ensemble) -> Array:
    """Return the sums of v_x, x, x^2, v_y, ... of a run in a field.

    It keeps those of v, of v_i v_j (i <= j), of r, and of r_i r_j.
    """
    sums = ensemble.arrays["field_sums"]
    n_axes = ensemble.medium.dimension
    half = sums.shape[2] // 2
    place_of_square = [0, n_axes, 2 * n_axes - 1]  # of r_i r_i among the r_i r_j
    columns = []
    for axis in range(n_axes):
        columns += [axis, half + axis, half + n_axes + place_of_square[axis]]
    return np.asarray(sums[:, :, columns])


def _restitution_of(ensemble: Ensemble) -> float | ImpactRestitution:
    """Return the restitution of a run as the solver has it."""
    from particles.impact import Viscoelastic as ViscoelasticOfRun

    restitution = ensemble.restitution
    if isinstance(restitution, float):
        return restitution
    if isinstance(restitution, ViscoelasticOfRun):
        return Viscoelastic(restitution.b)
    table = impact_restitution((restitution.speeds, restitution.values))
    assert table is not None
    return table


def _what_the_run_says(ensemble: Ensemble, restitution: float | ImpactRestitution) -> Stated:
    """Return restitution, density, scatterers and, where it has a name, the start of a run."""
    medium = ensemble.medium
    stated = Stated(
        restitution=restitution,
        number_density=ensemble.number_density * medium.diameter**medium.dimension,
        scatterers=medium.scatterers,
    )
    plan = ensemble.plan
    if plan.rest:
        stated["initial"] = "rest"
    elif plan.velocities is None and plan.monoenergetic:
        stated["initial"] = "monoenergetic"
    elif plan.velocities is None:
        stated["initial"] = "gaussian"
    return stated
