"""The stability sweep: solvers and particles at their limits, a verdict for each case.

`run_stress` runs it; `lorentz stress` is its command. It may import everything below the
cross-check (`kinetics`, `particles`) and `kinetics.crosscheck.references`. What becomes of bad
input, of random scenes and of other units is not here but in the tests (tests/crosscheck/stress).

Begin reading at `case` (what a case is, and its verdict). The files `*_cases` hold the cases,
`limits` and `starts` what is known of their answers, `run` and `report` the rest.
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
