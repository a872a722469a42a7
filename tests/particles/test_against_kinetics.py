"""The kinetic equation's own particle method against the equation: two programs, no formula shared.

Times reach from the first collisions to deep in the scaling state. 4 sigma for each number at one
fixed seed: of some 150 numbers, strongly correlated in time, 0.01 are expected beyond it.
"""

import numpy as np
import pytest

from kinetics import Scene, solve
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
    for name in NAMES:
        estimate = getattr(ensemble, name)
        sigmas = (estimate.value - getattr(solution, name)) / estimate.error
        assert np.all(abs(sigmas) < 4), (name, sigmas)
