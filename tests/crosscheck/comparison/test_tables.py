"""Tables of averages with standard errors: what can be judged from them is judged."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinetics import Scene, compare, solve
from kinetics.crosscheck.comparison.data import averages
from kinetics.crosscheck.comparison.data.read import read_sample
from kinetics.crosscheck.comparison.statistics import errors, of_the_worst
from kinetics.crosscheck.comparison.theory import observed
from kinetics.errors import InputError

TIMES = np.array([0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0])
TOLD: dict[str, Any] = {"restitution": 0.7, "number_density": 0.04}


@pytest.fixture(scope="module")
def table() -> dict[str, Any]:
    """The solution with errors of 1 % that are the same at all times: as correlated as can be."""
    outputs = ("thermal_speed", "a2", "msd")
    found = solve(Scene(0.7, 0.04, times=TIMES, outputs=outputs), rtol=1e-8)
    v0, r2 = found.thermal_speed, found.msd
    return {
        "t": TIMES, "v0": v0 * 1.01, "v0_error": v0 * 0.01, "<r^2>": r2 * 1.02,
        "<r^2>_se": r2 * 0.02, "a2": found.a2 - 0.01, "a2_err": np.full(TIMES.size, 0.02),
    }  # fmt: skip


def test_groups_have_the_means_and_the_errors_of_the_table(table: dict[str, Any]) -> None:
    sample = read_sample_of(table)
    total, scales = sample.sums.sum(axis=0), (sample.speed_scale, sample.length_scale)
    names = ("thermal_speed", "msd", "a2")
    values = observed(total, *scales, names, sample.law)
    replicates = observed(total - sample.sums, *scales, names, sample.law)
    for k, (name, error) in enumerate(
        (("v0", "v0_error"), ("<r^2>", "<r^2>_se"), ("a2", "a2_err"))
    ):
        np.testing.assert_allclose(values[k], table[name], rtol=1e-9)
        np.testing.assert_allclose(errors(replicates)[k], table[error], rtol=3e-3)
    off_diagonal = np.corrcoef(replicates[:, :2].reshape(averages.GROUPS, -1).T) - np.eye(14)
    assert np.abs(off_diagonal).max() < 0.01


def read_sample_of(table: dict[str, Any]) -> Any:
    from kinetics.crosscheck.comparison.data.columns import Table

    return read_sample([Table(table)])


def test_one_error_for_all_times_is_no_difference(table: dict[str, Any]) -> None:
    """One standard error off at all times: a sum of squares of independent errors would be 7."""
    result = compare(table, **TOLD)
    assert result.verdict == "agrees"
    assert (result.samples, result.groups, result.grouping) == (0, 0, "table")
    for test in result.tests:
        assert (test.dof, test.groups) == (1, None)
        assert test.p_value == 1.0  # 0.32 times 7 times
    assert "A table of averages at 7 times" in result.summary
    assert "however" not in result.warnings[0]


def test_p_values_hold_for_any_correlation() -> None:
    """The largest of n: never below alpha more often than alpha, for equal or independent ones."""
    rng = np.random.default_rng(3)
    independent = [of_the_worst(rng.normal(size=10)).p_value for _ in range(4000)]
    equal = [of_the_worst(np.full(10, rng.normal())).p_value for _ in range(4000)]
    assert np.mean(np.array(independent) < 0.05) == pytest.approx(0.049, abs=0.011)
    assert np.mean(np.array(equal) < 0.05) < 0.011
    tested = of_the_worst(np.array([1.0, -3.0]))
    assert tested.value == pytest.approx(7.75, abs=0.01)  # the chi-square of p = 2 * 0.0027
    assert of_the_worst(np.array([60.0])).value == 3600.0


def test_a_wrong_restitution_explains_the_difference(table: dict[str, Any]) -> None:
    result = compare(table, restitution=0.8, number_density=0.04)
    assert result.verdict == "differs"
    best = result.explanations[0]
    assert (best.name, best.outcome) == ("restitution", "explains")
    assert best.value is not None
    assert best.error is not None
    assert abs(best.value - 0.7) < 1.1 * best.error < 0.03


def test_fitted_values_have_the_errors_of_the_worst_correlation(table: dict[str, Any]) -> None:
    found = compare(table, explain=False).parameters
    for name, truth in (("restitution", 0.7), ("mean_free_path", 12.5)):
        assert found[name].value is not None
        assert found[name].error is not None
        assert abs(found[name].value - truth) < found[name].error


@pytest.mark.slow
def test_finite_density_stands_first(table: dict[str, Any]) -> None:
    times = np.array([30.0, 100.0, 300.0, 1000.0])
    dense = solve(
        Scene(0.7, 0.1, times=times, outputs=("thermal_speed", "msd"), scatterers="hard disks"),
        rtol=1e-6,
    )
    data = {
        "t": times, "v0": dense.thermal_speed, "v0_error": 0.01 * dense.thermal_speed,
        "msd": dense.msd, "msd_error": 0.01 * dense.msd,
    }  # fmt: skip
    result = compare(data, restitution=0.7, number_density=0.1)
    assert result.verdict == "differs"
    assert (result.explanations[0].name, result.explanations[0].outcome) == (
        "finite density", "explains",
    )  # fmt: skip


@pytest.mark.parametrize(("unit", "value"), [({"t": 1.1}, 1.1), ({"<r^2>": 4.0}, 0.5)])
def test_a_wrong_unit_comes_first(table: dict[str, Any], unit: Any, value: float) -> None:
    wrong = {name: values * unit.get(name, 1.0) for name, values in table.items()}
    wrong["<r^2>_se"] = wrong["<r^2>"] * 0.002
    wrong["v0_error"] = wrong["v0"] * 0.001
    result = compare(wrong, **TOLD)
    assert [item.name for item in result.explanations] == ["time unit"]
    assert result.explanations[0].value == pytest.approx(value, rel=0.02)
    assert result.summary.startswith("A unit is wrong: ⟨r²⟩/(⟨v²⟩ t²) tends to ")


def test_late_times_tell_nothing_of_units(table: dict[str, Any]) -> None:
    late = {name: values[2:] for name, values in table.items()}
    late["<r^2>_se"] = late["<r^2>"] * 0.021
    assert compare(late, **TOLD).verdict == "agrees"


@pytest.mark.parametrize("kind", ["csv", "npz", "h5", "parquet"])
def test_tables_are_files_of_any_columns(
    tmp_path: Path, table: dict[str, Any], kind: str, write: Any
) -> None:
    data = table | {"note": np.arange(TIMES.size)}
    if kind == "parquet":
        import pyarrow as pa
        from pyarrow import parquet

        path = tmp_path / "data.parquet"
        parquet.write_table(pa.table(data), path)
    else:
        path = write(tmp_path, kind, data)
    plain = compare(table, **TOLD, explain=False)
    found = compare(path, **TOLD, explain=False)
    assert [t.p_value for t in found.tests] == [t.p_value for t in plain.tests]
    assert [row.value for row in found.rows] == [row.value for row in plain.rows]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"t": np.ones(7)}, "different times"),
        ({"t": -TIMES}, "different times"),
        ({"v0_error": -np.ones(7)}, "an error of thermal_speed is negative"),
        ({"v0_error": np.zeros(7), "<r^2>_se": np.zeros(7)}, "no average has a value and"),
        ({"t": np.full(7, np.nan)}, "every value must be a finite number"),
    ],
)
def test_bad_tables_are_one_line(table: dict[str, Any], change: Any, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        compare(table | change, **TOLD)
    assert "\n" not in str(caught.value)


def test_units_of_averages(table: dict[str, Any]) -> None:
    """d = 2 mm, U = 0.5 m/s, times in ms."""
    data = {
        "t [ms]": TIMES * 4, "v0 [m/s]": table["v0"] / 2, "v0_error": table["v0_error"] / 2,
        "<r^2> [mm^2]": table["<r^2>"] * 4, "<r^2>_se": table["<r^2>_se"] * 4,
    }  # fmt: skip
    told: dict[str, Any] = {"restitution": 0.7, "number_density": 0.01, "explain": False}
    found = compare(data, **told, diameter=2.0, speed_unit=0.5)
    assert found.verdict == "agrees"
    assert "lengths in mm, " in found.warnings[-1] or "speeds in m/s" in found.warnings[-1]
    plain = compare(table, **TOLD, explain=False)
    for a, b in zip(found.observable("msd"), plain.observable("msd"), strict=True):
        assert a.value == pytest.approx(b.value)
        assert a.time == pytest.approx(b.time)


def test_what_a_table_cannot_say(table: dict[str, Any], tmp_path: Path, write: Any) -> None:
    some = {name: table[name] for name in ("t", "a2", "a2_err", "<r^2>", "<r^2>_se")}
    result = compare(some, **TOLD, explain=False)
    assert [test.observable for test in result.tests] == ["msd"]
    assert "a2 cannot be used without the second moment" in result.warnings[1]
    path = write(tmp_path, "csv", table)
    with pytest.raises(InputError, match="a table of averages must be the only file"):
        read_sample([path, path])
    with pytest.raises(InputError, match="column 'x' is missing"):  # v0 without its error
        compare({"t": TIMES, "v0": table["v0"]}, **TOLD)
    with pytest.raises(InputError, match="compared from rows alone"):
        compare(table, **TOLD, field=0.1)
