"""Averages over one collision as weighted sums: what a bounce hands to the collision law."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics import FloatArray


@dataclass(frozen=True)
class ImpactQuadrature:
    """Averages over one collision as weighted sums: E[f] = sum_k weight_k f_k.

    Attributes, arrays of shape ``(n_nodes,)``
    ------------------------------------------
    weight : positive, sums to 1
    log_loss : xi = -ln s, s the speed ratio of the bounce; accurate relative to itself
    ratio : s = exp(-xi)
    parallel : s cos(chi), chi the deflection
    dimension : 2 or 3
    """

    weight: FloatArray
    log_loss: FloatArray
    ratio: FloatArray
    parallel: FloatArray
    dimension: int = 2

    @cached_property
    def cosine(self) -> FloatArray:
        """cos(chi), shape (n_nodes,)."""
        return np.clip(self.parallel / self.ratio, -1.0, 1.0)

    @cached_property
    def deflection(self) -> FloatArray:
        """chi, from 0 to pi, shape (n_nodes,)."""
        return np.arccos(self.cosine)

    def harmonic(self, m: int) -> FloatArray:
        """What angular harmonic m keeps of itself in a bounce, shape (n_nodes,).

        cos(m chi) in the plane, the Legendre polynomial P_m(cos chi) in space.
        """
        if self.dimension == 2:
            return np.cos(m * self.deflection)
        return 1.0 - self.harmonic_loss(m)

    def harmonic_loss(self, m: int) -> FloatArray:
        """1 - harmonic(m), shape (n_nodes,), accurate where it is small."""
        if self.dimension == 2:  # 1 - cos(m chi) = 2 sin^2(m chi/2)
            return np.asarray(2.0 * np.sin(0.5 * m * self.deflection) ** 2)
        last = np.zeros_like(self.cosine)
        for lost in self._legendre_losses(abs(m)):
            last = lost
        return last

    def harmonics(self, top: int) -> tuple[FloatArray, FloatArray]:
        """harmonic(m) and harmonic_loss(m) for m up to ``top``, shape (top + 1, n_nodes) each."""
        if self.dimension == 2:
            order = np.arange(top + 1)[:, None]
            lost = 2.0 * np.sin(0.5 * order * self.deflection) ** 2
            return np.cos(order * self.deflection), lost
        lost = np.stack(list(self._legendre_losses(top)))
        return 1.0 - lost, lost

    def each_harmonic(self, top: int) -> Iterator[FloatArray]:
        """harmonic(m) for m up to ``top``, one after another: there may be many nodes."""
        if self.dimension == 3:
            yield from (1.0 - lost for lost in self._legendre_losses(top))
            return
        step, turned = np.exp(1j * self.deflection), np.ones(self.deflection.size, dtype=complex)
        for _ in range(top + 1):
            yield turned.real
            turned = turned * step

    def part(self, used: NDArray[np.bool_]) -> ImpactQuadrature:
        """Some of the nodes, (n_nodes,) of booleans; their weights need not sum to 1."""
        return ImpactQuadrature(
            self.weight[used],
            self.log_loss[used],
            self.ratio[used],
            self.parallel[used],
            self.dimension,
        )

    def _legendre_losses(self, top: int) -> Iterator[FloatArray]:
        """1 - P_m(cos chi) for m up to ``top``, one after another, (n_nodes,) each."""
        # q_m = (1 - P_m(x))/(1 - x), from (n+1) P_(n+1) = (2n+1) x P_n - n P_(n-1)
        x = self.cosine
        before, last = np.zeros_like(x), np.zeros_like(x)
        for n in range(top + 1):
            yield (1.0 - x) * last
            next_one = ((2 * n + 1) * (1.0 + x * last) - n * before) / (n + 1)
            before, last = last, next_one


def at_right_angle(m: int, dimension: int) -> float:
    """Harmonic m at the deflection pi/2: cos(m pi/2), or P_m(0); 0 for odd m."""
    if m % 2:
        return 0.0
    if dimension == 2:
        return 1.0 if m % 4 == 0 else -1.0
    value = 1.0
    for n in range(2, abs(m) + 1, 2):
        value *= -(n - 1.0) / n
    return value


@dataclass(frozen=True)
class Survival:
    """Integrals of the chance to lose more than xi: int_0^inf P(xi > u) e^u f(u) du = sum w_k f_k.

    In the scaling state, the flux downwards past x = ln(v t/l) is such an integral.

    Attributes, each of shape ``(n_nodes,)``
    ----------------------------------------
    log_weight : ln w; -inf where the weight is 0
    log_loss : u
    """

    log_weight: FloatArray
    log_loss: FloatArray


class Bounce(Protocol):
    """What the collision law asks of a bounce."""

    @property
    def dimension(self) -> int:
        """2 or 3."""

    @property
    def least_loss(self) -> float:
        """The smallest -ln s that occurs; negative where a bounce may gain energy."""

    @property
    def largest_loss(self) -> float:
        """The largest -ln s that occurs; infinite where s comes as near to 0 as one likes."""

    @property
    def lowest_power(self) -> float:
        """E[s^p] exists for Re p above it; -inf where s has a lower bound above 0."""

    @property
    def tail_exponent(self) -> float:
        """b where E[s^p] tends to b/p at large p; 0 where it falls faster, NaN where slower."""

    def turns(self, rate: float, m: int) -> float:
        """By how much s^z and harmonic m turn over all bounces, |z| up to ``rate``."""

    def quadrature(self, level: int) -> ImpactQuadrature:
        """The average, with panels 2^level times shorter than for slow functions."""

    def survival(self, level: int) -> Survival:
        """The integral over the chance to lose more than xi, with panels as short."""

    def cells(self, spacing: float, points: int) -> tuple[ImpactQuadrature, NDArray[np.int64]]:
        """The average cell by cell of width ``spacing`` in -ln s, and the cell of each node."""

    def chance_below(self, ratio: FloatArray) -> FloatArray:
        """Share of the bounces after which the speed ratio is below ``ratio``, its shape."""

    def closed_decay(self, z: NDArray[Any]) -> NDArray[Any] | None:
        """1 - E[s^z] where a closed form is better than the quadrature, shape of z; or None."""

    def beyond(self, p: NDArray[Any]) -> NDArray[Any] | float:
        """What bounces that lose more than any node add to E[s^p]; their deflection is pi/2."""
