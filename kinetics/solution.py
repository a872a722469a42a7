"""Solution: the frozen answer to a Scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.densities.harmonic import Profile
from kinetics.densities.marginal import component_density
from kinetics.errors import InputError, short
from kinetics.position.density import Displacement
from kinetics.scaling.scaled_vdf import SolverStatus
from kinetics.scene import Scene

FloatArray = NDArray[np.float64]

_FAST = 1e100  # typical speeds, that none has
_BEYOND = 1e6  # R from which G is nothing, and r may overflow


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
    _displacement: Displacement | None = field(default=None, repr=False)
    _scattering: Callable[[FloatArray, float | None], NDArray[Any]] | None = field(
        default=None, repr=False
    )
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
        :attr:`uncollided`. Right to rtol of its maximum above 1e-2 of the thermal speed; below it
        is the density of ln v that is. Raises InputError for v negative or not finite, or if
        "speed_density" was not among the outputs.
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

            out[i] = component_density(plane, np.minimum(x, _FAST * unit), unit) / unit / unit
        if profile.peak_speed is not None and profile.peak_weight is not None:
            room = profile.peak_speed**2 - np.minimum(x, 2.0 * profile.peak_speed) ** 2
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

    # -- position -----------------------------------------------------------------------------

    @property
    def ballistic_front(self) -> tuple[FloatArray, FloatArray]:
        """Tracers of a start of sharp speeds that have not collided: radius in d, and share.

        Shape (n_times, n_speeds) each: delta peaks, which :meth:`position_density` leaves out.
        n_speeds is 0 for a start that has a speed density.
        """
        found = self._position()
        return found.front_radius, found.front_weight

    def position_density(self, r: ArrayLike) -> FloatArray:
        """g(r, t), the radial density of the displacement (paper, fig. ``inelasticposi``), in 1/d.

        Shape (n_times, n_r). The integral over r is 1, less what :attr:`ballistic_front` holds. Its
        absolute error is max(rtol, 1e-8) over sqrt(<r^2>). Raises InputError for negative radii,
        or if "position_density" was not among the outputs.
        """
        found, r_ = self._position(), _not_negative("r", r)
        return np.array([found.density(i, r_) for i in range(self.times.size)])

    def scaled_position_density(self, scaled_radii: ArrayLike) -> FloatArray:
        """G(R) = sqrt(<r^2>) g(r, t) at R = r/sqrt(<r^2>), shape (n_times, n_R).

        NaN at t = 0, where all tracers are at the origin. Raises InputError for negative R.
        """
        found, x = self._position(), _not_negative("scaled_radii", scaled_radii)
        out = np.full((self.times.size, x.size), np.nan)
        for i, root in enumerate(found.root_mean_square):
            if root > 0.0:
                out[i] = root * found.density(i, np.minimum(x, _BEYOND) * root)
        return out

    def position_fraction(self, edges: ArrayLike) -> FloatArray:
        """Share of all tracers with r between the edges, in d: shape (n_times, n_edges - 1).

        For histograms: the ballistic front is in it, in (low, high]. Raises InputError for edges
        that are negative or do not rise.
        """
        found, r = self._position(), _not_negative("edges", edges)
        if r.size < 2 or np.any(np.diff(r) <= 0.0):
            raise InputError(f"edges: got {short(edges)}; they must rise, two at least")
        return np.array([np.diff(found.within(i, r)) for i in range(self.times.size)])

    def position_tail(self, scaled_radii: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """How the density p = G(R)/(2 pi R) in the plane falls at R: its exponent and its rate.

        Both of shape (n_times, n_R), for R > 0. With p ~ exp(-(R/b)^n) the exponent is n: 2 for a
        Gaussian, 1 for an exponential. It is d ln(ln(p(0)/p(R)))/d ln R, and the rate -d ln p/dR.
        Tracers that have not collided are left out. NaN where p is below its error. Raises
        InputError as :meth:`scaled_position_density` does.
        """
        found, x = self._position(), _not_negative("scaled_radii", scaled_radii)
        exponent = np.full((self.times.size, x.size), np.nan)
        rate = np.full_like(exponent, np.nan)
        for i, root in enumerate(found.root_mean_square):
            if root == 0.0:
                continue
            p, slope = found.collided_in_plane(i, np.minimum(x, _BEYOND) * root)
            center, _ = found.collided_in_plane(i, np.zeros(1))
            floor = found.error_estimate / (2.0 * np.pi * np.maximum(x, 0.1) * root**2)
            with np.errstate(divide="ignore", invalid="ignore"):
                good = (p > floor) & (x > 0.0)
                rate[i] = np.where(good, -root * slope / p, np.nan)
                exponent[i] = np.where(good, x * rate[i] / np.log(center / p), np.nan)
        return exponent, rate

    def intermediate_scattering(
        self, wave_numbers: ArrayLike, direction: float | None = None
    ) -> NDArray[Any]:
        """F(k, t) = <exp(i k.r)> for k in 1/d, shape (n_times, n_k), to max(rtol, 1e-12) absolute.

        ``direction`` is the angle of k to the x axis, in radians, for directed starts, where F is
        complex; by default F is the mean over the directions of k, and real. Raises InputError for
        wave numbers that are none, negative, not finite or larger than can be solved for, or if
        "intermediate_scattering" was not among the outputs.
        """
        if self._scattering is None:
            raise InputError(
                "outputs: 'intermediate_scattering' was not asked for; name it among the scene's "
                "outputs"
            )
        k = _not_negative("wave_numbers", wave_numbers)
        if direction is not None and not np.isfinite(direction):
            raise InputError(f"direction: got {short(direction)}; it must be a finite angle")
        return self._scattering(k, direction)

    def _position(self) -> Displacement:
        if self._displacement is None:
            raise InputError(
                "outputs: 'position_density' was not asked for; name it among the scene's outputs"
            )
        return self._displacement

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


def _not_negative(name: str, values: ArrayLike) -> FloatArray:
    array = _finite(name, values)
    if array.size == 0 or np.any(array < 0.0):
        raise InputError(f"{name}: got {short(values)}; give at least one, none negative")
    return array


def _speeds(v: ArrayLike) -> FloatArray:
    array = _finite("v", v)
    if np.any(array < 0.0):
        raise InputError(f"v: got {short(v)}; speeds must not be negative")
    return array
