"""Averages over one collision as weighted sums."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics import FloatArray


@dataclass(frozen=True)
class ImpactQuadrature:
    """Averages over one collision: E[f] = sum_k weight_k f_k.

    Attributes, arrays of shape ``(n_nodes,)``
    ------------------------------------------
    weight : positive, sums to 1
    log_loss : xi = -ln s, s the speed ratio of the bounce; accurate relative to itself
    ratio : s = exp(-xi)
    parallel : s cos(chi), chi the deflection
    dimension : 2 or 3
    across : s sin(chi), where chi is small: cos(chi) alone would lose its digits; None elsewhere
    """

    weight: FloatArray
    log_loss: FloatArray
    ratio: FloatArray
    parallel: FloatArray
    dimension: int = 2
    across: FloatArray | None = None

    @cached_property
    def cosine(self) -> FloatArray:
        """cos(chi), shape (n_nodes,)."""
        return np.clip(self.parallel / self.ratio, -1.0, 1.0)

    @cached_property
    def deflection(self) -> FloatArray:
        """chi, from 0 to pi, shape (n_nodes,)."""
        if self.across is not None:
            return np.asarray(np.arctan2(self.across, self.parallel))
        return np.arccos(self.cosine)

    def harmonic(self, m: int) -> FloatArray:
        """What angular harmonic m keeps of itself in a bounce, shape (n_nodes,).

        cos(m chi) in the plane, the Legendre polynomial P_m(cos chi) in space.
        """
        return 1.0 - self.harmonic_loss(m)

    def harmonic_loss(self, m: int) -> FloatArray:
        """1 - harmonic(m), shape (n_nodes,), accurate where it is small."""
        if self.dimension == 2:  # 1 - cos(m chi) = 2 sin^2(m chi/2)
            return np.asarray(2.0 * np.sin(0.5 * m * self.deflection) ** 2)
        *_, last = self.harmonic_losses(abs(m))
        return last

    def harmonic_losses(self, top: int) -> Iterator[FloatArray]:
        """harmonic_loss(m) for m up to ``top``, one after another: there may be many nodes."""
        if self.dimension == 2:
            yield from (self.harmonic_loss(m) for m in range(top + 1))
            return
        # q_m = (1 - P_m(x))/(1 - x), from (n+1) P_(n+1) = (2n+1) x P_n - n P_(n-1)
        x = self.cosine
        turned = 1.0 - x if self.across is None else 2.0 * np.sin(0.5 * self.deflection) ** 2
        before, last = np.zeros_like(x), np.zeros_like(x)
        for n in range(top + 1):
            yield turned * last
            next_one = ((2 * n + 1) * (1.0 + x * last) - n * before) / (n + 1)
            before, last = last, next_one

    def part(self, used: NDArray[np.bool_]) -> ImpactQuadrature:
        """Some of the nodes, (n_nodes,) of booleans; their weights need not sum to 1."""
        weight, log_loss, ratio = self.weight[used], self.log_loss[used], self.ratio[used]
        across = None if self.across is None else self.across[used]
        return ImpactQuadrature(
            weight, log_loss, ratio, self.parallel[used], self.dimension, across
        )
