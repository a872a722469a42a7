"""The court: holds the three witnesses against each other and writes the reports."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kinetics.crosscheck.compare.judge import compare
    from kinetics.crosscheck.compare.result import Comparison

_HOMES = {"Comparison": "compare.result", "compare": "compare.judge"}

__all__ = ["Comparison", "compare"]


def __getattr__(name: str) -> Any:
    # Loaded at first use: the command line imports this package before it knows what it needs.
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"kinetics.crosscheck.{_HOMES[name]}"), name)
    globals()[name] = value
    return value
