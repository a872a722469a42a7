"""What the commands write, the numbers they take, and how they print them."""

import csv
import io
import math
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinetics import Beam, Monoenergetic, Scene, SpeedTable, load, solve

SOLVE = ("solve", "--times", "1:1e4:3")


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def rows_of(path: str) -> list[dict[str, float]]:
    text = Path(path).read_text(encoding="utf-8")
    return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(io.StringIO(text))]


def test_a_csv_file_has_a_row_for_each_time_and_heads_with_units(
    lorentz: Any,
) -> None:
    lorentz(*SOLVE, "-o", "a.csv")
    expected = solve(Scene(0.7, times=[1.0, 100.0, 1e4], outputs=("thermal_speed", "a2", "msd")))
    rows = rows_of("a.csv")
    assert [row["time [d/U]"] for row in rows] == [1.0, 100.0, 1e4]
    assert [row["msd [d^2]"] for row in rows] == expected.msd.tolist()
    assert [row["a2"] for row in rows] == expected.a2.tolist()


def test_a_csv_file_has_a_column_for_each_point_of_a_density(
    lorentz: Any,
) -> None:
    asked = ("--outputs", "thermal_speed", "--rtol", "1e-4", "--times", "300")
    lorentz("solve", *asked, "--speeds", "0.1,0.2", "--radii", "1,2", "-o", "a.csv")
    outputs = ("thermal_speed", "speed_density", "position_density")
    expected = solve(Scene(0.7, times=[300.0], outputs=outputs), 1e-4)
    (row,) = rows_of("a.csv")
    f, g = expected.speed_density([0.1, 0.2])[0], expected.scaled_position_density([1, 2])[0]
    assert [row["speed_density(v=0.1) [1/U]"], row["speed_density(v=0.2) [1/U]"]] == f.tolist()
    names = ["scaled_position_density(R=1)", "scaled_position_density(R=2)"]
    assert [row[name] for name in names] == g.tolist()
    assert len(row) == 7


def test_other_kinds_of_files(lorentz: Any) -> None:
    xarray = pytest.importorskip("xarray")
    lorentz(*SOLVE, "-o", "a.h5")
    lorentz(*SOLVE, "-o", "a.nc")
    solution = load("a.h5")
    with xarray.open_dataset("a.nc", engine="scipy") as dataset:
        assert dataset.msd.values.tolist() == solution.msd.tolist()
        assert dataset.msd.attrs["units"] == "d^2"
    lorentz("solve", "--field-steady", "-o", "b.csv")
    assert rows_of("b.csv")[0]["drift [sqrt(g l)]"] == pytest.approx(0.50192612)
    lorentz("solve", "--scaled", "-o", "c.csv")
    assert list(rows_of("c.csv")[0]) == ["c", "vdf"]


@pytest.mark.parametrize("arguments", [SOLVE, ("simulate",), ("derive", "--only", "ad8")])
def test_a_folder_that_is_not_there_is_not_made(lorentz: Any, arguments: tuple[str, ...]) -> None:
    option = "--latex" if arguments[0] == "derive" else "-o"
    line = lorentz.refused(*arguments, option, os.path.join("no", "such", "a.csv"))
    assert "mkdir -p no/such" in line
    for command in ("report", "bench", "stress"):
        assert "mkdir -p no/such" in lorentz.refused(command, "-o", "no/such/folder")
    assert os.listdir() == []


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["-o", "a.xlsx"], [".csv", ".nc", ".h5"]),
        (["--initial", "a.csv"], ["initial", "a.csv"]),
        (["--speed", "2"], ["speed", "beam"]),
        (["--direction", "2"], ["direction", "beam"]),
        (["--until", "-1"], ["until", "-1"]),
        (["--until", "inf"], ["until", "inf"]),
        (["--times", "1:10"], ["times", "1:1e6:50"]),
        (["--times", "0:10:5"], ["times"]),
        (["--times", "1:10:1e9"], ["times"]),
        (["--speeds", "-1"], ["speeds", "-1"]),
    ],
)
def test_what_cannot_be_done_is_said_in_a_line(
    lorentz: Any, options: list[str], named: list[str]
) -> None:
    line = lorentz.refused("solve", *options)
    assert all(name in line for name in named), line


def test_ranges_are_logarithmic_and_may_stand_among_numbers(
    lorentz: Any,
) -> None:
    assert lorentz.json("solve", "--times", "0,1:1000:4")["times"] == [0, 1, 10, 100, 1000]
    ran = lorentz.json("simulate", "--media", "2", "--medium", "boltzmann-grad", "--until", "100")
    asked = lorentz.json("solve", "--until", "100")
    assert ran["times"] == asked["times"]
    assert (len(asked["times"]), asked["times"][0], asked["times"][-1]) == (31, 0.1, 100)


def test_starts_from_the_command_line(lorentz: Any) -> None:
    Path("start.csv").write_text("speed,density\n0,0\n1,1\n2,0\n")
    for options, initial in (
        (["--initial", "beam", "--speed", "2", "--direction", "1"], Beam(1.0, Monoenergetic(2.0))),
        (["--initial", "monoenergetic", "--speed", "0.5"], Monoenergetic(0.5)),
        (["--initial", "start.csv"], SpeedTable([0, 1, 2], [0, 1, 0])),
    ):
        expected = solve(Scene(0.7, initial=initial, times=[10.0], outputs="msd")).msd
        assert lorentz.json("solve", *options, "--times", "10", "--outputs", "msd")["msd"] == (
            expected.tolist()
        )
    Path("start.csv").write_text("0,0\n1,one\n")
    assert "row 2" in lorentz.refused("solve", "--initial", "start.csv")


def test_what_is_printed_fits_100_columns_and_is_in_no_notation_of_python(
    lorentz: Any,
) -> None:
    outputs = "thermal_speed,temperature,a2,collisions,msd,kurtosis,diffusion_coefficient"
    for arguments in (
        (*SOLVE, "--outputs", outputs, "--radii", "1:8:12", "--rtol", "1e-5"),
        ("solve", "--scaled"),
        ("solve", "--field-steady", "--field-units", "9.81,0.001,1e8"),
        ("simulate", "--media", "2", "--medium", "boltzmann-grad", "--times", "1,1e7"),
    ):
        text = lorentz(*arguments)
        assert max(map(len, text.splitlines())) <= 100
        assert "e+" not in text
        assert "e-0" not in text
        assert "np." not in text


def test_no_colour_where_there_is_no_terminal(lorentz: Any) -> None:
    assert "\x1b" not in lorentz(*SOLVE)


@pytest.mark.parametrize("name", ["a.png", "a.svg"])
def test_a_picture_of_a_run(lorentz: Any, name: str) -> None:
    arguments = ("simulate", "--media", "2", "--count", "400", "--tracers", "3", "--until", "50")
    plain = lorentz(*arguments)
    assert lorentz(*arguments, "--picture", name) == plain
    assert Path(name).stat().st_size > 10_000
    assert ".png" in lorentz.refused(*arguments, "--picture", "a.gif")


def test_the_last_digits_of_a_range_are_no_rounding(lorentz: Any) -> None:
    times = lorentz.json("solve", "--times", "1:1e6:13")["times"]
    np.testing.assert_allclose(times, np.geomspace(1, 1e6, 13), rtol=1e-13)
    assert all(math.log10(t) == round(math.log10(t)) for t in times[::2])
