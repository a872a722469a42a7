"""How long the speeds remember where they started."""

from __future__ import annotations

import math
from functools import lru_cache

from kinetics.collision.law import CollisionLaw


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
