"""How fast does a grain percolate? From a restitution, a density and g in SI units to a velocity.

python examples/percolation.py

A small grain falls under gravity among fixed spheres that stand far apart. Between its collisions
it falls freely, each collision takes energy from it, and so it comes to a constant mean velocity.

The contact distance d is the distance of the two centres at a collision: the sum of both radii.
The equation holds in the limit of low density, to the first order in rho d^3; the mean free path
is l = 1/(pi d^2 rho). Speeds are in sqrt(g l) and times in sqrt(l/g).

Three errors are given. That of the solver is what it estimates itself. That of the restitution is
what the uncertainty of a measured restitution makes of the velocity; in practice it is the larger
one by far. The particles, which are an independent method for the same limit, have a statistical
error.
"""

import math

import numpy as np

from kinetics import Scene, solve, solve_field
from particles import BoltzmannGrad, simulate

RESTITUTION, RESTITUTION_ERROR = 0.70, 0.02
CONTACT_DISTANCE = 3e-3  # m
NUMBER_DENSITY = 7.4e5  # 1/m^3: rho d^3 = 0.02
GRAVITY = 9.81  # m/s^2
DEPTH = 1.0  # m
CLOSE = 0.01  # the velocity is reached when it stays as close as this, relative to itself

# The unit of length of a Scene is d. With sqrt(g d) as the unit of speed the field is 1.
SPEED_UNIT = math.sqrt(GRAVITY * CONTACT_DISTANCE)
TIME_UNIT = math.sqrt(CONTACT_DISTANCE / GRAVITY)
DILUTE = NUMBER_DENSITY * CONTACT_DISTANCE**3

# 1. The steady state.
STATE = solve_field(RESTITUTION, dimension=3, rtol=1e-8)
STEADY = STATE.in_units(GRAVITY, CONTACT_DISTANCE, NUMBER_DENSITY)
VELOCITY = STEADY.drift
SOLVER_ERROR = VELOCITY * STATE.error_estimate
ENDS = [
    solve_field(RESTITUTION + sign * RESTITUTION_ERROR, dimension=3, rtol=1e-6)
    .in_units(GRAVITY, CONTACT_DISTANCE, NUMBER_DENSITY)
    .drift
    for sign in (-1, 1)
]
MEASUREMENT_ERROR = abs(ENDS[1] - ENDS[0]) / 2


def falling(times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean velocity, mean depth, and their spread along and across at times in s, from rest.

    Shapes (n_times,), (n_times,) and (n_times, 2); in m and s.
    """
    scene = Scene(
        RESTITUTION, number_density=DILUTE, dimension=3, field=1.0, initial="rest",
        times=times / TIME_UNIT,
        outputs=("mean_velocity", "mean_displacement", "displacement_tensor"),
    )  # fmt: skip
    found = solve(scene, rtol=1e-4)
    squares = found.displacement_tensor
    spread = np.sqrt(np.stack([squares[:, 0, 0], squares[:, 1, 1]], axis=1))
    depth = found.mean_displacement[:, 0] * CONTACT_DISTANCE
    return found.mean_velocity[:, 0] * SPEED_UNIT, depth, spread * CONTACT_DISTANCE


# 2. How long it takes to reach that velocity from rest: the last time at which it is not close.
EARLY = np.linspace(0.0, 12.0 * STEADY.time, 200)[1:]
EARLY_VELOCITY, EARLY_DEPTH, _ = falling(EARLY)
LAST = np.flatnonzero(abs(EARLY_VELOCITY / VELOCITY - 1) > CLOSE)[-1]
REACHED, REACHED_AT = EARLY[LAST], EARLY_DEPTH[LAST]

# 3. The time to the depth, and how far grains are then apart. Later than the approach to the
# steady state, the mean depth grows at the constant velocity.
FALL_TIME = EARLY[-1] + (DEPTH - EARLY_DEPTH[-1]) / VELOCITY
_, FALL_DEPTH, SPREAD = falling(np.array([FALL_TIME]))

# 4. The same from particles, which also say when a grain first comes to the depth.
RUN = simulate(
    BoltzmannGrad(DILUTE, dimension=3), RESTITUTION, "rest", [FALL_TIME / TIME_UNIT],
    media=50, tracers=400, field=1.0, depth=DEPTH / CONTACT_DISTANCE,
)  # fmt: skip
PARTICLE_VELOCITY = (RUN.drift.value[0] * SPEED_UNIT, RUN.drift.error[0] * SPEED_UNIT)
PARTICLE_DEPTH = tuple(
    np.array([RUN.mean_displacement.value[0, 0], RUN.mean_displacement.error[0, 0]])
    * CONTACT_DISTANCE
)
PARTICLE_SPREAD = np.sqrt(
    [RUN.dispersion_parallel.value[0], RUN.dispersion_perpendicular.value[0]]
) * CONTACT_DISTANCE  # fmt: skip
PASSED = RUN.passed  # share of the grains that have been at the depth by then

if __name__ == "__main__":
    print(f"mean free path       {100 * STEADY.mean_free_path:.3g} cm, rho d^3 = {DILUTE:.2g}")
    print(f"velocity             {VELOCITY:.7f} m/s")
    print(f"  error of the solver          {SOLVER_ERROR:.0e} m/s")
    print(f"  e = {RESTITUTION} +- {RESTITUTION_ERROR}           {MEASUREMENT_ERROR:.4f} m/s")
    print("  particles          {:.4f} +- {:.4f} m/s".format(*PARTICLE_VELOCITY))
    print(f"collisions           {STEADY.collision_rate:.3g} per s")
    print(f"reached to {CLOSE:.0%} after  {REACHED:.3g} s, {100 * REACHED_AT:.3g} cm down")
    print(f"fallen {DEPTH:g} m after     {FALL_TIME:.4g} s")
    print("  particles are then {:.4f} +- {:.4f} m down".format(*PARTICLE_DEPTH))
    print(f"  and {PASSED.value[0]:.0%} of them have been at {DEPTH:g} m")
    print(f"spread along g       {100 * SPREAD[0, 0]:.3g} cm", end="")
    print(f" (particles {100 * PARTICLE_SPREAD[0]:.3g} cm)")
    print(f"spread across        {100 * SPREAD[0, 1]:.3g} cm", end="")
    print(f" (particles {100 * PARTICLE_SPREAD[1]:.3g} cm)")
