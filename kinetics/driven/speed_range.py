"""How fast a driven tracer may be, and how often it collides. Lengths are in mean free paths l."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kinetics.drive import Drive
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import gauss_legendre

#: The share of tracers above the highest speed, over the tolerance. Measured: at a tenth and at ten
#: times averages move by 4e-8 under drives at rtol 1e-6, densities by 1e-6 of their maximum.
TAIL_OVER_TOLERANCE = 1e-3
#: Least highest speed in the unit of speed: tracers that stay below are at rest. Chosen: far below
#: any speed that is resolved.
MIN_TOP_SPEED = 1e-12
#: e-folds of the density beyond those of the tolerance, for the prefactor of the exponential.
#: Measured: at half and at twice averages at rtol 1e-6 move by less than that, and densities by
#: 2e-6 of their maximum.
FOLDS_BEYOND = 8.0
#: Speeds over the driven one at which drift and diffusion of the speed are tabulated.
SPEED_RATIOS = np.geomspace(1e-6, 1e6, 2401)
#: A speed, over `Drive.scale`, at which what collisions take outweighs what drives.
FAST = 1e3
#: Points of averages over the impact parameter.
IMPACT_POINTS = 24
#: Steps of the fixed point for a bath against drag: each leaves a small fraction of its error.
FIXED_POINT_STEPS = 9


def collision_rate(drive: Drive, v: FloatArray) -> FloatArray:
    """Return the rate of collisions at speeds v (n,), the mean relative speed over l."""
    from scipy.special import hyp1f1, poch  # averages alone load no scipy

    if not drive.bath_speed:
        return v
    half_dimension = 0.5 * drive.dimension
    w = math.sqrt(2.0) * drive.bath_speed
    at_rest = w * poch(half_dimension, 0.5)
    return np.asarray(at_rest * hyp1f1(-0.5, half_dimension, -((v / w) ** 2)))


@dataclass(frozen=True)
class Losses:
    """Averages over collisions with scatterers at rest, by speed, shape (n,) each.

    Parameters
    ----------
    energy : <1 - s^2>, s the speed after over that before
    along : <1 - s cos chi>, chi the angle of deflection
    kick_variance : <k^2 cos^2 theta>, k = 1 + e* (`Drive.impulse`), theta the angle between the
        normal and the velocity of the tracer: the variance of its change of speed over that of a
        component of the velocity of the scatterer; 0 where collisions scale with the speed
    """

    energy: FloatArray
    along: FloatArray
    kick_variance: FloatArray


def mean_losses(drive: Drive, v: FloatArray) -> Losses:
    """Return what tracers of speeds v (n,) lose in a collision, on average."""
    if drive.law is not None:
        impacts = drive.law.quadrature
        along = float(impacts.weight @ (1.0 - impacts.ratio * impacts.cosine))
        same = np.ones(v.shape)
        return Losses(drive.law.energy_loss * same, along * same, 0.0 * same)
    point, weight = gauss_legendre(IMPACT_POINTS)
    if drive.dimension == 2:
        cosine = np.cos(0.5 * np.pi * point)
        weight = 0.5 * np.pi * weight * cosine
    else:
        cosine = point
        weight = 2.0 * point * weight
    k = drive.impulse(v[:, None] * cosine)
    return Losses(
        energy=((2.0 - k) * k * cosine * cosine) @ weight,
        along=(k * cosine * cosine) @ weight,
        kick_variance=(k * k * cosine * cosine) @ weight,
    )


def takes_energy(drive: Drive) -> bool:
    """Return whether collisions or drag take energy from a fast tracer."""
    fast = np.array([FAST * (drive.scale or 1.0)])
    return drive.drag > 0.0 or bool(mean_losses(drive, fast).energy[0] > 0.0)


def top_speed(
    drive: Drive, tolerance: float, time: float = math.inf, fastest_start: float = 0.0
) -> float:
    """Return a speed that at most a share ``tolerance`` of the tracers exceeds up to a time.

    The density of the speed falls as exp(-S(v)). In the steady state dS/dv = A/D with the drift A
    and the diffusion D of the speed, or less where a tracer gains its speed in one flight; before,
    S = (integral of dv/sqrt(D))^2/(4 t).

    Parameters
    ----------
    drive : in units of l
    tolerance : the share of the tracers
    time : in l over the unit of speed
    fastest_start : the highest speed of the initial state
    """
    if not drive.is_driven:
        return fastest_start
    v = SPEED_RATIOS * drive.driven_speed
    change = _SpeedChange.of(drive, v)
    steady = np.cumsum(change.steady_slope() * np.gradient(v))
    rising = change.exponent_at(time)
    needed = math.log(1.0 / tolerance) + FOLDS_BEYOND
    reached = float(np.interp(needed, np.maximum(steady, rising), v))
    # energies add; what noise adds to a speed at once is in the margin of `fastest_start`
    top = math.hypot(reached, fastest_start)
    if drive.only_falls:
        without_collision = fastest_start + drive.field * time
        top = min(top, without_collision)
    return max(top, MIN_TOP_SPEED)


@dataclass(frozen=True)
class _SpeedChange:
    """How the speed changes: what opposes and what drives it, at speeds v, shape (n,) each.

    Parameters
    ----------
    drive : in units of l
    v : speeds, rising
    collisional_drift : A of collisions alone
    bath_diffusion : D of kicks by the scatterers of a bath
    diffusion : D of everything
    """

    drive: Drive
    v: FloatArray
    collisional_drift: FloatArray
    bath_diffusion: FloatArray
    diffusion: FloatArray

    @classmethod
    def of(cls, drive: Drive, v: FloatArray) -> _SpeedChange:
        """Return the change of the speed at speeds v."""
        losses = mean_losses(drive, v)
        bath_diffusion = 0.5 * drive.bath_speed**2 * losses.kick_variance * v
        with np.errstate(divide="ignore"):
            field_diffusion = drive.field * drive.field / (drive.dimension * losses.along * v)
        return cls(
            drive=drive,
            v=v,
            collisional_drift=0.5 * losses.energy * v * v,
            bath_diffusion=bath_diffusion,
            diffusion=drive.heating + bath_diffusion + field_diffusion,
        )

    def steady_slope(self) -> FloatArray:
        """Return dS/dv in the steady state."""
        drift = self.drive.drag * self.v + self.collisional_drift
        with np.errstate(divide="ignore"):
            slope = np.minimum(drift / self.diffusion, self._slope_in_one_flight())
        if self.drive.bath_speed and self.drive.drag:
            slope = np.minimum(slope, self._slope_of_few_kicks(drift))
        return slope

    def _slope_in_one_flight(self) -> FloatArray:
        """Return dS/dv of tracers that gain their speed in one free flight.

        Without a collision, D_v S'^2 + (g - gamma v) S' = v with noise D_v, field g and drag gamma.
        At most the slope of field and noise is taken, and more where drag opposes them.
        """
        drive = self.drive
        if not (drive.field or drive.heating):
            return np.full(self.v.shape, np.inf)
        undragged = 1.0 / (np.sqrt(drive.heating / self.v) + drive.field / self.v)
        if not drive.heating:
            return undragged
        half_drag = 0.5 * drive.drag * self.v / drive.heating
        return np.asarray(half_drag + np.hypot(half_drag, undragged))

    def _slope_of_few_kicks(self, drift: FloatArray) -> FloatArray:
        """Return dS/dv where drag leaves no time for diffusion: a few kicks of a bath count.

        Kicks are Gaussian of deviation K and come at the rate v, so that S' obeys
        drag v S' = v (exp(K^2 S'^2/2 - K^2 S' S'_c) - 1), S'_c half the slope of collisions alone.
        """
        drive = self.drive
        v = self.v
        largest_kick = drive.bath_speed * drive.impulse(v).max()
        half_collisional_slope = 0.5 * self.collisional_drift / self.bath_diffusion
        drag_per_kick = drive.drag * v / np.maximum(v, drive.bath_speed)
        slope = drift / self.diffusion
        for _ in range(FIXED_POINT_STEPS):
            kicks_needed = 2.0 * np.log1p(drag_per_kick * slope) / largest_kick**2
            slope = half_collisional_slope + np.sqrt(half_collisional_slope**2 + kicks_needed)
        return np.asarray(slope)

    def exponent_at(self, time: float) -> FloatArray:
        """Return S(v) at a time before the steady state."""
        step = np.gradient(self.v)
        exponent = np.cumsum(step / np.sqrt(self.diffusion)) ** 2 / (4.0 * max(time, 1e-300))
        if self.drive.bath_speed:  # one collision gives more than diffusion does
            in_one_kick = 0.5 * (self.v / (2.0 * self.drive.bath_speed)) ** 2
            exponent = np.minimum(exponent, in_one_kick)
        return np.asarray(exponent)
