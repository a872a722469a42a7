"""Averages at other times of a scene that has been solved: the same numbers, without solving."""

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinetics import Beam, Scene, load, solve
from kinetics.outputs import OUTPUTS

AVERAGES = tuple(row.name for row in OUTPUTS.values() if row.values is not None)
OTHERS = [0.0, 0.3, 17.0, 17.0, 4e3, 1e5]
SCENES: dict[str, dict[str, Any]] = {
    "disks": {"restitution": 0.6},
    "a beam": {"restitution": 0.6, "initial": Beam(direction=0.7)},
    "spheres": {"restitution": 0.7, "dimension": 3},
    "elastic": {"restitution": 1.0},
    "hard disks": {"restitution": 0.7, "scatterers": "hard disks"},
}


@pytest.mark.parametrize("name", SCENES)
def test_other_times_are_what_a_scene_with_them_gives(name: str) -> None:
    system = {"outputs": AVERAGES, **SCENES[name]}
    solution = solve(Scene(**system, times=np.geomspace(10.0, 1e5, 7)))
    found = solution.at(OTHERS)
    again = solve(Scene(**system, times=OTHERS))
    assert found.scene == again.scene
    assert found.status == again.status
    assert found.error_estimate == again.error_estimate
    for output, values in again.values.items():
        np.testing.assert_allclose(found.values[output], values, rtol=1e-13, atol=1e-14)


def test_after_pickling_and_from_a_file(tmp_path: Path) -> None:
    solution = solve(Scene(0.6, times=[1e4], outputs=("msd", "speed_density")))
    expected = solution.at([100.0])
    assert pickle.loads(pickle.dumps(solution)).at([100.0]) == expected
    solution.save(tmp_path / "a.h5")
    assert load(tmp_path / "a.h5").at([100.0]) == expected
