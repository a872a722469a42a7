"""Tracers that have not collided: their density against its formula, and results as plain data."""

import math
from typing import Any

import numpy as np
import pytest

from kinetics import Beam, SpeedTable
from kinetics.position.density import Uncollided
from kinetics.states.kinds import Gaussian, State, as_state

PATH = 12.5
TIMES = np.array([0.0, 0.3, 40.0, 1e4])


def top_hat(v: np.ndarray) -> np.ndarray:
    """1/2 up to a speed of 2: a jump of which nobody tells the solver."""
    return np.where(v < 2.0, 0.5, 0.0)


def root_start(v: np.ndarray) -> np.ndarray:
    """v^(1/2) exp(-v), normalised: not smooth at 0."""
    return np.sqrt(v) * np.exp(-v) / (0.5 * math.sqrt(math.pi))


STARTS: list[tuple[State, Any]] = [
    (Gaussian(), lambda v: v * np.exp(-0.5 * v * v)),
    (as_state(root_start), root_start),
    (as_state(top_hat), top_hat),
    (SpeedTable([0.2, 0.9, 2.0], [0.0, 1.0 / 0.9, 0.0]), None),
    (Beam(0.4, speeds="gaussian"), lambda v: v * np.exp(-0.5 * v * v)),
]


@pytest.mark.parametrize(("state", "exact"), STARTS)
def test_the_density_is_that_of_the_start(state: State, exact: Any) -> None:
    """f(r/t) exp(-r/l)/t, also between the points at which f was taken."""
    found = Uncollided(state, PATH, TIMES)
    v = np.concatenate([np.linspace(0.0, 1.9999, 500), np.linspace(2.0001, 9.0, 300)])
    f = exact(v) if exact else np.interp(v, [0.2, 0.9, 2.0], [0.0, 1.0 / 0.9, 0.0])
    for i, t in enumerate(TIMES[1:], start=1):
        r = v * t
        expected = f * np.exp(-r / PATH) / t
        assert np.abs(found.at(i, r) - expected).max() < 3e-13 / t
    assert not found.at(0, v).any()
    assert not found.at(1, np.array([1e300])).any()
