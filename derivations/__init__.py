"""Derivations with sympy: what the paper prints, re-derived and judged.

``verify()`` gives one :class:`Check` per labelled equation of the paper; nothing heavy is imported
before it is called.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .output import to_json, to_latex_document, to_text
    from .record import Check, Status
    from .rows import report_subset, verify

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
    "Check": "record",
    "Status": "record",
    "report_subset": "rows",
    "to_json": "output",
    "to_latex_document": "output",
    "to_text": "output",
    "verify": "rows",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f".{_HOME[name]}", __name__), name)
