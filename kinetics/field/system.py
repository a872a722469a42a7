"""What drives a tracer, and how fast it may then be. Lengths are in mean free paths l."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.field.restitution import ImpactRestitution, impact_restitution
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import gauss_legendre
from kinetics.validation import (
    check_mass_ratio,
    check_restitution,
    real_number,
    refuse,
    whole_number,
)

DRIVES = ("bath_speed", "heating", "drag", "capture_speed")
"""What a System has beside a restitution, a mass ratio and a field."""
LEAST, MOST = 1e-20, 1e20  # of what drives, in units of U and l: its powers are in doubles
SIZES = f"in units of U and the mean free path it must be 0, or from {LEAST:g} to {MOST:g}"
TAIL = 1e-3  # of a tolerance: the share of tracers above the highest speed
_LEAST_TOP = 1e-12  # of the speeds that are looked at: a system that stays below is at rest
_STRONG = 0.45  # a speed over sqrt(g l), from which on harmonics fall exponentially


def checked_drives(**drives: Any) -> dict[str, float]:
    """The strengths of what drives, by name; InputError for one that is no number, 0 or more."""
    allowed = "it must be a finite number, 0 or more"
    return {name: real_number(name, x, 0.0, allowed=allowed) for name, x in drives.items()}


@dataclass(frozen=True)
class System:
    """Scatterers and what acts on the tracer, in the mean free path and one unit of speed.

    Its fields are the arguments of `kinetics.solve_steady`; the restitution may also be a
    CollisionLaw, if there is no bath_speed or capture_speed.
    """

    restitution: float | ImpactRestitution | CollisionLaw
    dimension: int = 2
    bath_speed: float = 0.0
    mass_ratio: float = math.inf
    heating: float = 0.0
    drag: float = 0.0
    field: float = 0.0
    capture_speed: float = 0.0

    @classmethod
    def checked(cls, restitution: Any, dimension: Any, mass_ratio: Any, **drives: Any) -> System:
        """From a user's arguments; InputError for one out of range."""
        law = impact_restitution(restitution)
        return cls(
            check_restitution(restitution) if law is None else law,
            whole_number("dimension", dimension, 2, 3),
            mass_ratio=check_mass_ratio(mass_ratio),
            **checked_drives(**drives),
        )

    def scaled(self, path: float) -> System:
        """From accelerations, noise and drag per unit of length to those per mean free path.

        InputError where one of these, or a speed, is tiny or huge.
        """
        units = dict.fromkeys(DRIVES, 1.0) | dict.fromkeys(("heating", "drag", "field"), path)
        sizes = {name: getattr(self, name) * unit for name, unit in units.items()}
        for name, size in sizes.items():
            if getattr(self, name) and not LEAST <= size <= MOST:
                refuse(name, getattr(self, name), SIZES)
        return replace(self, **sizes)

    @property
    def is_driven(self) -> bool:
        """Whether anything gives the tracer energy."""
        return max(self.bath_speed, self.heating, self.field) > 0.0

    @cached_property
    def law(self) -> CollisionLaw | None:
        """The collision law, where what a collision does scales with the speed."""
        e = self.restitution
        if isinstance(e, CollisionLaw):
            return e
        if callable(e) or self.bath_speed or self.capture_speed:
            return None
        return CollisionLaw(e, 1.0, self.dimension, mass_ratio=self.mass_ratio)

    @property
    def only_slows(self) -> bool:
        """Whether there are but drag and collisions that scale with the speed."""
        return self.law is not None and self.drag > 0.0 and not self.is_driven

    @property
    def only_falls(self) -> bool:
        """Whether there are but a field and collisions that scale with the speed."""
        return self.law is not None and self.field > 0.0 and not (self.heating or self.drag)

    @property
    def only_heats(self) -> bool:
        """Whether there are but noise and collisions that scale with the speed."""
        return self.law is not None and self.heating > 0.0 and not (self.field or self.drag)

    @property
    def field_rules(self) -> bool:
        """Whether no bath or noise keeps directions smooth at low speeds, where a field bends."""
        return max(self.bath_speed, self.heating ** (1.0 / 3.0)) < _STRONG * math.sqrt(self.field)

    @property
    def takes_energy(self) -> bool:
        """Whether collisions or drag take energy from a fast tracer."""
        fast = np.array([1e3 * (self.scale or 1.0)])
        return self.drag > 0.0 or bool(self._losses(fast)[0][0] > 0.0)

    def impulse(self, impact_speed: FloatArray) -> FloatArray:
        """1 + e*, by which a collision multiplies the normal component that it takes away."""
        share = 1.0 if self.mass_ratio == math.inf else self.mass_ratio / (1.0 + self.mass_ratio)
        e: Any = self.restitution
        return share * (1.0 + (e(impact_speed) if callable(e) else np.full(impact_speed.shape, e)))

    @property
    def breaks(self) -> FloatArray:
        """Impact speeds at which the outcome of a collision is not smooth."""
        knots = self.restitution.breaks if callable(self.restitution) else np.empty(0)
        stick = [self.capture_speed] if self.capture_speed else []
        return np.unique(np.concatenate([knots, stick]))

    @property
    def sticks_sharply(self) -> bool:
        """Whether averages bend where impacts begin to stick, which no bath smooths."""
        return self.capture_speed > 0.0 and not self.bath_speed

    @property
    def is_singular(self) -> bool:
        """Whether the restitution varies as a fractional power of slow impacts."""
        return callable(self.restitution) and self.restitution.is_singular

    # -- how fast a tracer may be -----------------------------------------------------------------

    @cached_property
    def scale(self) -> float:
        """The speed below which averages vary little; 0 where nothing sets one."""
        found, stick = self._driven, self.capture_speed
        return min(found, stick) if found and stick else found or stick

    @property
    def _driven(self) -> float:
        """A speed that is given to tracers; 0 where nothing drives."""
        noise = self.heating ** (1.0 / 3.0)
        return max(self.bath_speed, noise, 0.3 * math.sqrt(self.field))

    def collision_rate(self, v: FloatArray) -> FloatArray:
        """Of tracers of these speeds (n,), in 1/l: the mean speed relative to the scatterers."""
        from scipy.special import hyp1f1, poch  # averages alone load no scipy

        d, w = 0.5 * self.dimension, math.sqrt(2.0) * self.bath_speed
        return w * poch(d, 0.5) * hyp1f1(-0.5, d, -((v / w) ** 2)) if w else v

    def _losses(self, v: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """E[1 - s^2], E[1 - s cos chi] and E[(1 + e*)^2 n^2] of resting scatterers, (n,) each."""
        if self.law is not None:
            q, one = self.law.quadrature, np.ones(v.shape)
            lost = self.law.energy_loss * one, (q.weight @ (1.0 - q.ratio * q.cosine)) * one
            return *lost, 0.0 * one
        x, w = gauss_legendre(24)
        if self.dimension == 2:
            c, w = np.cos(0.5 * np.pi * x), 0.5 * np.pi * w * np.cos(0.5 * np.pi * x)
        else:
            c, w = x, 2.0 * x * w
        k = self.impulse(v[:, None] * c)
        return ((2.0 - k) * k * c * c) @ w, (k * c * c) @ w, (k * k * c * c) @ w

    def top(self, tolerance: float, time: float = math.inf, start: float = 0.0) -> float:
        """A speed that a share of the tracers below the tolerance exceeds up to this time.

        start : the fastest of the beginning. The density falls as exp(-E): with the drift A and the
        diffusion D of the speed dE/dv = A/D, or less where a tracer gains its speed in one flight;
        before the steady state as exp(-(integral of dv/sqrt(D))^2/(4 t)).
        """
        if not self.is_driven:
            return start
        v = np.geomspace(1e-6, 1e6, 2401) * self._driven
        loss, turn, kick = self._losses(v)
        drift = self.drag * v + 0.5 * loss * v * v
        bath, noise, g = 0.5 * self.bath_speed**2 * kick * v, self.heating, self.field
        with np.errstate(divide="ignore"):
            spread = noise + bath + g * g / (self.dimension * turn * v)
            flight = 1.0 / (np.sqrt(noise / v) + g / v) if g or noise else np.full(v.shape, np.inf)
            flight = flight + (self.drag * v / noise if noise else 0.0)
        dv, rise = np.gradient(v), np.minimum(drift / spread, flight)
        if self.bath_speed and self.drag:  # it may leave no time for diffusion: a few kicks count
            kicked, mild = self.bath_speed * self.impulse(v).max(), 0.25 * loss * v * v / bath
            against, few = self.drag * v / np.maximum(v, self.bath_speed), drift / spread
            for _ in range(9):  # few dE/dv, of which kicks by kicked make up for the drag
                few = mild + np.sqrt(mild**2 + 2.0 * np.log1p(against * few) / kicked**2)
            rise = np.minimum(rise, few)
        steady = np.cumsum(rise * dv)
        rising = np.cumsum(dv / np.sqrt(spread)) ** 2 / (4.0 * max(time, 1e-300))
        if self.bath_speed:  # one collision gives more than diffusion does
            rising = np.minimum(rising, 0.5 * (v / (2.0 * self.bath_speed)) ** 2)
        needed = math.log(1.0 / tolerance) + 8.0
        reached = float(np.interp(needed, np.maximum(steady, rising), v))
        top = math.hypot(reached, start)
        if self.only_falls:  # and no faster than without a collision
            top = min(top, start + g * time)
        return max(top, _LEAST_TOP)
