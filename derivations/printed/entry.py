"""One printed formula: its label, the paper's LaTeX of that equation, and its transcription."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp


@dataclass(frozen=True)
class Printed:
    """A formula as the paper prints it, misprints included.

    ``source`` is the LaTeX of the equation (empty for a figure), ``formula`` its transcription:
    an ``Eq``, a relation, or a ``Tuple`` of equations where the paper chains or lists equalities.
    """

    label: str
    title: str
    section: str
    source: str
    formula: sp.Basic | None


class Section:
    """Collects the printed formulas of one part of the paper."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.entries: list[Printed] = []

    def add(self, label: str, title: str, source: str, formula: sp.Basic | None = None) -> None:
        """Record one labelled equation."""
        self.entries.append(Printed(label, title, self.name, source, formula))
