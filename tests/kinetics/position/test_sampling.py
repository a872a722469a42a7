"""Few wave numbers for F, and its end beyond them."""

import numpy as np
import pytest

from kinetics import Scene, SpeedTable, solve
from kinetics.position.wave_panel import Sampling

TIMES = np.array([0])


def test_an_even_polynomial_needs_half_of_the_points() -> None:
    sampling = Sampling(0.0, 2.0, 15)
    f = np.exp(-(sampling.places**2))[None]
    assert sampling.missed(f) < 1e-9
    panel = sampling.panel(TIMES, f, 30)
    assert np.abs(panel.values[0] - np.exp(-(panel.nodes**2))).max() < 1e-9


def test_a_power_needs_few_points() -> None:
    def exact(k: np.ndarray) -> np.ndarray:
        return (1.0 + k**2) ** -1.5

    few, plain = Sampling(4.0, 8.0, 8, 3), Sampling(4.0, 8.0, 8)
    f = exact(few.places)[None]
    assert few.missed(f) < 1e-10 < 1e-7 < plain.missed(exact(plain.places)[None])
    panel = few.panel(TIMES, f, 20)
    assert np.abs(panel.values[0] - exact(panel.nodes)).max() < 1e-10
    assert (panel.low, panel.high) == (4.0, 8.0)


@pytest.mark.parametrize(
    ("e", "t", "initial"),
    [
        # F goes over from one power to the next beyond the data: an error of 2.8e-3 was said to
        # be 4e-4
        (0.2, 100.0, "gaussian"),
        # as many tracers at rest as at any speed: F falls as K^-2, and an error of 3.9e-3 was said
        # to be 7e-4
        (0.7, 300.0, SpeedTable([0.0, 1.0], [1.0, 1.0])),
    ],
)
def test_the_end_of_f_is_right_beyond_the_data(e: float, t: float, initial: object) -> None:
    scene = Scene(e, initial=initial, times=[t], outputs=("position_density",))
    R = np.array([0.001, 0.01, 0.03, 0.1, 0.2, 0.4, 1.0])
    best, found = solve(scene, rtol=1e-4), solve(scene, rtol=1e-3)
    assert best.status.name == found.status.name == "CONVERGED"
    apart = found.scaled_position_density(R) - best.scaled_position_density(R)
    assert np.abs(apart).max() < min(1e-3, 2.0 * found.error_estimate)
