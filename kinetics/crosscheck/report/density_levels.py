"""What the theory of a finite density says of the hard disks of a report, level by level.

The levels go from the paper's equation, in which no scatterer is met a second time, to all that
`kinetics.collision.medium` knows. Each is a solution from the start and at the times of the report.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from kinetics import CollisionLaw, Scene, Solution, solve
from kinetics.collision import law_in_medium
from kinetics.crosscheck.report.case import Array, Case, Measured
from kinetics.crosscheck.report.observables import (
    bin_density,
    cooling_rate_between,
    msd_slope_between,
)
from kinetics.crosscheck.report.settings import ReportSettings

DILUTE, PATH = "dilute equation", "path of the medium"
LEADING, FIRST, FITTED = "leading order", "first order", "fitted second order"
LEVELS = (DILUTE, PATH, LEADING, FIRST, FITTED)
"""The levels, each with what the one before it has; the last has a number fitted to simulations."""
ORDER_OF = {LEADING: "leading", FIRST: "first", FITTED: "second"}
"""The `density_order` of a Scene."""
OBSERVABLES = ("thermal_speed", "cooling_rate", "msd", "msd_slope", "kurtosis")
AVERAGES = ("thermal_speed", "msd", "kurtosis")
_PLACE = 1e-4  # rtol of G(R): a hundredth of the errors of its bins


@dataclass(frozen=True)
class Prediction:
    """One observable of one restitution: each level, and the hard disks.

    Units are those of `ParticleRun`; `time` in d/U is the last one. `theory` is by level. The
    cooling rate h is read with the l of the dilute limit, as the paper reads it.
    """

    restitution: float
    observable: str
    time: float
    theory: dict[str, float]
    disks: Measured

    def off(self, level: str) -> Measured:
        """Hard disks over this level, less 1, with its standard error."""
        ratio = self.disks / self.theory[level]
        return Measured(np.asarray(ratio.value - 1.0), ratio.error)

    def change(self, level: str) -> float:
        """What this level changes of the one before it, as a ratio less 1."""
        before = LEVELS[LEVELS.index(level) - 1]
        return self.theory[level] / self.theory[before] - 1.0


@dataclass(frozen=True)
class PlacePrediction:
    """G(R) of the hard disks of one restitution at the last time, beside two of the levels.

    chi_square: by level (DILUTE and FITTED), the squares of the deviations over the standard
    errors, summed over `bins` bins of R in which the errors are below a third.
    """

    restitution: float
    time: float
    bins: int
    chi_square: dict[str, float]


def place_predictions(cases: Sequence[Case], settings: ReportSettings) -> list[PlacePrediction]:
    """G(R) of every case; hard disks and theory are each scaled with their own <r^2>."""
    found = []
    for case in cases:
        disks, edges, times = case.hard.position, case.position_edges, case.times[-1:]
        # in a run of few configurations all may have the same number in a bin
        sure = (disks.error > 0.0) & (disks.value > 3.0 * disks.error)
        outputs, rtol = ("msd", "position_density"), max(settings.position_rtol, _PLACE)
        density, e = settings.number_density, case.restitution
        theory = replace(case, position=solution(e, density, times, outputs, FITTED, rtol=rtol))
        off = {
            level: (disks.value - bin_density(of, edges))[sure] / disks.error[sure]
            for level, of in ((DILUTE, case), (FITTED, theory))
        }
        chi_square = {level: float(values @ values) for level, values in off.items()}
        found.append(PlacePrediction(e, float(times[0]), int(sure.sum()), chi_square))
    return found


def predictions(cases: Sequence[Case], settings: ReportSettings) -> list[Prediction]:
    """Every observable of every case; the elastic gas has no cooling rate and no change of v0."""
    found = []
    for case in cases:
        levels = {level: _reduced(case, level, settings) for level in LEVELS}
        for name in OBSERVABLES if case.exact is not None else ("msd", "msd_slope", "kurtosis"):
            measured = getattr(case.hard, name)
            found.append(
                Prediction(
                    restitution=case.restitution,
                    observable=name,
                    time=float(case.times[-1]),
                    theory={level: values[name] for level, values in levels.items()},
                    disks=measured[-1] if name in AVERAGES else measured,
                )
            )
    return found


def _reduced(case: Case, level: str, settings: ReportSettings) -> dict[str, float]:
    """The observables of one level, as of a run: at the last time, or over the last decade."""
    density, rtol = settings.number_density, settings.rtol
    solved = case.kinetic
    if level != DILUTE:
        solved = solution(case.restitution, density, case.times, AVERAGES, level, rtol=rtol)
    speed, msd = np.asarray(solved.thermal_speed), np.asarray(solved.msd)
    return {
        "thermal_speed": float(speed[-1]),
        "cooling_rate": cooling_rate_between(case.times, speed, case.early, settings.half_rate),
        "msd": float(msd[-1]),
        "msd_slope": msd_slope_between(case.times, msd, case.early),
        "kurtosis": float(solved.kurtosis[-1]),
    }


def solution(
    e: float, density: float, times: Array, outputs: tuple[str, ...], level: str,
    scatterers: str = "hard disks", rtol: float = 1e-6,
) -> Solution:  # fmt: skip
    """One level from a Gaussian start; density in d^-2, times in d/U."""
    more: dict[str, Any] = {}
    if level == PATH:
        law = law_in_medium(CollisionLaw(e), scatterers, density, 1.0, "leading")
        density = 0.5 / law.mean_free_path(density, 1.0)
    elif level != DILUTE:
        more = {"scatterers": scatterers, "density_order": ORDER_OF[level]}
    scene = Scene(e, number_density=density, times=times, outputs=outputs, **more)
    return solve(scene, rtol=rtol)
