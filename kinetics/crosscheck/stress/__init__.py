"""The stability sweep: solvers and particles at their limits, each case with its verdict.

`run_stress` runs it. Nothing is loaded until it is asked for.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kinetics.crosscheck.stress.report import StressReport
    from kinetics.crosscheck.stress.run import run_stress

_HOMES = {"StressReport": "report", "run_stress": "run"}

__all__ = ["StressReport", "run_stress"]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'kinetics.crosscheck.stress' has no attribute {name!r}")
    return getattr(import_module(f"kinetics.crosscheck.stress.{_HOMES[name]}"), name)
