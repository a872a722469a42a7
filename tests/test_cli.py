"""The command `lorentz`: what it prints and writes, what it refuses and how, and what it loads."""

import csv
import json
import math
import os
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import click
import numpy as np
import pandas
import pytest
import xarray

import particles
from kinetics import (
    Beam,
    Monoenergetic,
    Scene,
    SpeedTable,
    Viscoelastic,
    cli,
    load,
    solve,
    solve_field,
    solve_scaled,
    solve_steady,
)
from kinetics.crosscheck.words import number
from particles import BoltzmannGrad, Ensemble, HardDisks, Poisson, PoissonSpheres, simulate

SOLVE = ("solve", "--times", "1:1e4:3")
TINY = ("simulate", "--scatterers", "dilute", "--media", "2", "--tracers", "3")
TINY += ("--times", "1,9")

BAD_INPUT = [
    # arguments; what the line must name: the argument, the value
    ("report -e 1.5", "restitution 1.5"),
    ("report -e 0.5 -e 0.5", "restitutions 0.5"),
    ("report --field -e 1", "restitutions 1"),
    ("report --field --media 9", "media --system field"),
    ("nonsense", "nonsense"),
    ("sovle", "did you mean solve"),
    ("solve --times -1,1", "times -1"),
    ("solve --times 1,two", "times two"),
    ("solve --times 1,2" + "x" * 5000, "times 1,2x"),
    ("solve --initial a.csv", "initial a.csv"),
    ("solve --initial rest", "initial rest"),
    ("solve --speed 2", "speed gaussian"),
    ("solve -o a.xlsx", ".csv .nc .h5"),
    ("solve --scaled -e 1", "restitution 1"),
    ("solve --scaled --times 1,2", "times --scaled"),
    ("solve --field-steady --scaled", "field_steady"),
    ("solve --field-steady --field-units 0,1,1", "field_units"),
    ("solve --steady", "bath_speed 0"),
    ("solve --heating 1 --outputs kurtosis", "outputs kurtosis"),
    ("solve -e 0.5 --viscoelastic 0.4", "restitution --viscoelastic"),
    ("simulate --times 3,2", "times"),
    ("simulate --resume -o a.h5md", "resume"),
    ("simulate --scatterers hard-spheres --dimension 2", "dimension 2"),
    ("simulate --count 1000000000000", "memory"),
    ("simulate --mass-ratio 2 --times 1", "mass_ratio HardDisks"),
    ("simulate --part 3", "part 3 K/N"),
    ("merge -o a.h5", "HDF5"),
    ("explore -o no/such/a.html", "no/such"),
    ("derive --only nonsense", "nonsense"),
    ("derive --list --only B15", "only list"),
    ("bench --case nonsense", "nonsense"),
    ("stress --group nonsense", "groups nonsense"),
]


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(("arguments", "named"), BAD_INPUT, ids=lambda v: v[:60])
def test_bad_input_gets_one_line_that_names_it(lorentz: Any, arguments: str, named: str) -> None:
    line = lorentz.refused(*arguments.split()).replace("-", "_")
    assert all(name.replace("-", "_") in line for name in named.split()), line
    assert os.listdir() == []


@pytest.mark.parametrize("arguments", [SOLVE, ("simulate",), ("derive", "--only", "ad8")])
def test_an_output_is_refused_before_any_work(lorentz: Any, arguments: tuple[str, ...]) -> None:
    option = "--latex" if arguments[0] == "derive" else "-o"
    name = "a.h5" if arguments[0] == "simulate" else "a.csv"
    assert "mkdir -p no/such" in lorentz.refused(*arguments, option, f"no/such/{name}")
    Path("file").write_text("mine")
    for command in ("report", "bench", "stress"):
        lorentz.refused(command, "-o", "file")
    lorentz.refused(*arguments, option, f"file/{name}")
    assert {name: Path(name).read_text() for name in os.listdir()} == {"file": "mine"}


def test_help_loads_nothing_heavy() -> None:
    code = (
        "import sys\n"
        "from kinetics import cli\n"
        "for name in cli.COMMANDS:\n"
        "    assert cli.main([name, '--help']) == 0, name\n"
        "for arguments in ['--help'], ['--version'], []:\n"
        "    assert cli.main(arguments) == 0, arguments\n"
        "print(*sorted({m.split('.')[0] for m in sys.modules}), file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    loaded = set(done.stderr.split())
    assert done.returncode == 0, done.stderr
    heavy = "numpy scipy numba sympy mpmath matplotlib jinja2 rich h5py pandas xarray pyarrow"
    assert "click" in loaded
    assert not set(heavy.split()) & loaded
    assert all(f"\n  {name} " in done.stdout for name in cli.COMMANDS)


def test_a_shell_completes_commands_and_options() -> None:
    def complete(words: str, position: int) -> list[str]:
        asked = {"COMP_WORDS": words, "COMP_CWORD": str(position)}
        done = subprocess.run(
            [sys.executable, "-c", "import sys; from kinetics.cli import main; sys.exit(main())"],
            env=os.environ | asked | {"_LORENTZ_COMPLETE": "bash_complete"},
            capture_output=True, text=True, check=True,
        )  # fmt: skip
        return [line.partition(",")[2] for line in done.stdout.splitlines()]

    assert complete("lorentz s", 1) == ["solve", "simulate", "stress"]
    assert complete("lorentz solve --rest", 2) == ["--restitution"]


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_every_option_has_help_which_ends_with_an_example_of_known_ones(
    lorentz: Any, name: str
) -> None:
    command = cli.cli.get_command(click.Context(cli.cli), name)
    assert command is not None
    assert command.help
    assert command.get_short_help_str()
    # what an argument is, the command's own text says: click has no help for arguments
    assert all(p.help for p in command.params if isinstance(p, click.Option))
    _, example = lorentz(name, "--help").split("Example:\n")
    assert example.count("\n") == 1
    first, told, *arguments = shlex.split(example)
    assert (first, told) == ("lorentz", name)
    assert command.make_context(name, arguments).params


OVER_TIME = ("thermal_speed", "a2", "msd")
DRIVES = {"bath_speed": 0.5, "heating": 0.1, "drag": 0.2, "capture_speed": 0.1}
DRIVEN = "thermal_speed"
IN_FIELD = ("mean_velocity", "displacement_tensor", "collisions")
SPHERES = {"dimension": 3, "mass_ratio": 0.5}
# a question to the command, the same to Python, the keys that must be equal, and words in the text
ASKED: list[tuple[str, Any, tuple[str, ...], str]] = [
    ("solve -e 0.5 --times 0,1:100:3",
     lambda: solve(Scene(0.5, times=[0, 1, 10, 100], outputs=OVER_TIME)),
     ("times", *OVER_TIME), "t [d/U]  v0 [U]  a2  <r^2> [d^2]  status: "),
    ("solve --initial rest --field 0.08 --times 1,100 --rtol 1e-4 --outputs " + ",".join(IN_FIELD),
     lambda: solve(Scene(0.7, initial="rest", field=0.08, times=[1, 100], outputs=IN_FIELD), 1e-4),
     IN_FIELD, "<v_x> [U]  var(x) [d^2]  collisions"),
    ("solve --viscoelastic 0.4 --times 1,9 --rtol 1e-4 --outputs thermal_speed --bath-speed 0.5 "
     "--heating 0.1 --drag 0.2 --capture-speed 0.1",
     lambda: solve(Scene(Viscoelastic(0.4), times=[1, 9], outputs=DRIVEN, **DRIVES), 1e-4),
     ("thermal_speed", "captured"), "captured"),
    ("solve --scaled -e 1 --mass-ratio 0.5 --dimension 3",
     lambda: solve_scaled(1.0, **SPHERES), ("cooling_rate", "a2"), "cooling_rate"),
    ("solve --field-steady -e 0.5 --dimension 3 --rtol 1e-4",
     lambda: solve_field(0.5, 3, rtol=1e-4), ("drift", "diffusion_parallel"), "drift"),
    ("solve --steady --bath-speed 2 -e 0.5 --rtol 1e-6",
     lambda: solve_steady(0.5, bath_speed=2.0, rtol=1e-6),
     ("mean_square_along", "mobility", "diffusion_coefficient"), "drift  mobility"),
    ("solve --steady --bath-speed 2 -e 0.5 --capture-speed 1 --rtol 1e-4",
     lambda: solve_steady(0.5, bath_speed=2.0, capture_speed=1.0, rtol=1e-4),
     ("capture_time",), "capture_time"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("arguments", "python", "keys", "text"), ASKED, ids=[x[0][:40] for x in ASKED]
)
def test_what_is_solved_is_what_python_gives(
    lorentz: Any, arguments: str, python: Any, keys: tuple[str, ...], text: str
) -> None:
    found, expected = lorentz.json(*arguments.split()), python()
    assert found["status"] == expected.status.name.lower()
    for name in keys:
        np.testing.assert_allclose(found[name], getattr(expected, name), rtol=1e-12)
    printed = " ".join(lorentz(*arguments.split()).split())
    assert all(" ".join(part.split()) in printed for part in text.split("  "))


def test_solve_prints_what_is_asked_for(lorentz: Any) -> None:
    more = ["--outputs", "kurtosis", "--radii", "0,1", "--wave-numbers", "0.0,0.1"]
    arguments = ["solve", "-e", "0.5", "--times", "0,100", "--rtol", "1e-3", *more]
    found = lorentz.json(*arguments, "--collision-numbers", "1,5")
    assert "msd" not in found
    assert found["kurtosis"][1] > 2.0
    assert found["scaled_position_density"][1][0] == 0.0
    assert 0.5 < found["scaled_position_density"][1][1] < 0.7
    assert found["intermediate_scattering"][0] == [1.0, 1.0]
    assert found["by_collision"]["collision_numbers"] == [1, 5]
    text = lorentz(*arguments)
    assert all(head in text for head in ("<r^4>", "G(1)", "F(0.1/d)", "status: "))
    found = lorentz.json("solve", "--times", "1", "--viscoelastic", "0.4", "--outputs", "a2")
    assert (found["restitution"], found["viscoelastic"]) == (None, 0.4)


def test_the_steady_state_in_units_and_as_tables(lorentz: Any) -> None:
    arguments = ("solve", "--field-steady", "-e", "0.5", "--dimension", "3", "--rtol", "1e-4")
    found = lorentz.json(*arguments, "--field-units", "9.81,0.001,1e8", "-o", "a.csv")
    assert found["plan"][0]["part"] == "angular harmonics"
    path = 1.0 / (math.pi * 1e-6 * 1e8)
    assert found["in_units"]["drift"] == pytest.approx(found["drift"] * math.sqrt(9.81 * path))
    assert rows_of("a.csv")[0]["drift [sqrt(g l)]"] == pytest.approx(found["drift"])
    lorentz("solve", "--steady", "--bath-speed", "2", "--rtol", "1e-3", "-o", "b.csv")
    assert lorentz.json("solve", "--scaled", "-o", "c.csv")["moments"]["2"] == pytest.approx(1)
    assert list(rows_of("c.csv")[0]) == ["c", "vdf"]
    assert sorted(os.listdir()) == ["a.csv", "b.csv", "c.csv"]


def test_starts_from_the_command_line(lorentz: Any) -> None:
    Path("start.csv").write_text("speed,density\n0,0\n1,1\n2,0\n")
    for options, initial in (
        (["--initial", "beam", "--speed", "2", "--direction", "1"], Beam(1.0, Monoenergetic(2.0))),
        (["--initial", "monoenergetic", "--speed", "0.5"], Monoenergetic(0.5)),
        (["--initial", "start.csv"], SpeedTable([0, 1, 2], [0, 1, 0])),
    ):
        expected = solve(Scene(0.7, initial=initial, times=[10.0], outputs="msd")).msd
        found = lorentz.json("solve", *options, "--times", "10", "--outputs", "msd")
        assert found["msd"] == expected.tolist()
    for text in ("0,0\n1,one\n", "0,0\n", "\x00", "0;0\n1;1\n"):
        Path("start.csv").write_text(text)
        assert "start.csv" in lorentz.refused("solve", "--initial", "start.csv")


def rows_of(path: str) -> list[dict[str, float]]:
    with open(path, encoding="utf-8", newline="") as file:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]


def test_a_table_in_a_file_has_heads_with_units_and_a_column_for_each_point(lorentz: Any) -> None:
    asked = ("solve", "--outputs", "thermal_speed", "--rtol", "1e-4", "--times", "300")
    points = ("--speeds", "0.1,0.2", "--radii", "1,2")
    lorentz(*asked, *points, "-o", "a.csv")
    lorentz(*asked, *points, "-o", "a.parquet")
    outputs = ("thermal_speed", "speed_density", "position_density")
    expected = solve(Scene(0.7, times=[300.0], outputs=outputs), 1e-4)
    (row,) = rows_of("a.csv")
    assert row["time [d/U]"] == 300.0
    assert row["thermal_speed [U]"] == expected.thermal_speed[0]
    f, g = expected.speed_density([0.1, 0.2])[0], expected.scaled_position_density([1, 2])[0]
    assert [row["speed_density(v=0.1) [1/U]"], row["speed_density(v=0.2) [1/U]"]] == f.tolist()
    assert [row[f"scaled_position_density(R={k})"] for k in (1, 2)] == g.tolist()
    assert pandas.read_parquet("a.parquet").iloc[0].to_dict() == row


def test_files_that_hold_the_whole_result(lorentz: Any) -> None:
    msd = lorentz.json(*SOLVE, "-o", "A.H5")["msd"]
    assert load("A.H5").msd.tolist() == msd
    lorentz(*SOLVE, "-o", "a.nc")
    with xarray.open_dataset("a.nc") as dataset:
        assert dataset.msd.values.tolist() == msd
        assert dataset.msd.attrs["units"] == "d^2"


def test_a_picture_of_a_solution(lorentz: Any) -> None:
    for arguments, name in (
        ((*SOLVE, "--speeds", "0.1,1"), "a.png"),
        (("solve", "--scaled"), "a.svg"),
    ):
        assert lorentz(*arguments, "-o", name) == lorentz(*arguments)
        assert Path(name).stat().st_size > 5_000


def test_the_file_of_a_run_holds_what_python_gives(lorentz: Any) -> None:
    arguments = [
        "simulate", "-e", "0.6", "--media", "3", "--tracers", "4", "--count", "400", "--times",
        "1,9", "--initial", "monoenergetic", "--max-collisions", "7", "--seed", "5", "-o", "run.h5",
        "--observables", "positions, velocities", "--tangential-restitution", "0.8",
    ]  # fmt: skip
    document = lorentz.json(*arguments)
    expected = simulate(
        HardDisks(0.04, 400), 0.6, "monoenergetic", [1, 9], media=3, tracers=4, max_collisions=7,
        seed=5, observables=["positions", "velocities"], tangential_restitution=0.8,
    )  # fmt: skip
    np.testing.assert_array_equal(Ensemble.load("run.h5").positions, expected.positions)
    assert document["kurtosis"]["value"] == expected.kurtosis.value.tolist()
    assert document["missing"] == expected.missing.tolist()
    assert document["tangential_restitution"] == 0.8
    before = Path("run.h5").read_bytes()
    lorentz.refused(*arguments)  # it exists
    lorentz.refused(*arguments, "--resume", "--seed", "6")
    assert Path("run.h5").read_bytes() == before
    shown = number(expected.msd.value[1], expected.msd.error[1])
    assert shown in lorentz(*arguments, "--resume")


def test_parts_of_a_run_are_merged_to_the_same_file(lorentz: Any) -> None:
    whole = lorentz.json(*TINY, "-o", "whole.h5")
    for k in "12":
        found = lorentz.json(*TINY, "--part", f"{k}/2", "-o", f"{k}.h5")
        assert (found["part"], found["samples"]) == ([int(k), 2], [3, 3])
    assert "configuration 1 of 0 to 1 is missing" in lorentz.refused("merge", "1.h5", "-o", "a.h5")
    assert lorentz.json("merge", "[12].h5", "-o", "a.h5") == whole
    assert Path("a.h5").read_bytes() == Path("whole.h5").read_bytes()
    assert "exists" in lorentz.refused("merge", "1.h5", "2.h5", "-o", "a.h5")
    assert "a.csv" in lorentz.refused(*TINY, "-o", "a.csv")  # it would not be a table
    given = simulate(BoltzmannGrad(0.04), lambda v: 0.5 + 0 * v, [[1.0, 0.0]], [1.0], 2, 1)
    given.save("b.h5")
    document = lorentz.json("merge", "b.h5", "-o", "c.h5")
    assert (document["initial"], document["restitution"], document["viscoelastic"]) == (None,) * 3


RUNS: list[tuple[str, Any, dict[str, Any]]] = [
    ("--scatterers dilute --dimension 3", BoltzmannGrad(0.04, dimension=3), {}),
    ("--scatterers overlapping-spheres --count 100", PoissonSpheres(0.04, count=100), {}),
    ("--scatterers overlapping --count 100", Poisson(0.04, 100), {}),
    ("--initial rest --field 1.5 --depth 2", BoltzmannGrad(0.04),
     {"initial": "rest", "field": 1.5, "depth": 2.0}),
    ("-e 1 --mass-ratio 0.5", BoltzmannGrad(0.04), {"restitution": 1.0, "mass_ratio": 0.5}),
]  # fmt: skip


@pytest.mark.parametrize(("options", "medium", "told"), RUNS, ids=[x[0] for x in RUNS])
def test_runs(lorentz: Any, options: str, medium: Any, told: dict[str, Any]) -> None:
    found = lorentz.json(*TINY, *options.split())
    expected = simulate(medium, times=[1, 9], media=2, tracers=3, **{"restitution": 0.7} | told)
    names = ["msd"]
    if "field" in told:
        names = ["drift", "drift_of_moving", "trapped_fraction", "velocity_tensor", "passed",
                 "mean_displacement", "dispersion_parallel", "mean_passage_time"]  # fmt: skip
        text = lorentz(*TINY, *options.split())
        assert all(word in text for word in ("<v_x> [U]", "passed 2 d", "first passage"))
    for name in names:
        np.testing.assert_array_equal(found[name]["value"], getattr(expected, name).value)
        np.testing.assert_array_equal(found[name]["error"], getattr(expected, name).error)
    assert found["medium"] == found["scatterers"] == medium.scatterers
    assert (found["dimension"], found["statuses"]["finished"]) == (medium.dimension, 6)
    # strict JSON has no infinity, which is the default
    assert found.get("mass_ratio") == told.get("mass_ratio")


def test_a_space_in_a_word_may_be_a_hyphen(lorentz: Any) -> None:
    for word in ("hard-disks", "hard disks"):
        found = lorentz.json("solve", "--times", "1", "--scatterers", word, "--mass-ratio", "inf")
        assert (found["scatterers"], "mass_ratio" in found) == ("hard disks", False)


def test_solve_says_by_how_much_the_equation_itself_is_off(lorentz: Any) -> None:
    options = ("solve", "--times", "10,100", "-e", "0.5", "--scatterers", "hard-disks")
    found = lorentz.json(*options, "--number-density", "0.1", "--outputs", "thermal_speed,msd")
    scene = Scene(
        0.5, 0.1, times=[10.0, 100.0], scatterers="hard disks", outputs=("thermal_speed", "msd")
    )
    expected = solve(scene).model_error
    for name in ("thermal_speed", "msd"):
        np.testing.assert_allclose(found["model_error"][name], expected[name])
    assert "error of the equation itself" in lorentz(*options)
    assert "model_error" not in lorentz.json(*SOLVE)
    dense = lorentz.json(*options, "--number-density", "0.2")  # prints no warning
    assert dense["model_error"]["msd"][0] > 0.01


def test_derive_finds_equations_by_number_and_word(lorentz: Any) -> None:
    by_label = lorentz("derive", "--only", "sonine9")
    for name in ("B15", "b15", "eq. B15"):
        assert lorentz("derive", "--only", name) == by_label
    listed = lorentz("derive", "--list").splitlines()
    assert next(line.split()[:2] for line in listed if "sonine9" in line) == ["B15", "sonine9"]
    found = lorentz.json("derive", "--search", "Mean Square")["equations"]
    assert {"number": "22", "label": "msd"}.items() <= found[0].items()
    assert len(listed) > 150 > len(found)
    numbers = [row["number"] for row in lorentz.json("derive", "--list")["equations"]]
    numbers = [number for number in numbers if number]
    assert len(set(numbers)) == len(numbers) == 124


def run(*arguments: str, **keywords: Any) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "kinetics.cli", *arguments]
    pipes = {name: keywords.pop(name, subprocess.PIPE) for name in ("stdout", "stderr")}
    return subprocess.run(command, text=True, **pipes, **keywords)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminal")
def test_progress_and_colour_are_shown_on_a_terminal_only() -> None:
    import fcntl
    import pty
    import struct
    import termios

    def shown(stream: str, *arguments: str) -> tuple[str, Any]:
        master, terminal = pty.openpty()
        fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 100, 0, 0))
        done = run(*arguments, **{stream: terminal}, env=os.environ | {"TERM": "xterm-256color"})
        os.close(terminal)
        text = os.read(master, 100_000).decode()
        os.close(master)
        return text, done

    text, done = shown("stderr", *TINY, "--json")
    assert "/2" in text
    assert json.loads(done.stdout)["tracers"] == 3
    assert run(*TINY, "--json").stderr == ""
    text, _ = shown("stdout", *TINY)
    assert "\x1b[1m" in text


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
@pytest.mark.parametrize(("redirect", "status", "lines"), [
    (">/dev/full", 2, 1), (">&- 2>&-", 2, 0), ("-e 7 2>/dev/full", 2, 0),
    ("--json | head -c 1", 0, 0),
])  # fmt: skip
def test_a_stream_that_takes_nothing_makes_no_traceback(
    redirect: str, status: int, lines: int
) -> None:
    command = f"set -o pipefail; {sys.executable} -m kinetics.cli {' '.join(TINY)} {redirect}"
    buffered = {**os.environ, "PYTHONUNBUFFERED": ""}  # or what is left is written at once
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, env=buffered)
    assert done.returncode == status, done.stderr
    assert done.stderr.count("\n") == lines
    assert done.stderr.startswith("lorentz: " * lines)


def test_what_stops_a_command_is_one_line(lorentz: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: Any, **__: Any) -> None:
        raise MemoryError("834 GiB")

    monkeypatch.setattr(particles, "simulate", fail)
    assert "834 GiB" in lorentz.refused("simulate")


def test_warnings_are_one_line_and_numpys_are_not_shown() -> None:
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
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.stderr == "lorentz: warning: mind the step\nlorentz: the end\n"
    assert done.returncode == 2


ESCAPE = "\x1b[31mred"


@pytest.mark.parametrize("arguments", [
    ("compare", f"{ESCAPE}.csv"), ("compare", f"{ESCAPE}.h5"), ("fit", f"{ESCAPE}.xlsx"),
    ("merge", f"{ESCAPE}.h5", "-o", "all.h5"), ("solve", "--initial", f"{ESCAPE}.csv"),
    ("solve", "-o", f"{ESCAPE}/a.csv"), ("simulate", "-o", f"{ESCAPE}/a.h5"), (ESCAPE,),
])  # fmt: skip
@pytest.mark.parametrize("is_there", [False, True])
def test_names_of_files_do_not_command_the_terminal(
    lorentz: Any, arguments: tuple[str, ...], is_there: bool, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    if is_there:
        for ending in ("csv", "h5", "xlsx"):
            Path(f"{ESCAPE}.{ending}").write_text("no such format")
    assert lorentz.refused(*arguments).strip().isprintable()


def test_names_of_files_of_runs_are_printable_in_errors(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no such file") as refused:
        Ensemble.load(tmp_path / ESCAPE)
    assert str(refused.value).isprintable()
