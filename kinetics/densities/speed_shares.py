"""The distribution of the speeds at times as points: averages over the tracers by a plain sum.

Speeds v are in U, times t in l/U, l the mean free path. A :class:`Profile` is a density, without
the tracers of sharp speeds that have not collided. :class:`SpeedShares` holds these, and of the
others the share of tracers at each of many speeds. Begin with :meth:`SpeedShares.of` and
:meth:`SpeedShares.average`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.densities.harmonic import Profile
from kinetics.densities.log_panels import LogPanels
from kinetics.densities.node_masses import NodeMasses, deposit
from kinetics.densities.sharp_tracers import SharpTracers
from kinetics.numerics import FloatArray
from kinetics.states.state import LogMeasure, State

#: Panels for each octave of the speed, and more where the start is not smooth. Measured on free
#: flights of four starts at e = 0, 0.4, 0.9 and 1 against eight times as many: shares by duration
#: are right to 5e-12, by length to 9e-11. At half the latter are right to 2e-9, at twice to 1e-11.
PANELS_PER_OCTAVE = 3
#: Gauss points of a panel. Chosen: the polynomial through them is right to some 1e-10.
PANEL_POINTS = 6
#: Speeds over the fastest, times the number of mean free paths that it has, below which tracers
#: hardly collide: 1e-7 of their flights. Chosen: at half and at twice shares of flights move by
#: 5e-9 at most.
SLOWEST = 1e-7
#: How far above the fastest point of the start, in ln v, it may go on. Chosen: at half and at twice
#: shares of flights move by 4e-12 from smooth starts, by 2e-7 from one with kinks.
ABOVE_FASTEST = 0.05
#: Tolerance of the points of the start, of which the fastest is looked for, and those that show
#: where it is not smooth. Chosen: at a tenth and at ten times shares of flights move by 2e-10.
RTOL_OF_START = 1e-8
#: Least spacing in ln v of the speeds that carry the masses of the conservative method. Chosen: the
#: rates of collisions are right to its square over 8, 2e-6.
MASS_SPACING = math.log(2.0) / 180.0


@dataclass(frozen=True)
class SpeedShares:
    """Shares of all tracers at speeds, at times: those of ``shares`` and of ``sharp`` sum to 1.

    Parameters
    ----------
    times : t in l/U, l the mean free path, shape (n_times,)
    speeds : in U, rising, shape (n_v,)
    shares : share of all tracers near each speed, without the sharp ones, shape (n_times, n_v)
    sharp : tracers of sharp speeds that have not collided
    panels : of which the speeds are the nodes; None where they carry masses, or there are none
    """

    times: FloatArray
    speeds: FloatArray
    shares: FloatArray
    sharp: SharpTracers
    panels: LogPanels | None

    @classmethod
    def of(
        cls,
        solve: Callable[[FloatArray], Profile],
        law: CollisionLaw,
        state: State,
        times: FloatArray,
        mean_free_path: float,
    ) -> SpeedShares:
        """Solve for the speeds at times.

        Parameters
        ----------
        solve : maps times in d/U to the speed density then; not called where e = 1 and the start
            has no density, as all tracers are sharp
        law : collision law of the tracer
        state : initial state
        times : t in l/U, rising, shape (n_times,)
        mean_free_path : l in d
        """
        sharp = SharpTracers.of(state, law.is_elastic)
        if law.is_elastic and sharp.speeds.size:
            return cls(times, np.zeros(0), np.zeros((times.size, 0)), sharp, None)
        profile = solve(times * mean_free_path)
        panels = None
        if isinstance(profile.density, NodeMasses):
            speeds, shares = _masses_without_sharp(profile.density)
        else:
            panels = _panels_for(state, float(times[-1]))
            speeds = np.exp(panels.log_speeds)
            density = np.maximum(profile.continuous(speeds).real, 0.0)
            shares = density * (panels.weights * speeds)
        # the quadrature may miss a little at steps, but the number of tracers is known
        sums = shares.sum(axis=1)
        factor = (1.0 - sharp.remaining(times)) / np.where(sums > 0.0, sums, np.inf)
        return cls(times, speeds, shares * factor[:, None], sharp, panels)

    def average(self, function: Callable[[FloatArray], FloatArray]) -> FloatArray:
        """Return the average of a function of the speed over all tracers, at each time.

        Parameters
        ----------
        function : maps speeds in U, (n,), to numbers, (n,)

        Returns
        -------
        The average, shape (n_times,). Tracers that are slower than all speeds, where hardly any
        collide in the time (`SLOWEST`), count as the slowest.
        """
        return self.shares @ function(self.speeds) + self.sharp.sum_over(function, self.times)


def _masses_without_sharp(masses: NodeMasses) -> tuple[FloatArray, FloatArray]:
    """Return speeds in U, (n_v,), and shares of tracers there, (n_times, n_v).

    A quadrature over the speed would miss nodes, of which a sharp speed fills two, and parts of
    steps; the masses have the number of tracers and their energy.
    """
    shares = masses.mass
    if masses.uncollided is not None:
        shares = np.maximum(shares - masses.uncollided, 0.0)
    if masses.spacing >= MASS_SPACING:
        return np.exp(masses.x), shares
    highest = masses.x[-1]
    count = math.ceil((highest - masses.x[0]) / MASS_SPACING) + 2
    x = highest + MASS_SPACING * np.arange(2 - count, 2, dtype=float)
    rows = [deposit(LogMeasure(masses.x, row), x, MASS_SPACING) for row in shares]
    return np.exp(x), np.array(rows)


def _panels_for(state: State, last_time: float) -> LogPanels:
    """Return panels on which the density of the speed is smooth.

    The points of the start gather where a function steps, bends or has a narrow peak: panels are as
    short there as these points are close.

    last_time : in l/U; tracers slower than SLOWEST over it hardly collide
    """
    start = state.harmonic(0, RTOL_OF_START)
    assert start is not None  # harmonic 0 is never zero
    start_points = np.sort(start.x)
    log_fastest = float(start_points[-1])
    octaves = math.log2(math.exp(log_fastest) * max(last_time, 1.0) / SLOWEST)
    depths = np.linspace(0.0, math.log(2.0) * octaves, int(octaves * PANELS_PER_OCTAVE) + 1)
    edges = log_fastest + np.append(-depths[::-1], ABOVE_FASTEST)
    log_kinks = np.log(state.kinks[state.kinks > 0.0])
    if log_kinks.size == 0:
        every_panel = start_points[::PANEL_POINTS]
        is_dense = np.diff(every_panel) < math.log(2.0) / PANELS_PER_OCTAVE
        log_kinks = every_panel[:-1][is_dense]
    is_within = (log_kinks > edges[0]) & (log_kinks < edges[-1])
    return LogPanels(np.union1d(edges, log_kinks[is_within]), PANEL_POINTS)
