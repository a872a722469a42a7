"""Files that were made to do harm, their digest included: one line, and nothing is allocated."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import particles.storage.file as files
from particles import Ensemble, Poisson, simulate

OBSERVABLES = ["speed_histogram", "free_path_histogram", "positions", "finals"]


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("saved") / "run.h5"
    simulate(Poisson(0.1, 500), 0.5, times=[2.0], media=3, tracers=4, observables=OBSERVABLES).save(
        path
    )
    return path.read_bytes()


def seal(file: h5py.File) -> None:
    """Give a changed file the digest that fits."""
    arrays: dict[str, np.ndarray] = {}
    file.visititems(
        lambda name, item: arrays.update({name: item[()]} if hasattr(item, "shape") else {})
    )
    done, plan = file.attrs["done"], file.attrs["plan"]
    file.attrs["digest"] = files._digest(plan, done, arrays)


def plan(**changes: Any) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        values = json.loads(file.attrs["plan"])
        values.update(changes)
        file.attrs["plan"] = json.dumps(values)
        seal(file)

    return change


def medium(**changes: Any) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        values = json.loads(file.attrs["plan"])
        values["medium"].update(changes)
        file.attrs["plan"] = json.dumps(values)
        seal(file)

    return change


def attribute(name: str, value: Any) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        file.attrs[name] = value
        if name == "done":
            seal(file)

    return change


def array(name: str, **arguments: Any) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        del file[name]
        if arguments:
            file.create_dataset(name, **arguments)
        else:
            seal(file)

    return change


def new(name: str, value: Any) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        if name in file:
            del file[name]
        file[name] = value
        seal(file)

    return change


def external(file: h5py.File) -> None:
    del file["moments"]
    own = [("moments.raw", 0, 3 * 8 * 8)]
    file.create_dataset("moments", (3, 1, 8), np.float64, external=own)


def elsewhere(file: h5py.File) -> None:
    del file["moments"]
    layout = h5py.VirtualLayout((3, 1, 8), np.float64)
    layout[:] = h5py.VirtualSource("other.h5", "moments", (3, 1, 8))
    file.create_virtual_dataset("moments", layout)


HUGE = dict(shape=(10**12,), dtype=np.float64)
CRAFTED = {
    "1e12 elements": array("moments", **HUGE),
    "1e12 elements, compressed": array("moments", **HUGE, chunks=(10**6,), compression="gzip"),
    "1e12 times": array("plan/times", **HUGE),
    "external storage": external,
    "virtual": elsewhere,
    "objects": array("moments", shape=(3,), dtype=h5py.string_dtype()),
    "done an array": attribute("done", [3, 3]),
    "done a name": attribute("done", "three"),
    "done negative": attribute("done", -1),
    "done too large": attribute("done", 4),
    "version an array": attribute("version", [1, 1]),
    "plan not JSON": attribute("plan", "{"),
    "plan of brackets": attribute("plan", "[" * 9000),
    "digest a number": attribute("digest", 3),
    "no moments": array("moments"),
    "no times": array("plan/times"),
    "more": new("more", np.zeros(3)),
    "moments of another shape": new("moments", np.zeros((3, 2, 8))),
    "moments whole numbers": new("moments", np.zeros((3, 1, 8), np.int64)),
    "histogram of another shape": new("histograms/speed_histogram/sums", np.zeros((3, 1, 9), int)),
    "positions too few": new("raw/positions", np.zeros((1, 3, 2))),
    "restitution 7": plan(restitution=7),
    "restitution a name": plan(restitution="half"),
    "no seed": plan(seed=None),
    "another key": plan(more=3),
    "medium a name": plan(medium="Poisson"),
    "observables": plan(observables=["speed"]),
    "media 0": plan(media=0),
    "another medium": medium(kind="Gas"),
    "density -1": medium(number_density=-1),
    "medium with another key": medium(more=1),
}


@pytest.mark.parametrize("change", CRAFTED.values(), ids=CRAFTED)
def test_crafted_files_are_refused(
    change: Callable[[h5py.File], None], saved: bytes, tmp_path: Path
) -> None:
    path = tmp_path / "run.h5"
    path.write_bytes(saved)
    with h5py.File(path, "r+") as file:
        change(file)
    with pytest.raises(ValueError, match=r"run\.h5: (is damaged|version)") as caught:
        Ensemble.load(path)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300


def test_a_file_sealed_again_is_read(saved: bytes, tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    path.write_bytes(saved)
    before = Ensemble.load(path)
    with h5py.File(path, "r+") as file:
        plan()(file)
    assert Ensemble.load(path) == before
