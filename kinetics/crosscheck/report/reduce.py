"""The numbers to which runs and solutions are reduced so that they can be compared.

Errors are jackknifed over independent groups of tracers: configurations, where there are any.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics import Solution, sonine
from kinetics.crosscheck.compare.statistics import errors as jackknife_error
from kinetics.numerics.gauss import panels_between

Array = NDArray[np.float64]

# bins of c = v/v0 for F(c), and of R = r/sqrt(<r^2>) for G(R)
SPEED_EDGES = np.concatenate([np.linspace(0.0, 2.0, 21), np.linspace(2.25, 6.0, 16)])
POSITION_EDGES = np.concatenate([np.linspace(0.0, 3.0, 31), np.linspace(3.25, 6.0, 12)])
SPEEDS, DISTANCES = ((edges[1:] + edges[:-1]) / 2 for edges in (SPEED_EDGES, POSITION_EDGES))
LEAST_EXPECTED = 50  # samples in a bin before its jackknife error is trusted


@dataclass(frozen=True)
class Measured:
    """An estimate with its standard error, of the same shape; NaN where nothing was measured."""

    value: Array
    error: Array

    @staticmethod
    def of(estimate: Any) -> "Measured":
        """Of anything that has both."""
        return Measured(np.asarray(estimate.value), np.asarray(estimate.error))

    @property
    def last(self) -> "Measured":
        """The last one, of shape ()."""
        return Measured(*(np.asarray(np.ravel(x)[-1]) for x in (self.value, self.error)))

    def __truediv__(self, scale: float | Array) -> "Measured":
        return Measured(np.asarray(self.value / scale), np.asarray(self.error / scale))

    def __getitem__(self, where: Any) -> "Measured":
        return Measured(np.asarray(self.value[where]), np.asarray(self.error[where]))


def contact_value(number_density: float, dimension: int = 2) -> float:
    """The pair correlation at contact, g(d), by which the mean free path is divided.

    Of hard disks: D. Henderson, Mol. Phys. 30, 971 (1975); number_density in d^-2. Of hard spheres:
    N. F. Carnahan and K. E. Starling, J. Chem. Phys. 51, 635 (1969); in d^-3.
    """
    x = math.pi * number_density / (2 * dimension)  # their share of the plane, or of space
    return (1 - x / 2) / (1 - x) ** 3 if dimension == 3 else (1 - 7 * x / 16) / (1 - x) ** 2


def rates(
    times: Array, averages: Mapping[str, Array], early: int, half_rate: float
) -> dict[str, Array]:
    """h from 1/v0, and d<r^2>/d ln t, between index `early` and the last time; half_rate 1/2l."""
    (first, last), (r1, r2) = (averages[n][[early, -1]] for n in ("thermal_speed", "msd"))
    slope = (1 / last - 1 / first) / (times[-1] - times[early])
    spread = (r2 - r1) / np.log(times[-1] / times[early])
    return {"cooling_rate": np.asarray(slope / half_rate), "msd_slope": np.asarray(spread)}


def ball(dimension: int) -> float:
    """Area of the unit circle, or volume of the unit sphere."""
    return math.pi if dimension == 2 else 4 * math.pi / 3


def gaussian_vdf(c: ArrayLike, dimension: int) -> Array:
    """The Gaussian F(c) with <c^2> = 1: a density in the plane, or in space."""
    if dimension == 2:
        return sonine.vdf(c, 0.0)
    return np.asarray((1.5 / math.pi) ** 1.5 * np.exp(-1.5 * np.square(c)))


def bin_measure(dimension: int) -> Array:
    """Area, or volume, of each bin of c."""
    return np.asarray(ball(dimension) * np.diff(SPEED_EDGES**dimension))


def last_vdf(solution: Solution) -> Callable[[Array], Array]:
    """F(c) of a solution at its last time, from its radial density over v = c v0(t)."""
    v0, law = float(solution.thermal_speed[-1]), solution.scene.law
    surface, power = law.unit_surface, law.dimension - 1
    return lambda c: v0 * solution.speed_density(c * v0)[-1] / (surface * c**power)


def bin_average(vdf: Callable[[Array], ArrayLike], dimension: int) -> Array:
    """F(c) averaged over the area, or volume, of each bin of c, by 8 Gauss points in each."""
    c, weight = panels_between(SPEED_EDGES, 8)
    shares = dimension * c ** (dimension - 1) * np.asarray(vdf(c)) * weight
    return np.asarray(shares.reshape(-1, 8).sum(axis=1) / np.diff(SPEED_EDGES**dimension))


def scaled_density(samples: Array, edges: Array, measure: Array) -> Measured:
    """Density of samples (n_groups, n_in_group) over their own root mean square, per bin.

    edges (n_bins + 1,) of the scaled variable; measure (n_bins,): length or area of each bin.
    """
    every, by_group = np.sort(samples, axis=None), np.sort(samples, axis=1)

    def density(left_out: Array) -> Array:
        n = every.size - left_out.size
        at = edges * np.sqrt((np.sum(every**2) - np.sum(left_out**2)) / n)
        inside = np.diff(np.searchsorted(every, at) - np.searchsorted(left_out, at))
        return np.asarray(inside / n / measure)

    replicates = np.array([density(group) for group in by_group])
    return Measured(density(every[:0]), jackknife_error(replicates))
