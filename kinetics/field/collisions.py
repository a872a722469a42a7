"""The collision term on the speed panels, one matrix for each harmonic.

Forwards, for the density, tracers that leave a collision with the speed v came with v/s, s the
speed ratio; backwards, for averages as functions of the first speed, they leave it with v s.
"""

from __future__ import annotations

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.field.panels import SpeedPanels
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import gauss_legendre, panels_between

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
            if used.size == 0 and p != own:
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


def gain_matrices(panels: SpeedPanels, law: CollisionLaw, highest: int, rate: float) -> FloatArray:
    """What harmonics 0 ... highest of a density gain per unit time, (highest + 1, size, size).

    The gain is projected on the polynomials of each panel, all integrals over the speed split
    where tracers change to another panel. So mass is kept, and the gain of a density that is not
    smooth has the right averages over smooth functions.

    rate : of the quadrature over the impact parameter, see `collision_matrices`
    """
    q = law.quadrature_for(rate, highest)
    ratio = np.maximum(np.exp(-q.log_loss), 1e-300)
    share = q.weight * np.array([q.harmonic(m) for m in range(highest + 1)])
    edges, d = np.array(panels.edges), law.dimension
    out = np.zeros((highest + 1, panels.size, panels.size))
    for p, source in enumerate(panels.parts):
        for t, target in enumerate(panels.parts[: p + 1]):
            low = np.maximum(edges[p], edges[t] / ratio)
            high = np.minimum(edges[p + 1], edges[t + 1] / ratio)
            used = np.nonzero(high > low * (1.0 + 1e-14))[0]
            if used.size == 0:
                continue
            x, w = gauss_legendre(max(panels.counts[p], panels.counts[t]) + 1)
            width = (high - low)[used, None]
            v = low[used, None] + width * x
            weight = width * w * v**d  # the volume, and the rate of collisions
            before = panels.rows(p, v.reshape(-1, 1) - panels.speeds[source])
            after = panels.rows(t, (v * ratio[used, None]).reshape(-1, 1) - panels.speeds[target])
            for m in range(highest + 1):
                every = (share[m, used, None] * weight).reshape(-1, 1)
                out[m][target, source] += (after * every).T @ before
    return np.asarray(out / (panels.speeds ** (d - 1) * panels.weights)[:, None])


def rate_matrix(panels: SpeedPanels, dimension: int) -> FloatArray:
    """The rate of collisions v times a density, projected as in `gain_matrices`, (size, size).

    Elastic bounces then take as much as they give, to rounding.
    """
    out = np.zeros((panels.size, panels.size))
    for p, part in enumerate(panels.parts):
        v, w = panels_between(np.array(panels.edges[p : p + 2]), panels.counts[p] + 1)
        rows = panels.rows(p, v[:, None] - panels.speeds[part])
        out[part, part] = (rows * (w * v**dimension)[:, None]).T @ rows
    return out / (panels.speeds ** (dimension - 1) * panels.weights)[:, None]
