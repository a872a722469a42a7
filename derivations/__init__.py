"""Derivations with sympy: what the paper prints, derived again and judged.

``verify()`` gives one :class:`Check` per labelled equation of the paper;
``printed_equation(label)`` gives the equation as it is printed and derives nothing. Nothing heavy
is imported before one of them is called.

The rooms, each of which imports only those above it:

- ``symbols``, ``formal``, ``typesetting``: what formulas are made of, and how they are typeset;
- ``printed``: the paper as transcribed, and the results and claims that are judged beside it;
- ``premises``: the collision rule, and the averages over one collision that follow from it;
- ``derived``: one function per label; it never imports ``printed``;
- ``verdicts``: printed against derived;
- ``output``: the verdicts as text, data and a LaTeX document.

This package imports nothing else of the project. Begin reading with ``premises``, then
``derived.sonine``. A new row of derivations: see :mod:`derivations.printed`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .derived.record import Status
    from .output import to_json, to_latex_document, to_text
    from .printed import PrintedEquation, printed_equation
    from .verdicts import Check, report_subset, verify

__all__ = [
    "Check",
    "PrintedEquation",
    "Status",
    "printed_equation",
    "report_subset",
    "to_json",
    "to_latex_document",
    "to_text",
    "verify",
]

_HOME = {
    "Check": "verdicts",
    "PrintedEquation": "printed",
    "Status": "derived.record",
    "printed_equation": "printed",
    "report_subset": "verdicts",
    "to_json": "output",
    "to_latex_document": "output",
    "to_text": "output",
    "verify": "verdicts",
}


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used; ``__version__`` is that of the distribution."""
    if name == "__version__":
        from importlib.metadata import version

        return version("inelastic-lorentz")
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f".{_HOME[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
