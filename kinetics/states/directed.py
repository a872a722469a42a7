"""Directed initial states: beams, angular harmonics, polar grids, samples of velocities."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.errors import InputError, short
from kinetics.numerics import FloatArray
from kinetics.states import quadrature
from kinetics.states.isotropic import Samples, SpeedDensity, Table, as_state
from kinetics.states.quadrature import LogMeasure
from kinetics.states.state import SpeedFunction, State
from kinetics.validation import (
    density_not_negative,
    finite_array,
    normalised,
    real_number,
    refuse,
    rising_speeds,
)

_ZERO = 1e-15  # harmonics below this share of the speed density are rounding of the transform


@dataclass(frozen=True)
class VelocitySamples(Samples):
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
        allowed = "it must be of shape (n, 2), a finite array of numbers"
        v = finite_array("velocity", self.velocity, allowed, (2,))
        if v.shape[0] == 0 or v.shape[1] != 2:
            raise InputError(f"velocity: got shape {v.shape}; it must be of shape (n, 2), n >= 1")
        if np.any(np.hypot(v[:, 0], v[:, 1]) == 0.0):
            raise InputError("velocity: got a velocity of 0; a tracer at rest never collides")
        self.store(velocity=v)

    @property
    def _particles(self) -> tuple[FloatArray, FloatArray]:
        x, y = np.asarray(self.velocity).T
        return np.hypot(x, y), np.arctan2(y, x)


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
            refuse("speeds", self.speeds, "it must be an isotropic state")
        direction = real_number("direction", self.direction, allowed="it must be a finite angle")
        self.store(speeds=speeds, direction=direction)
        self.store(smooth=speeds.smooth, lowest_moment=speeds.lowest_moment)

    @property
    def peaks(self) -> tuple[FloatArray, FloatArray] | None:
        """The delta peaks of the speeds."""
        found: tuple[FloatArray, FloatArray] | None = self.speeds.peaks
        return found

    @property
    def kinks(self) -> FloatArray:
        """Where the speed density of the beam is not smooth."""
        return np.asarray(self.speeds.kinks)

    def in_space(self) -> State | None:
        """The same along the x axis, the only axis that a scene in space has."""
        speeds = self.speeds.in_space()
        return Beam(0.0, speeds) if self.direction == 0.0 and speeds is not None else None

    def harmonic(
        self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0
    ) -> LogMeasure | None:
        """The points of the speeds, with their weights times exp(-i m phi_0)."""
        found: LogMeasure = self.speeds.harmonic(0, rtol, lowest, highest)
        turn = np.exp(-1j * m * self.direction)
        return LogMeasure(found.x, found.weight * turn) if m else found

    def profile(self, m: int) -> SpeedFunction | None:
        """The speed density times exp(-i m phi_0)."""
        profile: SpeedFunction | None = self.speeds.profile(0)
        if profile is None or m == 0:
            return profile
        turn = np.exp(-1j * m * self.direction)
        return lambda v: np.asarray(turn * profile(v))


@dataclass(frozen=True)
class AngularHarmonics(State):
    """f(v, phi) given by its angular harmonics; in space, f(v, theta) by Legendre polynomials.

    Parameters
    ----------
    terms : m -> f_m(v), m >= 0, functions of v/U that map arrays to arrays, real or complex:
        f_m(v) = integral of exp(-i m phi) v f over phi, in space of P_m(cos theta) v^2 f over all
        directions; f_0 is the speed density

    Raises
    ------
    InputError : no m = 0, a negative or fractional m; where they are used, as for SpeedDensity
    """

    terms: Mapping[int, Callable[[Any], Any]]
    smooth = True

    def __post_init__(self) -> None:
        if not isinstance(self.terms, Mapping) or not all(map(callable, self.terms.values())):
            refuse("terms", self.terms, "it must map orders to functions of v")
        orders = list(self.terms)
        whole = all(isinstance(m, int | np.integer) and not isinstance(m, bool) for m in orders)
        if not whole or 0 not in orders or min(orders) < 0:
            raise InputError(
                f"terms: got orders {short(orders)}; whole m >= 0, and m = 0 is needed"
            )
        self.store(terms=dict(self.terms))

    def in_space(self) -> State:
        """The same functions, as coefficients of Legendre polynomials."""
        return self

    @property
    def highest_harmonic(self) -> int | None:  # type: ignore[override]
        """The largest m given."""
        return max(int(m) for m in self.terms)

    def harmonic(
        self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0
    ) -> LogMeasure | None:
        """Adaptive Gauss panels in ln v; None for a term that is zero everywhere."""
        if m == 0:
            return SpeedDensity(self.terms[0]).harmonic(0, rtol, lowest, highest)
        if m not in self.terms:
            return None
        return quadrature.function(self.terms[m], rtol, lowest, highest)

    def profile(self, m: int) -> SpeedFunction | None:
        """The function itself."""
        return SpeedDensity(self.terms[m]).profile(0) if m in self.terms else None


@dataclass(frozen=True)
class PolarGrid(Table):
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
        v = rising_speeds(self.speed)
        allowed = f"it must be of shape ({v.size}, n_phi), a finite array of numbers"
        f = finite_array("values", self.values, allowed, (2,))
        if f.shape[0] != v.size or f.shape[1] < 1:
            raise InputError(f"values: got shape {f.shape}; it must be ({v.size}, n_phi)")
        density_not_negative(f, "values")
        self.store(speed=v, values=f)
        normalised(self._integral, "values")

    @cached_property
    def _unscaled(self) -> NDArray[Any]:
        """f_m of the values as they were given, at the speeds of the grid: shape (n_v, n_phi)."""
        v, f = np.asarray(self.speed), np.asarray(self.values)
        found = np.fft.fft(f, axis=1) * (2.0 * math.pi / f.shape[1]) * v[:, None]
        found.flags.writeable = False
        return np.asarray(found)

    @cached_property
    def _integral(self) -> float:
        radial = self._unscaled[:, 0].real
        return float(np.sum(0.5 * (radial[1:] + radial[:-1]) * np.diff(self.speed)))

    @property
    def highest_harmonic(self) -> int | None:  # type: ignore[override]
        """The highest m that so many angles resolve."""
        return (np.asarray(self.values).shape[1] - 1) // 2

    def _values(self, m: int) -> NDArray[Any] | None:
        """f_m at the speeds of the grid, shape (n_v,); None where it is zero to rounding."""
        if m > (self.highest_harmonic or 0):
            return None
        values = self._unscaled[:, m] / self._integral
        if m == 0:
            return np.asarray(values.real)
        largest = float(np.abs(self._unscaled[:, 0]).max()) / self._integral
        return None if float(np.abs(values).max()) < _ZERO * largest else values
