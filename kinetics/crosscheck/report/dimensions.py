"""Disks and spheres side by side: closed form, solver and particles of one law in two and three.

Both have the mean free path of the report's own system, so that the times are those of the report.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from kinetics.crosscheck.report.case import Case, Measured, ParticleRun
from kinetics.crosscheck.report.observables import cooling_rate_between, msd_slope_between
from kinetics.crosscheck.report.run_methods import (
    OUTPUTS,
    free_run,
    reduced,
    scaling_states,
    solution,
)
from kinetics.crosscheck.report.settings import ReportSettings, half_cross_section

SCATTERERS = {2: "disks", 3: "spheres"}
_NO_VALUE: dict[str, float | None] = {"exact": None, "solver": None}
_OTHER_SEED = 5000
"""Added to the seed of the runs in the dimension that the report does not have."""


def both_dimensions(
    cases: Sequence[Case], settings: ReportSettings, tell: Callable[[str], None]
) -> list[dict[str, Any]]:
    """One row for each quantity, restitution and dimension; calls `tell` for each case.

    "exact" and "solver" are the limits of late times, by closed form and as solved; "equation" is
    the kinetic equation at the last time of the particles (rates: over their last decade), and
    "value" and "error" are of Boltzmann-Grad particles there. None where there is no such number.
    """
    rows: list[dict[str, Any]] = []
    dimension = 5 - settings.dimension
    # The same mean free path: rho0 is that of the report times the ratio of the cross-sections.
    ratio = half_cross_section(settings.dimension) / half_cross_section(dimension)
    density = settings.number_density * ratio
    other = replace(settings, dimension=dimension, number_density=density)
    for case in cases:
        tell(f"e = {case.restitution:g}: {other.scatterers} beside {settings.scatterers}")
        found = {
            settings.dimension: (case, case.exact, case.scaled, case.kinetic, case.free),
            dimension: (case, *_other(case, other)),
        }
        rows += [
            {"restitution": case.restitution, "scatterers": SCATTERERS[d], **row}
            for d in (2, 3)
            for row in _rows(*found[d], half_rate=settings.half_rate)
        ]
    return rows


def _other(case: Case, settings: ReportSettings) -> tuple[Any, Any, Any, ParticleRun]:
    """Scaling state in closed form and as solved, the equation, and the particles."""
    e, times = case.restitution, case.times
    law = settings.law(e)
    equation = solution(law, settings.number_density, times, OUTPUTS, settings.rtol)
    seed = settings.seed + _OTHER_SEED + settings.restitutions.index(e)
    run = free_run(e, times, seed, settings)
    particles = reduced("Boltzmann-Grad", run, case.early, settings.half_rate)
    return *scaling_states(law, settings.rtol).values(), equation, particles


def _rows(
    case: Case, exact: Any, scaled: Any, equation: Any, run: ParticleRun, half_rate: float
) -> list[dict[str, Any]]:
    """The rows of one dimension."""
    square, times = (2 * half_rate) ** 2, case.times
    rate = cooling_rate_between(times, equation.thermal_speed, case.early, half_rate)
    slope = msd_slope_between(times, equation.msd, case.early) * square
    limits: dict[str, dict[str, float | None]] = {}
    if exact is not None:
        limits = {
            name: {"exact": getattr(exact, name), "solver": getattr(scaled, name)}
            for name in ("cooling_rate", "a2")
        }
        limits["msd_slope"] = {"exact": exact.diffusion_slope, "solver": None}
        gaussian = 1 + 2 / exact.dimension
        limits["kurtosis"] = {"exact": gaussian, "solver": None}
    measured: dict[str, tuple[float, Measured]] = {
        "cooling_rate": (rate, run.cooling_rate),
        "a2": (equation.a2[-1], run.a2[-1]),
        "thermal_speed": (equation.thermal_speed[-1], run.thermal_speed[-1]),
        "msd": (equation.msd[-1] * square, run.msd[-1] * square),
        "msd_slope": (slope, run.msd_slope * square),
        "kurtosis": (equation.kurtosis[-1], run.kurtosis[-1]),
    }
    if exact is None:  # nothing cools
        del measured["cooling_rate"]
    return [
        {
            "observable": name,
            **limits.get(name, _NO_VALUE),
            "equation": float(at_end),
            "value": float(np.asarray(particles.value)),
            "error": float(np.asarray(particles.error)),
        }
        for name, (at_end, particles) in measured.items()
    ]
