r"""Tracers that have collided exactly twice with smooth scatterers: their radial density.

A bounce changes the velocity v by -(1+e) (v.s) s, s the unit vector from the tracer to the centre.
With w = (1+e) (v.s) s tau, tau the time that is left, a tracer that started with velocity c is
after the time T at r = c T - w_1 - w_2. Collisions at time T - tau come with a chance that is
proportional to v.s: it cancels, and the density of each w is, in units of l,

    1/(2 (1+e) |w|) in the plane,   1/(pi (1+e) |w|^2) in space,

times the chance of no other collision. After the first collision, at T - tau with the impact
parameter y, w_2 can be anywhere in a disk (in space a ball), with w_2 = 0 on its edge. The tracers
at a distance R from the start are on the part of a circle (sphere) that is in it:

- in the plane an arc. The integral over its angle theta from w_2 = 0 is smooth in asinh(theta/d),
  d the distance of the arc from w_2 = 0
- in space, at each time tau_2 that is left at the second collision, a circle, round which only
  the chance of no other collision varies. Smooth in asinh(1/tau_2 - a), for a suitable a

The integrals over tau and y have kinks or logarithms where the arc touches the disk or passes
through w_2 = 0: tau obeys a quadratic equation there, and where two of its solutions coincide
the speed ratio s obeys one of fourth order.

P_2(R) is not smooth at R = T, at the radii e T and e^2 T of head-on collisions at once, and at one
more, of two equal deflections. Between these it is a polynomial in a variable in which powers of
the distance from either end become smooth. The quadrature's error is smooth in R nearly everywhere:
in g(r, t) it cancels, as F(k, t) without these tracers has the same error with the other sign.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics import FloatArray
from kinetics.numerics.chebyshev import FirstKind
from kinetics.numerics.gauss import gauss_legendre
from kinetics.position.directions import mean_phase

_NODES = 24  # of the polynomial between two singular radii
_IMPACTS, _TIMES, _ARC, _AROUND = 8, 12, 10, 3  # Gauss points between singular places
_AWAY = (8.0, 64.0, 512.0)
_NEAREST = 1e-6  # of two singular radii, over T
_SOME, _FOR_TURN = 40, 1.4  # Gauss points of a transform, and for each K T


class _First(NamedTuple):
    """First collisions, shape (n,) each; unit speed and unit time.

    tau : time left; x : R; y : impact parameter; along, across : velocity after it; ratio : speed
    """

    tau: FloatArray
    x: FloatArray
    y: FloatArray
    along: FloatArray
    across: FloatArray
    ratio: FloatArray

    @property
    def front(self) -> tuple[FloatArray, FloatArray]:
        """Where w_2 = 0: the place of those that collide no more."""
        return 1.0 - self.tau + self.tau * self.along, self.tau * self.across

    def disk(self, e: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Coordinates of the centre of all places after a second collision, and the radius."""
        reach = 0.5 * self.tau
        centre = 1.0 - self.tau + (1.0 - e) * reach * self.along, (1.0 - e) * reach * self.across
        return *centre, (1.0 + e) * reach * self.ratio

    def part(self, which: NDArray[np.intp], tau: FloatArray) -> _First:
        """Some of them, at other times."""
        return _First(tau, *(value[which] for value in self[1:]))


def twice_within(rho: FloatArray, T: float, e: float, dimension: int) -> FloatArray:
    """Share of all tracers of one speed that have collided twice and are within rho (n,)."""
    ends, values = _table(T, e, dimension)
    node, weight = gauss_legendre(_NODES)
    out = np.zeros(rho.shape)
    for low, high, part in zip(ends[:-1], ends[1:], values, strict=True):
        upto = _local((rho - low) / (high - low))[:, None]
        t = upto * node
        f = (FirstKind(_NODES).rows(t.ravel()) @ part).reshape(t.shape)
        out += (high - low) * np.sum(f * _place(t)[1] * weight * upto, axis=1)
    return out


def twice_density(rho: FloatArray, T: float, e: float, dimension: int) -> FloatArray:
    """P_2 at R = rho (n,), for one speed, in units of l; 0 outside (0, T). From a table."""
    ends, values = _table(T, e, dimension)
    out = np.zeros(rho.shape)
    for low, high, part in zip(ends[:-1], ends[1:], values, strict=True):
        here = (rho > low) & (rho <= high) & (rho < T)
        t = _local((rho[here] - low) / (high - low))
        out[here] = FirstKind(_NODES).rows(t) @ part
    return out


def twice_scattering(k: FloatArray, T: float, e: float, dimension: int) -> FloatArray:
    """Their part of F at K = k (n,), for one speed."""
    ends, values = _table(T, e, dimension)
    out = np.zeros(k.shape)
    for low, high, part in zip(ends[:-1], ends[1:], values, strict=True):
        turns = float(k.max()) * (high - low)
        t, weight = gauss_legendre(_SOME + 8 * math.ceil(_FOR_TURN * turns / 8.0))
        place, slope = _place(t)
        f = (FirstKind(_NODES).rows(t) @ part) * weight * slope * (high - low)
        out += mean_phase(np.outer(k, low + (high - low) * place), dimension) @ f
    return out


@lru_cache(maxsize=16)
def _table(T: float, e: float, dimension: int) -> tuple[FloatArray, FloatArray]:
    """Singular radii (n + 1,), rising from 0 to T, and P_2 at points between, (n, _NODES)."""
    ends = np.unique((*inner_fronts(e), 0.0, 1.0))
    ends = T * ends[np.append(True, np.diff(ends) > _NEAREST)]
    place = _place(FirstKind(_NODES).local)[0]
    radii = ends[:-1, None] + np.diff(ends)[:, None] * place
    return ends, np.array([twice_integral(rho, T, e, dimension) for rho in radii])


def _place(t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Place in an interval, about t^4 near its ends, and its derivative."""
    once = np.sin(0.5 * math.pi * t) ** 2
    slope = (0.5 * math.pi) ** 2 * np.sin(math.pi * t) * np.sin(math.pi * once)
    return np.sin(0.5 * math.pi * once) ** 2, slope


def _local(place: FloatArray) -> FloatArray:
    """t of a place; 0 and 1 for places outside."""
    once = np.arcsin(np.sqrt(np.clip(place, 0.0, 1.0))) / (0.5 * math.pi)
    return np.asarray(np.arcsin(np.sqrt(once)) / (0.5 * math.pi))


@lru_cache(maxsize=16)
def inner_fronts(e: float) -> tuple[float, ...]:
    """Radii over T at which P_2 is not smooth, between 0 and T."""
    if e in (0.0, 1.0):
        return ()
    stationary = _two_equal_deflections(e)
    return (e * e, e) if stationary is None else (e * e, e, stationary)


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


def twice_integral(rho: FloatArray, T: float, e: float, dimension: int) -> FloatArray:
    """P_2 at 0 < R = rho < T (n,), for one speed, in units of l: the integral itself."""
    which, y, weight = _impacts(rho / T, e)
    if dimension == 3:
        weight = 2.0 * y * weight
    square = y * y
    ratio = np.sqrt(e * e + (1.0 - e) * (1.0 + e) * square)
    along = -e + (1.0 + e) * square
    across = (1.0 + e) * y * np.sqrt((1.0 - y) * (1.0 + y))
    each = _First(np.ones_like(y), (rho / T)[which], y, along, across, ratio)
    low, high = _times(each, e)
    middle = each.part(np.repeat(np.arange(y.size), low.shape[1]), 0.5 * (low + high).ravel())
    centre_x, centre_y, radius = middle.disk(e)
    centre = np.hypot(centre_x, centre_y)
    met = (np.abs(centre - middle.x) < radius).reshape(low.shape)
    i, j = np.nonzero(met & (high - low > 1e-12))
    node, w = _eased(_TIMES)
    length = (high - low)[i, j][:, None]
    tau = (low[i, j][:, None] + length * node).ravel()
    first = each.part(np.repeat(i, _TIMES), tau)
    seen = _on_arc if dimension == 2 else _on_sphere
    flown = np.exp(-T * (1.0 - tau + first.ratio * tau))
    part = (weight[i][:, None] * length * w).ravel() * flown * seen(first, e, T)
    return np.asarray(T * np.bincount(np.repeat(which[i], _TIMES), part, rho.size))


def _eased(points: int) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights on [0, 1], for square roots and logarithms at the ends."""
    t, w = gauss_legendre(points)
    return t * t * (3.0 - 2.0 * t), w * 6.0 * t * (1.0 - t)


def _impacts(x: FloatArray, e: float) -> tuple[NDArray[np.intp], FloatArray, FloatArray]:
    """Impact parameters y in [0, 1] for each R = x (n,): which x, y and weights, one line each."""
    edges = [np.zeros_like(x), np.ones_like(x), x]
    # near R = T the deflections that count are of size (1 - y)/(1 - x) = 1
    edges += [np.maximum(0.0, 1.0 - away * (1.0 - x)) for away in _AWAY]
    lost = (1.0 - e) * (1.0 + e)
    if lost > 0.0:
        # s where the discriminant of a quadratic equation of `_times` is zero
        k, q = (1.0 + e) * x, 4.0 * (1.0 + e) * (1.0 - x) * (1.0 + x)
        companion = np.zeros((x.size, 4, 4))
        companion[:, 0, 0] = -2.0 * k
        companion[:, 0, 1] = 2.0 * (2.0 + e) - k * k - q
        companion[:, 0, 2] = 2.0 * k * (2.0 + e)
        companion[:, 0, 3] = q - (2.0 + e) ** 2
        companion[:, [1, 2, 3], [0, 1, 2]] = 1.0
        s = np.linalg.eigvals(companion)
        real = np.where(np.abs(s.imag) < 1e-7, np.minimum(np.abs(s.real), 1.0), 0.0)
        # s where tau is 1 in one of them
        last = np.minimum(1.0, [x, x / max(e, 1e-300)])
        square = (np.vstack([real.T, last]) ** 2 - e * e) / lost
        edges += list(np.sqrt(np.clip(square, 0.0, 1.0)))
    sorted_edges = np.sort(np.array(edges).T, axis=1)
    length = np.diff(sorted_edges, axis=1)
    i, j = np.nonzero(length > 1e-9)
    node, w = _eased(_IMPACTS)
    y = sorted_edges[i, j][:, None] + length[i, j][:, None] * node
    return np.repeat(i, _IMPACTS), y.ravel(), (length[i, j][:, None] * w).ravel()


def _times(each: _First, e: float) -> tuple[FloatArray, FloatArray]:
    """Ends of intervals of tau in (0, 1) between its singular values, (n, 7) each.

    There R is that of w_2 = 0, or that of the disk's nearest or farthest point.
    """
    miss = (1.0 - each.y) * (1.0 + each.y)
    left = (1.0 - each.x) * (1.0 + each.x)
    square = (1.0 + e) * (1.0 - e) * (1.0 + e) * miss
    linear, shift = each.ratio**2 - 2.0 - e, (1.0 + e) * each.x * each.ratio
    equations = (
        ((1.0 + e) ** 2 * miss, -2.0 * (1.0 + e) * miss),
        (square, linear + shift),
        (square, linear - shift),
    )
    tau = [np.zeros_like(miss), np.ones_like(miss)]
    for a, b in equations:
        discriminant = b * b - 4.0 * a * left
        root = np.sqrt(np.maximum(discriminant, 0.0))
        q = -0.5 * (b + np.where(b < 0.0, -root, root))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            for found in (q / a, left / q):
                real = (discriminant >= 0.0) & np.isfinite(found)
                tau.append(np.clip(np.where(real, found, 0.0), 0.0, 1.0))
    edges = np.sort(np.array(tau).T, axis=1)
    return edges[:, :-1], edges[:, 1:]


def _on_arc(first: _First, e: float, T: float) -> FloatArray:
    """Density of the second collisions at R, in the plane, over the chance to fly on instead."""
    x, (front_x, front_y) = first.x, first.front
    centre_x, centre_y, radius = first.disk(e)
    front, centre = np.hypot(front_x, front_y), np.hypot(centre_x, centre_y)
    # angles from w_2 = 0, seen from the start of the path
    middle = np.arctan2(
        front_x * centre_y - front_y * centre_x, front_x * centre_x + front_y * centre_y
    )
    end = (x * x + centre * centre - radius * radius) / np.maximum(2.0 * x * centre, 1e-300)
    half, all_round = np.arccos(np.clip(end, -1.0, 1.0)), end <= -1.0
    near = np.maximum(np.abs(front - x), 1e-14) / np.maximum(np.sqrt(front * x), 1e-150)
    low = np.arcsinh(np.where(all_round, -math.pi, middle - half) / near)[:, None]
    high = np.arcsinh(np.where(all_round, math.pi, middle + half) / near)[:, None]
    node, weight = gauss_legendre(_ARC)
    theta = near[:, None] * np.sinh(low + (high - low) * node)
    sine, cosine = np.sin(0.5 * theta), np.cos(0.5 * theta)
    square = (front - x)[:, None] ** 2 + 4.0 * (front * x)[:, None] * sine * sine
    # v along and across the direction to w_2 = 0
    away = np.maximum(front, 1e-150)
    along = ((first.along * front_x + first.across * front_y) / away)[:, None]
    across = ((first.across * front_x - first.along * front_y) / away)[:, None]
    toward = along * (front - x)[:, None]  # v.w_2
    toward = toward + 2.0 * x[:, None] * sine * (along * sine - across * cosine)
    # the time that is left, at most tau but for rounding
    second = np.minimum(square / np.maximum((1.0 + e) * toward, 1e-300), first.tau[:, None])
    path = first.ratio[:, None] * second
    after = np.sqrt(np.maximum(path * path - (1.0 - e) / (1.0 + e) * square, 0.0))
    value = np.hypot(near[:, None], theta) * np.exp(T * (path - after)) / np.sqrt(square)
    return np.asarray(x / (2.0 * (1.0 + e)) * (((high - low) * value) @ weight))


def _on_sphere(first: _First, e: float, T: float) -> FloatArray:
    """The same in space, by the integral over 1/tau_2."""
    x, speed = first.x, 0.5 * (1.0 + e) * first.ratio  # of the ball's radius as tau_2 rises
    front = np.maximum(np.hypot(*first.front), 1e-150)
    toward = first.along * first.front[0] + first.across * first.front[1]  # v.front
    lean = 0.5 * (1.0 + e) * toward
    gap = (front - x) * (front + x)
    gap = np.where(np.abs(gap) < 1e-14, 1e-14, gap)
    # the spheres of all tau_2 touch one another where w_2 = 0: of 1/tau_2 at which they touch R,
    # the larger is that of the first, and the smaller, if it is positive, that of the last
    touch = np.sort([2.0 * (lean - x * speed) / gap, 2.0 * (lean + x * speed) / gap], axis=0)
    low = np.maximum(touch[0], 1.0 / first.tau)
    high = np.maximum(touch[1], low)
    # 1/tau_2 = shift + width sinh(z): the centre is at the distance tau_2 front width cosh(z)
    shift = lean / (front * front)
    across = np.abs(first.across * first.front[0] - first.along * first.front[1])
    width = 0.5 * (1.0 + e) * np.maximum(across, 1e-12 * first.ratio * front) / (front * front)
    width = np.maximum(width, 1e-150)
    ends = np.arcsinh((low - shift) / width)[:, None], np.arcsinh((high - shift) / width)[:, None]
    node, weight = gauss_legendre(_ARC)
    z = ends[0] + (ends[1] - ends[0]) * node
    second = 1.0 / np.clip(shift[:, None] + width[:, None] * np.sinh(z), low[:, None], None)
    centre = np.maximum(second * (front * width)[:, None] * np.cosh(z), 1e-150)
    radius, path = second * speed[:, None], second * first.ratio[:, None]
    # cosines of the angles between the centre's direction and those of R and of v
    apart = np.clip((x[:, None] ** 2 - centre**2 - radius**2) / (2.0 * centre * radius), -1.0, 1.0)
    turned = (toward[:, None] - radius * first.ratio[:, None]) / first.ratio[:, None] / centre
    turned = np.clip(turned, -1.0, 1.0)
    across_both = np.sqrt((1.0 - apart**2) * (1.0 - turned**2))
    lost = 2.0 * (1.0 - e) / (1.0 + e) * radius**2
    value = np.zeros_like(path)
    for cosine in np.cos(math.pi * (np.arange(_AROUND) + 0.5) / _AROUND):
        rest = path**2 - lost * (1.0 - apart * turned - across_both * cosine)
        value += np.exp(T * (path - np.sqrt(np.maximum(rest, 0.0)))) / _AROUND
    return np.asarray(x / (1.0 + e) / front * (((ends[1] - ends[0]) * value) @ weight))
