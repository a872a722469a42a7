"""One printed equation: its label, the paper's LaTeX of it, and its transcription into sympy."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import sympy as sp

from ..typesetting import latex, mathml, plain


@dataclass(frozen=True, repr=False)
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

    def __repr__(self) -> str:
        return f"PrintedEquation {self.label!r}: {self.title}: {plain(self.formula)}"

    def _repr_html_(self) -> str:
        return self.mathml


def read_equations(text: str, formulas: Mapping[str, sp.Basic]) -> Iterator[PrintedEquation]:
    """The equations of a text in the form of ``paper.tex``, each with its transcription.

    Raises ValueError for LaTeX without transcription, and the reverse.
    """
    section = ""
    for block in re.split(r"\n(?=%%? )", text):
        head, _, body = block.partition("\n")
        if head.startswith("%% "):
            section = head[3:]
        elif section:
            label, title = head[2:].split(": ", 1)
            source = " ".join(body.split())
            if bool(source) is not (label in formulas):
                raise ValueError(f"label {label!r}: LaTeX and transcription must both be there")
            yield PrintedEquation(label, title, section, source, formulas.get(label))
