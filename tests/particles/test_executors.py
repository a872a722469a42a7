"""The same bits on threads, processes and a Dask cluster."""

import multiprocessing
import warnings
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor

import pytest

from particles import (
    OBSERVABLES,
    BoltzmannGrad,
    Ensemble,
    HardDisks,
    HardSpheres,
    Poisson,
    PoissonSpheres,
    simulate,
)

MEDIA = (
    HardDisks(0.05, 800), Poisson(0.1, 400), HardSpheres(0.1, count=500, equilibrate=1),
    PoissonSpheres(0.2, count=500), BoltzmannGrad(0.04), BoltzmannGrad(0.04, dimension=3),
)  # fmt: skip


def run(executor: Executor | None = None, workers: int = 1, seed: int = 8) -> list[Ensemble]:
    return [
        simulate(
            medium, 0.4, times=[0.0, 1.0, 40.0], media=9, tracers=25, seed=seed, workers=workers,
            executor=executor, observables=OBSERVABLES,
        )
        for medium in MEDIA
    ] + [
        simulate(
            medium, 0.4, "rest", [0.0, 2.0, 20.0], media=6, tracers=30, field=0.5, seed=seed,
            depth=3.0, workers=workers, executor=executor,
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


def test_a_dask_cluster(alone: list[Ensemble], dask_executor: Executor) -> None:
    assert run(dask_executor) == alone


def test_an_error_in_a_worker_is_the_callers() -> None:
    with (
        ThreadPoolExecutor(2) as pool,
        pytest.raises(ValueError, match=r"number_density = 0\.65: only \d+ of 17 disks"),
    ):
        simulate(HardDisks(0.65, 17), 0.5, times=[1.0], media=40, executor=pool)
