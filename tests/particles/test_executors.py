"""The same bits on threads, processes and a Dask cluster."""

import multiprocessing
import warnings
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor

import pytest

from particles import Ensemble, HardDisks, Poisson, simulate


def run(executor: Executor | None = None, workers: int = 1) -> list[Ensemble]:
    return [
        simulate(
            medium, 0.4, times=[1.0, 40.0], media=9, tracers=25, seed=8, workers=workers,
            executor=executor, observables=["positions", "speed_histogram"],
        )
        for medium in (HardDisks(0.05, 800), Poisson(0.1, 400))
    ]  # fmt: skip


@pytest.fixture(scope="module")
def alone() -> list[Ensemble]:
    return run()


def assert_same(a: list[Ensemble], b: list[Ensemble]) -> None:
    for one, other in zip(a, b, strict=True):
        assert one.arrays.keys() == other.arrays.keys()
        for name, array in one.arrays.items():
            assert array.tobytes() == other.arrays[name].tobytes(), name


def test_threads(alone: list[Ensemble]) -> None:
    assert_same(alone, run(workers=2))
    with ThreadPoolExecutor(3) as pool:
        assert_same(alone, run(pool))


@pytest.mark.slow
def test_three_processes(alone: list[Ensemble]) -> None:
    with ProcessPoolExecutor(3, multiprocessing.get_context("spawn")) as pool:
        assert_same(alone, run(pool))


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


def test_a_dask_cluster(alone: list[Ensemble], dask_executor: Executor) -> None:
    assert_same(alone, run(dask_executor))


def test_an_error_in_a_worker_is_the_callers() -> None:
    with (
        ThreadPoolExecutor(2) as pool,
        pytest.raises(ValueError, match=r"number_density = 0\.65: only \d+ of 17 disks"),
    ):
        simulate(HardDisks(0.65, 17), 0.5, times=[1.0], media=40, executor=pool)
