"""The same trajectories give the same sums from every format, by the numbers of the run."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from made_data import (
    FORMATS,
    NO_MEDIUM,
    STEP,
    TIMES,
    TRACERS,
    Run,
    columns_of,
    simulated,
    text_of,
    write_dump,
    write_xyz,
)

from kinetics import compare
from kinetics.crosscheck.data.reading import read_sample
from kinetics.crosscheck.data.sample import R2, R4, V2, V4, N, Sample
from kinetics.errors import InputError


def moments(sample: Sample) -> Any:
    """Sums of 1, v^2, v^4, r^2, r^4 over groups: (n_times, 5)."""
    return sample.sums.sum(axis=0)[:, [N, V2, V4, R2, R4]]


def truth(run: Run) -> Any:
    v2, r2 = (np.sum(part**2, axis=2) for part in (run[1], run[0] - run[0][0]))
    return np.stack([x.sum(axis=1) for x in (v2**0, v2, v2**2, r2, r2**2)], axis=-1)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("name", list(FORMATS))
def test_every_format_gives_the_sums_of_the_run(
    tmp_path: Path, name: str, dimension: int, runs: dict[int, Run]
) -> None:
    path, run = tmp_path / name, runs[dimension]
    FORMATS[name](path, run)
    found = read_sample([path], dimension=dimension, timestep=STEP)
    exact = 1e-5 if name.endswith("gsd") else 1e-9
    np.testing.assert_allclose(moments(found), truth(run), rtol=exact, atol=1e-9)
    grouping, groups = ("tracer", 251) if name in NO_MEDIUM else ("medium", 40)
    assert (found.grouping, found.groups) == (grouping, groups)
    assert found.law.dimension == dimension
    np.testing.assert_array_equal(found.speeds[1].sum(axis=(0, 2)), TRACERS)  # type: ignore[union-attr]
    if dimension == 3:
        with pytest.raises(ValueError, match="dimension 3"):
            read_sample([path], timestep=STEP)


def test_columns_in_memory_are_read_as_files(run: Run) -> None:
    data = columns_of(run)
    frames = {"times": TIMES, "positions": run[0], "velocities": run[1]}
    frames["medium"] = data["medium"][:TRACERS]
    told: Any = {"restitution": 0.75, "number_density": 0.04, "explain": False}
    found = [compare(one, **told) for one in (data, pd.DataFrame(data), frames)]
    assert found[0] == found[1]
    assert {(c.grouping, c.p_value("msd") > 1e-3) for c in found} == {("medium", True)}


def test_columns_of_parquet_may_come_in_any_order_beside_others(tmp_path: Path, run: Run) -> None:
    columns = columns_of(run)
    frame = pd.DataFrame(columns)
    frame["mass"] = 1.0
    frame[sorted(frame)].to_parquet(tmp_path / "a.parquet")
    sample = read_sample([tmp_path / "a.parquet"])
    np.testing.assert_array_equal(sample.sums, read_sample([columns]).sums)


@pytest.mark.parametrize("order", ["shuffled", "by tracer"])
def test_rows_may_come_in_any_order(run: Run, order: str) -> None:
    data = columns_of(run)
    rows = np.random.default_rng(1).permutation(data["t"].size)
    if order == "by tracer":
        rows = np.argsort(data["id"], kind="stable")
    found = read_sample([{k: v[rows] for k, v in data.items()}])
    np.testing.assert_allclose(moments(found), truth(run), rtol=1e-9)


def test_particles_of_one_type_are_chosen(tmp_path: Path, run: Run) -> None:
    kind = np.where(np.arange(TRACERS) % 4 == 0, 2, 1)
    write_dump(tmp_path / "a.dump", run, kind=kind)
    write_xyz(tmp_path / "a.xyz", run, kind=[f"T{k}" for k in kind])
    (tmp_path / "a.csv").write_text(text_of(columns_of(run) | {"species": np.tile(kind, 4)}))
    part = run[0][:, kind == 2], run[1][:, kind == 2]
    for name, told in (("a.dump", "2"), ("a.xyz", "T2"), ("a.csv", 2)):
        found = read_sample([tmp_path / name], timestep=STEP, type=told)
        np.testing.assert_allclose(moments(found), truth(part), rtol=1e-9, err_msg=name)


def test_several_files_are_several_runs(tmp_path: Path, run: Run) -> None:
    """Labels of one file are not those of another, also where a time is missing in one."""
    data = columns_of(run)
    half = {k: v[data["id"] < 1000] for k, v in data.items()}
    rest = {k: v[data["id"] >= 1000] for k, v in data.items()}
    rest |= {"id": rest["id"] - 1000, "medium": rest["medium"] - 20}
    for name, part in (("a.csv", half), ("b.csv", rest)):
        (tmp_path / name).write_text(text_of(part))
    found = read_sample([tmp_path / "a.csv", tmp_path / "b.csv"])
    np.testing.assert_allclose(moments(found), truth(run), rtol=1e-9)
    assert found.groups == 40
    early = {k: v[half["t"] < 100] for k, v in half.items()}
    (tmp_path / "a.csv").write_text(text_of(early))
    found = read_sample([tmp_path / "a.csv", tmp_path / "b.csv"])
    np.testing.assert_array_equal(found.samples, [2000, 2000, 2000, 1000])
    assert any("1000 of 2000 tracers are missing" in text for text in found.warnings)


def test_units_that_do_not_belong_together_need_the_unit_of_time(run: Run) -> None:
    data = columns_of(run)
    names = {"t": "t [us]", "x": "x [mm]", "y": "y [mm]", "vx": "vx [m/s]", "vy": "vy [m/s]"}
    size = {"t": 2 / 3 * 1e3, "x": 2.0, "y": 2.0, "vx": 3.0, "vy": 3.0}
    other = {names.get(k, k): v * size.get(k, 1) for k, v in data.items()}
    with pytest.raises(InputError, match=r"lengths in mm, speeds in m/s.*--time-unit"):
        read_sample([other], diameter=2.0, speed_unit=3.0)
    told: dict[str, Any] = {"diameter": 2.0, "time_unit": 2 / 3 * 1e3}
    found = read_sample([other], speed_unit=3.0, **told)
    np.testing.assert_allclose(found.times, TIMES)
    np.testing.assert_allclose(moments(found), truth(run), rtol=1e-9)
    for unit in ("mm/us", "mm us^-1"):  # these belong together
        one = {k.replace("m/s", unit): v for k, v in other.items()}
        np.testing.assert_allclose(read_sample([one]).times[-1], other["t [us]"].max())


@pytest.mark.parametrize("stored", [True, False])
def test_a_run_of_the_simulator_has_its_own_averages(tmp_path: Path, stored: bool) -> None:
    every = ("positions", "velocities") if stored else ("speed_histogram",)
    made = simulated(observables=("thermal_speed", "msd", *every))
    made.save(tmp_path / "run.h5")
    files = [tmp_path / "run.h5"]
    if stored:
        made.write_h5md(tmp_path / "run.h5md")
        files.append(tmp_path / "run.h5md")
    for data in (made, *files):
        rows = compare(data, 0.75, 0.04, explain=False).to_dataframe("msd")
        np.testing.assert_allclose(rows["value"], made.msd.value[1:], rtol=1e-9)
        if not stored:  # that of the theory, or of the groups if it is larger; 40 know it to 11 %
            np.testing.assert_allclose(rows["error"], made.msd.error[1:], rtol=0.4)
