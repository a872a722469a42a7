"""The initial states of the package, by how they are given: formulas, particles, tables, functions.

What a state must provide is said in `state.py`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.errors import InputError
from kinetics.numerics import LARGEST_LOG, ROUNDING, FloatArray
from kinetics.results.record import stored_class
from kinetics.states import state as rules
from kinetics.states.state import LogMeasure, Points, SpeedFunction, State
from kinetics.validation import (
    check_positive,
    finite_array,
    normalised,
    real_number,
    refuse,
    rising_from_zero,
    whole_number,
)

_FAR_BESSEL = 1e9  # scipy has no I(q) beyond; there exp(-q) I(q) is q^-1/2 to 1e-10
_LARGEST_RATIO = 1e4  # of two deviations
# Standard deviations beyond which a Gaussian is zero, and v^2 may overflow
_HIGHEST = 2.0 * math.sqrt(LARGEST_LOG)


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class Gaussian(State):
    """Independent Gaussian components of the velocity, in general of different deviations.

    deviation_x, deviation_y : standard deviations of v_x and v_y, in U, above zero; equal ones are
        the isotropic start of the paper
    dimension : 2; or 3, where all components have one deviation
    """

    deviation_x: float = 1.0
    deviation_y: float = 1.0
    dimension: int = 2
    _wide: float = field(init=False, repr=False, compare=False)
    _ratio: float = field(init=False, repr=False, compare=False)
    smooth = True

    def __post_init__(self) -> None:
        x = check_positive("deviation_x", self.deviation_x)
        y = check_positive("deviation_y", self.deviation_y)
        if not max(x, y) <= _LARGEST_RATIO * min(x, y):
            refuse("deviation_y", y, f"it must be within {_LARGEST_RATIO:g} of deviation_x, {x:g}")
        d = whole_number("dimension", self.dimension, 2, 2 if x != y else 3)
        self.store(deviation_x=x, deviation_y=y, dimension=d, lowest_moment=-float(d))
        self.store(highest_harmonic=0 if x == y else None)
        self.store(_wide=max(x, y), _ratio=max(x, y) / min(x, y))

    def in_space(self) -> State | None:
        """The Maxwell distribution of the same deviation, if both are equal."""
        return Gaussian(self.deviation_x, self.deviation_x, 3) if self._ratio == 1.0 else None

    def _factor(self, m: int, u: FloatArray) -> Any:
        """f_m over the density of components that all have the wider deviation D, at u = v/D.

        With the ratio a of the deviations, the angle gives a exp(-q) I_(m/2)(q), even m only.
        """
        if self._ratio == 1.0 or m % 2:
            return None if m else 1.0
        from scipy.special import ive

        a, order = self._ratio, m // 2
        q = 0.25 * (a - 1.0) * (a + 1.0) * u**2
        far = np.maximum(q / _FAR_BESSEL, 1.0)
        found = a * ive(order, q / far) / np.sqrt(far)
        return -found if order % 2 and self.deviation_y > self.deviation_x else found

    def harmonic(self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0) -> Points:
        """Trapezoid rule in ln v."""
        d = self.dimension
        found = rules.gaussian_points(rtol, lowest, highest, d, self._wide, self._ratio)
        factor = self._factor(m, np.exp(found.x) / self._wide)
        return None if factor is None else LogMeasure(found.x, found.weight * factor)

    def profile(self, m: int) -> SpeedFunction | None:
        """v exp(-v^2/2 D^2)/D^2, in space sqrt(2/pi) v^2 exp(-v^2/2 D^2)/D^3, times the factor."""
        norm = (1.0 if self.dimension == 2 else math.sqrt(2.0 / math.pi)) / self._wide

        def value(v: FloatArray) -> NDArray[Any]:
            u = np.minimum(v / self._wide, _HIGHEST)
            with np.errstate(under="ignore"):
                radial = norm * u ** (self.dimension - 1) * np.exp(-0.5 * u * u)
                return np.asarray(radial * self._factor(m, u))

        return None if self._factor(m, np.zeros(0)) is None else value


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class Rest(State):
    """All tracers start at rest: for scenes with a field."""

    lowest_moment = 0.0

    def harmonic(self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0) -> Points:
        """Harmonic 0 is one point at the speed 0; all others are zero."""
        return None if m else LogMeasure(np.array([-np.inf]), np.ones(1))


class Samples(State):
    """Particles of the same weight: a subclass gives their speeds, and angles to the x axis."""

    peaks: tuple[FloatArray, FloatArray]
    _angle: FloatArray | None

    def _place(self, speed: FloatArray, angle: FloatArray | None = None) -> None:
        """Store speeds (n,), and angles (n,) where the particles are directed."""
        self.store(peaks=(speed, np.full(speed.size, 1.0 / speed.size)), _angle=angle)

    def harmonic(self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0) -> Points:
        """The samples with weights exp(-i m phi)/n, many of them gathered on a fine grid."""
        speed, weight = self.peaks
        if m and self._angle is None:
            return None
        turn = np.exp(-1j * m * np.asarray(self._angle)) if m else 1.0
        return rules.samples_points(np.log(speed), weight * turn, rtol, max(highest, -lowest))


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class Monoenergetic(Samples):
    """All speeds equal, all directions."""

    speed: float = 1.0

    def __post_init__(self) -> None:
        self.store(speed=check_positive("speed", self.speed))
        self._place(np.array([self.speed]))


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class SpeedSamples(Samples):
    """Speeds of particles in U, above zero, shape (n,), each of the same weight; isotropic."""

    speed: ArrayLike

    def __post_init__(self) -> None:
        allowed = "samples must be above 0, at least 1"
        v = finite_array("speed", self.speed, allowed, math.ulp(0.0))
        if v.size == 0:
            refuse("speed", self.speed, allowed)
        self.store(speed=v)
        self._place(v)


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class VelocitySamples(Samples):
    """Velocities of particles, each of the same weight; directions are kept.

    velocity : (v_x, v_y) in U, shape (n, 2), none of them zero: at rest a tracer never collides
    """

    velocity: ArrayLike
    highest_harmonic = None

    def __post_init__(self) -> None:
        allowed = "it must be finite numbers of shape (n, 2), n >= 1, and no velocity zero"
        v = finite_array("velocity", self.velocity, allowed, dimensions=(2,))
        if v.size == 0 or v.shape[1] != 2 or not v.any(axis=1).all():
            refuse("velocity", self.velocity, allowed)
        self.store(velocity=v)
        self._place(np.hypot(*v.T), np.arctan2(v[:, 1], v[:, 0]))


class Table(State):
    """A state whose f_m are linear between rising speeds; a subclass gives them at these."""

    _columns: NDArray[Any]

    def _tabulate(self, v: FloatArray, columns: NDArray[Any], name: str) -> None:
        """Store f_m, column m, at the speeds v, shape (n_v, n_m), so that f_0 has the norm 1."""
        radial = columns[:, 0].real
        total = normalised(radial, float(np.trapezoid(radial, v)), name)
        # the first piece decides which negative powers exist, if it begins at speed 0
        lowest = -math.inf if v[0] > 0.0 else -1.0 if radial[0] > 0.0 else -2.0
        self.store(kinks=v, lowest_moment=lowest, highest_harmonic=columns.shape[1] - 1)
        self.store(_columns=columns / total)

    def _values(self, m: int) -> NDArray[Any] | None:
        """f_m at the speeds; None where it is zero to rounding."""
        if m >= self._columns.shape[1]:
            return None
        first, values = self._columns[:, 0].real, self._columns[:, m]
        zero = np.abs(values).max() < 10.0 * ROUNDING * first.max()  # of a Fourier transform
        return None if zero else (values if m else first)

    def harmonic(self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0) -> Points:
        """Gauss points on the linear pieces."""
        values = self._values(m)
        if values is None:
            return None
        found = rules.table_points(self.kinks, values, 0.1 * rtol, lowest)
        # ln v of points that are close to each other has lost digits: the sum may not be 1
        return LogMeasure(found.x, found.weight / found.weight.sum()) if m == 0 else found

    def profile(self, m: int) -> SpeedFunction | None:
        """Linear interpolation."""
        values = self._values(m)
        if values is None:
            return None
        return lambda v: np.interp(v, self.kinks, values, left=0.0, right=0.0)


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class SpeedTable(Table):
    """A tabulated speed density: linear between the points, zero outside them; isotropic.

    speed : in U, rising, not negative, shape (n,), n >= 2
    density : per U; integral over the speed = 1 (within 1e-6; used rescaled to it), shape (n,)
    """

    speed: ArrayLike
    density: ArrayLike

    def __post_init__(self) -> None:
        v, f = rising_from_zero("speed", self.speed), finite_array("density", self.density)
        if v.size != f.size:
            raise InputError(f"density: got {f.size} values for {v.size} speeds")
        self.store(speed=v, density=f)
        self._tabulate(v, f[:, None], "density")


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class PolarGrid(Table):
    """f(v, phi), a density in the velocity plane, on a polar grid.

    speed : in U, rising, not negative, shape (n_v,)
    values : f at (speed, 2 pi j/n_phi), not negative, shape (n_v, n_phi); linear in the speed,
        trigonometric in the angle; integral of f v dv dphi = 1 (within 1e-6; used rescaled to it)
    """

    speed: ArrayLike
    values: ArrayLike

    def __post_init__(self) -> None:
        v = rising_from_zero("speed", self.speed)
        allowed = f"it must be finite numbers, none negative, of shape ({v.size}, n_phi)"
        f = finite_array("values", self.values, allowed, 0.0, (2,))
        if f.shape[0] != v.size or f.shape[1] < 1:
            refuse("values", self.values, allowed)
        self.store(speed=v, values=f)
        found = np.fft.fft(f, axis=1) * (2.0 * math.pi / f.shape[1]) * v[:, None]
        self._tabulate(v, found[:, : (f.shape[1] + 1) // 2], "values")


class Functions(State):
    """A state whose f_m are functions of v; a subclass gives those that are not zero."""

    smooth = True
    terms: Mapping[int, Callable[[Any], Any]]

    def in_space(self) -> State:
        """The same functions, as coefficients of Legendre polynomials."""
        return self

    def harmonic(self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0) -> Points:
        """Adaptive Gauss panels in ln v; None for a function that is zero everywhere."""
        if m not in self.terms:
            return None
        # a tenth of the allowed error of the norm, so that its check sees the density
        tight = rtol if m else min(rtol, 1e-7)
        found = rules.function_points(self.terms[m], tight, lowest, highest)
        if m:
            return found
        if found is None:
            raise InputError(rules.NO_INTEGRAL)
        if np.iscomplexobj(found.weight):
            raise InputError("initial: the speed density is complex; it must be real")
        norm = normalised(found.weight, float(found.weight.sum()))
        return LogMeasure(found.x, found.weight / norm, found.error)

    def profile(self, m: int) -> SpeedFunction | None:
        """The function itself."""
        return (lambda v: rules.evaluate(self.terms[m], v)) if m in self.terms else None


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class SpeedDensity(Functions):
    """A speed density given as a function of v/U that maps arrays to arrays; isotropic.

    InputError where it is used, if it is negative, NaN, not normalised, or has no second moment.
    """

    function: Callable[[Any], Any]

    def __post_init__(self) -> None:
        self.store(terms={0: self.function})


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class AngularHarmonics(Functions):
    """f(v, phi) given by its angular harmonics; in space, f(v, theta) by Legendre polynomials.

    terms : m -> f_m(v), m >= 0, functions of v/U that map arrays to arrays, real or complex:
        f_m(v) = integral of exp(-i m phi) v f over phi, in space of P_m(cos theta) v^2 f over all
        directions; f_0 is the speed density
    """

    terms: Mapping[int, Callable[[Any], Any]]

    def __post_init__(self) -> None:
        if not isinstance(self.terms, Mapping) or not all(map(callable, self.terms.values())):
            refuse("terms", self.terms, "it must map orders to functions of v")
        orders = list(self.terms)
        whole = all(isinstance(m, int | np.integer) and not isinstance(m, bool) for m in orders)
        if not whole or 0 not in orders or min(orders) < 0:
            refuse("terms", orders, "orders must be whole, m >= 0, and m = 0 is needed")
        self.store(terms=dict(self.terms), highest_harmonic=int(max(orders)))


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class Beam(State):
    """All velocities in one direction.

    direction : angle phi_0 of the velocity to the x axis, in radians
    speeds : an isotropic state, or a name, whose speeds the beam has
    """

    direction: float = 0.0
    speeds: Any = "monoenergetic"
    highest_harmonic = None

    def __post_init__(self) -> None:
        speeds = as_state(self.speeds, "speeds")
        if speeds.highest_harmonic != 0:
            refuse("speeds", self.speeds, "it must be an isotropic state")
        direction = real_number("direction", self.direction, allowed="it must be a finite angle")
        self.store(speeds=speeds, direction=direction, smooth=speeds.smooth)
        self.store(lowest_moment=speeds.lowest_moment, peaks=speeds.peaks, kinks=speeds.kinks)

    def in_space(self) -> State | None:
        """The same along the x axis, the only axis that a scene in space has."""
        speeds = self.speeds.in_space()
        return Beam(0.0, speeds) if self.direction == 0.0 and speeds is not None else None

    def harmonic(self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0) -> Points:
        """The points of the speeds, with their weights times exp(-i m phi_0)."""
        found: LogMeasure = self.speeds.harmonic(0, rtol, lowest, highest)
        return LogMeasure(found.x, found.weight * self._turn(m), found.error)

    def profile(self, m: int) -> SpeedFunction | None:
        """The speed density times exp(-i m phi_0)."""
        profile: SpeedFunction | None = self.speeds.profile(0)
        return profile and (lambda v: np.asarray(self._turn(m) * profile(v)))

    def _turn(self, m: int) -> Any:
        return np.exp(-1j * m * self.direction) if m else 1.0


NAMED: dict[str, State] = {"gaussian": Gaussian(), "monoenergetic": Monoenergetic(), "rest": Rest()}


def as_state(initial: Any, name: str = "initial") -> State:
    """The state meant by a name, a function or a State; InputError that says what is allowed."""
    if isinstance(initial, State):
        return initial
    if isinstance(initial, str) and initial in NAMED:
        return NAMED[initial]
    if callable(initial):
        return SpeedDensity(initial)
    allowed = "a function of v or a state (SpeedTable, SpeedSamples, Beam, ...)"
    refuse(name, initial, f"it must be one of {', '.join(NAMED)}, {allowed}")
