"""A restitution that depends on the impact speed: laws, and the one form that kernels read.

The impact speed is the size of the normal component of the relative velocity, in U. A law becomes
a table of e with PER_OCTAVE nodes in each octave of the speed, straight between them and constant
outside: off by 2e-7 at most for Viscoelastic; jumps are smeared over 0.4 % of the speed.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from particles.values import Value, check_number, check_positive, real_array, refuse, short

PER_OCTAVE = 256
OCTAVES = -40, 20  # of a table or a function: speeds from 9e-13 to 1e6
VISCOELASTIC_OCTAVES = -200, 20  # its e goes to 1 as slowly as speed^(1/5)


@dataclass(frozen=True)
class Viscoelastic:
    """Restitution of viscoelastic spheres, a function of the impact speed v in U.

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

    def __call__(self, speed: Any) -> np.ndarray:
        """Return the restitution at impact speeds in U, of any shape."""
        return np.asarray(np.interp(speed, self.speeds, self.values))


Law = Viscoelastic | Tabulated


def _nodes(lowest: int, highest: int) -> np.ndarray:
    """Return the speeds of a table from 2^lowest to 2^highest."""
    octave, place = np.divmod(np.arange((highest - lowest) * PER_OCTAVE + 1), PER_OCTAVE)
    return np.ldexp(1.0 + place / PER_OCTAVE, lowest + octave)


def check_restitution(value: Any) -> float | Law:
    """Return a number from 0 to 1 or a law; a function becomes a table. ValueError for others."""
    if isinstance(value, Law):
        return value
    if callable(value):
        allowed = "as a function it must give a number for each speed of an array"
        speeds = _nodes(*OCTAVES)
        try:
            found = value(speeds.copy())
        except Exception as error:  # of the user's own code
            refuse("restitution", value, f"{allowed}; it raised {short(error)}")
        values = real_array("restitution", found, allowed)
        if values.shape not in ((), speeds.shape):
            refuse("restitution", value, allowed)
        values = np.broadcast_to(values, speeds.shape).copy()
    elif isinstance(value, (tuple, list)) and len(value) == 2:
        allowed = "it must be (speeds, values): as many of either, speeds from 0 and increasing"
        speeds, values = (real_array("restitution", part, allowed) for part in value)
        good = speeds.ndim == 1 and speeds.shape == values.shape and speeds.size > 1
        if not (good and np.isfinite(speeds).all() and speeds[0] >= 0.0 < np.diff(speeds).min()):
            refuse("restitution", value, allowed)
    else:
        allowed = "it must be a number from 0 to 1, or say how it depends on the impact speed"
        return check_number("restitution", value, 0.0, 1.0, allowed)
    if (bad := ~((values >= 0.0) & (values <= 1.0))).any():
        where = f"restitution at the impact speed {speeds[bad][0]:g}"
        refuse(where, float(values[bad][0]), "it must be from 0 to 1")
    return Tabulated(speeds, values)


@lru_cache(16)
def compiled(law: float | Law) -> tuple[int, np.ndarray]:
    """Return (octave of the lowest speed, values at the nodes) of a law, or of a constant."""
    if not isinstance(law, Law):
        return 0, np.array([law])
    octaves = VISCOELASTIC_OCTAVES if isinstance(law, Viscoelastic) else OCTAVES
    return octaves[0], law(_nodes(*octaves))
