"""Every figure of a report: which there are, and in which order."""

from collections.abc import Callable, Sequence

from kinetics.crosscheck.report import scan_figures
from kinetics.crosscheck.report.case import Case, Scans
from kinetics.crosscheck.report.displacement_figures import (
    inelasticposi,
    kurtosis,
    msd_ratio,
    msd_slope,
    msdtheory,
    soninediffuse,
    tail_exponent,
)
from kinetics.crosscheck.report.figure_lines import Results
from kinetics.crosscheck.report.figures import Data
from kinetics.crosscheck.report.settings import ReportSettings
from kinetics.crosscheck.report.velocity_figures import (
    a2,
    approach,
    cooling_rate,
    hetomu2,
    inverse_speed,
    scalev,
    sign,
    v0re,
    vdf_tail,
)

_PAPER: tuple[Callable[[Results], Data], ...] = (
    v0re, hetomu2, msdtheory, inelasticposi, scalev, sign, soninediffuse
)  # fmt: skip
_OTHERS: tuple[Callable[[Results], Data], ...] = (
    cooling_rate, inverse_speed, a2, approach, vdf_tail, msd_slope, kurtosis, tail_exponent
)  # fmt: skip
PAPER_FIGURES = tuple(make.__name__ for make in _PAPER)
"""Names of the figures that are the paper's, by its labels."""
_ELASTIC = (inelasticposi, kurtosis, tail_exponent)
"""Those that the elastic gas has."""
_OF_ANY_LAW: dict[str, Callable[[Results], Data]] = {
    "position": inelasticposi,
    "vdf": scalev,
    **{make.__name__.replace("_", "-"): make for make in _OTHERS},
}
"""Figures of scatterers that are not smooth disks, by name; they have no formula of the paper."""


def all_figures(
    cases: Sequence[Case], scans: Scans | None, settings: ReportSettings
) -> dict[str, Data]:
    """The data of every figure that these cases allow, by figure name; the paper's come first.

    If no case cools, only those that the elastic gas has; Fig. 9 only where the printed a2 is real.
    """
    results = Results(cases, settings)
    chosen = _OF_ANY_LAW
    if settings.is_papers_law:
        chosen = {make.__name__.replace("_", "-"): make for make in _PAPER + _OTHERS}
    figures = {
        name: make(results)
        for name, make in chosen.items()
        if make in _ELASTIC or (results.printed if make is soninediffuse else results.cooling)
    }
    if settings.is_papers_law and results.dense_cases:
        figures["msd-ratio"] = msd_ratio(results)
    if scans is not None:
        figures["density"] = scan_figures.density(scans.density)
        figures["traps"] = scan_figures.traps(scans.traps)
    order = [case.restitution for case in cases]
    return {name: data | {"order": order} for name, data in figures.items()}
