"""The kinetic equation's own particle method against the equation: two programs, no formula shared.

Times reach from the first collisions to deep in the scaling state. 3 sigma for each number at one
fixed seed: of some 40 numbers, strongly correlated in time, 0.1 are expected beyond it.
"""

import numpy as np
import pytest

from kinetics import Scene, solve
from particles import BoltzmannGrad, Ensemble, simulate

TIMES = np.array([3.0, 30.0, 1000.0])
NAMES = ("thermal_speed", "a2", "msd", "kurtosis", "collisions")


def compare(ensemble: Ensemble, initial: str, names: tuple[str, ...]) -> None:
    scene = Scene(
        restitution=ensemble.restitution, number_density=0.04, initial=initial, times=TIMES,
        outputs=names,
    )  # fmt: skip
    solution = solve(scene, rtol=1e-7)
    for name in names:
        estimate = getattr(ensemble, name)
        sigmas = (estimate.value - getattr(solution, name)) / estimate.error
        assert np.all(abs(sigmas) < 3), (name, sigmas)


@pytest.mark.parametrize("initial", ["gaussian", "monoenergetic"])
@pytest.mark.parametrize("restitution", [0.4, 0.9])
def test_boltzmann_grad_meets_the_kinetic_equation(restitution: float, initial: str) -> None:
    ensemble = simulate(
        BoltzmannGrad(0.04), restitution, initial, times=TIMES, media=100, tracers=1000, seed=17
    )
    compare(ensemble, initial, NAMES)
