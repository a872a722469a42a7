r"""How F(k, t) of a start of one sharp speed ends: the fronts of tracers that bounced at once.

Each collision that deflects a tracer by a small angle makes the density one power of T - R smoother
at the front R = T (T = v t/l, R in units of l). Without the tracers that have collided twice at
most it begins as (T - R)^2, with factors of ln(T - R), and F ends as cos(K T) K^(-7/2) in the plane
and K^-4 in space. For et < 1, without the once-collided, it begins as T - R. Tracers that bounced
head-on at once are at R <= e T, and so on (`inner_fronts`): these fronts have fewer powers, but
weigh exp(-e T), not exp(-T). The end of F is fitted by

    (1 - x^2)^nu ln^p(1 - x^2),   x = R/T,

by powers of the distance from either side of the inner fronts, also with logarithms, and by powers
of 1/K, as in `tail`, that slow tracers leave. All these are known in R, so that the transform needs
no large K. What the fit leaves unknown is seen from what it would have left at half the largest K.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import panels_between
from kinetics.position.directions import element, mean_phase, radial_measure, radial_waves
from kinetics.position.once_collided import FARTHEST, Scatterer, radial_edges
from kinetics.position.tail import origin_terms, origin_transforms
from kinetics.position.wave_panel import WavePanel, nodes_between
from kinetics.results import Value

_POINTS = 12
_AT_ORIGIN = 8  # the last power of the terms at R = 0
_ORIGIN = 3.0  # K T from which these fall as powers, but not below K = 1
_FITTED = 0.3  # share of K, from above, to which they are fitted
# Shares of K up to which the error is seen. If it falls as K^-p, what follows with these differs
# by 2^p - 1 and (4/3)^p - 1 of it: it is less than _FALLING times the square of the second over the
# first, if p > 1, and about the second at least is assumed.
_SHORTER, _FALLING = (0.5, 0.75), 9.0
_TOGETHER = 1e-3  # 1 - e below which the front of head-on collisions is at R = T
# Fronts are told apart where K times their distance is above _APART; there are too few tracers at
# those beyond R = FAINT, and at those of more than _MOST_BOUNCES or of a power above _HIGHEST.
_APART, FAINT, _MOST_BOUNCES, _HIGHEST = 8.0, 16.0, 3, 3.5
_MANY = 10.0  # coefficients may be so many times larger than there are tracers
_LEAST = 1e-9  # of the singular values of a fit

Terms = tuple[tuple[float, float, float], ...]


@dataclass(frozen=True)
class FrontTail(Value):
    """The sum of such functions, of one speed.

    Attributes
    ----------
    coefficients : of the functions, shape (n_terms,)
    flight : T of the speed
    dimension : 2 or 3
    terms : a, nu and p of each function, shape (n_terms, 3). a = 1: at R = T, with the power nu and
        p logarithms; 0 < a < 1: at R = a T, with the power nu and |p| - 1 logarithms, for R > a T
        if p > 0, else for R < a T; a = 0: (q^2 + 1)^(-(nu + d)/2), q = K/scale
    """

    coefficients: FloatArray
    flight: float
    dimension: int
    terms: FloatArray

    @property
    def _shape(self) -> tuple[Terms, float, int]:
        """The terms, the scale of those at R = 0, and the dimension."""
        rows = tuple((float(a), float(nu), float(p)) for a, nu, p in self.terms)
        return rows, max(1.0, _ORIGIN / self.flight), self.dimension

    @property
    def reach(self) -> float:
        """R with which its part of F turns."""
        return min(self.flight, FARTHEST)

    def at(self, k: FloatArray) -> FloatArray:
        """Its part of F at K = k, shape (n_k,)."""
        return np.asarray(_columns(k, self.flight, *self._shape) @ self.coefficients)

    def transform(self, rho: FloatArray, kind: int) -> FloatArray:
        """Integral over all K at r = rho l, of a kind of `directions.radial_waves`, (n_r,)."""
        parts = _transforms(rho, self.flight, self._shape, kind)
        return np.asarray(self.coefficients @ parts)


def fit_fronts(
    panels: list[WavePanel], time: int, T: float, scatterer: Scatterer
) -> tuple[FrontTail | None, float]:
    """The tail of F at one of the times, beyond the panels, and what it leaves unknown of F.

    The latter follows from the largest difference of g(r, t) l, over the largest K, from what
    follows without the upper half, and quarter, of the panels, plus that from a fit to this half.
    It is infinite where there are too few panels. Of sums with and without inner fronts and powers
    of 1/K, or no sum at all, the one that leaves least is taken.
    """
    high, d = panels[-1].high, scatterer.dimension
    cuts = [
        min((panel.low for panel in panels), key=lambda low: abs(low - part * high))
        for part in _SHORTER
    ]
    if cuts[0] == 0.0:
        return None, math.inf
    terms = _terms(scatterer, T, high)
    shape = terms, max(1.0, _ORIGIN / T), d
    fits = _Fits(panels, time, [*cuts, high], (T, shape))
    known = _Known(panels, time, _places(high, T, terms), (T, shape))
    none = np.zeros(0)
    found = [(math.inf, none.astype(np.intp), none)]
    if T < FAINT:
        # without any function: what the upper half gives is more than all beyond, if that falls as
        # 1/K. Late, the waves of a sharp end would be seen at all radii.
        found = [(known.change(found[0][1], none, none, cuts[0]) / high, *found[0][1:])]
    outer = sum(a == 1.0 for a, _, _ in terms)
    fronts, count = sum(a > 0.0 for a, _, _ in terms), len(terms)
    for some, first in itertools.product({outer, fronts}, (count, fronts, fronts + 1)):
        used = np.r_[:some, first:count]
        if used.size == 0:
            continue
        full, upper, *shorter = fits(used)
        far, near = (
            known.change(used, full, trial, cut) for trial, cut in zip(shorter, cuts, strict=True)
        )
        left = min(far, max(near, _FALLING * near**2 / max(far, 1e-300)))
        found.append(((left + known.change(used, full, upper)) / high, used, full))
    left, used, full = min(found, key=lambda each: each[0])
    if used.size == 0:
        return None, left
    kept = np.array(terms)[used]
    return FrontTail(full, T, d, kept), left


class _Fits:
    """Sums of functions through F, with errors relative to its power of K."""

    def __init__(
        self,
        panels: list[WavePanel],
        time: int,
        ends: list[float],
        functions: tuple[float, tuple[Terms, float, int]],
    ) -> None:
        """ends : of the shorter ranges of K, and of all."""
        self.k, f = nodes_between(panels, time, _FITTED * ends[0])
        weight = self.k ** (0.5 * (functions[1][2] + 5))
        self.f = f * weight
        self.columns = _columns(self.k, functions[0], *functions[1]) * weight[:, None]
        self.largest = _largest(functions[0], *functions[1])
        shorter = [(self.k > _FITTED * end) & (self.k < end) for end in ends[:-1]]
        self.parts = [self.k > _FITTED * ends[-1], self.k > _SHORTER[0] * ends[-1], *shorter]

    def __call__(self, used: NDArray[np.intp]) -> list[FloatArray]:
        """Coefficients from all of the range, from its upper part, and from the shorter ranges."""
        found = []
        for part in self.parts:
            columns, f = self.columns[np.ix_(part, used)], self.f[part]
            size = np.linalg.norm(columns, axis=0)
            first = np.linalg.lstsq(columns / size, f, rcond=_LEAST)[0] / size
            # once more, with what the first fit misses as the error of F, and coefficients that
            # are not larger than there are tracers
            noise = float(np.sqrt(np.mean((columns @ first - f) ** 2)))
            bound = np.diag(noise / (size * self.largest[used]))
            columns = np.concatenate([columns / size, bound])
            f = np.concatenate([f, np.zeros(used.size)])
            found.append(np.linalg.lstsq(columns, f, rcond=_LEAST)[0] / size)
        return found


def _largest(T: float, terms: Terms, scale: float, dimension: int) -> FloatArray:
    """About the largest coefficients that there are tracers for, (n_terms,).

    The share exp(-a T) of the tracers, a few times T for each bounce, is spread over R < a T.
    """
    out = []
    for a, _, _ in terms:
        if a == 0.0:
            out.append(_MANY)
        else:
            out.append(_MANY * math.exp(-a * T) * max(1.0, T) ** 3 / (a * T) ** dimension)
    return np.array(out)


class _Known:
    """What the panels and the functions beyond them give of the density at some radii."""

    def __init__(
        self,
        panels: list[WavePanel],
        time: int,
        rho: FloatArray,
        functions: tuple[float, tuple[Terms, float, int]],
    ) -> None:
        T, shape = functions
        d = shape[2]
        self.functions = (element(rho, d) * _transforms(rho, T, shape, 0)).T
        self.parts = []
        for panel in panels:
            f = panel.of(time)
            assert f is not None  # the time is in all of them
            turns = min(T, FARTHEST) * (panel.high - panel.low)
            k, weight, values = panel.gauss(f, f.size + 8 * math.ceil(turns / 8.0))
            waves = radial_waves(np.outer(rho, k), 0, d) * (weight * radial_measure(k, 0, d))
            waves *= element(rho, d)[:, None]
            self.parts.append((panel.low, waves @ _columns(k, T, *shape), waves @ values))

    def change(
        self, used: NDArray[np.intp], full: FloatArray, trial: FloatArray, cut: float = math.inf
    ) -> float:
        """The largest of the density, by other coefficients and without the panels above a K."""
        out = self.functions[:, used] @ (full - trial)
        for low, part, values in self.parts:
            if low < cut:
                out -= part[:, used] @ (full - trial)
            else:
                out += values - part[:, used] @ full
        return float(np.abs(out).max())


def _terms(scatterer: Scatterer, T: float, high: float) -> Terms:
    """The functions that F at K = high still tells apart."""
    one = scatterer.restitution > 1.0 - _TOGETHER
    rows: list[tuple[float, float, float]] = []
    taken = [1.0]
    logarithms = 3 if scatterer.restitution == scatterer.tangential_restitution else 2
    if T < FAINT and scatterer.smooth:
        powers = (2.0, 3.0) if one else (2.0,)
        rows += [(1.0, nu, p) for nu, p in itertools.product(powers, (0.0, 1.0, 2.0))]
    elif T < FAINT:
        rows += [(1.0, nu, 0.0) for nu in (1.0, 2.0, 3.0)]
    for a, nu in sorted(inner_fronts(scatterer), key=lambda front: front[1]):
        apart = min(abs(a - b) for b in taken) * T * high
        if a * T < FAINT and a * T * high > _APART and apart > _APART:
            rows += [(a, nu, side * (1.0 + p)) for p in range(logarithms) for side in (-1.0, 1.0)]
            rows += [(a, nu + 1.0, side) for side in (-1.0, 1.0)]
            taken.append(a)
    return (*rows, *((0.0, float(j), 0.0) for j in range(_AT_ORIGIN + 1)))


def inner_fronts(scatterer: Scatterer) -> list[tuple[float, float]]:
    """R over T of the fronts of tracers that bounced at once, and the power of the distance there.

    That after h head-on and g grazing bounces is e^h et^g T. In the plane each bounce at once adds
    3/2 for a head-on one and 2 for a grazing one, as time and impact parameter both must be near
    their ends; in space 2 for both; 1 where all bounces lose as much speed. Bounces at the very
    end, or that deflect little, add 1 each. Those of tracers that are kept apart are left out.
    """
    e, et, d = scatterer.restitution, scatterer.tangential_restitution, scatterer.dimension
    head = 1.0 if e == et else (1.5 if d == 2 else 2.0)
    known = 2 if scatterer.smooth else 1  # bounces of those that are kept apart
    found = []
    for h, g in itertools.product(range(_MOST_BOUNCES + 1), repeat=2):
        if not 1 <= h + g <= _MOST_BOUNCES or (g and (scatterer.smooth or e == et)):
            continue
        nu = h * head + 2.0 * g - 1.0 + max(0, known + 1 - h - g)
        a = e**h * et**g
        if nu <= _HIGHEST and 0.0 < a < 1.0 - _TOGETHER:
            found.append((a, nu))
    return found


def _places(high: float, T: float, terms: Terms) -> FloatArray:
    """Radii: everywhere, and near the fronts, to within 1/(8 high)."""
    near = 2.0 ** np.arange(-3, 4) / high
    fronts = {a * T for a, _, _ in terms} | {0.0, T}
    far = min(T, FARTHEST)
    beside = [R + s * near for R in sorted(fronts) for s in (-1, 0, 1)]
    r = np.concatenate([far * np.linspace(0.02, 0.98, 49), *beside])
    return r[(r > 0.0) & (r < far)]


def _columns(k: FloatArray, T: float, terms: Terms, scale: float, dimension: int) -> FloatArray:
    """The functions at K = k, shape (n_k, n_functions); those at R = 0 last."""
    columns = []
    if terms[0][0] > 0.0:
        turns = float(k.max()) * min(T, FARTHEST)
        turns = 2.0 ** math.ceil(math.log2(max(32.0, turns)))
        rho, parts = _table(T, turns, dimension, terms)
        columns.append(mean_phase(np.outer(k, rho), dimension) @ parts.T)
    count, first = _at_origin(terms)
    if count:
        columns.append(origin_terms(k / scale, count, dimension, first))
    return np.hstack(columns)


def _at_origin(terms: Terms) -> tuple[int, int]:
    """How many powers of 1/K there are, and the first."""
    powers = [int(nu) for a, nu, _ in terms if a == 0.0]
    return len(powers), min(powers, default=1)


@lru_cache(maxsize=16)
def _table(T: float, turns: float, dimension: int, terms: Terms) -> tuple[FloatArray, FloatArray]:
    """Radii (n,) on [0, T], and weights R^(d-1) times the functions there, (n_functions, n)."""
    rho, weight = panels_between(_edges(T, terms, turns), _POINTS)
    return rho, weight * element(rho, dimension) * _functions(rho / T, terms)


def _edges(T: float, terms: Terms, turns: float = 0.0) -> FloatArray:
    far = min(T, FARTHEST)
    return radial_edges((*{a * T for a, _, _ in terms}, 0.0, far), far, turns)


def _functions(x: FloatArray, terms: Terms) -> FloatArray:
    """The functions of x = R/T but those at R = 0, shape (n_functions, n)."""
    found = []
    inside = x < 1.0
    rest = np.where(inside, (1.0 - x) * (1.0 + x), 1.0)
    with np.errstate(under="ignore"):
        end = np.where(inside, np.exp(-x * x / rest), 0.0)  # falls to 0 at R = T, and all slopes
    for a, nu, p in terms:
        if a == 1.0:
            found.append(np.where(inside, rest**nu * np.log(rest) ** p, 0.0))
        elif a > 0.0:
            beside = np.maximum(p / abs(p) * (x / a - 1.0) * (x / a + 1.0), 0.0)
            logarithm = np.log(np.maximum(beside, 1e-30)) ** (abs(p) - 1.0)
            # outside it must have fallen where the tables end
            fall = np.exp(-0.25 * beside**2) * end if p > 0.0 else 1.0
            found.append(beside**nu * logarithm * fall)
    return np.array(found)


def _transforms(
    rho: FloatArray, T: float, shape: tuple[Terms, float, int], kind: int
) -> FloatArray:
    """Of each function of one speed: (n_functions, n_rho); see :meth:`FrontTail.transform`."""
    terms, scale, d = shape
    parts = np.zeros((0, rho.size))
    if terms[0][0] == 0.0:
        pass
    elif kind == 0:
        parts = _functions(rho / T, terms)
    elif kind == 1:
        near = np.clip(rho, 0.0, min(T, FARTHEST))
        edges = np.union1d(_edges(T, terms), near)
        x, w = panels_between(edges, _POINTS)
        parts = w * element(x, d) * _functions(x / T, terms)
        sums = np.cumsum(parts.reshape(-1, edges.size - 1, _POINTS).sum(axis=2), axis=1)
        sums = np.concatenate([np.zeros((sums.shape[0], 1)), sums], axis=1)
        parts = sums[:, np.searchsorted(edges, near)] / np.maximum(element(rho, d), 1e-300)
    else:
        step = 1e-5 * T
        ends = [_functions(np.abs(rho + h) / T, terms) for h in (-step, step)]
        parts = (ends[0] - ends[1]) / (2.0 * step)
    count, first = _at_origin(terms)
    if count:
        at_origin = origin_transforms(scale * rho, count, kind, d, first)
        parts = np.concatenate([parts, at_origin * scale ** (d, d - 1, d + 1)[kind]])
    return parts
