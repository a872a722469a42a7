"""Samples from data: sums, groups, positions, units, labels; and data that are odd."""

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinetics.crosscheck.comparison import reduction
from kinetics.crosscheck.comparison.data import labels
from kinetics.crosscheck.comparison.data.columns import Rows
from kinetics.crosscheck.comparison.data.read import read_sample
from kinetics.crosscheck.comparison.reduction import MOST_GROUPS, Reduction
from kinetics.crosscheck.comparison.sample import R2, R4, V2, V4, N
from kinetics.errors import InputError

NAMES = ("time", "x", "y", "vx", "vy", "tracer", "medium")


@pytest.mark.parametrize("kind", ["csv", "npz", "zip.npz", "h5"])
def test_sums_are_those_of_the_rows(tmp_path: Path, kind: str, made_up: Any, write: Any) -> None:
    data = made_up()
    path = write(tmp_path, kind, data)
    before = path.read_bytes()
    sample = read_sample([path])
    assert path.read_bytes() == before
    assert sample.grouping == "medium"
    assert sample.groups == 10
    np.testing.assert_array_equal(sample.times, [0.0, 1.0, 10.0])
    np.testing.assert_array_equal(sample.samples, [40, 40, 40])
    speed2 = data["vx"] ** 2 + data["vy"] ** 2
    r2 = data["x"] ** 2 + data["y"] ** 2
    for k, time in enumerate(sample.times):
        for g in range(10):
            mine = (data["time"] == time) & (data["medium"] == g)
            v, r = sample.speed_scale[k] ** 2, sample.length_scale[k] ** 2
            sums = sample.sums[g, k]
            assert sums[N] == 4
            expected = {V2: speed2[mine], V4: speed2[mine] ** 2, R2: r2[mine], R4: r2[mine] ** 2}
            unit = {V2: v, V4: v**2, R2: r, R4: r**2}
            for column, values in expected.items():
                np.testing.assert_allclose(sums[column] * unit[column], values.sum(), rtol=1e-12)
    assert sample.speeds is not None
    assert sample.displacements is not None
    for binned, values in ((sample.speeds, np.sqrt(speed2)), (sample.displacements, np.sqrt(r2))):
        counts, _ = np.histogram(values[80:], binned.edges[2])
        np.testing.assert_array_equal(binned.totals[2, 1:-1], counts)
        assert binned.totals[2].sum() == 40
        assert binned.by_group is not None
        third, _ = np.histogram(values[80:][data["medium"][80:] == 2], binned.edges[2])
        np.testing.assert_array_equal(binned.by_group[2, 2, 1:-1], third)
    start = sample.start
    assert start is not None
    np.testing.assert_allclose(start.squares @ start.counts, speed2[:40].sum())
    np.testing.assert_allclose(
        start.flatness * start.squares**2 @ start.counts, (speed2[:40] ** 2).sum()
    )


def test_the_order_of_rows_and_columns_does_not_matter(
    tmp_path: Path, made_up: Any, moments: Any, write: Any
) -> None:
    data = made_up()
    order = np.random.default_rng(1).permutation(data["time"].size)
    mixed = {name: data[name][order] for name in reversed(NAMES)} | {"note": order}
    a, b = (read_sample([write(tmp_path, "npz", d)]) for d in (data, mixed))
    np.testing.assert_array_equal(a.times, b.times)
    np.testing.assert_allclose(moments(a), moments(b), rtol=1e-12)


def test_times_within_rounding_are_one_time(tmp_path: Path, made_up: Any, write: Any) -> None:
    data = made_up(times=(0.1 + 0.2, 1.0))
    data["time"][:20] = 0.3
    sample = read_sample([write(tmp_path, "npz", data)])
    np.testing.assert_array_equal(sample.samples, [40, 40])


def test_too_many_times_are_refused(tmp_path: Path, made_up: Any, write: Any) -> None:
    data = made_up()
    data["time"] = np.arange(data["time"].size) * 1.0
    path = write(tmp_path, "npz", {k: np.tile(v, 5) for k, v in data.items() if k != "time"} | {
        "time": np.arange(600.0)
    })  # fmt: skip
    with pytest.raises(InputError, match="more than 400 different times"):
        read_sample([path])


def test_absolute_positions_become_displacements(
    tmp_path: Path, made_up: Any, moments: Any, write: Any
) -> None:
    data = made_up()
    plain = read_sample([write(tmp_path, "npz", data)])
    origin = np.random.default_rng(2).uniform(-50, 50, (2, 40))
    moved = data | {"x": data["x"] + np.tile(origin[0], 3), "y": data["y"] + np.tile(origin[1], 3)}
    order = np.random.default_rng(1).permutation(120)
    path = write(tmp_path, "csv", {name: moved[name][order] for name in NAMES})
    for rule in ("auto", "absolute"):
        sample = read_sample([path], positions=rule)
        np.testing.assert_allclose(moments(sample), moments(plain), rtol=1e-9, atol=1e-9)
    assert "Positions at time 0 are not the origin" in read_sample([path]).warnings[0]
    told = read_sample([path], positions="displacement")
    assert (told.sums[:, 0, R2] > 0).all()


def test_absolute_positions_need_a_tracer_and_a_time_0(
    tmp_path: Path, made_up: Any, write: Any
) -> None:
    data = made_up()
    data["x"] = data["x"] + 5
    without = {k: v for k, v in data.items() if k != "tracer"}
    with pytest.raises(InputError, match="without a column tracer"):
        read_sample([write(tmp_path, "npz", without)])
    later = {k: v[40:] for k, v in data.items()}
    with pytest.raises(InputError, match="need rows at time 0"):
        read_sample([write(tmp_path, "npz", later)], positions="absolute")
    some = {k: np.delete(v, 3) for k, v in data.items()}
    with pytest.raises(InputError, match="tracer 3 has no row at time 0"):
        read_sample([write(tmp_path, "npz", some)])
    with pytest.raises(InputError, match="positions: got 'relative'"):
        read_sample([write(tmp_path, "npz", data)], positions="relative")


def test_units_of_the_data(tmp_path: Path, made_up: Any, moments: Any, write: Any) -> None:
    """The same data in other units: U = 3, d = 2, so that times are in units of 2/3 d/U."""
    data = made_up(tracers=400)
    plain = read_sample([write(tmp_path, "npz", data)])
    other = {
        name: values * {"time": 2 / 3, "x": 2, "y": 2, "vx": 3, "vy": 3}.get(name, 1)
        for name, values in data.items()
    }
    path = write(tmp_path, "npz", other)
    sample = read_sample([path], speed_unit=3.0, diameter=2.0)
    np.testing.assert_allclose(sample.times, plain.times)
    np.testing.assert_allclose(moments(sample), moments(plain), rtol=1e-12)
    found = read_sample([path], speed_unit="data", diameter=2.0)
    size = np.sqrt(np.mean(data["vx"][:400] ** 2 + data["vy"][:400] ** 2) / 2)
    np.testing.assert_allclose(found.times, plain.times * size)
    assert "U is" in found.warnings[-1]
    with pytest.raises(InputError, match="speed_unit"):
        read_sample([path], speed_unit=-1.0)
    later = write(tmp_path, "npz", {k: v[400:] for k, v in data.items()})
    with pytest.raises(InputError, match="needs velocities at time 0"):
        read_sample([later], speed_unit="data")


def test_without_configurations_errors_are_by_tracer_and_said_so(
    tmp_path: Path, made_up: Any, write: Any
) -> None:
    data = made_up()
    no_medium = {k: v for k, v in data.items() if k != "medium"}
    sample = read_sample([write(tmp_path, "npz", no_medium)])
    assert (sample.grouping, sample.groups) == ("tracer", 40)
    assert "share scatterers are not independent" in sample.warnings[0]
    rows = {k: v for k, v in no_medium.items() if k != "tracer"}
    sample = read_sample([write(tmp_path, "npz", rows)])
    assert (sample.grouping, sample.groups) == ("row", 40)
    assert "k-th row" in sample.warnings[1]
    one = data | {"medium": np.zeros(120, int)}
    sample = read_sample([write(tmp_path, "npz", one)])
    assert (sample.grouping, sample.groups) == ("tracer", 40)
    assert "one configuration" in sample.warnings[0]


def test_several_files_are_runs_of_their_own(tmp_path: Path, made_up: Any, write: Any) -> None:
    data = made_up()
    a = write(tmp_path, "npz", data)
    b = write(tmp_path, "csv", data)
    sample = read_sample([a, b])
    np.testing.assert_array_equal(sample.samples, [80, 80, 80])
    assert sample.groups == 20
    assert sample.names == ("data.npz", "data.csv")
    write(tmp_path, "h5", {k: v for k, v in data.items() if k != "medium"})
    with pytest.raises(InputError, match=r"data\.h5: column medium must be in all files"):
        read_sample([a, tmp_path / "data.h5"])


def test_many_configurations_share_groups(tmp_path: Path, made_up: Any, write: Any) -> None:
    data = made_up(tracers=4000)
    sample = read_sample([write(tmp_path, "npz", data)])
    assert sample.groups == MOST_GROUPS
    np.testing.assert_array_equal(sample.samples, [4000] * 3)


def test_labels_that_are_used_again_in_each_configuration(
    tmp_path: Path, made_up: Any, moments: Any, write: Any
) -> None:
    """Tracers 0 .. n - 1 in each of the configurations 0 .. m - 1: labels are two columns, not a
    sum of the two, in which (1, 0) and (0, 1) would be one."""
    data = made_up(tracers=40)
    data["medium"] = data["tracer"] // 8
    data["tracer"] = data["tracer"] % 8
    for kind in ("csv", "npz", "h5"):
        sample = read_sample([write(tmp_path, kind, data)])
        assert (sample.groups, sample.grouping) == (5, "medium")
        np.testing.assert_array_equal(sample.samples, [40, 40, 40])
    moved = data | {"x": data["x"] + np.tile(np.arange(40.0), 3)}
    absolute = read_sample([write(tmp_path, "npz", moved)])
    np.testing.assert_allclose(moments(absolute), moments(sample), rtol=1e-9, atol=1e-9)
    data["tracer"][41] = 0  # tracer 1 of configuration 0 at time 1
    with pytest.raises(InputError, match="tracer 0 of medium 0 has more than one row at time 1;"):
        read_sample([write(tmp_path, "npz", data)])


@pytest.mark.parametrize("wide", [1, 2**55, -(2**55)])
def test_labels_of_any_size_are_told_apart(wide: int) -> None:
    n = 300
    zeros = np.zeros(n)
    tracer = np.arange(n) % 30 * wide
    medium = np.arange(n) // 30 * wide
    run = Reduction("medium")
    for time in (1.0, 2.0):
        run.add(Rows(np.full(n, time), zeros, zeros, zeros + 1, zeros, tracer, medium))
    assert run.sample(("x",)).samples.tolist() == [n, n]
    run.add(Rows(*(v[:1] for v in (zeros + 2, zeros, zeros, zeros + 1, zeros, tracer, medium))))
    with pytest.raises(InputError, match="tracer 0 of medium 0 has more than one row at time 2"):
        run.sample(("x",))


def test_repeated_rows_are_found_in_a_part_of_the_tracers(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where there are more rows than are remembered, a part of the tracers is, at all times."""
    monkeypatch.setattr(labels, "MOST_REMEMBERED", 600)
    n = 5000
    zeros, label = np.zeros(n), 2 * np.arange(n)
    run = Reduction("tracer")
    for time in (1.0, 2.0):
        run.add(Rows(np.full(n, time), zeros, zeros, zeros + 1, zeros, label))
    assert run.sample(("x",)).samples.tolist() == [n, n]
    run.add(Rows(np.full(n, 2.0), zeros, zeros, zeros + 1, zeros, label))
    with pytest.raises(InputError, match="has more than one row at time 2"):
        run.sample(("x",))


def test_bins_count_what_lies_outside() -> None:
    """Zero and tiny values below, huge ones above."""
    speeds = np.array([1.0] * 98 + [0.0, 1e-30])
    zeros = np.zeros(100)
    run = Reduction("row")
    run.add(Rows(np.ones(100), zeros, zeros, speeds, zeros))
    run.add(Rows(np.ones(2), zeros[:2], zeros[:2], np.array([1e9, 1.0]), zeros[:2]))
    sample = run.sample(("x",))
    assert sample.speeds is not None
    assert sample.speeds.totals[0, 0] == 2
    assert sample.speeds.totals[0, -1] == 1
    assert sample.at_rest.tolist() == [1]
    assert reduction.SAME_TIME < 1e-8


@pytest.mark.parametrize(
    ("data", "told"),
    [
        ({"times": [1.0], "count": 2}, {"restitution": 0.7}),
        *(
            pytest.param(data, {"restitution": e}, marks=pytest.mark.slow)
            for data, e in (
                ({"times": [1.0, 10.0], "count": 50, "speed": 0.0}, 0.7),
                ({"times": [0.0, 1.0, 10.0], "count": 80, "speed": 1.0}, 0.0),
                ({"times": [1.0, 2, 3], "count": 3}, 0.7),
                ({"times": [0.0], "count": 50}, 0.7),
                ({"times": [1.0, 10.0], "count": 50, "speed": 1.0}, 0.7),
                ({"times": [0.0, 1.0, 10.0], "count": 80, "speed": 1.0}, 1.0),
                ({"times": [1e-200, 1e-3], "count": 80}, 0.5),
                ({"times": [1e10, 1e12], "count": 80}, 0.5),
                ({"times": [1.0, 10.0], "count": 50, "scale": 1e-170}, 0.5),
            )
        ),
    ],
)
def test_odd_data_have_an_answer(
    data: dict[str, Any], told: dict[str, float], tmp_path: Path, write: Any, tracers_at: Any
) -> None:
    from kinetics.crosscheck.comparison.page import files_of
    from kinetics.crosscheck.comparison.question import compare_sample

    columns = tracers_at(**data)
    result = compare_sample(
        read_sample([write(tmp_path, "npz", columns)]), number_density=0.04, **told
    )
    assert result.verdict in ("agrees", "unclear", "differs", "undefined")
    assert set(files_of(result, tmp_path / "page.html")) == {"page.html", "page.json"}
    if told["restitution"] == 0.7 and len(columns["time"]) < 10:
        assert result.verdict != "differs"  # two or three tracers cannot


@pytest.mark.parametrize(
    ("data", "told", "message"),
    [
        ({"times": [1.0, 2.0], "count": 3}, {}, "cannot be found in so few times and groups"),
        ({"times": [0.0], "count": 50}, {}, "cannot be found in so few times and groups"),
        (
            {"times": [0.0, 1.0], "count": 50, "speed": 0.0},
            {"restitution": 0.7},
            "every speed at time 0",
        ),
        (
            {"times": [1.0], "count": 50},
            {"restitution": 0.7, "initial": "data"},
            "needs velocities at",
        ),
        (
            {"times": [1.0], "count": 50},
            {"restitution": 0.7, "initial": "ring"},
            "must be one of auto",
        ),
        ({"times": [1.0], "count": 50, "scale": 1e160}, {"restitution": 0.7}, "give --speed-unit"),
        (
            {"times": [0.0, 1.0], "count": 50, "scale": 1e-100},
            {"restitution": 0.7},
            "give --speed-unit",
        ),
    ],
)
def test_what_cannot_be_compared_is_said(
    data: dict[str, Any],
    told: dict[str, Any],
    message: str,
    tmp_path: Path,
    write: Any,
    tracers_at: Any,
) -> None:
    from kinetics.crosscheck.comparison.question import compare_sample

    density = None if told == {} else 0.04
    path = write(tmp_path, "npz", tracers_at(**data))
    with pytest.raises(InputError, match=message):
        compare_sample(read_sample([path]), number_density=density, **told)


def test_a_file_may_have_any_name(tmp_path: Path, made_up: Any, write: Any) -> None:
    """Also bytes that are no text."""
    from kinetics.crosscheck.comparison.page import files_of
    from kinetics.crosscheck.comparison.question import compare_sample

    path = write(tmp_path, "csv", made_up()).rename(tmp_path / os.fsdecode(b"a\xff<b>.csv"))
    result = compare_sample(read_sample([path]), 0.7, 0.04)
    assert result.names == ("a?<b>.csv",)
    page = files_of(result, tmp_path / "page.html")["page.html"]
    assert isinstance(page, str)
    assert "a?&lt;b&gt;.csv" in page
    page.encode()
    path.write_text("time\n")
    with pytest.raises(InputError, match=r"a\?<b>\.csv: column 'x' is missing"):
        read_sample([path])
