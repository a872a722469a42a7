"""Every figure of a report, as the plain lists that the JSON file holds and `figures` draws."""

from collections.abc import Callable, Sequence

from kinetics.crosscheck.report import displacement_figures as displacement
from kinetics.crosscheck.report import scan_figures
from kinetics.crosscheck.report import velocity_figures as velocity
from kinetics.crosscheck.report.case import Case, Scans
from kinetics.crosscheck.report.figure_lines import Results
from kinetics.crosscheck.report.figures import Data
from kinetics.crosscheck.report.settings import ReportSettings

_PAPER: tuple[Callable[[Results], Data], ...] = (
    velocity.v0re, velocity.hetomu2, displacement.msdtheory, displacement.inelasticposi,
    velocity.scalev, velocity.sign, displacement.soninediffuse,
)  # fmt: skip
_OTHERS: tuple[Callable[[Results], Data], ...] = (
    velocity.cooling_rate, velocity.inverse_speed, velocity.a2, velocity.approach,
    velocity.vdf_tail, displacement.msd_slope, displacement.kurtosis, displacement.tail_exponent,
)  # fmt: skip
_ANY_RESTITUTION = {displacement.inelasticposi, displacement.kurtosis, displacement.tail_exponent}
PAPER_FIGURES = tuple(make.__name__ for make in _PAPER)
"""Names of the figures that are the paper's, by its labels."""


def all_figures(
    cases: Sequence[Case], scans: Scans | None, settings: ReportSettings
) -> dict[str, Data]:
    """The data of every figure that these cases allow, by figure name; the paper's come first.

    If no case cools, only those that the elastic gas has; Fig. 9 only where the printed a2 is real.
    """
    results = Results(cases, settings)
    figures = {
        make.__name__.replace("_", "-"): make(results)
        for make in _PAPER + _OTHERS
        if make in _ANY_RESTITUTION
        or (results.printed if make is displacement.soninediffuse else results.cooling)
    }
    if scans is not None:
        figures["density"] = scan_figures.density(scans.density)
        figures["traps"] = scan_figures.traps(scans.traps)
    return figures
