"""Numerical methods without physics; imports nothing of this project. Begin with `chebyshev.py`.

- `chebyshev`: polynomials through Chebyshev points, on one interval and on many panels
- `blocks`: equations of many blocks, each of which knows its neighbours
- `gauss`: Gauss-Legendre quadrature
- `log_grid`: equidistant nodes in the logarithm of the speed, and Fourier sums on them
- `refinement`: finer resolutions until two of them agree
- `recurrence`: solutions of G(z+1) = r(z) G(z)
"""

import math
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

ROUNDING = float(np.finfo(float).eps)
FOLDS = 4.0 - math.log(ROUNDING)  # 40: e^-40 = 4e-18 is nothing beside 1
LARGEST_LOG = math.log(float(np.finfo(float).max))  # 709.8: e to more than that overflows

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
BoolArray = NDArray[np.bool_]
NumberArray = NDArray[np.inexact[Any]]  # real or complex

P = ParamSpec("P")
T = TypeVar("T")


def one_blas_thread(function: Callable[P, T]) -> Callable[P, T]:
    """The function; while it runs, BLAS uses one thread in the whole process.

    More would wait for each other: the matrices of a solve are small. Finding the libraries takes
    about a millisecond: for functions that take much longer.
    """

    @wraps(function)
    def limited(*arguments: P.args, **keywords: P.kwargs) -> T:
        from threadpoolctl import threadpool_limits

        with threadpool_limits(limits=1, user_api="blas"):
            return function(*arguments, **keywords)

    return limited
