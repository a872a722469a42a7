"""What may be asked, under which name it is answered, and what a missed tolerance says."""

import subprocess
import sys

import numpy as np
import pytest

from kinetics import Beam, Scene, SolverStatus, ToleranceWarning, solve
from kinetics.errors import judge_errors
from kinetics.moments.outputs import averaged_outputs
from kinetics.outputs import OUTPUTS, described


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


TIMES = [0.0, 1.0, 100.0]


@pytest.mark.parametrize("name", OUTPUTS)
def test_every_row(name: str) -> None:
    """Array or method under the name of the row, of the shape that the row says."""
    row = OUTPUTS[name]
    solution = solve(Scene(0.7, initial=Beam(), times=TIMES, outputs=name, harmonics=1), rtol=1e-3)
    found = getattr(solution, name)
    if name not in averaged_outputs(2):
        assert callable(found)
        assert list(solution.values) == []
    else:
        assert tuple(solution.values) == row.names
        expected = [{"n_times": len(TIMES), "d": 2}[n] for n in row.shape]
        assert all(solution.values[n].shape == tuple(expected) for n in row.names)
    assert all(described(n, 2)[0] for n in row.names)
    steps = {step.part: step.solved for step in solution.plan}
    assert steps[row.step]


def test_what_the_message_says_helps() -> None:
    """Doing what the message of a solution says makes it converge."""
    scene = Scene(0.7, times=[0.0, 1.0, 30.0], outputs=("msd", "speed_density"))
    missed = solve(scene, rtol=1e-6, nodes=16)
    assert missed.status is SolverStatus.TOLERANCE_NOT_REACHED
    assert "densities:" in missed.message
    assert "more nodes than 16" in missed.message
    nearly = solve(scene, rtol=1e-6, nodes=200)
    raised = float(nearly.message.split("raise rtol to ")[1].split(",")[0])
    assert solve(scene, rtol=raised, nodes=200).status is SolverStatus.CONVERGED
    assert solve(scene, rtol=1e-6, nodes=400).status is SolverStatus.CONVERGED
    assert solve(scene, rtol=1e-6).message == SolverStatus.CONVERGED.value


def test_a_missed_tolerance_warns_at_the_line_that_asked() -> None:
    scene = Scene(0.7, times=[1.0], outputs=("speed_density",))
    with pytest.warns(ToleranceWarning, match="more nodes") as caught:
        solve(scene, rtol=1e-10, nodes=16)
    assert caught[0].filename == __file__


@pytest.mark.parametrize("error", [float("nan"), float("inf"), 1.1e-6])
def test_an_error_that_is_unknown_or_too_large_has_not_converged(error: float) -> None:
    tolerance = {"averages": 1e-6, "densities": 1e-4}
    status, message = judge_errors({"averages": error, "densities": 1e-9}, tolerance)
    assert status is SolverStatus.TOLERANCE_NOT_REACHED
    assert "averages" in message
    assert "densities" not in message
    status, _ = judge_errors({"averages": 1e-6, "densities": 1e-4}, tolerance)
    assert status is SolverStatus.CONVERGED
