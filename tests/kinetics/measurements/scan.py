"""What a constant of a solver does to its accuracy and its work: the table that all rooms print.

Each script beside this one, ``python tests/kinetics/measurements/ROOM.py [NAME ...]``, changes the
constants of its room one at a time and solves the same problems with each value. A value is good
where the error stays within what was asked for (below 1) at little work; where neither changes
much, the constant is no tuning at all.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from types import ModuleType
from typing import NamedTuple


class Outcome(NamedTuple):
    """Of all problems of a room.

    errors : the largest errors over what was asked for, by name
    median : the median of all of them
    work : what was solved, in the units that the script states
    unsaid : how many errors were above 1 while the estimate of the solver was below
    """

    errors: dict[str, float]
    median: float
    work: float
    unsaid: int


class Constant(NamedTuple):
    """One constant: the module that holds it, its name, and factors of its value to be tried."""

    module: ModuleType
    name: str
    factors: tuple[float, ...] = (0.5, 2.0)
    add: bool = False


def scan(constants: Iterable[Constant], measure: Callable[[], Outcome], work: str) -> None:
    """Print a line for each value of each constant; those in use are marked with a star."""
    chosen = set(sys.argv[1:])
    used = measure()
    names = "".join(f"{name:>10}" for name in used.errors)
    print(f"{'constant':20}{'value':>9} {names}{'median':>10}{work:>10}    unsaid")
    _line("(as they are)", "", used)
    for constant in constants:
        if chosen and constant.name not in chosen:
            continue
        value = getattr(constant.module, constant.name)
        others = [value + f if constant.add else type(value)(value * f) for f in constant.factors]
        for other in sorted([value, *others]):
            setattr(constant.module, constant.name, other)
            outcome = used if other == value else measure()
            mark = "*" if other == value else " "
            _line(constant.name, f"{other:.4g}{mark}", outcome)
        setattr(constant.module, constant.name, value)


def _line(name: str, value: str, found: Outcome) -> None:
    errors = "".join(f"{error:10.2e}" for error in found.errors.values())
    print(
        f"{name:20}{value:>9} {errors}{found.median:10.1e}{found.work:10.4g}{found.unsaid:10d}",
        flush=True,
    )
