"""Curves that figures and findings of a report draw on."""

import math
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from kinetics import ScalingSolution, sonine
from kinetics.crosscheck.report.cases import FloatArray

#: Restitutions at which the exact rate is drawn: evenly, and one close to 1.
N_RESTITUTIONS = 67
#: The restitution close to 1.
NEARLY_ELASTIC = 0.999
#: Laws whose rates are kept; a report draws one.
MAX_RATES_KEPT = 8


@lru_cache(maxsize=MAX_RATES_KEPT)
def exact_rates(tangential_restitution: float, dimension: int) -> tuple[FloatArray, FloatArray]:
    """Return restitutions from 0 to 1, and the exact h at each.

    The first restitution at which the printed a2 is real is among them.
    """
    threshold = sonine.THRESHOLD_RESTITUTION + 1e-12
    e = np.sort([*np.linspace(0.0, 0.99, N_RESTITUTIONS), NEARLY_ELASTIC, threshold])
    states = (ScalingSolution(float(x), tangential_restitution, dimension) for x in e)
    return e, np.array([state.cooling_rate for state in states])


def gaussian_vdf(c: ArrayLike, dimension: int) -> FloatArray:
    """Return the Gaussian F(c) with <c^2> = 1: a density in the plane, or in space."""
    norm = (dimension / 2 / math.pi) ** (dimension / 2)
    return np.asarray(norm * np.exp(-dimension / 2 * np.square(c)))


def limiting_drift(restitution: ArrayLike, dimension: int) -> FloatArray:
    """Return the drift in sqrt(g l) as collisions become elastic.

    With eps = 1 - e^2 speeds are distributed as exp(-a v^4), which grows as eps, and
    u = lambda(2) <v^3>/2.
    """
    steepness = 2 / 9 if dimension == 2 else 3 / 16  # a/eps
    energy_loss = 2 / 3 if dimension == 2 else 1 / 2  # lambda(2)/eps
    gamma_ratio = math.gamma((3 + dimension) / 4) / math.gamma(dimension / 4)
    third_moment = steepness**-0.75 * gamma_ratio
    scale = (1.0 - np.square(np.asarray(restitution, dtype=float))) ** 0.25
    return np.asarray(energy_loss * third_moment / 2 * scale)
