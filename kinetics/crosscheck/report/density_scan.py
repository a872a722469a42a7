"""<r^2> of hard and of overlapping disks over the density, and what each remembered disk adds."""

from dataclasses import dataclass

import numpy as np

from kinetics.crosscheck.report.case import Array, Case, DensityScan, Measured
from kinetics.crosscheck.report.density_levels import (
    DILUTE,
    FIRST,
    FITTED,
    LEADING,
    PATH,
    solution,
)
from kinetics.crosscheck.report.figures import Data, axis, series
from kinetics.crosscheck.report.scans import LARGEST_BOX
from kinetics.crosscheck.report.settings import ReportSettings
from kinetics.crosscheck.report.templates import paragraphs
from particles import ForgetfulPoisson, Medium, Poisson, simulate

MEMORIES = (0, 1, 2, 3, 5, 10)
"""Collisions that the tracers of the second figure remember."""
EVERYTHING = 1000
"""More collisions than a tracer makes."""
CURVE_POINTS = 8
SHORT = {"hard disks": "hard", "overlapping": "overlapping"}
"""The media as the legend says them, which has the points of hard disks under their full name."""
CURVES = {"hard disks": (PATH, LEADING, FIRST, FITTED), "overlapping": (LEADING, FIRST, FITTED)}
"""The path of overlapping disks is that of the dilute limit."""
_SEED = 4000
"""Added to the seed of these runs."""


@dataclass(frozen=True)
class ReturnScan:
    """<r^2> over that of the dilute equation, at one restitution and the same d rho0 t.

    points: by medium, at `densities` (n_densities,) in d^-2. curves: by medium and level, at
    `grid`. remembered: tracers among overlapping disks of the report's density that remember
    MEMORIES collisions, (n_memories,); all_remembered: that remember all, shape (); expected: the
    theory of these.
    """

    restitution: float
    number_density: float
    samples: int
    densities: Array
    points: dict[str, Measured]
    grid: Array
    curves: dict[str, dict[str, Array]]
    memories: Array
    remembered: Measured
    all_remembered: Measured
    expected: float


def gather_returns(case: Case, scan: DensityScan, settings: ReportSettings) -> ReturnScan:
    """The runs among overlapping disks and the curves; the points of hard disks are the scan's."""
    own, count = settings.number_density, min(settings.count, LARGEST_BOX)
    sparse = [Poisson(n, count) for n in scan.densities.tolist()]
    overlapping = [
        _ratio(medium, 3 * settings.tracers, case, _SEED + k, settings)
        for k, medium in enumerate(sparse)
    ]
    # No scatterers are placed for these: more tracers cost little. With one seed for all, tracers
    # of different memories go the same way until the memory matters.
    tracers = max(1, settings.free_tracers // (4 * settings.media))
    forgetful = [
        _ratio(ForgetfulPoisson(own, k), tracers, case, _SEED + 100, settings)
        for k in (*MEMORIES, EVERYTHING)
    ]
    grid = np.linspace(0.0, float(scan.densities[-1]), CURVE_POINTS + 1)[1:]
    curves = {
        medium: {level: _curve(case, grid, medium, level, settings) for level in levels}
        for medium, levels in CURVES.items()
    }
    at_own = _curve(case, np.array([own]), "overlapping", FITTED, settings)
    return ReturnScan(
        restitution=case.restitution,
        number_density=own,
        samples=scan.samples,
        densities=scan.densities,
        points={"hard disks": scan.ratios["msd"], "overlapping": Measured.joined(overlapping)},
        grid=grid,
        curves=curves,
        memories=np.array(MEMORIES),
        remembered=Measured.joined(forgetful[:-1]),
        all_remembered=forgetful[-1],
        expected=float(at_own[0]),
    )


def _ratio(
    medium: Medium, tracers: int, case: Case, seed: int, settings: ReportSettings
) -> Measured:
    """<r^2> over the dilute equation, at the last time of the case; tracers in each medium."""
    stretch = settings.number_density / medium.number_density
    run = simulate(
        medium, restitution=case.restitution, times=case.times[-1:] * stretch,
        media=settings.media, tracers=tracers, seed=settings.seed + seed,
        workers=settings.workers,
    )  # fmt: skip
    dilute = float(case.kinetic.msd[-1]) * stretch**2
    return Measured(run.msd.value[-1], run.msd.error[-1]) / dilute


def _curve(
    case: Case, densities: Array, medium: str, level: str, settings: ReportSettings
) -> Array:
    """One level over the dilute equation, at the same d rho0 t."""
    e, ratios = case.restitution, []
    for n in densities.tolist():
        stretch = settings.number_density / n
        found = solution(e, n, case.times[-1:] * stretch, ("msd",), level, medium)
        ratios.append(found.msd[-1] / (case.kinetic.msd[-1] * stretch**2))
    return np.array(ratios)


def figures(scan: ReturnScan) -> dict[str, Data]:
    """Both figures, by name."""
    lines = []
    for medium, levels in scan.curves.items():
        for level, ratio in levels.items():
            x, y = np.append(0.0, scan.grid), np.append(1.0, ratio)
            lines.append(series(level, x, y, group=SHORT[medium]))
        points = scan.points[medium]
        at, group = scan.densities, SHORT[medium]
        lines.append(series("particles", at, points.value, points.error, group=group))
    known = scan.remembered
    ends, everything = scan.memories[[0, -1]], float(scan.all_remembered.value)
    error = float(scan.all_remembered.error)
    beyond = 1.1 * ends[-1] + 1.0
    memory = [
        series(DILUTE, [0.0, beyond], [1.0, 1.0]),
        series(FITTED, [0.0, beyond], [scan.expected] * 2),
        series("particles", scan.memories, known.value, known.error),
        series("all remembered", beyond, everything, error),
    ]
    return {
        "finite-density": _figure("finite_density", axis(r"$\rho_0 d^2$"), lines, scan),
        "memory": _figure("memory", axis("collisions remembered"), memory, scan),
    }


def _figure(block: str, x: Data, lines: list[Data], scan: ReturnScan) -> Data:
    title, description = paragraphs("density.txt.j2", block, scan=scan)
    y = axis(r"$\langle r^2\rangle$ / dilute equation")
    return {"title": title, "description": description, "x": x, "y": y, "series": lines}
