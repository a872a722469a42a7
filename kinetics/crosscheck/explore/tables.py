r"""Tables from which the page draws its curves, as Chebyshev coefficients.

Lengths are in l = 1/(2 d rho_0), times in l/U. With H the cooling rate of v0 -> 2/(H t) and A such
that d<r^2>/d ln t -> 4/(H A), the tables hold v0 and <r^2> over those of tracers that keep to the
mean, averaged over the Gaussian start (`factors`): each has the speed v/(1 + H v t/2), and with the
length of its path, X = (2/H) ln(1 + H v t/2), the mean square displacement
2 (A X - 1 + exp(-A X))/A^2. For short times these are ballistic, for long ones they have the law of
Haff and the slope; and for e -> 1 among dilute scatterers they are exact: what is left is smooth,
1 + O(1 - e), and no time scale of 1/(1 - e) has to be resolved.

e enters through x, e = x^2 (3 - 2 x), which is dense at both ends: terms such as e^2 ln e are
resolved. The density n = rho_0 d^2 of hard disks enters through its square root, and their tables
have a break at e = 0.2, below which the constants of their theory are held.

F(c) is the density of ln(c)/w, w = sqrt((1 - e^2)/5): for e -> 1 a Gaussian of width 1. Its
logarithm is kept.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from numpy.typing import ArrayLike, NDArray

from kinetics import ScalingSolution, Scene, solve, solve_field, solve_scaled

Array = NDArray[np.float64]
Tables = dict[str, "Table"]

DILUTE, HARD = "dilute", "hard disks"
TIMES = (1e-3, 1e6)
"""In l/U: before, v0 and <r^2> are the factors; after, nothing is drawn."""
DENSITIES = (0.005, 0.1)
"""n of hard disks: up to where their theory was compared with simulations."""
HIGHEST_IN_FIELD = 0.99
"""e above which no steady state in a field is kept: elastic tracers have none."""
WIDTHS = {DILUTE: (-6.0, 6.0), HARD: (-3.0, 5.0)}
"""Of ln(c)/w, between which F(c) is kept. Below, that of hard disks may be negative."""
_OF_TIMES = (math.log(TIMES[0]), math.log(TIMES[1]))
_OF_DENSITIES = (math.sqrt(DENSITIES[0]), math.sqrt(DENSITIES[1]))
_BREAK = 0.2


@dataclass(frozen=True)
class Table:
    """A function of x(e) and perhaps other variables, each on its own range.

    breaks : ends of the panels of x, rising; ends : those of each further variable;
    coefficients : multiples of `unit`, shape (n_panels, n_e, ...), in which the page has them
    """

    breaks: tuple[float, ...]
    ends: tuple[tuple[float, float], ...]
    coefficients: NDArray[np.int64]
    unit: float

    def at(self, e: float, *points: ArrayLike) -> Array:
        """Values at e and, along an axis for each, at points of the further variables."""
        x = place_of(e)
        panel = min(int(np.searchsorted(self.breaks[1:], x)), len(self.breaks) - 2)
        found = self.unit * self.coefficients[panel]
        places = [(x, self.breaks[panel : panel + 2])]
        places += list(zip(points, self.ends, strict=True))
        for place, (low, high) in places:  # the first axis goes, its points come last
            scaled = (2.0 * np.atleast_1d(place) - low - high) / (high - low)
            found = np.tensordot(found, chebvander(scaled, len(found) - 1), (0, 1))
        return np.asarray(found[0])

    def as_json(self) -> dict[str, Any]:
        """Lists for the page; coefficients in the order of memory."""
        return {
            "breaks": self.breaks, "ends": self.ends, "shape": self.coefficients.shape,
            "unit": self.unit, "c": self.coefficients.ravel(),
        }  # fmt: skip


def place_of(e: float) -> float:
    """x in [0, 1], of e = x^2 (3 - 2 x)."""
    return 0.5 - math.sin(math.asin(1.0 - 2.0 * e) / 3.0)


def tables(
    names: Sequence[str], function: Callable[..., Any], breaks: Sequence[float], nodes: int,
    *axes: tuple[float, float, int], unit: float = 1e-6,
) -> Tables:  # fmt: skip
    """The tables of function(e, *grids), which gives shape (len(names), ...).

    breaks : of e; nodes : of e in each panel; axes : ends and number of nodes of the others
    """
    places = tuple(place_of(e) for e in breaks)
    grids = [low + (high - low) * _points(n) for low, high, n in axes]
    panels = []
    for low, high in zip(places[:-1], places[1:], strict=True):
        x = low + (high - low) * _points(nodes)
        values = np.array([function(e, *grids) for e in x * x * (3.0 - 2.0 * x)])
        for _ in axes:  # from the last axis to the third: each goes behind that of the names
            values = np.moveaxis(np.tensordot(_transform(values.shape[-1]), values, (1, -1)), 0, 2)
        panels.append(np.tensordot(_transform(nodes), values, 1))
    found = np.rint(np.array(panels) / unit).astype(np.int64)
    ends = tuple(axis[:2] for axis in axes)
    return {name: Table(places, ends, found[:, :, k], unit) for k, name in enumerate(names)}


def _points(n: int) -> Array:
    """Chebyshev's n points, on [0, 1]."""
    return np.asarray(0.5 + 0.5 * np.cos(np.pi * (np.arange(n) + 0.5) / n))


@cache
def _transform(n: int) -> Array:
    """The matrix from values at these points to coefficients."""
    found = np.cos(np.outer(np.arange(n), np.pi * (np.arange(n) + 0.5) / n)) * 2.0 / n
    found[0] /= 2.0
    return found


# -- what is divided out ---------------------------------------------------------------------------


@cache
def starts() -> tuple[Array, Array]:
    """Speeds of the Gaussian start, in U, and their weights."""
    x, weight = np.polynomial.legendre.leggauss(24)
    v = 3.25 * (x + 1.0)
    weight = weight * v * np.exp(-0.5 * v * v)
    return v, weight / weight.sum()


def factors(h: float, a: float, t: ArrayLike) -> Array:
    """v0 in U and <r^2> in l^2 of tracers that keep to the mean, shape (2, n_times)."""
    v, weight = starts()
    way = v * np.atleast_1d(np.asarray(t, float))[:, None]
    loss = 0.5 * h * way
    path = a * way * np.where(loss > 1e-9, np.log1p(loss) / np.maximum(loss, 1e-9), 1.0)
    short = path * path * (1.0 - path / 3.0 + path * path / 12.0)
    spread = np.where(path > 1e-3, 2.0 * (path + np.expm1(-path)), short) / a**2
    return np.array([np.sqrt((v / (1.0 + loss)) ** 2 @ weight), spread @ weight])


def rates(e: float, n: float | None) -> tuple[float, float]:
    """H and A, dilute (n is None) or among hard disks, in l = 1/(2 d rho_0)."""
    state = ScalingSolution(e) if n is None else _scaling(e, n)
    if e == 1.0:
        return 0.0, 4.0 / 3.0 if n is None else rates(1.0 - 1e-7, n)[1]
    path = 1.0 if n is None else 2.0 * n * state.law.mean_free_path(n, 1.0)
    h = state.cooling_rate / path
    return h, 4.0 / (h * state.diffusion_slope * path**2)


def _scaling(e: float, n: float) -> ScalingSolution:
    return ScalingSolution(e, scatterers=HARD, number_density=n)


def solved(e: float, n: float | None, t: Array) -> Array:
    """v0 in U and <r^2> in l^2 of the solver, shape (2, n_times), t in l/U in any order."""
    density, medium = (0.5, DILUTE) if n is None else (n, HARD)
    order = np.argsort(t)
    scene = Scene(
        restitution=e, number_density=density, times=t[order] / (2.0 * density), scatterers=medium,
        outputs=("thermal_speed", "msd"),
    )  # fmt: skip
    solution, found = solve(scene, rtol=1e-7), np.empty((2, t.size))
    found[:, order] = solution.thermal_speed, solution.msd * (2.0 * density) ** 2
    return found


# -- the tables of the page ------------------------------------------------------------------------


def all_tables(tell: Callable[..., None] = lambda *_: None) -> Tables:
    """Every table of the page, by name. tell : is called with what is begun."""
    log_t = (*_OF_TIMES, 48)
    root_n = (*_OF_DENSITIES, 6)
    breaks = (0.0, _BREAK, 1.0)
    tell("dilute scatterers")
    found = tables(("v0", "msd"), _dilute, (0.0, 1.0), 24, log_t)
    found |= tables(("ln F",), _log_vdf, (0.0, 1.0), 40, (*WIDTHS[DILUTE], 40))
    tell("hard disks: v0, <r^2>")
    found |= tables(("hard H", "hard A"), _hard_rates, breaks, 16, root_n)
    found |= tables(("hard v0", "hard msd"), _hard, breaks, 16, root_n, log_t)
    tell("hard disks: F(c)")
    axes = (*_OF_DENSITIES, 6), (*WIDTHS[HARD], 32)
    found |= tables(("hard ln F",), _hard_log_vdf, breaks, 16, *axes, unit=1e-5)
    tell("steady state in a field")
    names = ("drift", "parallel", "perpendicular")
    return found | tables(names, _in_field, (0.0, HIGHEST_IN_FIELD), 20)


def _dilute(e: float, log_t: Array) -> Array:
    t = np.exp(log_t)
    return solved(e, None, t) / factors(*rates(e, None), t)


def _hard(e: float, root_n: Array, log_t: Array) -> Array:
    t = np.exp(log_t)
    every = [solved(e, n, t) / factors(*rates(e, n), t) for n in (root_n**2).tolist()]
    return np.stack(every, axis=1)


def _hard_rates(e: float, root_n: Array) -> Array:
    """H/(1 - e), which has a limit for e -> 1, and A."""
    h, a = np.array([rates(e, n) for n in (root_n**2).tolist()]).T
    return np.array([h / (1.0 - e), a])


def scaled_density(e: float, n: float | None, xi: Array) -> Array:
    """The density of xi = ln(c)/w in the scaling state, of integral 1."""
    width = math.sqrt((1.0 - e * e) / 5.0)
    c = np.exp(width * xi)
    medium: dict[str, Any] = {} if n is None else {"scatterers": HARD, "number_density": n}
    vdf = solve_scaled(e, rtol=1e-7, **medium).vdf(c)
    return np.asarray(2.0 * math.pi * width * c * c * vdf)


def _log_vdf(e: float, xi: Array) -> Array:
    return np.log(np.maximum(scaled_density(e, None, xi), 1e-280))[None]


def _hard_log_vdf(e: float, root_n: Array, xi: Array) -> Array:
    return np.log([[scaled_density(e, n, xi) for n in (root_n**2).tolist()]])


def _in_field(e: float) -> Array:
    """Drift and both diffusion coefficients, l = g = 1, without their powers of 1 - e."""
    state, power = solve_field(e, rtol=1e-6), (1.0 - e) ** 0.25
    diffusion = np.array([state.diffusion_parallel, state.diffusion_perpendicular])
    return np.array([state.drift / power, *(diffusion * power)])


# -- what the page reads from them, and how far it is off ------------------------------------------


def read_averages(made: Tables, e: float, n: float | None, t: Array) -> Array:
    """v0 in U and <r^2> in l^2 from the tables, as the page has them, shape (2, n_times)."""
    log_t = np.log(t)
    if n is None:
        return np.array([made[k].at(e, log_t) for k in ("v0", "msd")]) * factors(*rates(e, n), t)
    root = math.sqrt(n)
    h, a = (float(made[k].at(e, root)[0]) for k in ("hard H", "hard A"))
    both = np.array([made[k].at(e, root, log_t)[0] for k in ("hard v0", "hard msd")])
    return both * factors(h * (1.0 - e), a, t)


def errors(made: Tables, seed: int = 1, points: int = 24) -> dict[str, float]:
    """The largest differences from the solver at random points.

    Relative for averages and, of F(c), the density of ln(c)/w over its largest value.
    """
    rng = np.random.default_rng(seed)
    off = dict.fromkeys(("dilute", "hard disks", "F(c)", "F(c), hard disks", "field"), 0.0)

    def note(name: str, value: ArrayLike, exact: Array, scale: ArrayLike | None = None) -> None:
        size = np.abs(exact) if scale is None else scale
        off[name] = max(off[name], float(np.max(np.abs(value - exact) / size)))

    for e in rng.uniform(0.0, 1.0, points).tolist():
        t = np.exp(rng.uniform(*_OF_TIMES, 20))
        n = float(rng.uniform(*_OF_DENSITIES) ** 2)
        note("dilute", read_averages(made, e, None, t), solved(e, None, t))
        note("hard disks", read_averages(made, e, n, t), solved(e, n, t))
        xi = np.linspace(*WIDTHS[HARD], 41)
        exact = scaled_density(e, None, xi)
        note("F(c)", np.exp(made["ln F"].at(e, xi)), exact, exact.max())
        exact = scaled_density(e, n, xi)
        note(
            "F(c), hard disks",
            np.exp(made["hard ln F"].at(e, math.sqrt(n), xi)[0]),
            exact,
            exact.max(),
        )
    for e in rng.uniform(0.0, HIGHEST_IN_FIELD, points // 4).tolist():
        read = [float(made[k].at(e)[()]) for k in ("drift", "parallel", "perpendicular")]
        note("field", read, _in_field(e))
    return off
