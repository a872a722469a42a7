"""A bounce that is given by weighted samples of its speed ratio and its deflection."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.collision.quadrature import ImpactQuadrature, Survival
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import panels_of
from kinetics.validation import finite_line, refuse

_POINTS = 20  # Gauss points on panels of length 1 of the chance to lose more
_SUM = 1e-9  # how far the sum of the weights may be from 1; they are rescaled to it
_ROUNDING = 1e-12  # how far a cosine may be beyond 1
_MOST = 20_000  # samples: each costs some kilobytes on every panel


@dataclass(frozen=True)
class SampledBounce:
    """Weighted samples of (speed ratio, cos(chi)); see :meth:`CollisionLaw.from_samples`.

    The three arguments are tuples of one length, so that laws compare and hash by their values.
    """

    weight: tuple[float, ...]
    ratio: tuple[float, ...]
    cosine: tuple[float, ...]
    dimension: int = 2

    @classmethod
    def checked(
        cls, weight: ArrayLike, ratio: ArrayLike, cosine: ArrayLike, dimension: int
    ) -> SampledBounce:
        """With weights that sum to 1 to rounding; InputError for anything that is no law."""
        w, s = finite_line("weight", weight), finite_line("ratio", ratio)
        c = finite_line("cosine", cosine)
        if not 1 <= w.size <= _MOST:
            refuse("weight", w, f"give 1 to {_MOST} samples")
        for name, array in (("ratio", s), ("cosine", c)):
            if array.size != w.size:
                refuse(name, array, f"it must have as many numbers as weight, {w.size}")
        if np.any(w < 0.0):
            refuse("weight", float(w.min()), "weights must not be negative")
        if not abs(w.sum() - 1.0) <= _SUM:
            refuse("weight", w, f"the weights must sum to 1, their sum is {w.sum():.10g}")
        if np.any(s <= 0.0):
            refuse("ratio", float(s.min()), "speed ratios must be above 0")
        if np.any(np.abs(c) > 1.0 + _ROUNDING):
            refuse("cosine", float(c[np.abs(c).argmax()]), "it must be from -1 to 1")
        kept = w > 0.0
        w, c = w[kept] / w.sum(), np.clip(c[kept], -1.0, 1.0)
        return cls(tuple(w.tolist()), tuple(s[kept].tolist()), tuple(c.tolist()), dimension)

    @cached_property
    def _arrays(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Weight, -ln s and cos(chi), each of shape (n_samples,)."""
        ratio = np.array(self.ratio)
        return np.array(self.weight), 0.0 - np.log(ratio), np.array(self.cosine)

    @property
    def least_loss(self) -> float:
        """-ln of the largest speed ratio."""
        return float(self._arrays[1].min())

    @property
    def largest_loss(self) -> float:
        """-ln of the smallest speed ratio."""
        return float(self._arrays[1].max())

    @property
    def lowest_power(self) -> float:
        """Every power has an average."""
        return -math.inf

    @property
    def tail_exponent(self) -> float:
        """0 where every bounce loses energy; infinite where a share of them loses none."""
        return 0.0 if self.least_loss > 0.0 else math.inf

    def turns(self, rate: float, m: int) -> float:
        """Samples are summed as they are."""
        return 0.0

    def quadrature(self, level: int) -> ImpactQuadrature:
        """The samples."""
        weight, log_loss, cosine = self._arrays
        ratio = np.array(self.ratio)
        return ImpactQuadrature(weight, log_loss, ratio, ratio * cosine, self.dimension)

    def survival(self, level: int) -> Survival:
        """Gauss points between one -ln s and the next: the chance is constant there."""
        weight, log_loss, _ = self._arrays
        order = np.argsort(log_loss)
        edge = np.concatenate([[0.0], log_loss[order]])
        chance = np.cumsum(weight[order][::-1])[::-1]
        pieces = np.maximum(1, np.ceil(np.diff(edge) * 2.0**level)).astype(int)
        low = np.repeat(edge[:-1], pieces)
        step = np.repeat(np.diff(edge) / pieces, pieces)
        nth = np.concatenate([np.arange(n) for n in pieces])
        ends = np.stack([low + nth * step, low + (nth + 1) * step], axis=1)
        wide = step > 0.0
        u, w = panels_of(ends[wide], _POINTS)
        log_weight = np.log(w * np.repeat(chance, pieces)[wide][:, None]) + u
        return Survival(log_weight.ravel(), u.ravel())

    def cells(self, spacing: float, points: int) -> tuple[ImpactQuadrature, NDArray[np.int64]]:
        """The samples and the cell of each."""
        cell = np.floor(self._arrays[1] / spacing).astype(np.int64)
        return self.quadrature(0), cell

    def chance_below(self, ratio: FloatArray) -> FloatArray:
        """The weight of the samples with smaller ratios."""
        weight, samples = np.array(self.weight), np.array(self.ratio)
        order = np.argsort(samples)
        sums = np.concatenate([[0.0], np.cumsum(weight[order])])
        return np.asarray(sums[np.searchsorted(samples[order], ratio)])

    def closed_decay(self, z: NDArray[Any]) -> NDArray[Any] | None:
        """The sum over the samples serves."""
        return None

    def beyond(self, p: NDArray[Any]) -> NDArray[Any] | float:
        """Nothing is left out."""
        return 0.0
