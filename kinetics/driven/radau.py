"""Collocation in time at Radau's points: implicit, and it damps what is fast.

The stages of a step of length h are decoupled by the eigenvectors of Butcher's matrix: each is one
solution with the equation's own operator L and a shift 1/(h lambda). Source: Hairer and Wanner,
Solving Ordinary Differential Equations II, sections IV.5 and IV.8.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics import ComplexArray, FloatArray
from kinetics.numerics.gauss import gauss_legendre

STAGES = 5  # an odd number; the order is 9
_SERIES = np.array([*[0.0] * (STAGES - 1), -1.0, 1.0])
POINTS = 0.5 * (np.append(np.sort(np.polynomial.legendre.legroots(_SERIES))[:-1], 1.0) + 1.0)
POINTS = np.concatenate([[0.0], POINTS])
"""The points in units of the step: its beginning, then the stages up to its end."""
_VALUES = np.linalg.inv(np.polynomial.legendre.legvander(2.0 * POINTS - 1.0, STAGES))

FINE, _WEIGHTS = gauss_legendre(16)
_ORDER = np.arange(STAGES)
_INSIDE = np.polynomial.legendre.legvander(2.0 * FINE - 1.0, STAGES - 1) * _WEIGHTS[:, None]
_TAKEN = np.polynomial.legendre.legvander(2.0 * POINTS - 1.0, STAGES - 1) @ (
    (2.0 * _ORDER + 1.0)[:, None] * _INSIDE.T
)


def modes() -> list[tuple[complex, complex, ComplexArray, ComplexArray]]:
    """(lambda, what a constant has of this mode, what a source at the stages has, its stages).

    One mode is real, of each complex pair there is one, of which the stages are times 2.
    """
    x, k = POINTS[1:], np.arange(STAGES)
    integrals = x[:, None] ** (k + 1.0) / (k + 1.0)
    values, vectors = np.linalg.eig(integrals @ np.linalg.inv(x[:, None] ** k))
    inverse = np.linalg.inv(vectors.astype(complex))
    return [
        (complex(value), inverse[i].sum(), inverse[i], (1 + (value.imag > 1e-12)) * vectors[:, i])
        for i, value in enumerate(values)
        if value.imag > -1e-12
    ]


def rows(local: FloatArray) -> FloatArray:
    """Interpolation from the points to local times (n,) in units of the step; exact at 0."""
    out = np.polynomial.legendre.legvander(2.0 * local - 1.0, STAGES) @ _VALUES
    out[local == 0.0] = np.eye(STAGES + 1)[0]
    return np.asarray(out)


def integral_rows(local: FloatArray) -> FloatArray:
    """Integrals from the beginning of a step to local times (n,), in units of the step."""
    x = 2.0 * local - 1.0
    table = np.polynomial.legendre.legvander(x, STAGES + 1)
    order = np.arange(1, STAGES + 1)
    rise = (table[:, 2:] - table[:, :-2]) / (2.0 * order + 1.0)
    return np.asarray(0.5 * np.column_stack([x + 1.0, rise]) @ _VALUES)


def roughness(values: NDArray[np.floating]) -> FloatArray:
    """Size of the highest Legendre coefficient over a step, of values (STAGES + 1, n)."""
    return np.asarray(np.abs(_VALUES[-1] @ values))


def projected(values: FloatArray) -> FloatArray:
    """From values at FINE to those at the points of the polynomial with the same integrals.

    With every polynomial that the stages take: the values need not be smooth in time.
    """
    return np.tensordot(_TAKEN, values, axes=1)
