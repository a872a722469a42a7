"""The benchmark: run time against error, on the same problems for every method.

`run_bench` measures; `lorentz bench` is its command. It may import everything below the cross-check
(`kinetics`, `particles`) and the reference values of `kinetics.crosscheck.references`. Speed from
one version of this package to the next is not its business: see ``tests/benchmarks``.

Begin reading at `run` (the cases, each in a process of its own) and `measuring` (how a piece of
work becomes a row, `record`). `precision` and `position` hold the problems and the five methods,
`accuracy` error asked against error reached, `skipping` what skipping saves, `cost` the run time
against the amount of work, `throughput` the particles. `analysis`, `tables` and `figures` make the
report from the rows.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kinetics.crosscheck.bench.report import BenchReport
    from kinetics.crosscheck.bench.run import run_bench

_HOMES = {"BenchReport": "report", "run_bench": "run"}

__all__ = ["BenchReport", "run_bench"]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'kinetics.crosscheck.bench' has no attribute {name!r}")
    return getattr(import_module(f"kinetics.crosscheck.bench.{_HOMES[name]}"), name)
