"""Equations of many blocks, each of which is coupled to its two neighbours, by elimination.

Begin with `BlockElimination`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve

from kinetics.numerics import FloatArray, NumberArray

#: Maps the number of a block to a matrix, shape (n, n).
Block = Callable[[int], NumberArray]


@dataclass(frozen=True, eq=False)
class EliminatedBlocks:
    """One or two blocks that were eliminated together.

    Parameters
    ----------
    begin, end : they are the blocks begin ... end - 1
    factors : the LU factors of their matrix, and its pivots
    response : their solution to the last block below them, shape (n_rows, n); None without coupling
    onto_below : how the block `begin` acts on the block below it, shape (n, n); None without that
    """

    begin: int
    end: int
    factors: tuple[NumberArray, NumberArray]
    response: NumberArray | None
    onto_below: NumberArray | None

    def solve(self, right: NumberArray) -> NumberArray:
        """Solve for these blocks alone."""
        solution: NumberArray = lu_solve(self.factors, right, check_finite=False)
        return solution


class BlockElimination:
    """Rows below(m) f_(m-1) + own(m) f_m + above(m) f_(m+1) = source_m, m from first to last.

    Blocks are eliminated from the last one down, two at a time: one alone may be a bad pivot.

    Parameters
    ----------
    first, last : numbers of the blocks
    own, below, above : map a block to its matrices, shape (n, n)
    coupled : whether neighbours are coupled; if not, each block is solved alone
    border : a row and a column (n,) that are added to the first block, where it is singular
    """

    def __init__(
        self,
        first: int,
        last: int,
        own: Block,
        below: Block,
        above: Block,
        coupled: bool = True,
        border: tuple[FloatArray, FloatArray] | None = None,
    ) -> None:
        self.first = first
        self.last = last
        self._is_bordered = border is not None
        self._eliminated: list[EliminatedBlocks] = []
        blocks_at_once = 2 if coupled else 1
        schur: NumberArray | float = 0.0
        end = last + 1
        while end > first:
            begin = max(first, end - blocks_at_once)
            matrix: NumberArray = own(end - 1) - schur
            n = len(matrix)
            if end - begin == 2:
                matrix = np.block([[own(begin), above(begin)], [below(end - 1), matrix]])
            if border is not None and begin == first:
                matrix = _with_border(matrix, *border)
            factors = lu_factor(matrix, overwrite_a=True, check_finite=False)
            response = None
            onto_below = None
            if coupled and begin > first:
                right = np.zeros((len(matrix), n), dtype=matrix.dtype)
                right[:n] = below(begin)
                response = lu_solve(factors, right, overwrite_b=True, check_finite=False)
                onto_below = above(begin - 1)
                schur = onto_below @ response[:n]
            blocks = EliminatedBlocks(begin, end, factors, response, onto_below)
            self._eliminated.append(blocks)
            end = begin

    def solve(self, source: NumberArray, last_row: float = 0.0) -> NDArray[Any]:
        """Return f, shape (n_blocks, n); real where the blocks and the source are.

        Parameters
        ----------
        source : of the blocks, shape (n_blocks, n)
        last_row : of the row of the border
        """
        matrix_type = self._eliminated[0].factors[0].dtype
        f = np.array(source, dtype=np.result_type(source, matrix_type))
        n = f.shape[1]
        alone = []
        for blocks in self._eliminated:
            begin = blocks.begin - self.first
            right = f[begin : blocks.end - self.first].ravel()
            if self._is_bordered and begin == 0:
                right = np.append(right, last_row)
            solution = blocks.solve(right)
            alone.append(solution)
            if blocks.onto_below is not None:
                f[begin - 1] -= blocks.onto_below @ solution[:n]
        for blocks, solution in zip(reversed(self._eliminated), reversed(alone), strict=True):
            begin = blocks.begin - self.first
            end = blocks.end - self.first
            if blocks.response is not None:
                solution = solution - blocks.response @ f[begin - 1]
            f[begin:end] = solution[: (end - begin) * n].reshape(-1, n)
        return f


def _with_border(matrix: NumberArray, row: FloatArray, column: FloatArray) -> NumberArray:
    """Return the matrix with a row and a column (n,) added, for the first n rows and columns."""
    bordered = np.pad(matrix, ((0, 1), (0, 1)))
    bordered[-1, : row.size] = row
    bordered[: column.size, -1] = column
    return bordered
