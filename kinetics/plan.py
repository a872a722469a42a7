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

_SPEEDS = np.geomspace(0.01, 3.0, 50)  # in thermal ones: where a density may not be below zero


def make_plan(
    averages: Averages,
    outputs: Iterable[str],
    profiles: Mapping[int, Profile],
    displacement: Displacement | None,
) -> tuple[PlanStep, ...]:
    """What was solved, what was skipped, and why."""
    dimension, rows = averages.law.dimension, [OUTPUTS[name] for name in sorted(outputs)]
    asked = {row.step for row in rows}
    pairs = powers_of(outputs, dimension)
    moments = ", ".join(f"v^{p:g}" + (f" (m = {m})" if m else "") for p, m in pairs)
    moving = [row for row in rows if row.step == DISPLACEMENT]
    chain = len({y for row in moving for _, y, _ in row.made_of(dimension)})
    chains = f"{', '.join(r.name for r in moving)}: {chain} scalar equations and what drives them"
    solved = sorted({m for _, m in pairs} | set(profiles))
    isotropic = averages.state.highest_harmonic == 0
    kinds = ", ".join(sorted({profile.method for profile in profiles.values()}))
    velocity = f"backward equation for {moments}" if pairs else "no output needs them"
    if pairs and averages.elastic:
        velocity = "elastic: speeds are kept, harmonics relax at their own rates"
    medium = averages.law.medium
    points = f"{averages.speeds.x.size} weighted speeds represent it"
    others = "the start is isotropic" if isotropic else "no output needs more"
    waves = f"{displacement.wave_numbers} wave numbers" if displacement else "not asked for"
    steps = (
        ("scatterers met again", True, medium.level if medium else ""),
        (VELOCITY, bool(pairs) and not averages.elastic, velocity),
        ("initial state", True, points),
        (COLLISIONS, COLLISIONS in asked, "asked for"),
        (DISPLACEMENT, bool(moving), chains),
        (POSITION, displacement is not None, waves),
        (SCATTERING, SCATTERING in asked, "solved for the wave numbers that are asked for"),
        ("angular harmonics", bool(solved), f"m = {solved or 'none'}: {others}"),
        (DENSITIES, bool(profiles), f"{len(profiles)} harmonics, {kinds}"),
    )
    always = (VELOCITY, "angular harmonics")  # they say why in any case
    return tuple(
        PlanStep(part, done, why if done or part in always else "not asked for")
        for part, done, why in steps
        if why != ""  # dilute scatterers are not met again
    )


def limits(
    averages: Averages, profiles: Mapping[int, Profile], displacement: Displacement | None
) -> str:
    """Where the theory of a finite density is not to be trusted; empty where nothing is to say."""
    medium = averages.law.medium
    if medium is None:
        return ""
    found = medium.limits()
    if profiles:
        found += medium.limits_of_speeds() + _negative_density(averages, profiles[0])
    if displacement is not None:
        with np.errstate(over="ignore"):
            first = averages.times[0] / averages.mean_free_path
        found += medium.limits_of_displacements(first)
    return found


def _negative_density(averages: Averages, profile: Profile) -> str:
    """Where the speed density is below zero, as its operator allows; empty where it is not."""
    lowest, highest = 0.0, 0.0
    for i, log_unit in enumerate(averages.log_reference):
        if log_unit < -650.0:  # f itself is larger than the largest number there
            continue
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
