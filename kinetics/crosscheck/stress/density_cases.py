"""Cases of the speed density: nodes from 8 to 4096, rough starts, late times, both methods."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from kinetics.crosscheck.stress.case import Case, Outcome
from kinetics.crosscheck.stress.limits import (
    REFERENCE_SHARE,
    FloatArray,
    Law,
    as_law,
    below,
    finite,
    forgets,
    label_of,
    late_thermal_speed,
    other_laws,
    takes_single_shares,
)
from kinetics.crosscheck.stress.starts import solve_start

_TIMES = np.array([0.5, 30.0, 1e3])
_LATE = np.array([0.0, 1e-300, 1e150, 1e300])
_RTOL = 1e-6
_OUTPUTS = ("speed_density", "thermal_speed")
_SCALED_SPEEDS = np.concatenate([[0.0], np.geomspace(1e-8, 30.0, 4000)])


def density_cases(quick: bool) -> Iterator[Case]:
    """All of them, in groups."""
    some = (0.0, 0.7, 0.99) if quick else (0.0, 1e-10, 1e-4, 0.2, 0.5, 0.7, 0.9, 0.99, 0.999)
    group = "spectral density"
    for e in some:
        for count in (8, 64, 512, None) if quick else (8, 16, 64, 256, 1024, 4096, None):
            name = f"{label_of(e)}, gaussian, {count or 'its own'} nodes"
            yield Case(group, name, _spectral, (e, "gaussian", count))
        yield Case(group, f"{label_of(e)}, tail v^-6", _spectral, (e, "tail v^-6", None))
    laws = [law for law in other_laws(quick) if law.mean_log_loss > 1e-4]
    for law in laws:
        yield Case(group, f"{label_of(law)}, gaussian", _spectral, (law, "gaussian", None))
        sharp = not takes_single_shares(law)  # else such a start is refused
        for start in ("gaussian", "monoenergetic") if sharp else ("gaussian",):
            name = f"{label_of(law)}, {start}, t to 1e300"
            yield Case("late density", name, _late, (law, start, 1.0))
        for label in ("gaussian", "two delta peaks") if sharp else ("gaussian", "step"):
            name = f"{label_of(law)}, {label}, 512 nodes"
            yield Case("conservative density", name, _conservative, (law, label, 512))
    near = (1.0 - 1e-6, 1.0 - 1e-10, 1.0)
    for e in (*some[:2], *near[1:]) if quick else (*some, *near):
        for start in ("gaussian", "monoenergetic"):
            for scale in (1.0,) if quick else (1e-100, 1.0, 1e100):
                name = f"{label_of(e)}, {start}, speeds times {scale:g}, t to 1e300"
                yield Case("late density", name, _late, (e, start, scale))
    for e in some:
        for count in (8, 64, 512) if quick else (8, 16, 64, 256, 1024, 4096):
            for label in ("gaussian", "monoenergetic", "step", "two delta peaks", "tail v^-6"):
                name = f"{label_of(e)}, {label}, {count} nodes"
                yield Case("conservative density", name, _conservative, (e, label, count))


def _largest(errors: FloatArray) -> float:
    return float(np.max(errors)) if finite(errors) else math.inf


@lru_cache(maxsize=2)
def _tight(e: Law, label: str) -> list[FloatArray] | None:
    """The density at the scaled speeds, solved more tightly; one array for each time.

    None where it is not known well enough to judge another one.
    """
    found = solve_start(e, label, _TIMES, _OUTPUTS, 0.01 * _RTOL)
    pairs = enumerate(found.thermal_speed)
    values = [found.speed_density(v0 * _SCALED_SPEEDS)[i] for i, v0 in pairs]
    return values if found.error_estimate <= REFERENCE_SHARE * _RTOL else None


def _spectral(e: Law, label: str, nodes: int | None) -> Outcome:
    """The density against a tighter one, relative to its maximum; its mass and its sign.

    Below 1e-2 of the thermal speed it is the density of ln v that keeps its accuracy.
    """
    solution = solve_start(e, label, _TIMES, _OUTPUTS, _RTOL, nodes=nodes)
    tight = _tight(e, label)
    reached, low, mass = math.nan if tight is None else 0.0, 0.0, 0.0
    for i, v0 in enumerate(solution.thermal_speed):
        f = solution.speed_density(v0 * _SCALED_SPEEDS)[i]
        weight = np.minimum(1.0, _SCALED_SPEEDS / 1e-2)
        if tight is not None:
            apart = np.abs(f - tight[i]) * weight / np.max(tight[i])
            reached = max(reached, _largest(apart))
        elif not finite(f):
            reached = math.inf
        low = max(low, below(f) / float(f.max()))
        v = v0 * np.geomspace(1e-8, 1e3, 20_001)
        weight = solution.speed_density(v)[i] * v * math.log(v[1] / v[0])
        mass = max(mass, abs(float(weight.sum()) - 1.0))
    converged = solution.status.name == "CONVERGED"
    claimed = _RTOL if converged else math.inf
    return Outcome(
        asked=_RTOL,
        reached=reached,
        converged=converged,
        invariants={
            "density not negative": (low, claimed),
            "mass": (mass, 3.0 * claimed),  # rtol of the maximum, over a width of some v0
        },
        note=f"estimate {solution.error_estimate:.0e}",
    )


def _late(e: Law, start: str, scale: float) -> Outcome:
    """At t = 0 the start, at t = 1e300 the scaling state, without overflow anywhere."""
    from kinetics import Gaussian, Monoenergetic, ScalingSolution, Scene, solve

    gaussian = start == "gaussian"
    state = Gaussian(scale, scale) if gaussian else Monoenergetic(scale)
    rtol, law = 1e-4, as_law(e)
    d, elastic = law.dimension, law.is_elastic
    solution = solve(Scene(law, initial=state, times=_LATE, outputs=_OUTPUTS), rtol)
    c, width = np.geomspace(1e-3, 20.0, 300), 0.0
    if law.mean_log_loss < 1e-4:  # smooth disks: the late ring of nearly elastic tracers
        x = law.restitution or 0.0
        width = math.sqrt(0.2 * (1.0 - x) * (1.0 + x))
        c = 1.0 + np.concatenate([[-0.5, 0.5], width * np.linspace(-5.0, 5.0, 99)])
    at_first = law.unit_surface * c ** (d - 1) * (0.5 * d / math.pi) ** (0.5 * d)
    first = at_first * np.exp(-0.5 * d * c * c) if gaussian else np.zeros(c.size)
    last, slack = first, 0.0
    if law.mean_log_loss > 1e-4:
        last = law.unit_surface * c ** (d - 1) * ScalingSolution(**law.arguments).vdf(c)
    elif not elastic:  # the closed form has 1/(1 - e) factors; a Gaussian to about its width
        u = np.clip((c - 1.0) / width, -30.0, 30.0)
        last, slack = np.exp(-0.5 * u * u) / (width * math.sqrt(2.0 * math.pi)), 5.0 * width
    peak = np.array([0.0 if gaussian else 1.0] * 2 + [float(not gaussian and elastic)] * 2)
    reached = 0.0
    known = (first, first, last, last) if elastic or forgets(law) else (first, first)
    for i, expected in enumerate(known):
        # exact: an error of rtol would move a ring out of its place
        v0 = scale * math.sqrt(d if gaussian else 1.0)
        if i > 1 and not elastic:
            v0 = late_thermal_speed(law, solution.scene.mean_free_path, float(_LATE[i]))
        f = v0 * solution.speed_density(v0 * c)[i]
        reached = max(reached, _largest(np.abs(f - expected) / max(1.0, expected.max())))
    everywhere = solution.speed_density(np.array([0.0, 1e-300, scale, 1e300]))
    marginal = solution.velocity_component_density(np.array([-1e300, 0.0, 1e300]))
    return Outcome(
        asked=rtol + slack,
        reached=reached if finite(everywhere, marginal) else math.inf,
        converged=solution.status.name == "CONVERGED",
        in_part=not (elastic or forgets(law)),
        invariants={
            "density not negative": (below(everywhere) * scale, rtol),
            "uncollided": (float(np.max(np.abs(solution.uncollided - peak))), 1e-12),
        },
        note=f"estimate {solution.error_estimate:.0e}",
    )


def _conservative(e: Law, label: str, nodes: int) -> Outcome:
    """The conservative scheme: density not negative, its mass, and <v^2> as averaged.

    At the tightest tolerance the scheme itself serves all of the times. The density is linear in
    ln v between nodes: its integrals by the trapezoid rule with many points for each node.
    """
    solution = solve_start(e, label, _TIMES, _OUTPUTS, 1e-13, method="conservative", nodes=nodes)
    v0 = solution.thermal_speed
    v = np.geomspace(1e-8 * v0[-1], 1e6 * v0[0], max(200_001, 200 * nodes + 1))
    f = solution.speed_density(v)
    weight = f * v * math.log(v[1] / v[0])
    mass = weight.sum(axis=1) + solution.uncollided
    energy = weight @ v**2 + solution.uncollided
    found = np.abs([energy / v0**2 - 1.0, mass - 1.0])
    estimate = solution.error_estimate
    return Outcome(
        # the interpolation between nodes adds to the scheme's own error
        asked=max(3.0 * estimate, 1e-5) if estimate < 1.0 else math.inf,
        reached=float(np.max(found)) if finite(f) else math.inf,
        invariants={
            "density not negative": (below(f), 0.0),
            # no number of nodes reaches 1e-13
            "status says so": (float(solution.status.name == "CONVERGED"), 0.0),
        },
        note=f"estimate {estimate:.0e}",
    )
