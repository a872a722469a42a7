"""What drives a tracer: one value, built once from a user's arguments and handed on whole."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.collision.impact import ImpactRestitution, impact_restitution
from kinetics.numerics import FloatArray
from kinetics.validation import (
    check_mass_ratio,
    check_restitution,
    real_number,
    refuse,
    whole_number,
)

#: The names of what acts on a tracer between its collisions, or at them, beside a field: some give
#: it energy, others take it.
DRIVES = ("bath_speed", "heating", "drag", "capture_speed")
#: Least and largest strength of what acts, in units of U and the mean free path: powers of it are
#: in the range of double precision.
MIN_STRENGTH = 1e-20
#: Largest strength, likewise.
MAX_STRENGTH = 1e20
STRENGTHS_ALLOWED = (
    f"in units of U and the mean free path it must be 0, or from {MIN_STRENGTH:g} to "
    f"{MAX_STRENGTH:g}"
)
#: A speed of a bath or of noise over sqrt(g l), g the field and l the mean free path, from which on
#: f depends so smoothly on the direction that angular harmonics fall exponentially. Chosen: it sets
#: the first resolution; at half and at twice averages move by 1e-11 at rtol 1e-6.
STRONG_OVER_FIELD = 0.45
#: The speed over sqrt(g l) below which averages in a field vary little: a fraction of the one that
#: the field gives in a flight, sqrt(2 g l). Measured: at half and at twice averages move by 5e-10
#: at rtol 1e-6.
FIELD_SPEED = 0.3


@dataclass(frozen=True, kw_only=True)
class Drive:
    """The collisions of a tracer, and what acts on it, in one unit of length and one of speed.

    A :class:`kinetics.Scene` has it in d and U, solvers in mean free paths (:meth:`per_path`).

    Parameters
    ----------
    restitution : e; or e as a function of the impact speed; or a law of collisions, where there is
        no bath_speed and no capture_speed
    dimension : d, 2 or 3
    field : uniform acceleration along x
    bath_speed : w, standard deviation of a component of the velocity of a scatterer
    mass_ratio : of a scatterer over the tracer
    heating : D_v of white noise, <dv_i dv_j> = 2 D_v delta_ij dt
    drag : gamma in dv/dt = -gamma v
    capture_speed : impacts whose normal speed is below it stick: the tracer stays at the scatterer
    """

    restitution: float | ImpactRestitution | CollisionLaw
    dimension: int = 2
    field: float = 0.0
    bath_speed: float = 0.0
    mass_ratio: float = math.inf
    heating: float = 0.0
    drag: float = 0.0
    capture_speed: float = 0.0

    def __post_init__(self) -> None:
        has_law = isinstance(self.restitution, CollisionLaw)
        if has_law and (self.bath_speed or self.capture_speed):
            allowed = (
                "with a bath_speed or capture_speed it must be a number, or of the impact speed"
            )
            refuse("restitution", self.restitution, allowed)

    @classmethod
    def checked(
        cls, *, restitution: Any, dimension: Any = 2, mass_ratio: Any = math.inf, **strengths: Any
    ) -> Drive:
        """Return the drive of a user's arguments; InputError for one that is out of range.

        strengths : field and `DRIVES`, by name
        """
        law = impact_restitution(restitution)
        return cls(
            restitution=check_restitution(restitution) if law is None else law,
            dimension=whole_number("dimension", dimension, 2, 3),
            mass_ratio=check_mass_ratio(mass_ratio),
            **check_strengths(**strengths),
        )

    @property
    def is_smooth_at_rest(self) -> bool:
        """Whether averages are smooth functions of the velocity at rest, as even polynomials are.

        Moving scatterers make them so; a term as |v| v in the motion would not leave them so. It
        decides which axis of speeds a solver takes (`kinetics.driven.chebyshev_axis`).
        """
        return self.bath_speed > 0.0

    def per_path(self, mean_free_path: float) -> Drive:
        """Return the same drive with the mean free path as the unit of length.

        mean_free_path : in the present unit

        InputError where an acceleration, a noise, a drag or a speed is tiny or huge then.
        """
        scaled = replace(
            self,
            field=self.field * mean_free_path,
            heating=self.heating * mean_free_path,
            drag=self.drag * mean_free_path,
        )
        for name in ("field", *DRIVES):
            given = getattr(self, name)
            if given and not MIN_STRENGTH <= getattr(scaled, name) <= MAX_STRENGTH:
                refuse(name, given, STRENGTHS_ALLOWED)
        return scaled

    # -- what acts --------------------------------------------------------------------------------

    @property
    def limits(self) -> str:
        """What the law of the collisions lacks, to follow a sentence; perhaps empty."""
        if isinstance(self.restitution, ImpactRestitution):
            return self.restitution.limits
        return ""

    @cached_property
    def law(self) -> CollisionLaw | None:
        """The collision law, if what a collision does scales with the speed; else None."""
        e = self.restitution
        if isinstance(e, CollisionLaw):
            return e
        if isinstance(e, ImpactRestitution) or self.bath_speed or self.capture_speed:
            return None
        return CollisionLaw(e, 1.0, self.dimension, mass_ratio=self.mass_ratio)

    @property
    def is_driven(self) -> bool:
        """Whether anything gives the tracer energy."""
        return self.bath_speed > 0.0 or self.heating > 0.0 or self.field > 0.0

    @property
    def only_collides(self) -> bool:
        """Whether there is nothing but collisions that scale with the speed."""
        return self.law is not None and not (self.field or self.heating or self.drag)

    @property
    def only_falls(self) -> bool:
        """Whether there are only a field and collisions that scale with the speed."""
        return self.law is not None and self.field > 0.0 and not (self.heating or self.drag)

    @property
    def only_heats(self) -> bool:
        """Whether there are only noise and collisions that scale with the speed."""
        return self.law is not None and self.heating > 0.0 and not (self.field or self.drag)

    @property
    def only_slows(self) -> bool:
        """Whether there are only drag and collisions that scale with the speed."""
        return self.law is not None and self.drag > 0.0 and not self.is_driven

    # -- what a collision does --------------------------------------------------------------------

    def impulse(self, impact_speed: FloatArray) -> FloatArray:
        """Return 1 + e* = (1 + e) M/(M + m), M/m the mass ratio.

        It is the change of the normal velocity of the tracer over the relative one before the
        collision. Sticking is not included.

        impact_speed : normal relative speeds of any shape
        """
        reduced_mass = 1.0
        if self.mass_ratio != math.inf:
            reduced_mass = self.mass_ratio / (1.0 + self.mass_ratio)
        e = self.restitution
        assert not isinstance(e, CollisionLaw)
        if isinstance(e, ImpactRestitution):
            return reduced_mass * (1.0 + e(impact_speed))
        return reduced_mass * (1.0 + np.full(impact_speed.shape, e))

    @property
    def breaks(self) -> FloatArray:
        """Impact speeds at which the outcome of a collision is not smooth, rising, shape (n,)."""
        speeds = np.empty(0)
        if isinstance(self.restitution, ImpactRestitution):
            speeds = self.restitution.breaks
        if self.capture_speed:
            speeds = np.append(speeds, self.capture_speed)
        return np.unique(speeds)

    @property
    def is_singular(self) -> bool:
        """Whether the restitution varies as a fractional power of slow impacts."""
        e = self.restitution
        return isinstance(e, ImpactRestitution) and e.is_singular

    @property
    def sticks_sharply(self) -> bool:
        """Whether averages have a kink where impacts begin to stick, which no bath smooths."""
        return self.capture_speed > 0.0 and not self.bath_speed

    # -- speeds that it sets ----------------------------------------------------------------------

    @property
    def driven_speed(self) -> float:
        """A speed that is given to tracers, with the mean free path as the unit of length.

        It is 0 where nothing gives energy.
        """
        of_field = FIELD_SPEED * math.sqrt(self.field)
        return max(self.bath_speed, self._noise_speed, of_field)

    @property
    def _noise_speed(self) -> float:
        """The speed that noise gives a tracer in a mean free path."""
        return float(self.heating ** (1.0 / 3.0))

    @property
    def scale(self) -> float:
        """The speed below which averages of a tracer of that speed vary little with it.

        With the mean free path as the unit of length; 0 where nothing sets one.
        """
        if self.driven_speed and self.capture_speed:
            return min(self.driven_speed, self.capture_speed)
        return self.driven_speed or self.capture_speed

    @property
    def is_field_dominated(self) -> bool:
        """Whether no bath or noise keeps directions smooth at low speeds, where a field bends."""
        other = max(self.bath_speed, self._noise_speed)
        return other < STRONG_OVER_FIELD * math.sqrt(self.field)


def check_strengths(**strengths: Any) -> dict[str, float]:
    """Return the strengths of what acts, by name; InputError for one that is no number >= 0."""
    allowed = "it must be a finite number, 0 or more"
    return {
        name: real_number(name, strength, 0.0, allowed=allowed)
        for name, strength in strengths.items()
    }
