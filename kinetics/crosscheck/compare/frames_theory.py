r"""The theory of the mean square displacement between two frames, M(s, t) = <|r(t) - r(s)|^2>.

Among dilute scatterers it is that of `Solution.displacement_between_frames`. Among hard disks

    M(s, t) = int f(v, s) B(v, t - s) dv,

with B the mean square displacement among hard disks of tracers of one speed, and f the density of
the speed at s, stretched so that its thermal speed is that of the averages. f is that among hard
disks; after a start with one speed, where it has none, it is that among dilute scatterers at the
time when these have the same thermal speed. What a tracer met before s and meets again after it is
not in it. The result is within 0.6 % of simulations at n = 0.04, e = 0.7 (Gaussian start, up to
400 d/U), and within 0.3 n at e = 0.4 to 0.9, n = 0.02 to 0.1.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kinetics.crosscheck.compare.observables import Array
from kinetics.crosscheck.compare.point import Point
from kinetics.crosscheck.data.sample import Law
from kinetics.numerics.gauss import panels_between
from kinetics.solution import Solution

#: Relative accuracy of the averages and densities: far below the error of any data.
RTOL = 1e-6
#: Relative accuracy of the density of the speed.
DENSITY_RTOL = 1e-5
#: First time of the table of B in l/U; B = v^2 t^2 below, to a thousandth.
SHORTEST_TIME = 1e-3
#: Its last time is that of the data for a speed of this, in U: no tracer of a Gaussian is faster.
LONGEST_SPEED = 12.0
#: Times of the table, even in the logarithm. Measured: with twice as many M moves by 4e-8 (e = 0.7,
#: n = 0.04, up to 400 d/U).
N_TIMES = 120
#: Lowest speed of the quadrature in U: of a Gaussian in the plane a share of 1e-12 is below.
LOWEST_SPEED = 1e-6
#: Highest speed: exp(-32) is above.
HIGHEST_SPEED = 8.0
#: Panels between them, even in the logarithm. Measured: with twice as many M moves by 7e-10.
N_PANELS = 30
#: Points of the Gauss rule of a panel.
POINTS_PER_PANEL = 8
#: Times of the table of the dilute thermal speed. Measured: with half or twice as many M moves by
#: 1e-4, a hundredth of the error of the theory.
N_SPEED_TIMES = 300

#: Solves a point: `theory.solve_at`.
Solver = Callable[..., Solution]


def mean_square_between_frames(
    point: Point, law: Law, earlier: Array, later: Array, solve_at: Solver
) -> Array:
    """Return M(s, t) in d^2 for pairs of times in d/U, shape (n_pairs,)."""
    if point.scatterers == "dilute":
        times, index = np.unique(np.concatenate([earlier, later]), return_inverse=True)
        solution = solve_at(point, law, times, ("speed_density",), RTOL)
        squares = solution.displacement_between_frames()
        return np.asarray(squares[index[: earlier.size], index[earlier.size :]])
    return _among_dense_scatterers(point, law, earlier, later, solve_at)


def _among_dense_scatterers(
    point: Point, law: Law, earlier: Array, later: Array, solve_at: Solver
) -> Array:
    from scipy.interpolate import CubicSpline

    path = point.path
    longest = LONGEST_SPEED * max(float(later.max()), path)
    table_times = np.geomspace(SHORTEST_TIME * path, longest, N_TIMES)
    of_one_speed = point.with_values(start="monoenergetic")
    msd = np.asarray(solve_at(of_one_speed, law, table_times, ("msd",), RTOL).msd)
    log_ratio = CubicSpline(np.log(table_times), np.log(msd / table_times**2))

    def squared_displacement(flown: Array) -> Array:
        """Return B of v t."""
        within = np.clip(flown, table_times[0], table_times[-1])
        return np.asarray(flown**2 * np.exp(log_ratio(np.log(within))))

    starts, index = np.unique(earlier, return_inverse=True)
    edges = np.geomspace(LOWEST_SPEED, HIGHEST_SPEED, N_PANELS + 1)
    speeds, weights = panels_between(edges, POINTS_PER_PANEL)
    solution = _solution_with_speeds(point, law, starts, solve_at)
    shares = solution.speed_density(speeds) * weights
    uncollided = np.asarray(solution.uncollided)  # of a start with one speed, U
    total = shares.sum(axis=1) + uncollided
    thermal_speed = np.asarray(solve_at(point, law, starts, ("thermal_speed",), RTOL).thermal_speed)
    stretch = thermal_speed / np.sqrt((shares @ speeds**2 + uncollided) / total)
    squares = np.empty(earlier.size)
    for pair, (start, duration) in enumerate(zip(index, later - earlier, strict=True)):
        flown_at_unit_speed = stretch[start] * duration
        mean = shares[start] @ squared_displacement(speeds * flown_at_unit_speed)
        mean += uncollided[start] * float(squared_displacement(np.array(flown_at_unit_speed)))
        squares[pair] = mean / total[start]
    return squares


def _solution_with_speeds(point: Point, law: Law, times: Array, solve_at: Solver) -> Solution:
    """Return a solution whose densities of the speed have the shape of those of a point at times.

    Among hard disks there is no density of the speed after a start with one speed.
    """
    outputs = ("speed_density",)
    if not point.has_one_speed:
        return solve_at(point, law, times, outputs, DENSITY_RTOL)
    dilute = point.with_values(scatterers="dilute")
    return solve_at(dilute, law, _dilute_times(point, law, times, solve_at), outputs, DENSITY_RTOL)


def _dilute_times(point: Point, law: Law, times: Array, solve_at: Solver) -> Array:
    """Return when dilute tracers have the thermal speed that those of a point have at times."""
    if point.restitution == 1.0 and law.tangential_restitution == 1.0:
        return times
    fine = np.geomspace(
        SHORTEST_TIME * point.path, 3.0 * float(times.max()) + point.path, N_SPEED_TIMES
    )
    fine = np.concatenate([[0.0], fine])
    dilute = point.with_values(scatterers="dilute")
    dilute_speed = np.asarray(solve_at(dilute, law, fine, ("thermal_speed",), RTOL).thermal_speed)
    speed = np.asarray(solve_at(point, law, times, ("thermal_speed",), RTOL).thermal_speed)
    dilute_times = np.interp(-speed, -dilute_speed, fine)
    return np.asarray(np.maximum.accumulate(dilute_times))  # rise, but for rounding at first
