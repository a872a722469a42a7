"""What a run gives: the columns of its tables, names, units, and averages of sums over tracers.

The columns are the layout of saved files too (`particles.files`): append, do not renumber.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

# How a tracer ended, unless it is RUNNING: indices into the counts of statuses, STATUSES of them.
RUNNING, FINISHED, COLLISION_CAP, TRAPPED, ESCAPED, CAPTURED, STATUSES = range(-1, 6)

# Moments, (n_times, MOMENTS): sums over tracers at one output time of 1, v^2, v^4, r^2, r^4, the
# collisions so far, v(t).v(0), and 1 for a tracer that is trapped or captured. Velocities are
# multiplied by `Records.scales` first.
SAMPLES, SPEED2, SPEED4, R2, R4, COLLISIONS, CORRELATION, CAUGHT, MOMENTS = range(9)

# Sums in a field, (n_times, FIELD_SUMS[dimension]): the velocity, its products v_i v_j (i <= j: xx,
# xy, yy in the plane, xx, xy, xz, yy, yz, zz in space), and the same of the place.
FIELD_SUMS = {d: d * (d + 3) for d in (2, 3)}
FIELD_SUMS_IN_PLANE = FIELD_SUMS[2]

# Totals, (TOTALS,): sums over tracers of the path travelled and of the collisions, to their ends.
TRAVELLED, ALL_COLLISIONS, TOTALS = range(3)

# The end of one tracer, (FINALS[dimension],): ln of its speed, ln of its time, place, collisions,
# and in three dimensions the third coordinate of the place.
LN_SPEED, LN_TIME, FINAL_X, FINAL_Y, FINAL_COLLISIONS, FINAL_Z = range(6)
FINALS = {2: 5, 3: 6}

# A trapped or captured tracer, (TRAPS[dimension],): its number, and the time and the place at which
# it was caught. A medium without scatterers has the columns of the plane unless tracers stick.
TRAP_TRACER, TRAP_TIME, TRAP_X, TRAP_Y, TRAP_Z = range(5)
TRAPS = {2: 4, 3: 5}

# Histograms: name -> symbol, unit and words of what is counted; then rows of the table of grids.
VARIABLES = {
    "speed_histogram": ("v", "U", "speed |v|"),
    "velocity_component_histogram": ("v_x", "U", "velocity component |v_x|"),
    "displacement_histogram": ("r", "d", "displacement |r|"),
    "free_path_histogram": ("path", "d", "length of a free flight"),
    "free_time_histogram": ("flight_time", "d/U", "duration of a free flight"),
}
HISTOGRAMS = tuple(VARIABLES)
SPEED, COMPONENT, DISTANCE, PATH, DURATION = range(5)
OF_FLIGHTS = HISTOGRAMS[PATH:]  # of the whole run, not of each output time

VELOCITY, PLACE = range(2)


class Sums:
    """Sums over tracers at each time, (n_times, columns): of `moments`, then of `field_sums`."""

    def __init__(self, array: np.ndarray, dimension: int) -> None:
        self.array, self.dimension = array, dimension

    def __getitem__(self, column: int) -> np.ndarray:
        return self.array[:, column]

    def mean(self, column: int) -> np.ndarray:
        """Return the average over the tracers, (n_times,)."""
        return np.asarray(self[column] / self[SAMPLES])

    def vector(self, which: int) -> np.ndarray:
        """Return the average of the VELOCITY or the PLACE, (n_times, dimension)."""
        return self._means(which)[:, : self.dimension]

    def tensor(self, which: int) -> np.ndarray:
        """Return the average of its products, (n_times, dimension, dimension)."""
        d, means = self.dimension, self._means(which)
        products = np.empty((len(means), d, d))
        i, j = np.triu_indices(d)
        products[:, i, j] = products[:, j, i] = means[:, d:]
        return products

    def covariance(self) -> np.ndarray:
        """Return that of the displacement, (n_times, dimension, dimension)."""
        mean = self.vector(PLACE)
        return self.tensor(PLACE) - mean[:, :, None] * mean[:, None, :]

    def _means(self, which: int) -> np.ndarray:
        return np.split(self.array[:, MOMENTS:], 2, axis=1)[which] / self[SAMPLES][:, None]


class Average(NamedTuple):
    """An estimate: unit, words, and its value as a function of the sums, None of other sums.

    scaled: it is still times the power of 2 that velocities are multiplied by in sums.
    """

    unit: str
    words: str
    of: Callable[[Sums], np.ndarray] | None = None
    scaled: bool = False


SCALARS = {
    "thermal_speed": Average("U", "sqrt(<v^2>)", lambda s: np.sqrt(s.mean(SPEED2)), scaled=True),
    "a2": Average(
        "1",
        "<v^4>/(k <v^2>^2) - 1, k = 2 in the plane and 5/3 in space",
        lambda s: s[SPEED4] * s[SAMPLES] / ((s.dimension + 2) / s.dimension * s[SPEED2] ** 2) - 1.0,
    ),
    "msd": Average("d^2", "mean square displacement", lambda s: s.mean(R2)),
    "kurtosis": Average("1", "<r^4>/<r^2>^2", lambda s: s[R4] * s[SAMPLES] / s[R2] ** 2),
    "collisions": Average(
        "1", "mean number of collisions per tracer", lambda s: s.mean(COLLISIONS)
    ),
    "velocity_autocorrelation": Average(
        "U^2", "<v(t).v(0)>", lambda s: s.mean(CORRELATION), scaled=True
    ),
    "mean_free_path": Average("d", "path per collision"),
}
"""Estimates of every run; those but the last are (n_times, ...), NaN where nothing was sampled."""
IN_FIELD = {
    "drift": Average("U", "<v_x>", lambda s: s[MOMENTS] / s[SAMPLES]),
    "drift_of_moving": Average(
        "U", "<v_x> of the tracers that are not trapped",
        lambda s: s[MOMENTS] / (s[SAMPLES] - s[CAUGHT]),
    ),
    "trapped_fraction": Average(
        "1", "share of the tracers that are trapped or captured", lambda s: s.mean(CAUGHT)
    ),
    "mean_velocity": Average("U", "<v>", lambda s: s.vector(VELOCITY)),
    "velocity_tensor": Average("U^2", "<v_i v_j>", lambda s: s.tensor(VELOCITY)),
    "mean_displacement": Average("d", "<r>", lambda s: s.vector(PLACE)),
    "dispersion": Average("d^2", "covariance of the displacement", Sums.covariance),
    "dispersion_parallel": Average(
        "d^2", "variance of the displacement along the field", lambda s: s.covariance()[:, 0, 0]
    ),
    "dispersion_perpendicular": Average(
        "d^2", "variance across the field, of one direction",
        lambda s: np.trace(s.covariance()[:, 1:, 1:], axis1=1, axis2=2) / (s.dimension - 1),
    ),
}  # fmt: skip
"""Estimates of a run in a field; `trapped_fraction` also where tracers stick."""
OF_A_DEPTH = {
    "passed": Average("1", "share of the tracers that have reached the depth"),
    "mean_passage_time": Average("d/U", "mean time of the first passage of the depth"),
}
"""Estimates of a run in a field with a depth, which has `passage_times` too."""
DRIVES = {"bath_speed": "U", "heating": "U^3/d", "drag": "U/d", "capture_speed": "U"}
"""What drives tracers, and what stops them: argument of `simulate` -> unit."""
ESTIMATES = SCALARS | IN_FIELD | OF_A_DEPTH
RAW = ("positions", "velocities", "finals")
OBSERVABLES = (*SCALARS, *HISTOGRAMS, *RAW)
