"""The scattering function of one tracer, wave number by wave number."""

import math

import numpy as np

from kinetics import CollisionLaw
from kinetics.numerics.panels import PanelRule
from kinetics.position.scattering import Sweep, solve_waves


def test_the_harmonics_left_out_are_replaced_by_steady_flights() -> None:
    """They cost accuracy: with 16 of them it is 1e-5 at K = 4, and 7e-5 with nothing there."""
    law, k, rule = CollisionLaw(0.6), np.array([4.0]), PanelRule(16, 0.125)
    x = np.linspace(-3.0, 5.0, 80)
    start = 0.125 * math.floor(math.log(5.0 / 6.0) / 0.125)
    few, many = (Sweep(law, k, rule, start, top, 50).run(50, 1e-16, 0)(x) for top in (16, 60))
    assert np.abs(few - many).max() < 3e-5


def test_waves_meet_the_accuracy_asked_for() -> None:
    """Against many more nodes and harmonics, over what a density uses."""
    x = np.linspace(-3.0, 6.0, 120)
    for e in (0.0, 0.5, 1.0):
        law = CollisionLaw(e)
        for k in (0.3, 2.0, 6.0):
            best = solve_waves(law, np.array([k]), 6.0, 1e-12)(x)
            for tolerance in (1e-4, 1e-7):
                found = solve_waves(law, np.array([k]), 6.0, tolerance)
                assert np.abs(found(x) - best).max() < tolerance
                assert found.errors[-1] < 10.0 * tolerance
