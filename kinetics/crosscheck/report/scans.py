"""Hard disks at other densities and restitutions: the dilute limit, and where traps begin."""

from collections.abc import Callable, Sequence

import numpy as np

from kinetics.crosscheck.report.case import Array, Case, DensityScan, Measured, Scans, TrapScan
from kinetics.crosscheck.report.observables import jackknife_error, weighted_fit
from kinetics.crosscheck.report.settings import ReportSettings
from particles import HardDisks, simulate
from particles.ensemble import Ensemble

DILUTIONS = (1 / 8, 1 / 4, 1 / 2, 1.0, 2.0)
"""Densities of the extrapolation, in units of the report's own."""
LARGEST_DENSITY = 0.25
"""In d^-2; above, random placement without overlap becomes slow, and fails in the end."""
TRAP_RESTITUTIONS = (0.0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
TRAP_FLIGHT = 40.0
"""d rho0 t U of the trap scan: 1000 d/U at the paper's density."""
RATIOS = ("mean_free_path", "thermal_speed", "msd")
"""What the density scan compares with the kinetic equation."""
LARGEST_BOX = 10_000
"""Scatterers in the box of a scan at most."""


def gather_scans(
    cases: Sequence[Case], settings: ReportSettings, tell: Callable[[str], None]
) -> Scans:
    """Both scans; calls `tell` twice."""
    tell("hard disks at other densities")
    density = _density_scan(min(cases, key=lambda case: abs(case.restitution - 0.7)), settings)
    tell("traps")
    return Scans(density, _trap_scan(settings))


def _allowed(factors: Sequence[float], settings: ReportSettings) -> Array:
    """Multiples of the report's density that can be simulated; its own always."""
    own = settings.number_density
    return np.array([f * own for f in factors if f <= 1 or f * own <= LARGEST_DENSITY])


def _disks(e: float, density: float, time: float, seed: int, settings: ReportSettings) -> Ensemble:
    """Hard disks until one time, in a box that may be smaller than the report's."""
    return simulate(
        HardDisks(density, min(settings.count, LARGEST_BOX)), restitution=e, times=[time],
        media=settings.media, tracers=settings.tracers, seed=settings.seed + seed,
        workers=settings.workers,
    )  # fmt: skip


def _density_scan(case: Case, settings: ReportSettings) -> DensityScan:
    densities = _allowed(DILUTIONS, settings)
    found = np.empty((densities.size, len(RATIOS), 2))
    for index, density in enumerate(densities.tolist()):
        stretch = settings.number_density / density
        last = float(case.times[-1]) * stretch
        run = _disks(case.restitution, density, last, 1000 + index, settings)
        speed, msd = case.kinetic.thermal_speed[-1], case.kinetic.msd[-1] * stretch**2
        for k, theory in enumerate((1 / (2 * density), speed, msd)):
            estimate = getattr(run, RATIOS[k])
            value, error = (np.ravel(x)[-1] for x in (estimate.value, estimate.error))
            found[index, k] = value / theory, error / theory
    names = ("free_path", *RATIOS[1:])
    ratios = {name: Measured(*found[:, k].T) for k, name in enumerate(names)}
    degree = min(2, densities.size - 2)
    extrapolated = {name: extrapolate(densities, r, degree) for name, r in ratios.items()}
    return DensityScan(
        restitution=case.restitution,
        densities=densities,
        samples=settings.media * settings.tracers,
        degree=degree,
        ratios=ratios,
        fits={name: fit for name, (fit, _) in extrapolated.items()},
        limits={name: limit for name, (_, limit) in extrapolated.items()},
    )


def extrapolate(x: Array, measured: Measured, degree: int) -> tuple[Array, Measured]:
    """Weighted polynomial fit, lowest coefficient first, and its value at x = 0 with its error.

    x and `measured` have shape (n,). Points without a positive error are left out; NaN if fewer
    than degree + 1 remain.
    """
    used = measured.error > 0
    if np.count_nonzero(used) <= degree:
        return np.full(degree + 1, np.nan), Measured(np.asarray(np.nan), np.asarray(np.nan))
    scale = np.max(x)
    fit, limit = weighted_fit(np.vander(x[used] / scale, degree + 1, True), measured[used])
    return fit / scale ** np.arange(degree + 1), limit


def _trap_scan(settings: ReportSettings) -> TrapScan:
    densities = _allowed((1.0, 4.0), settings)
    shares = np.empty((densities.size, len(TRAP_RESTITUTIONS), 2))
    for i, density in enumerate(map(float, densities)):
        for j, e in enumerate(TRAP_RESTITUTIONS):
            run = _disks(e, density, TRAP_FLIGHT / density, 2000 + 100 * i + j, settings)
            shares[i, j] = _share(run.statuses.trap_tracers, run.media, run.tracers)
    return TrapScan(
        time=TRAP_FLIGHT / settings.number_density,
        restitutions=np.array(TRAP_RESTITUTIONS),
        densities=densities,
        samples=settings.media * settings.tracers,
        share=Measured(shares[..., 0], shares[..., 1]),
    )


def _share(caught: Array, media: int, tracers: int) -> tuple[float, float]:
    """Share of tracers caught, with its jackknife error over configurations.

    caught (n, 2): configuration and tracer of each.
    """
    by_medium = np.bincount(caught[:, 0].astype(int), minlength=media) / tracers
    without = (by_medium.sum() - by_medium) / (media - 1)
    return float(by_medium.mean()), float(jackknife_error(without))
