"""What a run gives: the columns of its tables, names, units, and averages of sums over tracers.

The columns are the layout of saved files too (`particles.files`): append, do not renumber. Begin
reading with `Average` and the tables of estimates after it.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

# -- columns of tables -----------------------------------------------------------------------------

# How a tracer ended: indices into the counts of statuses.
RUNNING = -1  # it has not ended yet
FINISHED = 0  # it reached the last output time
COLLISION_CAP = 1  # it made the largest number of collisions
TRAPPED = 2  # in a corner, or at rest
ESCAPED = 3  # it flew too far without a collision
CAPTURED = 4  # it stuck to a scatterer
STATUSES = 5  # number of these counts

# Moments, (n_times, MOMENTS): sums over tracers at one output time. Velocities are multiplied by
# `Records.scales` first.
SAMPLES = 0  # of 1
SPEED2 = 1  # of v^2
SPEED4 = 2  # of v^4
R2 = 3  # of r^2, r the displacement
R4 = 4  # of r^4
COLLISIONS = 5  # of the number of collisions so far
CORRELATION = 6  # of v(t).v(0)
CAUGHT = 7  # of 1 for a tracer that is trapped or captured
MOMENTS = 8  # number of these columns

#: Sums in a field, for each dimension: columns of an array (n_times, columns). They are of the
#: velocity, its products v_i v_j (i <= j: xx, xy, yy in the plane, xx, xy, xz, yy, yz, zz in
#: space), and the same of the place. Derived: d (d + 3) in d dimensions.
FIELD_SUMS = {2: 10, 3: 18}
FIELD_SUMS_IN_PLANE = FIELD_SUMS[2]

# Totals, (TOTALS,): sums over tracers, to their ends.
TRAVELLED = 0  # of the path
ALL_COLLISIONS = 1  # of the number of collisions
TOTALS = 2  # number of these columns

# The end of one tracer, (FINALS[dimension],).
LN_SPEED = 0  # ln of the speed
LN_TIME = 1  # ln of the time
FINAL_X = 2  # displacement
FINAL_Y = 3  # displacement
FINAL_COLLISIONS = 4  # number of collisions
FINAL_Z = 5  # displacement; in three dimensions only
#: Columns of the end of one tracer, for each dimension.
FINALS = {2: 5, 3: 6}

# A trapped or captured tracer, (TRAPS[dimension],). A medium without scatterers has the columns of
# the plane unless tracers stick.
TRAP_TRACER = 0  # number of the tracer
TRAP_TIME = 1  # when it was caught
TRAP_X = 2  # displacement
TRAP_Y = 3  # displacement
TRAP_Z = 4  # displacement; in three dimensions only
#: Columns of a trapped or captured tracer, for each dimension.
TRAPS = {2: 4, 3: 5}

# -- histograms ------------------------------------------------------------------------------------


class Variable(NamedTuple):
    """What a histogram counts; the symbol is part of names in datasets."""

    symbol: str
    unit: str
    words: str


VARIABLES = {
    "speed_histogram": Variable("v", "U", "speed |v|"),
    "velocity_component_histogram": Variable("v_x", "U", "velocity component |v_x|"),
    "displacement_histogram": Variable("r", "d", "displacement |r|"),
    "free_path_histogram": Variable("path", "d", "length of a free flight"),
    "free_time_histogram": Variable("flight_time", "d/U", "duration of a free flight"),
}
"""Histograms, in the order of the rows of the table of grids."""
HISTOGRAMS = tuple(VARIABLES)
# Rows of the table of grids.
SPEED = 0  # |v|
COMPONENT = 1  # |v_x|
DISTANCE = 2  # |r|
PATH = 3  # of a flight
DURATION = 4  # of a flight
OF_VELOCITIES = HISTOGRAMS[:DISTANCE]
"""Histograms whose variable has no length in its unit."""
OF_FLIGHTS = HISTOGRAMS[PATH:]
"""Histograms of the whole run, not of each output time."""

# -- averages --------------------------------------------------------------------------------------

# Which half of the sums in a field.
VELOCITY = 0  # sums of v_i and v_i v_j
PLACE = 1  # sums of r_i and r_i r_j


class Sums:
    """Sums over tracers at each time, (n_times, columns): of `moments`, then of `field_sums`."""

    def __init__(self, array: np.ndarray, dimension: int) -> None:
        self.array = array
        self.dimension = dimension

    def __getitem__(self, column: int) -> np.ndarray:
        return self.array[:, column]

    def mean(self, column: int) -> np.ndarray:
        """Return the average over the tracers, (n_times,)."""
        return np.asarray(self[column] / self[SAMPLES])

    def mean_vector(self, half: int) -> np.ndarray:
        """Return the average of the VELOCITY or the PLACE, (n_times, dimension)."""
        return self._field_means(half)[:, : self.dimension]

    def mean_products(self, half: int) -> np.ndarray:
        """Return the averages of v_i v_j, or r_i r_j, (n_times, dimension, dimension)."""
        d = self.dimension
        means = self._field_means(half)
        products = np.empty((len(means), d, d))
        i, j = np.triu_indices(d)
        products[:, i, j] = means[:, d:]
        products[:, j, i] = means[:, d:]
        return products

    def covariance(self) -> np.ndarray:
        """Return that of the displacement, (n_times, dimension, dimension)."""
        mean = self.mean_vector(PLACE)
        return self.mean_products(PLACE) - mean[:, :, None] * mean[:, None, :]

    def _field_means(self, half: int) -> np.ndarray:
        halves = np.split(self.array[:, MOMENTS:], 2, axis=1)
        return halves[half] / self[SAMPLES][:, None]


#: Powers of the length d in the units of averages.
LENGTH_POWERS = {"1": 0, "U": 0, "U^2": 0, "d": 1, "d^2": 2}


class Average(NamedTuple):
    """An estimate: its unit, words, and how it is computed.

    Parameters
    ----------
    unit : a key of LENGTH_POWERS, or another one of an average that is not made of sums
    words : a formula or a description
    compute : its value, (n_times, ...), of sums over tracers; None for one that is made otherwise
    scaled : whether this value is still times the power of 2 that velocities have in sums
    """

    unit: str
    words: str
    compute: Callable[[Sums], np.ndarray] | None = None
    scaled: bool = False


def _thermal_speed(sums: Sums) -> np.ndarray:
    return np.asarray(np.sqrt(sums.mean(SPEED2)))


def _a2(sums: Sums) -> np.ndarray:
    of_gaussian = (sums.dimension + 2) / sums.dimension
    return sums[SPEED4] * sums[SAMPLES] / (of_gaussian * sums[SPEED2] ** 2) - 1.0


def _kurtosis(sums: Sums) -> np.ndarray:
    return sums[R4] * sums[SAMPLES] / sums[R2] ** 2


def _drift_of_moving(sums: Sums) -> np.ndarray:
    return sums[MOMENTS] / (sums[SAMPLES] - sums[CAUGHT])


def _dispersion_across(sums: Sums) -> np.ndarray:
    across = sums.covariance()[:, 1:, 1:]
    return np.trace(across, axis1=1, axis2=2) / (sums.dimension - 1)


SCALARS = {
    "thermal_speed": Average("U", "sqrt(<v^2>)", _thermal_speed, scaled=True),
    "a2": Average("1", "<v^4>/(k <v^2>^2) - 1, k = 2 in the plane and 5/3 in space", _a2),
    "msd": Average("d^2", "mean square displacement", lambda sums: sums.mean(R2)),
    "kurtosis": Average("1", "<r^4>/<r^2>^2", _kurtosis),
    "collisions": Average(
        "1", "mean number of collisions per tracer", lambda sums: sums.mean(COLLISIONS)
    ),
    "velocity_autocorrelation": Average(
        "U^2", "<v(t).v(0)>", lambda sums: sums.mean(CORRELATION), scaled=True
    ),
    "mean_free_path": Average("d", "path per collision"),
}
"""Estimates of every run; those but the last are (n_times, ...), NaN where nothing was sampled."""
IN_FIELD = {
    "drift": Average("U", "<v_x>", lambda sums: sums.mean(MOMENTS)),
    "drift_of_moving": Average("U", "<v_x> of the tracers that are not trapped", _drift_of_moving),
    "trapped_fraction": Average(
        "1", "share of the tracers that are trapped or captured", lambda sums: sums.mean(CAUGHT)
    ),
    "mean_velocity": Average("U", "<v>", lambda sums: sums.mean_vector(VELOCITY)),
    "velocity_tensor": Average("U^2", "<v_i v_j>", lambda sums: sums.mean_products(VELOCITY)),
    "mean_displacement": Average("d", "<r>", lambda sums: sums.mean_vector(PLACE)),
    "dispersion": Average("d^2", "covariance of the displacement", Sums.covariance),
    "dispersion_parallel": Average(
        "d^2",
        "variance of the displacement along the field",
        lambda sums: sums.covariance()[:, 0, 0],
    ),
    "dispersion_perpendicular": Average(
        "d^2", "variance across the field, of one direction", _dispersion_across
    ),
}
"""Estimates of a run in a field; `trapped_fraction` also where tracers stick."""
OF_A_DEPTH = {
    "passed": Average("1", "share of the tracers that have reached the depth"),
    "mean_passage_time": Average("d/U", "mean time of the first passage of the depth"),
}
"""Estimates of a run in a field with a depth, which has `passage_times` too."""
ESTIMATES = SCALARS | IN_FIELD | OF_A_DEPTH
RAW = ("positions", "velocities", "finals")
ALIASES = {
    "mean_square_displacement": "msd",
    "mean_squared_displacement": "msd",
    "v0": "thermal_speed",
    "thermal_velocity": "thermal_speed",
    "sonine": "a2",
    "vacf": "velocity_autocorrelation",
    "vdf": "speed_histogram",
    "speed_density": "speed_histogram",
    "position_density": "displacement_histogram",
    "van_hove": "displacement_histogram",
}
"""What people, and the kinetic equation, call outputs, and their names here."""
OBSERVABLES = (*SCALARS, *HISTOGRAMS, *RAW)
"""What may be requested of `simulate`."""
DRIVES = {"bath_speed": "U", "heating": "U^3/d", "drag": "U/d", "capture_speed": "U"}
"""What drives tracers, and what stops them: argument of `simulate` -> unit."""
