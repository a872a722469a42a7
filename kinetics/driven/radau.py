"""Collocation in time at Radau's points: implicit, and it damps what is fast.

A step of length h solves f' = L f + source at the stages, with Butcher's matrix A of the method.
The eigenvectors of A decouple the stages: each mode is one solution with L and a shift 1/(h
lambda), lambda an eigenvalue (`MODES`). Times are in units of the step, 0 at its beginning.

Source: Hairer and Wanner, Solving Ordinary Differential Equations II, sections IV.5 and IV.8.
Begin with `Mode`, and `kinetics.driven.march.StepEquation`, which uses it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import legroots, legvander
from numpy.typing import NDArray

from kinetics.numerics import ComplexArray, FloatArray
from kinetics.numerics.gauss import gauss_legendre

#: Stages of a step: an odd number; the order is 2 STAGES - 1 = 9. Measured on a field and drives
#: over time: with 3 the time is 2 to 4 times as long, with 7 it is 1.0 to 1.3 times.
STAGES = 5
#: Imaginary parts of eigenvalues below this are rounding. Chosen: far below any true one.
REAL_BELOW = 1e-12
#: Points of the quadrature over sources that are not smooth in time. Measured: with 8 and with 32
#: averages in a field move by 3e-9 at rtol 1e-4.
FINE_POINTS = 16


def _points() -> FloatArray:
    """Return the beginning of a step, and Radau's points up to its end, (STAGES + 1,)."""
    # Radau's points are the roots of P_STAGES - P_(STAGES - 1); the last one is 1.
    series = np.array([*[0.0] * (STAGES - 1), -1.0, 1.0])
    roots = np.append(np.sort(legroots(series))[:-1], 1.0)
    return np.concatenate([[0.0], 0.5 * (roots + 1.0)])


#: The points of a step: its beginning, then the stages up to its end, (STAGES + 1,).
POINTS = _points()
#: From values at `POINTS` to coefficients of Legendre polynomials over the step.
TO_LEGENDRE = np.linalg.inv(legvander(2.0 * POINTS - 1.0, STAGES))

#: Times, in units of the step, and weights of the quadrature over such sources, (FINE_POINTS,).
FINE_TIMES, FINE_WEIGHTS = gauss_legendre(FINE_POINTS)


def _projection() -> FloatArray:
    """Return the matrix from values at `FINE_TIMES` to those at `POINTS`: see `project`."""
    order = np.arange(STAGES)
    at_fine_times = legvander(2.0 * FINE_TIMES - 1.0, STAGES - 1) * FINE_WEIGHTS[:, None]
    at_points = legvander(2.0 * POINTS - 1.0, STAGES - 1)
    return np.asarray(at_points @ ((2.0 * order + 1.0)[:, None] * at_fine_times.T))


#: The matrix of `project`, (STAGES + 1, FINE_POINTS).
PROJECTION = _projection()


@dataclass(frozen=True)
class Mode:
    """One eigenvector of Butcher's matrix; of each complex pair there is one, counted twice.

    Parameters
    ----------
    eigenvalue : lambda, in units of the step
    constant_share : what this mode has of a value that is the same at all stages
    source_shares : what it has of a source at each stage, (STAGES,)
    stages : what it adds to each stage, (STAGES,); of a pair the real part counts
    """

    eigenvalue: complex
    constant_share: complex
    source_shares: ComplexArray
    stages: ComplexArray

    def shift(self, length: float) -> complex:
        """Return 1/(h lambda) for steps of length h; a real number where it is real."""
        shift = 1.0 / (length * self.eigenvalue)
        if abs(shift.imag) > REAL_BELOW * abs(shift):
            return shift
        return shift.real


def _modes() -> tuple[Mode, ...]:
    """Return the modes of Butcher's matrix."""
    x = POINTS[1:]
    power = np.arange(STAGES)
    integrals = x[:, None] ** (power + 1.0) / (power + 1.0)
    butcher = integrals @ np.linalg.inv(x[:, None] ** power)
    eigenvalues, vectors = np.linalg.eig(butcher)
    inverse = np.linalg.inv(vectors.astype(complex))
    modes = []
    for i, eigenvalue in enumerate(eigenvalues):
        if eigenvalue.imag <= -REAL_BELOW:
            continue
        count = 2 if eigenvalue.imag > REAL_BELOW else 1
        mode = Mode(complex(eigenvalue), inverse[i].sum(), inverse[i], count * vectors[:, i])
        modes.append(mode)
    return tuple(modes)


#: The modes of Butcher's matrix: those by which a step is solved.
MODES = _modes()


def interpolation_rows(local: FloatArray) -> FloatArray:
    """Return the interpolation from `POINTS` to times (n,), (n, STAGES + 1); exact at 0."""
    rows = legvander(2.0 * local - 1.0, STAGES) @ TO_LEGENDRE
    rows[local == 0.0] = np.eye(STAGES + 1)[0]
    return np.asarray(rows)


def integral_rows(local: FloatArray) -> FloatArray:
    """Return the integration from the beginning of a step to times (n,), (n, STAGES + 1)."""
    x = 2.0 * local - 1.0
    polynomials = legvander(x, STAGES + 1)
    order = np.arange(1, STAGES + 1)
    integrals = (polynomials[:, 2:] - polynomials[:, :-2]) / (2.0 * order + 1.0)
    return np.asarray(0.5 * np.column_stack([x + 1.0, integrals]) @ TO_LEGENDRE)


def roughness(values: NDArray[np.floating]) -> FloatArray:
    """Return the size of the highest Legendre coefficient of values (STAGES + 1, n), (n,)."""
    return np.asarray(np.abs(TO_LEGENDRE[-1] @ values))


def project(values: FloatArray) -> FloatArray:
    """Return a polynomial at `POINTS` that stands for values at `FINE_TIMES`, (FINE_POINTS, ...).

    Its integrals with every polynomial that the stages take are the same: the values need not be
    smooth in time.
    """
    return np.tensordot(PROJECTION, values, axes=1)
