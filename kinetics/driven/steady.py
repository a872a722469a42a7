"""solve_steady and its answer: the steady state of a driven tracer."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import astuple, dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics.driven.axis import SpeedAxis
from kinetics.driven.generator import Generator, Resolution
from kinetics.driven.heated import Line, density, log_moment
from kinetics.driven.system import System
from kinetics.errors import InputError, PlanStep, SolverStatus, judged
from kinetics.field.starts import angular
from kinetics.numerics import FloatArray, one_blas_thread
from kinetics.numerics.blocks import BlockElimination
from kinetics.numerics.gauss import gauss_legendre
from kinetics.results import Result, dataset, variable
from kinetics.validation import (
    check_rtol,
    finite_line,
    real_number,
    refuse,
    speeds,
    whole_number,
)

_FLOOR = 1e-12  # below it two solutions may agree by chance: ten times what rounding makes
_MOST_NODES, _MOST_HARMONICS = 150, 70
_MOST_TURNS, _SETTLED = 400, 1e-13  # of the iteration for the slowest decay, when tracers stick
_HIGHEST_POWER = 20.0
_WORSE = 10.0  # by so much an error may be larger than one before, and finer ones are tried
# Under noise the density next to rest has odd powers of v: errors fall as a power of the number of
# speeds, and more is left than the difference of two solutions
_SLOWLY = 3.0
_LONG = 5.0  # the highest speed over the scale of the axis, where only a field drives
_FIGURES = {
    "thermal_speed": ("1", "sqrt(<v^2>)"),
    "a2": ("1", "d <v^4>/((d + 2) <v^2>^2) - 1"),
    "drift": ("1", "<v_x>, along the field"),
    "mean_square_along": ("1", "<v_x^2>"),
    "collision_rate": ("1/l", "collisions in a unit of time"),
    "diffusion_parallel": ("l", "half the growth of the variance along the field"),
    "diffusion_perpendicular": ("l", "the same in one direction across the field"),
    "mobility": ("l", "what a small further field adds to the drift, over that field"),
}
"""Figures -> unit, where speeds have none, and words."""


class Steady:
    """The steady state at one resolution; with sticking, that of the tracers that still move."""

    def __init__(self, system: System, resolution: Resolution) -> None:
        alone, fading = system.only_falls, not system.field or system.capture_speed > 0.0
        top = system.top((1e-5 if alone else 0.01) * resolution.rtol)
        scale, power = (top / _LONG, 2.0) if alone else (system.scale, 1.0)
        smooth = system.bath_speed > 0.0
        self.axis = axis = SpeedAxis(top, scale, resolution.nodes, power, smooth, fading)
        self.generator = one = Generator(system, axis, resolution)
        v, self.system, self.resolution = axis.speeds, system, resolution
        nothing = np.zeros((resolution.harmonics + 1, v.size))
        self.decay = 0.0
        if system.capture_speed:
            along = one.elimination()
            start = nothing.copy()
            start[0] = v * np.exp(-v / v[v.size // 2])
            self.sums, time = _slowest(along, start, lambda f: f)
            self.decay = 1.0 / time
        else:
            along = one.elimination(border=v * np.exp(-v / v[v.size // 2]))
            self.sums = along.solve(nothing, 1.0)
        self.along = along

    def average(self, p: float, m: int) -> float:
        """<v^p Y_m>; p may be any number above -d."""
        sums, v = self.sums[m], self.axis.speeds
        if p >= 0.0 and (float(p).is_integer() or self.axis.power > 1.0):
            return float(v**p @ sums)
        x, w = gauss_legendre(max(200, 4 * v.size))
        d, power = self.system.dimension, 12
        speed, weight = self.axis.top * x**power, w * power * x ** (power - 1.0) * self.axis.top
        f = self.axis.density(self.sums[: m + 1], speed, d)[m]
        return float((weight * speed ** (p + d - 1.0)) @ f)

    @cached_property
    def figures(self) -> FloatArray:
        """The values of _FIGURES, (8,)."""
        one, v, d = self.generator, self.axis.speeds, self.system.dimension
        drift, second, fourth = self.average(1, 1), self.average(2, 0), self.average(4, 0)
        turned = self.average(2, 2) if one.harmonics > 1 else 0.0
        rate = float(one.rate @ self.sums[0])
        spread = [math.nan] * 3
        if not self.system.capture_speed:
            along = self.along.solve(one.along(self.sums) - drift * self.sums)
            across = one.elimination(1).solve(one.across(self.sums)[1:])
            spread = [float(v @ along[1]), float(v @ across[0])]
            if self.system.only_falls:  # speeds are in proportion to sqrt(g)
                spread += [0.5 * drift / self.system.field]
            else:
                spread += [float(v @ self.along.solve(one.pulled(self.sums))[1])]
        excess = d * fourth / ((d + 2.0) * second**2) - 1.0
        square = (second + (d - 1.0) * turned) / d
        return np.array([math.sqrt(second), excess, drift, square, rate, *spread])

    @cached_property
    def depth(self) -> float:
        """Z, with which the share of tracers that get further down a field falls, exp(-x/Z)."""
        start = self.sums.copy()
        return _slowest(self.along, start, self.generator.along)[1]

    def error(self, coarse: Steady) -> float:
        """The largest difference of the figures from a coarser solution's, relative to each.

        1 + a2 for a2; the drift relative to the thermal speed, unless a field alone drives.
        """
        scale = np.abs(self.figures)
        scale[1] = 1.0
        if not self.system.only_falls:
            scale[2] = self.figures[0]
        apart = np.abs(self.figures - coarse.figures) / scale
        if self.system.capture_speed:
            apart = np.append(apart[:5], abs(coarse.decay / self.decay - 1.0))
            if self.system.field:
                apart = np.append(apart, abs(coarse.depth / self.depth - 1.0))
        worst = float(np.max(apart))
        if self.system.heating and not self.system.bath_speed:
            worst *= _SLOWLY
        return max(worst, _FLOOR) if math.isfinite(worst) else math.inf


def _slowest(
    elimination: BlockElimination, f: FloatArray, weighed: Callable[[FloatArray], FloatArray]
) -> tuple[FloatArray, float]:
    """f with -L^T f = weighed(f)/T and the longest T: its sum is 1, and T; NaN if not found."""
    size = 0.0
    for _ in range(_MOST_TURNS):
        f = elimination.solve(weighed(f))
        before, size = size, float(f[0].sum())
        f = f / size
        if abs(size - before) <= _SETTLED * abs(size):
            return f, size
    return f, math.nan


def refined(system: System, rtol: float) -> tuple[Steady, float]:
    """The first solution that differs from a coarser one by less than rtol, or the best; its error.

    It is solved with one BLAS thread if the caller says so.
    """
    span = math.asinh(system.top(rtol) / system.scale)
    last = fine = Steady(system, Resolution.first(system, rtol, span))
    error, more = math.inf, fine.resolution.finer()
    while error > rtol and more.nodes <= _MOST_NODES and more.harmonics <= _MOST_HARMONICS:
        before, last = last, Steady(system, more)
        more = more.finer()
        if (found := last.error(before)) < error:
            fine, error = last, found
        elif found > _WORSE * error:  # rounding grows with the number of speeds
            break
    return fine, error


@dataclass(frozen=True)
class DrivenState(Result):
    """The steady state of a driven tracer, in the limit of low density; made by `solve_steady`.

    Lengths are in the mean free path l; the unit of speed is that of the arguments, and times are
    in l over it. Where slow impacts stick, averages are over the tracers that still move, after a
    long time.

    Attributes
    ----------
    restitution, dimension, bath_speed, mass_ratio, heating, drag, field, capture_speed, rtol : what
        was asked for
    thermal_speed : sqrt(<v^2>)
    a2 : d <v^4>/((d + 2) <v^2>^2) - 1
    drift : <v_x>, along the field
    mean_square_along : <v_x^2>
    collision_rate : collisions in a unit of time
    diffusion_parallel, diffusion_perpendicular : half the growth rate of the variance along the
        field and across it, the same without a field; NaN where tracers stick
    mobility : what a small further field adds to the drift, over that field; NaN where they stick
    capture_time, capture_depth : of tracers that stick, the time T and, in a field, the distance Z
        in which the number of those that still move falls by a factor e; else infinite
    error_estimate : relative error of these figures, the difference of two resolutions
    status, message : SolverStatus, and in words what misses its tolerance and what to change
    plan, stats : what was solved, and numbers about the work
    """

    restitution: Any
    dimension: int
    bath_speed: float
    heating: float
    drag: float
    field: float
    capture_speed: float
    rtol: float
    thermal_speed: float
    a2: float
    drift: float
    mean_square_along: float
    collision_rate: float
    diffusion_parallel: float
    diffusion_perpendicular: float
    mobility: float
    capture_time: float
    capture_depth: float
    error_estimate: float
    status: SolverStatus
    message: str
    plan: tuple[PlanStep, ...]
    stats: Mapping[str, Any]
    _resolution: tuple[int, int, int, float]
    mass_ratio: float = math.inf

    @property
    def mean_square_speed(self) -> float:
        """<v^2>."""
        return self.thermal_speed**2

    @property
    def diffusion_coefficient(self) -> float:
        """D, half the growth rate of the variance in one direction, averaged over directions."""
        d = self.dimension
        return (self.diffusion_parallel + (d - 1.0) * self.diffusion_perpendicular) / d

    @property
    def system(self) -> System:
        """What drives the tracer."""
        law = self.restitution
        names = ("dimension", "mass_ratio", "bath_speed", "heating", "drag", "field")
        values = {name: getattr(self, name) for name in (*names, "capture_speed")}
        return System.checked(law, values.pop("dimension"), values.pop("mass_ratio"), **values)

    @cached_property
    def _fine(self) -> Steady:
        """Where it was not kept, as in a loaded or pickled state, it is solved again."""
        return Steady(self.system, Resolution(*self._resolution))

    def moment(self, p: float, m: int = 0) -> float:
        """<v^p cos(m phi)>, phi the angle to the field; in space <v^p P_m(cos phi)>.

        p is real, above -d and up to 20. The error is about ``error_estimate`` for p from 0 to 4.
        Raises InputError for p or m out of range.
        """
        m = whole_number("m", m, 0, self._fine.resolution.harmonics)
        low = math.nextafter(-float(self.dimension), 0.0)
        allowed = f"it must be above -{self.dimension}, and at most {_HIGHEST_POWER:g}"
        p = real_number("p", p, low, _HIGHEST_POWER, allowed)
        law, unit = self.system.law, self.heating ** (1.0 / 3.0)
        if m == 0 and law is not None and self.system.only_heats:
            return float(unit**p * np.exp(log_moment(law, np.array([p]))[0].real))
        return self._fine.average(p, m)

    def vdf(self, v: ArrayLike, angle: ArrayLike = 0.0) -> FloatArray:
        """The density of the velocity, shape (n_v, n_angle); its integral is 1.

        v : speeds; angle : to the field, in radians. Raises InputError for others. If noise alone
        drives, it is a closed form, to some 1e-12 of itself. Else its error is about 1e-5 of the
        maximum, less for a smaller rtol, but in space 1e-2 for those nearly at rest, below a tenth
        of the thermal speed; and in a field without noise or bath it is more in the direction of
        the field.
        """
        v_, phi = speeds(v), finite_line("angle", angle)
        d, law, unit = self.dimension, self.system.law, self.heating ** (1.0 / 3.0)
        if law is not None and self.system.only_heats:
            f = density(law, v_ / unit, self._lines) / unit**d
            return np.repeat(f[:, None], phi.size, axis=1)
        one = self._fine
        return angular_sum(one.axis.density(one.sums, v_, d), phi, d)

    @cached_property
    def _lines(self) -> list[Line]:
        return []

    def capture_from(self, speed: float = 0.0) -> tuple[float, float, float]:
        """Mean distance along the field, time and collisions until tracers of this speed stick.

        They start in all directions alike. Raises InputError where nothing sticks.
        """
        if not self.capture_speed:
            refuse("capture_speed", self.capture_speed, "it must be above 0: no impact sticks")
        speed = real_number("speed", speed, 0.0)
        one = self._fine
        start = np.zeros_like(one.sums)
        start[0] = one.axis.rows(np.array([speed]))[0]
        spent = one.along.solve(start)
        depth = float(spent[1] @ one.axis.speeds)
        return depth, float(spent[0].sum()), float(spent[0] @ one.generator.rate)

    def relaxation_rates(self, n: int = 1, m: int = 0) -> FloatArray:
        """The n lowest rates with which disturbances of harmonic m decay, rising, shape (n,).

        m = 0 is the energy, m = 1 the momentum. In a bath there are few below the lowest collision
        rate, where the continuous spectrum begins: the others are NaN. Raises InputError for a
        state in a field.
        """
        if self.field:
            refuse("field", self.field, "relaxation rates are available without a field")
        n = whole_number("n", n, 1, 20)
        m = whole_number("m", m, 0, self._fine.resolution.harmonics)
        one = self._fine.generator
        found = np.sort(-np.linalg.eigvals(one.matrices[m]).real)
        found = found[1:] if m == 0 and not self.capture_speed else found
        if not self.heating:
            found = found[found < (1.0 - 1e-3) * one.rate.min()]
        out = np.full(n, math.nan)
        out[: found[:n].size] = found[:n]
        return out

    # -- how it shows itself ----------------------------------------------------------------------

    _points, _on_demand = ("speeds", "angles"), ("vdf",)

    def _asked(self) -> dict[str, Any]:
        names = ("restitution", "dimension", "bath_speed", "mass_ratio", "heating", "drag", "field")
        return {name: getattr(self, name) for name in (*names, "capture_speed")}

    def _dataset(self, only: Collection[str] | None = None, **points: Any) -> Any:
        """Points: speeds, and angles to the field in radians."""
        title = f"Steady state of a driven tracer: {self._asked()}; unit of length l"
        asked = {name: str(value) for name, value in self._asked().items()}
        points.setdefault("speeds", np.linspace(0.0, 4.0, 161) * self.thermal_speed)
        points.setdefault("angles", np.array([0.0, 0.5, 1.0]) * np.pi if self.field else [0.0])
        return velocity_dataset(self, title, asked, _FIGURES, only, **points, units=("1", "1"))

    def __repr__(self) -> str:
        asked = self._asked()
        shown = ", ".join(f"{k}={v!r}" for k, v in asked.items() if v not in (0.0, math.inf))
        figures = ", ".join(f"{name} = {getattr(self, name):.10g}" for name in _FIGURES)
        return f"DrivenState({shown}), unit of length l\n  {figures}\n  {self.message}"


def angular_sum(f: FloatArray, angle: FloatArray, dimension: int) -> FloatArray:
    """The density at angles, (n_v, n_angle), of harmonics (M + 1, n_v) as averages have them."""
    m = np.arange(len(f))[:, None]
    tables = angular(np.cos(angle), np.sin(angle), max(len(f), 2), dimension, 1)[0][: len(f)]
    norms = np.where(m == 0, 1.0, 2.0) if dimension == 2 else 2.0 * m + 1.0
    return np.asarray(f.T @ (norms * tables) / (2.0 * math.pi * (dimension - 1.0)))


def velocity_dataset(
    state: Any,
    title: str,
    question: Any,
    figures: Mapping[str, tuple[str, ...]],
    only: Collection[str] | None,
    speeds: ArrayLike,
    angles: ArrayLike,
    units: tuple[str, str],
) -> Any:
    """The dataset of a steady state: its figures, and its density at speeds and angles.

    figures : name -> unit and words; units : of the speed, and of the density
    """
    v, phi = finite_line("speeds", speeds), finite_line("angles", angles)
    found = {name: variable((), getattr(state, name), *about) for name, about in figures.items()}
    if only is None or "vdf" in only:
        words = "density of the velocity"
        found["vdf"] = variable(("angle", "v"), state.vdf(v, phi).T, units[1], words, "f")
    axes = {"v": variable(("v",), v, units[0], "speed")}
    axes |= {"angle": variable(("angle",), phi, "rad", "angle to the field")}
    return dataset(
        title,
        question,
        found,
        axes,
        status=state.status.name.lower(),
        message=state.message,
        tolerance_asked=state.rtol,
        tolerance_reached=state.error_estimate,
    )


@one_blas_thread
def solve_steady(
    restitution: Any,
    dimension: int = 2,
    bath_speed: float = 0.0,
    mass_ratio: float = math.inf,
    heating: float = 0.0,
    drag: float = 0.0,
    field: float = 0.0,
    capture_speed: float = 0.0,
    rtol: float = 1e-10,
) -> DrivenState:
    """The steady state of a tracer that a bath, noise or a field keeps moving, at low density.

    Parameters
    ----------
    restitution : e in [0, 1]; or a function of the normal impact speed: `kinetics.Viscoelastic`, a
        Python function of an array, or a table (impact speeds, values)
    dimension : 2 (disks) or 3 (spheres); smooth ones
    bath_speed : w, the standard deviation of each component of the scatterers' velocities
    mass_ratio : of a scatterer over the tracer; inf for infinitely heavy ones
    heating : D_v of white noise, <dv_i dv_j> = 2 D_v delta_ij dt
    drag : gamma, in dv/dt = -gamma v
    field : a uniform acceleration along x
    capture_speed : v_c; impacts whose normal speed is below it stick
    rtol : relative accuracy asked of the figures, 1e-14 to 0.1; 1e-12 is the best that there is

    Lengths are in the mean free path l; speeds in any unit, times in l over it.

    Returns
    -------
    DrivenState : moments, density, diffusion, mobility and relaxation

    Raises
    ------
    InputError (a ValueError) : an argument out of range, or a system without a steady state, as
        nothing gives it energy, or nothing takes it

    >>> state = solve_steady(restitution=0.5, bath_speed=1.0)  # <v_x^2> = w^2 (1 + e)/(1 - e)
    >>> round(state.mean_square_along, 9), state.status.name
    (3.0, 'CONVERGED')
    """
    rtol = check_rtol(rtol)
    drives = {"bath_speed": bath_speed, "heating": heating, "drag": drag, "field": field}
    system = System.checked(
        restitution, dimension, mass_ratio, **drives, capture_speed=capture_speed
    )
    if not system.is_driven:
        raise InputError(
            "bath_speed: got 0; without bath_speed, heating or field tracers cool for ever, and "
            "reach no steady state: see solve_scaled"
        )
    if not system.takes_energy:
        allowed = "collisions keep the energy, and drag is 0: no steady state is reached"
        refuse("restitution", restitution, allowed)
    fine, error = refined(system, rtol)
    status, message = judged({"averages": error}, {"averages": rtol})
    one = fine.resolution
    plan = (
        PlanStep("speeds", True, f"{one.nodes} points up to {fine.axis.top:.3g}"),
        PlanStep("angular harmonics", True, f"0 to {one.harmonics}"),
        PlanStep("dispersion", not system.capture_speed, "the linear response to the velocity"),
    )
    sticks = bool(system.capture_speed)
    state = DrivenState(
        **{name: getattr(system, name) for name in ("restitution", "dimension", "mass_ratio")},
        **{name: getattr(system, name) for name in (*drives, "capture_speed")},
        rtol=rtol,
        **dict(zip(_FIGURES, fine.figures.tolist(), strict=True)),
        capture_time=1.0 / fine.decay if sticks else math.inf,
        capture_depth=fine.depth if sticks and field else math.inf,
        error_estimate=error,
        status=status,
        message=message,
        plan=plan,
        stats={"nodes": one.nodes, "harmonics": one.harmonics, "highest_speed": fine.axis.top},
        _resolution=astuple(one),
    )
    state.__dict__["_fine"] = fine  # as if asked for
    return state
