"""A finite density in the clock of the path: simulations against the first order of the theory.

J_m(p) is compared with (l'/l)(1/lambda_m(p) + (-1)^m e^p eps): the mean free path of the medium and
its returns, without a fitted number. The theory's own error is of the order (n ln n)^2; the fitted
second order at m = 1 is below 2 (e n ln n)^2 there, and this much is allowed beside 3.5 sigma.
"""

import math

import numpy as np
import pytest

from kinetics import CollisionLaw
from kinetics.collision import law_in_medium
from particles import ForgetfulPoisson, Medium, Poisson, path_integrals

DENSITY = 0.02
POWERS = [(1, 0.0), (0, 1.0), (2, 0.0), (1, 1.0), (0, 2.0)]


@pytest.mark.parametrize(
    ("e", "medium", "ends"),
    [
        pytest.param(0.5, ForgetfulPoisson(DENSITY, 100), [20.0], marks=pytest.mark.slow),
        pytest.param(0.9, ForgetfulPoisson(DENSITY, 100), [20.0, 60.0], marks=pytest.mark.slow),
        (0.5, Poisson(DENSITY), [20.0]),
    ],
)
def test_overlapping_disks_meet_the_first_order_of_the_density(
    e: float, medium: Medium, ends: list[float]
) -> None:  # fmt: skip
    run = path_integrals(
        medium, e, POWERS, ends, windows=int(300 / ends[-1]), settling=15.0, seed=4
    )
    dilute = CollisionLaw(e)
    law = law_in_medium(dilute, "overlapping", DENSITY, 1.0, "first")
    path = 2.0 * DENSITY * law.mean_free_path(DENSITY, 1.0)
    rates = np.array([law.harmonic_decay_rate(p, m) for m, p in POWERS]) / path
    free = np.array([dilute.harmonic_decay_rate(p, m) for m, p in POWERS])
    # To the last of the paths for p > 0, which decay slowly; to the first one for the others, whose
    # errors grow with it. What is cut off is taken at the rate of one exponential: at most 1 %.
    window = np.array([len(ends) - 1 if p > 0.0 else 0 for _, p in POWERS])
    each = np.arange(len(POWERS))
    value, error = run.integrals.value[window, each], run.integrals.error[window, each]
    cut = np.array(ends)[window]
    allowed = 2.0 * (e * DENSITY * math.log(DENSITY)) ** 2
    assert np.all(abs(value - (1.0 - np.exp(-rates * cut)) / rates) < 3.5 * error + allowed)
    # The dilute equation is far off in at least one of them.
    far = abs(value - (1.0 - np.exp(-free * cut)) / free)
    assert np.any(far > 5.0 * error + allowed)
