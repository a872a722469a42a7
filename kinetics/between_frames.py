r"""The mean square displacement between two frames, M(s, t) = <|r(t) - r(s)|^2>.

A camera gives positions, and M is what it can average. A tracer among dilute scatterers forgets its
place and its direction in every collision, so that what it does after s depends on its speed then:

    M(s, t) = int f(v, s) B(v, t - s) dv,     B(v, tau) = l^2 b(v tau/l),

with f the density of the speed and b(T) the mean square displacement in l^2 of tracers of one speed
that would fly T mean free paths. Begin with `mean_square_between_frames`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.densities.harmonic import Profile
from kinetics.densities.speed_shares import SpeedShares
from kinetics.moments.averages import Averages, PowerRange
from kinetics.moments.outputs import root_mean_square_displacement
from kinetics.numerics import FloatArray
from kinetics.states.kinds import Monoenergetic
from kinetics.states.state import State

#: T below which a tracer flies straight: the error of b = T^2 is below T.
SHORTEST_PATH = 1e-9
#: Points of the table of b in an e-fold of T. Derived: cubic interpolation of ln b over ln T leaves
#: h^4/384 of the fourth derivative, which is of order 1, so 3e-11.
POINTS_PER_FOLD = 100
#: b is needed to this fraction of the tolerance: the rest is for the density of the speed.
SHARE_OF_TOLERANCE = 0.1


def mean_square_between_frames(
    solve: Callable[[FloatArray], Profile],
    law: CollisionLaw,
    state: State,
    times: FloatArray,
    mean_free_path: float,
    rtol: float,
) -> FloatArray:
    """Return M(s, t) in d^2 for all pairs of times, shape (n_times, n_times), symmetric.

    Parameters
    ----------
    solve : maps times in d/U to the speed density then
    law : collision law of the tracer, among dilute scatterers
    state : initial state
    times : in d/U, rising, shape (n_times,)
    mean_free_path : l in d
    rtol : relative accuracy of b
    """
    path_times = times / mean_free_path
    distribution = SpeedShares.of(solve, law, state, path_times, mean_free_path)
    speeds = np.concatenate([distribution.speeds, distribution.sharp.speeds])
    longest = float(speeds.max()) * float(path_times[-1] - path_times[0])
    squared_displacement = _OneSpeed(law, max(longest, 2.0 * SHORTEST_PATH), rtol)
    result = np.zeros((times.size, times.size))
    for later in range(1, times.size):
        for earlier in range(later):
            duration = float(path_times[later] - path_times[earlier])
            averages = distribution.average(partial(squared_displacement.after, duration))
            result[earlier, later] = averages[earlier]
            result[later, earlier] = averages[earlier]
    return mean_free_path**2 * result


class _OneSpeed:
    """b(T), the mean square displacement in l^2 of tracers of one speed after T = v t/l."""

    def __init__(self, law: CollisionLaw, longest: float, rtol: float) -> None:
        from scipy.interpolate import CubicSpline

        folds = np.log(longest / SHORTEST_PATH)
        log_path = np.linspace(0.0, folds, 2 + int(POINTS_PER_FOLD * folds)) + np.log(SHORTEST_PATH)
        path = np.exp(log_path)
        averages = Averages.over(
            law, 1.0, Monoenergetic(1.0), path, SHARE_OF_TOLERANCE * rtol, PowerRange(highest=2.0)
        )
        log_ratio = 2.0 * np.log(root_mean_square_displacement(averages) / path)
        self._log_ratio = CubicSpline(log_path, log_ratio)
        self._longest = longest

    def after(self, duration: float, speeds: FloatArray) -> FloatArray:
        """Return b of speeds in U, (n,), after a time in l/U."""
        path = duration * speeds
        within = np.clip(path, SHORTEST_PATH, self._longest)
        return np.asarray(path**2 * np.exp(self._log_ratio(np.log(within))))
