"""The collision operator of one angular harmonic, as the symbol that a log-speed grid needs.

On e^(z x) with x = ln(speed) a bounce acts as multiplication by E[s^z cos(m chi)]: the operator
is diagonal in z, and everything else is built from these numbers.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw

_MANY = 3000  # exponentials from which products of matrices are faster; both give the same
_CLOSE_TO_REST = 1e-16  # corrections are of that order
_LITTLE_LOST = 0.2399  # share of energy lost (e = 0.8) below which 1 - E[s^z] loses a digit


def decay_symbol_on_line(
    law: CollisionLaw, theta: float, wave_numbers: NDArray[Any]
) -> NDArray[Any]:
    """lambda(theta - i k) for equidistant k from 0, shape of k.

    Where the average over the impact parameter takes many points, exp(i k xi) is a product of two
    factors: instead of n exponentials for each point, 2 sqrt(n) of them and a product of matrices.
    """
    z = theta - 1j * wave_numbers
    if math.isfinite(law.lowest_power) or law.energy_loss < _LITTLE_LOST:
        return law.decay_symbol(z)
    q = law.quadrature_for(float(np.abs(z[[0, -1]]).max()))
    if z.size * q.weight.size < _MANY:
        return law.decay_symbol(z)
    fine = math.ceil(math.sqrt(z.size))
    coarse = -(-z.size // fine)
    turn = 1j * wave_numbers[1] * q.log_loss
    near = np.exp(np.multiply.outer(np.arange(fine), turn)) * (
        q.weight * np.exp(-theta * q.log_loss)
    )
    far = np.exp(np.multiply.outer(fine * np.arange(coarse), turn))
    power = (far @ near.T).ravel()[: z.size]
    out = 1.0 - power
    # next to z = 0 it is small
    out[:1] = law.decay_symbol(z[:1])
    return np.asarray(out)


def flux_symbol(
    law: CollisionLaw, z: NDArray[Any], decay: NDArray[Any] | None = None
) -> NDArray[Any]:
    """lambda(z)/(kappa z), 1 at z = 0: the flux of losses past a speed, relative to v at it.

    ``decay`` is lambda(z) where it is known.
    """
    zero = z == 0.0
    safe = np.where(zero, 1.0, z)
    if decay is None:
        decay = law.decay_symbol(safe)
    return np.asarray(np.where(zero, 1.0, decay / (law.mean_log_loss * safe)))


def drift_log(law: CollisionLaw, z: NDArray[Any]) -> NDArray[Any]:
    """rho(z) = ln(kappa z/lambda(z)) = ln A(z+1) - ln A(z), A(z) = E[(kappa v t/l)^z]; z real.

    An estimate for the sizes of windows: at large |z| the plain quadrature is a percent off.
    """
    if law.uniform_power:
        return np.asarray(np.log1p(z / law.uniform_power))
    q = law.quadrature
    zero = z == 0.0
    safe = np.where(zero, 1.0, z)
    decay = -np.expm1(-np.multiply.outer(safe, q.log_loss)) @ q.weight
    decay = law.met_again(safe, decay, 0)
    return np.asarray(np.where(zero, 0.0, np.log(law.mean_log_loss * safe / decay)))


def peak_position(law: CollisionLaw, z: NDArray[Any]) -> NDArray[Any]:
    """Where e^(z x) g(x) peaks in the scaling state, x = ln(kappa v t/l); an estimate, z real.

    The mean of x is the derivative of ln A, rho(z - 1/2) up to third differences of rho.
    """
    q = law.uniform_power
    if q:
        # nearly the digamma function at q + z, the derivative of ln Gamma(q + z)
        return np.asarray(np.log(z + q + 0.5) - 1.0 / (z + q) - math.log(q))
    return drift_log(law, z - 0.5)


def from_rest(law: CollisionLaw, c: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """The speeds at which F is asked for, shape (n,), and F(0) at all of them, as a beginning.

    F is 0 at rest, but where bounces come as near to rest as one likes: F ~ c^(q - d), with -q the
    lowest power of the law, is infinite, or (q = d) finite and asked for at a speed close by.
    """
    if not law.reaches_rest:
        return c, np.zeros(c.shape)
    power = -law.lowest_power - law.dimension
    if power == 0.0:
        c = np.where(c == 0.0, _CLOSE_TO_REST, c)
    return c, np.full(c.shape, math.inf if power < 0.0 else 0.0)


def harmonic_symbol(law: CollisionLaw, z: NDArray[Any], m: int) -> NDArray[Any]:
    """1 - E[s^z cos(m chi)], or that of the medium, shape of z (n,)."""
    q = law.quadrature_for(float(np.abs(z).max()), m)
    power = np.exp(-np.multiply.outer(z, q.log_loss))
    return law.met_again(z, np.asarray(1.0 - power @ (q.weight * q.harmonic(m))), m)
