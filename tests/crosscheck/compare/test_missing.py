"""A number that is masked or missing is a gap, as NaN is, in whatever form data come."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
import pytest
from made_data import TIMES, Run, columns_of

from kinetics import compare
from kinetics.crosscheck import Comparison
from kinetics.errors import InputError

#: Tracers that are compared: twelve configurations.
TRACERS = 600
MASKED_ROW = 2 * TRACERS + 7  # tracer 7 at the third time, 20


def column_with_one_masked(column: Any) -> Any:
    """Masked where the value is 1e6, as a detector writes what it has not seen."""
    values = np.array(column, float)
    values[MASKED_ROW] = 1e6
    return np.ma.masked_greater(values, 1e5)


def as_list_of_numbers(column: Any) -> list[Any]:
    numbers = list(np.array(column, float))
    numbers[MASKED_ROW] = np.ma.masked
    return numbers


def as_nullable(column: Any) -> Any:
    series = pd.Series(np.array(column, float)).astype("Float64")
    series[MASKED_ROW] = pd.NA
    return series


FORMS = {
    "masked array": column_with_one_masked,
    "list with a masked number": as_list_of_numbers,
    "nullable series": as_nullable,
    "nullable array": lambda column: as_nullable(column).array,
    "arrow series": lambda column: as_nullable(column).astype("float64[pyarrow]"),
}


def compared(data: Any) -> Comparison:
    """The comparison of few tracers: what is read is what counts."""
    return compare(data, 0.75, 0.04, scatterers="dilute", explain=False)


@pytest.fixture(scope="module")
def few(run: Run) -> Run:
    """The first configurations of the run."""
    return run[0][:, :TRACERS], run[1][:, :TRACERS]


@pytest.fixture(scope="module")
def expected(few: Run) -> Comparison:
    """The comparison of the data without the row."""
    columns = columns_of(few)
    return compared({name: np.delete(values, MASKED_ROW) for name, values in columns.items()})


def require_gap(data: Any, expected: Comparison) -> None:
    """The result is that of the data without the row, and the gap is counted."""
    result = compared(data)
    assert result.numbers == expected.numbers
    assert result.tests == expected.tests
    assert any(text.startswith("1 rows") for text in result.warnings)


@pytest.mark.parametrize("name", ["x", "vy"])
@pytest.mark.parametrize("form", list(FORMS))
def test_a_missing_number_in_a_column_is_a_gap(
    few: Run, expected: Comparison, form: str, name: str
) -> None:
    data = columns_of(few)
    data[name] = FORMS[form](data[name])
    require_gap(data, expected)


@pytest.mark.parametrize("kind", ["Float64", "float64[pyarrow]"])
def test_a_missing_number_in_a_data_frame_is_a_gap(
    few: Run, expected: Comparison, kind: str
) -> None:
    frame = pd.DataFrame(columns_of(few)).astype({"x": kind})
    frame.loc[MASKED_ROW, "x"] = pd.NA
    require_gap(frame, expected)


def test_an_empty_cell_is_a_gap(tmp_path: Path, few: Run, expected: Comparison) -> None:
    frame = pd.DataFrame(columns_of(few))
    frame.loc[MASKED_ROW, "x"] = np.nan
    frame.to_csv(tmp_path / "a.csv", index=False)
    require_gap(tmp_path / "a.csv", expected)


def test_nullable_columns_without_missing_values_are_read_as_plain_ones(few: Run) -> None:
    data = columns_of(few)
    frame = pd.DataFrame(data)
    kinds = dict.fromkeys(("t", "x", "y", "vx", "vy"), "Float64")
    of_frame = compared(frame)
    nullable = frame.astype(kinds | dict.fromkeys(("id", "medium"), "Int64"))
    assert compared(nullable) == of_frame
    masked = {name: np.ma.array(values) for name, values in data.items()}
    assert compared(masked) == of_frame


@pytest.mark.parametrize("label", ["medium", "id", "t"])
def test_a_missing_label_or_time_is_refused(few: Run, label: str) -> None:
    data = columns_of(few)
    mask = np.arange(data[label].size) == MASKED_ROW
    data[label] = np.ma.array(data[label], mask=mask)
    with pytest.raises(InputError, match=f"row {MASKED_ROW}: got (no time|.* = nan)"):
        compare(data, 0.75, 0.04)


@pytest.mark.parametrize("missing", [None, pd.NA, np.ma.masked])
def test_a_missing_label_among_texts_is_refused(few: Run, missing: Any) -> None:
    data = columns_of(few)
    names = np.array([f"run {k}" for k in data["medium"]], dtype=object)
    if missing is np.ma.masked:
        names = np.ma.array(names, mask=np.arange(names.size) == MASKED_ROW)
    else:
        names[MASKED_ROW] = missing
    with pytest.raises(InputError, match=f"row {MASKED_ROW}: got no medium"):
        compare(data | {"medium": names}, 0.75, 0.04)


@pytest.mark.parametrize("in_lists", [False, True])
def test_a_masked_number_in_arrays_of_frames_is_a_gap(
    few: Run, expected: Comparison, in_lists: bool
) -> None:
    positions = np.ma.array(few[0], copy=True)
    positions[2, 7, 0] = 1e6
    positions = np.ma.masked_greater(positions, 1e5)
    data = {"times": TIMES, "positions": positions, "velocities": few[1]}
    data["medium"] = columns_of(few)["medium"][:TRACERS]
    if in_lists:
        data["positions"] = list(positions)
    require_gap(data, expected)


def test_a_tracer_that_is_masked_from_a_time_on_has_ended_as_one_that_is_nan(few: Run) -> None:
    ended = np.zeros(few[0].shape, bool)
    ended[3, :100] = True
    masked: dict[str, Any] = {"times": TIMES, "positions": np.ma.array(few[0], mask=ended)}
    masked["velocities"] = np.ma.array(few[1], mask=ended)
    filled = {name: np.ma.filled(values, np.nan) for name, values in masked.items()}
    result = compared(masked)
    assert result == compared(filled)
    assert min(result.rows["samples"]) == TRACERS - 100


@pytest.mark.parametrize("attribute", ["_FillValue", "missing_value"])
def test_a_fill_value_of_netcdf_is_missing(
    tmp_path: Path, few: Run, expected: Comparison, attribute: str
) -> None:
    data = columns_of(few)
    data["x"] = data["x"].copy()
    data["x"][MASKED_ROW] = 1e6
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for name, values in data.items():
            file[name] = values
        file["x"].attrs[attribute] = np.array([1e6])
    require_gap(tmp_path / "a.h5", expected)


def test_a_null_of_parquet_is_missing(tmp_path: Path, few: Run, expected: Comparison) -> None:
    frame = pd.DataFrame(columns_of(few)).astype({"x": "Float64"})
    frame.loc[MASKED_ROW, "x"] = pd.NA
    frame.to_parquet(tmp_path / "a.parquet")
    require_gap(tmp_path / "a.parquet", expected)
