"""Collocation in time at Radau's points: implicit, and it damps what is fast.

The stages of a step of length h are decoupled by the eigenvectors of Butcher's matrix: each is one
solution with the equation's own operator L and a shift 1/(h lambda). Source: Hairer and Wanner,
Solving Ordinary Differential Equations II, sections IV.5 and IV.8.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics import ComplexArray, FloatArray
from kinetics.numerics.chebyshev import barycentric_weights, interpolation_rows


@dataclass(frozen=True)
class RadauRule:
    """Radau IIA with an odd number of stages; it has the order 2 stages - 1."""

    stages: int = 5

    @cached_property
    def points(self) -> FloatArray:
        """The points in units of the step: its beginning, then the stages up to its end."""
        series = np.zeros(self.stages + 1)
        series[-1], series[-2] = 1.0, -1.0
        roots = np.sort(np.polynomial.legendre.legroots(series).real)
        roots[-1] = 1.0
        return np.concatenate([[0.0], 0.5 * (roots + 1.0)])

    @cached_property
    def _spectrum(self) -> tuple[ComplexArray, ComplexArray]:
        """Eigenvalues and eigenvectors of Butcher's matrix."""
        x, k = self.points[1:], np.arange(self.stages)
        integrals = x[:, None] ** (k + 1.0) / (k + 1.0)
        butcher = integrals @ np.linalg.inv(x[:, None] ** k)
        values, vectors = np.linalg.eig(butcher)
        return values.astype(complex), vectors.astype(complex)

    @cached_property
    def modes(self) -> list[tuple[complex, complex, ComplexArray]]:
        """(lambda, what a constant has of this mode, its stages times 2 if it stands for a pair).

        One mode is real, of each complex pair there is one.
        """
        values, vectors = self._spectrum
        share = np.linalg.solve(vectors, np.ones(self.stages))
        found = []
        for i, value in enumerate(values):
            if abs(value.imag) < 1e-12:
                found.append((complex(value.real), share[i], vectors[:, i]))
            elif value.imag > 0.0:
                found.append((complex(value), share[i], 2.0 * vectors[:, i]))
        return found

    @cached_property
    def source_rows(self) -> list[ComplexArray]:
        """What a source at the stages, (stages,), has of each of the modes."""
        values, vectors = self._spectrum
        inverse = np.linalg.inv(vectors)
        return [inverse[int(np.argmin(np.abs(values - value)))] for value, _, _ in self.modes]

    def rows(self, local: FloatArray) -> FloatArray:
        """Interpolation from the points to local times (n,) in units of the step."""
        weights = barycentric_weights(4.0 * self.points)
        return interpolation_rows(local[:, None] - self.points, weights)

    def roughness(self, values: NDArray[Any]) -> FloatArray:
        """Size of the highest Legendre coefficient over a step, of values (stages + 1, ...)."""
        table = np.polynomial.legendre.legvander(2.0 * self.points - 1.0, self.stages)
        return np.asarray(np.abs(np.tensordot(np.linalg.inv(table)[-1], values, axes=1)))
