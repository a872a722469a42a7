"""What the steady state in a field tends to as collisions become elastic, in sqrt(g l).

With eps = 1 - e^2 the speeds are then distributed as exp(-a v^4), a = 2 eps/9 among disks and
3 eps/16 among spheres, and grow as eps^(-1/4). The energy that the field gives, g u, is what the
collisions take, which makes the drift u = lambda(2) <v^3>/2; across the field a tracer diffuses as
without a field, with the mean speed.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from kinetics.crosscheck.report.case import Array

_FALL = {2: 2 / 9, 3: 3 / 16}  # a/eps
_LOSS = {2: 2 / 3, 3: 1 / 2}  # lambda(2)/eps, the mean loss of v^2 in a collision
_TURN = {2: 4 / 3, 3: 1.0}  # lambda_1(0) = 1 - <cos chi> at e = 1
# Along the field the fluctuations of the energy take part, and no closed form is known. The number
# is the solver's as e -> 1.
_PARALLEL = {2: 0.176205, 3: 0.202982}


def _speed_moment(p: int, dimension: int) -> float:
    """<v^p> of exp(-a v^4) in the plane or in space, times eps^(p/4)."""
    d, a = dimension, _FALL[dimension]
    return a ** (-p / 4) * math.gamma((p + d) / 4) / math.gamma(d / 4)


def drift_constant(dimension: int) -> float:
    """Of the drift: u = constant eps^(1/4)."""
    return _LOSS[dimension] * _speed_moment(3, dimension) / 2


def dispersion_constants(dimension: int) -> tuple[float, float]:
    """Of D along and across the field: D = constant eps^(-1/4)."""
    across = _speed_moment(1, dimension) / (dimension * _TURN[dimension])
    return _PARALLEL[dimension], across


def drift_near_elastic(restitution: ArrayLike, dimension: int) -> Array:
    """The limiting law of the drift, as e -> 1."""
    eps = 1.0 - np.square(np.asarray(restitution, dtype=float))
    return np.asarray(drift_constant(dimension) * eps**0.25)


def dispersion_near_elastic(restitution: ArrayLike, dimension: int) -> tuple[Array, Array]:
    """The limiting laws of D along and across the field, as e -> 1; infinite at 1."""
    eps = 1.0 - np.square(np.asarray(restitution, dtype=float))
    along, across = dispersion_constants(dimension)
    with np.errstate(divide="ignore"):
        return along * eps**-0.25, across * eps**-0.25
