"""Tables, dumps and arrays as programs and people write them are read as the run that they hold."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
import pytest
from made_data import SIDE, STEP, TIMES, TRACERS, Run, columns_of, inside
from test_formats import moments, truth

from kinetics.crosscheck.data.reading import read_sample
from kinetics.errors import InputError

SHORT = 300
"""Tracers that are written where many would be slow."""


def table(run: Run) -> pd.DataFrame:
    names = {"t": "time", "id": "tracer"}
    return pd.DataFrame(columns_of(run)).rename(columns=names).drop(columns="medium")


def first_tracers(run: Run, count: int = SHORT) -> Run:
    return run[0][:, :count], run[1][:, :count]


def require_run(source: Any, run: Run, rtol: float = 1e-9, **arguments: Any) -> Any:
    sample = read_sample([source], **arguments)
    np.testing.assert_allclose(moments(sample), truth(run), rtol=rtol, atol=1e-9)
    return sample


def write(path: Path, text: str, encoding: str = "utf-8") -> Path:
    path.write_bytes(text.encode(encoding))
    return path


def test_a_remark_that_has_names_of_columns_is_no_head(tmp_path: Path, run: Run) -> None:
    remark = "# saved by tracker 2.1, time of recording 12:30, x and y in d\n"
    text = remark + table(run).to_csv(index=False)
    require_run(write(tmp_path / "a.csv", text), run)


def test_an_index_of_pandas_is_passed_over(tmp_path: Path, run: Run) -> None:
    require_run(write(tmp_path / "a.tsv", table(run).to_csv(sep="\t")), run)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
def test_encodings_of_spreadsheets(tmp_path: Path, run: Run, encoding: str) -> None:
    _, rest = table(run).to_csv(index=False, sep=";").split("\n", 1)
    head = "sep=;\ntime [s];x [µm];y [µm];vx [µm/s];vy [µm/s];tracer\n"
    text = head + rest
    require_run(write(tmp_path / "a.csv", text, encoding), run)


def test_blanks_separate_columns(tmp_path: Path, run: Run) -> None:
    text = table(run).to_string(index=False)
    require_run(write(tmp_path / "a.txt", text), run, rtol=1e-4)


def test_decimal_commas(tmp_path: Path, run: Run) -> None:
    text = table(run).to_csv(index=False, sep=";", decimal=",")
    file = write(tmp_path / "a.csv", text)
    require_run(file, run, decimal=",")
    with pytest.raises(InputError, match="--decimal ,"):
        read_sample([file])


def test_the_heads_of_trackmate(tmp_path: Path, run: Run) -> None:
    """Four lines of heads; ID is of a row, TRACK_ID of a tracer."""
    frame = table(run)
    names = ["LABEL", "ID", "TRACK_ID", "POSITION_X", "POSITION_Y", "POSITION_T", "vx", "vy"]
    columns = [frame.index, frame.index, frame.tracer, frame.x, frame.y, frame.time]
    columns += [frame.vx, frame.vy]
    made = pd.DataFrame(dict(zip(names, columns, strict=True)))
    first, rest = made.to_csv(index=False).split("\n", 1)
    heads = "Label,Spot ID,Track ID,X,Y,T,,\nLabel,Spot ID,Track ID,X,Y,T,,\n,,,(d),(d),(s),,\n"
    require_run(write(tmp_path / "a.csv", f"{first}\n{heads}{rest}"), run)


def test_frames_of_trackpy_need_the_time_between_frames(run: Run) -> None:
    frame = table(run).rename(columns={"tracer": "particle"})
    frame["frame"] = np.round(frame.pop("time") / STEP).astype(int)
    require_run({name: frame[name] for name in frame}, run, frame_interval=STEP)
    with pytest.raises(InputError, match="frame_interval"):
        read_sample([{name: frame[name] for name in frame}])


def test_absolute_positions_from_a_first_frame_that_is_not_0(run: Run) -> None:
    frame = table(run)
    frame["time"] += 1.0
    sample = require_run({name: frame[name] for name in frame}, run)
    assert sample.times[0] == 0.0
    assert any("first time" in text for text in sample.warnings)


def test_a_dump_of_each_step_is_one_run(tmp_path: Path, run: Run) -> None:
    frame = table(run)
    files = []
    for index, time in enumerate(TIMES):
        rows = frame[frame.time == time].sample(frac=1.0, random_state=index)
        rows.to_csv(tmp_path / f"step{index}.csv", index=False)
        files.append(tmp_path / f"step{index}.csv")
    sample = read_sample(files)
    np.testing.assert_allclose(moments(sample), truth(run), rtol=1e-9)


def test_matlab_files(tmp_path: Path, run: Run) -> None:
    from scipy.io import savemat

    frame = table(run)
    savemat(tmp_path / "a.mat", {name: frame[name].to_numpy() for name in frame})
    require_run(tmp_path / "a.mat", run)


def h5md(path: Path, run: Run, **elements: Any) -> Path:
    place = elements.pop("place", run[0])
    boundary = elements.pop("boundary", ["none"] * 2)
    edges = elements.pop("edges", None)
    with h5py.File(path, "w") as file:
        file.create_group("h5md").attrs["version"] = [1, 1]
        group = file.create_group("particles/all")
        group.create_group("box").attrs["boundary"] = np.array(boundary, "S8")
        if edges is not None:
            group["box/edges"] = edges
        for name, values in (("position", place), ("velocity", run[1]), *elements.items()):
            group[f"{name}/value"] = values
            group[f"{name}/time"] = TIMES
    return path


def test_h5md_edges_may_be_a_matrix(tmp_path: Path, run: Run) -> None:
    folded, image = inside(run)
    edges = np.diag([SIDE, SIDE])
    boundary = ["periodic"] * 2
    file = h5md(tmp_path / "a.h5", run, place=folded, boundary=boundary, edges=edges, image=image)
    require_run(file, run)


def test_h5md_position_without_its_image_is_missing(tmp_path: Path, run: Run) -> None:
    missing = -9999
    folded, image = inside(run)
    image[2, 0] = missing
    file = h5md(
        tmp_path / "a.h5",
        run,
        place=folded,
        boundary=["periodic"] * 2,
        edges=[SIDE, SIDE],
        image=image,
    )
    with h5py.File(file, "a") as opened:
        opened["particles/all/image/value"].attrs["_FillValue"] = missing
    sample = read_sample([file])
    np.testing.assert_array_equal(sample.samples, [TRACERS, TRACERS, TRACERS - 1, TRACERS])


def test_h5md_positions_that_leave_a_periodic_box_are_unwrapped(tmp_path: Path, run: Run) -> None:
    file = h5md(tmp_path / "a.h5", run, boundary=["periodic"] * 2, edges=[SIDE, SIDE])
    require_run(file, run)


def test_h5md_times_may_be_an_increment(tmp_path: Path, run: Run) -> None:
    times = np.arange(4) * 5.0
    with h5py.File(h5md(tmp_path / "a.h5", run), "a") as file:
        for name in ("position", "velocity"):
            del file[f"particles/all/{name}/time"]
            file[f"particles/all/{name}/time"] = 5.0
    sample = read_sample([tmp_path / "a.h5"])
    np.testing.assert_allclose(sample.times, times)


def test_only_axes_that_are_used_count_as_periodic(tmp_path: Path, run: Run) -> None:
    flat = np.zeros((*run[0].shape[:2], 1))
    place = np.concatenate([run[0], flat], axis=2)
    velocity = np.concatenate([run[1], flat], axis=2)
    boundary = ["none", "none", "periodic"]
    file = h5md(tmp_path / "a.h5", (place, velocity), boundary=boundary, edges=[50.0, 50.0, 1.0])
    require_run(file, run)


def close_frames(run: Run) -> tuple[np.ndarray, Run]:
    """Frames so close that no tracer goes half a box between them: those of free flights."""
    times = np.arange(4) * 2.0
    place = run[0][0] + times[:, None, None] * run[1][0]
    return times, (place, np.repeat(run[1][:1], 4, axis=0))


@pytest.mark.parametrize("kind", ["xyz", "gsd"])
def test_wrapped_positions_are_unwrapped_where_that_is_certain(
    tmp_path: Path, run: Run, kind: str
) -> None:
    times, (place, velocity) = close_frames(first_tracers(run))
    folded = place - SIDE * np.floor(place / SIDE + 0.5)
    if kind == "xyz":
        file = wrapped_xyz(tmp_path / "a.xyz", times, folded, velocity)
    else:
        file = gsd_frames(tmp_path / "a.gsd", times, folded, [velocity[0]] * 4)
    sample = read_sample([file], timestep=1.0)
    np.testing.assert_allclose(moments(sample), truth((place, velocity)), rtol=1e-4)


def wrapped_xyz(path: Path, times: Any, place: Any, velocity: Any) -> Path:
    lines = []
    for time, r, v in zip(times, place, velocity, strict=True):
        lattice = f'Lattice="{SIDE} 0 0 0 {SIDE} 0 0 0 1" pbc="T T F"'
        lines += [str(len(r)), f"{lattice} Properties=id:I:1:pos:R:2:velo:R:2 Time={time:g}"]
        rows = np.column_stack([np.arange(len(r)), r, v])
        lines += [" ".join(map(repr, row)) for row in rows.tolist()]
    text = "\n".join(lines).replace(".0 ", " ")
    return write(path, text + "\n")


def gsd_frames(path: Path, times: Any, place: Any, velocities: list[Any]) -> Path:
    hoomd = pytest.importorskip("gsd.hoomd")
    with hoomd.open(str(path), "w") as file:
        for time, r, v in zip(times, place, velocities, strict=True):
            frame = hoomd.Frame()
            frame.configuration.step = int(time)
            frame.configuration.dimensions = 2
            frame.configuration.box = [SIDE, SIDE, 0, 0, 0, 0]
            frame.particles.N = len(r)
            frame.particles.position = np.column_stack([r, np.zeros(len(r))])
            if v is not None:
                # the file leaves out what is as in the first frame
                still = 1.0 + 1e-6 * time
                frame.particles.velocity = np.column_stack([still * v, np.zeros(len(r))])
            file.append(frame)
    return path


def test_velocities_that_a_frame_of_gsd_does_not_state_are_missing(
    tmp_path: Path, run: Run
) -> None:
    times, (place, velocity) = close_frames(first_tracers(run))
    stated = [velocity[0], None, velocity[0], None]
    sample = read_sample([gsd_frames(tmp_path / "a.gsd", times, place, stated)], timestep=1.0)
    np.testing.assert_array_equal(sample.times, times[[0, 2]])


def test_exchanged_tracers_are_named(run: Run) -> None:
    place, velocity = run[0].copy(), run[1].copy()
    order = np.arange(TRACERS)
    order[:100] = np.roll(order[:100], 1)
    place[2:], velocity[2:] = place[2:][:, order], velocity[2:][:, order]
    sample = read_sample([{"times": TIMES, "positions": place, "velocities": velocity}])
    assert any("impossible" in text and "exchanged" in text for text in sample.warnings)
    clean = read_sample([{"times": TIMES, "positions": run[0], "velocities": run[1]}])
    assert not any("impossible" in text for text in clean.warnings)


def test_more_times_than_are_used_are_thinned(run: Run) -> None:
    times = np.arange(1000.0)
    v = run[1][0, :20]
    place = times[:, None, None] * v
    velocity = np.broadcast_to(v, place.shape)
    sample = read_sample([{"times": times, "positions": place, "velocities": velocity}])
    assert sample.times[0] == 0.0
    assert sample.times[-1] == 999.0
    assert sample.times.size <= 400
    assert any("1000 times" in text for text in sample.warnings)


def test_names_of_columns_that_only_the_user_knows(tmp_path: Path, run: Run) -> None:
    names = {"time": "zeit", "x": "lage_a", "y": "lage_b", "vx": "tempo_a", "vy": "tempo_b"}
    frame = table(run).rename(columns=names | {"tracer": "nummer"})
    columns = {ours: theirs for ours, theirs in (names | {"tracer": "nummer"}).items()}
    frame.to_csv(tmp_path / "a.csv", index=False)
    require_run(tmp_path / "a.csv", run, columns=columns)


def test_an_empty_cell_at_the_end_of_each_row_moves_no_name(tmp_path: Path, run: Run) -> None:
    head, *rows = table(run).to_csv(index=False).splitlines()
    text = "\n".join([head, *(f"{row}," for row in rows)])
    require_run(write(tmp_path / "a.csv", text + "\n"), run)


def test_labels_may_hold_the_sign_of_a_comment(tmp_path: Path, run: Run) -> None:
    frame = table(run)
    frame["tracer"] = [f"run#{label}" for label in frame.tracer]
    frame[["tracer", "time", "x", "y", "vx", "vy"]].to_csv(tmp_path / "a.csv", index=False)
    require_run(tmp_path / "a.csv", run)


def test_rows_without_a_number_at_first_are_no_heads(tmp_path: Path, run: Run) -> None:
    frame = table(run)
    frame.loc[0, ["x", "y", "vx", "vy"]] = np.nan
    frame.to_csv(tmp_path / "a.csv", index=False, na_rep="NA")
    sample = read_sample([tmp_path / "a.csv"])
    np.testing.assert_array_equal(sample.samples, [TRACERS - 1] * 4)


def test_a_gap_does_not_exchange_tracers_without_labels(run: Run) -> None:
    frame = table(run).drop(columns="tracer")
    whole = read_sample([{name: frame[name] for name in frame}], positions="displacement")
    frame.loc[2 * TRACERS + 7, "x"] = np.nan
    gap = read_sample([{name: frame[name] for name in frame}], positions="displacement")
    differs = np.any(whole.sums != gap.sums, axis=(1, 2))
    assert np.count_nonzero(differs) == 1


def test_time_stamps_stay_apart(run: Run) -> None:
    frame = table(run)
    frame["time"] += 1.7e9
    require_run({name: frame[name] for name in frame}, run)
