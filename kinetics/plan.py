"""What a solve did: the steps, which of them the scene needed, and why; and figures of the work."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from kinetics.densities.harmonic import Profile
from kinetics.moments.velocity import Averages
from kinetics.outputs import (
    COLLISIONS,
    DENSITIES,
    DISPLACEMENT,
    OUTPUTS,
    POSITION,
    SCATTERING,
    VELOCITY,
    powers_of,
)
from kinetics.position.density import Displacement
from kinetics.status import PlanStep

SCATTERERS = "scatterers met again"
NOT_ASKED = "not asked for"
# Against hard disks: see `kinetics.collision.medium`
_LOW_SPEEDS = "; the speed density is less certain below 0.4 of the thermal speed"
_LEAST = -650.0  # of ln(v0/U), v0 the thermal speed
_SPEEDS = np.geomspace(0.01, 3.0, 50)  # in thermal ones: where a density may not be below zero


def make_plan(
    averages: Averages,
    outputs: Iterable[str],
    profiles: Mapping[int, Profile],
    displacement: Displacement | None,
) -> tuple[PlanStep, ...]:
    """What was solved, what was skipped, and why."""
    pairs = powers_of(outputs, averages.law.dimension)
    solved = sorted({m for _, m in pairs} | set(profiles))
    isotropic = averages.state.highest_harmonic == 0
    others = "the start is isotropic" if isotropic else "no output needs more"
    points = averages.speeds.x.size
    return (
        *_scatterers_step(averages),
        _moments_step(averages, pairs),
        PlanStep("initial state", True, f"{points} weighted speeds represent it"),
        _asked_step(COLLISIONS, outputs, "asked for"),
        _displacement_step(averages, outputs),
        PlanStep(
            POSITION,
            displacement is not None,
            f"{displacement.wave_numbers} wave numbers" if displacement else NOT_ASKED,
        ),
        _asked_step(SCATTERING, outputs, "solved for the wave numbers that are asked for"),
        PlanStep("angular harmonics", bool(solved), f"m = {solved or 'none'}: {others}"),
        _densities_step(profiles),
    )


def _scatterers_step(averages: Averages) -> tuple[PlanStep, ...]:
    """The level of the theory of a finite density; nothing where scatterers are dilute."""
    level, _ = averages.law.density_theory(0.0)
    return (PlanStep(SCATTERERS, True, level),) if level else ()


def limits(averages: Averages, profiles: Mapping[int, Profile] | None = None) -> str:
    """Where the theory of a finite density is not to be trusted; empty where nothing is to say."""
    with np.errstate(over="ignore"):
        first = averages.times[0] / averages.mean_free_path
    found = averages.law.density_theory(first)[1]
    if profiles and averages.law.returns(0)[0]:
        found += _LOW_SPEEDS + _negative_density(averages, profiles[0])
    return found


def _negative_density(averages: Averages, profile: Profile) -> str:
    """Where the speed density is below zero, as its operator allows; empty where it is not."""
    lowest, highest = 0.0, 0.0
    for i, log_unit in enumerate(averages.log_reference):
        if log_unit < _LEAST:
            continue  # f itself is larger than the largest number there
        f = profile.at(i, np.exp(log_unit) * _SPEEDS).real
        share = f / max(float(f.max()), 1e-300)
        lowest = min(lowest, float(share.min()))
        highest = max(highest, float(_SPEEDS[share < -averages.rtol].max(initial=0.0)))
    if highest == 0.0:
        return ""
    return (
        f"; the speed density is negative, by up to {-lowest:.0e} of its maximum, at speeds below "
        f"{highest:.2g} of the thermal one: what slow tracers do is beyond the theory"
    )


def _asked_step(step: str, outputs: Iterable[str], reason: str) -> PlanStep:
    asked = any(OUTPUTS[name].step == step for name in outputs)
    return PlanStep(step, asked, reason if asked else NOT_ASKED)


def _moments_step(averages: Averages, pairs: list[tuple[float, int]]) -> PlanStep:
    if not pairs:
        return PlanStep(VELOCITY, False, "no output needs them")
    if averages.elastic:
        why = "elastic: speeds are kept, harmonics relax at their own rates"
        return PlanStep(VELOCITY, False, why)
    moments = ", ".join(f"v^{p:g}" + (f" (m = {m})" if m else "") for p, m in pairs)
    return PlanStep(VELOCITY, True, f"backward equation for {moments}")


def _displacement_step(averages: Averages, outputs: Iterable[str]) -> PlanStep:
    asked = set(outputs)
    rows = [row for row in OUTPUTS.values() if row.name in asked and row.step == DISPLACEMENT]
    if not rows:
        return PlanStep(DISPLACEMENT, False, NOT_ASKED)
    count = len({y for row in rows for _, y, _ in row.made_of(averages.law.dimension)})
    how = f"{count} scalar equations and what drives them"
    return PlanStep(DISPLACEMENT, True, f"{', '.join(row.name for row in rows)}: {how}")


def _densities_step(profiles: Mapping[int, Profile]) -> PlanStep:
    if not profiles:
        return PlanStep(DENSITIES, False, NOT_ASKED)
    kinds = sorted({profile.method for profile in profiles.values()})
    return PlanStep(DENSITIES, True, f"{len(profiles)} harmonics, {', '.join(kinds)}")


def make_stats(
    averages: Averages, profiles: Mapping[int, Profile], displacement: Displacement | None
) -> dict[str, Any]:
    """Numbers about the work: points of the initial state, panels, nodes, wave numbers."""
    stats: dict[str, Any] = {"initial_points": int(averages.speeds.x.size)}
    if not averages.elastic:
        stats["panels"] = averages.equation.count
        stats["nodes_per_panel"] = averages.equation.nodes
    for m, profile in profiles.items():
        stats[f"density_nodes_m{m}"] = profile.nodes
    if displacement is not None:
        stats["wave_numbers"] = displacement.wave_numbers
        stats["position_density_error"] = displacement.error_estimate
        # how many systems of so many equations were solved for F(k)
        stats["systems"] = {str(size): count for size, count in displacement.systems.items()}
    return stats
