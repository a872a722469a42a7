"""Caches that threads may share."""

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

from kinetics.numerics.cache import Cache


def test_a_result_is_computed_once() -> None:
    computed: list[int] = []
    cache: Cache[int, int] = Cache(4)

    def square() -> int:
        computed.append(3)
        return 9

    assert [cache.get(3, square), cache.get(3, square)] == [9, 9]
    assert computed == [3]


def test_the_oldest_results_are_dropped_beyond_the_size() -> None:
    cache: Cache[int, int] = Cache(2)
    for key in (1, 2, 3):
        cache.get(key, lambda key=key: key)  # type: ignore[misc]
    assert cache.get(2, lambda: -2) == 2
    assert cache.get(3, lambda: -3) == 3
    assert cache.get(1, lambda: -1) == -1


def test_computing_may_need_other_results_of_the_same_cache() -> None:
    cache: Cache[int, int] = Cache(8)

    def factorial(n: int) -> int:
        if n == 0:
            return 1
        return cache.get(n, lambda: n * factorial(n - 1))

    assert factorial(5) == 120


def test_threads_that_ask_at_once_get_one_object() -> None:
    n_threads = 8
    cache: Cache[str, object] = Cache(4)
    all_compute = Barrier(n_threads)

    def compute() -> object:
        all_compute.wait()
        return object()

    with ThreadPoolExecutor(n_threads) as pool:
        results = list(pool.map(lambda _: cache.get("key", compute), range(n_threads)))
    assert len({id(result) for result in results}) == 1
