"""Derivations with sympy: what the paper prints, re-derived and judged.

``verify()`` gives one :class:`Check` per labelled equation of the paper; nothing heavy is imported
before it is called.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .derived.record import Check, Status
    from .output.latex_document import to_json, to_latex_document, to_text
    from .verdicts.checks import report_subset, verify

__all__ = [
    "Check",
    "Status",
    "report_subset",
    "to_json",
    "to_latex_document",
    "to_text",
    "verify",
]

_HOME = {
    "Check": "derived.record",
    "Status": "derived.record",
    "report_subset": "verdicts.checks",
    "to_json": "output.latex_document",
    "to_latex_document": "output.latex_document",
    "to_text": "output.latex_document",
    "verify": "verdicts.checks",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f".{_HOME[name]}", __name__), name)
