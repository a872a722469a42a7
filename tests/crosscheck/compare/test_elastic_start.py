"""Elastic tracers whose speeds have no name are compared by their averages."""

import numpy as np

from kinetics import compare
from particles import BoltzmannGrad, simulate


def test_speeds_of_no_named_start_are_compared_at_restitution_1() -> None:
    """Their density is that of the start, of which the solver has none."""
    generator = np.random.default_rng(2)
    speed = generator.uniform(0.3, 1.7, (500, 1))
    angle = generator.uniform(0.0, 2.0 * np.pi, (500, 1))
    start = speed[..., None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    run = simulate(
        BoltzmannGrad(0.05),
        1.0,
        initial=start,
        times=[0.0, 2.0, 10.0, 40.0],
        media=500,
        tracers=1,
        seed=3,
        workers=1,
        observables=("positions", "velocities"),
    )
    data = {"times": run.times, "positions": run.positions, "velocities": run.velocities}
    result = compare(data, 1.0, 0.05, scatterers="dilute", explain=False)
    assert result.verdict == "agrees"
    assert "msd" in {test.observable for test in result.tests}
    assert any("speed density" in text for text in result.warnings)
