"""The collision term on the speed panels, one matrix for each harmonic.

Forwards, for the density, tracers that leave a collision with the speed v came with v/s, s the
speed ratio; backwards, for averages as functions of the first speed, they leave it with v s.
"""

from __future__ import annotations

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.field.panels import SpeedPanels
from kinetics.numerics import FloatArray

_LARGEST = 600.0  # an exponent that does not overflow


def collision_matrices(
    panels: SpeedPanels, law: CollisionLaw, highest: int, forwards: bool, rate: float
) -> FloatArray:
    """v^2 (1 - K_m) for m = 0 ... highest, shape (highest + 1, size, size).

    v (1 - K_m) is what harmonic m loses per unit time, less what it gains; another v multiplies
    the whole equation. Forwards K_m f(v) = E[s^-(d+1) cos(m chi) f(v/s)], with f = 0 above the
    panels, and backwards E[cos(m chi) f(v s)]; in space with P_m(cos chi). The matrices keep their
    digits as bounces become elastic: the diagonal is summed from what changes in a bounce.

    rate : f varies as fast as v^rate
    """
    q = law.quadrature_for(rate, highest)
    harmonics = range(highest + 1)
    power = law.dimension + 1.0 if forwards else 0.0
    # bounces that nearly stop a tracer come from above the panels: their factor is not used
    factor = q.weight * np.exp(np.minimum(power * q.log_loss, _LARGEST))
    kept = factor * np.array([q.harmonic(m) for m in harmonics])
    gone = factor * np.array([q.harmonic_loss(m) for m in harmonics])
    # of 1 - s^-power cos(m chi)
    gone -= q.weight * np.expm1(np.minimum(power * q.log_loss, _LARGEST))
    change = np.expm1(np.minimum(q.log_loss, _LARGEST) if forwards else -q.log_loss)
    out = np.zeros((highest + 1, panels.size, panels.size))
    for own, part in enumerate(panels.parts):
        v = panels.speeds[part]
        reached = v[:, None] * (1.0 + change)
        where = panels.panel_of(reached)
        if forwards:
            where[reached > panels.highest] = -1
            where[where >= 0] = np.maximum(where[where >= 0], own)
        else:
            where = np.minimum(where, own)
        for p in range(own, len(panels.parts)) if forwards else range(own + 1):
            inside = where == p
            used = np.nonzero(inside.any(axis=0))[0]
            if used.size == 0:
                continue
            # a node and itself shifted are apart by the shift, to all digits
            i, k = np.nonzero(inside[:, used])
            apart = (v[:, None] - panels.speeds[panels.parts[p]])[i]
            apart += (v[i] * change[used][k])[:, None]
            rows = np.zeros((v.size, used.size, panels.counts[p]))
            rows[i, k] = panels.rows(p, apart)
            if p == own:
                here = np.arange(v.size)
                rows[here, :, here] = 0.0
                diagonal = kept[:, used] @ rows.sum(axis=2).T
                diagonal += gone[:, used] @ inside[:, used].T
                diagonal += ~inside @ q.weight
                out[:, part, part][:, here, here] = diagonal
            gained = np.matmul(kept[None, :, used], rows)
            out[:, part, panels.parts[p]] -= np.moveaxis(gained, 1, 0)
    return np.asarray(panels.speeds[:, None] ** 2 * out)
