"""The law of viscoelastic spheres against their collision, integrated."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from kinetics import Viscoelastic, solve_steady


def integrated_restitution(beta: float) -> float:
    """e of x'' + beta sqrt(x) x' + x^(3/2) = 0 from x = 0, x' = 1, until the force ends."""

    def motion(t: float, state: np.ndarray) -> list[float]:
        x = max(state[0], 0.0)
        return [state[1], -beta * np.sqrt(x) * state[1] - x**1.5]

    def force_ends(t: float, state: np.ndarray) -> float:
        return float(state[0] + beta * state[1]) if t > 1e-3 else 1.0

    force_ends.terminal = True  # type: ignore[attr-defined]
    collision = solve_ivp(
        motion, (0.0, 1e4), [0.0, 1.0], "DOP853", events=force_ends, rtol=1e-11, atol=1e-14
    )
    return float(-collision.y_events[0][0][1])


@pytest.mark.parametrize("beta", [0.015, 0.07, 0.1, 0.25, 0.4, 0.8, 1.2, 3.0, 5.0, 40.0])
def test_the_stated_error_of_the_approximant_is_that_of_the_integrated_collision(
    beta: float,
) -> None:
    law = Viscoelastic(beta**0.5)
    difference = float(law(1.0)) - integrated_restitution(beta)
    assert float(law.model_error(1.0)) == pytest.approx(difference, rel=0.1)


def test_the_error_depends_on_the_impact_speed_alone_through_beta() -> None:
    speeds = np.array([[0.0, 1.0], [32.0, 1e5]])
    errors = Viscoelastic(0.5).model_error(speeds)
    assert errors.shape == speeds.shape
    assert errors[0, 0] == 0.0
    assert errors[1, 0] == pytest.approx(float(Viscoelastic(0.5 * 2**0.5).model_error(1.0)))
    assert np.all(errors <= 0.0087)


def test_a_state_of_viscoelastic_spheres_says_so() -> None:
    state = solve_steady(Viscoelastic(0.3), bath_speed=1.0, rtol=1e-6)
    assert "approximant" in state.message
