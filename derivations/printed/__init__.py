"""The paper's formulas as printed, keyed by their LaTeX label (``taun#2`` is the second ``taun``).

H.-D. Kim and H. Hayakawa, "Statistical Properties of Inelastic Lorentz Gas". Each entry holds the
LaTeX source of the equation and, apart from it, the transcription into sympy. Nothing here is
corrected: what the paper gets wrong is wrong here.
"""

from __future__ import annotations

from . import (
    appendix_a,
    appendix_b,
    appendix_c,
    appendix_d,
    cooling,
    figures,
    position,
    random_walk,
    stability,
    transport,
)
from .entry import Printed

PRINTED: dict[str, Printed] = {
    entry.label: entry
    for part in (
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
    for entry in part.SECTION.entries
}

__all__ = ["PRINTED", "Printed"]
