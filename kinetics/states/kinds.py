"""The initial states of the package, by how they are given: formulas, particles, tables, functions.

What a state must provide is said in `state.py`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from kinetics.errors import InputError, suggestion
from kinetics.numerics import LARGEST_LOG, ROUNDING, FloatArray, NumberArray
from kinetics.results.record import stored_class
from kinetics.states.density_scan import NO_INTEGRAL
from kinetics.states.function_points import UserFunction, evaluate_density, function_points
from kinetics.states.points import gaussian_points, samples_points, table_points
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

#: Argument q beyond which scipy has no exp(-q) I(q); there it is q^-1/2 to 1e-10. Chosen.
LARGEST_BESSEL_ARGUMENT = 1e9
#: Largest ratio of the two deviations of a Gaussian. Chosen: far beyond any experiment.
MAX_DEVIATION_RATIO = 1e4
#: Standard deviations beyond which a Gaussian is zero, and v^2 may overflow. Derived: exp(-x^2/2)
#: underflows before x = sqrt(2 LARGEST_LOG), and this is sqrt(2) times that.
ZERO_BEYOND = 2.0 * math.sqrt(LARGEST_LOG)
#: A harmonic of a table is zero below so many roundings of f_0: those of a Fourier transform.
#: Origin not recorded.
TABLE_ROUNDINGS = 10.0
#: rtol of a table's points over that of averages. Chosen: a tenth adds little to the error.
RTOL_SHARE_OF_TABLE = 0.1
#: Largest rtol for a speed density. Chosen: far below the norms that are looked at closer. Measured
#: on a Gaussian and on a step: it takes no longer than 1e-7.
MAX_RTOL_OF_NORM = 1e-10
#: What the norm of a speed density may be off before narrow peaks are looked for. Chosen: above
#: MAX_RTOL_OF_NORM, and what rare tracers so few add to <v^2> is small unless they are very fast.
MIN_MISSING_MASS = 1e-9


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class Gaussian(State):
    """Independent Gaussian components of the velocity, in general of different deviations.

    Parameters
    ----------
    deviation_x, deviation_y : standard deviations of v_x and v_y, in U, above zero. One alone is
        that of all components, the isotropic start of the paper
    dimension : 2; or 3, where all components have one deviation
    """

    deviation_x: float = 1.0
    deviation_y: float | None = None
    dimension: int = 2
    smooth = True

    def __post_init__(self) -> None:
        x = check_positive("deviation_x", self.deviation_x)
        y = x
        if self.deviation_y is not None:
            y = check_positive("deviation_y", self.deviation_y)
        if not max(x, y) <= MAX_DEVIATION_RATIO * min(x, y):
            allowed = f"it must be within {MAX_DEVIATION_RATIO:g} of deviation_x, {x:g}"
            refuse("deviation_y", y, allowed)
        is_isotropic = x == y
        dimension = whole_number("dimension", self.dimension, 2, 3 if is_isotropic else 2)
        self.store(deviation_x=x, deviation_y=y, dimension=dimension)
        self.store(lowest_moment=-float(dimension), highest_harmonic=0 if is_isotropic else None)

    def __repr__(self) -> str:
        if self._deviation_ratio == 1.0 and self.dimension == 2:
            deviation = "" if self.deviation_x == 1.0 else f"deviation_x={self.deviation_x!r}"
            return f"Gaussian({deviation})"
        return super().__repr__()

    @property
    def _deviations(self) -> tuple[float, float]:
        """The standard deviations of v_x and v_y in U."""
        assert self.deviation_y is not None  # since __post_init__
        return self.deviation_x, self.deviation_y

    @property
    def _wider(self) -> float:
        """D, the larger deviation in U."""
        return max(self._deviations)

    @property
    def _deviation_ratio(self) -> float:
        """a, the larger deviation over the smaller one."""
        return self._wider / min(self._deviations)

    def in_space(self) -> State | None:
        """Return the Maxwell distribution of the same deviation, if both are equal."""
        if self._deviation_ratio != 1.0:
            return None
        return Gaussian(self.deviation_x, self.deviation_x, 3)

    def _has_harmonic(self, m: int) -> bool:
        """Return whether f_m is not zero."""
        if self._deviation_ratio == 1.0:
            return m == 0
        return m % 2 == 0

    def _factor(self, m: int, u: FloatArray) -> FloatArray | float:
        """Return f_m over the density of components that all have the deviation D, at u = v/D.

        The angle gives a exp(-q) I_(m/2)(q), q = (a^2 - 1) u^2/4, with the sign (-1)^(m/2) if v_y
        has the larger deviation; m is even.
        """
        a = self._deviation_ratio
        if a == 1.0:
            return 1.0
        from scipy.special import ive

        order = m // 2
        q = 0.25 * (a - 1.0) * (a + 1.0) * u**2
        beyond = np.maximum(q / LARGEST_BESSEL_ARGUMENT, 1.0)
        factor: FloatArray = a * ive(order, q / beyond) / np.sqrt(beyond)
        deviation_x, deviation_y = self._deviations
        is_negative = order % 2 == 1 and deviation_y > deviation_x
        return -factor if is_negative else factor

    def harmonic(self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0) -> Points:
        """Return points of the trapezoid rule in ln v."""
        if not self._has_harmonic(m):
            return None
        points = gaussian_points(
            rtol, lowest, highest, self.dimension, self._wider, self._deviation_ratio
        )
        factor = self._factor(m, np.exp(points.x) / self._wider)
        return LogMeasure(points.x, points.weight * factor)

    def profile(self, m: int) -> SpeedFunction | None:
        """Return the density of components that all have the deviation D, times `_factor`.

        It is v exp(-v^2/2 D^2)/D^2, in space sqrt(2/pi) v^2 exp(-v^2/2 D^2)/D^3.
        """
        if not self._has_harmonic(m):
            return None
        norm = 1.0 / self._wider
        if self.dimension == 3:
            norm = math.sqrt(2.0 / math.pi) / self._wider

        def density(v: FloatArray) -> NumberArray:
            u = np.minimum(v / self._wider, ZERO_BEYOND)
            with np.errstate(under="ignore"):
                radial = norm * u ** (self.dimension - 1) * np.exp(-0.5 * u * u)
                return np.asarray(radial * self._factor(m, u))

        return density


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class Rest(State):
    """All tracers start at rest: for scenes with a field."""

    lowest_moment = 0.0

    def harmonic(self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0) -> Points:
        """Return one point at the speed 0; harmonics m > 0 are zero."""
        if m > 0:
            return None
        return LogMeasure(np.array([-np.inf]), np.ones(1))


class SampledState(State):
    """Particles of the same weight: a subclass gives their speeds, and angles to the x axis."""

    peaks: tuple[FloatArray, FloatArray]
    _angle: FloatArray | None

    def _place(self, speed: FloatArray, angle: FloatArray | None = None) -> None:
        """Store speeds (n,), and angles (n,) where the particles are directed."""
        equal_shares = np.full(speed.size, 1.0 / speed.size)
        self.store(peaks=(speed, equal_shares), _angle=angle)

    def harmonic(self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0) -> Points:
        """Return the samples with weights exp(-i m phi)/n, many of them gathered on a fine grid."""
        speed, share = self.peaks
        weight: NumberArray = share
        if m > 0:
            if self._angle is None:
                return None
            weight = share * np.exp(-1j * m * self._angle)
        return samples_points(np.log(speed), weight, rtol, max(highest, -lowest))


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class Monoenergetic(SampledState):
    """All speeds equal, all directions."""

    speed: float = 1.0

    def __post_init__(self) -> None:
        self.store(speed=check_positive("speed", self.speed))
        self._place(np.array([self.speed]))


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class SpeedSamples(SampledState):
    """Speeds of particles in U, above zero, shape (n,), each of the same weight; isotropic."""

    speed: ArrayLike

    def __post_init__(self) -> None:
        allowed = "samples must be above 0, at least 1"
        speed = finite_array("speed", self.speed, allowed, math.ulp(0.0))
        if speed.size == 0:
            refuse("speed", self.speed, allowed)
        self.store(speed=speed)
        self._place(speed)


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class VelocitySamples(SampledState):
    """Velocities of particles, each of the same weight; directions are kept.

    Parameters
    ----------
    velocity : (v_x, v_y) in U, shape (n, 2), none of them zero: at rest a tracer never collides
    """

    velocity: ArrayLike
    highest_harmonic = None

    def __post_init__(self) -> None:
        allowed = "it must be finite numbers of shape (n, 2), n >= 1, and no velocity zero"
        velocity = finite_array("velocity", self.velocity, allowed, dimensions=(2,))
        has_shape = velocity.size > 0 and velocity.shape[1] == 2
        if not has_shape or not velocity.any(axis=1).all():
            refuse("velocity", self.velocity, allowed)
        self.store(velocity=velocity)
        v_x = velocity[:, 0]
        v_y = velocity[:, 1]
        self._place(np.hypot(v_x, v_y), np.arctan2(v_y, v_x))


class TabulatedState(State):
    """A state whose f_m are linear between rising speeds; a subclass gives them at these."""

    _columns: NumberArray

    def _tabulate(self, v: FloatArray, columns: NumberArray, name: str) -> None:
        """Store f_m, column m, at the speeds v, shape (n_v, n_m), so that f_0 has the norm 1."""
        speed_density = columns[:, 0].real
        integral = float(np.trapezoid(speed_density, v))
        norm = normalised(speed_density, integral, name)
        # the first piece decides which negative powers exist, if it begins at speed 0
        if v[0] > 0.0:
            lowest_moment = -math.inf
        elif speed_density[0] > 0.0:
            lowest_moment = -1.0
        else:
            lowest_moment = -2.0
        self.store(kinks=v, lowest_moment=lowest_moment, highest_harmonic=columns.shape[1] - 1)
        self.store(_columns=columns / norm)

    def _values(self, m: int) -> NumberArray | None:
        """Return f_m at the speeds; None where it is zero to rounding."""
        if m >= self._columns.shape[1]:
            return None
        speed_density = self._columns[:, 0].real
        values = speed_density if m == 0 else self._columns[:, m]
        rounding = TABLE_ROUNDINGS * ROUNDING * speed_density.max()
        if np.abs(values).max() < rounding:
            return None
        return values

    def harmonic(self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0) -> Points:
        """Return Gauss points on the linear pieces."""
        values = self._values(m)
        if values is None:
            return None
        points = table_points(self.kinks, values, RTOL_SHARE_OF_TABLE * rtol, lowest, highest)
        if m > 0:
            return points
        # ln v of points that are close to each other has lost digits: the sum may not be 1
        return LogMeasure(points.x, points.weight / points.weight.sum())

    def profile(self, m: int) -> SpeedFunction | None:
        """Return f_m by linear interpolation."""
        values = self._values(m)
        if values is None:
            return None
        return lambda v: np.asarray(np.interp(v, self.kinks, values, left=0.0, right=0.0))


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class SpeedTable(TabulatedState):
    """A tabulated speed density: linear between the points, zero outside them; isotropic.

    Parameters
    ----------
    speed : in U, rising, not negative, shape (n,), n >= 2
    density : per U; integral over the speed = 1 (within 1e-6; used rescaled to it), shape (n,)
    """

    speed: ArrayLike
    density: ArrayLike

    def __post_init__(self) -> None:
        speed = rising_from_zero("speed", self.speed)
        density = finite_array("density", self.density)
        if speed.size != density.size:
            raise InputError(f"density: got {density.size} values for {speed.size} speeds")
        self.store(speed=speed, density=density)
        self._tabulate(speed, density[:, None], "density")


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class PolarGrid(TabulatedState):
    """f(v, phi), a density in the velocity plane, on a polar grid.

    Parameters
    ----------
    speed : in U, rising, not negative, shape (n_v,)
    values : f at (speed, 2 pi j/n_phi), not negative, shape (n_v, n_phi); linear in the speed,
        trigonometric in the angle; integral of f v dv dphi = 1 (within 1e-6; used rescaled to it)
    """

    speed: ArrayLike
    values: ArrayLike

    def __post_init__(self) -> None:
        speed = rising_from_zero("speed", self.speed)
        allowed = f"it must be finite numbers, none negative, of shape ({speed.size}, n_phi)"
        f = finite_array("values", self.values, allowed, 0.0, (2,))
        n_phi = f.shape[1]
        if f.shape[0] != speed.size or n_phi < 1:
            refuse("values", self.values, allowed)
        self.store(speed=speed, values=f)
        harmonics = np.fft.fft(f, axis=1) * (2.0 * math.pi / n_phi) * speed[:, None]
        n_resolved = (n_phi + 1) // 2
        self._tabulate(speed, harmonics[:, :n_resolved], "values")


class FunctionState(State):
    """A state whose f_m are functions of v; a subclass gives those that are not zero."""

    smooth = True
    terms: Mapping[int, UserFunction]

    def in_space(self) -> State:
        """Return the same functions, as coefficients of Legendre polynomials."""
        return self

    def harmonic(self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0) -> Points:
        """Return points of adaptive Gauss panels in ln v; None for a function that is zero.

        Raises
        ------
        InputError : f_0 is no density: it is complex, negative, NaN, or not normalised
        """
        if m not in self.terms:
            return None
        if m == 0:
            rtol = min(rtol, MAX_RTOL_OF_NORM)
        points = function_points(
            self.terms[m], rtol, lowest, highest, has_narrow_peaks=self._has_narrow_peaks
        )
        if m > 0:
            return points
        if points is None:
            raise InputError(NO_INTEGRAL)
        if np.iscomplexobj(points.weight):
            raise InputError("initial: the speed density is complex; it must be real")
        norm = normalised(points.weight, float(points.weight.sum()))
        return LogMeasure(points.x, points.weight / norm, points.error)

    @cached_property
    def _has_narrow_peaks(self) -> bool:
        """Whether the usual scan misses some of the mass, which narrow peaks may hold."""
        points = function_points(self.terms[0], MAX_RTOL_OF_NORM, 0.0, 2.0)
        if points is None:
            return True
        return bool(abs(points.weight.sum() - 1.0) > MIN_MISSING_MASS)

    def profile(self, m: int) -> SpeedFunction | None:
        """Return the function itself."""
        if m not in self.terms:
            return None
        return lambda v: evaluate_density(self.terms[m], v)


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class SpeedDensity(FunctionState):
    """A speed density given as a function of v/U that maps arrays to arrays; isotropic.

    InputError where it is used, if it is negative, NaN, not normalised, or has no second moment.
    """

    function: UserFunction

    def __post_init__(self) -> None:
        self.store(terms={0: self.function})


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class AngularHarmonics(FunctionState):
    """f(v, phi) given by its angular harmonics; in space, f(v, theta) by Legendre polynomials.

    Parameters
    ----------
    terms : m -> f_m(v), m >= 0, functions of v/U that map arrays to arrays, real or complex:
        f_m(v) = integral of exp(-i m phi) v f over phi, in space of P_m(cos theta) v^2 f over all
        directions; f_0 is the speed density
    """

    terms: Mapping[int, UserFunction]

    def __post_init__(self) -> None:
        if not isinstance(self.terms, Mapping) or not all(map(callable, self.terms.values())):
            refuse("terms", self.terms, "it must map orders to functions of v")
        orders = list(self.terms)
        are_whole = True
        for m in orders:
            is_whole = isinstance(m, int | np.integer) and not isinstance(m, bool)
            are_whole = are_whole and is_whole
        if not are_whole or 0 not in orders or min(orders) < 0:
            refuse("terms", orders, "orders must be whole, m >= 0, and m = 0 is needed")
        self.store(terms=dict(self.terms), highest_harmonic=int(max(orders)))


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class Beam(State):
    """All velocities in one direction.

    Parameters
    ----------
    direction : angle phi_0 of the velocity to the x axis, in radians
    speeds : an isotropic state, or a name, whose speeds the beam has
    """

    direction: float = 0.0
    speeds: State | UserFunction | str = "monoenergetic"
    highest_harmonic = None

    def __post_init__(self) -> None:
        speeds = as_state(self.speeds, "speeds")
        if speeds.highest_harmonic != 0:
            refuse("speeds", self.speeds, "it must be an isotropic state")
        direction = real_number("direction", self.direction, allowed="it must be a finite angle")
        self.store(speeds=speeds, direction=direction, smooth=speeds.smooth)
        self.store(lowest_moment=speeds.lowest_moment, peaks=speeds.peaks, kinks=speeds.kinks)

    @property
    def _speed_state(self) -> State:
        """The isotropic state whose speeds the beam has."""
        assert isinstance(self.speeds, State)  # since the check of the arguments
        return self.speeds

    def in_space(self) -> State | None:
        """Return the same along the x axis, the only axis that a scene in space has."""
        speeds = self._speed_state.in_space()
        if self.direction != 0.0 or speeds is None:
            return None
        return Beam(0.0, speeds)

    def harmonic(self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0) -> Points:
        """Return the points of the speeds, with their weights times exp(-i m phi_0)."""
        points = self._speed_state.harmonic(0, rtol, lowest, highest)
        assert points is not None  # harmonic 0 is the speed density
        return LogMeasure(points.x, points.weight * self._phase(m), points.error)

    def profile(self, m: int) -> SpeedFunction | None:
        """Return the speed density times exp(-i m phi_0)."""
        speed_density = self._speed_state.profile(0)
        if speed_density is None:
            return None
        return lambda v: np.asarray(self._phase(m) * speed_density(v))

    def _phase(self, m: int) -> complex | float:
        """Return exp(-i m phi_0), a real number for m = 0."""
        if m == 0:
            return 1.0
        return complex(np.exp(-1j * m * self.direction))


#: The states that have names, by these.
NAMED: dict[str, State] = {"gaussian": Gaussian(), "monoenergetic": Monoenergetic(), "rest": Rest()}


def as_state(initial: object, name: str = "initial") -> State:
    """Return the state meant by a name, a function or a State.

    Parameters
    ----------
    initial : one of these
    name : of the argument, for messages

    Raises
    ------
    InputError : it is something else; says what is allowed
    """
    if isinstance(initial, State):
        return initial
    if isinstance(initial, str) and initial in NAMED:
        return NAMED[initial]
    if callable(initial):
        return SpeedDensity(initial)
    allowed = "a function of v or a state (SpeedTable, SpeedSamples, Beam, ...)"
    near = suggestion(initial, NAMED) if isinstance(initial, str) else ""
    refuse(name, initial, f"it must be one of {', '.join(NAMED)}, {allowed}{near}")
