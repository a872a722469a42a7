"""The paper as transcribed, and the other statements that are judged; nothing is corrected here.

What the paper gets wrong is wrong here. ``paper.tex`` holds every label, its title and the paper's
LaTeX of it; ``main_text`` and ``appendices`` transcribe the same equations into sympy, one row an
equation, to be read beside the paper. The files ``beyond_...`` state the results that the
paper does not have, under labels that start with ``beyond:``. ``rows`` says what a row is.

May import: ``symbols``, ``formal``, ``printers``; never ``derived``. A new row is stated here and
derived by a function under ``@derives(label)`` in :mod:`derivations.derived`.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.resources import files

import sympy as sp

from ..printers import latex, mathml, plain
from . import (
    appendices,
    beyond_any_law,
    beyond_density,
    beyond_disks,
    beyond_drive,
    beyond_field,
    main_text,
)
from .rows import Result, Transcription

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


def _read_paper() -> dict[str, PrintedEquation]:
    """Return every row of ``paper.tex`` by label, with its transcription."""
    transcriptions: tuple[Transcription, ...] = (*main_text.EQUATIONS, *appendices.EQUATIONS)
    formulas = {row.label: row.formula for row in transcriptions}
    text = files(__name__).joinpath("paper.tex").read_text(encoding="utf-8")
    return {equation.label: equation for equation in read_equations(text, formulas)}


def _read_results() -> dict[str, PrintedEquation]:
    """Return every result beyond the paper by label, with the section that it stands in."""
    equations: dict[str, PrintedEquation] = {}
    for section, results in RESULTS.items():
        for row in results:
            equations[row.label] = PrintedEquation(
                row.label, row.title, section, formula=row.formula
            )
    return equations


RESULTS: dict[str, tuple[Result, ...]] = {
    "Beyond the paper": beyond_disks.SMOOTH_DISKS,
    "Beyond the paper: any collision law": beyond_any_law.ANY_LAW,
    "Beyond the paper: scatterers with a mass": beyond_any_law.MASS_RATIO,
    "Beyond the paper: finite density": beyond_density.FINITE_DENSITY,
    "Beyond the paper: a uniform field": beyond_field.UNIFORM_FIELD,
    "Beyond the paper: what drives a tracer": beyond_drive.DRIVEN,
}
"""The results beyond the paper, by section."""

_PAPER = _read_paper()
_BEYOND = _read_results()

PRINTED = {label: row for label, row in _PAPER.items() if not label.startswith("statement:")}
"""The paper's equations and figures, in its order."""

ROWS = PRINTED | _BEYOND | _PAPER
"""Every row: the paper's labels in its order, what lies beyond it, and its statements in words."""


_LABELS_BY_NUMBER = {row.number: label for label, row in PRINTED.items() if row.number}


def find_label(name: str) -> str | None:
    """Return the label of a row by its label or its number; None where there is none.

    A number may be written as in the paper or as one cites it: "B15", "b15", "(22)", "eq. 22",
    "Eq. (22)", "equation 22". Labels are exact.
    """
    if name in ROWS:
        return name
    words = name.strip().casefold()
    bare = re.sub(r"^(equation|eq\.?)\s*", "", words).strip("() ")
    return _LABELS_BY_NUMBER.get(bare.upper())


def printed_equation(label: str) -> PrintedEquation:
    """The equation with this label, or number such as "B15", as it is stated; nothing is derived.

    Capitals, "eq." and parentheses do not matter in a number: "b15" and "eq. (22)" are found.
    Raises ValueError for a label that does not exist.
    """
    if not isinstance(label, str):
        raise ValueError(f"label: got a {type(label).__name__}; {_ALLOWED}")
    row_label = find_label(label)
    if row_label is None:
        near = difflib.get_close_matches(label.casefold(), [*ROWS, *_LABELS_BY_NUMBER], n=1)
        meant = f"; did you mean {near[0]!r}?" if near else ""
        raise ValueError(f"label: got {label[:60]!r}; {_ALLOWED}{meant}")
    return ROWS[row_label]


_ALLOWED = (
    f"it must be one of the {len(ROWS)} rows, such as 'sonine9', 'taun#2' or 'beyond:a2', or a "
    "number such as 'B15' or 'eq. 22' (verify() gives them all)"
)
