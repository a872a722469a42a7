"""Numerical methods without physics; imports nothing of this project. Begin with `chebyshev`.

- `chebyshev`: polynomials through Chebyshev points, on one interval and on equal panels
- `panel_shifts`: averages of f(x - shift) over many shifts, on equal panels
- `blocks`: equations of many blocks, each of which is coupled to its neighbours
- `gauss`: Gauss-Legendre quadrature
- `log_grid`: equidistant nodes in the logarithm of the speed, and Fourier sums on them
- `refinement`: finer resolutions until two of them agree
- `recurrence`: solutions of G(z+1) = r(z) G(z)
- `cache`: results that are kept, for threads
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from threading import Lock
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from threadpoolctl import LibController

#: The relative spacing of doubles, 2.2e-16.
ROUNDING = float(np.finfo(float).eps)
#: e-folds after which nothing is left beside 1: 40, as e^-40 = 4e-18.
FOLDS = 4.0 - math.log(ROUNDING)
#: ln of the largest double, 709.8: e to more than that overflows.
LARGEST_LOG = math.log(float(np.finfo(float).max))

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
BoolArray = NDArray[np.bool_]
#: Real or complex numbers.
NumberArray = NDArray[np.inexact[Any]]

P = ParamSpec("P")
T = TypeVar("T")


def one_blas_thread(function: Callable[P, T]) -> Callable[P, T]:
    """Return the function so that, while it runs, BLAS uses one thread in the whole process.

    More would wait for each other: the matrices of a solve are small. Finding the libraries takes
    about a millisecond: for functions that take much longer.
    """

    @wraps(function)
    def limited(*arguments: P.args, **keywords: P.kwargs) -> T:
        with _BLAS_LIMIT.held():
            return function(*arguments, **keywords)

    return limited


class _SharedBlasLimit:
    """One thread for BLAS while any thread of the process is inside `held`.

    The first one that enters remembers the number of threads, and the last one that leaves restores
    it: each by itself would restore the one thread that it found while another one was inside.
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self._users = 0
        self._threads_before: dict[str, int] = {}

    @contextmanager
    def held(self) -> Iterator[None]:
        """Limit the threads of BLAS, and restore their number when nobody needs the limit."""
        from threadpoolctl import ThreadpoolController

        libraries = ThreadpoolController().select(user_api="blas").lib_controllers
        with self._lock:
            own_before = {library.filepath: library.get_num_threads() for library in libraries}
            self._users += 1
            for library in libraries:
                self._threads_before.setdefault(library.filepath, own_before[library.filepath])
                _set_threads(library, 1)
        try:
            yield
        finally:
            with self._lock:
                self._users -= 1
                for library in libraries:
                    if _is_limited_by_thread(library):
                        _set_threads(library, own_before[library.filepath])
                    elif self._users == 0:
                        _set_threads(library, self._threads_before[library.filepath])
                if self._users == 0:
                    self._threads_before.clear()


def _is_limited_by_thread(library: LibController) -> bool:
    """Return whether a limit holds in the thread alone that sets it, as those of OpenMP do."""
    return getattr(library, "threading_layer", "") == "openmp"


def _set_threads(library: LibController, number: int) -> None:
    """Set the number of threads of a library, whichever thread has set it before."""
    # From threadpoolctl 3.8 on, only the thread that was the first can, until it gives that up.
    give_up = getattr(library, "clear_controlling_thread", None)
    if give_up is not None:
        give_up(force=True)
    library.set_num_threads(number)
    if give_up is not None:
        give_up()


_BLAS_LIMIT = _SharedBlasLimit()
