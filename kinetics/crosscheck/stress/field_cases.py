"""Cases of a uniform field: extreme restitutions, fields and starts."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from kinetics.crosscheck.stress.case import Case, Outcome
from kinetics.crosscheck.stress.limits import FEWER, Law, above, finite, label_of, other_laws

_OUTPUTS = ("mean_velocity", "thermal_speed", "mean_displacement", "collisions")
_SPEEDS = (1e-12, 1e-6, 1e-2, 1.0, 1e3, 1e6)  # of a start, in sqrt(g l)


def field_cases(quick: bool) -> Iterator[Case]:
    """All of them, in groups."""
    laws: list[Law] = [e for e in FEWER if e < 1.0]
    if not quick:
        laws += [law for law in other_laws(True) if not law.is_elastic]
    for law in laws[:1] + laws[-1:] if quick else laws:
        for rtol in (1e-6,) if quick else (1e-3, 1e-6, 1e-10):
            yield Case("steady state", f"{label_of(law)}, rtol {rtol:.0e}", _steady, (law, rtol))
    for e in (0.7,) if quick else (0.0, 1e-10, 0.7, 1.0 - 1e-10, 1.0):
        for field in (1e12,) if quick else (1e-12, 1.0, 1e12):
            name = f"{label_of(e)}, rest, field {field:g}"
            yield Case("over time in a field", name, _over_time, (e, "rest", 1.0, field))
        for label in () if quick else ("gaussian", "beam"):
            for speed in _SPEEDS:
                name = f"{label_of(e)}, {label}, {speed:g} sqrt(g l)"
                field = 0.08 / speed**2
                yield Case("over time in a field", name, _over_time, (e, label, speed, field))


def _steady(law: Law, rtol: float) -> Outcome:
    """Against the exact relations <v^2 cos> = 1/lambda_1(1) and 2 <v_x> = lambda(2) <v^3>."""
    from kinetics import solve_field

    found = solve_field(law, rtol=rtol)
    fixed = found.moment(2.0, 1) * float(found.law.harmonic_decay_rate(1.0, 1)) - 1.0
    energy = float(found.law.decay_rate(2.0)) * found.moment(3.0) / (2.0 * found.drift) - 1.0
    figures = found.drift, found.mean_square_speed, found.mean_square_along, found.mean_speed
    reached = max(abs(fixed), abs(energy)) if finite(np.array(figures)) else math.inf
    spread = found.drift / math.sqrt(found.mean_square_along)
    return Outcome(
        asked=rtol + 1e-12,
        reached=reached,
        converged=found.status.name == "CONVERGED",
        invariants={"<v_x>^2 <= <v_x^2>": (above(np.array([spread])), 0.0)},
    )


def _over_time(e: float, label: str, speed: float, field: float) -> Outcome:
    """Averages over time, up to 10 sqrt(l/g).

    Elastic tracers keep <v^2> - 2 g <x>. Others lose some of it, and are compared with a solution
    of a smaller rtol.
    """
    from kinetics import Beam, InputError, Scene, solve

    initial: Any = Beam(2.0, "monoenergetic") if label == "beam" else label
    path = 12.5  # of the default density
    unit = math.sqrt(path / field)
    scene = Scene(
        e,
        times=np.array([1e-3, 0.1, 1.0, 10.0]) * unit,
        field=field,
        initial=initial,
        outputs=_OUTPUTS,
    )
    rtol = 1e-3
    try:
        found = solve(scene, rtol)
        finer = found if e == 1.0 else solve(scene, 0.1 * rtol)
    except InputError as refused:  # fast starts of which next to nothing is left
        return Outcome(asked=rtol, converged=False, note=str(refused))
    square = found.thermal_speed**2
    given = 2.0 * field * found.mean_displacement[:, 0]
    start = {"rest": 0.0, "gaussian": 2.0, "beam": 1.0}[label]
    scale = np.maximum(square, start)
    if e == 1.0:
        reached = float(np.max(np.abs(square - start - given) / (scale + np.abs(given))))
    else:
        apart = np.linalg.norm(found.mean_velocity - finer.mean_velocity, axis=1)
        changes = apart / finer.thermal_speed, found.thermal_speed / finer.thermal_speed - 1.0
        reached = float(np.max(np.abs(changes)))
    if not finite(*found.values.values()):
        reached = math.inf
    gained = (square - start - given) / (scale + np.abs(given))
    mean = np.linalg.norm(found.mean_velocity, axis=1) / found.thermal_speed
    return Outcome(
        asked=rtol,
        reached=reached,
        converged=found.status.name == "CONVERGED",
        invariants={
            "no more energy than the field gives": (above(gained, 0.0), 3.0 * rtol),
            "<v>^2 <= <v^2>": (above(mean), rtol),
        },
        note=f"{found.stats['harmonics']} harmonics, {found.stats['steps']} steps",
    )
