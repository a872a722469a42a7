"""Derivations with sympy: what the paper prints, derived again and judged.

``verify()`` gives one :class:`Check` per labelled equation of the paper;
``printed_equation(label)`` gives the equation as it is printed and derives nothing. Nothing heavy
is imported before one of them is called.

The rooms, each of which imports only those above it:

- ``symbols``, ``formal``, ``printers``: what formulas are made of, and how they are printed;
- ``printed``: the paper as transcribed, and the results and claims that are judged beside it;
- ``premises``: the collision rule, and the averages over one collision that follow from it;
- ``derived``: one derivation per label; it never imports ``printed``;
- ``checks``: printed against derived;
- ``documents``: the checks as text, JSON and LaTeX;
- ``errata``: what is printed wrong, what is right, and what it changes, in words.

This package imports nothing else of the project. Begin reading with ``premises``, then
``derived.sonine``. A new row of derivations: see :mod:`derivations.printed`.
"""

from __future__ import annotations

from threading import RLock
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .checks import Check, report_subset, verify
    from .derived.record import Status, Verdict
    from .documents import to_json, to_latex_document, to_text
    from .errata import ERRATA, Erratum
    from .printed import PrintedEquation, printed_equation

_FILES = {
    "ERRATA": "errata",
    "Erratum": "errata",
    "PrintedEquation": "printed",
    "printed_equation": "printed",
    "Check": "checks",
    "Status": "checks",
    "Verdict": "checks",
    "report_subset": "checks",
    "verify": "checks",
    "to_json": "documents",
    "to_latex_document": "documents",
    "to_text": "documents",
}
"""The public names, each with the file that it is imported from when it is first used."""

__all__ = [
    "ERRATA",
    "Check",
    "Erratum",
    "PrintedEquation",
    "Status",
    "Verdict",
    "printed_equation",
    "report_subset",
    "to_json",
    "to_latex_document",
    "to_text",
    "verify",
]

#: Held while a public name is imported: of two threads that import modules in another order, each
#: would see half of what the other one imports.
_IMPORTING = RLock()


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    from importlib import import_module, metadata

    if name == "__version__":
        try:
            return metadata.version("inelastic-lorentz")
        except metadata.PackageNotFoundError:  # a bare source tree
            return "0+unknown"
    if name in _FILES:
        with _IMPORTING:
            module = import_module(f".{_FILES[name]}", __name__)
        return getattr(module, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
