"""The averages over time that a march of driven tracers solves: two tables.

`AVERAGE_ROWS` are sums over the distribution at a time; `INTEGRAL_ROWS` grow over time at the rate
of one of them. With x f and y f, integrated over the place, all averages of the velocity and the
displacement up to second order follow.

To add an average, add one row to `AVERAGE_ROWS`, and its value for tracers without a collision to
:meth:`kinetics.driven.free_fall.Velocities.averages`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from kinetics.numerics import FloatArray


@dataclass(frozen=True)
class Component:
    """Harmonics of one family of a distribution f, or of x f or y f, integrated over the place.

    Parameters
    ----------
    weight : by which f is multiplied: "1", "x" or "y"
    family : of the harmonics, 0 or 1: see `kinetics.driven.harmonics`
    """

    weight: Literal["1", "x", "y"]
    family: int


@dataclass(frozen=True)
class Term:
    """What one harmonic of one component adds to an average: factor times the sum of v^power.

    Parameters
    ----------
    component, harmonic : of which the sums are taken
    power : of the speed v; None for the rate of collisions at v instead
    factor : of the sum
    """

    component: Component
    harmonic: int
    power: int | None
    factor: float = 1.0


#: The size, against which the error of an average counts, from the sizes of all, by name.
Scale = Callable[[Mapping[str, FloatArray]], FloatArray]


def _mean_square_speed(sizes: Mapping[str, FloatArray]) -> FloatArray:
    return sizes["v^2"]


def _thermal_speed(sizes: Mapping[str, FloatArray]) -> FloatArray:
    return np.sqrt(sizes["v^2"])


def _mean_square_displacement(sizes: Mapping[str, FloatArray]) -> FloatArray:
    return sizes["x^2"] + sizes["y^2"]


def _root_mean_square_displacement(sizes: Mapping[str, FloatArray]) -> FloatArray:
    return np.sqrt(sizes["x^2"] + sizes["y^2"])


def _rate_of_displacement(sizes: Mapping[str, FloatArray]) -> FloatArray:
    return sizes["v_x x"] + sizes["v_y y"]


@dataclass(frozen=True)
class AverageRow:
    """One row of the table: an average over the tracers at a time.

    Parameters
    ----------
    name : what is averaged; "v^2 cos 2" is v^2 times harmonic 2, "1" the share that moves
    terms : of which it is the sum
    scale : against which its error counts; None for its own size
    """

    name: str
    terms: tuple[Term, ...]
    scale: Scale | None = None


@dataclass(frozen=True)
class IntegralRow:
    """One row of the table: an integral over the time, from 0.

    Parameters
    ----------
    name : of what grows
    rate : name of the average at whose rate it grows
    factor : of that average
    scale : against which its error counts; None for its own size
    """

    name: str
    rate: str
    factor: float = 1.0
    scale: Scale | None = None


# Components: of f, x f and y f; of harmonics along the field (family 0) and across it (family 1).
F = Component(weight="1", family=0)
F_ACROSS = Component(weight="1", family=1)
X_F = Component(weight="x", family=0)
X_F_ACROSS = Component(weight="x", family=1)
Y_F = Component(weight="y", family=0)
Y_F_ACROSS = Component(weight="y", family=1)

#: The averages at a time, in the order of the columns.
AVERAGE_ROWS = (
    AverageRow("v_x", (Term(F, 1, 1),), _thermal_speed),
    AverageRow("v_y", (Term(F_ACROSS, 1, 1),), _thermal_speed),
    AverageRow("v^2", (Term(F, 0, 2),)),
    AverageRow("v^2 cos 2", (Term(F, 2, 2),), _mean_square_speed),
    AverageRow("v_x v_y", (Term(F_ACROSS, 2, 2, 0.5),), _mean_square_speed),
    AverageRow("v^4", (Term(F, 0, 4),)),
    AverageRow("collision rate", (Term(F, 0, None),)),
    AverageRow("v_x x", (Term(X_F, 1, 1),), _rate_of_displacement),
    AverageRow("v_y y", (Term(Y_F_ACROSS, 1, 1),), _rate_of_displacement),
    AverageRow("v_x y + v_y x", (Term(Y_F, 1, 1), Term(X_F_ACROSS, 1, 1))),
    AverageRow("1", (Term(F, 0, 0),)),
)
#: What grows over time, in the order of the columns behind these.
INTEGRAL_ROWS = (
    IntegralRow("x", "v_x", scale=_root_mean_square_displacement),
    IntegralRow("y", "v_y", scale=_root_mean_square_displacement),
    IntegralRow("collisions", "collision rate"),
    IntegralRow("x^2", "v_x x", 2.0, _mean_square_displacement),
    IntegralRow("y^2", "v_y y", 2.0, _mean_square_displacement),
    IntegralRow("x y", "v_x y + v_y x", scale=_mean_square_displacement),
)
#: All rows; the columns of the values of a march.
ROWS: tuple[AverageRow | IntegralRow, ...] = (*AVERAGE_ROWS, *INTEGRAL_ROWS)
#: The columns by name.
COLUMNS = {row.name: column for column, row in enumerate(ROWS)}
#: The columns at whose rates the integrals grow.
RATE_COLUMNS = [COLUMNS[integral.rate] for integral in INTEGRAL_ROWS]
#: The factors of these rates, (n_integrals,).
RATE_FACTORS = np.array([integral.factor for integral in INTEGRAL_ROWS])
#: Averages that need x f and y f.
SECOND_ORDER_IN_PLACE = frozenset({"x^2", "y^2", "x y"})


def average_rows(
    f: FloatArray, components: list[Component], speeds: FloatArray, rate: FloatArray
) -> FloatArray:
    """Return the averages over distributions, shape (n, n_averages).

    Without y f of family 1 it is as x f of family 0: both directions are alike.

    Parameters
    ----------
    f : (n, n_components, M + 1, size)
    components : what f has
    speeds : v, (size,)
    rate : of collisions at these speeds, (size,)
    """

    def sum_of(term: Term) -> FloatArray | float:
        component = term.component
        if component == Y_F_ACROSS and component not in components:
            component = X_F
        if component not in components:
            return 0.0
        weights = rate if term.power is None else _power(speeds, term.power)
        return term.factor * (f[:, components.index(component), term.harmonic] @ weights)

    rows = np.zeros((len(f), len(AVERAGE_ROWS)))
    for column, average in enumerate(AVERAGE_ROWS):
        for term in average.terms:
            rows[:, column] += sum_of(term)
    return rows


def _power(v: FloatArray, power: int) -> FloatArray:
    """Return v^power by squaring, which is exact to the last digit where v^2 is."""
    if power == 4:
        return np.asarray((v**2) ** 2)
    return np.asarray(v**power)


def largest_relative(missed: FloatArray, values: FloatArray, names: Collection[str]) -> float:
    """Return the largest relative size of what some averages miss; infinite if it is unknown.

    Parameters
    ----------
    missed : by every column, (n, n_columns)
    values : of every column, (n, n_columns)
    names : of the columns that count
    """
    sizes = {name: np.abs(values[:, column]) for name, column in COLUMNS.items()}
    largest = 0.0
    for row in ROWS:
        if row.name not in names:
            continue
        scale = sizes[row.name] if row.scale is None else row.scale(sizes)
        is_nonzero = scale != 0.0  # also what is no number, in a solution that overflows
        relative = np.abs(missed[:, COLUMNS[row.name]])[is_nonzero] / scale[is_nonzero]
        largest = np.maximum(largest, np.max(relative, initial=0.0))
    return float(largest) if math.isfinite(largest) else math.inf
