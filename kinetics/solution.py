"""Solution: the frozen answer to a Scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.errors import InputError, short
from kinetics.marginal import component_density
from kinetics.profile import Profile
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
    values : output name -> array whose first axis is time; also as attributes, ``solution.msd``
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
    _profiles: Mapping[int, Profile] = field(default_factory=dict, repr=False)
    _harmonic: Callable[[float, int], NDArray[Any]] | None = field(default=None, repr=False)
    _typical: FloatArray = field(default_factory=lambda: np.ones(0), repr=False)

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
        return np.asarray(self.harmonic(p, 0).real)

    def harmonic(self, p: float, m: int) -> NDArray[Any]:
        """<v^p exp(-i m phi)>(t) in U^p, complex for m > 0, shape (n_times,); solved when asked.

        Raises InputError for p or m out of range.
        """
        assert self._harmonic is not None
        return self._harmonic(p, m)

    def speed_density(self, v: ArrayLike) -> FloatArray:
        """Density of the speed at v (in U), shape (n_times, n_v), in 1/U; integral over v is 1.

        Without the delta peak of the tracers of a monoenergetic start that have not collided: see
        :attr:`uncollided`. Raises InputError for v negative or not finite, or if "speed_density"
        was not among the outputs.
        """
        return np.asarray(self._profile(0, "speed_density").continuous(_speeds(v)).real)

    @property
    def uncollided(self) -> FloatArray:
        """Share of tracers in the delta peak of a monoenergetic start, shape (n_times,).

        For e < 1 those that have not collided; at e = 1 all of them.

        Zero for other starts, whose uncollided tracers are part of :meth:`speed_density`.
        """
        peak = self._profile(0, "speed_density").peak_weight
        return np.zeros(self.times.shape) if peak is None else np.asarray(peak.real)

    def velocity_component_density(self, v_x: ArrayLike) -> FloatArray:
        """Density of one velocity component (isotropic part), shape (n_times, n), in 1/U.

        To 1e-8 of the maximum for smooth densities, to a percent near the steps of rough ones.
        With c_x = v_x/v0 the marginal F(c_x) of the paper's figure scalev; integral over v_x is 1.
        Raises InputError as :meth:`speed_density` does (v_x may be negative).
        """
        profile = self._profile(0, "speed_density")
        x = np.abs(_finite("v_x", v_x))
        out = np.empty((self.times.size, x.size))
        for i in range(self.times.size):
            unit = float(self._typical[i])

            def plane(v: FloatArray, i: int = i, unit: float = unit) -> FloatArray:
                # times the square of a typical speed, or it overflows late
                return np.asarray(profile.at(i, v).real * unit * (unit / v) / (2.0 * np.pi))

            out[i] = component_density(plane, x, unit) / unit / unit
        if profile.peak_speed is not None and profile.peak_weight is not None:
            room = profile.peak_speed**2 - x**2
            shape = np.where(room > 0.0, 1.0 / (np.pi * np.sqrt(np.where(room > 0, room, 1.0))), 0)
            out += profile.peak_weight.real[:, None] * shape
        return out

    def velocity_density(self, v: ArrayLike, phi: ArrayLike) -> FloatArray:
        """f(v, phi) in the velocity plane, shape (n_times, n_v, n_phi), in 1/U^2.

        The sum of the harmonics up to ``scene.harmonics``; integral of f v dv dphi is 1. Delta
        peaks in the speed are left out; v must be above 0. Raises InputError for bad v or phi, or
        if "velocity_density" was not among the outputs.
        """
        v_, phi_ = _speeds(v), _finite("phi", phi)
        if np.any(v_ == 0.0):
            raise InputError(f"v: got {short(v)}; speeds must be above 0 here")
        self._profile(0, "velocity_density")
        out = np.zeros((self.times.size, v_.size, phi_.size))
        for m, profile in self._profiles.items():
            turn = np.exp(1j * m * phi_) * (1.0 if m == 0 else 2.0)
            out += (profile.continuous(v_)[:, :, None] * turn).real
        return out / (2.0 * np.pi * v_[:, None])

    def _profile(self, m: int, output: str) -> Profile:
        if output not in self.scene.outputs and not (
            output == "speed_density" and "velocity_density" in self.scene.outputs
        ):
            raise InputError(
                f"outputs: {output!r} was not asked for; name it among the scene's outputs"
            )
        return self._profiles[m]


def _finite(name: str, values: ArrayLike) -> FloatArray:
    try:
        array = np.atleast_1d(np.asarray(values, dtype=float))
    except (TypeError, ValueError):
        array = np.array([np.nan])
    if array.ndim != 1 or not np.all(np.isfinite(array)):
        raise InputError(f"{name}: got {short(values)}; it must be finite numbers, 1-dimensional")
    return array


def _speeds(v: ArrayLike) -> FloatArray:
    array = _finite("v", v)
    if np.any(array < 0.0):
        raise InputError(f"v: got {short(v)}; speeds must not be negative")
    return array
