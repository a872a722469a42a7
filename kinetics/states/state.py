"""The contract of an initial state: what a new one must provide.

Write a ``@dataclass(frozen=True, eq=False, repr=False)`` class whose fields are what the user
gives; ``Scene(initial=...)`` takes any object of a subclass of :class:`State`. In ``__post_init__``
check the arguments, and store arrays with ``self.store(name=array)``, which keeps read-only copies.
Speeds are in U, densities in 1/U. Write ``harmonic``, with one of the rules in `points` (Gaussians,
tables, samples) and `function_points` (functions), ``profile`` if f_m is a function of v, which
densities need, and ``in_space()`` if the state may start a scene in space and is not isotropic; set
the attributes of State where their defaults do not fit. ``tests/kinetics/states/test_contract.py``
tests all this for the states in ``tests/kinetics/example_values.py``. A public state is named in
`kinetics.names` and ``kinetics/__init__.py`` too. The shortest example is
:class:`kinetics.states.kinds.Rest`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kinetics.numerics import FloatArray, NumberArray
from kinetics.results.result import Storable
from kinetics.results.value import Value

#: A function of speeds in U, shape (n,), with real or complex values of that shape.
SpeedFunction = Callable[[FloatArray], NumberArray]


@dataclass(frozen=True, eq=False, repr=False)
class LogMeasure(Value):
    """A distribution of speeds: weight w_k at ln(v/U) = x_k, shape (n_points,) each.

    The weights are real and sum to 1 for a speed distribution; complex for a harmonic of one.

    Parameters
    ----------
    x : ln(v/U)
    weight : of each point
    error : estimated relative error of averages over it, of a density that quadrature does not
        resolve to the tolerance requested; 0 where it does
    """

    x: FloatArray
    weight: NumberArray
    error: float = 0.0

    def log_second_moment(self) -> float:
        """Return ln <v^2>, for speeds of any scale."""
        fastest = float(self.x.max())
        mean = float(self.weight.real @ np.exp(2.0 * (self.x - fastest)))
        return 2.0 * fastest + math.log(mean)


#: The points of a harmonic; None where it is zero.
Points = LogMeasure | None


class State(Storable):
    """An initial state; see the module's docstring for what a subclass must provide.

    Attributes
    ----------
    highest_harmonic : largest m for which f_m is not zero, 0 for an isotropic state; None where
        all m may be there
    smooth : whether f_m are smooth functions of ln v, so that the spectral method can be used
    lowest_moment : <v^p> exists for p above it
    peaks : speeds of delta peaks and shares of tracers in them, (n,) each; None for densities
    kinks : speeds at which the density is not smooth, as at a step, rising, shape (n,)
    """

    highest_harmonic: int | None = 0
    smooth: bool = False
    lowest_moment: float = -math.inf
    peaks: tuple[FloatArray, FloatArray] | None = None
    kinks: FloatArray = np.empty(0)

    def in_space(self) -> State | None:
        """Return the state as it starts a three-dimensional scene; None if it has no such form.

        There harmonic m is the integral of P_m(cos theta) f over all directions, theta the angle to
        the x axis. Isotropic states that are given by their speeds are the same in space.
        """
        return self if self.highest_harmonic == 0 else None

    def harmonic(self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0) -> Points:
        """Return f_m(v), the integral of exp(-i m phi) v f(v, phi) over phi, as weighted points.

        f_0 is the speed density: its weights sum to 1.

        Parameters
        ----------
        m : the angular harmonic, 0 or more
        rtol : the sum of the weights times v^p exp(smooth function of ln v) is right to about this
        lowest, highest : the powers p for which it is

        Returns
        -------
        The points; None where f_m is zero.
        """
        raise NotImplementedError

    def profile(self, m: int) -> SpeedFunction | None:
        """Return f_m in 1/U as a function of v/U; None where it is none (delta peaks, samples)."""
        return None
