r"""How F(k, t) of a start of sharp speeds ends: the fronts of those that have collided twice.

Without the tracers that have collided once at most, F falls as K^(-5/2) in the plane and K^-3 in
space: the density of the others has a kink at R = T, of those that were hardly deflected, and
weaker ones at smaller radii. Each is a power of the distance from its radius, perhaps times
logarithms (T = v t/l, R in units of l), in the plane:

- R = T: whole powers, from 1
- R = e T: a head-on collision at once, the others hardly deflect: half-integer powers, from 3/2
- R = a T: two equal deflections, one after the other at once, at a stationary distance; from 3/2
- R = e^2 T: two head-on collisions at once; whole powers, from 2

and in space the same at R = T, and powers from 2, 2 and 3 at the others: one half more for each
head-on collision, and for the plane in which both of two deflections lie.
- R = 0, where e is small: tracers that a collision has stopped; powers of 1/K as in `tail`

The end of F is fitted by functions with these singularities. In R they are known, so that the
transform needs no large K.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import gauss_legendre, panels_between
from kinetics.position.directions import element, mean_phase, radial_measure, radial_waves
from kinetics.position.once_collided import radial_edges
from kinetics.position.tail import origin_terms, origin_transforms
from kinetics.values import Value

_POINTS = 12
_CUT = 2  # functions that begin at an inner front end at T as this power of T^2 - R^2
_NEAREST = 0.03  # of a front to 0 or 1: nearer ones are not resolved by K T of about 100
_AT_ORIGIN, _SMALL = 8, 0.2  # terms at R = 0, and e up to which there are any
# Singular values below one of these shares of the largest are left out: they raise errors of F.
# Which is best depends on how far the fronts are apart, over 1/K.
_SMALLEST = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10)
_ORIGIN = 3.0  # K T from which these fall as powers


@dataclass(frozen=True)
class FrontTail(Value):
    """A sum of functions of R with the singularities of the twice collided, of some speeds.

    Attributes
    ----------
    coefficients : shape (n_functions,)
    restitution : e
    flights : T of each speed, shape (n_speeds,)
    dimension : 2 or 3
    """

    coefficients: FloatArray
    restitution: float
    flights: FloatArray
    dimension: int = 2

    def at(self, k: FloatArray) -> FloatArray:
        """Its part of F at K = k, shape (n_k,)."""
        columns = _columns(k, self.restitution, self.flights, self.dimension)
        return np.asarray(columns @ self.coefficients)

    def transform(self, rho: FloatArray, kind: int) -> FloatArray:
        """Integral over all K at r = rho l, of a kind of `directions.radial_waves`, (n_r,)."""
        out, first = np.zeros(rho.shape), 0
        for T in self.flights:
            parts = _transforms(rho, float(T), (self.restitution, self.dimension), kind)
            out += self.coefficients[first : first + len(parts)] @ parts
            first += len(parts)
        return out


def fit_fronts(
    k: FloatArray, f: FloatArray, restitution: float, flights: FloatArray, dimension: int = 2
) -> tuple[FrontTail, float]:
    """The tail of F through f at K = k, shape (n_k,) each, and what it leaves unknown of g(r, t) l.

    The latter is the largest difference from a fit without the upper quarter of the range, at
    radii no closer to a front than 1/K; it is infinite where there are too few points.
    """
    columns = _columns(k, restitution, flights, dimension)

    def tail(coefficients: FloatArray) -> FrontTail:
        return FrontTail(coefficients, restitution, flights, dimension)

    below = k < k.min() + 0.75 * (k.max() - k.min())
    if np.count_nonzero(below) < columns.shape[1]:
        return tail(np.zeros(columns.shape[1])), np.inf
    best, left = None, np.inf
    for smallest in _SMALLEST:
        full, trial = (
            tail(_least_squares(columns[use], f[use], k[use] ** (0.5 * (dimension + 3)), smallest))
            for use in (k > 0.0, below)
        )
        apart = _difference(full, trial, float(k.max()))
        if best is None or apart < left:
            best, left = full, apart
    assert best is not None
    return best, left


def _difference(one: FrontTail, other: FrontTail, high: float) -> float:
    """How far the densities are apart that follow with F as it is up to K = high, over l."""
    longest, d = float(one.flights.max()), one.dimension
    node, weight = gauss_legendre(8 * math.ceil((40.0 + high * longest) / 8.0))
    k = high * node
    missed = weight * high * radial_measure(k, 0, d) * (one.at(k) - other.at(k))
    largest = 0.0
    for T in one.flights:
        rho = T * _places(one.restitution, high * float(T), d)
        below = radial_waves(np.outer(rho, k), 0, d) @ missed
        beyond = one.transform(rho, 0) - other.transform(rho, 0) - below
        largest = max(largest, float(np.abs(element(rho, d) * beyond).max()))
    return largest


def _places(e: float, turns: float, dimension: int) -> FloatArray:
    """Radii over T: between the fronts, and near them, but no closer than 1/turns."""
    near = 2.0 ** np.arange(4) / turns
    fronts = [1.0, *(ring for ring, _, _ in inner_fronts(e, dimension))]
    x = np.concatenate(
        [np.linspace(0.02, 0.98, 49), *(a + s * near for a in fronts for s in (-1, 1))]
    )
    far = np.min([np.abs(x - a) for a in fronts], axis=0) > 0.99 / turns
    return x[far & (x > 0.0) & (x < 1.0)]


def _least_squares(
    columns: FloatArray, f: FloatArray, weight: FloatArray, smallest: float
) -> FloatArray:
    """Of the errors relative to the power of K with which F falls, 1/weight."""
    found = np.linalg.lstsq(columns * weight[:, None], f * weight, rcond=smallest)
    return np.asarray(found[0])


def _columns(k: FloatArray, e: float, flights: FloatArray, dimension: int) -> FloatArray:
    """The functions at K = k, shape (n_k, n_functions)."""
    columns = []
    for T in flights:
        turns = 2.0 ** math.ceil(math.log2(max(32.0, float(k.max()) * T)))
        rho, parts = _table(e, float(T), turns, dimension)
        columns.append(mean_phase(np.outer(k, rho), dimension) @ parts.T)
        if e < _SMALL:
            columns.append(origin_terms(k * T / _ORIGIN, _AT_ORIGIN, dimension, _first(e)))
    return np.hstack(columns)


def _first(e: float) -> int:
    """Which powers of 1/K tracers leave that a collision has stopped, or nearly: see `tail`."""
    return 0 if e == 0.0 else 1


@lru_cache(maxsize=16)
def _table(e: float, T: float, turns: float, dimension: int) -> tuple[FloatArray, FloatArray]:
    """Radii (n,) on [0, T], and weights R^(d-1) times the functions there, (n_functions, n)."""
    inner = tuple(T * ring for ring, _, _ in inner_fronts(e, dimension))
    rho, weight = panels_between(radial_edges((0.0, *inner, T), T, turns), _POINTS)
    return rho, weight * element(rho, dimension) * _functions(rho / T, e, dimension)


def _functions(x: FloatArray, e: float, dimension: int) -> FloatArray:
    """The functions of x = R/T, shape (n_functions, n), each at most 1 or about 1."""
    return np.asarray(_unscaled(x, e, dimension) / _sizes(e, dimension)[:, None])


@lru_cache(maxsize=16)
def _sizes(e: float, dimension: int) -> FloatArray:
    """Of each function: without it, those between fronts that nearly coincide would be lost."""
    x = np.linspace(0.0, 1.0, 2001)
    return np.abs(_unscaled(x, e, dimension)).max(axis=1) + 1e-290


def _unscaled(x: FloatArray, e: float, dimension: int) -> FloatArray:
    inside = x < 1.0
    d = np.where(inside, (1.0 - x) * (1.0 + x), 1.0)
    out = [np.where(inside, d**nu * np.log(d) ** p, 0.0) for nu in (1, 2, 3) for p in range(nu + 2)]
    for ring, powers, logarithms in inner_fronts(e, dimension):
        q = (x - ring) * (x + ring)
        above = np.where(q > 0.0, np.where(inside, d, 0.0) ** _CUT, 0.0)
        below = np.where(q < 0.0, 1.0, 0.0)
        size = np.where(q == 0.0, 1.0, np.abs(q))
        for nu in powers:
            for p in range(logarithms + 1):
                part = size**nu * np.log(size) ** p
                out += [part * above, part * below]
    return np.array(out)


def _transforms(rho: FloatArray, T: float, gas: tuple[float, int], kind: int) -> FloatArray:
    """Of each function of one speed: (n_functions, n_rho); see :meth:`FrontTail.transform`.

    gas : e and the dimension
    """
    e, d = gas
    if kind == 0:
        parts = _functions(rho / T, e, d)
    elif kind == 1:
        inner = tuple(T * ring for ring, _, _ in inner_fronts(e, d))
        near = np.clip(rho, 0.0, T)
        edges = np.union1d(radial_edges((0.0, *inner, T), T), near)
        x, w = panels_between(edges, _POINTS)
        parts = (w * element(x, d) * _functions(x / T, e, d)).reshape(-1, edges.size - 1, _POINTS)
        sums = np.cumsum(parts.sum(axis=2), axis=1)
        sums = np.concatenate([np.zeros((sums.shape[0], 1)), sums], axis=1)
        parts = sums[:, np.searchsorted(edges, near)] / np.maximum(element(rho, d), 1e-300)
    else:
        step = 1e-5 * T
        ends = [_functions(np.abs(rho + h) / T, e, d) for h in (-step, step)]
        parts = (ends[0] - ends[1]) / (2.0 * step)
    if e < _SMALL:
        scale = _ORIGIN / T
        at_origin = origin_transforms(scale * rho, _AT_ORIGIN, kind, d, _first(e))
        parts = np.concatenate([parts, at_origin * scale ** (d, d - 1, d + 1)[kind]])
    return parts


@lru_cache(maxsize=16)
def inner_fronts(e: float, dimension: int = 2) -> tuple[tuple[float, tuple[float, ...], int], ...]:
    """Radii over T, powers and the highest power of the logarithm, of the fronts inside (0, T)."""
    if e in (0.0, 1.0):
        return ()
    more = 0.5 * (dimension - 2)
    half = (1.5 + more, 2.5 + more)
    found = [(e, half, 1), (e * e, (2.0 + 2.0 * more, 3.0 + 2.0 * more), 1)]
    stationary = _two_equal_deflections(e)
    if stationary is not None:
        found.append((stationary, half, 0))
    return tuple(front for front in found if _NEAREST < front[0] < 1.0 - _NEAREST)


def _two_equal_deflections(e: float) -> float | None:
    """R/T where the distance of those with two equal collisions at one place is stationary.

    A collision multiplies the velocity, as a complex number, by q = ((1-e) + (1+e) exp(i psi))/2.
    The end of the path, for all places of two equal collisions, is the line from 1 to q^2: R is
    stationary at the foot of the perpendicular from 0 where this line touches the curve q^2(psi).
    """
    from scipy.optimize import brentq

    def touches(psi: float) -> float:
        turned = 0.5 * (1.0 + e) * complex(math.cos(psi), math.sin(psi))
        q = 0.5 * (1.0 - e) + turned
        return ((1j * turned * q).conjugate() * (1.0 - q * q)).imag

    psi = np.linspace(0.3, math.pi - 1e-3, 400)
    values = [touches(float(p)) for p in psi]
    for low, high, a, b in zip(psi[:-1], psi[1:], values[:-1], values[1:], strict=True):
        if a * b < 0.0:
            p = float(brentq(touches, low, high, xtol=1e-14))
            turned = 0.5 * (1.0 + e) * complex(math.cos(p), math.sin(p))
            along = 1.0 - (0.5 * (1.0 - e) + turned) ** 2
            return abs(along.imag) / abs(along)
    return None
