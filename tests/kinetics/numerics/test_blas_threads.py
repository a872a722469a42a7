"""The limit of one BLAS thread while something is solved, and what is restored after."""

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier, Event

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from kinetics.numerics import one_blas_thread


def blas_threads() -> set[int]:
    libraries = threadpool_info()
    return {library["num_threads"] for library in libraries if library["user_api"] == "blas"}


def test_a_solve_uses_one_thread_and_restores_the_others() -> None:
    with threadpool_limits(2, user_api="blas"):
        assert one_blas_thread(blas_threads)() == {1}
        assert blas_threads() == {2}


def test_the_limit_is_restored_whichever_of_two_solves_ends_first() -> None:
    """The second begins while the first one runs, and ends after it."""
    second_has_begun = Event()
    first_has_ended = Event()

    @one_blas_thread
    def first() -> None:
        second_has_begun.wait(10.0)

    @one_blas_thread
    def second() -> set[int]:
        second_has_begun.set()
        first_has_ended.wait(10.0)
        return blas_threads()

    with threadpool_limits(2, user_api="blas"), ThreadPoolExecutor(2) as pool:
        of_first = pool.submit(first)
        of_second = pool.submit(second)
        of_first.result()
        first_has_ended.set()
        assert of_second.result() == {1}
        assert blas_threads() == {2}


def test_errors_in_eight_threads_leave_no_limit() -> None:
    barrier = Barrier(8)

    @one_blas_thread
    def fail() -> None:
        barrier.wait(10.0)
        raise ArithmeticError

    with threadpool_limits(2, user_api="blas"), ThreadPoolExecutor(8) as pool:
        for future in [pool.submit(fail) for _ in range(8)]:
            with pytest.raises(ArithmeticError):
                future.result()
        assert blas_threads() == {2}
