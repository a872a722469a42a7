"""Solution: the frozen answer to a Scene."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.errors import InputError, short
from kinetics.scaled import SolverStatus
from kinetics.scene import Scene

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class PlanStep:
    """One part of the work: what, whether it was done, and why."""

    part: str
    solved: bool
    reason: str


@dataclass(frozen=True)
class Solution:
    """What :func:`kinetics.solve` found. Time is the first axis of every array.

    Attributes
    ----------
    scene : the question
    rtol : the relative accuracy asked for
    values : output name -> array of shape (n_times,); also as attributes, ``solution.msd``
    status : SolverStatus; its text says what to change
    error_estimate : largest relative error that the solver saw
    plan : what was solved and what was skipped, and why
    stats : numbers about the work (nodes, panels, points of the initial state)
    """

    scene: Scene
    rtol: float
    values: dict[str, FloatArray]
    status: SolverStatus
    error_estimate: float
    plan: tuple[PlanStep, ...]
    stats: dict[str, Any]
    _density: Callable[[FloatArray], FloatArray] | None = field(default=None, repr=False)
    _moment: Callable[[float], FloatArray] | None = field(default=None, repr=False)

    @property
    def times(self) -> FloatArray:
        """Output times in d/U, shape (n_times,)."""
        return np.asarray(self.scene.times)

    def __getattr__(self, name: str) -> FloatArray:
        values = self.__dict__.get("values", {})
        if name in values:
            return np.asarray(values[name])
        if name.startswith("_"):
            raise AttributeError(name)
        raise AttributeError(
            f"{name!r} was not asked for; this solution has {', '.join(values) or 'no arrays'}"
        )

    def moment(self, p: float) -> FloatArray:
        """<v^p>(t) in U^p for real p, shape (n_times,); InputError where it does not exist."""
        assert self._moment is not None
        return self._moment(p)

    def speed_density(self, v: ArrayLike) -> FloatArray:
        """Density of the speed at v (in U), shape (n_times, n_v), in 1/U; integral over v is 1.

        Raises InputError for v negative or not finite, or if "speed_density" was not among the
        outputs.
        """
        if self._density is None:
            raise InputError(
                "outputs: 'speed_density' was not asked for; name it among the scene's outputs"
            )
        v_ = np.atleast_1d(np.asarray(v, dtype=float))
        if v_.ndim != 1 or not np.all(np.isfinite(v_)) or np.any(v_ < 0.0):
            raise InputError(f"v: got {short(v)}; speeds must be finite and not negative")
        return self._density(v_)
