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
    """Nodes x_j = start + j spacing, j = 0 ... nodes-1, of a periodic window in x = ln(speed).

    Parameters
    ----------
    start : left end of the window
    spacing : of the nodes
    nodes : their number
    """

    start: float
    spacing: float
    nodes: int

    @cached_property
    def x(self) -> FloatArray:
        """The nodes, shape (nodes,)."""
        # counted from x = 0, near which a rounding error of the size of start would be large
        first_node = round(self.start / self.spacing)
        offset = self.start - first_node * self.spacing
        return offset + self.spacing * np.arange(first_node, first_node + self.nodes, dtype=float)

    @property
    def end(self) -> float:
        """Right end of the window."""
        return self.start + self.spacing * self.nodes

    @cached_property
    def wave_numbers(self) -> FloatArray:
        """k_n of a real Fourier transform, shape (nodes//2 + 1,)."""
        return np.asarray(2.0 * np.pi * np.fft.rfftfreq(self.nodes, self.spacing))

    def coefficients(self, values: FloatArray) -> ComplexArray:
        """Return c_n in Re sum_n c_n exp(i k_n (x - start)), (..., nodes//2 + 1).

        The values are at the nodes, shape (..., nodes).
        """
        spectrum = np.fft.rfft(values, axis=-1) / self.nodes
        spectrum[..., 1:] *= 2.0
        if self.nodes % 2 == 0:
            spectrum[..., -1] *= 0.5
        return np.asarray(spectrum)

    def evaluate(self, coefficients: ComplexArray, x: FloatArray) -> FloatArray:
        """Return the trigonometric polynomial of coefficients (..., nodes//2 + 1) at x (n,).

        The shape of the result is (..., n).
        """
        # exp(i k_n x) = exp(i k_1 x)^n: one power each costs less than an exponential each
        powers = np.empty((self.wave_numbers.size - 1, x.size), dtype=complex)
        powers[:] = np.exp(1j * self.wave_numbers[1] * (x - self.start))
        np.cumprod(powers, axis=0, out=powers)
        return np.asarray(coefficients[..., :1].real + (coefficients[..., 1:] @ powers).real)

    def interpolate(self, values: FloatArray, x: FloatArray) -> FloatArray:
        """Return the trigonometric interpolant of values (..., nodes) at x (n,): shape (..., n)."""
        return self.evaluate(self.coefficients(values), x)
