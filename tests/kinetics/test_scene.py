"""Scenes: what may be asked, and one clear line for what may not."""

import dataclasses
import math
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import kinetics
from kinetics import Beam, InputError, Scene, SpeedSamples, solve
from kinetics.scene import OUTPUTS


def one_line(caught: pytest.ExceptionInfo[InputError], *parts: str) -> None:
    text = str(caught.value)
    assert "\n" not in text
    assert len(text) < 400
    for part in parts:
        assert part in text, text


REFUSED: dict[str, tuple[list[Any], tuple[str, ...]]] = {
    "restitution": ([-0.01, 1.5, math.nan, math.inf, "half", None, 0.5j, True], ("0", "1")),
    "number_density": ([0.0, -0.04, math.nan, math.inf, "x", None], ("above 0",)),
    "diameter": ([0.0, -0.04, math.nan, math.inf, "x", None], ("above 0",)),
    "times": (
        [[], [1.0, 0.5], [-1.0], [0.0, math.nan], [math.inf], [1j], "soon", None, [[1.0], [2.0]]],
        ("not negative", "not falling"),
    ),
    "outputs": ([(), [], 7, None, (None,)], ("thermal_speed",)),
    "harmonics": ([-1, 257, 2.0, True, "8", None], ("0 to 256",)),
    "initial": (["gausian", 3.0, None, np.ones(4)], ("gaussian", "monoenergetic", "SpeedTable")),
}
CASES = [(name, value) for name, (values, _) in REFUSED.items() for value in values]


@pytest.mark.parametrize(("name", "value"), CASES)
def test_what_is_refused(name: str, value: Any) -> None:
    with pytest.raises(InputError) as caught:
        Scene(**{"restitution": 0.5, "times": [1.0], name: value})
    one_line(caught, f"{name}: got ", *REFUSED[name][1])


def test_times_must_be_given() -> None:
    with pytest.raises(InputError, match=r"^times: got \(\)"):
        Scene(0.5)


def test_equal_times_and_a_single_one_are_fine() -> None:
    assert Scene(0.5, times=3.0).times.shape == (1,)
    solution = solve(Scene(0.5, times=[2.0, 2.0, 3]))
    assert solution.thermal_speed[0] == solution.thermal_speed[1]


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("termal_speed", "thermal_speed"),
        ("thermal speed", "thermal_speed"),
        ("colisions", "collisions"),
        ("speed_densty", "speed_density"),
        ("MSD", None),
        ("xyzzy", None),
    ],
)
def test_misspelt_outputs_get_a_suggestion(name: str, near: str | None) -> None:
    with pytest.raises(InputError) as caught:
        Scene(0.5, times=[1.0], outputs=("thermal_speed", name))
    one_line(caught, f"outputs: got {name!r}", "known are", *OUTPUTS)
    if near:
        one_line(caught, f"did you mean {near!r}?")


@pytest.mark.parametrize("rtol", [0.0, 1e-15, 0.5, math.nan, "x"])
def test_bad_rtol(rtol: Any) -> None:
    with pytest.raises(InputError, match=r"^rtol: got .*1e-14 to 0\.1") as caught:
        solve(Scene(0.5, times=[1.0]), rtol=rtol)
    one_line(caught)


def test_bad_scene_method_and_nodes() -> None:
    scene = Scene(0.5, times=[1.0])
    with pytest.raises(InputError, match=r"^scene: got .*must be a Scene"):
        solve({"restitution": 0.5})  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"^method: got 'fast'; .*spectral, conservative"):
        solve(scene, method="fast")
    for nodes in (7, 10_000, 64.0, True):
        with pytest.raises(InputError, match=r"^nodes: got .*8 to 8192"):
            solve(scene, nodes=nodes)  # type: ignore[arg-type]


def test_nothing_can_be_changed_afterwards() -> None:
    scene = Scene(0.5, times=[1.0, 2.0], initial=Beam(), outputs=["msd", "a2", "msd"])
    solution = solve(scene)
    for thing in (scene, solution, scene.state, solution.plan[0], SpeedSamples([1.0])):
        assert dataclasses.is_dataclass(thing)
        field = dataclasses.fields(thing)[0].name
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(thing, field, None)
    with pytest.raises(ValueError, match="read-only"):
        scene.times[0] = 3.0
    assert scene.outputs == ("msd", "a2")


def test_the_times_of_the_caller_stay_his() -> None:
    times = np.array([1.0, 2.0])
    scene = Scene(0.5, times=times)
    times[0] = 1.5
    assert scene.times[0] == 1.0


def test_outputs_that_were_not_asked_for_say_so() -> None:
    solution = solve(Scene(0.5, times=[1.0, 2.0], outputs="msd"))
    assert solution.msd.shape == (2,)
    assert list(solution.values) == ["msd"]
    with pytest.raises(AttributeError, match="'a2' was not asked for; this solution has msd"):
        _ = solution.a2
    with pytest.raises(AttributeError):
        _ = solution._nothing


def test_units() -> None:
    scene = Scene(0.5, number_density=0.04, diameter=2.0, times=[1.0])
    assert scene.mean_free_path == pytest.approx(1 / (2 * 2.0 * 0.04))
    assert np.array_equal(solve(scene).times, [1.0])


def test_averages_alone_load_no_scipy() -> None:
    code = (
        "import sys, kinetics as k; "
        "k.solve(k.Scene(0.5, times=[0.0, 1.0], outputs=('thermal_speed', 'a2', 'msd'))); "
        "k.solve_scaled(0.7).moment(3.0); k.ScalingSolution(0.7).vdf(1.0); "
        "print('scipy' in sys.modules)"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "False"


def test_public_names() -> None:
    for name in kinetics.__all__:
        assert getattr(kinetics, name).__doc__
    assert kinetics.__all__ == sorted(kinetics.__all__)
