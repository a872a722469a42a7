r"""The mean square displacement between two frames, M(s, t) = <|r(t) - r(s)|^2>.

A camera gives positions at times s and t, and M is what it can average. l is the mean free path; d
is the contact distance, and U the unit of speed. A tracer among dilute scatterers meets a new
scatterer at every collision, and nothing prefers a direction. So what it does after s depends only
on its speed v then:

    M(s, t) = int f(v, s) B(v, t - s) dv,     B(v, tau) = l^2 b(v tau/l),

with f the density of the speed, and b(T) the mean square displacement, in l^2, of tracers that all
start with one speed and would fly T mean free paths if they kept it. b is tabulated once, as
ln(b/T^2) over ln T. Begin with `mean_square_between_frames`.
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

#: T, in mean free paths, below which a tracer flies straight. Derived: a fraction T of the tracers
#: has collided, so that the relative error of b = T^2 is below T.
SHORTEST_PATH = 1e-9
#: Points of the table of b in an e-fold of T. Derived: a cubic spline of ln b over ln T with the
#: spacing h leaves h^4/384 of the fourth derivative, which is of order 1, so 3e-11. Half as
#: many move b by 2.5e-10, twice as many by 2e-11 (e = 0, 0.7 and 1).
POINTS_PER_FOLD = 100
#: The tolerance of b over that of M; the rest of the tolerance is for the density of the speed.
#: Chosen: with half or twice of it b is the same to the last digit at rtol 1e-6 and
#: 1e-8, and it is right to 5e-10 or better.
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
    rtol : relative tolerance of M; b is computed to `SHARE_OF_TOLERANCE` of it, and `solve` has one
        of its own
    """
    path_times = times / mean_free_path
    distribution = SpeedShares.of(solve, law, state, path_times, mean_free_path)
    speeds = np.concatenate([distribution.speeds, distribution.sharp.speeds])
    longest = float(speeds.max()) * float(path_times[-1] - path_times[0])
    squared_displacement = _OneSpeed(law, max(longest, 2.0 * SHORTEST_PATH), rtol)
    result = np.zeros((times.size, times.size))
    for later in range(1, times.size):
        for earlier in range(later):
            # `average` gives <B> over the speeds at all times, of which the earlier one counts
            duration = float(path_times[later] - path_times[earlier])
            averages = distribution.average(partial(squared_displacement.after, duration))
            result[earlier, later] = averages[earlier]
            result[later, earlier] = averages[earlier]
    return mean_free_path**2 * result


class _OneSpeed:
    """b(T), the mean square displacement in l^2 of tracers of one speed v after T = v t/l.

    Parameters
    ----------
    law : the collision law
    longest : largest T of the table, in mean free paths
    rtol : relative tolerance of M; see `SHARE_OF_TOLERANCE`
    """

    def __init__(self, law: CollisionLaw, longest: float, rtol: float) -> None:
        from scipy.interpolate import CubicSpline

        folds = np.log(longest / SHORTEST_PATH)
        log_path = np.linspace(0.0, folds, 2 + int(POINTS_PER_FOLD * folds)) + np.log(SHORTEST_PATH)
        path = np.exp(log_path)
        # with l = 1 and v = 1 the time is T; <r^2> needs powers of the speed up to the second
        averages = Averages.over(
            law=law,
            mean_free_path=1.0,
            state=Monoenergetic(1.0),
            times=path,
            rtol=SHARE_OF_TOLERANCE * rtol,
            powers=PowerRange(highest=2.0),
        )
        log_ratio = 2.0 * np.log(root_mean_square_displacement(averages) / path)
        self._log_ratio = CubicSpline(log_path, log_ratio)
        self._longest = longest

    def after(self, duration: float, speeds: FloatArray) -> FloatArray:
        """Return b of tracers of speeds in U, shape (n,), after a time in l/U.

        Below the table, at 0 too, they fly straight. Above it is only rounding, as `longest` is the
        path of the fastest tracer; there b/T^2 is that of the end of the table.
        """
        path = duration * speeds
        within = np.clip(path, SHORTEST_PATH, self._longest)
        return np.asarray(path**2 * np.exp(self._log_ratio(np.log(within))))
