"""How fast this machine does one thing and nothing else: what floors are made of.

Each rate is measured once in a process, when it is asked for, on data that stay in the cache.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

_SECONDS = 0.05  # of measuring each rate
_SIDE = 1024  # rows of the arrays


def _best(work: Callable[[], Any], amount: float) -> float:
    """Amount per second of processor time, in the quickest of the repeats."""
    work()
    least, spent = float("inf"), 0.0
    while spent < _SECONDS:
        begin = time.process_time()
        for _ in range(8):
            work()
        took = (time.process_time() - begin) / 8
        least, spent = min(least, took), spent + 8 * took
    return amount / max(least, 1e-9)


class Rates:
    """Rates by name, per second."""

    @cache  # noqa: B019 - there is one object
    def per_second(self, name: str) -> float:
        """Of "divisions", "multiply-adds", "exponentials", "solves of 12" (unknowns), ..."""
        kind, _, size = name.partition(" of ")
        kind = kind.lower().replace(" ", "_").replace("-", "_")
        return float(getattr(self, "_" + kind)(size))

    def _divisions(self, _: str) -> float:
        a, out = np.linspace(1.0, 2.0, _SIDE * 16).reshape(_SIDE, 16), np.empty((_SIDE, 16))
        return _best(lambda: np.divide(1.0, a, out=out), a.size)

    def _multiply_adds(self, _: str) -> float:
        """In products of small matrices, as numpy hands them to BLAS."""
        a, b = np.full((_SIDE, 16), 0.5), np.full((16, 16), 0.5)
        out = np.empty((_SIDE, 16))
        return _best(lambda: np.matmul(a, b, out=out), _SIDE * 16 * 16)

    def _exponentials(self, _: str) -> float:
        a, out = np.linspace(-1.0, 1.0, 16 * _SIDE), np.empty(16 * _SIDE)
        return _best(lambda: np.exp(a, out=out), a.size)

    def _products(self, _: str) -> float:
        a = np.linspace(0.5, 2.0, 16 * _SIDE)
        out = np.empty_like(a)
        return _best(lambda: np.multiply(a, a, out=out), a.size)

    def _bessel_functions(self, _: str) -> float:
        from scipy.special import j0

        a = np.linspace(0.0, 100.0, 4 * _SIDE)
        return _best(lambda: j0(a), a.size)

    def _transforms(self, size: str) -> float:
        """Real ones of so many numbers, forty together."""
        a = np.ones((40, int(size)))
        return _best(lambda: np.fft.rfft(a), 40)

    def _solves(self, size: str) -> float:
        """Of dense systems of so many unknowns and one right-hand side more, twenty together."""
        n = int(size)
        matrix = np.linspace(0.0, 1.0, 20 * n * n).reshape(20, n, n) + n * np.eye(n)
        right = np.ones((20, n, n + 1))
        return _best(lambda: np.linalg.solve(matrix, right), 20)

    def _bytes_copied(self, _: str) -> float:
        a, out = np.ones(4 * _SIDE**2), np.empty(4 * _SIDE**2)
        return _best(lambda: np.copyto(out, a), 8.0 * a.size)

    def _cells_searched(self, _: str) -> float:
        cells, turns = _table_of_cells(), 200_000
        return _best(lambda: _compiled()[0](cells, turns), turns)

    def _bounces(self, _: str) -> float:
        turns = 200_000
        return _best(lambda: _compiled()[1](turns), turns)


def _table_of_cells() -> Any:
    """Slots of 64 cells with five scatterers each, the others empty, as the simulator has them."""
    from particles.compiled.search import SLOTS
    from particles.grid.cells import EMPTY

    slots = np.full((64, 2 * SLOTS), EMPTY)
    rng = np.random.default_rng(1)
    slots[:, :5] = rng.uniform(-5.0, 5.0, (64, 5))
    slots[:, SLOTS : SLOTS + 5] = rng.uniform(-5.0, 5.0, (64, 5))
    return slots


@cache
def _compiled() -> tuple[Any, Any]:
    """Loops over nothing but the search of a cell, and over nothing but bounces.

    Four at a time that do not wait for one another, as the simulator has its tracers.
    """
    from numba import njit

    from particles.compiled.search import strike
    from particles.events import scatter, touch

    @njit(error_model="numpy")
    def search(slots: Any, turns: int) -> float:
        total = 0.0
        for k in range(turns):
            angle = 0.6 + 1e-7 * k
            path, slot = strike(slots, k & 63, 0.1, -0.2, angle, 0.8)
            total += min(path, 1e3) + slot
        return total

    @njit(error_model="numpy")
    def bounce(turns: int) -> float:
        ux, uy = np.array([0.6, 0.8, 0.0, 1.0]), np.array([0.8, 0.6, 1.0, 0.0])
        total = 0.0
        for k in range(turns):
            a = k & 3
            impact = 0.3 + 1e-7 * k
            x, y = touch(0.2, 0.1, ux[a], uy[a], impact)
            ux[a], uy[a], ratio = scatter(ux[a], uy[a], impact, 0.9)
            total += x + y + ratio
        return total

    return search, bounce


RATES = Rates()
