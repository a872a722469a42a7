"""A status says what to change, and which part missed its tolerance."""

import pytest

from kinetics import Scene, SolverStatus, ToleranceWarning, solve


def test_what_the_message_says_helps() -> None:
    """Doing what the message of a solution says makes it converge."""
    scene = Scene(0.7, times=[0.0, 1.0, 30.0], outputs=("msd", "speed_density"))
    missed = solve(scene, rtol=1e-6, nodes=16)
    assert missed.status is SolverStatus.TOLERANCE_NOT_REACHED
    assert "densities:" in missed.message
    assert "averages:" not in missed.message
    assert "more nodes than 16" in missed.message
    assert "raise rtol" not in missed.message  # the estimate is above the largest rtol
    nearly = solve(scene, rtol=1e-6, nodes=200)
    assert "raise rtol" in nearly.message
    raised = float(nearly.message.split("raise rtol to ")[1].split(",")[0])
    assert solve(scene, rtol=raised, nodes=200).status is SolverStatus.CONVERGED
    assert solve(scene, rtol=1e-6, nodes=400).status is SolverStatus.CONVERGED
    met = solve(scene, rtol=1e-6)
    assert met.status is SolverStatus.CONVERGED
    assert met.message == SolverStatus.CONVERGED.value


def test_a_missed_tolerance_warns_at_the_line_that_asked() -> None:
    scene = Scene(0.7, times=[1.0], outputs=("speed_density",))
    with pytest.warns(ToleranceWarning, match="more nodes") as caught:
        solve(scene, rtol=1e-10, nodes=16)
    assert caught[0].filename == __file__
