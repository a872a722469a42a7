"""The memory of a run is estimated before it is asked for."""

import re
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import particles
from particles import BoltzmannGrad, HardDisks, HardSpheres, PoissonSpheres, arguments, simulate
from particles.placement import build

GOOD: dict[str, Any] = dict(restitution=0.5, times=[1.0, 9.0], media=2, tracers=2)
RAW = ["positions", "velocities", "finals"]


@pytest.mark.parametrize(("changes", "words"), [
    (dict(medium=HardDisks(0.04, 10**12)), "count: got 1000000000000"),
    (dict(medium=HardSpheres(0.04, count=10**12)), "count: got 1000000000000"),
    (dict(media=2 * 10**9), "media: got 2000000000"),
    (dict(media=10**5, tracers=10**7, observables=RAW), "observables: got ['finals'"),
    (dict(times=np.arange(10**6), observables=["speed_histogram"]), "times: got array(["),
])  # fmt: skip
def test_a_run_that_is_too_large_is_refused_with_the_estimate(
    changes: dict[str, Any], words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(arguments, "machine_memory", lambda: 8e9)
    with pytest.raises(ValueError, match=re.escape(words)) as caught:
        simulate(**dict(medium=BoltzmannGrad(0.04)) | GOOD | changes)
    assert re.search(r"about [\d.e+]+ GB of memory, this machine has 8 GB$", str(caught.value))
    assert arguments.machine_memory() > 1e8


@pytest.mark.parametrize("medium", [HardDisks(0.04, 20_000), PoissonSpheres(0.9, count=20_000)])
def test_the_estimate_of_a_configuration_is_what_it_takes(medium: Any) -> None:
    build(medium, np.uint64(1), 0)  # compiled
    tracemalloc.start()
    cells = build(medium, np.uint64(1), 0)
    taken = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert cells is not None
    run = simulate(medium, 0.5, times=[1.0, 2.0], media=1, tracers=50, observables=RAW)
    estimated = arguments.estimate_memory(run.plan, 1)
    assert estimated["count"] == pytest.approx(taken, rel=0.25)
    raw = sum(array.nbytes for name, array in run.arrays.items() if name.startswith("raw"))
    assert estimated["observables"] == 3 * raw


def test_a_file_of_positions_that_does_not_fit_is_refused_unread(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "places.csv"
    path.write_text("x,y\n1,2\n")
    assert particles.Positions.from_csv(path, 8.0).count == 1
    monkeypatch.setattr("particles.media.machine_memory", lambda: 100.0)
    with pytest.raises(ValueError, match=r"places\.csv: .* of memory"):
        particles.Positions.from_csv(path, 8.0)
