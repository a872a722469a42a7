"""`lorentz solve` with a field: the steady state, units, and averages over time."""

import math
from pathlib import Path
from typing import Any

import pytest

from kinetics import load, solve_field

RTOL = ["--rtol", "1e-4"]


def test_steady_state(lorentz: Any) -> None:
    arguments = ("solve", "--field-steady", "-e", "0.5", "--dimension", "3", *RTOL)
    found = lorentz.json(*arguments, "--field-units", "9.81,0.001,1e8")
    state = solve_field(0.5, 3, rtol=1e-4)
    assert found["drift"] == state.drift
    assert found["diffusion_parallel"] == state.diffusion_parallel
    assert found["status"] == "converged"
    assert found["plan"][0]["part"] == "angular harmonics"
    path = 1.0 / (math.pi * 1e-6 * 1e8)
    assert found["in_units"]["drift"] == pytest.approx(state.drift * math.sqrt(9.81 * path))
    assert f"drift                    {state.drift:.13g}" in lorentz(*arguments)


def test_averages_over_time(lorentz: Any) -> None:
    asked = ("--outputs", "mean_velocity,displacement_tensor,collisions")
    arguments = ("solve", "--field", "0.08", "--initial", "rest", "--times", "1,100", *asked, *RTOL)
    found = lorentz.json(*arguments)
    assert found["field"] == 0.08
    assert found["mean_velocity"][0][0] == pytest.approx(0.08, rel=0.01)
    assert found["mean_velocity"][1][0] == pytest.approx(solve_field(0.7).drift, rel=1e-4)
    heads = lorentz(*arguments).splitlines()[0]
    assert all(head in heads for head in ("<v_x> [U]", "var(x) [d^2]", "collisions"))


@pytest.mark.parametrize(
    "arguments",
    [
        ("--initial", "rest"),
        ("--field-steady", "-e", "1"),
        ("--field-steady", "--scaled"),
        ("--field-units", "1,2,3"),
        ("--field-steady", "--field-units", "1,2"),
        ("--field-steady", "--field-units", "0,1,1"),
        ("--field-steady", "--field-units", "nan,1,1"),
        ("--field-steady", "--field", "1"),
        ("--field-steady", "--speeds", "1"),
        ("--field-steady", "--scatterers", "overlapping"),
        ("--scaled", "--times", "1,2"),
        ("--scaled", "--field", "1"),
        ("--until", "5", "--times", "1,2"),
        ("--speeds", "1,,2"),
        ("--field", "1", "--outputs", "kurtosis"),
        ("--field", "-1"),
    ],
)
def test_refusals(lorentz: Any, arguments: tuple[str, ...]) -> None:
    lorentz.refused("solve", *arguments)


@pytest.mark.parametrize("name", ["x.h5", "X.H5"])
def test_the_ending_of_a_file_may_be_in_capitals(lorentz: Any, tmp_path: Path, name: str) -> None:
    lorentz("solve", "--times", "1", *RTOL, "--output", str(tmp_path / name))
    assert load(tmp_path / name).scene.restitution == 0.7
