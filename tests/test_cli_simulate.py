"""lorentz simulate: saved runs, media, starts."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import particles
from particles import (
    BoltzmannGrad,
    Ensemble,
    HardDisks,
    HardSpheres,
    Poisson,
    PoissonSpheres,
    simulate,
)


def test_the_file_holds_what_python_gives(lorentz: Any, tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    arguments = [
        "simulate", "-e", "0.6", "--box", "none", "--media", "3", "--tracers", "4",
        "--times", "1,9", "--initial", "monoenergetic", "--max-collisions", "7", "--seed", "5",
        "-o", str(path), "--observables", "positions, velocities",
    ]  # fmt: skip
    document = lorentz.json(*arguments)
    expected = simulate(
        HardDisks(0.04, box=None), 0.6, "monoenergetic", [1, 9], media=3, tracers=4,
        max_collisions=7, seed=5, observables=["positions", "velocities"],
    )  # fmt: skip
    found = Ensemble.load(path)
    np.testing.assert_array_equal(found.positions, expected.positions)
    np.testing.assert_array_equal(found.velocities, expected.velocities)
    assert document["kurtosis"]["value"] == expected.kurtosis.value.tolist()
    assert document["missing"] == expected.missing.tolist()
    assert "resume" in lorentz.refused(*arguments)
    before = path.read_bytes()
    assert "seed = 5, not 6" in lorentz.refused(*arguments, "--resume", "--seed", "6")
    assert path.read_bytes() == before
    table = lorentz(*arguments, "--resume")
    assert f"{expected.msd.value[1]:.6g}" in table
    path.write_text("x,y\n1,2\n")
    assert "is damaged, or not a saved simulation" in lorentz.refused(*arguments, "--resume")
    assert path.read_text() == "x,y\n1,2\n"


def test_tangential_restitution(lorentz: Any) -> None:
    arguments = ["--medium", "poisson", "--count", "200", "--media", "2", "--tracers", "3"]
    law = ["--tangential-restitution", "0.8"]
    document = lorentz.json("simulate", *arguments, *law, "--times", "1,9")
    expected = simulate(
        Poisson(0.04, 200), 0.7, times=[1, 9], media=2, tracers=3, tangential_restitution=0.8
    )
    assert document["tangential_restitution"] == 0.8
    assert document["msd"]["value"] == expected.msd.value.tolist()
    assert "tangential_restitution = 2.0" in lorentz.refused(
        "simulate", "--tangential-restitution", "2"
    )


def test_three_dimensions(lorentz: Any) -> None:
    arguments = ["--medium", "boltzmann-grad", "--media", "3", "--tracers", "4", "--times", "1,9"]
    document = lorentz.json("simulate", *arguments, "--dimension", "3")
    expected = simulate(BoltzmannGrad(0.04, dimension=3), 0.7, times=[1, 9], media=3, tracers=4)
    assert document["dimension"] == 3
    assert document["kurtosis"]["value"] == expected.kurtosis.value.tolist()
    assert "dimension = 4: must be 2 or 3" in lorentz.refused(
        "simulate", *arguments, "--dimension", "4"
    )
    message = (
        "dimension = 3: must be 2 unless the medium is boltzmann-grad, hard-spheres or poisson"
    )
    assert message in lorentz.refused("simulate", "--dimension", "3")
    assert message in lorentz.refused("simulate", "--dimension", "3", "--medium", "poisson")


def test_positions_are_read_from_a_file(lorentz: Any, tmp_path: Path) -> None:
    path = tmp_path / "disks.csv"
    path.write_text("x,y\n3,3\n1,8\n8,2\n")
    arguments = ["--positions", str(path), "--media", "2", "--times", "", "--max-collisions", "9"]
    document = lorentz.json("simulate", *arguments, "--box-side", "10")
    assert document["number_density"] == 0.03
    assert document["medium"] == "positions"
    assert document["statuses"]["collision_cap"] == 200
    assert "mean free path" in lorentz("simulate", *arguments, "--box-side", "10")
    assert "--box-side" in lorentz.refused("simulate", *arguments)
    assert "box_side = -1" in lorentz.refused("simulate", *arguments, "--box-side", "-1")
    assert "times = None" in lorentz.refused("simulate", "--times", "")
    assert "resume = True: needs output" in lorentz.refused("simulate", "--resume")


def test_what_is_too_large_gets_the_estimate(lorentz: Any) -> None:
    """Numbers that no machine has memory for."""
    for arguments in (
        ["simulate", "--count", "1000000000000"],
        ["simulate", "--media", "2000000000", "--observables", "speed_histogram,finals"],
        ["simulate", "--media", "2000000000", "--tracers", "1000000", "--observables", "finals"],
        ["report", "--count", "1000000000000"],
    ):
        assert " GB of memory, this machine has " in lorentz.refused(*arguments)


def test_too_little_memory_is_one_line(lorentz: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def run(*_: Any, **__: Any) -> None:
        raise MemoryError("Unable to allocate 834. GiB for an array")

    monkeypatch.setattr(particles, "simulate", run)
    assert lorentz.refused("simulate") == (
        "lorentz: not enough memory: Unable to allocate 834. GiB for an array\n"
    )


def test_a_binary_file_of_positions(lorentz: Any, tmp_path: Path) -> None:
    path = tmp_path / "disks.csv"
    path.write_bytes(bytes(range(256)))
    line = lorentz.refused("simulate", "--positions", str(path), "--box-side", "10")
    assert line == f"lorentz: {path}: must be a CSV file, text in UTF-8\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
@pytest.mark.parametrize("json", [[], ["--json"]])
def test_an_output_that_takes_nothing_is_one_line(json: list[str], tmp_path: Path) -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "kinetics.cli", "simulate", "--medium", "boltzmann-grad",
             "--media", "2", "--times", "1", *json],
            stdout=full, stderr=subprocess.PIPE, text=True, cwd=tmp_path,
        )  # fmt: skip
    assert (done.returncode, done.stderr) == (2, "lorentz: No space left on device\n")


def test_warnings_are_one_line_and_numpys_are_not_shown(tmp_path: Path) -> None:
    code = """
import sys, warnings
import numpy as np
import particles
from kinetics import cli

def simulate(*_, **__):
    np.float64(1e300) * np.float64(1e300)
    warnings.warn("mind the\\nstep")
    raise ValueError("the end")

particles.simulate = simulate
sys.exit(cli.main())
"""
    command = [sys.executable, "-c", code, "simulate"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.stderr == "lorentz: warning: mind the step\nlorentz: the end\n"
    assert done.returncode == 2


def test_media_of_spheres(lorentz: Any) -> None:
    arguments = ["-e", "0.7", "--media", "2", "--tracers", "3", "--times", "1,9", "--count", "100"]
    for name, options, medium in (
        ("hard-spheres", [], HardSpheres(0.04, count=100)),
        ("hard-spheres", ["--dimension", "3"], HardSpheres(0.04, count=100)),
        ("poisson-spheres", [], PoissonSpheres(0.04, count=100)),
        ("poisson-spheres", ["--box", "none"], PoissonSpheres(0.04, count=None)),
    ):
        document = lorentz.json("simulate", *arguments, "--medium", name, *options)
        expected = simulate(medium, 0.7, times=[1, 9], media=2, tracers=3)
        assert document["medium"] == name
        assert document["dimension"] == 3
        assert document["msd"]["value"] == expected.msd.value.tolist()
    for name in ("hard-spheres", "poisson-spheres"):
        assert "dimension = 2: must be 3 unless the medium is boltzmann-grad" in lorentz.refused(
            "simulate", "--medium", name, "--dimension", "2"
        )
    assert "box = 'none': hard-spheres need a periodic box" in lorentz.refused(
        "simulate", "--medium", "hard-spheres", "--box", "none"
    )


def test_a_field(lorentz: Any) -> None:
    arguments = (
        "--medium", "boltzmann-grad", "-e", "0.6", "--number-density", "0.5", "--initial", "rest",
        "--field", "1.5", "--depth", "2", "--times", "0,1,40", "--media", "4", "--tracers", "50",
    )  # fmt: skip
    printed = lorentz.json("simulate", *arguments)
    medium = BoltzmannGrad(0.5)
    run = simulate(medium, 0.6, "rest", [0.0, 1.0, 40.0], media=4, tracers=50, field=1.5, depth=2.0)
    assert printed["field"] == 1.5
    assert printed["initial"] == "rest"
    names = (
        "drift",
        "drift_of_moving",
        "trapped_fraction",
        "velocity_tensor",
        "mean_displacement",
        "dispersion_parallel",
        "passed",
    )
    for name in (*names, "mean_passage_time"):
        estimate = getattr(run, name)
        assert np.array_equal(printed[name]["value"], estimate.value)
        assert np.array_equal(printed[name]["error"], estimate.error)
    out = lorentz("simulate", *arguments)
    assert "<v_x> [U]" in out
    assert "passed 2 d" in out
    first = run.mean_passage_time
    assert f"mean time of the first passage: {first.value:.6g} +- {first.error:.2g} d/U" in out
    spheres = "--medium", "hard-spheres", "--number-density", "0.04", "--field", "1"
    assert "field = 1.0: is not there for HardSpheres" in lorentz.refused(
        "simulate", "-e", "0.5", *spheres
    )
    assert "initial = 'rest': needs a field" in lorentz.refused(
        "simulate", "-e", "0.5", "--initial", "rest"
    )
