"""The contract: numbers that stay, what is said of a file of particles, and the public names."""

import importlib
import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import questions
from questions import FIELD, NUMBERS, QUESTIONS, TOLD

KEPT = json.loads(NUMBERS.read_text(encoding="utf-8"))
NAMES = {
    "kinetics": """AngularHarmonics Beam CollisionLaw FieldState Gaussian InputError Monoenergetic
        PolarGrid ScaledVDF ScalingSolution Scene Solution SolverStatus SpeedDensity SpeedSamples
        SpeedTable ToleranceWarning VelocitySamples __version__ compare fit load solve solve_field
        solve_scaled sonine solve_steady sweep Viscoelastic DrivenState ModelWarning""",
    "particles": """OBSERVABLES BoltzmannGrad Ensemble Estimate HardDisks HardSpheres Histogram
        Medium Poisson PoissonSpheres Positions Statuses load simulate""",
    "derivations": "verify printed_equation",
    "kinetics.crosscheck": "Comparison compare compare_data fit_data",
    "kinetics.CollisionLaw": """mean_speed_ratio_power decay_rate mean_cosine mean_log_loss
        from_samples mixture""",
    "kinetics.ScalingSolution": """cooling_rate a2 moment vdf diffusion_slope save to_xarray plot
        collision_cumulants collision_power path_cumulants""",
    "kinetics.ScaledVDF": """cooling_rate a2 moment vdf nodes error_estimate status message save
        to_dataframe to_xarray plot""",
    "kinetics.Solution": """plan stats status message save to_dataframe to_xarray plot speed_density
        position_density scaled_position_density intermediate_scattering velocity_density
        model_error""",
    "kinetics.FieldState": """drift mean_square_speed moment diffusion_parallel plan vdf
        diffusion_perpendicular error_estimate status save to_dataframe to_xarray plot""",
    "particles.Ensemble": "thermal_speed statuses save to_dataframe to_xarray plot write_h5md",
}


@pytest.mark.parametrize("name", QUESTIONS)
def test_a_number_that_stays(name: str) -> None:
    rtol, answer = QUESTIONS[name]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a missed tolerance warns; only the numbers count here
        found = np.array(questions.flat(answer()))
    kept = np.array(KEPT[name])
    assert found.shape == kept.shape
    # what is zero by symmetry is rounding, of no size of its own
    np.testing.assert_allclose(found, kept, rtol=rtol, atol=1e-13 * np.nanmax(np.abs(kept)))


@pytest.mark.parametrize("name", FIELD)
def test_the_steady_state_is_that_of_the_prototype(name: str) -> None:
    np.testing.assert_allclose(KEPT[f"steady state in a field {name}"], FIELD[name], rtol=1e-11)


def require_same(found: list[Any], kept: list[Any]) -> None:
    """The same verdicts and degrees of freedom, and chi-squares and p-values.

    Those of averages are from 1,000 simulated sets, where another processor may count one more or
    less; G(R) is solved to what the bins need, to some 1e-4 of a chi-square.
    """
    assert [found[0], *((row[0], row[3:]) for row in _without_numbers(found))] == [
        kept[0], *((row[0], row[3:]) for row in _without_numbers(kept))
    ]  # fmt: skip
    for (name, *numbers, _), (_, *expected, _) in zip(found[1:], kept[1:], strict=True):
        chi_square, freedom, p_value = numbers
        assert freedom == expected[1]
        bound = {"speed_density": 1e-6, "position_density": 1e-3}.get(name, 0.05)
        assert chi_square == pytest.approx(expected[0], rel=bound)
        assert p_value == pytest.approx(expected[2], abs=0.01 if bound > 0.01 else bound)


def _without_numbers(verdicts: list[Any]) -> list[Any]:
    return [[row[0], None, None, row[4]] for row in verdicts[1:]]


def test_what_is_said_of_a_file(tmp_path: Path) -> None:
    """Other formats give the same sums: tests/crosscheck/compare/test_formats.py."""
    questions.write_table(tmp_path / "run.csv", *questions.trajectories())
    for which, arguments in TOLD.items():
        document = questions.judged(tmp_path / "run.csv", *arguments)
        require_same(questions.verdicts(document), KEPT[f"compare {which}"])
        assert set(document) >= {"verdict", "summary", "parameters", "tests", "explanations"}
        for parameter in ("restitution", "mean_free_path"):
            assert set(document["parameters"][parameter]) >= {"value", "error"}


def test_a_file_of_spheres(tmp_path: Path) -> None:
    questions.write_table(tmp_path / "run.csv", *questions.trajectories(3))
    document = questions.judged(tmp_path / "run.csv", *TOLD["true"], "--dimension", "3")
    require_same(questions.verdicts(document), KEPT["compare spheres"])


@pytest.mark.parametrize("owner", NAMES)
def test_public_names(owner: str) -> None:
    module, _, name = owner.partition(".")
    place: Any = importlib.import_module(module if name != "crosscheck" else owner)
    if name and name != "crosscheck":
        place = getattr(place, name)
    fields = getattr(place, "__dataclass_fields__", {})
    missing = {name for name in NAMES[owner].split() if not hasattr(place, name)}
    assert missing <= set(fields)
