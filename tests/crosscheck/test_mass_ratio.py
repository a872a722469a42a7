"""The commands among scatterers that a collision sets in motion."""

from typing import Any

import pytest

from kinetics import ScalingSolution, solve_field

TINY = ("simulate", "--medium", "boltzmann-grad", "--media", "2", "--tracers", "3", "--times", "1")
LIGHT = ("-e", "1", "--mass-ratio", "0.5")


def test_solve(lorentz: Any) -> None:
    exact = ScalingSolution(1.0, dimension=3, mass_ratio=0.5)
    found = lorentz.json("solve", *LIGHT, "--dimension", "3", "--scaled")
    assert found["cooling_rate"] == pytest.approx(exact.cooling_rate, rel=1e-10)
    found = lorentz.json("solve", *LIGHT, "--field-steady")
    assert found["drift"] == pytest.approx(solve_field(1.0, mass_ratio=0.5).drift, rel=1e-10)
    assert found["mass_ratio"] == lorentz.json("solve", *LIGHT, "--times", "1")["mass_ratio"] == 0.5
    # strict JSON has no infinity, which is the default
    assert "mass_ratio" not in lorentz.json("solve", "--times", "1", "--mass-ratio", "inf")


def test_simulate(lorentz: Any) -> None:
    assert lorentz.json(*TINY, *LIGHT)["mass_ratio"] == 0.5
    assert "mass_ratio" not in lorentz.json(*TINY)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("simulate --mass-ratio 2 --times 1", "must be inf for HardDisks"),
        ("simulate --mass-ratio 0 --times 1 --medium boltzmann-grad", "mass_ratio = 0.0: must be"),
        ("solve --mass-ratio nan", "mass_ratio: got nan; it must be a number"),
        ("solve --mass-ratio 2 --scatterers overlapping", "mass_ratio: got 2.0; with scatterers="),
        (
            "solve --mass-ratio 2 --tangential-restitution .5 --scaled",
            "mass_ratio: got 2.0; at tan",
        ),
    ],
)
def test_refused(lorentz: Any, arguments: str, said: str) -> None:
    assert said in lorentz.refused(*arguments.split())
