"""One angular harmonic of the velocity density: the question, its solvers, and their answer.

Harmonic m is f_m(v, t), the integral of exp(-i m phi) v f(v, phi, t) over phi; in space, of
P_m(cos theta) v^2 f over all directions. Harmonic 0 is the density of the speed, and the velocity
density is the sum of :func:`angular_function` times f_m. Each harmonic obeys an equation of its
own, with the loss rate v/l and the gain of bounces v -> s v that turn it by cos(m chi).

A new method provides one function, a :class:`HarmonicSolver`, which takes a
:class:`HarmonicProblem` and returns a :class:`Profile`. That holds the smooth part of f_m as any
object with the one method of :class:`HarmonicDensity`, the delta peak beside it, and an error
estimate. `kinetics.undriven` chooses the method. Begin with :class:`HarmonicSolver`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics import FloatArray
from kinetics.results.value import Value
from kinetics.states.state import State

#: Values of a harmonic: real for m = 0 and in space, complex where the start is directed.
HarmonicArray = NDArray[Any]


@dataclass(frozen=True)
class HarmonicProblem:
    """One angular harmonic of the velocity density that is to be solved for.

    Parameters
    ----------
    law : collision law of the tracer
    mean_free_path : l in d
    state : initial state, of which harmonic m is not zero
    m : number of the harmonic, 0 or more
    times : output times in d/U, rising, shape (n_times,)
    rtol : error that is requested, relative; what it is relative to is that of a Profile
    nodes : requested number of nodes of the speed axis; None where the solver chooses it
    """

    law: CollisionLaw
    mean_free_path: float
    state: State
    m: int
    times: FloatArray
    rtol: float
    nodes: int | None = None


class HarmonicDensity(Protocol):
    """A harmonic at the output times, without delta peaks, as a function of the speed."""

    def at(self, i: int, v: FloatArray) -> HarmonicArray:
        """Evaluate f_m in 1/U at the i-th time and speeds v in U, shape (n_v,).

        Speeds may be any that are not negative, in any order; where no tracer is, f_m is 0.
        """


@dataclass(frozen=True, eq=False, repr=False)
class Profile(Value):
    """Harmonic m of the velocity density at all output times.

    Parameters
    ----------
    density : the harmonic without delta peaks
    count : number of times
    method : "spectral", "conservative" or "exact"
    nodes : number of nodes of the speed axis, 0 without one
    error_estimate : of f_m relative to its maximum ("spectral"), or of its integral from 0 to v,
        the largest for any v ("conservative")
    peak_speed : speed in U of the tracers of a start of one speed that have not collided; None for
        other starts
    peak_weight : their share of all tracers times exp(-i m phi_0), phi_0 their direction, shape
        (n_times,); None for other starts
    """

    density: HarmonicDensity
    count: int
    method: str
    nodes: int
    error_estimate: float
    peak_speed: float | None = None
    peak_weight: HarmonicArray | None = None

    def at(self, i: int, v: FloatArray) -> HarmonicArray:
        """Evaluate f_m in 1/U, without delta peaks, at the i-th time and speeds v in U (n_v,)."""
        return self.density.at(i, v)

    def continuous(self, v: FloatArray) -> HarmonicArray:
        """Evaluate f_m in 1/U, without delta peaks, at all times, shape (n_times, n_v)."""
        return np.array([self.at(i, v) for i in range(self.count)])


class HarmonicSolver(Protocol):
    """What a method of solving for a harmonic provides: one function.

    `elastic.elastic_profile`, `spectral.solve_spectral` and `conservative.solve_conservative` are
    of this kind.
    """

    def __call__(self, problem: HarmonicProblem) -> Profile | None:
        """Solve for the harmonic at the times of the problem.

        Parameters
        ----------
        problem : at e < 1, except for the exact method of e = 1. Times may be 0, and as late as
            doubles go

        Returns
        -------
        The profile; None where the method cannot treat the start, so that another one is tried. Its
        ``error_estimate`` may exceed ``problem.rtol``, but not be below the error: the caller
        judges it. Integrals of f_0 and its peaks over v are 1.

        Raises
        ------
        InputError
            Where the solution would take too much memory or work, or does not exist.
        """


def angular_function(m: int, angle: FloatArray, dimension: int) -> HarmonicArray:
    """Return what harmonic m is multiplied by in the sum that gives f.

    The sum is over m >= 0, and has to be divided by 2 pi v, in space by 4 pi v^2.

    Parameters
    ----------
    m : number of the harmonic
    angle : angle to the x axis in radians, shape (n,)
    dimension : 2 or 3

    Returns
    -------
    exp(i m phi), twice for m > 0 as -m adds the complex conjugate; in space (2 m + 1) P_m. (n,)
    """
    if dimension == 2:
        multiplicity = 1.0 if m == 0 else 2.0
        return np.asarray(np.exp(1j * m * angle) * multiplicity)
    coefficients = np.zeros(m + 1)
    coefficients[m] = 2.0 * m + 1.0
    return np.asarray(np.polynomial.legendre.legval(np.cos(angle), coefficients))
