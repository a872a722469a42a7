"""The paper's formulas as printed, keyed by their LaTeX label (``taun#2`` is the second ``taun``).

H.-D. Kim and H. Hayakawa, "Statistical Properties of Inelastic Lorentz Gas". Each entry holds the
LaTeX source of the equation and, apart from it, the transcription into sympy. Nothing here is
corrected: what the paper gets wrong is wrong here.
"""

from __future__ import annotations

from .appendix_b import SECTION as _appendix_b
from .appendix_c import SECTION as _appendix_c
from .entry import Printed, chain, eq
from .transport import SECTION as _transport

PRINTED: dict[str, Printed] = {
    entry.label: entry
    for section in (_transport, _appendix_b, _appendix_c)
    for entry in section.entries
}

__all__ = ["PRINTED", "Printed", "chain", "eq"]
