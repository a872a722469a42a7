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

DILUTE = "dilute"
HARD = "hard disks"
#: Unit of the coefficients, which the page has as whole numbers.
UNIT = 1e-6
#: First time of the tables, in l/U: before it v0 and <r^2> are the factors alone. The origin of the
#: number is not recorded.
FIRST_TIME = 1e-3
#: Last time of the tables, in l/U: after it nothing is drawn. The origin is not recorded.
LAST_TIME = 1e6
#: Lowest density n of hard disks. The origin of the number is not recorded.
LOWEST_DENSITY = 0.005
#: Highest density n of hard disks: up to it their theory was compared with simulations.
HIGHEST_DENSITY = 0.1
#: e above which no steady state is kept: elastic tracers, driven by anything here, have none.
HIGHEST_DRIVEN = 0.99
#: e below which the constants of the theory of hard disks are held.
HELD_BELOW = 0.2
#: What drives a tracer -> figures of its steady state (`steady`) -> the power of 1 - e that is
#: divided out of their tables.
POWERS = {
    "field": {"drift": 1 / 4, "parallel": -1 / 4, "perpendicular": -1 / 4},
    "bath": {"v0": -1 / 2, "D": -1 / 2, "fourth": 0.0, "einstein": 0.0},
    "noise": {"v0": -1 / 3, "D": -1 / 3, "fourth": 0.0, "einstein": 0.0},
}
#: ln(c)/w between which F(c) is kept. Below, that of hard disks may be negative.
WIDTHS = {DILUTE: (-6.0, 6.0), HARD: (-3.0, 5.0)}
# Nodes of the tables, chosen so that what is read is the solver's to 2e-4 (3e-4 among hard disks),
# which the tests hold.
#: In e, of v0 and <r^2>.
NODES_OF_AVERAGES = 24
#: In e, of F(c).
NODES_OF_DENSITY = 40
#: In each panel of e, of averages among hard disks.
NODES_OF_HARD_AVERAGES = 16
#: In each panel of e, of F(c) among hard disks.
NODES_OF_HARD_DENSITY = 12
#: In e, of steady states.
NODES_OF_STEADY_STATES = 20
#: In the logarithm of time.
NODES_IN_TIME = 48
#: In the root of the density n.
NODES_IN_ROOT_DENSITY = 6
#: The same, of F(c).
NODES_IN_ROOT_DENSITY_OF_VDF = 3
#: In ln(c)/w.
NODES_IN_SPEED = 40
#: The same, among hard disks.
NODES_IN_HARD_SPEED = 32
#: Tolerance of the averages: below the error of the tables.
AVERAGES_RTOL = 1e-7
#: Tolerance of the steady states, likewise.
STEADY_RTOL = 1e-6
#: F below which its logarithm is held: smaller numbers underflow.
MIN_DENSITY = 1e-280
#: Gauss nodes in the speed of the Gaussian start. The origin is not recorded.
N_START_SPEEDS = 24
#: Largest speed of the start over U: beyond are 7e-10 of the tracers.
LARGEST_START_SPEED = 6.5
#: e in place of 1 where a rate is a limit.
NEARLY_ELASTIC = 1.0 - 1e-7


@dataclass(frozen=True)
class Table:
    """A function of x(e) and perhaps other variables, each on its own range.

    Parameters
    ----------
    breaks : ends of the panels of x, rising
    ends : those of each further variable
    coefficients : multiples of `UNIT`, shape (n_panels, n_e, ...), in which the page has them
    """

    breaks: tuple[float, ...]
    ends: tuple[tuple[float, float], ...]
    coefficients: NDArray[np.int64]

    def at(self, e: float, *points: ArrayLike) -> Array:
        """Return values at e and, along an axis for each, at points of the further variables."""
        x = place_of(e)
        panel = min(int(np.searchsorted(self.breaks[1:], x)), len(self.breaks) - 2)
        values = UNIT * self.coefficients[panel]
        ends = (self.breaks[panel : panel + 2], *self.ends)
        for place, (low, high) in zip((x, *points), ends, strict=True):
            # The first axis goes, its points come last.
            scaled = (2.0 * np.atleast_1d(place) - low - high) / (high - low)
            values = np.tensordot(values, chebvander(scaled, len(values) - 1), (0, 1))
        return np.asarray(values[0])

    def as_json(self) -> dict[str, object]:
        """Return what the page has; coefficients in the order of memory."""
        return {
            "breaks": self.breaks,
            "ends": self.ends,
            "coefficients": self.coefficients.ravel(),
            "shape": self.coefficients.shape,
        }


@dataclass(frozen=True)
class Variable:
    """A variable of a table beside e: its range, and the number of its nodes."""

    low: float
    high: float
    nodes: int

    @property
    def grid(self) -> Array:
        """Chebyshev's points on the range."""
        return np.asarray(self.low + (self.high - self.low) * (0.5 + 0.5 * chebpts1(self.nodes)))


def place_of(e: float) -> float:
    """Return x in [0, 1], of e = x^2 (3 - 2 x)."""
    return 0.5 - math.sin(math.asin(1.0 - 2.0 * e) / 3.0)


def tabulate(
    names: Sequence[str],
    function: Callable[..., Array],
    breaks: Sequence[float],
    nodes: int,
    *variables: Variable,
) -> Tables:
    """Return the tables of function(e, *grids), which gives shape (len(names), ...).

    Parameters
    ----------
    names : of the tables
    breaks : of e
    nodes : of e in each panel
    variables : the others
    """
    places = tuple(place_of(e) for e in breaks)
    grids = [variable.grid for variable in variables]
    panels = []
    for low, high in pairwise(places):
        x = Variable(low, high, nodes).grid
        values = np.array([function(e, *grids) for e in x * x * (3.0 - 2.0 * x)])
        for _ in variables:  # from the last axis to the third: each goes behind that of the names
            transform = _chebyshev_transform(values.shape[-1])
            values = np.moveaxis(np.tensordot(transform, values, (1, -1)), 0, 2)
        panels.append(np.tensordot(_chebyshev_transform(nodes), values, 1))
    coefficients = np.rint(np.array(panels) / UNIT).astype(np.int64)
    ends = tuple((variable.low, variable.high) for variable in variables)
    return {name: Table(places, ends, coefficients[:, :, k]) for k, name in enumerate(names)}


@cache
def _chebyshev_transform(n: int) -> Array:
    """Return the matrix from values at Chebyshev's n points to coefficients."""
    return np.asarray(np.linalg.inv(chebvander(chebpts1(n), n - 1)))


# -- what is divided out ---------------------------------------------------------------------------
@cache
def starts() -> tuple[Array, Array]:
    """Return speeds of the Gaussian start, in U, and their weights."""
    nodes, weights = np.polynomial.legendre.leggauss(N_START_SPEEDS)
    speeds = LARGEST_START_SPEED / 2 * (nodes + 1.0)
    weights = weights * speeds * np.exp(-0.5 * speeds * speeds)
    return speeds, weights / weights.sum()


def factors(h: float, a: float, t: ArrayLike) -> Array:
    """Return v0 in U and <r^2> in l^2 of tracers that keep to the mean, shape (2, n_times).

    h and a are H and A of the module's docstring.
    """
    speeds, weights = starts()
    free_path = speeds * np.atleast_1d(np.asarray(t, float))[:, None]
    loss = 0.5 * h * free_path
    # ln(1 + x)/x is 1 where x has no digits.
    path = a * free_path * np.where(loss > 1e-9, np.log1p(loss) / np.maximum(loss, 1e-9), 1.0)
    series = path * path * (1.0 - path / 3.0 + path * path / 12.0)
    spread = np.where(path > 1e-3, 2.0 * (path + np.expm1(-path)), series) / a**2
    thermal_speed = np.sqrt((speeds / (1.0 + loss)) ** 2 @ weights)
    return np.array([thermal_speed, spread @ weights])


def scatterers_of(n: float | None) -> str:
    """Return the scatterers of a density n; None: dilute ones."""
    if n is None:
        return DILUTE
    return HARD


def rates(e: float, n: float | None) -> tuple[float, float]:
    """Return H and A, dilute (n is None) or among hard disks, in l = 1/(2 d rho_0)."""
    if e == 1.0:
        return 0.0, rates(NEARLY_ELASTIC, n)[1]
    state = ScalingSolution(e, scatterers=scatterers_of(n), number_density=n)
    path = 1.0
    if n is not None:
        path = 2.0 * n * state.law.mean_free_path(n, 1.0)
    h = state.cooling_rate / path
    return h, 4.0 / (h * state.diffusion_slope * path**2)


def solved(e: float, n: float | None, t: Array) -> Array:
    """Return v0 in U and <r^2> in l^2 of the solver, shape (2, n_times).

    t : in l/U, in any order
    """
    density = 0.5 if n is None else n
    order = np.argsort(t)
    scene = Scene(
        restitution=e,
        number_density=density,
        times=t[order] / (2.0 * density),
        scatterers=scatterers_of(n),
        outputs=("thermal_speed", "msd"),
    )
    solution = solve(scene, rtol=AVERAGES_RTOL)
    averages = np.empty((2, t.size))
    averages[0, order] = solution.thermal_speed
    averages[1, order] = solution.msd * (2.0 * density) ** 2
    return averages


# -- the tables of the page ------------------------------------------------------------------------
def ignore_progress(stage: str) -> None:
    """Take the name of what is begun, and do nothing."""


def all_tables(tell: Callable[[str], None] = ignore_progress) -> Tables:
    """Return every table of the page, by name.

    tell : called with what is begun
    """
    log_time = Variable(math.log(FIRST_TIME), math.log(LAST_TIME), NODES_IN_TIME)
    lowest_root = math.sqrt(LOWEST_DENSITY)
    highest_root = math.sqrt(HIGHEST_DENSITY)
    root_density = Variable(lowest_root, highest_root, NODES_IN_ROOT_DENSITY)
    root_density_of_vdf = Variable(lowest_root, highest_root, NODES_IN_ROOT_DENSITY_OF_VDF)
    log_speed = Variable(*WIDTHS[DILUTE], NODES_IN_SPEED)
    hard_log_speed = Variable(*WIDTHS[HARD], NODES_IN_HARD_SPEED)
    everywhere = (0.0, 1.0)
    with_break = (0.0, HELD_BELOW, 1.0)
    tell("dilute scatterers")
    tables = tabulate(
        ("v0", "msd"),
        lambda e, log_t: _over_factors(e, None, log_t),
        everywhere,
        NODES_OF_AVERAGES,
        log_time,
    )
    tables |= tabulate(
        ("ln F",),
        lambda e, xi: _log_density(e, None, xi),
        everywhere,
        NODES_OF_DENSITY,
        log_speed,
    )
    tell("hard disks: v0, <r^2>")
    tables |= tabulate(
        ("hard H", "hard A"),
        _at_each_density(_scaled_rates),
        with_break,
        NODES_OF_HARD_AVERAGES,
        root_density,
    )
    tables |= tabulate(
        ("hard v0", "hard msd"),
        _at_each_density(_over_factors),
        with_break,
        NODES_OF_HARD_AVERAGES,
        root_density,
        log_time,
    )
    tell("hard disks: F(c)")
    tables |= tabulate(
        ("hard ln F",),
        _at_each_density(_log_density),
        with_break,
        NODES_OF_HARD_DENSITY,
        root_density_of_vdf,
        hard_log_speed,
    )
    tell("steady states of driven tracers")
    for drive in POWERS:
        tables |= _tabulate_steady_states(drive)
    return tables


def _tabulate_steady_states(drive: str) -> Tables:
    """Return the tables of the steady state of a drive."""
    powers = POWERS[drive]
    exponents = np.array([*powers.values()])

    def scaled(e: float) -> Array:
        return np.asarray(steady(drive, e) / (1.0 - e) ** exponents)

    names = [f"{drive} {name}" for name in powers]
    return tabulate(names, scaled, (0.0, HIGHEST_DRIVEN), NODES_OF_STEADY_STATES)


def _at_each_density(function: Callable[..., Array]) -> Callable[..., Array]:
    """Return function(e, n, ...) at each of several roots of n, along a second axis."""

    def at_all(e: float, root_density: Array, *grids: Array) -> Array:
        densities = (root_density**2).tolist()
        return np.stack([function(e, n, *grids) for n in densities], axis=1)

    return at_all


def _scaled_rates(e: float, n: float) -> Array:
    """Return H/(1 - e), which has a limit for e -> 1, and A."""
    return np.array(rates(e, n)) / [1.0 - e, 1.0]


def _over_factors(e: float, n: float | None, log_t: Array) -> Array:
    """Return the averages of the solver over those of tracers that keep to the mean."""
    t = np.exp(log_t)
    return np.asarray(solved(e, n, t) / factors(*rates(e, n), t))


def scaled_density(e: float, n: float | None, xi: Array) -> Array:
    """Return the density of xi = ln(c)/w in the scaling state, of integral 1."""
    width = math.sqrt((1.0 - e * e) / 5.0)
    c = np.exp(width * xi)
    state = ScalingSolution(e, scatterers=scatterers_of(n), number_density=n)
    return np.asarray(2.0 * math.pi * width * c * c * state.vdf(c))


def _log_density(e: float, n: float | None, xi: Array) -> Array:
    """Return the logarithm of `scaled_density`, (1, n_xi)."""
    return np.asarray(np.log(np.maximum(scaled_density(e, n, xi), MIN_DENSITY))[None])


def steady(drive: str, e: float) -> Array:
    """Return figures of a steady state, in the order of `POWERS`; l = 1, and what drives is 1.

    In a field drift and both diffusion coefficients; in a bath of infinitely heavy scatterers and
    under noise v0, D, <v^4>/(2 v0^4) = 1 + a2, and D/(mu <v_x^2>), 1 by Einstein's relation.
    """
    if drive == "field":
        field = solve_field(e, rtol=STEADY_RTOL)
        return np.array([field.drift, field.diffusion_parallel, field.diffusion_perpendicular])
    bath_speed = float(drive == "bath")
    heating = float(drive == "noise")
    state = solve_steady(e, bath_speed=bath_speed, heating=heating, rtol=STEADY_RTOL)
    diffusion = state.diffusion_coefficient
    einstein = diffusion / (state.mobility * state.mean_square_along)
    return np.array([state.thermal_speed, diffusion, 1.0 + state.a2, einstein])


# -- the page --------------------------------------------------------------------------------------
def render(tables: Tables, tracers: int = 200) -> str:
    """Return the page of these tables, which needs nothing beside it."""
    from markupsafe import Markup

    speeds, weights = starts()
    densities = (LOWEST_DENSITY, HIGHEST_DENSITY)
    data: dict[str, Any] = {
        "tables": {name: table.as_json() for name, table in tables.items()},
        "speeds": speeds,
        "weights": weights,
        "widths": WIDTHS,
        "densities": densities,
        "highestDriven": HIGHEST_DRIVEN,
        "powers": POWERS,
        "unit": UNIT,
    }
    text = json.dumps(plain(data), allow_nan=False, separators=(",", ":"))
    return rendered(
        "explorer.html.j2",
        data=Markup(text),
        version=__version__,
        tracers=tracers,
        densities=densities,
    )
