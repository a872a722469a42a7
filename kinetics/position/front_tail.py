r"""How F(k, t) of a start of sharp speeds ends: the front of those that collided three times.

Each collision that deflects a tracer by a small angle makes the density one power of T - R smoother
at the front R = T (T = v t/l, R in units of l). Without the tracers that have collided twice at
most it begins as (T - R)^2, with factors of ln(T - R), and F ends as cos(K T) K^(-7/2) in the plane
and K^-4 in space; other fronts are weaker. The end of F is fitted by

    (1 - x^2)^2 ln^p(1 - x^2),   x = R/T,   p = 0, 1, 2,

for each speed. Where collisions lose no energy there is no other front, and the third power of
1 - x^2 can be told apart too. Where e is small, tracers that a collision has nearly stopped leave
powers of 1/K besides, as in `tail`. All these are known in R, so that the transform needs no large
K.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import panels_between
from kinetics.position.directions import element, mean_phase, radial_measure, radial_waves
from kinetics.position.once_collided import Scatterer, radial_edges
from kinetics.position.tail import origin_terms, origin_transforms
from kinetics.position.wave_panel import WavePanel, nodes_between
from kinetics.values import Value

_POINTS = 12
_LOWEST, _LOGARITHMS = 2, 3  # the first power, and how many logarithms there are with each
_AT_ORIGIN, _SMALL = 8, 0.2  # terms at R = 0, and e up to which there are any
_ORIGIN = 3.0  # K T from which these fall as powers
_FITTED = 0.3  # share of K, from above, to which they are fitted
_SHORTER, _UPPER = 0.75, 0.5  # shares of K, from below and above, from which the error is seen


@dataclass(frozen=True)
class FrontTail(Value):
    """The sum of such functions, of some speeds.

    Attributes
    ----------
    coefficients : of the functions of one speed after another, shape (n_functions,)
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
        columns = _columns(k, self.flights, self.restitution, self.dimension)
        return np.asarray(columns @ self.coefficients)

    def transform(self, rho: FloatArray, kind: int) -> FloatArray:
        """Integral over all K at r = rho l, of a kind of `directions.radial_waves`, (n_r,)."""
        gas = self.restitution, self.dimension
        parts = [_transforms(rho, float(T), gas, kind) for T in self.flights]
        return np.asarray(self.coefficients @ np.concatenate(parts))


def fit_fronts(
    panels: list[WavePanel], time: int, flights: FloatArray, scatterer: Scatterer
) -> tuple[FrontTail | None, float]:
    """The tail of F at one of the times, beyond the panels, and what it leaves unknown of F.

    The latter is the largest difference of g(r, t) l, over the largest K, from what follows without
    the upper quarter of the panels, plus that from a fit to the upper half of them. It is infinite
    where there are too few panels.
    """
    high, d = panels[-1].high, scatterer.dimension
    cut = min((panel.low for panel in panels), key=lambda low: abs(low - _SHORTER * high))
    if cut == 0.0:
        return None, math.inf
    full = _fitted(panels, time, (_FITTED * high, high), (flights, scatterer))
    ends = (cut, high)
    trials = [
        _fitted(panels, time, (low, end), (flights, scatterer))
        for low, end in zip((_FITTED * cut, _UPPER * high), ends, strict=True)
    ]
    rho = np.concatenate([T * _places(high * float(T), scatterer) for T in flights])
    apart = np.array([full.transform(rho, 0) - trial.transform(rho, 0) for trial in trials])
    for panel in panels:
        f = panel.of(time)
        assert f is not None  # the time is in all of them
        turns = float(flights.max()) * (panel.high - panel.low)
        k, weight, values = panel.gauss(f, f.size + 8 * math.ceil(turns / 8.0))
        waves = radial_waves(np.outer(rho, k), 0, d) * (weight * radial_measure(k, 0, d))
        for one, trial, end in zip(apart, trials, ends, strict=True):
            one += waves @ ((trial.at(k) if panel.low < end else values) - full.at(k))
    return full, float(np.abs(element(rho, d) * apart).max(axis=1, initial=0.0).sum()) / high


def _fitted(
    panels: list[WavePanel],
    time: int,
    between: tuple[float, float],
    of: tuple[FloatArray, Scatterer],
) -> FrontTail:
    """Through F between two K, with errors relative to its power of K.

    of : flights, and what the tracers have collided with
    """
    (flights, scatterer), (low, end) = of, between
    e, dimension = scatterer.restitution, scatterer.dimension
    k, f = nodes_between(panels, time, low, end)
    weight = k ** (0.5 * (dimension + 5))
    columns = _columns(k, flights, e, dimension) * weight[:, None]
    size = np.linalg.norm(columns, axis=0)
    found = np.linalg.lstsq(columns / size, f * weight, rcond=1e-9)[0]
    return FrontTail(np.asarray(found / size), e, flights, dimension)


def _places(turns: float, scatterer: Scatterer) -> FloatArray:
    """Radii over T: everywhere, and near the fronts, to within 1/(8 turns)."""
    near = 2.0 ** np.arange(-3, 4) / turns
    fronts = scatterer.singular_radii(1.0)
    x = np.concatenate(
        [np.linspace(0.02, 0.98, 49), *(a + s * near for a in fronts for s in (-1, 1))]
    )
    return x[(x > 0.01) & (x < 1.0)]


def _columns(k: FloatArray, flights: FloatArray, e: float, dimension: int) -> FloatArray:
    """The functions at K = k, shape (n_k, n_functions)."""
    columns = []
    for T in flights:
        turns = 2.0 ** math.ceil(math.log2(max(32.0, float(k.max()) * T)))
        rho, parts = _table(float(T), turns, dimension, _powers(e))
        columns.append(mean_phase(np.outer(k, rho), dimension) @ parts.T)
        if e < _SMALL:
            columns.append(origin_terms(k * T / _ORIGIN, _AT_ORIGIN, dimension, _first(e)))
    return np.hstack(columns)


def _powers(e: float) -> int:
    """How many powers of 1 - x^2: the coefficients of more are lost among other fronts."""
    return 2 if e == 1.0 else 1


def _first(e: float) -> int:
    """Which powers of 1/K tracers leave that a collision has stopped, or nearly: see `tail`."""
    return 0 if e == 0.0 else 1


@lru_cache(maxsize=16)
def _table(T: float, turns: float, dimension: int, powers: int) -> tuple[FloatArray, FloatArray]:
    """Radii (n,) on [0, T], and weights R^(d-1) times the functions there, (n_functions, n)."""
    rho, weight = panels_between(radial_edges((0.0, T), T, turns), _POINTS)
    return rho, weight * element(rho, dimension) * _functions(rho / T, powers)


def _functions(x: FloatArray, powers: int) -> FloatArray:
    """The functions of x = R/T, shape (n_functions, n)."""
    inside = x < 1.0
    d = np.where(inside, (1.0 - x) * (1.0 + x), 1.0)
    exponents = itertools.product(range(_LOWEST, _LOWEST + powers), range(_LOGARITHMS))
    return np.array([np.where(inside, d**nu * np.log(d) ** p, 0.0) for nu, p in exponents])


def _transforms(rho: FloatArray, T: float, gas: tuple[float, int], kind: int) -> FloatArray:
    """Of each function of one speed: (n_functions, n_rho); see :meth:`FrontTail.transform`.

    gas : e and the dimension
    """
    e, d = gas
    if kind == 0:
        parts = _functions(rho / T, _powers(e))
    elif kind == 1:
        near = np.clip(rho, 0.0, T)
        edges = np.union1d(radial_edges((0.0, T), T), near)
        x, w = panels_between(edges, _POINTS)
        parts = w * element(x, d) * _functions(x / T, _powers(e))
        sums = np.cumsum(parts.reshape(-1, edges.size - 1, _POINTS).sum(axis=2), axis=1)
        sums = np.concatenate([np.zeros((sums.shape[0], 1)), sums], axis=1)
        parts = sums[:, np.searchsorted(edges, near)] / np.maximum(element(rho, d), 1e-300)
    else:
        step = 1e-5 * T
        ends = [_functions(np.abs(rho + h) / T, _powers(e)) for h in (-step, step)]
        parts = (ends[0] - ends[1]) / (2.0 * step)
    if e < _SMALL:
        scale = _ORIGIN / T
        at_origin = origin_transforms(scale * rho, _AT_ORIGIN, kind, d, _first(e))
        parts = np.concatenate([parts, at_origin * scale ** (d, d - 1, d + 1)[kind]])
    return parts
