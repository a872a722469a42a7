"""What a frame of a trajectory does not state is missing, and boxes are read in all formats."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from camera_data import FRAME_TIMES, Tracks, mean_squares, true_mean_squares

from kinetics.crosscheck.data.reading import read_sample
from kinetics.crosscheck.data.sample import R2, V2, Sample
from kinetics.errors import InputError

SIDE = 60.0
"""Of the box: no tracer goes half of it in a frame, most leave it in the end."""


def wrapped(place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places in the box about the origin, and image flags."""
    image = np.floor(place / SIDE + 0.5)
    return place - SIDE * image, image


def flat(vectors: np.ndarray) -> np.ndarray:
    return np.column_stack([vectors, np.zeros(len(vectors))])


def write_gsd(path: Path, place: Any, velocity: Any, image: Any) -> None:
    """Arrays of each frame; None for what it does not state."""
    hoomd = pytest.importorskip("gsd.hoomd")
    with hoomd.open(str(path), "w") as file:
        for step, (r, v, i) in enumerate(zip(place, velocity, image, strict=True)):
            frame = hoomd.Frame()
            frame.configuration.step = step
            frame.configuration.dimensions = 2
            frame.configuration.box = [SIDE, SIDE, 0, 0, 0, 0]
            frame.particles.N = len(r)
            frame.particles.position = flat(r)
            if v is not None:
                frame.particles.velocity = flat(v)
            if i is not None:
                frame.particles.image = flat(i).astype(int)
            file.append(frame)


def write_xyz(path: Path, place: Any, velocity: Any, boxes: list[str]) -> None:
    lines = []
    for time, r, v, box in zip(FRAME_TIMES, place, velocity, boxes, strict=False):
        names = "id:I:1:pos:R:2" + (":velo:R:2" if v is not None else "")
        lines += [str(len(r)), f"{box} Properties={names} Time={time:g}"]
        rows = np.column_stack([r] if v is None else [r, v]).tolist()
        lines += [f"{k} {' '.join(map(repr, row))}" for k, row in enumerate(rows)]
    path.write_text("\n".join(lines) + "\n")


def lattice(side: float, flags: str | None = "T T F") -> str:
    text = f'Lattice="{side} 0 0 0 {side} 0 0 0 1"'
    return text if flags is None else f'{text} pbc="{flags}"'


def require_displacements(sample: Sample, place: np.ndarray) -> None:
    used = place[np.round(sample.times).astype(int)]
    square = np.sum((used - used[0]) ** 2, axis=2).sum(axis=1)
    np.testing.assert_allclose(sample.sums.sum(axis=0)[:, R2], square, rtol=1e-3)


def test_images_that_only_the_first_frame_of_gsd_states_are_unknown(
    tmp_path: Path, tracks: Tracks
) -> None:
    """HOOMD writes none later unless it is asked to; a reader returns those of the first frame."""
    place = tracks[0][:, :200]
    folded, image = wrapped(place)
    images = [image[0], *[None] * 60]
    write_gsd(tmp_path / "a.gsd", folded, tracks[1][:, :200], images)
    require_displacements(read_sample([tmp_path / "a.gsd"], timestep=1.0), place)


def test_images_of_gsd_are_as_in_the_first_frame_where_others_state_theirs(
    tmp_path: Path, tracks: Tracks
) -> None:
    place = tracks[0][:, :200]
    folded, image = wrapped(place)
    write_gsd(tmp_path / "a.gsd", folded, tracks[1][:, :200], image)
    require_displacements(read_sample([tmp_path / "a.gsd"], timestep=1.0), place)


def test_velocities_that_only_the_first_frame_of_gsd_states_are_not_used(
    tmp_path: Path, tracks: Tracks
) -> None:
    place = tracks[0][:, :200]
    folded, image = wrapped(place)
    velocities = [tracks[1][0, :200], *[None] * 60]
    write_gsd(tmp_path / "a.gsd", folded, velocities, image)
    sample = read_sample([tmp_path / "a.gsd"], timestep=1.0)
    assert not sample.has_velocities
    np.testing.assert_allclose(mean_squares(sample), true_mean_squares(sample, place), rtol=1e-3)


def test_frames_of_xyz_without_velocities_have_none(tmp_path: Path, tracks: Tracks) -> None:
    place = tracks[0][:20, :200]
    velocity = tracks[1][:20, :200]
    stated = [v if step % 2 == 0 else None for step, v in enumerate(velocity)]
    write_xyz(tmp_path / "a.xyz", place, stated, [""] * 20)
    sample = read_sample([tmp_path / "a.xyz"])
    np.testing.assert_array_equal(sample.times, FRAME_TIMES[:20:2])
    square = np.sum(velocity[::2] ** 2, axis=2).sum(axis=1)
    np.testing.assert_allclose(sample.sums.sum(axis=0)[:, V2], square)


@pytest.mark.parametrize("with_velocities", [True, False])
@pytest.mark.parametrize(
    "boxes",
    [[lattice(SIDE)] * 61, [lattice(SIDE), *[""] * 60], [lattice(SIDE, None)] * 61],
    ids=["all frames", "first frame alone", "no flags"],
)
def test_wrapped_positions_of_xyz_are_unwrapped(
    tmp_path: Path, tracks: Tracks, boxes: list[str], with_velocities: bool
) -> None:
    place = tracks[0][:, :200]
    velocity = tracks[1][:, :200] if with_velocities else [None] * 61
    write_xyz(tmp_path / "a.xyz", wrapped(place)[0], velocity, boxes)
    require_displacements(read_sample([tmp_path / "a.xyz"]), place)


def test_a_box_that_changes_is_refused(tmp_path: Path, tracks: Tracks) -> None:
    place = tracks[0][:2, :200]
    boxes = [lattice(SIDE), lattice(SIDE + 1.0)]
    write_xyz(tmp_path / "a.xyz", wrapped(place)[0], [None] * 2, boxes)
    with pytest.raises(InputError, match="box: got one that changes"):
        read_sample([tmp_path / "a.xyz"])


def test_wrapped_positions_of_distant_frames_are_refused(tmp_path: Path, tracks: Tracks) -> None:
    place = tracks[0][[0, 30, 60], :200]
    folded = wrapped(place)[0]
    write_xyz(tmp_path / "a.xyz", folded, [None] * 3, [lattice(SIDE)] * 3)
    with pytest.raises(InputError, match="periodic box"):
        read_sample([tmp_path / "a.xyz"])


def test_image_flags_in_some_frames_of_lammps_are_refused(tmp_path: Path, tracks: Tracks) -> None:
    lines = []
    for step, r in enumerate(wrapped(tracks[0][:2, :200])[0]):
        columns = "id x y ix iy" if step == 0 else "id x y"
        tail = " 0 0" if step == 0 else ""
        lines += ["ITEM: TIMESTEP", str(step), "ITEM: NUMBER OF ATOMS", str(len(r))]
        lines += ["ITEM: BOX BOUNDS pp pp pp", "-30 30", "-30 30", "0 1", f"ITEM: ATOMS {columns}"]
        lines += [f"{k} {x!r} {y!r}{tail}" for k, (x, y) in enumerate(r.tolist())]
    (tmp_path / "a.dump").write_text("\n".join(lines) + "\n")
    with pytest.raises(InputError, match="some frames alone"):
        read_sample([tmp_path / "a.dump"], timestep=1.0)


@pytest.mark.parametrize("step", [1, 30])
def test_a_dump_of_each_step_is_unwrapped_from_one_to_the_next(
    tmp_path: Path, tracks: Tracks, step: int
) -> None:
    place = tracks[0][::step, :200]
    files = []
    for index, r in enumerate(wrapped(place)[0]):
        lines = ["ITEM: TIMESTEP", str(index * step), "ITEM: NUMBER OF ATOMS", str(len(r))]
        lines += ["ITEM: BOX BOUNDS pp pp pp", "-30 30", "-30 30", "0 1", "ITEM: ATOMS id x y"]
        lines += [f"{k} {x!r} {y!r}" for k, (x, y) in enumerate(r.tolist())]
        files.append(tmp_path / f"{index}.dump")
        files[-1].write_text("\n".join(lines) + "\n")
    if step == 1:
        require_displacements(read_sample(files, timestep=1.0), tracks[0][:, :200])
        return
    with pytest.raises(InputError, match="periodic box"):
        read_sample(files, timestep=1.0)
