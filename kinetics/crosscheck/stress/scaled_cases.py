"""Cases of the scaled equation: restitutions, tolerances, and numbers of nodes."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from kinetics.crosscheck.stress.case import Case, Outcome, named
from kinetics.crosscheck.stress.limits import FEWER, RESTITUTIONS, label_of, scaling


def scaled_cases(quick: bool) -> Iterator[Case]:
    """All of them, in groups."""
    for e in FEWER if quick else RESTITUTIONS:
        if e == 1.0:  # refused: there is no scaling state
            continue
        for rtol in (1e-4, 1e-12) if quick else (1e-1, 1e-3, 1e-6, 1e-9, 1e-12, 1e-13):
            name = f"{label_of(e)}, rtol {rtol:.0e}"
            yield named("scaled equation", name, _scaled, e, rtol, None)
    few = (0.0, 0.2, 0.7, 0.99)
    for e in few if quick else (0.0, 1e-10, 0.2, 0.7, 0.99, 1.0 - 1e-10):
        for nodes in (8, 16, 64, 256) if quick else (8, 12, 16, 32, 64, 256, 1024, 4096):
            name = f"{label_of(e)}, {nodes} nodes"
            yield named("scaled equation, nodes given", name, _scaled, e, 1e-12, nodes)


def _scaled(e: float, rtol: float, nodes: int | None) -> Outcome:
    """h and a2 against closed forms; norm, <c^2> = 1 and positivity of F."""
    from kinetics import solve_scaled

    state = solve_scaled(e, rtol, nodes)
    h, one_a2, *_ = scaling(e)
    c = np.geomspace(1e-3, 30.0, 400)
    F = state.vdf(c)
    reached = max(abs(state.cooling_rate / h - 1.0), abs((1.0 + state.a2) / one_a2 - 1.0))
    estimate, converged = state.error_estimate, state.status.name == "CONVERGED"
    claimed = max(rtol, 1e-12) if converged else math.inf
    # with the nodes given, it is the estimate that must hold
    asked = rtol if nodes is None else max(rtol, estimate)
    if not (math.isfinite(reached) and np.all(np.isfinite(F))):
        reached = math.inf
    return Outcome(
        asked=asked,
        reached=reached,
        converged=converged,
        invariants={
            "F not negative": (max(0.0, -float(F.min())), 0.0),
            "<c^2> = 1": (abs(state.moment(2.0) - 1.0), claimed),
            "<c^0> = 1": (abs(state.moment(0.0) - 1.0), claimed),
        },
        note=f"estimate {estimate:.1e}",
    )
