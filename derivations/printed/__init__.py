"""The paper as transcribed, and the other statements that are judged; nothing is corrected here.

H.-D. Kim and H. Hayakawa, "Statistical Properties of Inelastic Lorentz Gas". What the paper gets
wrong is wrong here. A label that the paper uses twice has a number: ``taun#2`` is its second
``taun``. ``beyond_the_paper`` states the results that the paper does not have, ``statements`` the
paper's claims in words; their labels start with ``beyond:`` and ``statement:``.

May import: ``symbols``, ``formal``, ``typesetting``; never ``derived``. Begin reading with
``equation``, then any section of the paper.

A new row: state it in the file of its section here, and derive it by a function under
``@derives(label)`` in :mod:`derivations.derived`.
"""

from __future__ import annotations

from . import (
    appendix_a,
    appendix_b,
    appendix_c,
    appendix_d,
    beyond_the_paper,
    cooling,
    figures,
    position,
    random_walk,
    stability,
    statements,
    transport,
)
from .equation import PrintedEquation, Section

_PAPER = (
    cooling,
    random_walk,
    transport,
    position,
    appendix_a,
    appendix_b,
    stability,
    appendix_c,
    appendix_d,
    figures,
)


def _by_label(*sections: Section) -> dict[str, PrintedEquation]:
    return {equation.label: equation for section in sections for equation in section.equations}


PRINTED = _by_label(*(part.SECTION for part in _PAPER))
"""The paper's equations and figures, in its order."""

ROWS = PRINTED | _by_label(beyond_the_paper.SECTION, statements.SECTION)
"""Every row: the paper's labels in its order, what lies beyond it, and its statements."""


def printed_equation(label: str) -> PrintedEquation:
    """The equation with this label, as it is stated; nothing is derived.

    Raises ValueError for a label that does not exist.
    """
    if label not in ROWS:
        raise ValueError(
            f"label: got {label!r}; it must be one of the {len(ROWS)} rows, such as 'sonine9', "
            "'taun#2' or 'beyond:a2' (verify() gives them all)"
        )
    return ROWS[label]


__all__ = ["PRINTED", "ROWS", "PrintedEquation", "printed_equation"]
