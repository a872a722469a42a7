"""The collision operator of one angular harmonic, as the symbol that a log-speed grid needs.

On e^(z x) with x = ln(speed) a bounce acts as multiplication by E[s^z cos(m chi)]: the operator
is diagonal in z, and everything else is built from these numbers.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw


def decay_symbol(law: CollisionLaw, z: NDArray[Any]) -> NDArray[Any]:
    """lambda(z) = 1 - E[s^z], shape of z; no range checks, for the solvers' inner loops."""
    if law.restitution == 0.0:
        return np.asarray(z / (1.0 + z))
    q = law.quadrature_for(float(np.abs(z).max()))
    return np.asarray(-np.expm1(-np.multiply.outer(z, q.log_loss)) @ q.weight)


def flux_symbol(law: CollisionLaw, z: NDArray[Any]) -> NDArray[Any]:
    """lambda(z)/(kappa z), 1 at z = 0: the flux of losses past a speed, relative to v at it."""
    zero = z == 0.0
    safe = np.where(zero, 1.0, z)
    return np.asarray(np.where(zero, 1.0, decay_symbol(law, safe) / (law.mean_log_loss * safe)))


def drift_log(law: CollisionLaw, z: NDArray[Any]) -> NDArray[Any]:
    """rho(z) = ln(kappa z/lambda(z)) = ln A(z+1) - ln A(z), A(z) = E[(kappa v t/l)^z]; z real.

    An estimate that only sizes windows: at large |z| the plain quadrature leaves a percent.
    """
    if law.restitution == 0.0:
        return np.asarray(np.log1p(z))
    q = law.quadrature
    zero = z == 0.0
    safe = np.where(zero, 1.0, z)
    decay = -np.expm1(-np.multiply.outer(safe, q.log_loss)) @ q.weight
    return np.asarray(np.where(zero, 0.0, np.log(law.mean_log_loss * safe / decay)))


def peak_position(law: CollisionLaw, z: NDArray[Any]) -> NDArray[Any]:
    """Where e^(z x) g(x) peaks in the scaling state, x = ln(kappa v t/l); an estimate, z real.

    The mean of x is the derivative of ln A, rho(z - 1/2) up to third differences of rho.
    """
    if law.restitution == 0.0:
        # the digamma function at 1 + z, nearly
        return np.asarray(np.log(z + 1.5) - 1.0 / (z + 1.0))
    return drift_log(law, z - 0.5)


def harmonic_symbol(law: CollisionLaw, z: NDArray[Any], m: int) -> NDArray[Any]:
    """1 - E[s^z cos(m chi)], shape of z (n,)."""
    q = law.quadrature_for(float(np.abs(z).max()), m)
    power = np.exp(-np.multiply.outer(z, q.log_loss))
    return np.asarray(1.0 - power @ (q.weight * q.harmonic(m)))
