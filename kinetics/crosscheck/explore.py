r"""The page to play with, and the tables from which it draws its curves, Chebyshev coefficients.

Its HTML, CSS and JavaScript are `explorer.*` in `kinetics/crosscheck/templates`.

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

Of F(c) the logarithm of the density of ln(c)/w is kept, w = sqrt((1 - e^2)/5): for e -> 1 that of a
Gaussian of width 1.
"""

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebpts1, chebvander
from numpy.typing import ArrayLike, NDArray

from kinetics import ScalingSolution, Scene, __version__, solve, solve_field, solve_steady
from kinetics.crosscheck.files import plain, rendered

Array = NDArray[np.float64]
Tables = dict[str, "Table"]

DILUTE, HARD = "dilute", "hard disks"
UNIT = 1e-6  # of coefficients
TIMES = (1e-3, 1e6)
"""In l/U: before, v0 and <r^2> are the factors; after, nothing is drawn."""
DENSITIES = (0.005, 0.1)
"""n of hard disks: up to where their theory was compared with simulations."""
HIGHEST_DRIVEN = 0.99
"""e above which no steady state is kept: elastic tracers, driven by anything here, have none."""
POWERS = {
    "field": {"drift": 1 / 4, "parallel": -1 / 4, "perpendicular": -1 / 4},
    "bath": {"v0": -1 / 2, "D": -1 / 2, "fourth": 0.0, "einstein": 0.0},
    "noise": {"v0": -1 / 3, "D": -1 / 3, "fourth": 0.0, "einstein": 0.0},
}
"""What drives a tracer -> figures of its steady state (`steady`) -> the power of 1 - e that is
divided out of their tables."""
WIDTHS = {DILUTE: (-6.0, 6.0), HARD: (-3.0, 5.0)}
"""Of ln(c)/w, between which F(c) is kept. Below, that of hard disks may be negative."""


@dataclass(frozen=True)
class Table:
    """A function of x(e) and perhaps other variables, each on its own range.

    breaks : ends of the panels of x, rising; ends : those of each further variable;
    coefficients : multiples of `UNIT`, shape (n_panels, n_e, ...), in which the page has them
    """

    breaks: tuple[float, ...]
    ends: tuple[tuple[float, float], ...]
    coefficients: NDArray[np.int64]

    def at(self, e: float, *points: ArrayLike) -> Array:
        """Values at e and, along an axis for each, at points of the further variables."""
        x = place_of(e)
        panel = min(int(np.searchsorted(self.breaks[1:], x)), len(self.breaks) - 2)
        found = UNIT * self.coefficients[panel]
        ends = (self.breaks[panel : panel + 2], *self.ends)
        for place, (low, high) in zip((x, *points), ends, strict=True):
            # the first axis goes, its points come last
            scaled = (2.0 * np.atleast_1d(place) - low - high) / (high - low)
            found = np.tensordot(found, chebvander(scaled, len(found) - 1), (0, 1))
        return np.asarray(found[0])

    def as_json(self) -> dict[str, Any]:
        """For the page; coefficients in the order of memory."""
        c = self.coefficients
        return {**vars(self), "coefficients": c.ravel(), "shape": c.shape}


def place_of(e: float) -> float:
    """x in [0, 1], of e = x^2 (3 - 2 x)."""
    return 0.5 - math.sin(math.asin(1.0 - 2.0 * e) / 3.0)


def tables(
    names: Sequence[str], function: Callable[..., Any], breaks: Sequence[float], nodes: int,
    *axes: tuple[float, float, int],
) -> Tables:  # fmt: skip
    """The tables of function(e, *grids), which gives shape (len(names), ...).

    breaks : of e; nodes : of e in each panel; axes : ends and number of nodes of the others
    """
    places = tuple(place_of(e) for e in breaks)
    grids = [_on(low, high, n) for low, high, n in axes]
    panels = []
    for low, high in pairwise(places):
        x = _on(low, high, nodes)
        values = np.array([function(e, *grids) for e in x * x * (3.0 - 2.0 * x)])
        for _ in axes:  # from the last axis to the third: each goes behind that of the names
            values = np.moveaxis(np.tensordot(_transform(values.shape[-1]), values, (1, -1)), 0, 2)
        panels.append(np.tensordot(_transform(nodes), values, 1))
    found = np.rint(np.array(panels) / UNIT).astype(np.int64)
    ends = tuple(axis[:2] for axis in axes)
    return {name: Table(places, ends, found[:, :, k]) for k, name in enumerate(names)}


def _on(low: float, high: float, n: int) -> Array:
    return np.asarray(low + (high - low) * (0.5 + 0.5 * chebpts1(n)))


@cache
def _transform(n: int) -> Array:
    """The matrix from values at Chebyshev's n points to coefficients."""
    return np.asarray(np.linalg.inv(chebvander(chebpts1(n), n - 1)))


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
    if e == 1.0:
        return 0.0, rates(1.0 - 1e-7, n)[1]
    state = ScalingSolution(e, scatterers=DILUTE if n is None else HARD, number_density=n)
    path = 1.0 if n is None else 2.0 * n * state.law.mean_free_path(n, 1.0)
    return (h := state.cooling_rate / path), 4.0 / (h * state.diffusion_slope * path**2)


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
    breaks, ends_of_n = (0.0, 0.2, 1.0), (math.sqrt(DENSITIES[0]), math.sqrt(DENSITIES[1]))
    log_t, root_n = (math.log(TIMES[0]), math.log(TIMES[1]), 48), (*ends_of_n, 6)
    xi, hard_xi = (*WIDTHS[DILUTE], 40), (*WIDTHS[HARD], 32)
    tell("dilute scatterers")
    found = tables(("v0", "msd"), lambda e, s: _over_factors(e, None, s), (0.0, 1.0), 24, log_t)
    found |= tables(("ln F",), lambda e, s: _log_density(e, None, s), (0.0, 1.0), 40, xi)
    tell("hard disks: v0, <r^2>")
    # H/(1 - e) has a limit for e -> 1
    limits = _at_each(lambda e, n: np.array(rates(e, n)) / [1.0 - e, 1.0])
    found |= tables(("hard H", "hard A"), limits, breaks, 16, root_n)
    found |= tables(("hard v0", "hard msd"), _at_each(_over_factors), breaks, 16, root_n, log_t)
    tell("hard disks: F(c)")
    found |= tables(("hard ln F",), _at_each(_log_density), breaks, 14, (*ends_of_n, 5), hard_xi)
    tell("steady states of driven tracers")
    for drive, powers in POWERS.items():
        falls = np.array([*powers.values()])
        scaled = lambda e, d=drive, p=falls: steady(d, e) / (1.0 - e) ** p  # noqa: E731
        found |= tables([f"{drive} {name}" for name in powers], scaled, (0.0, HIGHEST_DRIVEN), 20)
    return found


def _at_each(function: Callable[..., Any]) -> Callable[..., Array]:
    """function(e, n, ...) at each of several roots of n, along a second axis."""

    def each(e: float, root_n: Array, *rest: Array) -> Array:
        return np.stack([function(e, n, *rest) for n in (root_n**2).tolist()], axis=1)

    return each


def _over_factors(e: float, n: float | None, log_t: Array) -> Array:
    t = np.exp(log_t)
    return np.asarray(solved(e, n, t) / factors(*rates(e, n), t))


def scaled_density(e: float, n: float | None, xi: Array) -> Array:
    """The density of xi = ln(c)/w in the scaling state, of integral 1."""
    width = math.sqrt((1.0 - e * e) / 5.0)
    c = np.exp(width * xi)
    medium = DILUTE if n is None else HARD
    state = ScalingSolution(e, scatterers=medium, number_density=n)
    return np.asarray(2.0 * math.pi * width * c * c * state.vdf(c))


def _log_density(e: float, n: float | None, xi: Array) -> Array:
    return np.log(np.maximum(scaled_density(e, n, xi), 1e-280))[None]


def steady(drive: str, e: float) -> Array:
    """Figures of a steady state, in the order of `POWERS`; l = 1, and what drives is 1.

    In a field drift and both diffusion coefficients; in a bath of infinitely heavy scatterers and
    under noise v0, D, <v^4>/(2 v0^4) = 1 + a2, and D/(mu <v_x^2>), 1 by Einstein's relation.
    """
    if drive == "field":
        field = solve_field(e, rtol=1e-6)
        return np.array([field.drift, field.diffusion_parallel, field.diffusion_perpendicular])
    bath, noise = float(drive == "bath"), float(drive == "noise")
    state = solve_steady(e, bath_speed=bath, heating=noise, rtol=1e-6)
    spread = state.diffusion_coefficient
    einstein = spread / (state.mobility * state.mean_square_along)
    return np.array([state.thermal_speed, spread, 1.0 + state.a2, einstein])


# -- the page --------------------------------------------------------------------------------------
def render(made: Tables, tracers: int = 200) -> str:
    """The page of these tables, which needs nothing beside it."""
    from markupsafe import Markup

    speeds, weights = starts()
    data: dict[str, Any] = {
        "tables": {name: table.as_json() for name, table in made.items()},
        "speeds": speeds, "weights": weights, "widths": WIDTHS, "densities": DENSITIES,
        "highestDriven": HIGHEST_DRIVEN, "powers": POWERS, "unit": UNIT,
    }  # fmt: skip
    text = json.dumps(plain(data), allow_nan=False, separators=(",", ":"))
    return rendered(
        "explorer.html.j2", data=Markup(text), version=__version__, tracers=tracers,
        densities=DENSITIES,
    )  # fmt: skip
