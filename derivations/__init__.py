"""Derivations with sympy: what the paper prints, derived again and judged.

``verify()`` gives one :class:`Check` per labelled equation of the paper;
``printed_equation(label)`` gives the equation as it is printed and derives nothing. Nothing heavy
is imported before one of them is called.

The rooms, each of which imports only those above it:

- ``symbols``, ``formal``, ``printers``: what formulas are made of, and how they are printed;
- ``printed``: the paper as transcribed, and the results and claims that are judged beside it;
- ``premises``: the collision rule, and the averages over one collision that follow from it;
- ``derived``: one derivation per label; it never imports ``printed``;
- ``checks``: printed against derived.

This package imports nothing else of the project. Begin reading with ``premises``, then
``derived.sonine``. A new row of derivations: see :mod:`derivations.printed`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .checks import Check, report_subset, verify
    from .derived.record import Status
    from .printed import PrintedEquation, printed_equation
    from .printers import to_json, to_latex_document, to_text

__all__ = [
    "Check", "PrintedEquation", "Status", "printed_equation", "report_subset", "to_json",
    "to_latex_document", "to_text", "verify",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    from importlib import import_module, metadata

    if name == "__version__":
        try:
            return metadata.version("inelastic-lorentz")
        except metadata.PackageNotFoundError:  # a bare source tree
            return "0+unknown"
    if name in __all__:
        for file in ("printed", "checks", "printers"):
            module = import_module(f".{file}", __name__)
            if hasattr(module, name):
                return getattr(module, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
