"""One thread for the matrices of a solve: they are small, and more threads wait for each other.

On two cores beside other programs, two threads took twice as long as one for the density of the
position, and fourteen times as long for the steady state in a field.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


def one_blas_thread(function: Callable[P, T]) -> Callable[P, T]:
    """The function; while it runs, BLAS uses one thread in the whole process.

    Finding the libraries takes about a millisecond: for functions that take much longer.
    """

    @wraps(function)
    def limited(*arguments: P.args, **keywords: P.kwargs) -> T:
        from threadpoolctl import threadpool_limits

        with threadpool_limits(limits=1, user_api="blas"):
            return function(*arguments, **keywords)

    return limited
