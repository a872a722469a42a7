r"""How long the speeds remember where they started, under a law that loses by steps.

What an initial state adds to the scaling state is a sum of terms e^(z tau), tau = ln t, over the
zeros z of lambda(z) = 1 - E[s^z] with Re z < 0. If the loss -ln s may take any value from 0 on, as
at smooth scatterers, all of them fall faster than 1/t. If every loss is a multiple of one number L
(et = e: L = -ln e; or samples of one ratio), then lambda vanishes at z = 2 pi i n/L: v t/l keeps
oscillating in ln t for ever. Where the losses are nearly so, the oscillations die slowly.
"""

from __future__ import annotations

import cmath
import math
from functools import lru_cache

import numpy as np

from kinetics.collision.law import CollisionLaw
from kinetics.numerics import FloatArray

_STEPS = 0.25  # of the wave number, times the largest loss: zeros are about 2 pi apart in it
_RARE = 0.01  # share of the bounces that lose more than the largest loss that counts there
_ROUNDING = 40.0  # e-folds: the largest loss, and the smallest weight, e^-40 = 4e-18
_LINES = (0.0, -0.3, -0.6, -0.9)  # real parts at which the size of lambda is scanned
_FOUND, _SAME = 1e-12, 1e-6  # the last step of Newton's method; what is 0 of a zero


@lru_cache(maxsize=48)
def oscillations(law: CollisionLaw, highest: float) -> tuple[complex, ...]:
    """The zeros z of lambda(z) with -1 < Re z <= 0 and 0 < -Im z < highest, by -Im z.

    None at smooth scatterers: only laws that have a least loss, that take single values of s, or
    that are mixtures are looked at.
    """
    smooth = law.least_loss == 0.0 and not law.has_atoms and len(law.bounces) == 1
    if law.is_elastic or smooth:
        return ()
    # bounces that lose nothing take a single value too, but leave no waves
    steps = any(part.has_atoms and part.losses[1] > 0.0 for _, part in law.bounces)
    if not steps:
        highest = min(highest, 64.0)  # faster waves fall faster than 1/t there
    q = law.quadrature_for(highest)
    # at Re z = -1 a bounce counts s^-1 times its weight; what is rounding even there is left out
    counts = np.log(np.maximum(q.weight, 1e-300)) + np.minimum(q.log_loss, _ROUNDING)
    kept = counts > counts.max() - _ROUNDING
    order = np.argsort(q.log_loss[kept])
    log_loss, weight = q.log_loss[kept][order], q.weight[kept][order]
    beyond = np.cumsum(weight[::-1])[::-1]
    # where s is continuous, its density is less
    counts = beyond > _RARE * (np.exp(-log_loss) if steps else 1.0)
    largest = min(max(1.0, float(log_loss[counts].max())), _ROUNDING)
    k = np.arange(0.0, highest + _STEPS, _STEPS / largest)
    pieces = np.array_split(k, 1 + k.size * weight.size // 1_000_000)
    found: dict[tuple[float, float], complex] = {}
    for real in _LINES:
        tilted = weight * np.exp(np.minimum(-real * log_loss, _ROUNDING))
        size = np.concatenate(
            [abs(1.0 - np.exp(1j * np.multiply.outer(x, log_loss)) @ tilted) for x in pieces]
        )
        least = 1 + np.nonzero((size[1:-1] <= size[:-2]) & (size[1:-1] <= size[2:]))[0]
        for start in k[least]:
            z = _zero_near(weight, log_loss, complex(real, -start))
            if z is not None and -1.0 < z.real < _SAME and _SAME < -z.imag < highest:
                found[round(z.real, 5), round(z.imag, 5)] = complex(min(z.real, 0.0), z.imag)
    return tuple(sorted(found.values(), key=lambda z: -z.imag))


def _zero_near(weight: FloatArray, log_loss: FloatArray, z: complex) -> complex | None:
    """A zero of 1 - sum weight s^z by Newton's method from z on; None where it finds none."""
    for _ in range(40):
        with np.errstate(over="ignore", invalid="ignore"):
            power = weight * np.exp(-z * log_loss)
            step = complex((1.0 - power.sum()) / (power @ log_loss))
        if not cmath.isfinite(step) or z.real < -2.0:
            return None
        z -= step / max(1.0, 2.0 * abs(step))
        if abs(step) < _FOUND:
            return z
    return None


@lru_cache(maxsize=48)
def asymptotic_from(law: CollisionLaw) -> float:
    """X = ln T from which averages of a cooling tracer are asymptotic; inf at rough scatterers.

    Corrections fall as T^(Re z), over the zeros z of 1 - E[s^z cos(m chi)]. Smooth scatterers have
    Re z <= -0.736 (disks with e = 0.03, m = 1): what is left is 6e-13 at worst. Where e < 0 tracers
    keep their direction for long, and the largest z, of m = 1, is real.
    """
    e, slowest = law.effective_restitution, -1.0
    if law.tangential_restitution != 1.0:
        return math.inf
    if e is not None and e < 0.0 and law.harmonic_decay_rate(slowest, 1) < 0.0:
        from scipy.optimize import brentq

        slowest = brentq(lambda z: law.harmonic_decay_rate(z, 1), slowest, 0.0, rtol=1e-9)
    return 38.0 / -slowest - math.log(law.mean_log_loss)


def time_to_forget(z: complex, amplitude: float) -> float:
    """tau at which amplitude e^(Re z tau) has fallen to 1; 0 if it is smaller, inf if it stays."""
    if amplitude <= 1.0:
        return 0.0
    return math.log(amplitude) / -z.real if z.real < -_SAME else math.inf


def common_loss(law: CollisionLaw, highest: float) -> float | None:
    """L where every loss -ln s is a multiple of L, and L > 2 pi/highest; None at other laws."""
    lasting = [z for z in oscillations(law, highest) if z.real > -_SAME]
    return 2.0 * math.pi / abs(lasting[0].imag) if lasting else None
