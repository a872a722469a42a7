r"""Which nodes of x = ln v a spectral solution of a harmonic needs.

l is the mean free path, v_rms the root mean square speed of the start; g = v f is the density of ln
v. Three windows of x = ln(v (t + t_0)/l), t_0 = l/v_rms, in which the scaling state stands still:
where g is above what is aimed at at some time (:func:`speed_window`); nodes that resolve the start
there (:func:`resolve_start`); and the window of the solution, which reaches further down and up, as
far as u does, the state without its collisions (:func:`choose_grid`). Begin with
:class:`SpectralProblem`.

"At half and at twice" in the comments below is measured on Gaussian starts with a mean velocity,
e = 0, 0.4, 0.7 and 0.95, m = 0 and 2, t up to 1e3, rtol 1e-8: by how much f moves, relative to its
maximum. The error estimates there are 1e-9 to 2e-9.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.densities.gain import log_gain
from kinetics.densities.grid_density import to_rows
from kinetics.densities.harmonic import HarmonicProblem
from kinetics.densities.turned_axis import SHARE_OF_SMALL_ERROR, TAPER_WIDTH, choose_angle
from kinetics.errors import InputError
from kinetics.numerics import ROUNDING, ComplexArray, FloatArray
from kinetics.numerics.log_grid import LogGrid
from kinetics.scaling.mellin import extent_of
from kinetics.states.state import LogMeasure, SpeedFunction

#: Most nodes. Chosen: it bounds work and memory.
MAX_NODES = 40_000
#: Most values at nodes and times. Derived: a quarter of a gigabyte.
MAX_VALUES = 3e7
#: The solution has so many nodes ...
FINE_NODES = 5
#: ... where the one that it is compared with has so many, so that some of both coincide. Chosen.
COARSE_NODES = 4
#: By so many e-folds of the speed the window of the coarser solution ends higher up, so that what
#: the end does to the solution is in the difference. Chosen: at half and at twice f moves by 3e-11,
#: and estimates grow by 1.3 at most.
COARSE_WINDOW_HIGHER = 2.0
#: Least accuracy that can be aimed at. Chosen: it matters for an rtol below 4e-13 only.
MIN_AIM = 50.0 * ROUNDING
#: The window of g ends so many e-folds below what is aimed at. It was 8 before (commit 39e460d0).
#: At half and at twice f moves by 3e-11, with 0.8 to 1.4 times the nodes.
DEPTH_BELOW_AIM = 6.0
#: The ends of the window of g lie so far outside of where g is. Chosen: at half and at twice f
#: moves by 4e-11.
WINDOW_MARGIN = 0.5
#: Ratio of speeds below which bounces count as leading to any speed: they fill the low speeds up to
#: v^1 in the density of ln v. Chosen: at half and at twice f moves by 1e-12, with 1.6 times the
#: nodes at twice.
SMALL_RATIO = 0.3
#: Slowest power of v with which harmonics m > 0, without their collisions, fall at low speeds under
#: such laws. Chosen: at half there are 1.9 times, at twice 0.6 times the nodes, and f moves by
#: 2e-13.
SLOWEST_POWER = 0.6
#: Largest wave number that a start without features needs, as long as nearly elastic tracers are as
#: widely spread as at the start. Chosen: nothing moves at e up to 0.95.
BAND_OF_START = 8.0
#: ln of how far nearly elastic tracers must be from the time at which they cool, 1/E[-ln s], for
#: that. Chosen: nothing moves at e up to 0.95.
LOG_MARGIN_OF_COOLING = 1.0
#: Factor of the nodes until the start is resolved. Measured at rtol 1e-8: with 1.2 and with 2 f
#: moves by 2e-10 and densities of a component by 5e-9, in the same time.
NODES_FACTOR = 1.4
#: The window of u ends where exp(-v t/l) is e^-7 of what is aimed at. Chosen: at half and at twice
#: nothing moves, as the window of g ends higher up.
DEPTH_OF_COLLIDED = 7.0
#: Extra length of the window, in ln v. Derived: then wave numbers are less than 1/2 apart, as the
#: gain needs (`kinetics.densities.gain`).
LENGTH_FOR_GAIN = 4.0 * math.pi
#: Highest modes in which what is unresolved is looked for. Chosen: one alone may vanish by chance.
HIGHEST_MODES = 3
#: Stands for 0 in a denominator: close to the smallest number.
TINY = 1e-300


@dataclass(frozen=True)
class SpectralProblem:
    """A harmonic problem, and the start as the spectral method takes it.

    Parameters
    ----------
    harmonic : the harmonic problem
    start : f_m of the start as a function of v in U
    speeds : the distribution of the initial speeds
    log_unit : ln of the root mean square of those, v_rms, here the unit of speed
    tau : ln(1 + v_rms t/l), shape (n_times,)
    aim : accuracy that is aimed at
    tilt : v^tilt f is what is solved for
    """

    harmonic: HarmonicProblem
    start: SpeedFunction
    speeds: LogMeasure
    log_unit: float
    tau: FloatArray
    aim: float
    tilt: float

    @classmethod
    def of(
        cls, harmonic: HarmonicProblem, start: SpeedFunction, speeds: LogMeasure
    ) -> SpectralProblem:
        """Aim at the tolerance, without tilt."""
        log_unit = 0.5 * speeds.log_second_moment()
        paths = harmonic.times / harmonic.mean_free_path
        tau = np.log(paths + math.exp(-log_unit)) + log_unit
        return cls(harmonic, start, speeds, log_unit, tau, harmonic.rtol, 0.0)

    def aiming_at(self, aim: float, tilt: float) -> SpectralProblem:
        """Return the problem with another aim, as far as rounding allows it, and tilt."""
        return replace(self, aim=max(aim, MIN_AIM), tilt=tilt)

    @property
    def has_pole(self) -> bool:
        """Whether the gain has a pole at z = tilt."""
        return self.harmonic.m == 0 and not self.tilt

    def gain(self, k: FloatArray) -> ComplexArray:
        """Return ln of the gain at wave numbers k."""
        return log_gain(self.harmonic.law, k, self.harmonic.m, self.tilt)

    def start_on(self, grid: LogGrid) -> FloatArray:
        """Return v^tilt g of the start at nodes of ln(v/v_rms), shape (1 or 2, nodes)."""
        v = np.exp(grid.x + self.log_unit)
        g = np.asarray(self.start(v) * v)
        if self.harmonic.m == 0:
            if not g.any():  # a peak between two nodes: a finer grid then differs from this one
                middle = float(self.speeds.weight.real @ self.speeds.x) - self.log_unit
                g[np.argmin(np.abs(grid.x - middle))] = 1.0
            g = g / (float(g.sum()) * grid.spacing)  # some of the mass lies beyond the window
        return to_rows(g) * np.exp(self.tilt * grid.x)


@dataclass(frozen=True)
class SpeedWindow:
    """Where g is at all times.

    Parameters
    ----------
    low, high : ends of x = ln(v (t + t_0)/l)
    band : largest wave number that the scaling state needs
    """

    low: float
    high: float
    band: float


def speed_window(law: CollisionLaw, start: LogMeasure, aim: float, duration: float) -> SpeedWindow:
    """Return where g is above the accuracy that is aimed at, up to tau = duration."""
    depth = math.log(1.0 / aim) + DEPTH_BELOW_AIM
    order = np.argsort(start.x)
    x = start.x[order] - 0.5 * start.log_second_moment()
    weight_below = np.cumsum(np.abs(start.weight[order]))
    negligible = math.exp(-depth) * weight_below[-1]
    # of bounces that lose L at rates e^x a share exp(-(y^2 - x^2)/2 L) comes from x down to y
    loss = min(law.largest_loss, -math.log(SMALL_RATIO))
    log_excess = np.log(np.maximum(weight_below / negligible, 1.0))
    squared_depths = np.minimum(x, 0.0) ** 2 + 2.0 * loss * log_excess
    low = -math.sqrt(float(squared_depths[weight_below >= negligible].max()))
    if law.least_ratio < SMALL_RATIO:
        low = min(low, -depth)
    minus_weight_above = weight_below - weight_below[-1]
    last = int(np.searchsorted(minus_weight_above, -negligible))
    start_high = float(x[min(last + 1, x.size - 1)])
    scaling_high, band = extent_of(law, depth)
    # before that the ring of nearly elastic tracers is still as wide as the start
    if start_high + duration <= -math.log(law.mean_log_loss) - LOG_MARGIN_OF_COOLING:
        band = BAND_OF_START
    high = max(start_high, min(scaling_high, start_high + duration))
    return SpeedWindow(low - WINDOW_MARGIN, high + WINDOW_MARGIN, band)


def unresolved_fraction(rows: FloatArray) -> float:
    """Return the highest modes of rows over the largest of both, at the worst of the times.

    rows : real and imaginary part, shape (1 or 2, ..., nodes)
    """
    modes = np.abs(np.fft.rfft(rows)).max(axis=0)
    highest = modes[..., -HIGHEST_MODES:].max(axis=-1)
    largest = modes.max(axis=-1)
    return float(np.max(highest / np.maximum(largest, TINY)))


def resolve_start(problem: SpectralProblem, window: SpeedWindow) -> LogGrid | None:
    """Return nodes in the window that resolve the start and the scaling state.

    With a requested number of nodes, so many; None where the start is too rough.

    Raises
    ------
    InputError
        Where there would be too many nodes.
    """
    requested = problem.harmonic.nodes
    length = window.high - window.low
    count = requested or int(length * window.band / math.pi) + 2
    check_work(problem, count)
    while True:
        count += count % 2
        grid = LogGrid(window.low, length / count, count)
        unresolved = unresolved_fraction(problem.start_on(grid))
        if requested is not None or unresolved <= SHARE_OF_SMALL_ERROR * problem.aim:
            return grid
        if 2 * count > MAX_NODES // FINE_NODES:
            return grid if unresolved <= problem.aim else None
        count = int(NODES_FACTOR * count)


def choose_grid(problem: SpectralProblem, start_grid: LogGrid) -> tuple[LogGrid, float]:
    """Return the nodes of the solution and the angle of its axis, from nodes for the start.

    A requested number of nodes counts as the next multiple of ten.

    Raises
    ------
    InputError
        Where there would be too many nodes.
    """
    from scipy.fft import next_fast_len

    requested = problem.harmonic.nodes
    rows = problem.start_on(start_grid)
    node_unit = 2 * FINE_NODES  # an even number, and nodes in common with the coarser solution
    if requested is None:
        angle, low, high = _turned_window(problem, start_grid, rows, start_grid.spacing)
        spacing = start_grid.spacing * (COARSE_NODES / FINE_NODES)
        n_units = next_fast_len(math.ceil((high - low) / spacing / node_unit))
    else:
        n_units = math.ceil(requested / node_unit)
        spacing = start_grid.spacing
        # the spacing follows from the window, and the window, by the angle, from the spacing
        for _ in range(2):
            angle, low, high = _turned_window(problem, start_grid, rows, spacing)
            spacing = (high - low) / (node_unit * n_units)
    check_work(problem, node_unit * n_units)
    # both ends at multiples of the nodes that two solutions have in common
    first = math.floor(low / (FINE_NODES * spacing))
    return LogGrid(FINE_NODES * spacing * first, spacing, node_unit * n_units), angle


def _turned_window(
    problem: SpectralProblem, start_grid: LogGrid, rows: FloatArray, spacing: float
) -> tuple[float, float, float]:
    """Return the angle of the axis for nodes of some spacing, and both ends of the window of u.

    It goes further down than that of g, and further up as exp(-v t/l) falls there.
    """
    law = problem.harmonic.law
    aim = problem.aim
    angle, log_raised = choose_angle(problem.gain, start_grid, rows, spacing, aim)
    low = math.log(SHARE_OF_SMALL_ERROR * aim) - log_raised - COARSE_WINDOW_HIGHER
    if problem.tilt:
        low = low / problem.tilt - float(problem.tau[-1])
    elif problem.harmonic.m == 0:
        low += math.log(law.mean_log_loss)
    elif law.least_ratio < SMALL_RATIO:
        low /= SLOWEST_POWER
    path = (DEPTH_OF_COLLIDED - math.log(aim) + log_raised) / math.cos(angle)
    high = max(start_grid.end, math.log(path))
    taper_width = TAPER_WIDTH if angle else 0.0
    low = min(start_grid.start, low) - taper_width
    high = high + taper_width
    return angle, min(low, high - LENGTH_FOR_GAIN), high


class TooManyNodesError(InputError):
    """A density needs more nodes than this method takes; the conservative one may need fewer."""


def check_work(problem: SpectralProblem, count: int) -> None:
    """Raise TooManyNodesError where so many nodes are too many."""
    n_times = problem.tau.size
    if count <= MAX_NODES and count * n_times <= MAX_VALUES:
        return
    latest = problem.harmonic.times[-1]
    raise TooManyNodesError(
        f"times: got up to {latest:g} at {problem.harmonic.law.described}; the density would need"
        f" {count:.1e} nodes, ask for other times, a larger rtol, or averages only"
    )
