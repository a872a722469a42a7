"""Tables of averages are told from tracks by the names of their columns."""

from pathlib import Path

import numpy as np
import pytest

from kinetics.crosscheck.data.averages import AveragesTable
from kinetics.crosscheck.data.reading import read_data, read_sample
from kinetics.errors import InputError


def table_of(tmp_path: Path, text: str, **arguments: float) -> AveragesTable:
    path = tmp_path / "averages.csv"
    path.write_text(text)
    table = read_data([path], **arguments)
    assert isinstance(table, AveragesTable)
    return table


def test_averages_with_errors(tmp_path: Path) -> None:
    text = "# a paper\nt, v0, v0_error, msd, msd_error\n2,1.3,.02,7.5,.3\n1,1.4,.01,2,.1\n"
    table = table_of(tmp_path, text)
    assert table.names == ("thermal_speed", "msd")
    np.testing.assert_array_equal(table.times, [1.0, 2.0])
    np.testing.assert_array_equal(table.values, [[1.4, 1.3], [2.0, 7.5]])
    np.testing.assert_array_equal(table.errors, [[0.01, 0.02], [0.1, 0.3]])


def test_the_table_of_the_explorer(tmp_path: Path) -> None:
    text = "time [d/U],thermal_speed [U],msd [d^2]\n1,1.4,2\n2,1.3,7.5\n4,1.1,22\n"
    table = table_of(tmp_path, text)
    assert table.names == ("thermal_speed", "msd")
    assert not table.has_errors
    assert "No standard errors" in table.remarks[0]


@pytest.mark.parametrize("text", ["t;msd\n1;2\n3;7\n", "t msd\n1 2\n3 7\n", "t\tr2\n1\t2\n3\t7\n"])
def test_two_columns_are_enough(tmp_path: Path, text: str) -> None:
    np.testing.assert_array_equal(table_of(tmp_path, text).values, [[2.0, 7.0]])


def test_mean_square_speeds_become_thermal_speeds(tmp_path: Path) -> None:
    table = table_of(tmp_path, "t,v2,v2_error\n1,4,.4\n2,1,.2\n")
    assert table.names == ("thermal_speed",)
    np.testing.assert_allclose(table.values, [[2.0, 1.0]])
    np.testing.assert_allclose(table.errors, [[0.1, 0.1]])


def test_units_are_those_of_the_data(tmp_path: Path) -> None:
    text = "t,v0,v0_error,msd\n1,3,.3,8\n2,6,.3,4\n"
    table = table_of(tmp_path, text, diameter=2.0, speed_unit=3.0)
    np.testing.assert_allclose(table.times, [1.5, 3.0])
    np.testing.assert_allclose(table.values, [[1.0, 2.0], [2.0, 1.0]])
    np.testing.assert_allclose(table.errors[0], [0.1, 0.1])


def test_a_value_that_is_missing_is_not_a_number(tmp_path: Path) -> None:
    table = table_of(tmp_path, "t,v0,msd\n1,1.4,2\n2,1.3,\n")
    np.testing.assert_array_equal(np.isnan(table.values), [[False, False], [False, True]])


def test_tracks_are_no_averages(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t,tracer,x,y,v0\n0,1,0,0,1\n1,1,1,0,1\n0,2,0,0,1\n1,2,1,0,1\n")
    assert not isinstance(read_data([path]), AveragesTable)
    with pytest.raises(InputError, match="no column 'y'"):
        read_data([{"t": np.arange(2.0), "x": np.arange(2.0)}])


def test_averages_are_no_tracks(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t,v0,msd\n0,1,0\n1,1,1\n")
    with pytest.raises(InputError, match="averages at times"):
        read_sample([path])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("t,v0,msd\n1,1,1\n1,1,2\n", "there twice"),
        ("t,v0,msd\n-1,1,1\n1,1,2\n", "row 0: got time = -1"),
        ("t,v0,msd\n0,1,1\n1,1,-2\n", "msd = -2"),
        ("t,v0,v0_error\n0,1,1\n1,1,-2\n", r"thermal_speed = 1 \+- -2"),
        ("step,v0,msd\n0,1,1\n1,1,2\n", "--timestep"),
        ("u,v0,msd\n0,1,1\n1,1,2\n", "'time'"),
    ],
    ids=["time twice", "negative time", "negative msd", "negative error", "steps", "no time"],
)
def test_what_cannot_be_used_is_refused(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        table_of(tmp_path, text)
    assert "\n" not in str(caught.value)
