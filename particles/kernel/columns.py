"""The columns of every table that a run keeps. Importing this file does not import numba.

They are the layout of saved files too (`particles.files`): append, do not renumber.
"""

# How a tracer ended: indices into the counts of statuses.
FINISHED, COLLISION_CAP, TRAPPED, ESCAPED, CAPTURED, STATUSES = range(6)  # the last: how many

# Moments, (n_times, MOMENTS): sums over tracers at one output time of 1, v^2, v^4, r^2, r^4, the
# collisions so far, v(t).v(0), and 1 for a tracer that is trapped or captured. Velocities are
# multiplied by `Records.scales` first.
SAMPLES, SPEED2, SPEED4, R2, R4, COLLISIONS, CORRELATION, CAUGHT, MOMENTS = range(9)

# Sums in a field, (n_times, FIELD_SUMS[dimension]): the velocity, its products v_i v_j (i <= j: xx,
# xy, yy in the plane, xx, xy, xz, yy, yz, zz in space), and the same of the place.
FIELD_SUMS_IN_PLANE = 10
FIELD_SUMS = {2: FIELD_SUMS_IN_PLANE, 3: 18}

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

# Histograms: rows of the table of their grids.
SPEED, COMPONENT, DISTANCE, PATH, DURATION = range(5)
HISTOGRAMS = (
    "speed_histogram",
    "velocity_component_histogram",
    "displacement_histogram",
    "free_path_histogram",
    "free_time_histogram",
)
OF_FLIGHTS = HISTOGRAMS[PATH:]  # of the whole run, not of each output time
