"""The numbers to which runs and solutions are reduced so that they can be compared.

Errors are jackknifed over independent groups of tracers: configurations of scatterers where there
are any.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics import Solution, sonine
from kinetics.numerics.gauss import panels_between

Array = NDArray[np.float64]

SPEED_EDGES = np.concatenate([np.linspace(0.0, 2.0, 21), np.linspace(2.25, 6.0, 16)])
"""Bins of c = v/v0 for F(c)."""
POSITION_EDGES = np.concatenate([np.linspace(0.0, 3.0, 31), np.linspace(3.25, 6.0, 12)])
"""Bins of R = r/sqrt(<r^2>) for G(R)."""
LEAST_EXPECTED = 50
"""Samples that a bin must be expected to hold before its jackknife error is trusted."""


@dataclass(frozen=True)
class Measured:
    """An estimate with its standard error, of the same shape; NaN where nothing was measured."""

    value: Array
    error: Array

    @staticmethod
    def of(estimate: Any) -> "Measured":
        """Of anything that has both."""
        return Measured(np.asarray(estimate.value), np.asarray(estimate.error))

    @staticmethod
    def joined(parts: Iterable[Any]) -> "Measured":
        """Several estimates of one shape as one, along a new first axis."""
        known = list(parts)
        return Measured(np.array([p.value for p in known]), np.array([p.error for p in known]))

    @property
    def last(self) -> "Measured":
        """The last one, of shape ()."""
        return Measured(np.asarray(np.ravel(self.value)[-1]), np.asarray(np.ravel(self.error)[-1]))

    def __truediv__(self, scale: float | Array) -> "Measured":
        return Measured(np.asarray(self.value / scale), np.asarray(self.error / scale))

    def __getitem__(self, where: Any) -> "Measured":
        return Measured(np.asarray(self.value[where]), np.asarray(self.error[where]))


def jackknife_error(replicates: Array) -> Array:
    """Standard error from n >= 2 estimates that each leave out one group, shape (n, ...)."""
    n = len(replicates)
    return np.asarray(np.sqrt((n - 1) * np.var(replicates, axis=0)))


def jackknifed(sums: dict[str, Array], of: Callable[[dict[str, Array]], Array]) -> Measured:
    """A function of averages that are given for each of n groups, and its standard error."""
    n = len(next(iter(sums.values())))
    value = of({name: np.asarray(x.mean()) for name, x in sums.items()})
    without = {name: (x.sum() - x) / (n - 1) for name, x in sums.items()}
    return Measured(np.asarray(value), jackknife_error(of(without)))


def contact_value(number_density: float, dimension: int = 2) -> float:
    """The pair correlation at contact, g(d), by which the mean free path is divided.

    Of hard disks that of D. Henderson, Mol. Phys. 30, 971 (1975), number_density in d^-2; of hard
    spheres that of N. F. Carnahan and K. E. Starling, J. Chem. Phys. 51, 635 (1969), in d^-3.
    """
    if dimension == 3:
        fraction = math.pi * number_density / 6
        return (1 - fraction / 2) / (1 - fraction) ** 3
    fraction = math.pi * number_density / 4
    return (1 - 7 * fraction / 16) / (1 - fraction) ** 2


def cooling_rate_between(times: Array, thermal_speed: Array, early: int, half_rate: float) -> float:
    """h from 1/v0 at index `early` and at the last time; half_rate is 1/(2 l), for disks d rho0."""
    slope = (1 / thermal_speed[-1] - 1 / thermal_speed[early]) / (times[-1] - times[early])
    return float(slope / half_rate)


def msd_slope_between(times: Array, msd: Array, early: int) -> float:
    """Mean d<r^2>/d ln t between index `early` and the last time."""
    return float((msd[-1] - msd[early]) / np.log(times[-1] / times[early]))


def ball(dimension: int) -> float:
    """Area of the unit circle, or volume of the unit sphere."""
    return math.pi if dimension == 2 else 4 * math.pi / 3


def gaussian_vdf(c: ArrayLike, dimension: int) -> Array:
    """The Gaussian F(c) with <c^2> = 1: a density in the plane, or in space."""
    if dimension == 2:
        return sonine.vdf(c, 0.0)
    return np.asarray((1.5 / math.pi) ** 1.5 * np.exp(-1.5 * np.square(c)))


def middles(edges: Array) -> Array:
    """The middle of each bin."""
    return np.asarray((edges[1:] + edges[:-1]) / 2)


def bin_measure(dimension: int) -> Array:
    """Area, or volume, of each bin of c."""
    return np.asarray(ball(dimension) * np.diff(SPEED_EDGES**dimension))


def last_vdf(solution: Solution) -> Callable[[Array], Array]:
    """F(c) of a solution at its last time, from its radial density over v = c v0(t)."""
    v0, law = float(solution.thermal_speed[-1]), solution.scene.law

    def vdf(c: Array) -> Array:
        surface = law.unit_surface * c ** (law.dimension - 1)
        return np.asarray(v0 * solution.speed_density(c * v0)[-1] / surface)

    return vdf


def bin_average(vdf: Callable[[Array], ArrayLike], dimension: int) -> Array:
    """F(c) averaged over the area, or volume, of each bin of c, by 8 Gauss points in each."""
    d = dimension
    c, weight = panels_between(SPEED_EDGES, 8)
    shares = (d * c ** (d - 1) * np.asarray(vdf(c)) * weight).reshape(-1, 8).sum(axis=1)
    return np.asarray(shares / np.diff(SPEED_EDGES**d))


def scaled_density(samples: Array, edges: Array, measure: Array) -> Measured:
    """Density of samples over their own root mean square, per bin, with its jackknife error.

    samples (n_groups, n_in_group): absolute values; edges (n_bins + 1,) of the scaled variable;
    measure (n_bins,): length or area of each bin. The scale is the sample's, also when a group is
    left out.
    """
    every, by_group = np.sort(samples, axis=None), np.sort(samples, axis=1)

    def density(left_out: Array) -> Array:
        n = every.size - left_out.size
        at = edges * np.sqrt((np.sum(every**2) - np.sum(left_out**2)) / n)
        inside = np.diff(np.searchsorted(every, at) - np.searchsorted(left_out, at))
        return np.asarray(inside / n / measure)

    replicates = np.array([density(group) for group in by_group])
    return Measured(density(every[:0]), jackknife_error(replicates))
