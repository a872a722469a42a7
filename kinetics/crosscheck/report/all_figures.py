"""Every figure of a report, as the plain lists that the JSON file holds and `figures` draws."""

from collections.abc import Callable, Sequence

from kinetics.crosscheck.report import displacement_figures as displacement
from kinetics.crosscheck.report import scan_figures
from kinetics.crosscheck.report import velocity_figures as velocity
from kinetics.crosscheck.report.case import Case, Scans
from kinetics.crosscheck.report.figure_lines import Results
from kinetics.crosscheck.report.figures import Data
from kinetics.crosscheck.report.settings import ReportSettings

_PAPER: dict[str, Callable[[Results], Data]] = {
    "v0re": velocity.v0re,
    "hetomu2": velocity.hetomu2,
    "msdtheory": displacement.msdtheory,
    "inelasticposi": displacement.inelasticposi,
    "scalev": velocity.scalev,
    "sign": velocity.sign,
    "soninediffuse": displacement.soninediffuse,
}
_OTHERS: dict[str, Callable[[Results], Data]] = {
    "cooling-rate": velocity.cooling_rate,
    "inverse-speed": velocity.inverse_speed,
    "a2": velocity.a2,
    "approach": velocity.approach,
    "vdf-tail": velocity.vdf_tail,
    "msd-slope": displacement.msd_slope,
    "kurtosis": displacement.kurtosis,
    "tail-exponent": displacement.tail_exponent,
}
PAPER_FIGURES = tuple(_PAPER)
"""Names of the figures that are the paper's, by its labels."""
_ANY_RESTITUTION = {"inelasticposi", "kurtosis", "tail-exponent"}


def all_figures(
    cases: Sequence[Case], scans: Scans | None, settings: ReportSettings
) -> dict[str, Data]:
    """The data of every figure that these cases allow, by figure name; the paper's come first.

    Without a case that cools only those that the elastic gas has; Fig. 9 only where the printed
    a2 is real.
    """
    results = Results(cases, scans, settings)
    figures = {
        name: draw(results)
        for name, draw in (_PAPER | _OTHERS).items()
        if name in _ANY_RESTITUTION
        or (results.printed if name == "soninediffuse" else results.cooling)
    }
    if scans is not None:
        figures["density"] = scan_figures.density(scans.density)
        figures["traps"] = scan_figures.traps(scans.traps)
    return figures
