"""Measures the constants of `kinetics.position` again.

Two tables. Waves: a_0 for many restitutions, wave numbers and tolerances against the best that the
solver can do; the work is the flops of its linear systems. Densities: G(R) of scenes that differ
against rtol = 1e-6; the work is that of all their wave numbers. References are made by the same
solver with the constants as they are: a constant that spoils the best result is seen by the tests,
against closed forms, not here. Takes some minutes; names of constants as arguments choose.
"""

from __future__ import annotations

import itertools

import numpy as np
from scan import Constant, Outcome, scan

from kinetics import CollisionLaw, Scene, solve
from kinetics.position import intermediate_scattering, scattering, sweep, tail

TIMES = np.linspace(-3.0, 6.0, 60)  # X = ln(v t/l)
WAVES = list(itertools.product((0.0, 0.6, 1.0), (0.2, 1.0, 3.0, 7.0), (1.0, 6.0)))
SCENES = [
    (0.4, [3000.0], "gaussian"),
    (0.6, [300.0], "gaussian"),
    (0.6, [20.0], "gaussian"),
    (0.9, [1000.0], "gaussian"),
    (0.1, [1e3], "gaussian"),
    (1.0, [1e3], "gaussian"),
    (0.7, [500.0], "monoenergetic"),
    (0.95, [2000.0], "monoenergetic"),
]
RADII = np.linspace(0.0, 6.0, 200)

OF_WAVES = [
    Constant(scattering, "_TURNING", (0.5, 1.5)),
    Constant(scattering, "_SOME", (-1.0, 1.0), add=True),
    Constant(scattering, "_NEGLIGIBLE", (0.1, 10.0)),
    Constant(scattering, "_FOR_DIGIT", (0.8, 1.2)),
    Constant(scattering, "_FOR_TURN", (0.7, 1.3)),
    Constant(scattering, "_LATE_FOR_DIGIT", (0.6, 1.4)),
    Constant(scattering, "_EARLY_FOR_DIGIT", (0.5, 1.5)),
    Constant(scattering, "_RISING", (0.8, 1.2)),
    Constant(scattering, "_MORE", (-3, 2), add=True),
    Constant(scattering, "_MOST_MORE", (-4, 6), add=True),
    Constant(scattering, "_FEWEST_NODES", (-2, 2), add=True),
]
OF_DENSITIES = [
    Constant(sweep, "_LARGEST", (0.5, 2.0)),
    Constant(sweep, "_LARGEST_OF_PEAKS", (0.5, 1.5)),
    Constant(sweep, "FEW", (0.1, 10.0)),
    Constant(sweep, "_CHEAP", (0.5, 2.0)),
    Constant(sweep, "_CHEAPER", (0.01, 100.0)),
    Constant(sweep, "_POINTS", (-2.0, 2.0), add=True),
    Constant(sweep, "_FOR_DIGIT", (0.7, 1.3)),
    Constant(sweep, "_FOR_DIGIT_AT_ZERO", (0.7, 1.3)),
    Constant(sweep, "_FIRST", (0.5, 1.5)),
    Constant(sweep, "_POINTS_OF_POWERS", (-1.0, 2.0), add=True),
    Constant(sweep, "_FOR_DIGIT_LATE", (0.7, 1.3)),
    Constant(sweep, "_EARLIER", (0.5, 2.0)),
    Constant(sweep, "_MOST_ALLOWED", (0.2, 4.0)),
    Constant(sweep, "_STEP", (0.9, 1.3)),
    Constant(sweep, "_LONGEST_STEP", (0.85, 1.25)),
    Constant(sweep, "_POWERS", (0.5, 1.5)),
    Constant(sweep, "_FITTED", (0.5, 1.7)),
    Constant(sweep, "_BETTER", (0.3, 3.0)),
    Constant(sweep, "_BEYOND", (0.5, 3.0)),
    Constant(sweep, "_FALL", (0.5, 2.0)),
    Constant(tail, "_LOWER", (0.9, 1.2)),
    Constant(intermediate_scattering, "_POINTS", (-3, 3), add=True),
]


def waves(e: float, k: float, highest: float, tolerance: float) -> tuple[np.ndarray, float, float]:
    """a_0 at TIMES up to the highest, the error estimate, and the work."""
    found = scattering.solve_waves(CollisionLaw(e), np.array([k]), highest, tolerance)
    values = found(TIMES[highest >= TIMES])[:, 0]
    return values, found.error_estimate, found.systems * (found.rule.nodes - 1) ** 3


def density(case: int, rtol: float) -> tuple[np.ndarray, float, float]:
    """G(R) of one of the SCENES, its error estimate and the work."""
    e, times, initial = SCENES[case]
    scene = Scene(e, initial=initial, times=times, outputs=("position_density",))
    found = solve(scene, rtol=rtol)
    work = sum(count * int(size) ** 3 for size, count in found.stats["systems"].items())
    return found.scaled_position_density(RADII), found.stats["position_density_error"], work


def measure_waves(best: list[np.ndarray]) -> Outcome:
    """All waves and tolerances, as the constants are now."""
    errors, work, unsaid = [], 0.0, 0
    for (i, case), tolerance in itertools.product(enumerate(WAVES), (1e-3, 1e-6, 1e-9)):
        found, estimate, cost = waves(*case, tolerance)
        errors.append(float(np.abs(found - best[i]).max()) / tolerance)
        work += cost
        unsaid += errors[-1] > 1.0 and estimate < tolerance
    return Outcome({"a_0": max(errors)}, float(np.median(errors)), work, unsaid)


def measure_densities(best: list[np.ndarray]) -> Outcome:
    """All scenes and tolerances, as the constants are now."""
    errors, work, unsaid = [], 0.0, 0
    for case, rtol in itertools.product(range(len(SCENES)), (1e-2, 1e-3, 1e-4)):
        found, estimate, cost = density(case, rtol)
        errors.append(float(np.abs(found - best[case]).max()) / rtol)
        work += cost
        unsaid += errors[-1] > 1.0 and estimate < rtol
    return Outcome({"G(R)": max(errors)}, float(np.median(errors)), work, unsaid)


if __name__ == "__main__":
    best_densities = [density(case, 1e-6)[0] for case in range(len(SCENES))]
    scan(OF_DENSITIES, lambda: measure_densities(best_densities), "flops")
    best_waves = [waves(*case, 1e-12)[0] for case in WAVES]
    scan(OF_WAVES, lambda: measure_waves(best_waves), "flops")
