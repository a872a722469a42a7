r"""Tracers that have collided exactly once: their density is one integral, their F(k, t) another.

In units of the mean free path, a tracer of speed v that has flown T = v t/l without or with one
collision flew x to the collision and u = T - x after it, and is at distance R. With the impact
parameter y (`kinetics.collision`), R^2 is linear in y^2 for each x:

    R^2 = A^2 + y^2 (B^2 - A^2),   A = x - e u,   B = x + et u.

These tracers have weight exp(-x - s(y) u). In the plane y is uniform, and their radial density is

    P_1(R) = R integral of exp(-x - s u)/sqrt(|B^2 - A^2| |R^2 - A^2|) du

over all u at which R is between |A| and B. In space y^2 is uniform, and it is

    P_1(R) = 2 R integral of exp(-x - s u)/|B^2 - A^2| du.

For smooth disks B = T, and with A = R tanh z no edge is singular. P_1 itself has a logarithm at
R = T for smooth scatterers and, for 0 < e < 1, a square root (in space a kink) at R = e T, above
which no tracer collided at once and head-on. For et < 1 it has a step at R = T instead. A Fourier
transform on finitely many wave numbers cannot show these.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import equal_panels, gauss_legendre, panels_between
from kinetics.position.directions import mean_phase
from kinetics.position.twice_collided import twice_density, twice_scattering, twice_within
from kinetics.results import Value
from kinetics.states.state import State

_POINTS = 12  # of a Gauss rule, on panels in z of length 2 at most: rounding is left
_FAR = 34.0  # in z: the integrand falls as exp(-|z|) there, to e^-34 = 2e-15
_LENGTH = 2.0  # of a panel in z for other bounces
_NEAREST = 20  # panels towards a singular radius, each a quarter of the next
_TURN = 6.0  # of K R on a panel in R, at most
FARTHEST = 40.0  # R beyond which there are none: fewer than e^-R
# T beyond which rounding spoils their density, and beyond which that of the twice-collided, which
# is known as a polynomial between the fronts, is not resolved
_LONGEST, _LONGEST_OF_TWICE = 2e7, 40.0


class Scatterer(NamedTuple):
    """What a tracer has collided with."""

    restitution: float
    tangential_restitution: float
    dimension: int

    @property
    def smooth(self) -> bool:
        """Whether it leaves the tangential velocity unchanged."""
        return self.tangential_restitution == 1.0

    @property
    def smooth_disk(self) -> bool:
        """Whether it is the scatterer of the paper."""
        return self.smooth and self.dimension == 2

    def singular_radii(self, T: float) -> tuple[float, ...]:
        """R at which P_1 is not smooth, 0 and T among them."""
        e, et = self.restitution, self.tangential_restitution
        if et == 1.0:
            return (0.0, e * T, T)
        same = T * (e + et) / (2.0 + e - et)  # reached with any impact parameter, where et <= e
        return (0.0, e * T, et * T, *((same,) if et <= e else ()), T)


@dataclass(frozen=True)
class OnceCollided(Value):
    """The tracers that have collided once, or twice at most, of a start of one sharp speed.

    Attributes
    ----------
    restitution : e, and 1 for a law that is given by samples, for which none are kept apart
    mean_free_path : l, in d
    flights : T = v t/l of each time, shape (n_times,); 0 for other starts
    kept : whether these tracers are kept apart at each time, shape (n_times,)
    tangential_restitution : et
    dimension : 2 or 3
    twice : whether those that have collided twice are among them
    """

    restitution: float
    mean_free_path: float
    flights: FloatArray
    kept: NDArray[np.bool_]
    tangential_restitution: float = 1.0
    dimension: int = 2
    twice: bool = False

    @property
    def scatterer(self) -> Scatterer:
        """What they have collided with."""
        return Scatterer(self.restitution, self.tangential_restitution, self.dimension)

    def kept_apart(self, time: int) -> bool:
        """Whether these tracers are kept apart at a time."""
        return bool(self.kept[time])

    def has_front(self, time: int, least: float) -> bool:
        """Whether more than a share ``least`` of the tracers has not collided at a time."""
        with np.errstate(under="ignore"):
            return self.kept_apart(time) and bool(np.exp(-self.flights[time]) > least)

    def at(self, time: int, r: FloatArray) -> FloatArray:
        """Their density in 1/d at radii r in d, shape (n_r,)."""
        if not self.kept[time]:
            return np.zeros(r.shape)
        rho, T = r / self.mean_free_path, float(self.flights[time])
        found = once_density(rho, T, self.scatterer)
        if self._twice(T):
            found = found + twice_density(rho, T, self.restitution, self.dimension)
        return np.asarray(found / self.mean_free_path)

    def within(self, time: int, r: FloatArray) -> FloatArray:
        """Share of all tracers that are among these and within r, shape (n_r,)."""
        if not self.kept[time]:
            return np.zeros(r.shape)
        rho, T = r / self.mean_free_path, float(self.flights[time])
        near = np.clip(rho, 0.0, min(T, FARTHEST))
        edges = np.union1d(_edges(self.scatterer, T), near)
        x, w = panels_between(edges, _POINTS)
        part = (once_density(x, T, self.scatterer) * w).reshape(edges.size - 1, -1)
        sums = np.concatenate([[0.0], np.cumsum(part.sum(axis=1))])
        found = sums[np.searchsorted(edges, near)]
        if self._twice(T):
            near = np.clip(rho, 0.0, T)
            found = found + twice_within(near, T, self.restitution, self.dimension)
        return np.asarray(found)

    def scattering(self, time: int, wave_numbers: FloatArray) -> FloatArray:
        """Their part of F(k, t) at K = k l, shape (n_k,)."""
        if not self.kept[time]:
            return np.zeros(wave_numbers.shape)
        T = float(self.flights[time])
        # few different resolutions, so that tables are used again
        turns = float(wave_numbers.max(initial=0.0)) * min(T, FARTHEST)
        turns = 2.0 ** math.ceil(math.log2(max(32.0, turns)))
        rho, weight = _table(self.scatterer, T, turns)
        found = mean_phase(np.outer(wave_numbers, rho), self.dimension) @ weight
        if self._twice(T):
            found += twice_scattering(wave_numbers, T, self.restitution, self.dimension)
        return np.asarray(found)

    def _twice(self, T: float) -> bool:
        return self.twice and T < _LONGEST_OF_TWICE


def once_collided(
    law: CollisionLaw, state: State, mean_free_path: float, times: FloatArray, least: float
) -> OnceCollided:
    """The once-collided tracers of a start of one speed, at the times at which they count.

    least : share of tracers that is negligible
    """
    peaks, e, et = state.peaks, law.restitution, law.tangential_restitution
    if e is None or et is None:  # every sample has its own singular radii
        peaks, e, et = None, 1.0, 1.0
    one = peaks is not None and np.ptp(peaks[0]) == 0.0
    speed = float(peaks[0][0]) if peaks is not None and one else 0.0
    with np.errstate(over="ignore", under="ignore"):
        flights = times * speed / mean_free_path
        # those that lost most at once: that flew e T after a head-on collision where e < et
        kept = (np.exp(-min(e, et) * flights) > least) & (flights > least) & (flights < _LONGEST)
    return OnceCollided(e, mean_free_path, flights, kept, et, law.dimension, twice=et == 1.0)


def once_density(rho: FloatArray, T: float, scatterer: Scatterer) -> FloatArray:
    """P_1 at R = rho (n,), for one speed, in units of l; 0 outside (0, T)."""
    if scatterer.smooth_disk:
        return _smooth_disks(rho, T, scatterer.restitution)
    out = np.zeros(rho.shape)
    inside = (rho > 0.0) & (rho < T)
    if inside.any():
        out[inside] = _any_bounce(rho[inside], T, scatterer)
    return out


def _smooth_disks(rho: FloatArray, T: float, e: float) -> FloatArray:
    """P_1 by the integral over A = R tanh z."""
    out = np.zeros(rho.shape)
    inside = (rho > 0.0) & (rho < T)
    r = rho[inside][:, None]
    if r.size == 0:
        return out
    # r^2 sech^2 z and T^2 - r^2 are equal where the integrand begins to fall as exp(-z)
    rest = np.maximum((T - r) * (T + r) / r / r, 1e-30)
    high = np.maximum(0.0, 0.5 * np.log(4.0 / rest)) + _FAR
    with np.errstate(divide="ignore"):
        low = np.maximum(-np.arctanh(np.minimum(1.0, e * T / r)), -high)
    count = math.ceil(0.5 * float((high - low).max()))
    node, weight = gauss_legendre(_POINTS)
    local = ((np.arange(count)[:, None] + node) / count).ravel()
    z = low + (high - low) * local
    sech = 1.0 / np.cosh(z)
    A = r * np.tanh(z)
    x, u = (A + e * T) / (1.0 + e), (T - A) / (1.0 + e)
    root = np.sqrt(rest + sech * sech)
    s = np.sqrt(e * e + (1.0 - e * e) * (sech / root) ** 2)
    with np.errstate(under="ignore"):
        value = sech * np.exp(-x - s * u) / root
    out[inside] = (high - low)[:, 0] * (value @ np.tile(weight / count, count)) / (1.0 + e)
    return out


def _any_bounce(r: FloatArray, T: float, scatterer: Scatterer) -> FloatArray:
    """P_1 by the integral over u, in two parts, R rising with y in one and falling in the other."""
    e, et = scatterer.restitution, scatterer.tangential_restitution
    # u at which A = R, A = -R and B = R
    first, second = (T - r) / (1.0 + e), (T + r) / (1.0 + e)
    third = (T - r) / (1.0 - et) if et < 1.0 else np.full_like(r, np.inf)
    end = np.minimum(T, np.minimum(second, third))
    out = _between(first, end, True, r, (T, scatterer))
    if et < e:
        end = np.minimum(T, np.maximum(second, third))
        out += _between(end, np.full_like(r, T), False, r, (T, scatterer))
    return out


def _between(
    low: FloatArray,
    high: FloatArray,
    rising: bool,
    r: FloatArray,
    system: tuple[float, Scatterer],
) -> FloatArray:
    """The integral over low < u < high, for each r; rising : whether R rises with y there.

    u = low + (high - low)/(1 + exp(-z)): no power of the distance from either end is singular in
    z. Each distance is a sum of terms of one sign, but for those that are far from zero.
    """
    T, scatterer = system
    e, et, d = scatterer.restitution, scatterer.tangential_restitution, scatterer.dimension
    far = _FAR if d == 3 else 2.0 * _FAR  # in the plane the ends are inverse square roots
    z, weight = equal_panels(2.0 * far, _POINTS, _LENGTH)
    share = 1.0 / (1.0 + np.exp(z - far))  # of the interval above u, and below by symmetry
    length = np.maximum(high - low, 0.0)[:, None]
    above, below = length * share, length * share[::-1]
    low, high, r = low[:, None], high[:, None], r[:, None]
    u, x = low + below, (T - high) + above

    def distance(end: float | FloatArray) -> FloatArray:
        """From u to an end that is above the interval where R rises with y, else below it."""
        if rising:
            return np.maximum(end - high, 0.0) + above
        return np.maximum(low - end, 0.0) + below

    # at the second of these u, |A| = B, and every impact parameter leads to the same R
    to_minus, to_same = distance((T + r) / (1.0 + e)), distance(2.0 * T / (2.0 + e - et))
    to_plus = np.maximum(low - (T - r) / (1.0 + e), 0.0) + below
    rise = (1.0 + e) ** 2 * to_plus * to_minus  # |R - A| |R + A|
    gap = (e + et) * (2.0 + e - et) * u * to_same  # |B^2 - A^2|
    with np.errstate(under="ignore", divide="ignore", invalid="ignore"):
        square = np.minimum(1.0, rise / gap)  # y^2
        ratio = np.sqrt(np.maximum(0.0, e * e + (et * et - e * e) * square))
        chance = 2.0 * r / gap if d == 3 else r / np.sqrt(gap * rise)
        value = np.exp(-x - ratio * u) * chance * length * share * share[::-1]
    return np.asarray(np.where(np.isfinite(value), value, 0.0) @ weight)


@lru_cache(maxsize=16)
def _table(scatterer: Scatterer, T: float, turns: float) -> tuple[FloatArray, FloatArray]:
    """Radii on [0, T], and weights times P_1 there, for K T up to ``turns``, (n,) each."""
    rho, weight = panels_between(_edges(scatterer, T, turns), _POINTS)
    return rho, weight * once_density(rho, T, scatterer)


def _edges(scatterer: Scatterer, T: float, turns: float = 0.0) -> FloatArray:
    """Edges of panels from 0 to where there are no more once-collided; see `radial_edges`."""
    far = min(T, FARTHEST)
    return radial_edges((*scatterer.singular_radii(T), far), far, turns)


def radial_edges(singular: tuple[float, ...], T: float, turns: float = 0.0) -> FloatArray:
    """Edges of panels on [0, T], short towards the singular radii, and for J_0(K R), K T = turns.

    The singular radii include 0 and T.
    """
    ends = np.unique(np.minimum(singular, T))
    ends = ends[np.append(True, np.diff(ends) > 1e-12 * T)]
    near = np.append(0.0, 0.5 * 0.25 ** np.arange(_NEAREST, -1.0, -1.0))
    edges = [np.linspace(0.0, T, math.ceil(turns / _TURN) + 1)]
    for low, high in itertools.pairwise(ends):
        edges += [low + (high - low) * near, high - (high - low) * near]
    together = np.unique(np.concatenate(edges))
    return together[(together >= 0.0) & (together <= T)]
