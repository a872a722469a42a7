"""The steady state of a driven tracer at one resolution, and as fine a one as a tolerance needs.

Distributions f, averages of the polynomials of the axis, obey -L^T f = 0 with mass 1. Where slow
impacts stick there is none: f is then the slowest decay, -L^T f = f/T, of the tracers that still
move. Begin with `SteadySolution`, or `solve_steady_until_converged`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import astuple, dataclass
from functools import cached_property, partial

import numpy as np

from kinetics.drive import Drive
from kinetics.driven.chebyshev_axis import ChebyshevSpeedAxis
from kinetics.driven.generator import Generator
from kinetics.driven.harmonics import Border, across, along, sum_over_harmonics
from kinetics.driven.resolution import ChebyshevResolution
from kinetics.driven.speed_range import collision_rate, top_speed
from kinetics.numerics import FloatArray
from kinetics.numerics.blocks import BlockElimination
from kinetics.numerics.gauss import gauss_legendre
from kinetics.numerics.refinement import RefinementRules, refine_until_converged
from kinetics.outputs import AVERAGES

#: Least error that is stated: two solutions may agree by chance, and this is ten times rounding.
MIN_ERROR = 1e-12
#: What errors are over differences where they fall slowly: under noise the density next to rest has
#: odd powers of v, where impacts begin to stick a root, and errors fall as a power of the number of
#: speeds. Largest ratio measured: 3.8 (commit 5f752db7).
SLOW_ERROR_FACTOR = 4.0
#: Speeds over the thermal one at which densities are compared.
COMPARED_SPEEDS = np.append([0.01, 0.02, 0.04, 0.07], np.linspace(0.1, 3.0, 60))
#: Angles to the field at which densities are compared.
COMPARED_ANGLES = np.array([0.0, 0.5 * math.pi, math.pi])
#: The share of tracers above the axis over rtol, in a field alone. Measured for e = 0, 0.3 and 0.7:
#: at a tenth and at ten times averages move by 2e-14, in the same time.
TAIL_IN_FIELD = 1e-5
#: The same under any other drive. Measured on eight drives at rtol 1e-6: at ten times the
#: relaxation rates move by 1e-4, at a tenth densities by 6e-6.
TAIL_ELSEWHERE = 0.01
#: The scale of the axis over its top, where a field alone drives. Measured for e = 0, 0.3 and 0.7:
#: at half averages move by 1e-11, at twice by 5e-14, in the same time.
SCALE_OVER_TOP_IN_FIELD = 0.2
#: The power p of the axis there: averages have terms v^n ln v, see `chebyshev_axis`.
AXIS_POWER_IN_FIELD = 2.0
#: Most iterations for the slowest decay. Measured on 12 systems: 12 is the median, 167 the most.
MAX_ITERATIONS = 400
#: Fewest points of the quadrature for averages of v^p with p < 0. Measured: at half and at twice
#: <v^-1/2> moves by 2e-14.
MIN_POINTS_OF_NEGATIVE_POWER = 200
#: The power by which these points gather at rest. Measured: at half and at twice <v^-1/2> moves by
#: 2e-15.
GATHERING_POWER_AT_REST = 12
#: An error is at least this fraction of the difference before: differences of the steady state fall
#: fast, as it is smooth. Chosen: at half and at twice some estimates are so, and no result moves.
MIN_RATIO_OF_STEADY_STATE = 0.01
#: The same, also over time, where tracers stick below a sharp speed: averages bend there, errors
#: fall slowly, and change sign (commit 316ac4dd).
MIN_RATIO_IF_STICKING = 1.0


@dataclass(frozen=True)
class SteadyFigures:
    """The numbers of a steady state, in units of l and of the speed of the drive.

    Parameters
    ----------
    thermal_speed : sqrt(<v^2>)
    a2 : d <v^4>/((d + 2) <v^2>^2) - 1
    drift : <v_x>
    mean_square_along : <v_x^2>
    collision_rate : collisions in a unit of time
    diffusion_parallel, diffusion_perpendicular : along the field and across it; NaN with sticking
    mobility : NaN with sticking
    """

    thermal_speed: float
    a2: float
    drift: float
    mean_square_along: float
    collision_rate: float
    diffusion_parallel: float
    diffusion_perpendicular: float
    mobility: float

    @property
    def of_velocity(self) -> FloatArray:
        """The figures that there are with sticking too, in the order of the fields."""
        return np.array(astuple(self)[:5])

    @property
    def all(self) -> FloatArray:
        """All figures, in the order of the fields."""
        return np.array(astuple(self))


class SteadySolution:
    """The steady state at one resolution; with sticking, that of the tracers that still move.

    Attributes
    ----------
    drive, resolution : what is solved, and how finely
    axis, generator : of the speeds, and the equation
    sums : averages of the polynomials of the axis, (M + 1, size); the sum of the first row is 1
    decay : the rate 1/T at which the number of tracers that still move falls; else 0
    finer : the next finer resolution; None where there is none
    """

    def __init__(self, drive: Drive, resolution: ChebyshevResolution) -> None:
        self.drive = drive
        self.resolution = resolution
        self.axis = _make_axis(drive, resolution)
        self.generator = Generator(drive, self.axis, resolution)
        self.finer = self.generator.finer
        v = self.axis.speeds
        some_distribution = v * np.exp(-v / v[v.size // 2])
        zero = np.zeros((resolution.harmonics + 1, v.size))
        if drive.capture_speed:
            self._solver = self.generator.chain.elimination()
            first = zero.copy()
            first[0] = some_distribution
            slowest = slowest_decay(self._solver, first, lambda f: f)
            self.sums = slowest.distribution
            self.decay = 1.0 / slowest.length
        else:
            border = Border(mass=np.ones(v.size), source=some_distribution)
            self._solver = self.generator.chain.elimination(border=border)
            self.sums = self._solver.solve(zero, 1.0)
            self.decay = 0.0

    def spent(self, source: FloatArray) -> FloatArray:
        """Return the time spent at each speed by tracers that start as a source (M + 1, size)."""
        return self._solver.solve(source)

    # -- averages ---------------------------------------------------------------------------------

    def is_resolved(self, p: float, m: int) -> bool:
        """Return whether v^p Y_m is a function as the axis has them: its average is a sum.

        In a bath these are polynomials in the components of the velocity; other powers bend at
        rest.
        """
        if p < 0.0:
            return False
        return not self.axis.smooth or (p >= m and (p - m) % 2.0 == 0.0)

    def average(self, p: float, m: int) -> float:
        """Return <v^p Y_m>; p may be any number above -d."""
        sums = self.sums[m]
        if self.is_resolved(p, m):
            return float(self.axis.speeds**p @ sums)
        d = self.drive.dimension
        if p >= 0.0:
            width = math.sqrt(self.average(2.0, 0) / d)
            return self.axis.power_average(sums, p, m % 2, d, width)
        x, x_weight = gauss_legendre(max(MIN_POINTS_OF_NEGATIVE_POWER, 4 * self.axis.size))
        power = GATHERING_POWER_AT_REST
        v = self.axis.highest * x**power
        weight = x_weight * power * x ** (power - 1.0) * self.axis.highest
        f = self.axis.density(self.sums[: m + 1], v, d)[m]
        return float((weight * v ** (p + d - 1.0)) @ f)

    @cached_property
    def figures(self) -> SteadyFigures:
        """The numbers of this steady state."""
        d = self.drive.dimension
        drift = np.float64(self.average(1, 1))
        second = np.float64(self.average(2, 0))
        fourth = np.float64(self.average(4, 0))
        cosine = self.average(2, 2) if self.generator.harmonics > 1 else 0.0
        response = self._response(float(drift))
        return SteadyFigures(
            thermal_speed=float(np.sqrt(second)),
            a2=float(d * fourth / ((d + 2.0) * second**2) - 1.0),
            drift=float(drift),
            mean_square_along=float((second + (d - 1.0) * cosine) / d),
            collision_rate=float(self.generator.rate @ self.sums[0]),
            diffusion_parallel=response.diffusion_parallel,
            diffusion_perpendicular=response.diffusion_perpendicular,
            mobility=response.mobility,
        )

    def _response(self, drift: float) -> LinearResponse:
        """Return the linear response to the velocity and to a further field."""
        if self.drive.capture_speed:
            return LinearResponse(math.nan, math.nan, math.nan)
        d = self.drive.dimension
        v = self.axis.speeds
        chain = self.generator.chain
        moved_along = v * along(self.sums, 0, d) - drift * self.sums
        moved_across = (v * across(self.sums, 0, d))[1:]
        response_across = chain.elimination(1).solve(moved_across)
        if self.drive.only_falls:  # speeds are in proportion to sqrt(g)
            mobility = 0.5 * drift / self.drive.field
        else:
            mobility = float(v @ self._solver.solve(chain.pulled(self.sums))[1])
        return LinearResponse(
            diffusion_parallel=float(v @ self._solver.solve(moved_along)[1]),
            diffusion_perpendicular=float(v @ response_across[0]),
            mobility=mobility,
        )

    @cached_property
    def depth(self) -> float:
        """Z, with which the share of tracers that get further down a field falls, exp(-x/Z)."""
        v = self.axis.speeds
        d = self.drive.dimension
        return slowest_decay(self._solver, self.sums, lambda f: v * along(f, 0, d)).length

    # -- differences from a coarser solution ------------------------------------------------------

    def difference(self, coarse: SteadySolution) -> dict[str, float]:
        """Return the largest difference of the figures from a coarser solution's, relative.

        1 + a2 for a2; the drift relative to the thermal speed, unless a field alone drives.
        """
        scale = np.abs(self.figures.all)
        scale[1] = 1.0
        if not self.drive.only_falls:
            scale[2] = self.figures.thermal_speed
        differences = np.abs(self.figures.all - coarse.figures.all) / scale
        if self.drive.capture_speed:
            n_of_velocity = self.figures.of_velocity.size
            decay_difference = abs(coarse.decay / self.decay - 1.0)
            differences = np.append(differences[:n_of_velocity], decay_difference)
            if self.drive.field:
                differences = np.append(differences, abs(coarse.depth / self.depth - 1.0))
        return {AVERAGES: _error_of(float(np.max(differences)) * self._error_factor)}

    def difference_of_densities(self, coarse: SteadySolution) -> dict[str, float]:
        """Return the largest difference of the mean density over directions, over its maximum."""
        d = self.drive.dimension
        v = COMPARED_SPEEDS * math.sqrt(self.average(2.0, 0))
        fine_density = self.axis.density(self.sums[:1], v, d)
        coarse_density = coarse.axis.density(coarse.sums[:1], v, d)
        scale = np.abs(fine_density).max() / self._error_factor
        return {AVERAGES: float(np.abs(fine_density - coarse_density).max() / scale)}

    def difference_over_angles(self) -> float:
        """Return how much the density differs, over its maximum, from a coarser solution's.

        At some angles to the field; the coarser solution is made for this. Next to rest refining
        helps little, as the averages that decide there are the least accurate.
        """
        d = self.drive.dimension
        v = COMPARED_SPEEDS * math.sqrt(self.average(2.0, 0))
        coarse = SteadySolution(self.drive, self.resolution.coarser)
        densities = [
            sum_over_harmonics(solution.axis.density(solution.sums, v, d), COMPARED_ANGLES, d)
            for solution in (self, coarse)
        ]
        difference = np.abs(densities[0] - densities[1]).max()
        return float(difference / np.abs(densities[0]).max())

    def moment_difference(self, coarse: SteadySolution, p: float, m: int) -> float:
        """Return the error of <v^p Y_m>, over <v^p>, from its difference from a coarser one.

        Drag gathers tracers at rest against the collisions there, at the rate nu(0): the density
        is as v^(nu(0)/drag - d), and the error falls as the number n of speeds to the power
        -(p + nu(0)/drag). So of the difference 1/((n/n_coarse)^(p + nu(0)/drag) - 1) is left.
        """
        scale = abs(self.average(p, 0))
        difference = abs(self.average(p, m) - coarse.average(p, m)) / scale
        if self.drive.drag:
            collisions_at_rest = float(collision_rate(self.drive, np.zeros(1))[0])
            order = p + collisions_at_rest / self.drive.drag
            growth = (self.axis.size / coarse.axis.size) ** order
            difference *= max(1.0, 1.0 / (growth - 1.0))
        return _error_of(difference)

    @property
    def _error_factor(self) -> float:
        """What errors are over differences."""
        falls_slowly = self.drive.heating or self.drive.sticks_sharply
        return SLOW_ERROR_FACTOR if falls_slowly else 1.0


@dataclass(frozen=True)
class LinearResponse:
    """Diffusion along the field and across it, and mobility; NaN where tracers stick."""

    diffusion_parallel: float
    diffusion_perpendicular: float
    mobility: float


def _make_axis(drive: Drive, resolution: ChebyshevResolution) -> ChebyshevSpeedAxis:
    """Return the axis of a steady state."""
    if drive.only_falls:
        top = top_speed(drive, TAIL_IN_FIELD * resolution.rtol)
        scale = SCALE_OVER_TOP_IN_FIELD * top
        power = AXIS_POWER_IN_FIELD
    else:
        top = top_speed(drive, TAIL_ELSEWHERE * resolution.rtol)
        scale = drive.scale
        power = 1.0
    return ChebyshevSpeedAxis(
        highest=top,
        scale=scale,
        size=resolution.nodes,
        power=power,
        smooth=drive.is_smooth_at_rest,
        fading=not drive.field or drive.capture_speed > 0.0,
    )


def _error_of(difference: float) -> float:
    """Return the error that a difference means; infinite where it is no number."""
    return max(difference, MIN_ERROR) if math.isfinite(difference) else math.inf


@dataclass(frozen=True)
class SlowestDecay:
    """The distribution that decays slowest, and the time, or length, in which it falls by e."""

    distribution: FloatArray
    length: float


def slowest_decay(
    solver: BlockElimination,
    f: FloatArray,
    weighted: Callable[[FloatArray], FloatArray],
) -> SlowestDecay:
    """Return f with -L^T f = weighted(f)/T and the longest T, by inverse iteration.

    Parameters
    ----------
    solver : of -L^T f = source
    f : with which to begin, (M + 1, size)
    weighted : what decays, of f

    Returns
    -------
    The sum of row 0 is 1; T is NaN if the iteration does not converge.
    """
    length = 0.0
    for _ in range(MAX_ITERATIONS):
        f = solver.solve(weighted(f))
        previous_length = length
        length = float(f[0].sum())
        f = f / length
        if abs(length - previous_length) <= 0.1 * MIN_ERROR * abs(length):
            return SlowestDecay(f, length)
    return SlowestDecay(f, math.nan)


def solve_steady_until_converged(
    drive: Drive,
    rtol: float,
    difference: Callable[
        [SteadySolution, SteadySolution], dict[str, float]
    ] = SteadySolution.difference,
) -> tuple[SteadySolution, float]:
    """Return the steady state of a drive, the best there is, and its relative error.

    Parameters
    ----------
    drive : in units of l
    rtol : relative error that is asked for
    difference : maps a solution and a coarser one to what they differ by, as {AVERAGES: ...}
    """
    span = math.asinh(top_speed(drive, rtol) / drive.scale)
    min_ratio = MIN_RATIO_IF_STICKING if drive.sticks_sharply else MIN_RATIO_OF_STEADY_STATE
    solution, errors = refine_until_converged(
        solve=partial(SteadySolution, drive),
        resolution=ChebyshevResolution.first(drive, rtol, span),
        difference=difference,
        tolerance={AVERAGES: rtol},
        rules=RefinementRules(min_ratio_to_previous=min_ratio),
    )
    return solution, errors[AVERAGES]
