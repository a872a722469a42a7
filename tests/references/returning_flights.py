"""Random flights with weights, for the operator of a finite density at its leading order.

A tracer flies exponential paths of mean 1. At their ends (K - 1)/(1 - eps B (K - 1)) + 1 acts, with
K one collision and B the direction reversed and the speed times e. It is

    K + sum over j > 0 of (-1)^(j+1) eps^j B^j (1 - K)^(j+1):

one of the terms is drawn, and a weight of either sign carries the rest. Nothing of the project is
used.
"""

from typing import NamedTuple

import numpy as np

_TERMS = 40


class Flights(NamedTuple):
    """Speeds, angles, places in the complex plane, and weights, (count,) each."""

    speed: np.ndarray
    angle: np.ndarray
    place: np.ndarray
    weight: np.ndarray

    def mean(self, values: np.ndarray) -> tuple[float, float]:
        """The weighted mean and its standard error."""
        product = self.weight * values
        return float(product.mean()), float(product.std() / len(product) ** 0.5)


def returning_flights(e: float, eps: float, time: float, count: int, seed: int) -> Flights:
    """Flights along x at first, with speeds of a Gaussian velocity, up to the time in l/U."""
    rng = np.random.default_rng(seed)
    v = np.hypot(rng.standard_normal(count), rng.standard_normal(count))
    angle, r, weight = np.zeros(count), np.zeros(count, complex), np.ones(count)
    left = np.full(count, time)
    chance = np.append(1.0, 2.0 * (2.0 * eps) ** np.arange(1, _TERMS))
    whole = chance.sum()
    alive = np.arange(count)
    while alive.size:
        flight = rng.exponential(size=alive.size) / v[alive]
        lasts = flight >= left[alive]
        flight = np.minimum(flight, left[alive])
        r[alive] += v[alive] * flight * np.exp(1j * angle[alive])
        left[alive] -= flight
        alive = alive[~lasts]
        j = np.searchsorted(np.cumsum(chance) / whole, rng.random(alive.size))
        v[alive] *= e**j
        angle[alive] += np.pi * j
        hits = np.where(j == 0, 1, rng.binomial(j + 1, 0.5))
        weight[alive] *= whole * np.where(j == 0, 1.0, (-1.0) ** (j + 1 + hits))
        for hit in range(int(hits.max(initial=0))):
            here = alive[hits > hit]
            y = rng.uniform(-1.0, 1.0, here.size)
            s = np.sqrt(e * e + (1.0 - e * e) * y * y)
            cosine = np.clip((-e + (1.0 + e) * y * y) / s, -1.0, 1.0)
            angle[here] += np.sign(y) * np.arccos(cosine)
            v[here] *= s
    return Flights(v, angle, r, weight)
