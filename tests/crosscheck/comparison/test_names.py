"""Columns by the names that people give them, tables in memory, and units as options."""

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinetics
from kinetics.cli import main
from kinetics.crosscheck.comparison import question
from kinetics.crosscheck.comparison.data.columns import parsed_columns
from kinetics.crosscheck.comparison.data.read import read_sample
from kinetics.crosscheck.comparison.question import compare_data
from kinetics.errors import InputError
from particles import BoltzmannGrad, simulate

OTHER = {
    "time": "t", "tracer": "particle", "medium": "replica", "x": "xu", "y": "yu", "vx": "v_x",
    "vy": "v_y",
}  # fmt: skip


def renamed(data: dict[str, Any], names: dict[str, str]) -> dict[str, Any]:
    return {names.get(name, name): values for name, values in data.items()}


@pytest.mark.parametrize("kind", ["csv", "npz", "h5"])
def test_usual_names_are_known(
    tmp_path: Path, kind: str, made_up: Any, moments: Any, write: Any
) -> None:
    data = made_up()
    plain = read_sample([write(tmp_path, kind, data)])
    found = read_sample([write(tmp_path, kind, renamed(data, OTHER))])
    np.testing.assert_array_equal(moments(found), moments(plain))
    assert found.grouping == "medium"


def test_any_name_may_be_told(tmp_path: Path, made_up: Any, moments: Any, write: Any) -> None:
    data = made_up()
    path = write(tmp_path, "csv", renamed(data, {"time": "clock [s]", "vx": "speed x"}))
    columns = parsed_columns(" t=clock [s] , v_x = speed x")
    assert columns == {"time": "clock [s]", "vx": "speed x"}
    plain = read_sample([write(tmp_path, "npz", data)])
    np.testing.assert_allclose(
        moments(read_sample([path], columns=columns)), moments(plain), rtol=1e-12
    )
    with pytest.raises(InputError, match="column 'tick' is missing"):
        read_sample([path], columns={"time": "tick"})
    for text, message in (
        ("time", "must be like time=t"),
        ("colour=t", "'colour' is not known"),
        ("t=a,time=b", "'time' stands twice"),
    ):
        with pytest.raises(InputError, match=message):
            parsed_columns(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0,1,2,3,4\n1,2,3,4,5\n", "has no header; its first line must name the columns"),
        ("t;x;y;vx;vy\n0,5;1;2;3;4\n", "'0,5' is not a number; numbers must have a decimal point"),
        ("t,xu,x_u,y,vx,vy,time\n", "column 'x' is missing"),
        ("t,x,y,vx,vy,times\n", r"column 'time' stands 2 times \(as t and times\)"),
    ],
)
def test_what_is_wrong_with_names_is_said(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "data.csv"
    path.write_text(text)
    if "x_u" in text:
        path.write_text(text.replace("xu,", ""))
    with pytest.raises(InputError, match=message) as caught:
        read_sample([path])
    assert "\n" not in str(caught.value)


def test_names_behind_a_sharp(tmp_path: Path, made_up: Any, moments: Any, write: Any) -> None:
    """As numpy.savetxt writes them."""
    data = made_up()
    table = np.column_stack(list(data.values()))
    path = tmp_path / "data.csv"
    np.savetxt(path, table, delimiter=",", header="t,x,y,vx,vy,id,config")
    plain = read_sample([write(tmp_path, "npz", data)])
    np.testing.assert_allclose(moments(read_sample([path])), moments(plain), rtol=1e-12)


def test_parquet(tmp_path: Path, made_up: Any, moments: Any, write: Any) -> None:
    import pyarrow as pa
    from pyarrow import parquet

    data = made_up()
    path = tmp_path / "data.parquet"
    parquet.write_table(pa.table({**data, "note": ["a"] * 120}), path)
    plain = read_sample([write(tmp_path, "npz", data)])
    np.testing.assert_array_equal(moments(read_sample([path])), moments(plain))
    parquet.write_table(pa.table({**data, "x": ["a"] * 120}), path)
    with pytest.raises(InputError, match="column 'x' is string; it must be real numbers"):
        read_sample([path])
    parquet.write_table(pa.table({**data, "x": [None, *data["x"][1:].tolist()]}), path)
    with pytest.raises(InputError, match="has empty cells"):
        read_sample([path])
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(InputError, match=r"is damaged, or not a \.parquet file"):
        read_sample([path])


def test_compare_takes_columns_in_memory(tmp_path: Path, made_up: Any, write: Any) -> None:
    """A dictionary, a DataFrame and a file of the same data give the same answer."""
    pandas = pytest.importorskip("pandas")
    data = made_up()
    path = write(tmp_path, "npz", data)
    of_file = kinetics.compare(path, restitution=0.7, number_density=0.04, explain=False)
    frame = pandas.DataFrame(renamed(data, OTHER))
    frame["replica"] = [f"run {k}" for k in frame["replica"]]
    for table in (data, frame, [data]):
        found = kinetics.compare(table, restitution=0.7, number_density=0.04, explain=False)
        assert found.verdict == of_file.verdict
        assert [t.p_value for t in found.tests] == [t.p_value for t in of_file.tests]
    rows = found.to_dataframe()
    assert list(rows.columns)[:3] == ["observable", "time", "value"]
    assert len(rows) == len(found.rows)
    assert found.to_dict() == json.loads(found.to_json())
    with pytest.raises(InputError, match="data: column 'y' is missing"):
        kinetics.compare({k: v for k, v in data.items() if k != "y"}, restitution=0.7)
    with pytest.raises(InputError, match="data: got 3"):
        kinetics.compare(3, restitution=0.7)


def agreeing() -> dict[str, Any]:
    """Columns of flights with e = 0.7 at the density 0.04."""
    run = simulate(
        BoltzmannGrad(0.04), 0.7, times=[0.0, 5.0, 50.0], media=20, tracers=5, seed=2, workers=1,
        observables=("positions", "velocities"),
    )  # fmt: skip
    columns = np.moveaxis(np.concatenate([run.positions, run.velocities], axis=2), 2, 0)
    labels = np.tile(np.arange(100), 3)
    found = dict(zip(("x", "y", "vx", "vy"), columns.reshape(4, -1), strict=True))
    return {"time": np.repeat(run.times, 100), **found, "tracer": labels, "medium": labels // 5}


def test_units_are_options(tmp_path: Path, write: Any, capsys: Any) -> None:
    """Lengths in 2 d, speeds in U/4 and times in a unit that does not belong to them."""
    data = agreeing()
    path = write(tmp_path, "csv", data)
    scaled = data | {k: data[k] * 2 for k in "xy"} | {k: data[k] / 4 for k in ("vx", "vy")}
    scaled["time"] = data["time"] * 100
    other = write(tmp_path, "npz", renamed(scaled, {"time": "clock"}))
    told = ["-e", "0.7", "--json"]
    assert main(["compare", str(path), *told, "--number-density", "0.04"]) == 0
    plain = json.loads(capsys.readouterr().out)
    units = ["--length-unit", "2", "--speed-unit", "0.25", "--time-unit", "100"]
    more = [*units, "--columns", "time=clock", "--number-density", "0.01"]
    assert main(["compare", str(other), *told, *more]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["verdict"] == plain["verdict"] == "agrees"  # nothing is fitted
    for a, b in zip(found["tests"], plain["tests"], strict=True):
        assert a["p_value"] == pytest.approx(b["p_value"], rel=1e-6, abs=1e-12)


def test_a_script_can_fail_on_a_difference(
    tmp_path: Path, made_up: Any, write: Any, capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write(tmp_path, "csv", made_up(400))
    once = cache(lambda: compare_data(path, 0.7, 0.04))  # most of the time of this test
    monkeypatch.setattr(question, "compare_data", lambda *_, **__: once())
    arguments = ["compare", str(path), "-e", "0.7", "--number-density", "0.04"]
    assert main(arguments) == 0
    text = capsys.readouterr().out
    assert text.startswith(("They differ", "A unit is wrong"))
    assert max(map(len, text.splitlines())) <= 100
    assert main([*arguments, "--fail-on", "differs"]) == 1
    assert main([*arguments, "--fail-on", "unclear"]) == 1
