"""Tables of averages are compared and fitted with independent errors."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinetics import Scene, compare, fit, solve
from kinetics.crosscheck.compare.result import Comparison
from kinetics.errors import InputError

TIMES = np.geomspace(2.0, 400.0, 12)
PATH = 12.5
"""Mean free path at n = 0.04, in d."""


def averages(
    seed: int = 1,
    scatterers: str = "dilute",
    error: float = 0.02,
    names: tuple[str, ...] = ("thermal_speed", "msd"),
    times: Any = TIMES,
    initial: str = "gaussian",
) -> dict[str, Any]:
    """Averages of e = 0.7 and n = 0.04 with independent errors, which are stated."""
    scene = Scene(0.7, 0.04, initial=initial, times=times, scatterers=scatterers, outputs=names)
    solution = solve(scene)
    generator = np.random.default_rng(seed)
    columns: dict[str, Any] = {"t": times}
    for name in names:
        exact = np.asarray(getattr(solution, name))
        columns[name] = exact * (1.0 + generator.normal(0.0, error, exact.size))
        columns[f"{name}_error"] = error * exact
    return columns


def without_errors(columns: dict[str, Any]) -> dict[str, Any]:
    return {name: values for name, values in columns.items() if not name.endswith("_error")}


def pulls(result: Comparison) -> list[float]:
    """Deviations of e and ln l from the truth, in stated errors."""
    restitution = result.parameters["restitution"]
    path = result.parameters["mean_free_path"]
    assert restitution.value is not None
    assert restitution.error is not None
    assert path.value is not None
    assert path.error is not None
    return [
        (restitution.value - 0.7) / restitution.error,
        math.log(path.value / PATH) / (path.error / path.value),
    ]


@pytest.mark.parametrize("scatterers", ["dilute", "hard disks"])
@pytest.mark.parametrize(
    "names", [("thermal_speed", "msd"), ("thermal_speed", "kurtosis"), ("msd",)], ids=str
)
def test_a_fit_finds_restitution_and_free_path(names: tuple[str, ...], scatterers: str) -> None:
    result = fit(averages(names=names, scatterers=scatterers), scatterers=scatterers)
    assert result.verdict == "agrees"
    assert np.all(np.abs(pulls(result)) < 3.0)


@pytest.mark.parametrize(("assumed", "verdict"), [(0.7, "agrees"), (0.75, "differs")])
def test_the_right_theory_agrees_and_a_wrong_one_differs(assumed: float, verdict: str) -> None:
    assert compare(averages(), assumed, 0.04).verdict == verdict


def test_the_medium_is_found() -> None:
    assert fit(averages(scatterers="hard disks", error=0.01)).medium == "hard disks"
    assert fit(averages(error=0.01)).medium == "dilute"


def test_one_speed_at_the_start() -> None:
    data = averages(initial="monoenergetic")
    result = compare(data, 0.7, 0.04, initial="one speed", scatterers="dilute")
    assert result.verdict == "agrees"


@pytest.mark.slow
def test_errors_of_what_is_fitted_are_honest() -> None:
    found = [pulls(fit(averages(seed=seed))) for seed in range(40)]
    assert np.all(np.abs(np.mean(found, axis=0)) < 0.35)
    assert np.all(np.abs(np.std(found, axis=0) - 1.0) < 0.3)


def test_mean_speeds_are_those_of_the_density() -> None:
    """<v> of a Gaussian is v0 sqrt(pi)/2: before collisions the thermal speed tells it."""
    times = np.array([1e-3, 2e-3])
    speeds = np.full(2, math.sqrt(math.pi / 2.0))
    data = {"t": times, "mean_speed": speeds, "mean_speed_error": 1e-3 * speeds}
    rows = compare(data, 0.7, 0.04, scatterers="dilute").to_dataframe("mean_speed")
    np.testing.assert_allclose(rows["theory"], speeds, rtol=3e-4)


def test_mean_speeds_among_disks_have_an_error_of_the_theory() -> None:
    data = averages(names=("thermal_speed",), scatterers="hard disks")
    data["mean_speed"] = math.sqrt(math.pi) / 2.0 * data.pop("thermal_speed")
    data["mean_speed_error"] = data.pop("thermal_speed_error")
    dense = compare(data, 0.7, 0.04, scatterers="hard disks").to_dataframe("mean_speed")
    dilute = compare(data, 0.7, 0.04, scatterers="dilute").to_dataframe("mean_speed")
    np.testing.assert_allclose(dilute["error"], data["mean_speed_error"])
    assert np.all(dense["error"][6:] > 1.001 * data["mean_speed_error"][6:])


def test_errors_of_averages_of_disks_are_tested_with_their_correlations() -> None:
    """Of one average alone the test is that of all averages."""
    data = averages(names=("msd",), scatterers="hard disks", error=0.001)
    result = compare(data, 0.7, 0.04, scatterers="hard disks")
    assert result.tests[0].chi_square == pytest.approx(result.chi_square)
    assert result.tests[0].dof == result.dof


def test_tests_of_averages_have_the_degrees_of_freedom_that_a_fit_leaves() -> None:
    """Two numbers fitted to one average leave n - 2 of it."""
    data = averages(names=("msd",))
    result = fit(data, scatterers="dilute")
    assert result.tests[0].dof == TIMES.size - 2
    assert result.tests[0].chi_square == pytest.approx(result.chi_square, rel=1e-3)


def test_media_are_compared_by_the_scatter_where_no_errors_are_stated() -> None:
    """A scatter of 5 % excludes no medium, and one of 0.1 % the wrong one."""
    coarse = fit(without_errors(averages(scatterers="hard disks", error=0.05)))
    assert {coarse.medium, *coarse.undecided} == {"dilute", "hard disks"}
    fine = fit(without_errors(averages(scatterers="hard disks", error=0.001)))
    assert fine.medium == "hard disks"
    assert fine.undecided == ()


def test_averages_without_an_error_beside_others_are_said_to_be_left_out() -> None:
    data = averages()
    data["msd_error"][:3] = np.nan
    data["msd_error"][3] = 0.0
    result = compare(data, 0.7, 0.04, scatterers="dilute")
    assert any("4 averages" in text for text in result.warnings)
    assert len(result.numbers) == 2 * TIMES.size - 4


def test_a_number_without_influence_has_no_value() -> None:
    """Elastic tracers keep their speeds, whatever the mean free path is."""
    data = averages(names=("thermal_speed",))
    data["thermal_speed"] = np.full(TIMES.size, math.sqrt(2.0))
    data["thermal_speed_error"] = np.full(TIMES.size, 0.01)
    result = compare(data, 1.0, scatterers="dilute")
    assert result.parameters["number_density"].value is None
    assert "mean free path" in result.cannot_tell[0]
    assert result.covariance == ((math.inf,),)
    assert "confidence" not in result.figures


def test_a_density_at_the_limit_of_the_theory_is_no_value() -> None:
    """Disks of the density 1 overlap: the theory among hard ones ends before."""
    scene = Scene(0.7, 1.0, times=TIMES, outputs=("thermal_speed", "msd"))
    solution = solve(scene)
    data = {
        "t": TIMES[::2],
        "thermal_speed": solution.thermal_speed[::2],
        "msd": solution.msd[::2],
    }
    with pytest.raises(InputError, match="no restitution and density"):
        fit(data, scatterers="hard disks")


def test_without_errors_nothing_is_tested() -> None:
    """As in the table of the explorer: errors of what is fitted are from the scatter."""
    result = fit(without_errors(averages()), scatterers="dilute")
    assert result.verdict == "not tested"
    assert result.overall_p_value is None
    assert np.all(np.abs(pulls(result)) < 3.0)


def test_what_averages_cannot_tell_has_no_value() -> None:
    """Before a tenth of a mean free time, v0 knows the rate of loss alone."""
    data = averages(names=("thermal_speed",), times=np.linspace(0.1, 1.0, 9))
    result = fit(data, scatterers="dilute")
    assert "e and the mean free path" in result.cannot_tell[0]
    assert result.parameters["restitution"].value is None


def test_units_are_those_of_the_data() -> None:
    data = averages()
    scaled = {
        "t": 1.5 * data["t"],
        "thermal_speed": 2.0 * data["thermal_speed"],
        "thermal_speed_error": 2.0 * data["thermal_speed_error"],
        "msd": 9.0 * data["msd"],
        "msd_error": 9.0 * data["msd_error"],
    }
    plain = compare(data, 0.7, 0.04, scatterers="dilute")
    other = compare(scaled, 0.7, 0.04 / 9.0, scatterers="dilute", diameter=3.0, speed_unit=2.0)
    assert other.chi_square == pytest.approx(plain.chi_square)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"initial": "data"}, "initial"),
        ({"field": 0.1, "restitution": 0.7, "number_density": 0.04}, "without a field"),
        ({"restitution": 1.7}, "restitution: got 1.7"),
        ({"dimension": 3, "scatterers": "hard disks"}, "dilute"),
        ({"mass_ratio": 2.0}, "mass_ratio: got 2"),
        ({"tangential_restitution": 0.5}, "tangential_restitution: got 0.5"),
    ],
    ids=["start", "field", "restitution", "medium in space", "mass ratio", "rough"],
)
def test_what_cannot_be_compared_is_refused(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        compare(averages(), **arguments)


def test_too_few_averages_are_refused() -> None:
    with pytest.raises(InputError, match=r"2 averages.*3 at least"):
        fit(averages(names=("msd",), times=TIMES[:2]))


def test_a_file_is_compared_by_the_command(tmp_path: Path, lorentz: Any) -> None:
    import pandas as pd

    pd.DataFrame(averages()).to_csv(tmp_path / "curve.csv", index=False)
    text = lorentz("compare", str(tmp_path / "curve.csv"), "--restitution", "0.7", "--json")
    assert '"verdict": "agrees"' in text
