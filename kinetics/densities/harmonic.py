"""A harmonic of the speed density at the output times, whatever solver made it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.scaling.scaled_vdf import ScaledVDF, solve_scaled

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Profile:
    """Harmonic m of the velocity distribution: exp(-i m phi) v f(v, phi) integrated over phi.

    Attributes
    ----------
    at : (i, v) -> density at the i-th time and speeds v (n_v,) in U, without delta peaks; in 1/U
    count : n_times
    peak_speed, peak_weight : tracers of the monoenergetic start that have not collided, speed in U
        and share of all tracers (times exp(-i m phi_0)), shape (n_times,); None where there are no
        delta peaks
    method : "spectral", "conservative" or "exact"
    nodes : of the speed axis
    error_estimate : relative to the maximum
    """

    at: Callable[[int, FloatArray], NDArray[Any]]
    count: int
    method: str
    nodes: int
    error_estimate: float
    peak_speed: float | None = None
    peak_weight: NDArray[Any] | None = None

    def continuous(self, v: FloatArray) -> NDArray[Any]:
        """All times: shape (n_times, n_v)."""
        return np.array([self.at(i, v) for i in range(self.count)])


def count_before_scaling(law: CollisionLaw, tau: FloatArray, rtol: float) -> int:
    """How many of the times tau = ln(1 + v_rms t/l) are before the scaling state is reached.

    The slowest transient of an isotropic state falls as e^-tau.
    """
    saturated = -math.log(law.mean_log_loss) + math.log(1.0 / rtol) + 4.0
    return int(np.searchsorted(tau, saturated))


@dataclass(frozen=True)
class ThenScaling:
    """Densities of a solver at the early times, and of the scaling state at the later ones.

    Attributes
    ----------
    early : (i, v) -> density, for the first ``count`` times
    count : how many those are
    late_shift : ln((t + t0)/l) of the later times
    scaled : the stationary solution that serves them
    """

    early: Callable[[int, FloatArray], NDArray[Any]]
    count: int
    late_shift: FloatArray
    scaled: ScaledVDF | None

    def __call__(self, i: int, v: FloatArray) -> NDArray[Any]:
        """Density at the i-th time and speeds v, shape (n_v,)."""
        if i < self.count:
            return self.early(i, v)
        assert self.scaled is not None
        out = np.zeros(v.shape)
        # v0 (t + t0)/l = 2/h in the scaling state
        log_thermal = math.log(2.0 / self.scaled.cooling_rate) - float(
            self.late_shift[i - self.count]
        )
        with np.errstate(divide="ignore"):
            log_c = np.log(v) - log_thermal
        near = np.abs(log_c) < 300.0  # further off nothing is left, or c overflows
        c = np.exp(log_c[near])
        out[near] = 2.0 * math.pi * c * self.scaled.vdf(c) * math.exp(-log_thermal)
        return out


def then_scaling(
    law: CollisionLaw,
    early: Callable[[int, FloatArray], NDArray[Any]],
    count: int,
    late_shift: FloatArray,
    rtol: float,
) -> ThenScaling:
    """The early densities, with the scaling state solved if there are later times."""
    scaled = solve_scaled(law.restitution, max(rtol, 1e-13)) if late_shift.size else None
    return ThenScaling(early, count, late_shift, scaled)
