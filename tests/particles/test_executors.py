"""The same bits on threads, processes and a Dask cluster, and from parts of a run."""

import multiprocessing
import warnings
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

import particles
from particles import BoltzmannGrad, Ensemble, HardDisks, HardSpheres, Poisson, simulate

MEDIA = (
    HardDisks(0.05, 800), Poisson(0.1, 400), HardSpheres(0.1, count=500),
    particles.PoissonSpheres(0.2, count=500), BoltzmannGrad(0.04), BoltzmannGrad(0.04, dimension=3),
)  # fmt: skip


def run(
    executor: Executor | None = None, workers: int = 1, seed: int = 8, **part: Any
) -> list[Ensemble]:
    return [
        simulate(
            medium, 0.4, times=[0.0, 1.0, 40.0], media=9, tracers=25, seed=seed, workers=workers,
            executor=executor, observables=particles.OBSERVABLES, **part,
        )
        for medium in MEDIA
    ] + [
        simulate(
            medium, 0.4, "rest", [0.0, 2.0, 20.0], media=6, tracers=30, field=0.5, seed=seed,
            depth=3.0, workers=workers, executor=executor, **part,
        )
        for medium in (HardDisks(0.3, 200), *MEDIA[-2:])
    ]  # fmt: skip


@pytest.fixture(scope="module")
def alone() -> list[Ensemble]:
    return run()


def test_threads(alone: list[Ensemble]) -> None:
    assert run(workers=3) == alone
    assert all(one != other for one, other in zip(alone, run(seed=9), strict=True))
    with ThreadPoolExecutor(3) as pool:
        assert run(pool) == alone


@pytest.mark.slow
def test_three_processes(alone: list[Ensemble]) -> None:
    with ProcessPoolExecutor(3, multiprocessing.get_context("spawn")) as pool:
        assert run(pool) == alone


@pytest.fixture
def dask_executor() -> Iterator[Executor]:
    distributed = pytest.importorskip("distributed")
    with warnings.catch_warnings():
        # Of the cluster's own making: ports in use, sockets closed late.
        warnings.simplefilter("ignore")
        with (
            distributed.LocalCluster(
                n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
            ) as cluster,
            distributed.Client(cluster) as client,
        ):
            yield client.get_executor()


@pytest.mark.slow
def test_a_dask_cluster(alone: list[Ensemble], dask_executor: Executor) -> None:
    assert run(dask_executor) == alone


def test_parts_are_the_whole_run(alone: list[Ensemble]) -> None:
    parts = [run(part=part) for part in ((4, 4), (1, 2), (3, 4))]
    for whole, *pieces in zip(alone, *parts, strict=True):
        assert sum(piece.media for piece in pieces) == whole.media
        assert Ensemble.merge(pieces) == whole
        for piece in pieces:  # of its own size, in every estimate
            assert piece.missing.min() >= 0
            assert piece.to_dataframe().shape == whole.to_dataframe().shape


SMALL: dict[str, Any] = dict(
    medium=BoltzmannGrad(0.1), restitution=0.5, times=[2.0, 50.0], media=7, tracers=3,
    workers=1, observables=["positions", "velocities"],
)  # fmt: skip


def test_parts_in_files_go_on_and_merge_to_the_same_file(tmp_path: Path) -> None:
    files = [tmp_path / f"{k}.h5" for k in (1, 2, 3)]
    for k, file in enumerate(files, 1):
        with pytest.raises(KeyboardInterrupt):
            simulate(**SMALL, part=(k, 3), output=file, progress=_stop_after_one)
        with pytest.raises(ValueError, match=r"holds 1 of [23] configurations"):
            Ensemble.merge(files[:k])
        with pytest.raises(ValueError, match="another run, with part"):
            simulate(**SMALL, part=(k % 3 + 1, 3), output=file, resume=True)
        simulate(**SMALL, part=(k, 3), output=file, resume=True)
    Ensemble.merge(reversed(files)).save(tmp_path / "merged.h5")
    simulate(**SMALL, output=tmp_path / "whole.h5")
    assert Ensemble.load(files[1]).plan.part == (2, 3)
    assert (tmp_path / "merged.h5").read_bytes() == (tmp_path / "whole.h5").read_bytes()


def _stop_after_one(done: int, total: int) -> None:
    if done == 1:
        raise KeyboardInterrupt


def test_what_does_not_make_a_whole_run_is_refused() -> None:
    one, two, three = (simulate(**SMALL, part=(k, 3)) for k in (1, 2, 3))
    for parts, words in [
        ([one, three], "configuration 2 of 0 to 6 is missing"),
        ([two, three], "configuration 0 of 0 to 6 is missing"),
        ([one, two], "configuration 4 of 0 to 6 is missing"),
        ([one, two, two, three], "configuration 2 is there twice"),
        ([one, two, simulate(**SMALL, part=(2, 2))], "configuration 3 is there twice"),
        ([one, two, simulate(**SMALL | {"restitution": 0.6}, part=(3, 3))], "restitution = 0.6"),
        ([one, simulate(**SMALL | {"seed": 2}, part=(2, 3)), three], "seed = 2"),
        ([], "parts"),
        ("all.h5", "parts"),
    ]:
        with pytest.raises(ValueError, match=words) as refused:
            Ensemble.merge(parts)  # type: ignore[arg-type]
        assert "\n" not in str(refused.value)
    for part in ((0, 3), (4, 3), (1, 8), (1,), 3, (1.0, 2.0), (True, 2), "12"):
        with pytest.raises(ValueError, match=r"^part: got .* 1 <= k <= n <= 7"):
            simulate(**SMALL, part=part)
    assert simulate(**SMALL, part=(1, 1)) == simulate(**SMALL)


def test_an_error_in_a_worker_is_the_callers() -> None:
    with (
        ThreadPoolExecutor(2) as pool,
        pytest.raises(ValueError, match=r"number_density: got 0\.65; only \d+ of 17 disks"),
    ):
        simulate(HardDisks(0.65, 17), 0.5, times=[1.0], media=40, executor=pool)
