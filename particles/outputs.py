"""The names of what a run can give, with their units: one table for results, files and commands."""

from particles.kernel.columns import HISTOGRAMS

SCALARS = {
    "thermal_speed": ("U", "sqrt(<v^2>)"),
    "a2": ("1", "<v^4>/(k <v^2>^2) - 1, k = 2 in the plane and 5/3 in space"),
    "msd": ("d^2", "mean square displacement"),
    "kurtosis": ("1", "<r^4>/<r^2>^2"),
    "collisions": ("1", "mean number of collisions per tracer"),
    "velocity_autocorrelation": ("U^2", "<v(t).v(0)>"),
    "mean_free_path": ("d", "path per collision"),
}
"""Estimates of every run: name -> unit, and what it is in words."""
IN_FIELD = {
    "drift": ("U", "<v_x>"),
    "drift_of_moving": ("U", "<v_x> of the tracers that are not trapped"),
    "trapped_fraction": ("1", "share of the tracers that are trapped or captured"),
    "mean_velocity": ("U", "<v>"),
    "velocity_tensor": ("U^2", "<v_i v_j>"),
    "mean_displacement": ("d", "<r>"),
    "dispersion": ("d^2", "covariance of the displacement"),
    "dispersion_parallel": ("d^2", "variance of the displacement along the field"),
    "dispersion_perpendicular": ("d^2", "variance across the field, of one direction"),
}
"""Estimates of a run in a field."""
OF_A_DEPTH = {
    "passed": ("1", "share of the tracers that have reached the depth"),
    "mean_passage_time": ("d/U", "mean time of the first passage of the depth"),
}
"""Estimates of a run in a field with a depth, which has `passage_times` too."""
DRIVES = {"bath_speed": "U", "heating": "U^3/d", "drag": "U/d", "capture_speed": "U"}
"""What drives tracers, and what stops them: argument of `simulate` -> unit."""
ESTIMATES = SCALARS | IN_FIELD | OF_A_DEPTH
VARIABLES = {
    "speed_histogram": ("v", "U", "speed |v|"),
    "velocity_component_histogram": ("v_x", "U", "velocity component |v_x|"),
    "displacement_histogram": ("r", "d", "displacement |r|"),
    "free_path_histogram": ("path", "d", "length of a free flight"),
    "free_time_histogram": ("flight_time", "d/U", "duration of a free flight"),
}
"""Name of a histogram -> symbol, unit and words of what is counted."""
RAW = ("positions", "velocities", "finals")
OBSERVABLES = (*SCALARS, *HISTOGRAMS, *RAW)
