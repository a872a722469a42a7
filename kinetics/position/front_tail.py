r"""How F(k, t) of a start of sharp speeds ends: the front of those that collided three times.

Each collision that deflects a tracer by a small angle makes the density one power of T - R smoother
at the front R = T (T = v t/l, R in units of l). Without the tracers that have collided twice at
most it begins as (T - R)^2, with factors of ln(T - R), and F ends as cos(K T) K^(-7/2) in the plane
and K^-4 in space; other fronts are weaker. The end of F is fitted by

    (1 - x^2)^2 ln^p(1 - x^2),   x = R/T,   p = 0, 1, 2,

for each speed. These are known in R, so that the transform needs no large K.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import panels_between
from kinetics.position.directions import element, mean_phase, radial_measure, radial_waves
from kinetics.position.once_collided import Scatterer, radial_edges
from kinetics.position.wave_panel import WavePanel
from kinetics.values import Value

_POINTS = 12
_POWER, _LOGARITHMS = 2, 3
_FITTED = 0.3  # share of K, from above, to which they are fitted
_SHORTER = 0.75  # share of the panels from which the error is seen


@dataclass(frozen=True)
class FrontTail(Value):
    """The sum of such functions, of some speeds.

    Attributes
    ----------
    coefficients : shape (3 n_speeds,)
    flights : T of each speed, shape (n_speeds,)
    dimension : 2 or 3
    """

    coefficients: FloatArray
    flights: FloatArray
    dimension: int = 2

    def at(self, k: FloatArray) -> FloatArray:
        """Its part of F at K = k, shape (n_k,)."""
        return np.asarray(_columns(k, self.flights, self.dimension) @ self.coefficients)

    def transform(self, rho: FloatArray, kind: int) -> FloatArray:
        """Integral over all K at r = rho l, of a kind of `directions.radial_waves`, (n_r,)."""
        parts = [_transforms(rho, float(T), self.dimension, kind) for T in self.flights]
        return np.asarray(self.coefficients @ np.concatenate(parts))


def fit_fronts(
    panels: list[WavePanel], time: int, flights: FloatArray, scatterer: Scatterer
) -> tuple[FrontTail | None, float]:
    """The tail of F at one of the times, beyond the panels, and what it leaves unknown of F.

    The latter is the largest difference of g(r, t) l, over the largest K, from what follows without
    the upper quarter of the panels, at radii no closer to a front than 1/K. It is infinite where
    there are too few panels.
    """
    high, d = panels[-1].high, scatterer.dimension
    cut = min((panel.low for panel in panels), key=lambda low: abs(low - _SHORTER * high))
    if cut == 0.0:
        return None, math.inf
    full, trial = (_fitted(panels, time, end, (flights, d)) for end in (high, cut))
    largest = 0.0
    for T in flights:
        rho = T * _places(high * float(T), scatterer)
        apart = full.transform(rho, 0) - trial.transform(rho, 0)
        for panel in panels:
            f = panel.of(time)
            assert f is not None  # the time is in all of them
            points = f.size + 8 * math.ceil(T * (panel.high - panel.low) / 8.0)
            k, weight, values = panel.gauss(f, points)
            seen = trial.at(k) if panel.low < cut else values
            missed = weight * radial_measure(k, 0, d) * (seen - full.at(k))
            apart += radial_waves(np.outer(rho, k), 0, d) @ missed
        largest = max(largest, float(np.abs(element(rho, d) * apart).max(initial=0.0)))
    return full, largest / high


def _fitted(
    panels: list[WavePanel], time: int, end: float, of: tuple[FloatArray, int]
) -> FrontTail:
    """Through F up to K = end, with errors relative to its power of K.

    of : flights and the dimension
    """
    flights, dimension = of
    used = [panel for panel in panels if panel.low < end]
    k = np.concatenate([panel.nodes for panel in used])
    f = np.concatenate([panel.of(time) for panel in used])
    k, f = k[k > _FITTED * end], f[k > _FITTED * end]
    weight = k ** (0.5 * (dimension + 5))
    columns = _columns(k, flights, dimension) * weight[:, None]
    size = np.linalg.norm(columns, axis=0)
    found = np.linalg.lstsq(columns / size, f * weight, rcond=1e-9)[0]
    return FrontTail(np.asarray(found / size), flights, dimension)


def _places(turns: float, scatterer: Scatterer) -> FloatArray:
    """Radii over T: between the fronts, and near them, but no closer than 1/turns."""
    near = 2.0 ** np.arange(4) / turns
    fronts = scatterer.singular_radii(1.0)
    x = np.concatenate(
        [np.linspace(0.02, 0.98, 49), *(a + s * near for a in fronts for s in (-1, 1))]
    )
    far = np.min([np.abs(x - a) for a in fronts if a > 0.0], axis=0) > 0.99 / turns
    return x[far & (x > 0.0) & (x < 1.0)]


def _columns(k: FloatArray, flights: FloatArray, dimension: int) -> FloatArray:
    """The functions at K = k, shape (n_k, n_functions)."""
    columns = []
    for T in flights:
        turns = 2.0 ** math.ceil(math.log2(max(32.0, float(k.max()) * T)))
        rho, parts = _table(float(T), turns, dimension)
        columns.append(mean_phase(np.outer(k, rho), dimension) @ parts.T)
    return np.hstack(columns)


@lru_cache(maxsize=16)
def _table(T: float, turns: float, dimension: int) -> tuple[FloatArray, FloatArray]:
    """Radii (n,) on [0, T], and weights R^(d-1) times the functions there, (n_functions, n)."""
    rho, weight = panels_between(radial_edges((0.0, T), T, turns), _POINTS)
    return rho, weight * element(rho, dimension) * _functions(rho / T)


def _functions(x: FloatArray) -> FloatArray:
    """The functions of x = R/T, shape (n_functions, n)."""
    inside = x < 1.0
    d = np.where(inside, (1.0 - x) * (1.0 + x), 1.0)
    return np.array([np.where(inside, d**_POWER * np.log(d) ** p, 0.0) for p in range(_LOGARITHMS)])


def _transforms(rho: FloatArray, T: float, d: int, kind: int) -> FloatArray:
    """Of each function of one speed: (n_functions, n_rho); see :meth:`FrontTail.transform`."""
    if kind == 0:
        return _functions(rho / T)
    if kind == 2:
        step = 1e-5 * T
        ends = [_functions(np.abs(rho + h) / T) for h in (-step, step)]
        return np.asarray((ends[0] - ends[1]) / (2.0 * step))
    near = np.clip(rho, 0.0, T)
    edges = np.union1d(radial_edges((0.0, T), T), near)
    x, w = panels_between(edges, _POINTS)
    parts = (w * element(x, d) * _functions(x / T)).reshape(_LOGARITHMS, -1, _POINTS)
    sums = np.cumsum(parts.sum(axis=2), axis=1)
    sums = np.concatenate([np.zeros((_LOGARITHMS, 1)), sums], axis=1)
    return np.asarray(sums[:, np.searchsorted(edges, near)] / np.maximum(element(rho, d), 1e-300))
