"""The cross-check: compares the three methods, and anybody's data, and writes the reports.

Only this room and `kinetics.cli` may import all of `kinetics`, `particles`, `derivations`; none
of them imports it. Begin with `verdicts.py`, which says how a comparison can come out, then with
the room of a command: `report`, `comparison` (of particle data), `bench`, `stress`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kinetics.crosscheck.comparison.judging import compare
    from kinetics.crosscheck.comparison.question import compare_data
    from kinetics.crosscheck.comparison.result import Comparison

_HOMES = {
    "Comparison": "comparison.result",
    "compare": "comparison.judging",
    "compare_data": "comparison.question",
}

__all__ = ["Comparison", "compare", "compare_data"]


def __getattr__(name: str) -> Any:
    # Loaded at first use: the command line imports this package before it knows what it needs.
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"kinetics.crosscheck.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
