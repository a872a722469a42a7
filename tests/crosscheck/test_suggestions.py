"""A wrong word is answered with the one that was probably meant, by every door."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import derivations
import kinetics
import particles
from kinetics import (
    DrivenState,
    FieldState,
    Gaussian,
    InputError,
    ScalingSolution,
    Scene,
    Solution,
    compare,
    solve,
    solve_field,
    solve_steady,
)
from kinetics.cli import main
from kinetics.crosscheck.stress import run_stress
from particles import BoltzmannGrad, Ensemble, Poisson, simulate

TIMES = [1.0, 10.0]


@pytest.fixture(scope="module")
def solution() -> Solution:
    return solve(Scene(0.7, times=TIMES, outputs=("thermal_speed", "msd")))


@pytest.fixture(scope="module")
def run() -> Ensemble:
    return simulate(BoltzmannGrad(0.04), 0.7, times=TIMES, media=12, tracers=5)


def message_of(call: Callable[[], object]) -> str:
    with pytest.raises((ValueError, AttributeError, KeyError)) as caught:
        call()
    return str(caught.value)


# -- outputs ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("word", "meant"),
    [
        ("thermal_sped", "thermal_speed"),
        ("MSD", "msd"),
        ("mean_square_displacement", "msd"),
        ("thermal speed", "thermal_speed"),
    ],
)
def test_an_output_that_was_probably_meant(
    solution: Solution, run: Ensemble, word: str, meant: str
) -> None:
    doors: list[Callable[[], object]] = [
        lambda: getattr(solution, word),
        lambda: solution[word],
        lambda: solution.plot(word),
        lambda: solution.to_dataframe(word),
        lambda: Scene(0.7, times=TIMES, outputs=word),
        lambda: getattr(run, word),
        lambda: run[word],
        lambda: run.plot(word),
        lambda: simulate(BoltzmannGrad(0.04), 0.7, times=TIMES, observables=[word]),
    ]
    for door in doors:
        message = message_of(door)
        assert f"did you mean '{meant}'" in message
        assert "not asked for" not in message


def test_a_vdf_of_a_solution_points_to_the_scaling_solution(solution: Solution) -> None:
    for door in (lambda: solution.vdf, lambda: solution["vdf"], lambda: solution.plot("vdf")):
        assert "ScalingSolution" in message_of(door)


def test_an_output_that_exists_is_to_be_asked_for(solution: Solution, run: Ensemble) -> None:
    for door in (lambda: solution.a2, lambda: solution["a2"], lambda: solution.plot("a2")):
        assert "not asked for" in message_of(door)
    for door in (lambda: run.speed_histogram, lambda: run.plot("speed_histogram")):
        assert "simulate(observables=['speed_histogram'" in message_of(door)


def test_what_is_missing_says_why(run: Ensemble) -> None:
    assert "field" in message_of(lambda: run.drift)
    assert "observables" in message_of(lambda: run.positions)
    assert "depth" in message_of(lambda: run.passage_times)


def test_results_can_be_indexed_by_name(solution: Solution, run: Ensemble) -> None:
    assert solution["msd"].tolist() == solution.msd.tolist()
    assert run["msd"] == run.msd


def test_a_comparison_suggests_its_observables(run: Ensemble) -> None:
    comparison = compare(run, restitution=0.7, number_density=0.04)
    for door in (comparison.plot, comparison.to_dataframe):
        assert "did you mean 'msd'" in message_of(
            lambda door=door: door("mean_square_displacement")
        )


# -- other words -----------------------------------------------------------------------------------


def test_methods_media_starts_labels_groups_and_names(tmp_path: Path) -> None:
    scene = Scene(0.7, times=TIMES)
    frame = pd.DataFrame({"t": TIMES, "position": [0.0, 1.0], "y": [0.0, 1.0], "tracer": [1, 1]})
    frame.to_csv(tmp_path / "data.csv", index=False)
    doors: dict[str, Callable[[], object]] = {
        "conservative": lambda: solve(scene, method="conservativ"),
        "hard disks": lambda: Scene(0.7, times=TIMES, scatterers="hard disk"),
        "overlapping disks": lambda: ScalingSolution(0.7, scatterers="overlaping disks"),
        "gaussian": lambda: Scene(0.7, times=TIMES, initial="gausian"),
        "monoenergetic": lambda: simulate(
            BoltzmannGrad(0.04), 0.7, times=TIMES, initial="monoenergtic"
        ),
        "sonine9": lambda: derivations.verify(["sonin9"]),
        "steady state": lambda: run_stress(groups=["stedy state"]),
        "HardDisks": lambda: particles.HardDiscs,
        "solve": lambda: kinetics.slove,
        "position": lambda: compare(
            tmp_path / "data.csv", restitution=0.7, columns={"x": "positon"}
        ),
    }
    for meant, door in doors.items():
        assert f"did you mean '{meant}'" in message_of(door)


@pytest.mark.parametrize(
    ("line", "meant"),
    [
        ("sovle", "solve"),
        ("solve -e 0.7 --outputs thermal_sped", "thermal_speed"),
        ("solve -e 0.7 --outputs MSD", "msd"),
        ("solve -e 0.7 --scatterers hard-disk", "hard disks"),
        ("solve --restituion 0.7", "--restitution"),
        ("simulate --scatterers overlaping-disks", "overlapping disks"),
        ("simulate --observables positons", "positions"),
        ("simulate --initial gausian", "gaussian"),
        ("derive --only sonin9", "sonine9"),
        ("report --system heatd", "heated"),
        ("bench --case coling", "cooling"),
    ],
)
def test_the_command_line_says_what_was_probably_meant(
    capsys: pytest.CaptureFixture[str], line: str, meant: str
) -> None:
    assert main(line.split()) == 2
    said = capsys.readouterr().err
    assert meant in said.lower().split("did you mean")[-1]
    assert said.count("\n") == 1


def test_an_equation_is_found_by_its_number_in_small_letters() -> None:
    (check,) = derivations.verify(["b15"])
    assert check.label == "sonine9"


# -- the same words everywhere ---------------------------------------------------------------------


@pytest.mark.parametrize(
    "word", ["overlapping disks", "overlapping-disks", "overlapping_disks", "overlapping"]
)
def test_overlapping_disks_have_one_name(word: str) -> None:
    scene = Scene(0.7, times=TIMES, scatterers=word)
    assert scene.scatterers == Poisson(0.04, count=400).scatterers == "overlapping disks"
    assert ScalingSolution(0.7, scatterers=word, number_density=0.04).scatterers == scene.scatterers


def test_several_restitutions_on_the_command_line_point_to_sweep(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["solve", "-e", "0.7,0.8"]) == 2
    assert "sweep" in capsys.readouterr().err


def test_a_figure_of_a_state_below_its_error_is_zero_on_the_command_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["solve", "--steady", "--bath-speed", "1", "-e", "0.7"]) == 0
    lines = dict(line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert lines["a2"] == "0"


# -- files -----------------------------------------------------------------------------------------


def test_the_wrong_package_says_which_loads_a_file(
    tmp_path: Path, solution: Solution, run: Ensemble
) -> None:
    solution.save(tmp_path / "solution.h5")
    run.save(tmp_path / "run.h5")
    assert "kinetics.load" in message_of(lambda: particles.load(tmp_path / "solution.h5"))
    assert "particles.load" in message_of(lambda: kinetics.load(tmp_path / "run.h5"))


# -- nonsense that passed in silence ---------------------------------------------------------------


def test_a_list_of_restitutions_points_to_sweep() -> None:
    for function in (lambda e: Scene(e, times=TIMES), ScalingSolution, solve_field):
        assert "sweep" in message_of(lambda function=function: function([0.7, 0.8]))


def test_more_disks_than_have_room_are_refused() -> None:
    for scatterers in ("hard disks", "overlapping disks"):
        with pytest.raises(InputError, match="number_density"):
            Scene(0.7, 2.0, times=TIMES, scatterers=scatterers)
    with pytest.raises(ValueError, match="number_density"):
        particles.HardDisks(2.0)


def test_one_deviation_is_that_of_all_components() -> None:
    assert Gaussian(1.36) == Gaussian(1.36, 1.36)
    assert Gaussian(1.36).in_space() is not None
    assert Gaussian() == Gaussian(1.0, 1.0)
    assert repr(Gaussian()) == "Gaussian()"
    solution = solve(Scene(0.7, initial=Gaussian(1.36), times=[0.0], outputs="velocity_tensor"))
    np.testing.assert_allclose(solution.velocity_tensor[0], 1.36**2 * np.eye(2))


def test_one_configuration_has_unknown_errors_on_the_command_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    line = "simulate --scatterers dilute --media 1 --tracers 2 --times 1"
    assert main(line.split()) == 0
    table = capsys.readouterr().out
    assert "∞" not in table
    assert "unknown" in table


# -- densities of velocity -------------------------------------------------------------------------


@pytest.fixture(scope="module", params=["driven", "field"])
def state(request: pytest.FixtureRequest) -> DrivenState | FieldState:
    if request.param == "driven":
        return solve_steady(0.7, bath_speed=1.0, rtol=1e-4)
    return solve_field(0.7, rtol=1e-4)


def test_a_vdf_without_an_angle_has_the_shape_of_v(state: Any) -> None:
    v = np.array([0.5, 1.0, 1.5])
    along = state.vdf(v, [0.0, 1.0])
    assert along.shape == (3, 2)
    assert state.vdf(v).shape == (3,)
    assert state.vdf(v).tolist() == along[:, 0].tolist()
    assert np.shape(state.vdf(0.5)) == np.shape(ScalingSolution(0.7).vdf(0.5)) == ()
    assert state.vdf(v, 0.0).shape == (3, 1)
