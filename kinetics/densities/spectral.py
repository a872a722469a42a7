r"""Solves for a harmonic of the velocity density spectrally, on a logarithmic speed axis.

v is the speed, l the mean free path; f is the harmonic, g = v f the density of ln v. On equidistant
nodes of x = ln v a smooth density is resolved to rounding by some hundred of them
(`spectral_grid`). Its collisions are taken out of the equation (`intertwining`), so that any time
follows at once. The error is the difference of two such solutions, on nodes of which some coincide.
Begin with :func:`solve_spectral`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetics.densities.grid_density import GridDensity, from_rows, to_rows
from kinetics.densities.harmonic import HarmonicArray, HarmonicProblem, Profile
from kinetics.densities.intertwining import intertwine
from kinetics.densities.spectral_grid import (
    COARSE_NODES,
    COARSE_WINDOW_HIGHER,
    FINE_NODES,
    SMALL_RATIO,
    SpectralProblem,
    choose_grid,
    resolve_start,
    speed_window,
    unresolved_fraction,
)
from kinetics.densities.turned_axis import SHARE_OF_SMALL_ERROR
from kinetics.errors import InputError
from kinetics.numerics import FOLDS, FloatArray
from kinetics.numerics.log_grid import LogGrid

#: Error of the initial speeds over the tolerance. Chosen: at half and at twice f moves
#: by 4e-8 of its largest at most (rtol 1e-8, speeds from 1e-3 U).
START_RTOL_OVER_RTOL = 1e-3
#: Where nodes are too few for what is aimed at, a hundred times less is aimed at, and so on, up to
#: this: the conservative method has no such digits (commit 27883ef1). Chosen.
LOOSEST_AIM = 1e-4
#: Factor by which less is aimed at, each time. Origin not recorded.
AIM_FACTOR = 100.0
#: Where the first solution misses the tolerance, a second one aims at this fraction of it, ...
SECOND_AIM_OVER_RTOL = 0.03
#: ... with this tilt. Where v t/l goes on oscillating, or tracers forwards, u oscillates at low
#: speeds, or stays, for long: with a tilt it falls, but rounding grows as t^tilt. Chosen.
SECOND_TILT = 0.25
#: Least error that is stated: for the rounding that two solutions may have in common. Measured: up
#: to 2e-13 of it.
MIN_ERROR = 5e-13
#: Least error that is stated over what is aimed at, below which the low end is cut off. Chosen:
#: half of it halves the smallest estimates.
MIN_ERROR_OVER_AIM = 0.1
#: An error with which all is lost, so that the conservative method is tried. Chosen: a density a
#: tenth off is none; at a tenth and at twice nothing moves for smooth starts.
LOST_ERROR = 0.1
#: Most times at which two solutions are compared. It was 8 before (commit 39e460d0); with 3 some
#: estimates are 0.88 of what they are, with 12 none differs.
MAX_COMPARED_TIMES = 6
#: Speed in root mean square speeds above which a density is right relative to its maximum; below,
#: the density of ln v is. Chosen; it is stated in `Solution.speed_density`.
LOWEST_SPEED = 1e-2
#: Harmonics m > 0 die away: their errors are relative to a density of ln v with this maximum; the
#: isotropic one has a larger. Chosen: at half and at twice no estimate differs, where it was
#: measured for `spectral_grid`.
LEAST_MAXIMUM = 0.3
#: Where bounces lead to any speed, f is a polynomial below `LOWEST_SPEED` over this. Chosen: at
#: half and at twice f moves by less than its rounding above `LOWEST_SPEED`.
FILLED_BELOW_LOWEST = 10.0
#: Stands for 0 in a denominator: close to the smallest number.
TINY = 1e-300


def solve_spectral(problem: HarmonicProblem) -> Profile | None:
    """Solve for the harmonic at the times, e < 1.

    A requested number of nodes counts as the next multiple of ten.

    Returns
    -------
    The profile, with an error estimate relative to the maximum of f; None where the state is too
    rough for this method.

    Raises
    ------
    InputError
        Where it would take too many nodes.
    """
    rtol = problem.rtol
    speeds = problem.state.harmonic(0, START_RTOL_OVER_RTOL * rtol)
    start = problem.state.profile(problem.m)
    if speeds is None or start is None:
        return None
    spectral = SpectralProblem.of(problem, start, speeds)
    profile = _solve_at_least_loosely(spectral)
    if profile is None:
        return None
    is_late = float(spectral.tau[-1]) > FOLDS
    if profile.error_estimate > rtol and problem.nodes is None and not is_late:
        tilted = _solve_tilted(spectral)
        if tilted is not None and tilted.error_estimate < profile.error_estimate:
            profile = tilted
    has_other_method = problem.nodes is None and problem.law.medium is None
    if has_other_method and profile.error_estimate > LOST_ERROR:
        return None
    return profile


def _solve_at_least_loosely(problem: SpectralProblem) -> Profile | None:
    """Solve for the tolerance, or for the first of ever looser aims that nodes suffice for.

    None where the start is too rough, InputError where nodes are too many, for the loosest aim.
    """
    aims = [problem.harmonic.rtol]
    if problem.harmonic.nodes is None:
        aims += _looser_aims(problem.harmonic.rtol)
    refusal: InputError | None = None
    for aim in aims:
        refusal = None
        try:
            profile = _solve(problem.aiming_at(aim, 0.0))
        except InputError as error:
            refusal = error
            continue
        if profile is not None:
            return profile
    if refusal is not None:
        raise refusal
    return None


def _looser_aims(rtol: float) -> list[float]:
    """Return rtol times `AIM_FACTOR`, its square, and so on, up to `LOOSEST_AIM`."""
    aims = []
    factor = AIM_FACTOR
    while factor * rtol <= LOOSEST_AIM:
        aims.append(factor * rtol)
        factor *= AIM_FACTOR
    return aims


def _solve_tilted(problem: SpectralProblem) -> Profile | None:
    """Return the second solution, with a tilt; None where it takes too many nodes."""
    aim = SECOND_AIM_OVER_RTOL * problem.harmonic.rtol
    try:
        return _solve(problem.aiming_at(aim, SECOND_TILT))
    except InputError:
        return None


def _solve(problem: SpectralProblem) -> Profile | None:
    """Solve for one aim and tilt; None where the start is too rough.

    InputError where nodes are too many.
    """
    harmonic = problem.harmonic
    law = harmonic.law
    window = speed_window(law, problem.speeds, problem.aim, float(problem.tau[-1]))
    start_grid = resolve_start(problem, window)
    if start_grid is None:
        return None
    grid, angle = choose_grid(problem, start_grid)
    is_bounded = harmonic.m == 0 or law.least_ratio >= SMALL_RATIO or problem.tilt > 0.0
    lowest_x = window.low if is_bounded else grid.start
    fine, coarse = _solve_twice(problem, grid, angle, lowest_x)
    errors = _compare(problem, fine, coarse)
    error = max(errors.of_f, MIN_ERROR, MIN_ERROR_OVER_AIM * problem.aim)
    if harmonic.nodes is not None:
        # few nodes may agree, and say nothing of what is between
        error = max(error, unresolved_fraction(to_rows(fine.g)))
    filled = None
    if harmonic.m == 0 and law.reaches_rest:
        filled = _log_lowest_speed(problem) + problem.log_unit - math.log(FILLED_BELOW_LOWEST)
    density = GridDensity(
        grid=grid,
        values=fine.g,
        shift=fine.shift - problem.log_unit,
        start=lowest_x,
        end=window.high + grid.spacing,
        resolved=max(SHARE_OF_SMALL_ERROR * problem.aim, errors.of_g),
        filled=filled,
    )
    return Profile(density, problem.tau.size, "spectral", grid.nodes, error)


@dataclass(frozen=True)
class _GridSolution:
    """g at nodes at some times.

    Parameters
    ----------
    grid : nodes of x
    times : indices of the times, shape (n_times,)
    shift : x - ln(v/v_rms), shape (n_times,)
    g : density of ln v, shape (n_times, n_nodes)
    """

    grid: LogGrid
    times: NDArray[np.intp]
    shift: FloatArray
    g: HarmonicArray

    def without_tilt(self, tilt: float, lowest_x: float) -> _GridSolution:
        """Return the density of ln v itself, and 0 below the lowest x, where rounding is raised."""
        if not tilt:
            return self
        tilting = np.exp(-tilt * (self.grid.x - self.shift[:, None]))
        g = self.g * tilting * (self.grid.x >= lowest_x)
        return _GridSolution(self.grid, self.times, self.shift, g)


def _solve_twice(
    problem: SpectralProblem, grid: LogGrid, angle: float, lowest_x: float
) -> tuple[_GridSolution, _GridSolution]:
    """Return the solution, and a coarser one at a few times, to compare.

    That has the same wave numbers, but fewer of them, and a window that ends higher up.
    """
    tau = problem.tau
    gain = problem.gain(grid.wave_numbers)
    fine_state = intertwine(grid, problem.start_on(grid), gain, angle, problem.has_pole)
    n_moved, fine_rows = fine_state.at(tau, FINE_NODES)
    shift = n_moved * grid.spacing
    fine = _GridSolution(grid, np.arange(tau.size), shift, from_rows(fine_rows))
    n_compared = min(tau.size, MAX_COMPARED_TIMES)
    compared = np.unique(np.linspace(0, tau.size - 1, n_compared).astype(int))
    unit = FINE_NODES * grid.spacing  # both grids move by multiples of it
    coarse_start = grid.start + _skipped_units(grid) * unit
    n_coarse = grid.nodes // FINE_NODES * COARSE_NODES
    coarse_grid = LogGrid(coarse_start, unit / COARSE_NODES, n_coarse)
    coarse_gain = gain[: n_coarse // 2 + 1]
    coarse_start_rows = problem.start_on(coarse_grid)
    coarse_state = intertwine(coarse_grid, coarse_start_rows, coarse_gain, angle, problem.has_pole)
    _, coarse_rows = coarse_state.at(tau[compared], COARSE_NODES)
    coarse = _GridSolution(coarse_grid, compared, shift[compared], from_rows(coarse_rows))
    return fine.without_tilt(problem.tilt, lowest_x), coarse.without_tilt(problem.tilt, lowest_x)


def _skipped_units(grid: LogGrid) -> int:
    """Return by how many coinciding nodes the coarser window begins higher up."""
    return math.ceil(COARSE_WINDOW_HIGHER / (FINE_NODES * grid.spacing))


def _log_lowest_speed(problem: SpectralProblem) -> FloatArray:
    """Return ln of v/v_rms where a density begins to be right relative to its maximum, (n_times,).

    Speeds cool nearly as 1/(1 + r v_rms t/l), r the geometric mean of E[-ln s] and lambda(1).
    """
    law = problem.harmonic.law
    rate = math.sqrt(law.mean_log_loss * float(law.decay_rate(1.0)))
    return math.log(LOWEST_SPEED) - np.log1p(rate * np.expm1(problem.tau))


@dataclass(frozen=True)
class _RelativeErrors:
    """Errors of two solutions, the largest of all times: of f, and of g, over their maxima."""

    of_f: float
    of_g: float


def _compare(
    problem: SpectralProblem, fine: _GridSolution, coarse: _GridSolution
) -> _RelativeErrors:
    """Estimate the errors of a solution by its difference from a coarser one.

    f counts per speed, but below the lowest speed per its logarithm. The isotropic harmonic cannot
    be negative: where it is, by rounding that both solutions have, that is an error too.
    """
    m = problem.harmonic.m
    skipped = _skipped_units(fine.grid)
    is_common = slice(FINE_NODES * skipped, None, FINE_NODES)
    n_common_coarse = coarse.grid.nodes - COARSE_NODES * skipped
    g = fine.g[coarse.times]
    difference = np.abs(g[:, is_common] - coarse.g[:, :n_common_coarse:COARSE_NODES])
    least_maximum = 0.0 if m == 0 else LEAST_MAXIMUM
    lowest_x = (_log_lowest_speed(problem) + fine.shift)[coarse.times, None]
    per_speed = np.exp(-np.maximum(fine.grid.x, lowest_x))
    maximum_of_f = (np.abs(g) * per_speed).max(axis=1)
    # the least maximum is where most tracers are
    least_maximum_of_f = least_maximum * LOWEST_SPEED * np.exp(-lowest_x[:, 0])
    maximum_of_f = np.maximum(maximum_of_f, least_maximum_of_f)
    error_of_f = (difference * per_speed[:, is_common]).max(axis=1) / maximum_of_f
    if m == 0 and problem.harmonic.law.medium is None:
        error_of_f = np.maximum(error_of_f, -(g * per_speed).min(axis=1) / maximum_of_f)
    maximum_of_g = np.maximum(np.abs(g).max(axis=1), max(least_maximum, TINY))
    error_of_g = difference.max(axis=1) / maximum_of_g
    return _RelativeErrors(float(error_of_f.max()), float(error_of_g.max()))
