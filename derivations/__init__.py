"""Derivations with sympy: what the paper prints, re-derived and judged.

``verify()`` gives one :class:`Check` per labelled equation of the paper; nothing heavy is imported
before it is called.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .output import to_json, to_latex_document, to_text
    from .record import Check, Status
    from .verify import report_subset, verify

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
    "report_subset": "verify",
    "to_json": "output",
    "to_latex_document": "output",
    "to_text": "output",
    "verify": "verify",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    module = import_module(f".{_HOME[name]}", __name__)
    # importing the submodule `verify` binds it here: the function of that name has to win
    globals().update({key: getattr(module, key) for key in _HOME if _HOME[key] == _HOME[name]})
    return globals()[name]
