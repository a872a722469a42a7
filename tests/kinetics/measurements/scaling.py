"""Measures the constants of `kinetics.scaling` again: h, a2, moments and F(c) for many e and rtol.

References are the closed forms of ScalingSolution, with which the solver shares no method. The
work is the number of nodes solved for. Takes some minutes; names of constants as arguments choose.
"""

from __future__ import annotations

import itertools
from functools import lru_cache

import numpy as np
from scan import Constant, Outcome, scan

from kinetics import ScaledVDF, ScalingSolution, solve_scaled
from kinetics.scaling import log_density, low_speeds, tilted

RESTITUTIONS = (0.0, 1e-4, 0.05, 0.2, 0.3, 0.4, 0.5, 0.6, 0.65, 0.7, 0.8, 0.9, 0.99, 0.9999)
TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-12)
MOMENTS = (-2.0, -0.4, 0.5, 1.0, 3.0, 6.0, 8.0)
SPEEDS = np.array([1e-6, 1e-3, 0.03, 0.2, 0.6, 1.0, 1.5, 3.0, 8.0, 60.0])

CONSTANTS = [
    Constant(tilted, "_BULK_MARGIN", (-1.0, 1.0), add=True),
    Constant(tilted, "_MARGIN", (-1.5, 1.5), add=True),
    Constant(tilted, "_MORE_MODES", (-1.0, 1.0), add=True),
    Constant(tilted, "_MORE_WHERE_WIDE", (0.0, 1.6)),
    Constant(tilted, "_MISSED", (0.2, 5.0)),
    Constant(tilted, "_ROUNDING", (0.2, 5.0)),
    Constant(tilted, "_NARROW_ROUNDING", (0.2, 5.0)),
    Constant(tilted, "_NARROWEST", (-0.5, 0.5), add=True),
    Constant(tilted, "_DEFECT", (0.1, 10.0)),
    Constant(tilted, "_NARROW_DEFECT", (0.1, 10.0)),
    Constant(tilted, "_SPECTRUM", (0.1, 10.0)),
    Constant(tilted, "_FEW_BOUNCES", (0.7, 1.3)),
    Constant(tilted, "_BULK_DROP", (-1.5, 1.5), add=True),
    Constant(tilted, "_SIZING", (0.5, 1.6)),
    Constant(log_density, "_FIRST_TILT", (0.2, 3.0)),
    Constant(log_density, "_UNNOTICED", (0.5, 1.5)),
    Constant(log_density, "_FINER", (0.3, 3.0)),
    Constant(log_density, "_NOISE", (0.1, 10.0)),
    Constant(log_density, "_NEGLIGIBLE", (-3.0, 3.0), add=True),
    Constant(low_speeds, "_MORE_NODES", (-3, 3), add=True),
]


def moments(solution: ScalingSolution | ScaledVDF) -> np.ndarray:
    """h, 1 + a2 and the moments."""
    exist = [p for p in MOMENTS if solution.restitution > 0.0 or p > -1.0]
    return np.array(
        [solution.cooling_rate, 1.0 + solution.a2, *(solution.moment(p) for p in exist)]
    )


@lru_cache(maxsize=len(RESTITUTIONS))
def exact(e: float) -> tuple[np.ndarray, np.ndarray]:
    """The moments, and F at SPEEDS."""
    solution = ScalingSolution(e)
    return moments(solution), solution.vdf(SPEEDS)


def measure() -> Outcome:
    """All restitutions and tolerances, as the constants are now."""
    of_moments, of_density, work, unsaid = [], [], 0, 0
    for e, rtol in itertools.product(RESTITUTIONS, TOLERANCES):
        numbers, f = exact(e)
        seen = f > 1e-290
        first, second = solve_scaled(e, rtol), solve_scaled(e, rtol)
        of_moments.append(np.abs(moments(first) / numbers - 1.0).max() / rtol)
        of_density.append(np.abs(second.vdf(SPEEDS)[seen] / f[seen] - 1.0).max() / rtol)
        unsaid += of_moments[-1] > 1.0 and first.error_estimate < rtol
        unsaid += of_density[-1] > 1.0 and second.error_estimate < rtol
        work += first.nodes + second.nodes
    errors = {"moments": max(of_moments), "F(c)": max(of_density)}
    return Outcome(errors, float(np.median(of_moments + of_density)), work, unsaid)


if __name__ == "__main__":
    scan(CONSTANTS, measure, "nodes")
