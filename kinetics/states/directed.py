"""Directed initial states: beams, angular harmonics, polar grids, samples of velocities."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.errors import InputError, short
from kinetics.states import quadrature as measure
from kinetics.states.isotropic import (
    Profile,
    SpeedDensity,
    State,
    as_state,
    check_norm,
    not_negative,
    rising,
)
from kinetics.states.quadrature import LogMeasure

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class VelocitySamples(State):
    """Velocities of particles, each of the same weight; directions are kept.

    Parameters
    ----------
    velocity : (v_x, v_y) in U, shape (n, 2), none of them zero

    Raises
    ------
    InputError : of another shape, NaN, or a velocity that is zero
    """

    velocity: ArrayLike
    highest_harmonic = None

    def __post_init__(self) -> None:
        try:
            v = np.asarray(self.velocity, dtype=float)
        except (TypeError, ValueError):
            v = np.empty(0)
        if v.ndim != 2 or v.shape[1] != 2 or v.shape[0] == 0 or not np.all(np.isfinite(v)):
            raise InputError(
                f"velocity: got {short(self.velocity)}; it must be finite, of shape (n, 2)"
            )
        if np.any(np.hypot(v[:, 0], v[:, 1]) == 0.0):
            raise InputError("velocity: got a velocity of 0; a tracer at rest never collides")
        object.__setattr__(self, "velocity", v)

    def harmonic(
        self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0
    ) -> LogMeasure | None:
        """The samples with weights exp(-i m phi)/n."""
        v = np.asarray(self.velocity)
        x = np.log(np.hypot(v[:, 0], v[:, 1]))
        phase = np.exp(-1j * m * np.arctan2(v[:, 1], v[:, 0])) if m else np.ones(x.size)
        return measure.samples(x, phase / x.size)

    @property
    def peaks(self) -> tuple[FloatArray, FloatArray]:
        """The speed of every sample."""
        v = np.asarray(self.velocity)
        return np.hypot(v[:, 0], v[:, 1]), np.full(v.shape[0], 1.0 / v.shape[0])


@dataclass(frozen=True)
class Beam(State):
    """All velocities in one direction.

    Parameters
    ----------
    direction : angle phi_0 of the velocity to the x axis, in radians
    speeds : an isotropic state, or a name, whose speeds the beam has
    """

    direction: float = 0.0
    speeds: Any = "monoenergetic"
    highest_harmonic = None

    def __post_init__(self) -> None:
        speeds = as_state(self.speeds, "speeds")
        if speeds.highest_harmonic != 0:
            raise InputError(f"speeds: got {short(self.speeds)}; it must be an isotropic state")
        if not isinstance(self.direction, int | float) or not math.isfinite(self.direction):
            raise InputError(f"direction: got {short(self.direction)}; it must be a finite angle")
        object.__setattr__(self, "speeds", speeds)

    @property
    def smooth(self) -> bool:  # type: ignore[override]
        """Whether the speeds are."""
        return bool(self.speeds.smooth)

    @property
    def lowest_moment(self) -> float:  # type: ignore[override]
        """That of the speeds."""
        return float(self.speeds.lowest_moment)

    @property
    def peaks(self) -> tuple[FloatArray, FloatArray] | None:
        """Those of the speeds."""
        found: tuple[FloatArray, FloatArray] | None = self.speeds.peaks
        return found

    @property
    def kinks(self) -> FloatArray:
        """Those of the speeds."""
        return np.asarray(self.speeds.kinks)

    def harmonic(
        self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0
    ) -> LogMeasure | None:
        """The speeds with the weight exp(-i m phi_0)."""
        found = self.speeds.harmonic(0, rtol, lowest, highest)
        if m == 0:
            return found
        return LogMeasure(found.x, found.weight * np.exp(-1j * m * self.direction))

    def profile(self, m: int) -> Profile | None:
        """That of the speeds, turned."""
        profile = self.speeds.profile(0)
        if profile is None or m == 0:
            return profile
        turn = np.exp(-1j * m * self.direction)
        return lambda v: np.asarray(turn * profile(v))


@dataclass(frozen=True)
class AngularHarmonics(State):
    """f(v, phi) given by its angular harmonics.

    Parameters
    ----------
    terms : m -> f_m(v), m >= 0, functions of v/U that map arrays to arrays, real or complex:
        f_m(v) = integral of exp(-i m phi) v f over phi; f_0 is the speed density

    Raises
    ------
    InputError : no m = 0, a negative or fractional m; where they are used, as for SpeedDensity
    """

    terms: Mapping[int, Callable[[Any], Any]]
    smooth = True

    def __post_init__(self) -> None:
        if not isinstance(self.terms, Mapping) or not all(map(callable, self.terms.values())):
            raise InputError(
                f"terms: got {short(self.terms)}; it must map orders to functions of v"
            )
        orders = list(self.terms)
        whole = all(isinstance(m, int | np.integer) and not isinstance(m, bool) for m in orders)
        if not whole or 0 not in orders or min(orders) < 0:
            raise InputError(
                f"terms: got orders {short(orders)}; whole m >= 0, and m = 0 is needed"
            )

    @property
    def highest_harmonic(self) -> int | None:  # type: ignore[override]
        """The largest m given."""
        return max(int(m) for m in self.terms)

    def harmonic(
        self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0
    ) -> LogMeasure | None:
        """Adaptive Gauss panels in ln v."""
        if m == 0:
            return SpeedDensity(self.terms[0]).harmonic(0, rtol, lowest, highest)
        return measure.function(self.terms[m], rtol, lowest, highest) if m in self.terms else None

    def profile(self, m: int) -> Profile | None:
        """The function itself."""
        if m not in self.terms:
            return None
        return lambda v: measure.evaluate_density(self.terms[m], v)


@dataclass(frozen=True)
class PolarGrid(State):
    """f(v, phi), a density in the velocity plane, on a polar grid.

    Parameters
    ----------
    speed : in U, rising, not negative, shape (n_v,)
    values : f at (speed, 2 pi j/n_phi), not negative, shape (n_v, n_phi); linear in the speed,
        trigonometric in the angle; integral of f v dv dphi = 1 (within 1e-6; rescaled to it)

    Raises
    ------
    InputError : negative, NaN, of another shape, unsorted, or not normalised
    """

    speed: ArrayLike
    values: ArrayLike

    def __post_init__(self) -> None:
        v = rising(self.speed)
        allowed = f"it must be finite, of shape ({v.size}, n_phi)"
        try:
            f = np.asarray(self.values, dtype=float)
        except (TypeError, ValueError):
            raise InputError(f"values: got {short(self.values)}; {allowed}") from None
        if f.ndim != 2 or f.shape[0] != v.size or f.shape[1] < 1 or not np.all(np.isfinite(f)):
            raise InputError(f"values: got shape {f.shape}, or not finite; {allowed}")
        not_negative(f, "values")
        spectrum = np.fft.fft(f, axis=1) * (2.0 * math.pi / f.shape[1]) * v[:, None]
        radial = spectrum[:, 0].real
        total = check_norm(float(np.sum(0.5 * (radial[1:] + radial[:-1]) * np.diff(v))), "values")
        object.__setattr__(self, "speed", v)
        object.__setattr__(self, "values", spectrum / total)

    @property
    def highest_harmonic(self) -> int | None:  # type: ignore[override]
        """What the angles resolve."""
        return (np.asarray(self.values).shape[1] - 1) // 2

    @property
    def lowest_moment(self) -> float:  # type: ignore[override]
        """From the first piece, if that begins at speed 0."""
        if np.asarray(self.speed)[0] > 0.0:
            return -math.inf
        # the columns hold v f, which is 0 at v = 0
        return -2.0

    def _of_order(self, m: int) -> NDArray[Any] | None:
        highest = self.highest_harmonic
        assert highest is not None
        if m > highest:
            return None
        column = np.asarray(self.values)[:, m]
        return np.asarray(column.real) if m == 0 else column

    def harmonic(
        self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0
    ) -> LogMeasure | None:
        """Gauss points on the linear pieces."""
        column = self._of_order(m)
        return None if column is None else measure.table(np.asarray(self.speed), column)

    def profile(self, m: int) -> Profile | None:
        """Linear interpolation."""
        column = self._of_order(m)
        if column is None:
            return None
        speed = np.asarray(self.speed)

        def value(v: FloatArray) -> NDArray[Any]:
            real = np.interp(v, speed, column.real, left=0.0, right=0.0)
            if not np.iscomplexobj(column):
                return np.asarray(real)
            return np.asarray(real + 1j * np.interp(v, speed, column.imag, left=0.0, right=0.0))

        return value

    @property
    def kinks(self) -> FloatArray:
        """The speeds of the grid."""
        return np.asarray(self.speed)
