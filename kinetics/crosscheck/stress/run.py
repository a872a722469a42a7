"""run_stress(): every case, one after another."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterable

from kinetics.crosscheck.stress.case import Case, StressCase, attempt
from kinetics.crosscheck.stress.cooling_cases import cooling_cases, scaled_cases
from kinetics.crosscheck.stress.density_cases import density_cases
from kinetics.crosscheck.stress.field_cases import field_cases
from kinetics.crosscheck.stress.particle_cases import flight_cases, medium_cases
from kinetics.crosscheck.stress.position_cases import position_cases
from kinetics.crosscheck.stress.report import StressReport
from kinetics.errors import InputError

_PARTS = (
    scaled_cases,
    cooling_cases,
    density_cases,
    position_cases,
    field_cases,
    medium_cases,
    flight_cases,
)


def all_cases(quick: bool) -> list[Case]:
    """Every case of a sweep, not run."""
    return list(itertools.chain.from_iterable(part(quick) for part in _PARTS))


def _compile() -> None:
    """Compile the particles' kernels: that is no part of a case's time."""
    import numpy as np

    from particles import BoltzmannGrad, Positions, simulate

    for medium in (BoltzmannGrad(0.04), Positions(np.array([[1.0, 1.0]]), box_side=10.0)):
        simulate(medium, 0.5, max_collisions=1, media=1, tracers=1, workers=1)


def run_stress(
    quick: bool = False,
    groups: Iterable[str] | None = None,
    progress: Callable[[str, int], None] | None = None,
    interrupted: Callable[[StressReport], None] | None = None,
) -> StressReport:
    """Run the sweep, or the named groups of it.

    progress(name of the group, number of cases in all) is called before each case. After Ctrl-C or
    SIGTERM interrupted(report of the cases that have been run) is called, and the exception goes
    on. Raises InputError for a group that does not exist.
    """
    chosen = all_cases(quick)
    if groups is not None:
        wanted, known = set(groups), dict.fromkeys(case.group for case in chosen)
        for group in sorted(wanted - set(known)):
            raise InputError(f"groups: got {group!r}; known are {', '.join(map(repr, known))}")
        chosen = [case for case in chosen if case.group in wanted]
    begin, processor = time.perf_counter(), time.process_time()
    _compile()
    found: list[StressCase] = []

    def report() -> StressReport:
        seconds, of_processor = time.perf_counter() - begin, time.process_time() - processor
        return StressReport(tuple(found), quick, seconds, of_processor, len(chosen) - len(found))

    try:
        for case in chosen:
            if progress is not None:
                progress(case.group, len(chosen))
            found.append(attempt(case))
    except (KeyboardInterrupt, SystemExit):
        if interrupted is not None:
            interrupted(report())
        raise
    return report()
