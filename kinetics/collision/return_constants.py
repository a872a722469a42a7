"""The constants of the theory of a finite density, from the table `returns.json`.

n is the number density times d^2, d the contact distance, l the mean free path, e the restitution.
The constants are integrals over two scatterers and over loops, which
tests/kinetics/measurements/returns.py computes again. Begin with :func:`constants_at`.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np

from kinetics.numerics import FloatArray
from kinetics.numerics.chebyshev import barycentric_weights, interpolation_rows

#: Columns of powers of the speed: of what comes back at once, and of loops of the size of l.
OF_SPEED = ("at once", "ratio at once", "loops", "ratio of loops", "path of loops")
#: All columns that are used.
COLUMNS = ("d", "ln C 0", "ln C 1", "ln C 2", *OF_SPEED)
#: Points of the table through which a constant is interpolated: a cubic. Chosen.
INTERPOLATION_POINTS = 4


@dataclass(frozen=True)
class ReturnConstants:
    """What a restitution makes of the theory; by default the leading order in the density.

    Parameters
    ----------
    more_collisions : d, of 1 + d n times as many collisions
    log_c : ln C of the harmonics m = 0, 1 and 2
    at_once : share of powers of the speed that comes back at once, over n 2 e/(1 + e)
    ratio_at_once : its speed ratio
    loops : share that comes back in loops of the size of l, over n 2 e/(1 + e)
    ratio_of_loops, path_of_loops : its speed ratio, and half of its mean path in l
    """

    more_collisions: float = 0.0
    log_c: tuple[float, float, float] = (0.0, 0.0, 0.0)
    at_once: float = 0.0
    ratio_at_once: float = 1.0
    loops: float = 0.0
    ratio_of_loops: float = 1.0
    path_of_loops: float = 1.0


@cache
def _table() -> dict[str, FloatArray]:
    """Return the columns of the file; those of speeds end before e = 1, where none is lost."""
    text = files("kinetics.collision").joinpath("returns.json").read_text("utf-8")
    document = json.loads(text)
    return {name: np.array(document[name]) for name in ("restitution", *COLUMNS)}


def constants_at(restitution: float) -> ReturnConstants:
    """Return the constants of a restitution; beyond the ends of the table they are held."""
    table = _table()
    values = {}
    for name in COLUMNS:
        column = table[name]
        values[name] = _interpolate(restitution, table["restitution"][: column.size], column)
    return ReturnConstants(
        more_collisions=values["d"],
        log_c=(values["ln C 0"], values["ln C 1"], values["ln C 2"]),
        at_once=values["at once"],
        ratio_at_once=values["ratio at once"],
        loops=values["loops"],
        ratio_of_loops=values["ratio of loops"],
        path_of_loops=values["path of loops"],
    )


def _interpolate(x: float, points: FloatArray, values: FloatArray) -> float:
    """Return the polynomial through the values at the nearest points, at x; held beyond them."""
    x = min(max(x, points[0]), points[-1])
    nearest = np.argsort(np.abs(points - x))[:INTERPOLATION_POINTS]
    weights = barycentric_weights(points[nearest])
    rows = interpolation_rows(x - points[nearest], weights)
    return float(rows @ values[nearest])
