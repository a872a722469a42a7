"""Averages over one collision as weighted sums over the impact parameter, or over samples.

E[f] = sum_k weight_k f(s_k, chi_k), s the ratio of the speeds after and before a bounce and chi the
deflection. Begin with :class:`ImpactQuadrature`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics import ComplexArray, FloatArray

#: Real or complex numbers, where it does not matter which.
NumberArray = NDArray[Any]
#: Arrays of real or of complex powers, and what has their type.
Numbers = TypeVar("Numbers", FloatArray, ComplexArray, NumberArray)


@dataclass(frozen=True, eq=False)
class ImpactQuadrature:
    """Averages over one collision: E[f] = sum_k weight_k f_k; arrays of shape ``(n_nodes,)``.

    Parameters
    ----------
    weight : positive, sums to 1
    log_loss : -ln s, s the speed ratio of the bounce; accurate relative to itself
    deflection : chi, from 0 to pi, in which small deflections keep their digits
    dimension : 2 (the plane) or 3 (space)
    """

    weight: FloatArray
    log_loss: FloatArray
    deflection: FloatArray
    dimension: int = 2

    @property
    def ratio(self) -> FloatArray:
        """s, shape (n_nodes,)."""
        return np.exp(-self.log_loss)

    @property
    def cosine(self) -> FloatArray:
        """cos(chi), shape (n_nodes,)."""
        return np.cos(self.deflection)

    def losses(self, z: Numbers) -> Numbers:
        """Return 1 - s^z, of the shape of z and (n_nodes,), accurate where it is small."""
        if not np.iscomplexobj(z):
            return np.asarray(-np.expm1(-np.multiply.outer(z, self.log_loss)))
        # 1 - e^-(a + i b) = 1 - e^-a + 2 e^-a sin(b/2) (sin(b/2) + i cos(b/2)): quicker than a
        # complex expm1
        fall = np.multiply.outer(z.real, self.log_loss)
        half_phase = np.multiply.outer(0.5 * z.imag, self.log_loss)
        sine = np.sin(half_phase)
        turned = 2.0 * np.exp(-fall)
        turned *= sine
        return np.asarray(turned * sine - np.expm1(-fall) + 1j * (turned * np.cos(half_phase)))

    def harmonic_loss(self, m: int) -> FloatArray:
        """Return 1 - cos(m chi) in the plane, 1 - P_m(cos chi) in space, shape (n_nodes,).

        It is accurate where it is small.
        """
        if self.dimension == 2:
            return np.asarray(2.0 * np.sin(0.5 * m * self.deflection) ** 2)
        *_, last = self.harmonic_losses(abs(m))
        return last

    def harmonic_losses(self, highest: int) -> Iterator[FloatArray]:
        """Yield harmonic_loss(m) for m = 0 ... highest, one at a time: nodes may be many."""
        if self.dimension == 2:
            for m in range(highest + 1):
                yield self.harmonic_loss(m)
            return
        # q_m = (1 - P_m(x))/(1 - x), from (m+1) P_(m+1) = (2m+1) x P_m - m P_(m-1)
        x = self.cosine
        first_loss = 2.0 * np.sin(0.5 * self.deflection) ** 2  # 1 - x
        previous = np.zeros_like(x)
        current = np.zeros_like(x)
        for m in range(highest + 1):
            yield first_loss * current
            following = ((2 * m + 1) * (1.0 + x * current) - m * previous) / (m + 1)
            previous = current
            current = following
