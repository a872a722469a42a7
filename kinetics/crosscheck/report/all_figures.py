"""The data of each figure, as plain lists: what the JSON file holds and `figures` draws."""

from collections.abc import Sequence

from kinetics.crosscheck.report import displacement_figures as further
from kinetics.crosscheck.report import velocity_figures as paper
from kinetics.crosscheck.report.case import Case, Scans
from kinetics.crosscheck.report.figure_lines import Data
from kinetics.crosscheck.report.settings import ReportSettings

PAPER_FIGURES = (
    "v0re", "hetomu2", "msdtheory", "inelasticposi", "scalev", "sign", "soninediffuse"
)  # fmt: skip
"""Names of the figures that are the paper's, by its labels."""


def all_figures(
    cases: Sequence[Case], scans: Scans | None, settings: ReportSettings
) -> dict[str, Data]:
    """The data of every figure that these cases allow, by figure name; the paper's come first."""
    cooling = [case for case in cases if case.exact is not None]
    printed = [case for case in cooling if paper.has_sonine(case)]
    figures: dict[str, Data] = {}
    if cooling:
        figures["v0re"] = paper.v0re(cooling, settings)
        figures["hetomu2"] = paper.hetomu2(cooling)
        figures["msdtheory"] = paper.msdtheory(cooling, settings)
    figures["inelasticposi"] = paper.inelasticposi(cases)
    if cooling:
        figures["scalev"] = paper.scalev(cooling)
        figures["sign"] = paper.sign(cooling)
    if printed:
        figures["soninediffuse"] = paper.soninediffuse(printed, settings)
    if cooling:
        figures["cooling-rate"] = further.cooling_rate(cooling)
        figures["inverse-speed"] = further.inverse_speed(cooling, settings)
        figures["a2"] = further.a2(cooling)
        figures["approach"] = further.approach(cooling)
        figures["vdf-tail"] = further.vdf_tail(cooling)
        figures["msd-slope"] = further.msd_slope(cooling, settings)
    figures["kurtosis"] = further.kurtosis(cases)
    figures["tail-exponent"] = further.tail_exponent(cases)
    if scans is not None:
        figures["density"] = further.density(scans.density)
        figures["traps"] = further.traps(scans.traps)
    return figures
