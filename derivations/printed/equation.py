"""One printed equation: its label, the paper's LaTeX of it, and its transcription into sympy."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..typesetting import latex, mathml


@dataclass(frozen=True)
class PrintedEquation:
    """An equation as it is stated, misprints included.

    ``source`` is the paper's LaTeX of it, empty where the paper has none (a figure, a result
    beyond the paper). ``formula`` is its transcription: an ``Eq``, a relation, or a ``Tuple`` of
    equations where several are chained or listed; None where there is nothing to transcribe.
    """

    label: str
    title: str
    section: str
    source: str = ""
    formula: sp.Basic | None = None

    @property
    def latex(self) -> str:
        """The transcription as LaTeX (no delimiters); empty if there is none."""
        return latex(self.formula)

    @property
    def mathml(self) -> str:
        """The transcription as MathML, one ``<math>`` element per equation; empty if none."""
        return mathml(self.formula)


class Section:
    """Collects the equations of one part of the paper."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.equations: list[PrintedEquation] = []

    def add(
        self, label: str, title: str, source: str = "", formula: sp.Basic | None = None
    ) -> None:
        """Record one labelled equation."""
        self.equations.append(PrintedEquation(label, title, self.name, source, formula))
