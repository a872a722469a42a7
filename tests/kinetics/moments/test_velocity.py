"""solve: averages in time against Mellin-Barnes integrals and power series in mpmath."""

from typing import Any

import numpy as np
import pytest
from cooling import SAMPLES, TABLE, TIMES

from kinetics import ScalingSolution, Scene, Solution, SolverStatus, SpeedSamples, SpeedTable, solve
from kinetics.crosscheck.references import load

MEANS = ("thermal_speed", "temperature", "a2", "collisions", "msd")
EVOLUTION = load()["evolution"]
OTHERS: dict[str, Any] = {
    "table": SpeedTable(*TABLE),
    "samples": SpeedSamples(SAMPLES),
    "exponential": lambda v: v * np.exp(-v),
    "power_law": lambda v: 5.0 * v * (1.0 + v * v) ** -3.5,
}


def errors(solution: Solution, rows: Any) -> dict[str, float]:
    """Largest relative error of each output over the times; of a2 relative to 1 + a2."""
    v2, v4 = np.array(rows["v^2"]), np.array(rows["v^4"])
    ratio = 0.5 * v4 / v2**2
    return {
        "thermal_speed": float(np.max(np.abs(solution.thermal_speed / np.sqrt(v2) - 1))),
        "temperature": float(np.max(np.abs(2 * solution.temperature / v2 - 1))),
        "a2": float(np.max(np.abs(solution.a2 + 1 - ratio) / ratio)),
        "collisions": float(np.max(np.abs(solution.collisions / rows["collisions"] - 1))),
        "msd": float(np.max(np.abs(solution.msd / rows["msd"] - 1))),
    }


@pytest.mark.parametrize("e", ["0.0", "0.05", "0.4", "0.7", "0.9", "0.99"])
@pytest.mark.parametrize("name", ["monoenergetic", "gaussian"])
def test_averages_at_times_up_to_1e8(e: str, name: str) -> None:
    """As accurate as asked for; and at 1e-6 not 1000 times more so, which would cost time."""
    rows = EVOLUTION[e][name]
    for rtol in (1e-6, 1e-8, 1e-10, 1e-12):
        scene = Scene(float(e), times=TIMES, initial=name, outputs=MEANS)
        solution = solve(scene, rtol=rtol)
        assert solution.status is SolverStatus.CONVERGED
        assert solution.error_estimate <= rtol
        worst = max(errors(solution, rows).values())
        assert worst <= rtol
        assert worst >= 1e-9 or rtol < 1e-6
        for p in (1.0, 2.5, 6.0):
            if f"v^{p:g}" in rows:
                tolerance = max(rtol, 1e-11)
                np.testing.assert_allclose(solution.moment(p), rows[f"v^{p:g}"], rtol=tolerance)


@pytest.mark.parametrize("e", ["0.05", "0.7"])
@pytest.mark.parametrize("name", OTHERS)
def test_other_starts(e: str, name: str) -> None:
    """The last one has a tail v^-6: <v^4> is 1/4 of its way from diverging."""
    scene = Scene(float(e), times=TIMES, initial=OTHERS[name], outputs=MEANS)
    found = errors(solve(scene, rtol=1e-12), EVOLUTION[e][name])
    assert max(found.values()) <= 2e-12, found


@pytest.mark.parametrize("e", [0.0, 1e-8, 0.4, 0.9, 0.99])
@pytest.mark.parametrize("name", ["gaussian", "monoenergetic"])
def test_the_latest_times_are_the_scaling_state(e: float, name: str) -> None:
    """v0 = 2 l/(h t), and d<r^2>/d ln t = 2 l^2/(kappa (1 - <cos chi>)), up to 1e300."""
    exact = ScalingSolution(e)
    times = [1e14, 1e100, 1e150, 1e300]
    solution = solve(Scene(e, times=times, initial=name, outputs=MEANS), rtol=1e-12)
    thermal = 2 * 12.5 / (exact.cooling_rate * np.array(times))
    np.testing.assert_allclose(solution.thermal_speed, thermal, rtol=1e-10)
    np.testing.assert_allclose(solution.a2, exact.a2, atol=1e-10 * (1 + abs(exact.a2)))
    slope = np.diff(solution.msd) / np.diff(np.log(times))
    np.testing.assert_allclose(slope, 12.5**2 * exact.diffusion_slope, rtol=1e-9)
    rate = np.diff(solution.collisions) / np.diff(np.log(times))
    np.testing.assert_allclose(rate, 1 / exact.law.mean_log_loss, rtol=1e-9)
