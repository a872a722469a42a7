r"""The generator of the velocity of a driven tracer, harmonic by harmonic, and its steady state.

Of a function h = sum_m H_m(v) Y_m of the velocity, Y_m = cos(m phi) in the plane and P_m(cos theta)
in space about the field (family 0), or sin(m phi) and P_m^1(cos theta) cos(azimuth) across it
(family 1), the rate of change of its average is that of

    L h = collisions + D_v laplacian h - gamma v.grad h + g d_x h.

A collision with a scatterer of velocity V and the normal n is at the rate q dphi_n/2 in the plane,
q dOmega_n/pi in space, q = (v - V).n > 0, and takes (1 + e*) q n from the velocity. Only V.n
matters, which is Gaussian of deviation w. Distributions are the averages of the polynomials of the
axis: they obey the transposed matrices, and averages over them are sums.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.drive import Drive
from kinetics.driven.axis import SpeedAxis
from kinetics.driven.harmonics import Chain, across, along
from kinetics.driven.panels import bounces
from kinetics.driven.speed_range import collision_rate, top_speed
from kinetics.numerics import FloatArray
from kinetics.numerics.blocks import BlockElimination
from kinetics.numerics.gauss import gauss_legendre
from kinetics.numerics.refinement import RefinementRules, refine_until_converged

_MOST_NODES, _MOST_HARMONICS = 180, 70
_MOST_SUMMED = 2e8  # impacts times functions of a solution that may have a finer one: seconds
_FLOOR = 1e-12  # below it two solutions may agree by chance: ten times what rounding makes
# Under noise the density next to rest has odd powers of v, where impacts begin to stick a root:
# errors fall as a power of the number of speeds, and up to 3.8 times what two solutions differ by
# is left
SLOWLY = 4.0
# speeds, over the thermal one, at which densities are compared
TRIED = np.append([0.01, 0.02, 0.04, 0.07], np.linspace(0.1, 3.0, 60))
_REACH = 8.5  # standard deviations of a scatterer's velocity: beyond it is 1e-16 of them


@dataclass(frozen=True)
class Resolution:
    """How finely the velocity is resolved.

    nodes : of the speed axis
    points : of the quadrature over the impact, in each of its two directions
    harmonics : M; harmonics 0 ... M are solved
    rtol : what speeds above the top, and a step of time, may miss
    """

    nodes: int
    points: int
    harmonics: int
    rtol: float

    @classmethod
    def first(cls, drive: Drive, rtol: float, span: float, harmonics: int = 1) -> Resolution:
        """One that is often enough; span : asinh of the highest speed over the axis' scale."""
        digits = -math.log10(max(rtol, 1e-12))
        most = 4 * _MOST_HARMONICS // 5 - 2  # so that one finer solution is left; of nodes too
        if drive.only_falls:
            assert drive.law is not None
            lossy = 1.0 + 0.4 * drive.law.mean_log_loss  # then directions vary faster
            turns = min(math.ceil((4.0 + 0.25 * digits**2) * lossy), most)
            return cls(math.ceil((6.0 + 2.5 * digits) * lossy**0.4), 0, turns, 10.0**-digits)
        if not drive.is_driven:
            nodes = 20.0 + 5.0 * digits
        elif drive.bath_speed:
            nodes = 6.0 + (0.1 * digits**2 if drive.field else 0.45 * digits) * max(span, 2.5)
        else:
            nodes = 8.0 + 0.8 * digits * max(span, 3.0)
        if drive.is_field_dominated:
            coupled = 4.0 + 0.25 * digits**2
        elif drive.field:
            coupled = 2.0 + (0.6 + 0.4 * math.sqrt(drive.field) / drive.scale) * digits
        else:
            coupled = 0.0
        nodes, coupled = min(nodes, 0.8 * _MOST_NODES - 4.0), min(coupled, most)
        points = math.ceil(14.0 + 0.26 * digits**2 if drive.field else 6.0 + 2.4 * digits)
        return cls(math.ceil(nodes), points, max(harmonics, math.ceil(coupled)), 10.0**-digits)

    @property
    def finer(self) -> Resolution | None:
        """With more of everything, harmonics only where a field couples them; None at the end."""
        nodes = self.nodes + self.nodes // 5 + 3
        points = self.points + self.points // 5 + 3
        m = self.harmonics if self.harmonics < 3 else self.harmonics + self.harmonics // 4 + 2
        enough = nodes <= _MOST_NODES and m <= _MOST_HARMONICS
        return Resolution(nodes, points, m, 0.2 * self.rtol) if enough else None


class Generator:
    """The matrices of one drive, in units of l, on one axis of speeds."""

    def __init__(self, drive: Drive, axis: SpeedAxis, resolution: Resolution) -> None:
        self.drive, self.axis = drive, axis
        self.harmonics, self._points, self.impacts = resolution.harmonics, resolution.points, 0
        v, d = axis.speeds, drive.dimension
        self._collide()
        summed = self.impacts * (axis.size + self.harmonics)
        self.finer = resolution.finer if summed < _MOST_SUMMED else None
        slopes, inverse = [axis.derivative(0), axis.derivative(1)], np.diag(1.0 / v)
        noise = drive.heating * axis.faded[:, None]
        for m, matrix in enumerate(self.matrices):
            slope, second = slopes[m % 2], slopes[1 - m % 2] @ slopes[m % 2]
            spread = second + (d - 1.0) * inverse @ slope - m * (m + d - 2.0) * inverse**2
            matrix += noise * spread - drive.drag * v[:, None] * slope
        # distributions, as averages of the polynomials, obey the transposed matrices
        inverse = axis.faded / v
        pull = [-(axis.faded[:, None] * one).T - np.diag((d - 1.0) * inverse) for one in slopes]
        lost = -self.matrices.swapaxes(1, 2)
        self.chain = Chain(
            d, lost, (pull[1], pull[0]), inverse, drive.field, drive.is_field_dominated
        )

    def _impacts(self, v: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Cosine of the normal to the velocity, q, and the rate of each quadrature point."""
        drive, w = self.drive, self.drive.bath_speed
        reach = _REACH * w / v  # cosines below which the scatterer's own velocity may decide
        if w:
            edges = np.unique(np.clip([-reach, reach, 1.0], -1.0, 1.0))
        else:
            breaks = drive.breaks / v
            edges = np.unique(np.concatenate([[0.0], breaks[breaks < 1.0], [1.0]]))
        count = max(10, self._points // max(1, edges.size - 2))
        x, weight = gauss_legendre(count) if w else self._gathered(count)
        at = np.arcsin(edges) if drive.dimension == 2 else edges
        place = (at[:-1, None] + np.diff(at)[:, None] * x).ravel()
        weight = (np.diff(at)[:, None] * weight).ravel()
        cosine = np.sin(place) if drive.dimension == 2 else place
        weight = weight if drive.dimension == 2 else 2.0 * weight
        if not w:
            return cosine, v * cosine, weight * v * cosine
        low = np.maximum(0.0, v * cosine - _REACH * w)
        high = v * cosine + _REACH * w
        cosine, low, high, weight = (a[high > 0.0] for a in (cosine, low, high, weight))
        cuts = np.clip(drive.breaks, low[:, None], high[:, None])
        cuts = np.concatenate([low[:, None], cuts, high[:, None]], axis=1)
        x, share = self._gathered(self._points)
        width = np.diff(cuts, axis=1)[:, :, None]
        q = (cuts[:, :-1, None] + width * x).reshape(cosine.size, -1)
        share = (width * share).reshape(cosine.size, -1)
        away = (v * cosine[:, None] - q) / w
        chance = np.exp(-0.5 * away**2) / (math.sqrt(2.0 * math.pi) * w)
        rate = weight[:, None] * share * q * chance
        return np.broadcast_to(cosine[:, None], q.shape).ravel(), q.ravel(), rate.ravel()

    def _gathered(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Nodes and weights on [0, 1], close to 0 where slow impacts need it."""
        x, weight = gauss_legendre(count)
        if not self.drive.is_singular:
            return x, weight
        power = 4.0  # as e varies as v_n^(1/5)
        return x**power, weight * power * x ** (power - 1.0)

    def _collide(self) -> None:
        """Matrices of collisions for each harmonic, and the rate at each speed."""
        n, d = self.axis.size, self.drive.dimension
        if self.drive.law is not None:
            self.rate = self.axis.speeds
            self.matrices = self._scaled(self.drive.law)
            return
        self.matrices = np.zeros((self.harmonics + 1, n, n))
        self.rate = np.zeros(n)
        for i, v in enumerate(self.axis.speeds):
            cosine, q, rate = self._impacts(v)
            lost = self.drive.impulse(q) * q
            along, square = v - lost * cosine, (lost * cosine) ** 2
            after = np.sqrt(along**2 + (lost**2 - square))
            turned = np.divide(along, after, out=np.ones_like(after), where=after > 0.0)
            turned = np.clip(turned, -1.0, 1.0)
            gained = np.where(q < self.drive.capture_speed, 0.0, rate)
            tables = self.axis.polynomials(after)
            if d == 2:
                angular = np.polynomial.chebyshev.chebvander(turned, self.harmonics)
            else:
                angular = np.polynomial.legendre.legvander(turned, self.harmonics)
            weighed = (angular * gained[:, None]).T
            for parity in (0, 1):
                self.matrices[parity::2, i] = weighed[parity::2] @ tables[parity]
            self.rate[i] = rate.sum()
            self.impacts += rate.size
        for parity in (0, 1):
            self.matrices[parity::2] = self.matrices[parity::2] @ self.axis.to_coefficients(parity)
        self.matrices[:, np.arange(n), np.arange(n)] -= self.rate

    def _scaled(self, law: CollisionLaw) -> FloatArray:
        """The matrices where all speeds have the same bounces: what changes, without rounding."""
        axis, v = self.axis, self.axis.speeds
        kept, gone, lost = bounces(law, axis.size, self.harmonics)
        changed = np.stack([change @ kept.T for change in axis.changes(lost)], axis=-1)
        out = v[:, None] * (changed.swapaxes(0, 1) @ axis.to_coefficients(0))
        place = np.arange(v.size)
        out[:, place, place] -= np.outer(gone.sum(axis=1), v)
        return np.asarray(out)


class Steady:
    """The steady state at one resolution; with sticking, that of the tracers that still move."""

    def __init__(self, drive: Drive, resolution: Resolution) -> None:
        alone, fading = drive.only_falls, not drive.field or drive.capture_speed > 0.0
        top = top_speed(drive, (1e-5 if alone else 0.01) * resolution.rtol)
        scale, power = (0.2 * top, 2.0) if alone else (drive.scale, 1.0)
        smooth = drive.bath_speed > 0.0
        self.axis = axis = SpeedAxis(top, scale, resolution.nodes, power, smooth, fading)
        self.generator = one = Generator(drive, axis, resolution)
        v, self.drive, self.resolution = axis.speeds, drive, resolution
        self.finer = one.finer
        nothing = np.zeros((resolution.harmonics + 1, v.size))
        self.decay = 0.0
        if drive.capture_speed:
            solver = one.chain.elimination()
            start = nothing.copy()
            start[0] = v * np.exp(-v / v[v.size // 2])
            self.sums, time = _slowest(solver, start, lambda f: f)
            self.decay = 1.0 / time
        else:
            border = np.ones(v.size), v * np.exp(-v / v[v.size // 2])
            solver = one.chain.elimination(border=border)
            self.sums = solver.solve(nothing, 1.0)
        self.solver = solver

    def is_resolved(self, p: float, m: int) -> bool:
        """Whether v^p Y_m is a function as the axis has them, so that its average is a sum.

        In a bath these are polynomials in the components of the velocity; other powers bend at
        rest.
        """
        if p < 0.0:
            return False
        return not self.axis.smooth or (p >= m and (p - m) % 2.0 == 0.0)

    def average(self, p: float, m: int) -> float:
        """<v^p Y_m>; p may be any number above -d."""
        sums = self.sums[m]
        v = self.axis.speeds
        d = self.drive.dimension
        if self.is_resolved(p, m):
            return float(v**p @ sums)
        if p >= 0.0:
            width = math.sqrt(self.average(2.0, 0) / d)
            return self.axis.power_average(sums, p, m % 2, d, width)
        x, w = gauss_legendre(max(200, 4 * v.size))
        top = self.axis.highest
        power = 12
        speed = top * x**power
        weight = w * power * x ** (power - 1.0) * top
        f = self.axis.density(self.sums[: m + 1], speed, d)[m]
        return float((weight * speed ** (p + d - 1.0)) @ f)

    def moment_difference(self, coarse: Steady, p: float, m: int) -> float:
        """The error of <v^p Y_m>, over <v^p>, as its difference from a coarser solution's says.

        Drag gathers tracers at rest against the collisions there, at the rate nu(0): the density
        is as v^(nu(0)/drag - d), and the error falls as the number n of speeds to the power
        -(p + nu(0)/drag). So of the difference 1/((n/n_coarse)^(p + nu(0)/drag) - 1) is left.
        """
        scale = abs(self.average(p, 0))
        difference = abs(self.average(p, m) - coarse.average(p, m)) / scale
        if self.drive.drag:
            collisions_at_rest = float(collision_rate(self.drive, np.zeros(1))[0])
            order = p + collisions_at_rest / self.drive.drag
            growth = (self.axis.size / coarse.axis.size) ** order
            difference *= max(1.0, 1.0 / (growth - 1.0))
        return max(difference, _FLOOR) if math.isfinite(difference) else math.inf

    @cached_property
    def figures(self) -> FloatArray:
        """The figures of `steady.DrivenState`, (8,)."""
        one, v, d = self.generator, self.axis.speeds, self.drive.dimension
        drift, second, fourth = (np.float64(self.average(p, int(p == 1))) for p in (1, 2, 4))
        cosine = self.average(2, 2) if one.harmonics > 1 else 0.0
        rate = float(one.rate @ self.sums[0])
        spread = [math.nan] * 3
        if not self.drive.capture_speed:
            moved = v * along(self.sums, 0, d) - drift * self.sums
            turned = one.chain.elimination(1).solve((v * across(self.sums, 0, d))[1:])
            spread = [float(v @ self.solver.solve(moved)[1]), float(v @ turned[0])]
            if self.drive.only_falls:  # speeds are in proportion to sqrt(g)
                spread += [0.5 * drift / self.drive.field]
            else:
                spread += [float(v @ self.solver.solve(one.chain.pulled(self.sums))[1])]
        excess = d * fourth / ((d + 2.0) * second**2) - 1.0
        square = (second + (d - 1.0) * cosine) / d
        return np.array([np.sqrt(second), excess, drift, square, rate, *spread])

    @cached_property
    def depth(self) -> float:
        """Z, with which the share of tracers that get further down a field falls, exp(-x/Z)."""
        v, d = self.axis.speeds, self.drive.dimension
        return _slowest(self.solver, self.sums, lambda f: v * along(f, 0, d))[1]

    @property
    def _slowly(self) -> float:
        return SLOWLY if self.drive.heating or self.drive.sticks_sharply else 1.0

    def apart(self, coarse: Steady) -> dict[str, float]:
        """The largest difference of the figures from a coarser solution's, relative to each.

        1 + a2 for a2; the drift relative to the thermal speed, unless a field alone drives.
        """
        scale = np.abs(self.figures)
        scale[1] = 1.0
        if not self.drive.only_falls:
            scale[2] = self.figures[0]
        apart = np.abs(self.figures - coarse.figures) / scale
        if self.drive.capture_speed:
            apart = np.append(apart[:5], abs(coarse.decay / self.decay - 1.0))
            if self.drive.field:
                apart = np.append(apart, abs(coarse.depth / self.depth - 1.0))
        worst = float(np.max(apart)) * self._slowly
        return {"averages": max(worst, _FLOOR) if math.isfinite(worst) else math.inf}

    def densities_apart(self, coarse: Steady) -> dict[str, float]:
        """The largest difference of the mean density over directions, over its maximum."""
        d, v = self.drive.dimension, TRIED * math.sqrt(self.average(2.0, 0))
        f, other = (one.axis.density(one.sums[:1], v, d) for one in (self, coarse))
        least = np.abs(f).max() / self._slowly
        return {"averages": float(np.abs(f - other).max() / least)}


def _slowest(
    elimination: BlockElimination, f: FloatArray, weighed: Callable[[FloatArray], FloatArray],
    turns: int = 400,
) -> tuple[FloatArray, float]:  # fmt: skip
    """f with -L^T f = weighed(f)/T and the longest T: its sum is 1, and T; NaN if not found."""
    size = 0.0
    for _ in range(turns):
        f = elimination.solve(weighed(f))
        before, size = size, float(f[0].sum())
        f = f / size
        if abs(size - before) <= 0.1 * _FLOOR * abs(size):
            return f, size
    return f, math.nan


def solved(drive: Drive, rtol: float, apart: Any = Steady.apart) -> tuple[Steady, float]:
    """The first that differs from a coarser one by less than rtol, or the best; and its error."""
    first = Resolution.first(drive, rtol, math.asinh(top_speed(drive, rtol) / drive.scale))
    solve, earlier = partial(Steady, drive), 1.0 if drive.sticks_sharply else 0.01
    rules = RefinementRules(min_ratio_to_previous=earlier)
    fine, errors = refine_until_converged(solve, first, apart, {"averages": rtol}, rules)
    return fine, errors["averages"]
