"""The paper as transcribed, and the other statements that are judged; nothing is corrected here.

What the paper gets wrong is wrong here. ``paper.tex`` holds every label, its title and the paper's
LaTeX of it; ``main_text`` and ``appendices`` transcribe the same equations into sympy, each held
against its LaTeX by a reader apart from them. ``beyond`` states the results that the paper does not
have, under labels that start with ``beyond:``.

May import: ``symbols``, ``formal``, ``printers``; never ``derived``. A new row is stated here and
derived by a function under ``@derives(label)`` in :mod:`derivations.derived`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.resources import files

import sympy as sp

from ..printers import latex, mathml, plain
from . import appendices, beyond, main_text

__all__ = ["PRINTED", "ROWS", "PrintedEquation", "printed_equation", "read_equations"]


@dataclass(frozen=True, repr=False)
class PrintedEquation:
    """An equation as it is stated, misprints included.

    ``source`` is the paper's LaTeX of it, empty where the paper has none (a figure, a result
    beyond the paper). ``formula`` is its transcription: an ``Eq``, a relation, or a ``Tuple`` of
    equations where several are chained or listed; None where there is nothing to transcribe.
    ``latex`` and ``mathml`` are that formula, empty if there is none. ``number`` is the paper's,
    such as "B15", empty where it has none.
    """

    label: str
    title: str
    section: str
    source: str = ""
    formula: sp.Basic | None = None
    number: str = ""
    latex = property(lambda self: latex(self.formula))
    mathml = property(lambda self: mathml(self.formula))

    def __repr__(self) -> str:
        return f"PrintedEquation {self.label!r}: {self.title}: {plain(self.formula)}"

    def _repr_html_(self) -> str:
        return mathml(self.formula)


def read_equations(text: str, formulas: Mapping[str, sp.Basic]) -> Iterator[PrintedEquation]:
    """The equations of a text in the form of ``paper.tex``, each with its transcription."""
    section = ""
    for block in re.split(r"\n(?=%%? )", text):
        head, _, body = block.partition("\n")
        if head.startswith("%% "):
            section = head[3:]
        elif section:
            name, title = head[2:].split(": ", 1)
            label, _, number = name.removesuffix(")").partition(" (")
            source = " ".join(body.split())
            yield PrintedEquation(label, title, section, source, formulas.get(label), number)


_PAPER = {
    equation.label: equation
    for equation in read_equations(
        files(__name__).joinpath("paper.tex").read_text(encoding="utf-8"),
        main_text.FORMULAS | appendices.FORMULAS,
    )
}
_BEYOND = {
    label: PrintedEquation(
        label, title, section, formula=sp.Tuple(*stated) if len(stated) > 1 else stated[0]
    )
    for section, table in (
        ("Beyond the paper", beyond.PAPERS_LAW),
        ("Beyond the paper: any collision law", beyond.ANY_LAW),
        ("Beyond the paper: scatterers with a mass", beyond.MASS_RATIO),
        ("Beyond the paper: finite density", beyond.FINITE_DENSITY),
        ("Beyond the paper: a uniform field", beyond.UNIFORM_FIELD),
        ("Beyond the paper: what drives a tracer", beyond.DRIVEN),
    )
    for label, (title, *stated) in table.items()
}

PRINTED = {label: row for label, row in _PAPER.items() if not label.startswith("statement:")}
"""The paper's equations and figures, in its order."""

ROWS = PRINTED | _BEYOND | _PAPER
"""Every row: the paper's labels in its order, what lies beyond it, and its statements in words."""


_LABELS = {row.number: label for label, row in PRINTED.items() if row.number}


def printed_equation(label: str) -> PrintedEquation:
    """The equation with this label, or number such as "B15", as it is stated; nothing is derived.

    Raises ValueError for a label that does not exist.
    """
    if isinstance(label, str):
        label = _LABELS.get(label, label)
    if not isinstance(label, str) or label not in ROWS:
        got = repr(label[:60]) if isinstance(label, str) else f"a {type(label).__name__}"
        raise ValueError(
            f"label: got {got}; it must be one of the {len(ROWS)} rows, such as 'sonine9', "
            "'taun#2' or 'beyond:a2', or a number such as 'B15' (verify() gives them all)"
        )
    return ROWS[label]
