"""The paper's approximations as numbers: Sonine, Chapman-Enskog, random walk and G(R).

Kim and Hayakawa, "Statistical Properties of Inelastic Lorentz Gas". Each printed formula is a
function whose docstring gives its LaTeX label. Where a formula has an error, ``as_printed=False``
or a function with ``corrected`` in its name gives the right one. The solvers use nothing of this:
reports compare these curves with the kinetic equation. There are also the same approximations at
any Sonine order, and fits of the printed G(R).

Lengths are in scatterer diameters d, speeds in U, times in d/U, number densities in d^-2. Arguments
of the printed formulas broadcast as numpy arrays; bad ones raise InputError, a ValueError.

- :mod:`kinetics.sonine.first_order`: a2, M2, M4, h(e), the VDF, v0(t)
- :mod:`kinetics.sonine.random_walk`: collision times and numbers, <r^2>
- :mod:`kinetics.sonine.diffusion`: Chapman-Enskog, the coefficient at one speed
- :mod:`kinetics.sonine.position`, :mod:`kinetics.sonine.fit`: G(R) and its two constants
- :mod:`kinetics.sonine.series`, :mod:`kinetics.sonine.diffusion_series`: Sonine of any order
"""

from kinetics.sonine.diffusion import (
    diffusion_at_hopping_speed,
    diffusion_at_speed,
    diffusion_at_speed_scaling,
    diffusion_coefficient,
    diffusion_from_rates,
    diffusion_rate,
    msd_of_diffusion,
    msd_sonine,
)
from kinetics.sonine.diffusion_series import SonineDiffusion, diffusion_of_order
from kinetics.sonine.first_order import (
    FITTED_COOLING_FACTOR,
    THERMAL_SPEED_START,
    THRESHOLD_RESTITUTION,
    a2,
    cooling_rate,
    cooling_rate_fitted,
    m2,
    m4,
    stability,
    thermal_speed,
    vdf,
)
from kinetics.sonine.fit import PositionFit, fit_position
from kinetics.sonine.position import (
    PEAK_ETA,
    PEAK_SPEED,
    TAIL_ETA,
    TAIL_GAMMA,
    displacement_density,
    position_exponent,
    position_far_tail,
    position_far_tail_corrected,
    position_given_speed,
    position_integral,
    position_peak,
    position_saddle,
    position_steepest_descent,
    position_tail,
)
from kinetics.sonine.random_walk import (
    FITTED_FREE_PATH,
    alpha,
    beta,
    collision_count,
    collision_interval,
    collision_interval_number,
    collision_time,
    eta_random_walk,
    msd_random_walk,
)
from kinetics.sonine.series import (
    SeriesStatus,
    SonineCooling,
    SonineState,
    cooling,
    exact_coefficients,
    scaled_state,
)

__all__ = [
    "FITTED_COOLING_FACTOR",
    "FITTED_FREE_PATH",
    "PEAK_ETA",
    "PEAK_SPEED",
    "TAIL_ETA",
    "TAIL_GAMMA",
    "THERMAL_SPEED_START",
    "THRESHOLD_RESTITUTION",
    "PositionFit",
    "SeriesStatus",
    "SonineCooling",
    "SonineDiffusion",
    "SonineState",
    "a2",
    "alpha",
    "beta",
    "collision_count",
    "collision_interval",
    "collision_interval_number",
    "collision_time",
    "cooling",
    "cooling_rate",
    "cooling_rate_fitted",
    "diffusion_at_hopping_speed",
    "diffusion_at_speed",
    "diffusion_at_speed_scaling",
    "diffusion_coefficient",
    "diffusion_from_rates",
    "diffusion_of_order",
    "diffusion_rate",
    "displacement_density",
    "eta_random_walk",
    "exact_coefficients",
    "fit_position",
    "m2",
    "m4",
    "msd_of_diffusion",
    "msd_random_walk",
    "msd_sonine",
    "position_exponent",
    "position_far_tail",
    "position_far_tail_corrected",
    "position_given_speed",
    "position_integral",
    "position_peak",
    "position_saddle",
    "position_steepest_descent",
    "position_tail",
    "scaled_state",
    "stability",
    "thermal_speed",
    "vdf",
]
