"""A harmonic of the speed density at the output times, whatever solver made it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Profile:
    """Harmonic m of the velocity distribution: exp(-i m phi) v f(v, phi) integrated over phi.

    Attributes
    ----------
    continuous : v (n_v,) in U -> (n_times, n_v), without delta peaks; in 1/U
    peak_speed, peak_weight : tracers of the monoenergetic start that have not collided, speed in U
        and share of all tracers (times exp(-i m phi_0)), shape (n_times,); None where there are no
        delta peaks
    method : "spectral", "conservative" or "exact"
    nodes : of the speed axis
    error_estimate : relative to the maximum
    """

    continuous: Callable[[FloatArray], NDArray[Any]]
    method: str
    nodes: int
    error_estimate: float
    peak_speed: float | None = None
    peak_weight: NDArray[Any] | None = None
