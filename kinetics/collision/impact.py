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

# The Padé approximant of viscoelastic spheres (Müller and Pöschel, Phys. Rev. E 84, 021302, 2011):
# e = (1 + c1 x)/(1 + c1 x + b2 x^2 + b3 x^3 + b4 x^4), x = b v_n^(1/10), without units.
#: Coefficient of x in numerator and denominator.
_C1 = 0.501086
#: Coefficient of x^2 in the denominator: e of slow impacts is 1 - _B2 x^2.
_B2 = 1.15345
#: Coefficient of x^3 in the denominator.
_B3 = 0.577977
#: Coefficient of x^4 in the denominator.
_B4 = 0.532178
#: beta = b^2 v_n^(1/5) at which the error of the approximant is tabulated.
_BETA = np.array([0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0,
                  1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 20.0, 50.0, 100.0, 1000.0])  # fmt: skip
#: The approximant less e of the integrated collision there: x'' + beta sqrt(x) x' + x^(3/2) = 0
#: from x = 0 and x' = 1 until the force ends at x'' = 0, to 1e-9. The test integrates it again.
_ERROR = np.array([6.18e-08, 5.22e-07, 7.21e-06, 4.70e-05, 2.65e-04, 6.58e-04, 1.18e-03,
                   2.41e-03, 3.66e-03, 4.80e-03, 6.87e-03, 8.00e-03, 8.64e-03, 8.35e-03, 7.15e-03,
                   6.01e-03, 4.38e-03, 2.68e-03, 9.42e-04, 3.93e-04, 1.74e-05])  # fmt: skip
#: Power of beta with which the error falls below the table. Measured: 2.7 to 3.2 in its first rows.
_POWER_OF_ERROR = 3.0
#: Impact speeds, in the user's unit, at which a Python function is tried: four in a decade of all
#: that a run may meet. The origin of the range is not recorded.
_PROBES = np.geomspace(1e-9, 1e6, 61)
#: Points of a table at most whose kinks are integrated over one by one: finer tables are taken for
#: smooth. The origin of the number is not recorded.
_MOST_BREAKS = 40


class ImpactRestitution(Storable):
    """e as a function of the normal impact speed.

    breaks : impact speeds at which it is not smooth, rising, shape (n,)
    is_singular : whether it varies as a fractional power of slow impacts
    """

    breaks: FloatArray = np.empty(0)
    is_singular: bool = False

    @property
    def limits(self) -> str:
        """What the law lacks, to follow a sentence; empty where nothing is known."""
        return ""

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

    This is a Padé approximant (Müller and Pöschel, Phys. Rev. E 84, 021302, 2011) of the collision
    of two spheres with a viscoelastic force. It is above the e of that collision by 5e-5, 0.0012,
    0.0037 and 0.0086 at b^2 v_n^(1/5) = 0.1, 0.4, 0.8 and 3, where it is largest: results are those
    of the approximant, whatever accuracy a solver has. :meth:`model_error` is this error.

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
        numerator = np.polyval([_C1, 1.0], x)
        denominator = np.polyval([_B4, _B3, _B2, _C1, 1.0], x)
        return np.asarray(numerator / denominator)

    def model_error(self, impact_speed: ArrayLike) -> FloatArray:
        """The approximant's e less that of the integrated collision, to a tenth of itself.

        At normal impact speeds of any shape, not negative; from 0 to 0.0086.
        """
        beta = self.b**2 * np.asarray(impact_speed, dtype=float) ** 0.2
        with np.errstate(divide="ignore"):
            log_error = np.interp(np.log(beta), np.log(_BETA), np.log(_ERROR))
        below_table = np.minimum(beta / _BETA[0], 1.0) ** _POWER_OF_ERROR
        return np.asarray(np.exp(log_error) * below_table)

    @property
    def limits(self) -> str:
        """What the law lacks: it is an approximant."""
        text = "; e of viscoelastic spheres is a Padé approximant, too high by up to"
        return f"{text} {max(_ERROR):.2g}"


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
