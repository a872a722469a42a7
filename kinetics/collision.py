"""One collision, as averages over the impact parameter: the only place that knows how e enters.

A tracer meets a disk with impact parameter ``y d``, y uniform on [-1, 1]. In units of its speed
before the bounce (paper, label ``vchange``) it leaves with

    speed                 s(y)     = sqrt(e^2 + (1 - e^2) y^2)
    parallel component    s cos(chi) = -e + (1 + e) y^2
    deflection            chi(y), of the sign of y

Everything that the kinetic equation needs is an average of s^p cos(m chi) over y.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.errors import InputError
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import equal_panels, gauss_legendre
from kinetics.validation import check_restitution, number_array, refuse, whole_number

# Gauss-Legendre points on each panel in the variable u below. They are exact to rounding for
# s^z cos(m chi) while (|z| + m) times the length of a panel is below _RESOLVED: measured again by
# tests/kinetics/measurements/collision.py.
_POINTS = 20
_RESOLVED = 30.0
_DEEPEST = 40.0  # at e = 0, ln(1/s) is unbounded; what lies beyond this weighs e^-40 = 4e-18
_STEEP = 5.0  # U from which exponentials of U are taken apart: either form holds from 1 to 300
_HIGHEST_HARMONIC = 1_000_000
_LARGEST_TURN = 1e7  # that many turns of s^z take 7e6 points, about a gigabyte of exponentials


@dataclass(frozen=True)
class ImpactQuadrature:
    """Averages over the impact parameter as weighted sums: E[f] = sum_k weight_k f_k.

    Attributes, each of shape ``(n_nodes,)``
    ----------------------------------------
    weight : positive, sums to 1
    log_loss : xi = -ln s >= 0, accurate relative to itself
    ratio : s = exp(-xi)
    parallel : s cos(chi)
    """

    weight: FloatArray
    log_loss: FloatArray
    ratio: FloatArray
    parallel: FloatArray

    @cached_property
    def cosine(self) -> FloatArray:
        """cos(chi), shape (n_nodes,)."""
        return np.clip(self.parallel / self.ratio, -1.0, 1.0)

    @cached_property
    def deflection(self) -> FloatArray:
        """chi, from 0 to pi, shape (n_nodes,)."""
        return np.arccos(self.cosine)

    def harmonic(self, m: int) -> FloatArray:
        """cos(m chi), shape (n_nodes,): what angular harmonic m keeps of itself in a bounce."""
        return np.cos(m * self.deflection)

    def harmonic_loss(self, m: int) -> FloatArray:
        """1 - cos(m chi) = 2 sin^2(m chi/2), shape (n_nodes,), accurate where it is small."""
        return np.asarray(2.0 * np.sin(0.5 * m * self.deflection) ** 2)


def impact_quadrature(restitution: float, longest: float = 1.0) -> ImpactQuadrature:
    """Quadrature over the impact parameter, in a variable in which no e is special.

    ``longest`` is the length of a panel in u below: (|z| + m) longest must stay below 30 for
    averages of s^z cos(m chi).

    s(y) has branch points at y = +-i e/sqrt(1-e^2), near the real axis for small e. With
    y = (e/b) sinh u, b = sqrt(1-e^2), they leave: s = e cosh u, 0 <= u <= U = asinh(b/e).
    ln s is taken from 1 - s^2 = b^2 (1-y^2) = e^2 sinh(U-u) sinh(U+u) where s is near 1, so
    that -ln s keeps its digits as e -> 1.
    """
    e = restitution
    if e == 1.0:
        # nothing is lost, but the deflection remains: cos(chi) = 2 y^2 - 1
        y, w = equal_panels(1.0, _POINTS, longest)
        one = np.ones_like(y)
        return ImpactQuadrature(w, np.zeros_like(y), one, 2.0 * y * y - 1.0)
    if e == 0.0:
        xi, w = equal_panels(_DEEPEST, _POINTS, longest)
        s = np.exp(-xi)
        return ImpactQuadrature(w * s, xi, s, s * s)
    top = _highest(e)
    u, w = equal_panels(top, _POINTS, longest)
    rest = u[::-1]  # U - u without cancellation: the nodes are symmetric
    if top > _STEEP:
        # ratios of cosh and sinh of u to those of U, which would overflow for the smallest e
        decay, small, least = np.exp(-rest), np.exp(-2.0 * u), math.exp(-2.0 * top)
        xi = rest - np.log1p(small) + math.log1p(least)
        y = decay * (1.0 - small) / (1.0 - least)
        weight = w * decay * (1.0 + small) / (1.0 - least)
        return ImpactQuadrature(weight, xi, np.exp(-xi), -e + (1.0 + e) * y * y)
    b = math.sqrt((1.0 - e) * (1.0 + e))
    lost = e * e * np.sinh(rest) * np.sinh(top + u)  # 1 - s^2
    near_one = lost < 0.5
    xi = np.where(
        near_one, -0.5 * np.log1p(-np.where(near_one, lost, 0.0)), -np.log(e * np.cosh(u))
    )
    y2 = ((e / b) * np.sinh(u)) ** 2
    # near y = 1 this is 1 - (1+e)(1-y^2), which loses nothing
    parallel = np.where(near_one, 1.0 - lost / (1.0 - e), -e + (1.0 + e) * y2)
    return ImpactQuadrature(w * (e / b) * np.cosh(u), xi, np.exp(-xi), parallel)


def _highest(e: float) -> float:
    """U = acosh(1/e) = asinh(b/e), for any e > 0."""
    if e < 1e-8:  # the next term, e^2/4, is below rounding
        return math.log(2.0) - math.log(e)
    return math.asinh(math.sqrt((1.0 - e) * (1.0 + e)) / e)


def impact_cells(
    restitution: float, spacing: float, points: int = 6
) -> tuple[ImpactQuadrature, NDArray[np.int64]]:
    """The average over the impact parameter, cell by cell of width ``spacing`` in -ln s.

    Returns the quadrature, with ``points`` Gauss-Legendre points in y for each cell (s is smooth
    in y, its density in -ln s is not), and the cell of each point, both of shape (n_nodes,). For
    0 <= e < 1. At e = 0 cells end at s = e^-40; the last one holds all bounces below.
    """
    e = restitution
    b2 = (1.0 - e) * (1.0 + e)
    loss = -math.log(e) if e > 0.0 else math.inf  # of a head-on bounce
    count = max(1, math.ceil(min(_DEEPEST, loss) / spacing))
    edge = np.arange(count + 1) * spacing
    # y^2 = (s^2 - e^2)/(1 - e^2), without cancellation
    y2_edge = np.exp(-2.0 * edge) * -np.expm1(2.0 * np.minimum(0.0, edge - loss)) / b2
    y_edge = np.sqrt(y2_edge)
    y_edge[-1] = 0.0
    node, weight = gauss_legendre(points)
    width = (y_edge[:-1] - y_edge[1:])[:, None]
    y = (y_edge[1:, None] + width * node).ravel()
    w = (width * weight).ravel()
    lost = b2 * (1.0 - y) * (1.0 + y)
    xi = np.where(lost < 0.5, -0.5 * np.log1p(-np.minimum(lost, 0.5)), 0.0)
    deep = lost >= 0.5
    xi[deep] = -0.5 * np.log(e * e + b2 * y[deep] ** 2)
    parallel = -e + (1.0 + e) * y * y
    cell = np.repeat(np.arange(count), points)
    return ImpactQuadrature(w, xi, np.exp(-xi), parallel), cell


@dataclass(frozen=True)
class CollisionLaw:
    """The inelastic bounce off a fixed disk, averaged over a uniform impact parameter.

    Parameters
    ----------
    restitution : e in [0, 1], the same for every bounce

    Raises
    ------
    InputError (a ValueError) : restitution outside [0, 1] or not a number

    All results are dimensionless. Relative accuracy 1e-13 or better for every e, those near 0
    and 1 included: for real p each is a sum of terms of one sign. For complex p the error of
    E[s^p] is relative to E[s^(Re p)].

    >>> law = CollisionLaw(restitution=0.7)
    >>> bool(abs(law.decay_rate(2) - 2 / 3 * (1 - 0.7**2)) < 1e-15)
    True
    """

    restitution: float
    _quadratures: dict[int, ImpactQuadrature] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    def __post_init__(self) -> None:
        object.__setattr__(self, "restitution", check_restitution(self.restitution))

    @property
    def lowest_power(self) -> float:
        """E[s^p] exists for p above it: -1 at e = 0, where a head-on bounce stops the tracer."""
        return -1.0 if self.restitution == 0.0 else -math.inf

    @cached_property
    def quadrature(self) -> ImpactQuadrature:
        """The average over the impact parameter as a weighted sum, for slow functions of ln s."""
        return self.quadrature_for(0.0)

    def quadrature_for(self, rate: float, m: int = 0) -> ImpactQuadrature:
        """The same for functions that vary as fast as s^z cos(m chi) with |z| up to ``rate``.

        Raises InputError where that takes more than some million points.
        """
        # by how much |z| ln s and m chi change over a panel: by less than u, and by less than pi
        top = 40.0 if self.restitution == 0.0 else _highest(self.restitution)
        turn = rate * min(1.0, top * math.tanh(top)) + 3.0 * m
        if not turn <= _LARGEST_TURN:
            raise InputError(f"p: got a size of {rate:.3g}; E[s^p] needs too many points there")
        level = max(0, math.ceil(math.log2(max(turn, 1.0) / _RESOLVED)))
        if level not in self._quadratures:
            longest = min(1.0, top) * 2.0**-level if top > 0.0 else 2.0**-level
            self._quadratures[level] = impact_quadrature(self.restitution, longest)
        return self._quadratures[level]

    def mean_speed_ratio_power(self, p: ArrayLike) -> Any:
        """E[s^p]: a float for a real p, an array of the shape of p for an array; p may be complex.

        Closed form: e^p 2F1(-p/2, 1/2; 3/2; -(1-e^2)/e^2), and 1/(1+p) at e = 0, where it
        exists for Re p > -1 only.
        """
        p_ = self._exponents(p)
        if self.restitution == 0.0:
            return (1.0 / (1.0 + p_))[()]
        q = self.quadrature_for(_size(p_))
        with np.errstate(over="ignore", invalid="ignore"):
            mean = np.exp(-np.multiply.outer(p_, q.log_loss)) @ q.weight
        return self._finite(p, mean)[()]

    def decay_rate(self, p: ArrayLike) -> Any:
        """lambda(p) = 1 - E[s^p], so that d<v^p>/dt = -lambda(p) <v^(p+1)>/l (isotropic part).

        Same shapes as :meth:`mean_speed_ratio_power`; accurate relative to itself also where
        it vanishes (p -> 0, e -> 1). Negative for p < 0.
        """
        p_ = self._exponents(p)
        if self.restitution == 0.0:
            return (p_ / (1.0 + p_))[()]
        q = self.quadrature_for(_size(p_))
        with np.errstate(over="ignore", invalid="ignore"):
            rate = -np.expm1(-np.multiply.outer(p_, q.log_loss)) @ q.weight
        return self._finite(p, rate)[()]

    @cached_property
    def mean_log_loss(self) -> float:
        """kappa = E[-ln s] = 1 - e arccos(e)/sqrt(1-e^2); 0 at e = 1, 1 at e = 0."""
        if self.restitution == 0.0:
            return 1.0
        return float(self.quadrature.weight @ self.quadrature.log_loss)

    @cached_property
    def mean_cosine(self) -> float:
        """<cos chi>: 1/2 at e = 0, -1/3 at e = 1 (hard disks scatter backwards on average)."""
        if self.restitution == 0.0:
            return 0.5
        return float(self.quadrature.weight @ self.quadrature.cosine)

    def harmonic_decay_rate(self, p: ArrayLike, m: int) -> Any:
        """1 - E[s^p cos(m chi)]: how fast the moment of v^p exp(i m phi) is lost, in v/l.

        A float for a real p, an array of the shape of p for an array.
        """
        m = whole_number("m", m, -_HIGHEST_HARMONIC, _HIGHEST_HARMONIC)
        if m == 0:
            return self.decay_rate(p)
        p_ = self._exponents(p)
        q = self.quadrature_for(_size(p_), abs(m))
        turned = q.harmonic_loss(m)
        with np.errstate(over="ignore", invalid="ignore"):
            if self.restitution == 0.0:
                # s^p near s = 0, where chi = pi/2, in closed form: the points end at s = e^-40
                head_on = (0.0, 1.0, 2.0, 1.0)[m % 4]  # 1 - cos(m pi/2)
                powers = np.exp(-np.multiply.outer(p_, q.log_loss))
                rate = (p_ + head_on) / (1.0 + p_) + powers @ ((turned - head_on) * q.weight)
            else:
                # 1 - s^p cos = (1 - s^p) + s^p (1 - cos): no cancellation
                lost = -np.expm1(-np.multiply.outer(p_, q.log_loss))
                rate = (lost + (1.0 - lost) * turned) @ q.weight
        return self._finite(p, rate)[()]

    def _exponents(self, p: ArrayLike) -> NDArray[Any]:
        p_ = number_array("p", p, "iufc", "it must be a number or an array of numbers")
        if not np.all(np.isfinite(p_)):
            refuse("p", p, "it must be finite")
        if self.restitution == 0.0 and np.any(p_.real <= -1.0):
            refuse("p", p, "at restitution 0 it must be above -1")
        return p_

    @staticmethod
    def _finite(p: ArrayLike, value: NDArray[Any]) -> NDArray[Any]:
        if not np.all(np.isfinite(value)):
            refuse("p", p, "E[s^p] overflows double precision there")
        return value


def _size(z: NDArray[Any]) -> float:
    return float(np.max(np.abs(z))) if z.size else 0.0
