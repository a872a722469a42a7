"""How far the scaling state reaches upwards, and how fine it is: estimates that size grids."""

from __future__ import annotations

import math

import numpy as np

from kinetics.collision import CollisionLaw

_REACHES = (14.0, 60.0, 300.0)  # wave numbers that are tried, over the deviation
_STEPS = 32  # of each try
_OWN_FACTOR = 5.0  # a density of x falls as e^-(e^x) high up: its own factor e^x is allowed for


def small_deviation(law: CollisionLaw) -> float:
    """The root of E[xi^2]/(2 kappa): the deviation of x = ln(kappa v t/l) where that is small."""
    q = law.quadrature
    return math.sqrt(float(q.weight @ q.log_loss**2) / (2.0 * law.mean_log_loss))


def extent_of(law: CollisionLaw, depth: float) -> tuple[float, float]:
    """x above which the scaling state weighs e^-depth, and where its transform is that small.

    The transform of its density is A(i k), A(z) = E[(kappa v t/l)^z]. The derivative of ln A is
    nearly rho(z - 1/2), rho(z) = ln A(z + 1) - ln A(z) = ln(kappa z/lambda(z)), for Re z >= 1/2.
    """
    deviation = small_deviation(law)
    q, kappa = law.quadrature, law.mean_log_loss
    # Chernoff's bound
    p = np.geomspace(1e-3, 60.0, 120) / deviation
    middle = 0.5 * (p + np.append(0.0, p[:-1])) - 0.5
    middle = np.where(np.abs(middle) < 1e-6, 1e-6, middle)
    decay = law.met_again(middle, -np.expm1(-np.multiply.outer(middle, q.log_loss)) @ q.weight, 0)
    log_a = np.cumsum(np.log(kappa * middle / decay) * np.diff(p, prepend=0.0))
    right = float(np.min((log_a + depth + _OWN_FACTOR) / p))
    band = 0.0
    for reach in _REACHES:
        k = np.linspace(0.0, reach / deviation, _STEPS)
        # ln A(i k) = ln A(1 + i k) - rho(i k), and up the line from there
        z = np.stack([1j * k, 0.5 + 1j * k])
        z[0, 0] = 1e-6
        log_rho = np.log(kappa * z / law.decay_symbol(z.ravel()).reshape(z.shape))
        turn = np.unwrap(log_rho[1].imag)
        fall = np.append(0.0, np.cumsum(0.5 * (turn[1:] + turn[:-1]) * np.diff(k)))
        fall += log_rho[0].real - log_rho[0, 0].real
        if fall[-1] > depth:
            i = int(np.nonzero(fall <= depth)[0][-1]) + 1  # before, A may vanish at single k
            share = (depth - fall[i - 1]) / (fall[i] - fall[i - 1])
            return right, float(k[i - 1] + share * (k[i] - k[i - 1]))
        band = float(k[-1])
    return right, band
