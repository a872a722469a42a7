"""A restitution that depends on the impact speed: laws, and the one form that kernels read.

The impact speed is the size of the normal component of the relative velocity, in U. A law becomes a
table of the restitution with PER_OCTAVE nodes in each octave of the speed, straight between two of
them and constant outside. With h = 1/PER_OCTAVE that is off by h^2 |v^2 e''(v)|/8 at most where e
is smooth, and not at all where it is itself straight between nodes. For Viscoelastic it is below
1e-7 at any b. A jump or a kink of e lies in one piece, 0.4 % of the speed wide.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from particles.checks import check_number, check_positive, real_array, refuse, short
from particles.results import Value

PER_OCTAVE = 256
OCTAVES = (-40, 20)  # of a table or a function: speeds from 9e-13 to 1e6
LOWEST_VISCOELASTIC = -200  # its e has no plain limit: it goes to 1 as speed^(1/5)
_UPPER, _LOWER = (0.501086,), (0.501086, 1.15345, 0.577977, 0.532178)


@dataclass(frozen=True)
class Viscoelastic:
    """Restitution of viscoelastic spheres, as a function of the impact speed in U.

    With x = b v^(1/10), in the Pade form of P. Mueller and T. Poeschel, Phys. Rev. E 84, 021302
    (2011): e = (1 + c1 x)/(1 + c1 x + b2 x^2 + b3 x^3 + b4 x^4). b: positive, in U^(-1/10).
    ValueError for one that is not.
    """

    b: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "b", check_positive("b", self.b))

    def __call__(self, speed: Any) -> np.ndarray:
        """Return the restitution at impact speeds in U, of any shape."""
        x = self.b * np.asarray(speed, float) ** 0.1
        with np.errstate(over="ignore"):
            tail = x * x * (_LOWER[1] + x * (_LOWER[2] + x * _LOWER[3]))
            return np.asarray(1.0 / (1.0 + tail / (1.0 + _UPPER[0] * x)))


@dataclass(frozen=True, eq=False)
class Tabulated(Value):
    """Restitution as a table: speeds (n,) in U, increasing, and values (n,) in [0, 1].

    Straight between two speeds, constant outside.
    """

    speeds: np.ndarray
    values: np.ndarray

    def __call__(self, speed: Any) -> np.ndarray:
        """Return the restitution at impact speeds in U, of any shape."""
        return np.asarray(np.interp(speed, self.speeds, self.values))


Law = Viscoelastic | Tabulated


def _nodes(lowest: int, highest: int) -> np.ndarray:
    """Return the speeds of a table from 2^lowest to 2^highest."""
    places = np.arange((highest - lowest) * PER_OCTAVE + 1)
    return np.ldexp(1.0 + places % PER_OCTAVE / PER_OCTAVE, lowest + places // PER_OCTAVE)


def check_restitution(value: Any) -> float | Law:
    """Return a number from 0 to 1 or a law; a function becomes a table. ValueError for others."""
    if isinstance(value, Law):
        return value
    if callable(value):
        speeds = _nodes(*OCTAVES)
        return Tabulated(speeds, _values_of(value, speeds))
    if isinstance(value, (tuple, list)) and len(value) == 2:
        allowed = "must be (speeds, values): two sequences of as many numbers, speeds increasing"
        speeds, values = (real_array("restitution", part, allowed) for part in value)
        good = speeds.ndim == 1 and speeds.shape == values.shape and speeds.size > 1
        if not (good and np.isfinite(speeds).all() and np.all(np.diff(speeds) > 0.0)):
            refuse("restitution", value, allowed)
        if speeds[0] < 0.0:
            refuse("restitution", value, "its speeds must not be negative")
        return Tabulated(speeds, _require_share(speeds, values))
    allowed = "must be a number from 0 to 1"
    if not isinstance(value, (int, float, np.number)):
        allowed += ", Viscoelastic(b), a function of the impact speed or (speeds, values)"
    return check_number("restitution", value, 0.0, 1.0, allowed)


def _values_of(law: Callable[..., Any], speeds: np.ndarray) -> np.ndarray:
    allowed = "as a function it must give an array of numbers, one for each speed of an array"
    try:
        found = law(speeds.copy())
    except Exception as error:  # of the user's own code
        what = short(str(error))
        refuse("restitution", law, f"{allowed}; it raised {type(error).__name__}({what})")
    values = real_array("restitution", found, allowed)
    if values.shape not in ((), speeds.shape):
        refuse("restitution", law, allowed)
    return _require_share(speeds, np.broadcast_to(values, speeds.shape).copy())


def _require_share(speeds: np.ndarray, values: np.ndarray) -> np.ndarray:
    bad = ~((values >= 0.0) & (values <= 1.0))
    if bad.any():
        where = f"restitution at the impact speed {speeds[bad][0]:g}"
        raise ValueError(f"{where} = {values[bad][0]:g}: must be from 0 to 1")
    return values


@lru_cache(16)
def compiled(law: float | Law) -> tuple[int, np.ndarray]:
    """Return (octave of the lowest speed, values at the nodes) of a law, or of a constant."""
    if not isinstance(law, Law):
        return 0, np.array([law])
    lowest, highest = OCTAVES
    if isinstance(law, Viscoelastic):
        lowest = LOWEST_VISCOELASTIC
    return lowest, np.ascontiguousarray(law(_nodes(lowest, highest)))
