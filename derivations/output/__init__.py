"""The verdicts for readers: plain text, JSON data, a LaTeX document.

May import: all other rooms of ``derivations``. Begin reading with ``text``.
"""

from .latex_document import to_latex_document
from .text import to_json, to_text

__all__ = ["to_json", "to_latex_document", "to_text"]
