"""Figures of hard disks at other densities and restitutions."""

import numpy as np

from kinetics.crosscheck.report.case import DensityScan, TrapScan
from kinetics.crosscheck.report.figure_lines import level
from kinetics.crosscheck.report.figures import Data, axis, figure, series

RATIO_NAMES = {"free_path": "free path", "thermal_speed": "thermal speed", "msd": "⟨r²⟩"}


def density(scan: DensityScan) -> Data:
    """Hard disks over the dilute theory at several densities, and their limit rho0 d^2 -> 0."""
    x = np.linspace(0.0, float(scan.densities[-1]), 40)
    lines = [level("kinetic equation", x, 1.0)]
    for name, ratio in scan.ratios.items():
        group, limit = RATIO_NAMES[name], scan.limits[name]
        lines.append(series("hard disks", scan.densities, ratio.value, ratio.error, group=group))
        if np.isfinite(limit.value):
            fit = np.polynomial.Polynomial(scan.fits[name])(x)
            lines.append(series("extrapolation", x, fit, group=group))
            lines.append(series("limit", 0.0, limit.value, limit.error, group=group))
    y = axis("hard disks / kinetic equation")
    return figure("density", axis(r"$\rho_0 d^2$"), y, lines, scan=scan)


def traps(scan: TrapScan) -> Data:
    """Share of tracers caught in corners over e."""
    lines, uncaught, at = [], [], scan.restitutions
    for number_density, value, error in zip(
        scan.densities, scan.share.value, scan.share.error, strict=True
    ):
        group, caught = f"ρ₀d² = {number_density:g}", value > 0
        lines.append(series("hard disks", at[caught], value[caught], error[caught], group=group))
        if not np.all(caught):
            uncaught.append(f"{group}: e = " + ", ".join(f"{e:g}" for e in at[~caught]))
    y = axis("share caught", "", "log")
    return figure("traps", axis("restitution $e$"), y, lines, scan=scan, uncaught=uncaught)
