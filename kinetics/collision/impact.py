"""Restitutions that depend on the normal component v_n of the impact speed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics.errors import ERRORS_OF_FUNCTIONS, InputError, short
from kinetics.numerics import FloatArray
from kinetics.results.record import stored_class
from kinetics.results.result import Storable
from kinetics.validation import check_positive, finite_line, number_array, refuse

#: Coefficients of the numerator of the Padé approximant of e(x), x = b v_n^(1/10), of viscoelastic
#: spheres: Müller and Pöschel, Phys. Rev. E 84, 021302 (2011).
_ABOVE = (0.501086, 1.0)
#: Coefficients of its denominator.
_BELOW = (0.532178, 0.577977, 1.15345, 0.501086, 1.0)
_PROBES = np.geomspace(1e-9, 1e6, 61)
_MOST_BREAKS = 40  # of a table: finer ones are integrated over as if they were smooth


class ImpactRestitution(Storable):
    """e as a function of the normal impact speed.

    breaks : impact speeds at which it is not smooth, rising, shape (n,)
    is_singular : whether it varies as a fractional power of slow impacts
    """

    breaks: FloatArray = np.empty(0)
    is_singular: bool = False

    def __call__(self, impact_speed: ArrayLike) -> FloatArray:
        """e at normal impact speeds of any shape, not negative."""
        raise NotImplementedError


def _impact_speeds(value: ArrayLike) -> FloatArray:
    """Return impact speeds of any shape; InputError for what are no numbers, or negative."""
    allowed = "it must be numbers, none negative"
    speeds: FloatArray = number_array("impact_speed", value, "biuf", allowed)
    if speeds.size and speeds.min() < 0.0:
        refuse("impact_speed", value, allowed)
    return speeds


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class Viscoelastic(ImpactRestitution):
    """Viscoelastic spheres: e falls from 1 as the impact speed grows.

    Parameters
    ----------
    b : the material parameter, above 0, in U^(-1/10) for a Scene: e is a function of
        x = b v_n^(1/10), (1 + c1 x)/(1 + c1 x + b2 x^2 + b3 x^3 + b4 x^4). For slow impacts it is
        1 - 1.15345 b^2 v_n^(1/5)

    Raises InputError unless b is a finite number above 0.

    >>> round(float(Viscoelastic(0.45)(1.0)), 5)
    0.79912
    """

    b: float
    is_singular = True

    def __post_init__(self) -> None:
        self.store(b=check_positive("b", self.b))

    def __call__(self, impact_speed: ArrayLike) -> FloatArray:
        """e at normal impact speeds of any shape, not negative."""
        x = self.b * _impact_speeds(impact_speed) ** 0.1
        return np.asarray(np.polyval(_ABOVE, x) / np.polyval(_BELOW, x))


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class TabulatedRestitution(ImpactRestitution):
    """e linear between measured impact speeds, constant beyond them.

    Parameters
    ----------
    impact_speed : rising, not negative, shape (n,)
    restitution : in [0, 1], same shape
    """

    impact_speed: ArrayLike
    restitution: ArrayLike

    def __post_init__(self) -> None:
        speed = finite_line("restitution", self.impact_speed, low=0.0)
        value = finite_line("restitution", self.restitution, low=0.0)
        if not (speed.size == value.size > 0 and np.all(np.diff(speed) > 0) and value.max() <= 1):
            allowed = "a table needs rising impact speeds and as many values from 0 to 1"
            refuse("restitution", (self.impact_speed, self.restitution), allowed)
        few = speed.size <= _MOST_BREAKS
        self.store(impact_speed=speed, restitution=value, breaks=speed if few else np.empty(0))

    def __call__(self, impact_speed: ArrayLike) -> FloatArray:
        """e at normal impact speeds of any shape."""
        return np.interp(_impact_speeds(impact_speed), self.impact_speed, self.restitution)  # type: ignore[arg-type]


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class RestitutionFunction(ImpactRestitution):
    """A Python function of an array of impact speeds; it is taken to be smooth.

    Raises InputError unless it returns numbers from 0 to 1 of the same shape.
    """

    function: Callable[[Any], Any]

    def __post_init__(self) -> None:
        self(_PROBES)

    def __call__(self, impact_speed: ArrayLike) -> FloatArray:
        """e at normal impact speeds of any shape."""
        v = _impact_speeds(impact_speed)
        try:
            e = np.asarray(self.function(v), dtype=float)
        except ERRORS_OF_FUNCTIONS as error:
            text = "the function could not be evaluated on an array of impact speeds"
            raise InputError(f"restitution: {text} ({short(error)})") from None
        if e.shape != v.shape or not np.all((e >= 0.0) & (e <= 1.0)):
            allowed = "a function must map impact speeds to as many numbers from 0 to 1"
            refuse("restitution", self.function, allowed)
        return e


def impact_restitution(value: Any) -> ImpactRestitution | None:
    """The restitution of impact speeds that a user gives; None for a number or a collision law."""
    if isinstance(value, ImpactRestitution):
        return value
    if isinstance(value, tuple) and len(value) == 2:
        return TabulatedRestitution(*value)
    return RestitutionFunction(value) if callable(value) else None
