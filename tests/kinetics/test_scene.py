"""Scenes: what may be asked, and one clear line for what may not."""

import subprocess
import sys

import numpy as np
import pytest

from kinetics import Scene, solve


def test_equal_times_a_single_one_and_repeated_outputs_are_fine() -> None:
    scene = Scene(0.5, number_density=0.04, diameter=2.0, times=3.0)
    assert scene.times.shape == (1,)
    assert scene.mean_free_path == pytest.approx(1 / (2 * 2.0 * 0.04))
    times = np.array([2.0, 2.0, 3.0])
    solution = solve(Scene(0.5, times=times))
    assert solution.thermal_speed[0] == solution.thermal_speed[1]
    assert Scene(0.5, times=times, outputs=["msd", "a2", "msd"]).outputs == ("msd", "a2")
    times[0] = 1.0
    assert solution.times[0] == 2.0  # a copy


def test_averages_alone_load_no_scipy() -> None:
    code = (
        "import sys, kinetics as k; "
        "k.solve(k.Scene(0.5, times=[0.0, 1.0], outputs=('thermal_speed', 'a2', 'msd'))); "
        "k.solve_scaled(0.7).moment(3.0); k.ScalingSolution(0.7).vdf(1.0); "
        "print('scipy' in sys.modules)"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "False"
