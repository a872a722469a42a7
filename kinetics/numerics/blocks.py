"""Equations of many blocks, each of which knows its two neighbours, by elimination."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve

from kinetics.numerics import FloatArray

Block = Callable[[int], NDArray[Any]]


class BlockElimination:
    """Rows below(m) f_(m-1) + own(m) f_m + above(m) f_(m+1) = source_m, m from first to last.

    Blocks are eliminated from the last one down, two at a time: one alone may be a bad pivot.

    own, below, above : block -> matrix (n, n)
    coupled : whether neighbours know each other; if not, each block is solved alone
    border : a row and a column (n,) that are added to the first block, where it is singular
    """

    def __init__(
        self, first: int, last: int, own: Block, below: Block, above: Block, coupled: bool = True,
        border: tuple[FloatArray, FloatArray] | None = None,
    ) -> None:  # fmt: skip
        self.first, self.last, self._bordered = first, last, border is not None
        self._factors: list[tuple[int, int, Any, Any, Any]] = []
        schur: Any = 0.0
        end, size = last + 1, 2 if coupled else 1
        while end > first:
            begin = max(first, end - size)
            matrix = own(end - 1) - schur
            n = len(matrix)
            if end - begin == 2:
                matrix = np.block([[own(begin), above(begin)], [below(end - 1), matrix]])
            if border is not None and begin == first:
                matrix = np.pad(matrix, ((0, 1), (0, 1)))
                matrix[-1, :n], matrix[:n, -1] = border
            factors = lu_factor(matrix, overwrite_a=True, check_finite=False)
            response: Any = None
            onto: Any = None
            if coupled and begin > first:
                right = np.zeros((len(matrix), n), dtype=matrix.dtype)
                right[:n] = below(begin)
                response = lu_solve(factors, right, overwrite_b=True, check_finite=False)
                onto = above(begin - 1)
                schur = onto @ response[:n]
            self._factors.append((begin, end, factors, response, onto))
            end = begin

    def solve(self, source: NDArray[Any], last_row: float = 0.0) -> NDArray[Any]:
        """f (n_blocks, n), from a source of this shape; last_row : the source of the border."""
        right = np.array(source, dtype=np.result_type(source, self._factors[0][2][0]))
        n, parts = right.shape[1], []
        for begin, end, factors, _, onto in self._factors:
            given = right[begin - self.first : end - self.first].ravel()
            if self._bordered and begin == self.first:
                given = np.append(given, last_row)
            parts.append(lu_solve(factors, given, check_finite=False))
            if onto is not None:
                right[begin - self.first - 1] -= onto @ parts[-1][:n]
        solved = zip(self._factors[::-1], parts[::-1], strict=True)
        for (begin, end, _, response, _), found in solved:
            k = begin - self.first
            if response is not None:
                found = found - response @ right[k - 1]
            right[k : end - self.first] = found[: (end - begin) * n].reshape(-1, n)
        return right
