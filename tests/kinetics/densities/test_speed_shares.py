"""The speeds of the tracers as points: averages over them against the averages that are solved."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from kinetics import Scene, SpeedSamples, SpeedTable, solve
from kinetics.densities.harmonic import Profile
from kinetics.densities.speed_shares import SpeedShares
from kinetics.undriven import UndrivenAnswer

TIMES = np.array([0.0, 0.5, 3.0, 40.0])
STARTS: dict[str, Any] = {
    "gaussian": "gaussian",
    "one speed": "monoenergetic",
    "three speeds": SpeedSamples([0.5, 1.0, 1.7]),
    "table": SpeedTable([0.5, 1.5], [0.5, 1.5]),
}


def speed_shares(scene: Scene, rtol: float) -> SpeedShares:
    law, path, state, times = scene.problem

    def solve_speeds(at_times: Any) -> Profile:
        at_those = replace(scene, times=at_times, outputs=("speed_density",))
        return UndrivenAnswer(at_those, rtol, None, None).profiles[0]

    return SpeedShares.of(solve_speeds, law, state, times / path, path)


@pytest.mark.parametrize("e", [0.0, 0.7, 1.0])
@pytest.mark.parametrize("start", STARTS)
def test_averages_over_the_shares_are_those_that_are_solved(start: str, e: float) -> None:
    scene = Scene(e, 0.04, initial=STARTS[start], times=TIMES, outputs=("thermal_speed",))
    shares = speed_shares(scene, 1e-3)
    solution = solve(scene, 1e-9)
    for p in (1.0, 2.0):
        average = shares.average(lambda v, p=p: v**p)
        # collisions are right to 1e-3 from rough starts, and do less to averages
        np.testing.assert_allclose(average, solution.moment(p), rtol=1e-4)


@pytest.mark.parametrize("start", STARTS)
def test_all_tracers_have_a_speed_at_all_times(start: str) -> None:
    scene = Scene(0.7, 0.04, initial=STARTS[start], times=TIMES, outputs=("thermal_speed",))
    shares = speed_shares(scene, 1e-3)
    np.testing.assert_allclose(shares.average(np.ones_like), 1.0, rtol=1e-12)


def test_tracers_of_sharp_speeds_that_have_not_collided_are_apart() -> None:
    scene = Scene(0.7, 0.04, initial=STARTS["three speeds"], times=TIMES, outputs="thermal_speed")
    shares = speed_shares(scene, 1e-2)
    speeds = np.array([0.5, 1.0, 1.7])
    # each speed v keeps exp(-v t/l) of its third
    uncollided = np.exp(-np.outer(TIMES / scene.mean_free_path, speeds)).mean(axis=1)
    np.testing.assert_allclose(shares.sharp.remaining(shares.times), uncollided, rtol=1e-12)
    np.testing.assert_allclose(shares.shares.sum(axis=1), 1.0 - uncollided, atol=1e-12)
