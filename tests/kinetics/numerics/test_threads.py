"""Solves with small matrices let BLAS use one thread, and give the others back."""

import pytest
import threadpoolctl

from kinetics.numerics import one_blas_thread


def used() -> list[int]:
    return [
        library["num_threads"]
        for library in threadpoolctl.threadpool_info()
        if library["user_api"] == "blas"
    ]


def test_one_thread_meanwhile_and_as_many_as_before_after_an_error() -> None:
    @one_blas_thread
    def fails() -> None:
        assert used()
        assert all(count == 1 for count in used())
        raise KeyError

    with threadpoolctl.threadpool_limits(limits=2, user_api="blas"):
        before = used()
        with pytest.raises(KeyError):
            fails()
        assert used() == before
