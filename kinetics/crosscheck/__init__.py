"""The cross-check: compares the three methods, and anybody's data, and writes the reports.

Only this room and `kinetics.cli` may import all of `kinetics`, `particles`, `derivations`; none
of them imports it. Begin with `words.py`, which says how a comparison can come out, then with the
room of a command: `report`, `explore`, `compare` (data, read in `data`), `bench`, `stress`.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kinetics.crosscheck import compare as compare
    from kinetics.crosscheck.compare import Comparison, compare_data, fit_data

__all__ = ["Comparison", "compare", "compare_data", "fit_data"]


def __getattr__(name: str) -> Any:
    from importlib import import_module  # the command line does not know yet what it needs

    from kinetics.names import IMPORTING

    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    with IMPORTING:
        import_module("numpy")
        room = import_module("kinetics.crosscheck.compare")
    return room if name == "compare" else getattr(room, name)
