"""What one row of the transcription is: an equation of the paper, or a result beyond it."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp


@dataclass(frozen=True)
class Transcription:
    """One equation of the paper in sympy, misprints included.

    ``number`` is the paper's, such as "B15", and empty where the paper gives none; ``label`` is
    that of the paper's LaTeX. Title and LaTeX of the same label stand in ``paper.tex``.
    """

    number: str
    label: str
    formula: sp.Basic


@dataclass(frozen=True)
class Result:
    """One result that the paper does not have: its title, and the equations that it states."""

    label: str
    title: str
    formulas: tuple[sp.Basic, ...]

    @property
    def formula(self) -> sp.Basic:
        """The equation, or a ``Tuple`` of several."""
        if len(self.formulas) == 1:
            return self.formulas[0]
        return sp.Tuple(*self.formulas)
