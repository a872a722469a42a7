"""A point of the theory: every number that it has of the data, and the start of the tracers."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.data.sample import StartBins
from kinetics.states.kinds import Beam
from kinetics.states.state import LogMeasure, State

#: All tracers start with the velocity U along x.
BEAM = Beam()


@dataclass(frozen=True, eq=False)
class SampledStart(State):
    """The speeds of a sample at time 0, as it has them, in all directions alike."""

    bins: StartBins

    def harmonic(
        self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0
    ) -> LogMeasure | None:
        """Return one point for each bin of the speeds; there is no harmonic but the isotropic."""
        if m:
            return None
        counts = self.bins.counts
        return LogMeasure(0.5 * np.log(self.bins.squares), counts / counts.sum())


@dataclass(frozen=True, kw_only=True)
class Point:
    """Every number that a theory of data has; a cause of a difference is another value of some.

    Parameters
    ----------
    restitution, start, scatterers : as in a Scene
    path : 1/(2 d rho) in d (in space 1/(pi d^2 rho)), among dense scatterers too
    speed_unit, time_unit, length_unit : U, d/U and d of the data in those that were specified
    at_rest : share of the tracers that never move
    time_offset : by how much the data's clock is behind the true one, in d/U
    velocity_noise, position_noise : variance of the error of a component, in U^2 and d^2; of a
        displacement if the data have velocities, of a position if they have positions alone
    """

    restitution: Any
    path: float
    start: Any
    scatterers: str = "dilute"
    speed_unit: float = 1.0
    time_unit: float = 1.0
    length_unit: float = 1.0
    at_rest: float = 0.0
    time_offset: float = 0.0
    velocity_noise: float = 0.0
    position_noise: float = 0.0

    def with_values(self, **changed: Any) -> Point:
        """Return the same point with other values of some numbers."""
        return replace(self, **changed)

    @property
    def has_own_start(self) -> bool:
        """Whether the theory starts from the speeds of the sample at time 0."""
        return isinstance(self.start, SampledStart)

    @property
    def starts_along_x(self) -> bool:
        """Whether all tracers start with one velocity along x."""
        return bool(self.start == BEAM)

    @property
    def has_one_speed(self) -> bool:
        """Whether all tracers start with one speed."""
        if isinstance(self.start, SampledStart):
            return bool(self.start.bins.squares.size == 1)
        return self.starts_along_x or self.start == "monoenergetic"

    @property
    def clock(self) -> float:
        """The true time over the time of the data, both in d/U."""
        return self.speed_unit / self.time_unit

    def true_times(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return times of the data on the true clock, both in d/U; 0 stays 0."""
        on_clock = times * self.clock + self.time_offset * (times > 0.0)
        return np.asarray(np.maximum(on_clock, 0.0))

    @property
    def start_in_words(self) -> str:
        """The start as the middle of a sentence."""
        if self.has_own_start:
            return "the data's own speeds at time 0"
        if self.starts_along_x:
            return "a beam along x"
        named = {"gaussian": "a Gaussian start", "monoenergetic": "a start with all speeds U"}
        return named.get(self.start, str(self.start))
