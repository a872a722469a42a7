"""The kinetic equation's own particle method against the equation: two programs, no formula shared.

Times reach from the first collisions to deep in the scaling state. 4 sigma for each number at one
fixed seed: of some 150 numbers, strongly correlated in time, 0.01 are expected beyond it.
"""

import numpy as np
import pytest
from sigmas import check, check_averages

from kinetics import ScalingSolution, Scene, solve
from particles import BoltzmannGrad, simulate

TIMES = np.array([3.0, 30.0, 1000.0])
NAMES = ("thermal_speed", "a2", "msd", "kurtosis", "collisions")


@pytest.mark.parametrize("initial", ["gaussian", "monoenergetic"])
@pytest.mark.parametrize(
    ("restitution", "tangential", "dimension"),
    [(0.4, 1.0, 2), (0.9, 1.0, 2), (0.0, 1.0, 3), (0.7, 1.0, 3), (0.5, 0.8, 3)],
)
def test_boltzmann_grad_meets_the_kinetic_equation(
    restitution: float, tangential: float, dimension: int, initial: str
) -> None:
    usual = dict(times=TIMES, initial=initial, tangential_restitution=tangential)
    ensemble = simulate(
        BoltzmannGrad(0.04, dimension=dimension), restitution, **usual, media=100, tracers=1000,
        seed=17,
    )  # fmt: skip
    solution = solve(
        Scene(restitution, 0.04, **usual, dimension=dimension, outputs=NAMES), rtol=1e-7
    )
    check_averages(ensemble, solution, NAMES)


@pytest.mark.parametrize(("restitution", "dimension"), [(0.5, 2), (0.7, 3)])
def test_collisions_scatter_as_the_closed_form_says(restitution: float, dimension: int) -> None:
    """Mean and variance of the number of collisions per ln t, between 1e4 and 1e7 d/U."""
    found = []
    for time, seed in ((1e4, 3), (1e7, 4)):
        ensemble = simulate(
            BoltzmannGrad(0.04, dimension=dimension), restitution, times=[time], media=40,
            tracers=2000, seed=seed, initial="monoenergetic", observables=["finals"],
        )  # fmt: skip
        number = ensemble.finals[:, 4].reshape(40, -1)
        found.append([number.mean(axis=1), number.var(axis=1, ddof=1)])
    late, early = np.array(found[1]), np.array(found[0])
    slope = (late.mean(axis=1) - early.mean(axis=1)) / np.log(1e3)
    spread = np.hypot(late.std(axis=1, ddof=1), early.std(axis=1, ddof=1)) / np.log(1e3)
    expected = ScalingSolution(restitution, dimension=dimension).collision_cumulants(2)
    check(slope, spread / np.sqrt(40), expected)
