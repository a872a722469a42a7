"""The collision term on the speed panels, one matrix for each harmonic."""

from __future__ import annotations

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.field.grid import SpeedPanels
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import gauss_legendre

_RATE = 70.0  # f falls no faster than v^-70 where it counts: for the average over impacts
_SMALL = 0.1  # -ln s below which changes of polynomials would lose digits
_STOPPED = 9.0  # -ln s of bounces that count as one: so slow tracers, 1e-4, are as few as that


def loss_matrices(panels: SpeedPanels, law: CollisionLaw, highest: int) -> FloatArray:
    """What harmonics 0 ... highest of a density lose by collisions per unit time, less their gain.

    Shape (highest + 1, size, size). A tracer of speed v collides at the rate v, and leaves with
    v s, s the speed ratio; of harmonic m cos(m chi) is kept, in space P_m(cos chi). The term is
    projected on the polynomials of each panel, all integrals over the speed split where tracers
    change to another panel. So mass and the balance of each power of the speed are kept, also of
    densities that are not smooth. As bounces become elastic no digits are lost: only what changes
    in a bounce is summed.
    """
    q = law.quadrature_for(_RATE, highest // 2)  # polynomials hide what is finer
    gone = np.array([q.harmonic_loss(m) for m in range(highest + 1)])
    kept, gone, lost = q.weight * (1.0 - gone), q.weight * gone, q.log_loss
    stopped = lost > _STOPPED
    if stopped.any():
        kept, gone = (np.c_[x[:, ~stopped], x[:, stopped].sum(axis=1)] for x in (kept, gone))
        mean = q.weight[stopped] @ q.ratio[stopped] / q.weight[stopped].sum()
        lost = np.append(lost[~stopped], -np.log(mean))
    ratio, edges, d = np.exp(-lost), np.array(panels.edges), law.dimension
    out = np.zeros((highest + 1, panels.size, panels.size))
    for p, source in enumerate(panels.parts):
        for t, target in enumerate(panels.parts[: p + 1]):
            low = np.maximum(edges[p], edges[t] / ratio)
            width = np.minimum(edges[p + 1], edges[t + 1] / ratio) - low
            if t == p - 1:  # to all digits
                short = np.minimum(edges[p] * np.expm1(lost), width)
                width = np.where(lost < _SMALL, short, width)
            used = np.nonzero(width > 0.0)[0]
            if used.size == 0:
                continue
            x, w = gauss_legendre(max(panels.counts[p], panels.counts[t]) + 1)
            v = low[used, None] + width[used, None] * x  # (n_used, n_points)
            weight = width[used, None] * w * v**d  # the volume, and the rate of collisions
            change = -np.expm1(-lost[used])[:, None] * v
            before = panels.rows(p, v[..., None] - panels.speeds[source])
            weighed = weight[..., None] * before
            loss = np.tensordot(gone[:, used], np.matmul(before.swapaxes(1, 2), weighed), axes=1)
            after = panels.rows(t, (v - change)[..., None] - panels.speeds[target])
            if t == p:
                changed = before - after
                small = np.nonzero(lost[used] < _SMALL)[0]
                if small.size:
                    changed[small] = _changes(panels, p, v[small], change[small])
            else:
                gained = np.matmul(after.swapaxes(1, 2), weighed)
                out[:, target, source] -= np.tensordot(kept[:, used], gained, axes=1)
                changed = before
            changed = np.matmul(changed.swapaxes(1, 2), weighed)
            out[:, source, source] += loss + np.tensordot(kept[:, used], changed, axes=1)
    return np.asarray(out / (panels.speeds ** (d - 1) * panels.weights)[:, None])


def _changes(panels: SpeedPanels, panel: int, v: FloatArray, change: FloatArray) -> FloatArray:
    """Polynomials at v less those at v - change, (*v.shape, nodes): integrals of their slope."""
    x, w = gauss_legendre(panels.counts[panel] // 2)
    nodes = panels.speeds[panels.parts[panel]]
    slopes = sum(
        share * panels.rows(panel, (v - point * change)[..., None] - nodes)
        for point, share in zip(x, w, strict=True)
    )
    return np.asarray(change[..., None] * (slopes @ panels.derivative(panel)))
