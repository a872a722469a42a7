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

__all__ = ["Comparison", "compare", "compare_data"]


def __getattr__(name: str) -> Any:
    # Loaded at first use: the command line imports this package before it knows what it needs.
    homes = {"Comparison": "result", "compare": "judging", "compare_data": "question"}
    if name not in homes:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"kinetics.crosscheck.comparison.{homes[name]}"), name)
