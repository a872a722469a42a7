"""The paper as transcribed, and the other statements that are judged; nothing is corrected here.

What the paper gets wrong is wrong here. ``paper.tex`` holds every label, its title and the paper's
LaTeX of it; the files of the sections transcribe the same equations into sympy, and a test holds
each transcription against its LaTeX. ``beyond_the_paper`` and
``finite_density`` state the results that the paper does not have.

May import: ``symbols``, ``formal``, ``typesetting``; never ``derived``. Begin reading with
``paper.tex``.

A new row of derivations: state it here, in ``beyond_the_paper`` or
``finite_density`` (its label starts with
``beyond:``); or in ``paper.tex`` and in the file of its section, if the paper prints it. Then
derive it by a function under ``@derives(label)`` in :mod:`derivations.derived`.
"""

from __future__ import annotations

from importlib.resources import files

from . import (
    appendix_a,
    appendix_b,
    appendix_c,
    appendix_d,
    beyond_the_paper,
    cooling,
    finite_density,
    position,
    random_walk,
    stability,
    transport,
    uniform_field,
)
from .equation import PrintedEquation, read_equations

_FORMULAS = (
    cooling.FORMULAS
    | random_walk.FORMULAS
    | transport.FORMULAS
    | position.FORMULAS
    | appendix_a.FORMULAS
    | appendix_b.FORMULAS
    | stability.FORMULAS
    | appendix_c.FORMULAS
    | appendix_d.FORMULAS
)
_PAPER = read_equations(
    files(__name__).joinpath("paper.tex").read_text(encoding="utf-8"), _FORMULAS
)
_BY_LABEL = {equation.label: equation for equation in _PAPER}

PRINTED = {
    label: equation for label, equation in _BY_LABEL.items() if not label.startswith("statement:")
}
"""The paper's equations and figures, in its order."""

ROWS = (
    PRINTED
    | beyond_the_paper.EQUATIONS
    | finite_density.EQUATIONS
    | uniform_field.EQUATIONS
    | _BY_LABEL
)
"""Every row: the paper's labels in its order, what lies beyond it, and its statements in words."""


def printed_equation(label: str) -> PrintedEquation:
    """The equation with this label, as it is stated; nothing is derived.

    Raises ValueError for a label that does not exist.
    """
    if not isinstance(label, str) or label not in ROWS:
        got = repr(label[:60]) if isinstance(label, str) else f"a {type(label).__name__}"
        raise ValueError(
            f"label: got {got}; it must be one of the {len(ROWS)} rows, such as 'sonine9', "
            "'taun#2' or 'beyond:a2' (verify() gives them all)"
        )
    return ROWS[label]


__all__ = ["PRINTED", "ROWS", "PrintedEquation", "printed_equation"]
