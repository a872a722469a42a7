"""Runs the methods on a system of any kind."""

from kinetics.crosscheck.report.cases import Results
from kinetics.crosscheck.report.cooling import run_cooling
from kinetics.crosscheck.report.driven import run_driven
from kinetics.crosscheck.report.progress import Progress
from kinetics.crosscheck.report.systems import Cooling, Driven, System


def gather(system: System, tell: Progress) -> Results:
    """Run everything that a report of the system needs; ValueError for what cannot be simulated."""
    if isinstance(system, Cooling):
        return Results(system, cooling=run_cooling(system, tell))
    if isinstance(system, Driven):
        return Results(system, driven=run_driven(system, tell))
    raise TypeError(f"no report of a {type(system).__name__}")
