"""The discretised speed axis: equidistant nodes in the logarithm of the speed.

The losses at a bounce, v -> s v, are shifts on it, so that the collision operator is a convolution.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinetics.numerics import ComplexArray, FloatArray


@dataclass(frozen=True)
class LogGrid:
    """Nodes x_j = start + j spacing, j = 0 ... nodes-1, of a periodic window in x = ln(speed)."""

    start: float
    spacing: float
    nodes: int

    @cached_property
    def x(self) -> FloatArray:
        """The nodes, shape (nodes,)."""
        # counted from x = 0, near which a rounding error of the size of start would be large
        first = round(self.start / self.spacing)
        rest = self.start - first * self.spacing
        return rest + self.spacing * np.arange(first, first + self.nodes, dtype=float)

    @property
    def end(self) -> float:
        """Right end of the window."""
        return self.start + self.spacing * self.nodes

    @cached_property
    def wave_numbers(self) -> FloatArray:
        """Of a real transform, shape (nodes//2 + 1,)."""
        return np.asarray(2.0 * np.pi * np.fft.rfftfreq(self.nodes, self.spacing))

    def coefficients(self, values: FloatArray) -> ComplexArray:
        """Of values (..., nodes), the c_n in Re sum_n c_n exp(i k_n (x - start))."""
        spectrum = np.fft.rfft(values, axis=-1) / self.nodes
        spectrum[..., 1:] *= 2.0
        if self.nodes % 2 == 0:
            spectrum[..., -1] *= 0.5
        return np.asarray(spectrum)

    def evaluate(self, coefficients: ComplexArray, x: FloatArray) -> FloatArray:
        """The trigonometric polynomial of coefficients (..., nodes//2 + 1) at x (n,): (..., n)."""
        # exp(i k_n x) = exp(i k_1 x)^n: one power each costs less than an exponential each
        powers = np.empty((self.wave_numbers.size - 1, x.size), dtype=complex)
        powers[:] = np.exp(1j * self.wave_numbers[1] * (x - self.start))
        np.cumprod(powers, axis=0, out=powers)
        return np.asarray(coefficients[..., :1].real + (coefficients[..., 1:] @ powers).real)

    def interpolate(self, values: FloatArray, x: FloatArray) -> FloatArray:
        """The trigonometric interpolant; values (..., nodes), x (n,) in the window: (..., n)."""
        return self.evaluate(self.coefficients(values), x)
