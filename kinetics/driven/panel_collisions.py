"""What collisions do to the harmonics of a distribution on panels of speeds.

A tracer of speed v collides at the rate v, and leaves with v s; of harmonic m cos(m chi) is kept,
in space P_m(cos chi), chi the angle of deflection. Begin with `loss_matrices`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.driven.panels import SpeedPanels
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import gauss_legendre

#: f falls no faster than v^-70 where it counts: for the average over impacts. Measured: at half and
#: at twice averages in a field move by 1e-9.
FASTEST_POWER = 70.0
#: -ln s below which changes of polynomials would lose digits. Measured: at half and at twice
#: averages move by 1e-12.
SMALL_LOG_LOSS = 0.1
#: -ln s of bounces that count as one: so slow tracers, 1e-6, are as few as that.
STOPPED_LOG_LOSS = 14.0


@dataclass(frozen=True)
class HarmonicBounces:
    """What harmonics keep and lose in bounces; each bounce has its ratio s of the speeds.

    Parameters
    ----------
    kept : the weight of the bounce times the share that it keeps, (count, n_bounces)
    lost : the weight times the share that it takes, (count, n_bounces)
    log_loss : -ln s, (n_bounces,)
    """

    kept: FloatArray
    lost: FloatArray
    log_loss: FloatArray


def harmonic_bounces(law: CollisionLaw, rate: float, highest: int) -> HarmonicBounces:
    """Return the bounces of harmonics 0 ... highest; all that nearly stop a tracer are one.

    rate : integrals over functions as fast as s^rate are right
    """
    impacts = law.quadrature_for(rate, highest // 2)
    share_lost = np.array(list(impacts.harmonic_losses(highest)))
    kept = impacts.weight * (1.0 - share_lost)
    lost = impacts.weight * share_lost
    log_loss = impacts.log_loss
    is_stopped = log_loss > STOPPED_LOG_LOSS
    if not is_stopped.any():
        return HarmonicBounces(kept, lost, log_loss)
    stopped_weight = impacts.weight[is_stopped]
    mean_ratio = stopped_weight @ impacts.ratio[is_stopped] / stopped_weight.sum()
    return HarmonicBounces(
        kept=_with_last_merged(kept, is_stopped),
        lost=_with_last_merged(lost, is_stopped),
        log_loss=np.append(log_loss[~is_stopped], -np.log(mean_ratio)),
    )


def _with_last_merged(shares: FloatArray, is_merged: NDArray[np.bool_]) -> FloatArray:
    """Return columns without those that are merged, and with their sum as the last one."""
    return np.column_stack([shares[:, ~is_merged], shares[:, is_merged].sum(axis=1)])


def loss_matrices(panels: SpeedPanels, law: CollisionLaw, highest: int) -> FloatArray:
    """Return what harmonics 0 ... highest of a density lose per unit time, less their gain.

    Integrals over the speed are split where tracers change to another panel, so mass and the
    balance of each power of the speed are kept, also of densities that are not smooth. Only what
    changes in a bounce is summed: no digits are lost as bounces become elastic.

    Returns
    -------
    Shape (highest + 1, size, size)
    """
    bounces = harmonic_bounces(law, FASTEST_POWER, highest)
    losses = np.zeros((highest + 1, panels.size, panels.size))
    for source in range(len(panels.counts)):
        for target in range(source + 1):
            _add_losses(losses, panels, bounces, source, target, law.dimension)
    return np.asarray(losses / panels.volumes(law.dimension))


def _add_losses(
    losses: FloatArray,
    panels: SpeedPanels,
    bounces: HarmonicBounces,
    source: int,
    target: int,
    dimension: int,
) -> None:
    """Add what harmonics lose by bounces from one panel to one that is not above it."""
    low, width = _speeds_between(panels, bounces.log_loss, source, target)
    used = np.nonzero(width > 0.0)[0]
    if used.size == 0:
        return
    from_ = panels.parts[source]
    to = panels.parts[target]
    kept = bounces.kept[:, used]
    log_loss = bounces.log_loss[used]
    x, x_weight = gauss_legendre(max(panels.counts[source], panels.counts[target]) + 1)
    v = low[used, None] + width[used, None] * x  # (n_used, n_points)
    weight = width[used, None] * x_weight * v**dimension  # the volume, and the rate of collisions
    change = -np.expm1(-log_loss)[:, None] * v
    before = panels.rows(source, v)
    weighted = weight[..., None] * before
    lost = np.matmul(before.swapaxes(1, 2), weighted)
    loss = np.tensordot(bounces.lost[:, used], lost, axes=1)
    after = panels.rows(target, v - change)
    if target == source:
        changed = before - after
        is_small = np.nonzero(log_loss < SMALL_LOG_LOSS)[0]
        if is_small.size:
            changed[is_small] = _changes(panels, source, v[is_small], change[is_small])
    else:
        gained = np.matmul(after.swapaxes(1, 2), weighted)
        losses[:, to, from_] -= np.tensordot(kept, gained, axes=1)
        changed = before
    changes = np.matmul(changed.swapaxes(1, 2), weighted)
    losses[:, from_, from_] += loss + np.tensordot(kept, changes, axes=1)


def _speeds_between(
    panels: SpeedPanels, log_loss: FloatArray, source: int, target: int
) -> tuple[FloatArray, FloatArray]:
    """Return the lowest speed in one panel from which bounces lead to another, and the width."""
    edges = np.array(panels.edges)
    ratio = np.exp(-log_loss)
    low = np.maximum(edges[source], edges[target] / ratio)
    width = np.minimum(edges[source + 1], edges[target + 1] / ratio) - low
    if target == source - 1:  # to all digits where s is near 1
        short = np.minimum(edges[source] * np.expm1(log_loss), width)
        width = np.where(log_loss < SMALL_LOG_LOSS, short, width)
    return low, width


def _changes(panels: SpeedPanels, panel: int, v: FloatArray, change: FloatArray) -> FloatArray:
    """Return polynomials at v less those at v - change, (*v.shape, nodes): integrated slopes."""
    x, weight = gauss_legendre(panels.counts[panel] // 2)
    mean = sum(
        share * panels.rows(panel, v - point * change)
        for point, share in zip(x, weight, strict=True)
    )
    return np.asarray(change[..., None] * (mean @ panels.derivative(panel)))
