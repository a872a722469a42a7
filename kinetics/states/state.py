"""The contract of an initial state: what a new one must provide.

Write a ``@dataclass(frozen=True)`` class whose fields are what the user gives;
``Scene(initial=...)`` takes any object of a subclass of :class:`State`. In ``__post_init__`` check
the arguments, and store arrays with ``self.store(name=array)``, which keeps read-only copies.
Speeds are in U, densities in 1/U. Write ``harmonic`` (`quadrature` has rules for Gaussians, tables,
functions and samples), ``profile`` if f_m is a function of v, which densities need, and
``in_space()`` if the state may start a scene in space and is not isotropic; set the attributes of
State where their defaults do not fit. ``tests/kinetics/states/test_contract.py`` tests all this.
The shortest example is :class:`kinetics.states.kinds.Rest`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics import FloatArray
from kinetics.results import Value
from kinetics.states.quadrature import LogMeasure

SpeedFunction = Callable[[FloatArray], NDArray[Any]]  # speeds in U, (n,), to values, (n,)
Points = LogMeasure | None  # of a harmonic; None where it is zero


class State(Value):
    """An initial state; see the module's docstring for what a subclass must provide.

    Attributes
    ----------
    highest_harmonic : largest m for which f_m is not zero, 0 for an isotropic state; None where
        all m may be there
    smooth : whether f_m are smooth functions of ln v, so that the spectral method can be used
    lowest_moment : <v^p> exists for p above it
    peaks : speeds of delta peaks and shares of tracers in them, (n,) each; None for densities
    kinks : speeds at which the density is not smooth, rising, shape (n,)
    """

    highest_harmonic: int | None = 0
    smooth: bool = False
    lowest_moment: float = -math.inf
    peaks: tuple[FloatArray, FloatArray] | None = None
    kinks: FloatArray = np.empty(0)

    def in_space(self) -> State | None:
        """The state as it starts a three-dimensional scene; None if it has no such form.

        There harmonic m is the integral of P_m(cos theta) f over all directions, theta the angle to
        the x axis. Isotropic states that are given by their speeds are the same in space.
        """
        return self if self.highest_harmonic == 0 else None

    def harmonic(self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0) -> Points:
        """f_m(v), the integral of exp(-i m phi) v f(v, phi) over phi, as weighted points; or None.

        The sum of the weights times v^p exp(smooth function of ln v) is right to about rtol for all
        powers p from ``lowest`` to ``highest``. f_0 is the speed density: its weights sum to 1.
        """
        raise NotImplementedError

    def profile(self, m: int) -> SpeedFunction | None:
        """f_m in 1/U as a function of v/U; None where it is no function (delta peaks, samples)."""
        return None
