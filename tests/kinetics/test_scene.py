"""Scenes: what may be asked, and one clear line for what may not."""

import dataclasses
import subprocess
import sys

import numpy as np
import pytest

from kinetics import Beam, Scene, SpeedSamples, solve


def test_equal_times_and_a_single_one_are_fine() -> None:
    assert Scene(0.5, times=3.0).times.shape == (1,)
    solution = solve(Scene(0.5, times=[2.0, 2.0, 3]))
    assert solution.thermal_speed[0] == solution.thermal_speed[1]


def test_nothing_can_be_changed_afterwards() -> None:
    scene = Scene(0.5, times=[1.0, 2.0], initial=Beam(), outputs=["msd", "a2", "msd"])
    solution = solve(scene)
    for thing in (scene, solution, scene.state, solution.plan[0], SpeedSamples([1.0])):
        assert dataclasses.is_dataclass(thing)
        field = dataclasses.fields(thing)[0].name
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(thing, field, None)
    with pytest.raises(ValueError, match="read-only"):
        scene.times[0] = 3.0
    assert scene.outputs == ("msd", "a2")


def test_the_times_of_the_caller_stay_his() -> None:
    times = np.array([1.0, 2.0])
    scene = Scene(0.5, times=times)
    times[0] = 1.5
    assert scene.times[0] == 1.0


def test_outputs_that_were_not_asked_for_say_so() -> None:
    solution = solve(Scene(0.5, times=[1.0, 2.0], outputs="msd"))
    assert solution.msd.shape == (2,)
    assert list(solution.values) == ["msd"]
    with pytest.raises(AttributeError, match="'a2' was not asked for; this solution has msd"):
        _ = solution.a2
    with pytest.raises(AttributeError):
        _ = solution._nothing


def test_units() -> None:
    scene = Scene(0.5, number_density=0.04, diameter=2.0, times=[1.0])
    assert scene.mean_free_path == pytest.approx(1 / (2 * 2.0 * 0.04))
    assert np.array_equal(solve(scene).times, [1.0])


def test_averages_alone_load_no_scipy() -> None:
    code = (
        "import sys, kinetics as k; "
        "k.solve(k.Scene(0.5, times=[0.0, 1.0], outputs=('thermal_speed', 'a2', 'msd'))); "
        "k.solve_scaled(0.7).moment(3.0); k.ScalingSolution(0.7).vdf(1.0); "
        "print('scipy' in sys.modules)"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "False"
