"""What lifts the h of hard disks to the paper's 1.45 (1 - e): two causes, each with its number.

The paper reads h as the slope of 1/v0 over a finite window of times, with the mean free path of a
dilute medium. So two things stand between its value and the exact h of late times: the Gaussian
start is not yet forgotten in the window, and the disks, at a finite density, are hit more often.
"""

from dataclasses import dataclass

from kinetics import Solution, sonine
from kinetics.crosscheck.report.case import Case, Measured
from kinetics.crosscheck.report.figure_lines import Results
from kinetics.crosscheck.report.observables import cooling_rate_between


@dataclass(frozen=True)
class Causes:
    """The steps from the exact h/(1 - e) to that of hard disks, at one restitution.

    Rates are h/(1 - e), with the l of a dilute medium; changes are relative, of each step to the
    one before.
    """

    restitution: float
    exact: float  # of late times
    same_times: float  # kinetic equation over the window of the particles
    start: float  # relative: same_times over exact, less 1
    dilute: Measured  # Boltzmann-Grad particles over the window
    disks: Measured  # hard disks over the window
    density: Measured  # relative: disks over same_times, less 1
    corrected: float | None  # the equation at the density of the disks, over the window
    predicted: float | None  # relative: corrected over same_times, less 1
    free_path: Measured  # relative: measured over dilute mean free path, less 1
    fit: float  # 1.45
    fit_off: float  # relative: 1.45 over exact, less 1


def causes(results: Results) -> list[Causes]:
    """One for each restitution that cools; of smooth disks in the plane."""
    if not results.is_papers_law:
        return []
    return [_causes(case, results.settings.half_rate) for case in results.cooling]


def _causes(case: Case, half_rate: float) -> Causes:
    scale = 1 - case.restitution

    def rate(solution: Solution) -> float:
        speed = solution.thermal_speed
        return cooling_rate_between(case.times, speed, case.early, half_rate) / scale

    exact, same_times = case.scaling_state[0].cooling_rate / scale, rate(case.kinetic)
    disks = case.hard.cooling_rate / scale
    corrected = None if case.dense is None else rate(case.dense)
    path = case.hard.free_path * (2 * half_rate)
    over = disks / same_times
    return Causes(
        restitution=case.restitution,
        exact=exact,
        same_times=same_times,
        start=same_times / exact - 1,
        dilute=case.free.cooling_rate / scale,
        disks=disks,
        density=Measured(over.value - 1, over.error),
        corrected=corrected,
        predicted=None if corrected is None else corrected / same_times - 1,
        free_path=Measured(path.value - 1, path.error),
        fit=sonine.FITTED_COOLING_FACTOR,
        fit_off=sonine.FITTED_COOLING_FACTOR / exact - 1,
    )
