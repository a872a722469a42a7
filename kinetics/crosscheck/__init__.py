"""The cross-check: compares the three methods, and anybody's data, and writes the reports.

Only this room and `kinetics.cli` may import all of `kinetics`, `particles` and `derivations`.
Begin with `verdicts.py`, which says what a comparison can come out as, then `report/report.py`.
"""

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
