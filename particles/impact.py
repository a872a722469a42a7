"""A restitution that depends on the impact speed: laws, and the one form that kernels read.

The impact speed is the size of the normal component of the relative velocity, in U. A law becomes
a table of e with NODES_PER_OCTAVE nodes in each octave of the speed, straight between them and
constant outside. Begin reading with `check_restitution` and `tabulate`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from particles.values import (
    Value,
    check_number,
    check_positive,
    real_array,
    refuse,
    set_fields,
    short,
)

#: Nodes of a table in each octave of the impact speed. Measured: e of Viscoelastic is off by
#: 1.1e-7 at most (b from 0.1 to 10), by 4.5e-7 with half as many. A jump is smeared over
#: 1/256 = 0.4 % of the speed.
NODES_PER_OCTAVE = 256
#: Octave of the lowest impact speed of a table or a function, 9e-13 U. The origin of the number is
#: not recorded.
LOWEST_OCTAVE = -40
#: The same of Viscoelastic, whose 1 - e falls as slowly as speed^(1/5). Measured: at 2^-200 U it is
#: 1e-12 for b = 1; at 2^-100 U it would be 1e-6.
LOWEST_VISCOELASTIC_OCTAVE = -200
#: Octave of the highest impact speed, 1e6 U. The origin of the number is not recorded.
HIGHEST_OCTAVE = 20
#: Tables that are kept: the laws of the last so many runs. The origin of the number is not
#: recorded.
TABLES_KEPT = 16


def _impact_speeds(value: object) -> np.ndarray:
    """Return impact speeds of any shape; ValueError for what are no numbers, or negative."""
    allowed = "it must be numbers, none negative"
    speeds = real_array("speed", value, allowed)
    if speeds.size and speeds.min() < 0.0:
        refuse("speed", value, allowed)
    return speeds


@dataclass(frozen=True)
class Viscoelastic:
    """Restitution of viscoelastic spheres, a function of the impact speed v in U.

    With x = b v^(1/10), in the Pade form of P. Mueller and T. Poeschel, Phys. Rev. E 84, 021302
    (2011): e = (1 + c1 x)/(1 + c1 x + b2 x^2 + b3 x^3 + b4 x^4). b: positive, in U^(-1/10).
    ValueError for one that is not.
    """

    b: float

    def __post_init__(self) -> None:
        set_fields(self, b=check_positive("b", self.b))

    def __call__(self, speed: ArrayLike) -> np.ndarray:
        """Return the restitution at impact speeds in U, of any shape."""
        x = self.b * _impact_speeds(speed) ** 0.1
        with np.errstate(over="ignore"):
            # b2, b3 and b4, then c1, of the article.
            above = x * x * (1.15345 + x * (0.577977 + x * 0.532178))
            return np.asarray(1.0 / (1.0 + above / (1.0 + 0.501086 * x)))


@dataclass(frozen=True, eq=False)
class Tabulated(Value):
    """Restitution as a table: speeds (n,) in U, increasing, and values (n,) in [0, 1].

    Straight between two speeds, constant outside.
    """

    speeds: np.ndarray
    values: np.ndarray

    def __repr__(self) -> str:
        return f"Tabulated({self.speeds.size} speeds {self.speeds[0]:g} to {self.speeds[-1]:g})"

    def __call__(self, speed: ArrayLike) -> np.ndarray:
        """Return the restitution at impact speeds in U, of any shape."""
        return np.asarray(np.interp(_impact_speeds(speed), self.speeds, self.values))


Law = Viscoelastic | Tabulated


def _nodes(lowest_octave: int) -> np.ndarray:
    """Return the speeds of a table from 2^lowest_octave on."""
    count = (HIGHEST_OCTAVE - lowest_octave) * NODES_PER_OCTAVE + 1
    octaves, places = np.divmod(np.arange(count), NODES_PER_OCTAVE)
    return np.ldexp(1.0 + places / NODES_PER_OCTAVE, lowest_octave + octaves)


def check_restitution(value: object) -> float | Law:
    """Return a number from 0 to 1 or a law; a function becomes a table. ValueError for others."""
    if isinstance(value, Law):
        return value
    if callable(value):
        table = _table_of_function(value)
    elif isinstance(value, (tuple, list)) and len(value) == 2:
        table = _table_of_pair(value[0], value[1], value)
    else:
        allowed = "it must be a number from 0 to 1, or say how it depends on the impact speed"
        return check_number("restitution", value, 0.0, 1.0, allowed)
    is_bad = ~((table.values >= 0.0) & (table.values <= 1.0))
    if is_bad.any():
        name = f"restitution at the impact speed {table.speeds[is_bad][0]:g}"
        refuse(name, float(table.values[is_bad][0]), "it must be from 0 to 1")
    return table


def _table_of_function(function: Callable[..., object]) -> Tabulated:
    """Return the table of a user's function, whose values may be any real numbers."""
    allowed = "as a function it must give a number for each speed of an array"
    speeds = _nodes(LOWEST_OCTAVE)
    try:
        result = function(speeds.copy())
    except Exception as error:  # of the user's own code
        refuse("restitution", function, f"{allowed}; it raised {short(error)}")
    values = real_array("restitution", result, allowed)
    if values.shape not in ((), speeds.shape):
        refuse("restitution", function, allowed)
    return Tabulated(speeds, np.broadcast_to(values, speeds.shape).copy())


def _table_of_pair(speeds: object, values: object, pair: object) -> Tabulated:
    """Return the table that a user has specified as a pair of sequences."""
    allowed = "it must be (speeds, values): as many of either, speeds from 0 and increasing"
    x = real_array("restitution", speeds, allowed)
    y = real_array("restitution", values, allowed)
    if x.ndim != 1 or x.shape != y.shape or x.size < 2:
        refuse("restitution", pair, allowed)
    is_increasing = np.isfinite(x).all() and x[0] >= 0.0 and np.diff(x).min() > 0.0
    if not is_increasing:
        refuse("restitution", pair, allowed)
    return Tabulated(x, y)


@lru_cache(TABLES_KEPT)
def tabulate(law: float | Law) -> tuple[int, np.ndarray]:
    """Return (octave of the lowest speed, values at the nodes) of a law, or of a constant."""
    if not isinstance(law, Law):
        return 0, np.array([law])
    lowest_octave = LOWEST_OCTAVE
    if isinstance(law, Viscoelastic):
        lowest_octave = LOWEST_VISCOELASTIC_OCTAVE
    return lowest_octave, law(_nodes(lowest_octave))
