r"""The steady state of a tracer that only white noise drives, in closed form.

Its moments M(z) = <v^z> obey D_v z (z + d - 2) M(z - 2) = lambda(z) M(z + 1): in units of
(D_v l)^(1/3) they go in steps of three,

    M(z) = 9^(z/3) Gamma((z+2)/3) Gamma((z+d)/3)/[Gamma(2/3) Gamma(d/3)]
           product over k >= 0 of lambda(z+2+3k)/lambda(2+3k),        Re z > -d,

and the density is the inverse Mellin transform, along lines through saddle points: its error is
relative to itself. It shares the collision law with the discretised solver, and nothing else.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import loggamma

from kinetics.collision import CollisionLaw
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import gauss_legendre
from kinetics.numerics.recurrence import MOST_ORDERS, log_growth, taylor_of_log

_FACTORS, _PATH = 12, 64  # of the product as they are; points of integrals, and of lines at once
_END = 2.0 + 3.0 * _FACTORS  # lambda's argument where that begins
_NEGLIGIBLE = 39.0  # e^-39 = 1e-17
_APART = 2.0  # of lines, in deviations; at the ends each serves somewhat more than half of it
_LOWEST = 0.4  # the lowest line above -d, where the density is that at rest
_AT_REST = 1e-9  # a speed at which the density is what it is at rest


def log_moment(
    law: CollisionLaw, z: NDArray[Any], path: NDArray[Any] | None = None
) -> NDArray[Any]:
    """ln M(z), shape (n,), with D_v = l = 1; Re z > -d.

    path : the integral of ln lambda from _END to _END + z, (n,)
    """
    u, start = np.asarray(z, dtype=complex) / 3.0, 2.0 + 3.0 * np.arange(_FACTORS)
    if path is None:
        node, weight = gauss_legendre(_PATH)
        path = 3.0 * u * (_log_rate(law, _END + 3.0 * u[:, None] * node) @ weight)
    first = _log_rate(law, 3.0 * u[:, None] + start).sum(axis=1) - _log_rate(law, start).sum()
    rest = log_growth(path / 3.0, _taylor(law, np.array([_END])), _taylor(law, _END + 3.0 * u))
    gammas = loggamma(u + 2.0 / 3.0) + loggamma(u + law.dimension / 3.0)
    begin = math.lgamma(2.0 / 3.0) + math.lgamma(law.dimension / 3.0)
    return np.asarray(u * math.log(9.0) + gammas - begin + first - rest)


def _log_rate(law: CollisionLaw, p: NDArray[Any]) -> NDArray[Any]:
    """ln lambda(p), of the shape of p."""
    return np.log(law.decay_symbol(p.ravel().astype(complex)).reshape(p.shape))


def _taylor(law: CollisionLaw, p: NDArray[Any]) -> list[NDArray[Any]]:
    """Taylor coefficients of ln lambda(p + 3 u) in u, each of the shape of p."""
    found = taylor_of_log(law.decay_taylor(p.astype(complex), MOST_ORDERS))
    return [each * 3.0**n for n, each in enumerate(found)]


def density(law: CollisionLaw, v: FloatArray, lines: list[Line]) -> FloatArray:
    """The density of the velocity at speeds v (n,), with D_v = l = 1; its integral is 1.

    lines : those made for this law so far, by their exponents; new ones are added
    """
    x, d = np.log(np.maximum(v, _AT_REST)), law.dimension
    lines[:] = lines or [Line(law, 0.0)]
    while x.max(initial=0.0) > lines[-1].centre + 0.6 * _APART * lines[-1].deviation:
        lines.append(Line(law, lines[-1].exponent + _APART / lines[-1].deviation))
    while (end := lines[0]).exponent > _LOWEST - d:
        lines.insert(0, Line(law, max(end.exponent - _APART / end.deviation, _LOWEST - d)))
    edges = [
        (a.centre * b.deviation + b.centre * a.deviation) / (a.deviation + b.deviation)
        for a, b in pairwise(lines)
    ]
    which, out = np.searchsorted(edges, x), np.empty(x.shape)
    for i, line in enumerate(lines):
        out[which == i] = line.density(x[which == i])
    return np.asarray(out * np.exp(-d * x) / law.unit_surface)


class Line:
    """M on the line Re z = exponent: the tilted density e^(exponent x) g(x) of x = ln v."""

    def __init__(self, law: CollisionLaw, exponent: float) -> None:
        h = 0.02
        near = log_moment(law, exponent + h * np.arange(-1.0, 2.0)).real
        self.exponent, self.centre = exponent, float(near[2] - near[0]) / (2.0 * h)
        self.deviation = math.sqrt(float(near[2] - 2.0 * near[1] + near[0])) / h
        # low down the tilted density falls as e^((exponent + d) x), high up faster than a Gaussian
        below = _NEGLIGIBLE / (exponent + law.dimension)
        self._step = step = 2.0 * math.pi / (below + 12.0 * self.deviation)
        self._log, found = float(near[1]), [np.ones(1, dtype=complex)]
        node, weight = gauss_legendre(_PATH)
        path = exponent * complex(_log_rate(law, _END + exponent * node) @ weight)
        node, weight = gauss_legendre(3)
        count = 0
        while np.abs(found[-1][-4:]).max() > math.exp(-_NEGLIGIBLE):
            z = exponent + 1j * step * np.arange(count, count + _PATH)
            parts = 1j * step * (_log_rate(law, _END + z[:, None] + 1j * step * node) @ weight)
            paths = path + np.cumsum(parts)
            found.append(np.exp(log_moment(law, z + 1j * step, paths) - self._log))
            path, count = complex(paths[-1]), count + _PATH
        self._samples = np.concatenate(found)

    def density(self, x: FloatArray) -> FloatArray:
        """g at x, shape (n,)."""
        wave = self._step * np.arange(self._samples.size)
        total = 2.0 * (np.exp(-1j * np.outer(x, wave)) @ self._samples).real - 1.0
        scale = np.exp(self._log - self.exponent * x) * self._step / (2.0 * math.pi)
        return np.asarray(scale * total)
