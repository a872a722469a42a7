"""Run time against error: every method on the same problems, in one run, and what skipping saves.

`run_bench` measures, `compare_bench` holds one run against an earlier one. Nothing is loaded until
it is asked for.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kinetics.crosscheck.bench.comparison import Comparison, compare_bench
    from kinetics.crosscheck.bench.report import BenchReport
    from kinetics.crosscheck.bench.run import run_bench

_HOMES = {
    "BenchReport": "report",
    "Comparison": "comparison",
    "compare_bench": "comparison",
    "run_bench": "run",
}

__all__ = ["BenchReport", "Comparison", "compare_bench", "run_bench"]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'kinetics.crosscheck.bench' has no attribute {name!r}")
    return getattr(import_module(f"kinetics.crosscheck.bench.{_HOMES[name]}"), name)
