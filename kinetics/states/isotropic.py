"""Isotropic initial states, and the Gaussian with two temperatures.

Directed ones are in `directed.py`; what a state must provide is said in `state.py`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.errors import InputError, short
from kinetics.numerics import FloatArray
from kinetics.states import quadrature
from kinetics.states.quadrature import LogMeasure
from kinetics.states.state import SpeedFunction, State
from kinetics.validation import (
    check_positive,
    density_not_negative,
    finite_array,
    normalised,
    refuse,
    rising_speeds,
)

# q = v^2 times a difference of inverse variances, from which exp(-q) I(q) is the first two terms of
# its asymptotic series: the third is 1e-16 of it for harmonics up to m = 20
_FAR_BESSEL = 1e9


@dataclass(frozen=True)
class Gaussian(State):
    """Independent Gaussian components of the velocity, in general of different deviations.

    Parameters
    ----------
    deviation_x, deviation_y : standard deviations of v_x and v_y, in U; equal ones are the
        isotropic start of the paper

    Raises
    ------
    InputError : a deviation that is not above zero
    """

    deviation_x: float = 1.0
    deviation_y: float = 1.0
    smooth = True
    lowest_moment = -2.0

    def __post_init__(self) -> None:
        for name in ("deviation_x", "deviation_y"):
            self.store(**{name: check_positive(name, getattr(self, name))})

    @property
    def highest_harmonic(self) -> int | None:  # type: ignore[override]
        """0 where the deviations are equal."""
        return 0 if self.deviation_x == self.deviation_y else None

    @property
    def _wide(self) -> float:
        return max(self.deviation_x, self.deviation_y)

    @property
    def _ratio(self) -> float:
        """The wider deviation over the other."""
        return self._wide / min(self.deviation_x, self.deviation_y)

    def in_space(self) -> State | None:
        """The Maxwell distribution of the same deviation, if both are equal."""
        return Maxwell(self.deviation_x) if self.highest_harmonic == 0 else None

    def _factor(self, m: int, u: FloatArray) -> NDArray[Any]:
        """f_m over the density of an isotropic Gaussian of the wider deviation D, at u = v/D.

        With the ratio a of the deviations, the angle gives a exp(-q) I_(m/2)(q), even m only, of
        q = (a^2 - 1) v^2/4: the inverse squares of the deviations differ by that much.
        """
        if self.highest_harmonic == 0:
            return np.ones(u.shape)
        from scipy.special import ive

        ratio, order = self._ratio, abs(m) // 2
        root = 0.5 * math.sqrt((1.0 - 1.0 / ratio) * (1.0 + 1.0 / ratio)) * u  # sqrt(q)/a
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            q = (ratio * root) ** 2
            far = (1.0 - (order**2 - 0.25) / (2.0 * q)) / (math.sqrt(2.0 * math.pi) * root)
        found = np.where(q > _FAR_BESSEL, far, ratio * ive(order, np.minimum(q, _FAR_BESSEL)))
        return -found if order % 2 and self.deviation_y > self.deviation_x else found

    def _is_zero(self, m: int) -> bool:
        """Odd harmonics vanish, and all but the first where the deviations are equal."""
        return m % 2 == 1 or (m != 0 and self.highest_harmonic == 0)

    def harmonic(
        self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0
    ) -> LogMeasure | None:
        """Trapezoid rule in ln v."""
        if self._is_zero(m):
            return None
        found = quadrature.gaussian(rtol, lowest, highest, self._wide, self._ratio)
        return LogMeasure(found.x, found.weight * self._factor(m, np.exp(found.x) / self._wide))

    def profile(self, m: int) -> SpeedFunction | None:
        """v exp(-v^2/2 D^2)/D^2 times the Bessel factor."""

        def value(v: FloatArray) -> NDArray[Any]:
            u = np.minimum(v / self._wide, 100.0)  # f is zero beyond, and u^2 may overflow
            with np.errstate(under="ignore"):
                return u / self._wide * np.exp(-0.5 * u * u) * self._factor(m, u)

        return None if self._is_zero(m) else value


@dataclass(frozen=True)
class Maxwell(State):
    """Three independent Gaussian components of the velocity, in space; isotropic.

    ``deviation`` is the standard deviation of each, in U. Raises InputError if it is not above 0.
    """

    deviation: float = 1.0
    smooth = True
    lowest_moment = -3.0

    def __post_init__(self) -> None:
        self.store(deviation=check_positive("deviation", self.deviation))

    def harmonic(
        self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0
    ) -> LogMeasure | None:
        """Trapezoid rule in ln v: the plane's Gaussian times v."""
        if m:
            return None
        found = quadrature.gaussian(rtol, lowest + 1.0, highest + 1.0, self.deviation)
        weight = found.weight * np.exp(found.x - math.log(self.deviation))
        return LogMeasure(found.x, weight / weight.sum())

    def profile(self, m: int) -> SpeedFunction | None:
        """sqrt(2/pi) v^2/D^3 exp(-v^2/2 D^2)."""
        plane, d = Gaussian(self.deviation, self.deviation).profile(m), self.deviation
        if plane is None:
            return None
        return lambda v: math.sqrt(2.0 / math.pi) * np.minimum(v / d, 100.0) * plane(v)


class Samples(State):
    """Particles of the same weight: of speeds (n,), and of angles (n,) where they are directed."""

    speed: Any

    @property
    def _particles(self) -> tuple[FloatArray, FloatArray | None]:
        """Speeds, and angles to the x axis; all directions where there are none."""
        return np.atleast_1d(self.speed), None

    def harmonic(
        self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0
    ) -> LogMeasure | None:
        """The samples with weights exp(-i m phi)/n, many of them gathered on a fine grid."""
        speed, angle = self._particles
        weight: NDArray[Any] = np.full(speed.size, 1.0 / speed.size)
        if m:
            if angle is None:
                return None
            weight = weight * np.exp(-1j * m * angle)
        return quadrature.samples(np.log(speed), weight, rtol, max(highest, -lowest))

    @property
    def peaks(self) -> tuple[FloatArray, FloatArray]:
        """Every sample is a peak."""
        speed, _ = self._particles
        return speed, np.full(speed.size, 1.0 / speed.size)


@dataclass(frozen=True)
class Monoenergetic(Samples):
    """All speeds equal, all directions."""

    speed: float = 1.0

    def __post_init__(self) -> None:
        self.store(speed=check_positive("speed", self.speed))


class Table(State):
    """A state whose f_m are linear between speeds (n,): what `_values` returns at them, or None."""

    speed: ArrayLike

    def _values(self, m: int) -> NDArray[Any] | None:
        raise NotImplementedError

    def harmonic(
        self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0
    ) -> LogMeasure | None:
        """Gauss points on the linear pieces."""
        values = self._values(m)
        if values is None:
            return None
        found = quadrature.table(np.asarray(self.speed), values, 0.1 * rtol, lowest)
        # ln v of points that are close to each other has lost digits: the sum may not be 1
        return LogMeasure(found.x, found.weight / found.weight.sum()) if m == 0 else found

    def profile(self, m: int) -> SpeedFunction | None:
        """Linear interpolation."""
        speed, values = np.asarray(self.speed), self._values(m)
        return None if values is None else lambda v: quadrature.interpolate(v, speed, values)

    @property
    def lowest_moment(self) -> float:  # type: ignore[override]
        """The first piece decides, if it begins at speed 0."""
        values = self._values(0)
        assert values is not None
        if np.asarray(self.speed)[0] > 0.0:
            return -math.inf
        return -1.0 if values[0] > 0.0 else -2.0

    @property
    def kinks(self) -> FloatArray:
        """The points of the table."""
        return np.asarray(self.speed)


@dataclass(frozen=True)
class SpeedTable(Table):
    """A tabulated speed density: linear between the points, zero outside them; isotropic.

    Parameters
    ----------
    speed : in U, rising, not negative, shape (n,), n >= 2
    density : per U; integral over the speed = 1 (within 1e-6; rescaled to it), shape (n,)

    Raises
    ------
    InputError : negative, NaN, unsorted, or not normalised
    """

    speed: ArrayLike
    density: ArrayLike

    def __post_init__(self) -> None:
        v = rising_speeds(self.speed)
        f = finite_array("density", self.density)
        if v.size != f.size:
            raise InputError(f"density: got {f.size} values for {v.size} speeds")
        density_not_negative(f)
        total = normalised(float(np.sum(0.5 * (f[1:] + f[:-1]) * np.diff(v))))
        self.store(speed=v, density=f / total)

    @classmethod
    def _from_storage(cls, parts: dict[str, Any]) -> SpeedTable:
        """As it was, and not rescaled once more."""
        found = object.__new__(cls)
        found.store(**parts)
        return found

    def _values(self, m: int) -> NDArray[Any] | None:
        return None if m else np.asarray(self.density)


@dataclass(frozen=True)
class SpeedSamples(Samples):
    """Speeds of particles, each of the same weight; isotropic.

    Parameters
    ----------
    speed : in U, above zero, shape (n,)

    Raises
    ------
    InputError : empty, NaN or not above zero
    """

    speed: ArrayLike

    def __post_init__(self) -> None:
        v = finite_array("speed", self.speed)
        if v.size == 0 or np.any(v <= 0.0):
            refuse("speed", self.speed, "samples must be above 0, at least 1")
        self.store(speed=v)


@dataclass(frozen=True)
class SpeedDensity(State):
    """A speed density given as a function of v/U that maps arrays to arrays; isotropic.

    Raises
    ------
    InputError : where it is used, if it is negative, NaN, not normalised (within 1e-6), or has no
        second moment
    """

    function: Callable[[Any], Any]
    smooth = True

    def harmonic(
        self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0
    ) -> LogMeasure | None:
        """Adaptive Gauss panels in ln v."""
        if m:
            return None
        # a tenth of the allowed error of the norm, so that its check sees the density
        found = quadrature.function(self.function, min(rtol, 1e-7), lowest, highest)
        if found is None:
            raise InputError(quadrature.NO_INTEGRAL)
        if np.iscomplexobj(found.weight):
            raise InputError("initial: the speed density is complex; it must be real")
        density_not_negative(found.weight)
        return LogMeasure(found.x, found.weight / normalised(float(found.weight.sum())))

    def profile(self, m: int) -> SpeedFunction | None:
        """The function itself."""
        return None if m else lambda v: quadrature.evaluate_density(self.function, v)


@dataclass(frozen=True)
class Rest(State):
    """All tracers start at rest: for scenes with a field."""

    lowest_moment = 0.0

    def harmonic(
        self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0
    ) -> LogMeasure | None:
        """Harmonic 0 is one point at the speed 0; all others are zero."""
        return None if m else LogMeasure(np.array([-np.inf]), np.ones(1))


NAMED: dict[str, State] = {"gaussian": Gaussian(), "monoenergetic": Monoenergetic()}


def as_state(initial: Any, name: str = "initial") -> State:
    """The state meant by a name, a function or a State; InputError that says what is allowed."""
    if isinstance(initial, State):
        return initial
    if isinstance(initial, str) and initial in NAMED:
        return NAMED[initial]
    if callable(initial):
        return SpeedDensity(initial)
    raise InputError(
        f"{name}: got {short(initial)}; it must be one of {', '.join(NAMED)}, a function of v "
        "or a state (SpeedTable, SpeedSamples, Beam, ...)"
    )
