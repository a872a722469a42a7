"""Initial states: what a Scene may start from. Directed ones are in `directed.py`.

A state answers two questions. ``harmonic(m, ...)`` gives the angular harmonic

    f_m(v) = integral of exp(-i m phi) v f(v, phi) over phi

as weighted points (:mod:`kinetics.states.quadrature`); f_0 is the speed density. ``profile(m)``
gives it as a function of v where it is one, for the solvers that need one; None where it is
singular.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.errors import InputError, check_positive, short
from kinetics.states import quadrature as measure
from kinetics.states.quadrature import LogMeasure

FloatArray = NDArray[np.float64]
Profile = Callable[[FloatArray], NDArray[Any]]

_FAR_BESSEL = 3e4  # root of q from which exp(-q) I(q) is its asymptotic series
_NORM = 1e-6  # how far the integral of a given density may be from 1; it is rescaled to 1


class State:
    """An initial state.

    Attributes
    ----------
    highest_harmonic : largest m that is not zero; None where they do not end
    smooth : whether its densities are smooth in ln v
    lowest_moment : <v^p> exists for p above it
    """

    highest_harmonic: int | None = 0
    smooth: bool = False
    lowest_moment: float = -math.inf

    @property
    def peaks(self) -> tuple[FloatArray, FloatArray] | None:
        """Speeds of delta peaks and their shares, (n,) each; None for densities."""
        return None

    @property
    def kinks(self) -> FloatArray:
        """Speeds where the density is not smooth, (n,)."""
        return np.empty(0)

    def harmonic(
        self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0
    ) -> LogMeasure | None:
        """f_m as weighted points that give averages to about rtol; None where it is zero.

        ``lowest`` and ``highest`` are the powers of the speed that will be averaged.
        """
        raise NotImplementedError

    def profile(self, m: int) -> Profile | None:
        """f_m as a function of v/U; None where it is no function (delta peaks, samples)."""
        return None


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

    def __post_init__(self) -> None:
        object.__setattr__(self, "deviation_x", check_positive("deviation_x", self.deviation_x))
        object.__setattr__(self, "deviation_y", check_positive("deviation_y", self.deviation_y))

    smooth = True
    lowest_moment = -2.0

    @property
    def highest_harmonic(self) -> int | None:  # type: ignore[override]
        """0 where the deviations are equal."""
        return 0 if self.deviation_x == self.deviation_y else None

    @property
    def _wide(self) -> float:
        return max(self.deviation_x, self.deviation_y)

    @property
    def _ratio(self) -> float:
        """Of the wider deviation to the other."""
        return self._wide / min(self.deviation_x, self.deviation_y)

    def _factor(self, m: int) -> Callable[[Any], Any] | None:
        """f_m over the density of an isotropic Gaussian of the wider deviation D, at v/D.

        With the ratio a of the deviations, the angle gives a exp(-q) I_(m/2)(q), even m only, of
        q = (a^2 - 1) v^2/4: the inverse squares of the deviations differ by that much.
        """
        if self.deviation_x == self.deviation_y:
            return None
        ratio, order = self._ratio, m // 2
        half = 0.5 * math.sqrt((1.0 - 1.0 / ratio) * (1.0 + 1.0 / ratio))
        sign = -1.0 if order % 2 and self.deviation_y > self.deviation_x else 1.0

        def factor(v: Any) -> Any:
            from scipy.special import ive

            # sqrt(q)/a: q itself may overflow
            root = half * np.asarray(v)
            far = root > _FAR_BESSEL / ratio
            q = (ratio * np.where(far, 0.0, root)) ** 2
            beyond = 1.0 / np.where(far, root, 1.0)
            small = (0.5 * beyond / ratio) ** 2  # 1/(4 q)
            series = 1.0 - (2 * order**2 - 0.5) * small * (1.0 - (order**2 - 2.25) * small)
            beyond = beyond * series / math.sqrt(2.0 * math.pi)
            return sign * np.where(far, beyond, ratio * ive(order, q))

        return factor

    def harmonic(
        self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0
    ) -> LogMeasure | None:
        """Trapezoid rule in ln v; odd harmonics vanish."""
        m = abs(m)
        if (m and self.highest_harmonic == 0) or m % 2:
            return None
        factor = self._factor(m)
        return measure.gaussian(rtol, lowest, highest, self._wide, factor, self._ratio)

    def profile(self, m: int) -> Profile | None:
        """v exp(-v^2/2 D^2)/D^2 times the Bessel factor."""
        m = abs(m)
        if (m and self.highest_harmonic == 0) or m % 2:
            return None
        wide, factor = self._wide, self._factor(m)

        def value(v: FloatArray) -> NDArray[Any]:
            u = np.minimum(v, 100.0 * wide) / wide  # beyond, nothing is left
            with np.errstate(under="ignore"):
                f = u / wide * np.exp(-0.5 * u * u)
            return f if factor is None else np.asarray(f * factor(u))

        return value


@dataclass(frozen=True)
class Monoenergetic(State):
    """All speeds equal, all directions."""

    speed: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "speed", check_positive("speed", self.speed))

    def harmonic(
        self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0
    ) -> LogMeasure | None:
        """One point."""
        return LogMeasure(np.array([math.log(self.speed)]), np.ones(1)) if m == 0 else None

    @property
    def peaks(self) -> tuple[FloatArray, FloatArray]:
        """One."""
        return np.array([self.speed]), np.ones(1)


@dataclass(frozen=True)
class SpeedTable(State):
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
        v = rising(self.speed)
        f = column("density", self.density)
        if v.size != f.size:
            raise InputError(f"density: got {f.size} values for {v.size} speeds")
        not_negative(f)
        total = check_norm(float(np.sum(0.5 * (f[1:] + f[:-1]) * np.diff(v))))
        object.__setattr__(self, "speed", v)
        object.__setattr__(self, "density", f / total)

    def harmonic(
        self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0
    ) -> LogMeasure | None:
        """Gauss points on the linear pieces."""
        if m:
            return None
        speed, density = np.asarray(self.speed), np.asarray(self.density)
        found = measure.table(speed, density, 0.1 * rtol, lowest)
        # knots that are close lose digits in ln v
        return LogMeasure(found.x, found.weight / found.weight.sum())

    @property
    def lowest_moment(self) -> float:  # type: ignore[override]
        """From the first piece, if that begins at speed 0."""
        speed, density = np.asarray(self.speed), np.asarray(self.density)
        if speed[0] > 0.0:
            return -math.inf
        return -1.0 if density[0] > 0.0 else -2.0

    def profile(self, m: int) -> Profile | None:
        """Linear interpolation."""
        if m:
            return None
        speed, values = np.asarray(self.speed), np.asarray(self.density)
        return lambda v: np.asarray(np.interp(v, speed, values, left=0.0, right=0.0))

    @property
    def kinks(self) -> FloatArray:
        """The points of the table."""
        return np.asarray(self.speed)


@dataclass(frozen=True)
class SpeedSamples(State):
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
        v = column("speed", self.speed)
        if v.size == 0 or np.any(v <= 0.0):
            raise InputError(f"speed: got {short(self.speed)}; samples must be above 0, at least 1")
        object.__setattr__(self, "speed", v)

    def harmonic(
        self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0
    ) -> LogMeasure | None:
        """The samples, many of them gathered on a fine grid."""
        if m:
            return None
        x = np.log(np.asarray(self.speed))
        return measure.samples(x, np.full(x.size, 1.0 / x.size))

    @property
    def peaks(self) -> tuple[FloatArray, FloatArray]:
        """Every sample."""
        speed = np.asarray(self.speed)
        return speed, np.full(speed.size, 1.0 / speed.size)


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
        found = measure.function(self.function, min(rtol, 1e-7), lowest, highest)
        if np.iscomplexobj(found.weight):
            raise InputError("initial: the speed density is complex; it must be real")
        not_negative(found.weight)
        return LogMeasure(found.x, found.weight / check_norm(float(found.weight.sum())))

    def profile(self, m: int) -> Profile | None:
        """The function itself."""
        return None if m else lambda v: measure.evaluate_density(self.function, v)


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


def column(name: str, values: ArrayLike) -> FloatArray:
    """A finite 1-dimensional float array; InputError that names it otherwise."""
    try:
        array = np.asarray(values)
        if array.dtype.kind == "c":
            raise TypeError
        array = array.astype(float)
    except (TypeError, ValueError):
        raise InputError(f"{name}: got {short(values)}; it must be an array of numbers") from None
    if array.ndim != 1 or not np.all(np.isfinite(array)):
        raise InputError(f"{name}: got {short(values)}; it must be 1-dimensional and finite")
    return array


def rising(speed: ArrayLike) -> FloatArray:
    """Speeds that rise from 0 or more, at least two; InputError otherwise."""
    v = column("speed", speed)
    if v.size < 2 or np.any(np.diff(v) <= 0.0) or v[0] < 0.0:
        raise InputError(f"speed: got {short(speed)}; it must rise, from 0 or more, 2 at least")
    return v


def not_negative(f: NDArray[Any], name: str = "density") -> None:
    """InputError where a density is negative."""
    if f.size and float(f.min()) < 0.0:
        raise InputError(f"{name}: got a value of {f.min():.3g}; it must not be negative")


def check_norm(total: float, name: str = "density") -> float:
    """The norm if it is 1 within 1e-6; InputError otherwise."""
    if not abs(total - 1.0) < _NORM:
        narrow = "; a peak narrower than a percent needs a SpeedTable" if total < 0.5 else ""
        raise InputError(
            f"{name}: its integral over the velocities is {total:.6g}; it must be 1{narrow}"
        )
    return total
