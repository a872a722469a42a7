"""Every figure of a report: which there are, and in which order."""

from collections.abc import Callable, Sequence

from kinetics.crosscheck.report import displacement_figures as place
from kinetics.crosscheck.report import scan_figures
from kinetics.crosscheck.report import velocity_figures as velocity
from kinetics.crosscheck.report.case import Case, Scans
from kinetics.crosscheck.report.figure_lines import Results
from kinetics.crosscheck.report.figures import Data
from kinetics.crosscheck.report.settings import ReportSettings

_PAPER: tuple[Callable[[Results], Data], ...] = (
    velocity.v0re, velocity.hetomu2, place.msdtheory, place.inelasticposi, velocity.scalev,
    velocity.sign, place.soninediffuse,
)  # fmt: skip
_OTHERS: tuple[Callable[[Results], Data], ...] = (
    velocity.cooling_rate, velocity.inverse_speed, velocity.a2, velocity.approach,
    velocity.vdf_tail, place.msd_slope, place.kurtosis, place.tail_exponent,
)  # fmt: skip
PAPER_FIGURES = tuple(make.__name__ for make in _PAPER)
"""Names of the figures that are the paper's, by its labels."""
_ELASTIC = (place.inelasticposi, place.kurtosis, place.tail_exponent)
"""Those that the elastic gas has."""
_OF_ANY_LAW: dict[str, Callable[[Results], Data]] = {
    "position": place.inelasticposi,
    "vdf": velocity.scalev,
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
        if make in _ELASTIC or (results.printed if make is place.soninediffuse else results.cooling)
    }
    if settings.is_papers_law and results.dense_cases:
        figures["msd-ratio"] = place.msd_ratio(results)
    if scans is not None:
        figures["density"] = scan_figures.density(scans.density)
        figures["traps"] = scan_figures.traps(scans.traps)
    order = [case.restitution for case in cases]
    return {name: data | {"order": order} for name, data in figures.items()}
