"""Numbers, tables and JSON as a user reads them."""

import numpy as np

from kinetics.crosscheck.numerals import number, numeral
from kinetics.crosscheck.strict_json import plain
from kinetics.crosscheck.text_tables import columns


def test_numbers_show_their_error() -> None:
    assert number(12.34567, 0.0123) == "12.346 ± 0.012"
    assert number(1234.5, 123.0) == "1234 ± 123"
    assert number(None) == "–"
    assert number(0.123456789) == "0.123457"
    assert number(-0.173316) == "−0.173316"
    assert number(2.2e7) == "2.2·10⁷"
    assert number(5177.61, digits=3) == "5180"
    assert number(-1.5, 0.5, "+") == "−1.50 ± 0.50"
    assert numeral(1e-10, "g") == "10⁻¹⁰"
    assert numeral(2200, ".2g") == "2200"
    assert numeral(-0.2, "+.0f") == "0"


def test_columns_are_aligned() -> None:
    assert columns(["t", "v0"], [[1.0, 10.0], [0.5, 123456.0]]).splitlines() == [
        " t      v0",
        " 1     0.5",
        "10  123456",
    ]


def test_plain_leaves_no_numpy_and_no_nan() -> None:
    value = {"a": np.array([1.0, np.nan]), "b": (np.float64(2), np.int32(3)), "c": float("inf")}
    assert plain(value) == {"a": [1.0, None], "b": [2.0, 3], "c": None}
