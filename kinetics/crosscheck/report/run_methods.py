"""Runs the solver and the particles on one restitution, and reduces the runs to a `Case`."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from kinetics import ScalingSolution, Scene, Solution, solve, solve_scaled
from kinetics.collision import CollisionLaw
from kinetics.collision.medium import HIGHEST_DENSITY
from kinetics.crosscheck.report.case import Array, Case, Measured, ParticleRun
from kinetics.crosscheck.report.observables import (
    ball,
    cooling_rate_between,
    jackknife_error,
    measured_exponent,
    msd_slope_between,
    scaled_density,
)
from kinetics.crosscheck.report.row import OVER_TIME
from kinetics.crosscheck.report.settings import ReportSettings, half_cross_section
from kinetics.validation import refuse
from particles import BoltzmannGrad, HardDisks, HardSpheres, Medium, simulate
from particles.arguments import check_workers, make_plan
from particles.ensemble import Ensemble
from particles.estimators import Estimate
from particles.memory import require_memory

PAPER_CAP = 100
"""Collisions after which the paper stops a sample."""
GROUPS = 100
"""Independent groups that a Boltzmann-Grad run is split into for its jackknife."""
OUTPUTS = ("thermal_speed", "a2", "msd", "kurtosis", "speed_density")
LATE_OUTPUTS = ("thermal_speed", "a2", "msd", "kurtosis", "diffusion_coefficient")
DENSE_OUTPUTS = ("thermal_speed", "a2", "msd")
LATEST, LATE_TIMES = 1e9, 55
"""Last time in d/U of the equation alone, and how many there are, evenly spaced in ln t."""
SPEED_EDGES = np.concatenate([np.linspace(0.0, 2.0, 21), np.linspace(2.25, 6.0, 16)])
"""Bins of c = v/v0 for F(c)."""
POSITION_EDGES = np.concatenate([np.linspace(0.0, 3.0, 31), np.linspace(3.25, 6.0, 12)])
"""Bins of R = r/sqrt(<r^2>) for G(R)."""


def output_times(last: float, count: int) -> Array:
    """`count` times up to the last, evenly spaced in ln t from 1 d/U (or a tenth of the last)."""
    return np.geomspace(min(1.0, last / 10), last, count)


def gather_case(
    restitution: float, last: float, settings: ReportSettings, tell: Callable[[str], None]
) -> Case:
    """What every method gives for one restitution, until the last time (in d/U).

    Calls `tell` three times. ValueError, before anything is solved, for a system that cannot be
    simulated.
    """
    e, law = restitution, settings.law(restitution)
    times = output_times(last, settings.n_times)
    early = int(np.searchsorted(times, last / 10))
    seed = settings.seed + 2 * settings.restitutions.index(e)
    _, hard_medium = _media(settings)

    plan = make_plan(
        hard_medium, e, "gaussian", times, ("finals",), settings.tangential_restitution,
        media=settings.media, tracers=settings.tracers, seed=seed + 1, max_collisions=None,
    )  # fmt: skip
    require_memory(plan, check_workers(settings.workers))
    tell(f"e = {e:g}: kinetic equation")
    solved = _solutions(law, times, settings)
    tell(f"e = {e:g}: Boltzmann-Grad particles")
    free = free_run(e, times, seed, settings)
    name = f"hard {settings.scatterers}"
    tell(f"e = {e:g}: {name}")
    counts = {"media": settings.media, "tracers": settings.tracers}
    hard = _followed(hard_medium, e, times, seed + 1, settings, **counts)
    path = float(hard.mean_free_path.value)
    if not np.isfinite(path):
        refuse("until", last, f"no tracer among {name} has collided by then, some must")
    thinner = 1 / (2 * path) / half_cross_section(settings.dimension)
    rescaled = solution(law, thinner, times, OUTPUTS, settings.rtol)
    return Case(
        restitution=e,
        law=law,
        times=times,
        early=early,
        speed_edges=SPEED_EDGES,
        position_edges=POSITION_EDGES,
        rescaled=rescaled,
        free=reduced("Boltzmann-Grad", free, early, settings.half_rate),
        hard=reduced(name, hard, early, settings.half_rate),
        **_of_hard_disks(law, times, settings),
        rescaled_errors=_rescaled_errors(hard, rescaled, early, settings.half_rate),
        **solved,
    )


def free_run(e: float, times: Array, seed: int, settings: ReportSettings) -> Ensemble:
    """Tracers of the Boltzmann-Grad limit, in groups for the jackknife."""
    groups = min(GROUPS, settings.free_tracers // 2)
    counts = {"media": groups, "tracers": settings.free_tracers // groups}
    return _followed(_media(settings)[0], e, times, seed, settings, **counts)


def _followed(
    medium: Medium, e: float, times: Array, seed: int, settings: ReportSettings, **counts: int
) -> Ensemble:
    return simulate(
        medium, restitution=e, times=times, seed=seed, workers=settings.workers,
        observables=("finals",), tangential_restitution=settings.tangential_restitution,
        media=counts["media"], tracers=counts["tracers"],
    )  # fmt: skip


def _media(settings: ReportSettings) -> tuple[Medium, Medium]:
    """The Boltzmann-Grad limit, and hard disks or spheres."""
    density, count = settings.number_density, settings.count
    if settings.dimension == 3:
        return BoltzmannGrad(density, dimension=3), HardSpheres(density, count=count)
    return BoltzmannGrad(density), HardDisks(density, count)


def _solutions(law: CollisionLaw, times: Array, settings: ReportSettings) -> dict[str, Any]:
    """The kinetic equation and its scaling state, as fields of `Case`."""
    density, rtol = settings.number_density, settings.rtol
    late = np.geomspace(times[0], max(LATEST, 10 * times[-1]), LATE_TIMES)
    place = ("msd", "position_density")
    return {
        "kinetic": solution(law, density, times, OUTPUTS, rtol),
        "late": solution(law, density, late, LATE_OUTPUTS, rtol),
        "position": solution(law, density, times[-1:], place, settings.position_rtol),
        **scaling_states(law, rtol),
    }


def scaling_states(law: CollisionLaw, rtol: float) -> dict[str, Any]:
    """The scaling state in closed form and as solved, as fields of `Case`; None if elastic."""
    if law.is_elastic:
        return {"exact": None, "scaled": None}
    solved = solve_scaled(**law.arguments, rtol=rtol)
    return {"exact": ScalingSolution(**law.arguments), "scaled": solved}


def _of_hard_disks(law: CollisionLaw, times: Array, settings: ReportSettings) -> dict[str, Any]:
    """The equation of hard disks at their density, as fields of `Case`."""
    density, rtol = settings.number_density, settings.rtol
    late = np.array([LATEST / 10, LATEST])
    far = None if law.is_elastic else dense_solution(law, density, late, rtol)
    slope = None if far is None else msd_slope_between(late, far.msd, 0)
    return {"dense": dense_solution(law, density, times, rtol), "dense_slope": slope}


def dense_solution(law: CollisionLaw, density: float, times: Array, rtol: float) -> Solution | None:
    """The equation of hard disks at this density (in d^-2), which forgets no scatterer.

    None for what it does not have: spheres, rough disks, and densities that are too high.
    """
    if law.dimension != 2 or law.tangential_restitution != 1 or density > HIGHEST_DENSITY:
        return None
    scene = Scene(
        number_density=density, times=times, outputs=DENSE_OUTPUTS, scatterers="hard disks",
        **law.arguments,
    )  # fmt: skip
    return solve(scene, rtol=rtol)


def solution(
    law: CollisionLaw, density: float, times: Array, outputs: tuple[str, ...], rtol: float
) -> Solution:
    """The kinetic equation from a Gaussian start; times in d/U, density in d^-2 or d^-3."""
    scene = Scene(number_density=density, times=times, outputs=outputs, **law.arguments)
    return solve(scene, rtol=rtol)


def reduced(name: str, run: Ensemble, early: int, half_rate: float) -> ParticleRun:
    """The run reduced to arrays; every error is a jackknife over its configurations."""
    by_group = run.finals.reshape(run.media, run.tracers, -1)
    log_speed, _, x, y, collisions, *z = np.moveaxis(by_group, -1, 0)
    speeds = np.exp(log_speed)
    # A tracer that was trapped in a corner is at rest there.
    caught = run.statuses.trap_tracers
    speeds[caught[:, 0], caught[:, 1]] = 0.0

    replicates = [_values(part, early, half_rate) for part in _without_each(run)]
    slopes = {
        name: Measured(
            _values(run, early, half_rate)[name],
            jackknife_error(np.array([values[name] for values in replicates])),
        )
        for name in ("cooling_rate", "msd_slope")
    }
    distances = np.hypot(x, y)
    for third in z:
        distances = np.hypot(distances, third)
    d = run.medium.dimension
    return ParticleRun(
        name=name,
        samples=run.media * run.tracers,
        groups=run.media,
        **{name: _measured(getattr(run, name)) for name in OVER_TIME},
        **slopes,
        free_path=_measured(run.mean_free_path),
        vdf=scaled_density(speeds, SPEED_EDGES, ball(d) * np.diff(SPEED_EDGES**d)),
        position=scaled_density(distances, POSITION_EDGES, np.diff(POSITION_EDGES)),
        tail_exponent=measured_exponent(distances, d),
        mean_collisions=float(np.mean(collisions)),
        most_collisions=int(np.max(collisions)),
        above_cap=float(np.mean(collisions > PAPER_CAP)),
        statuses={name: getattr(run.statuses, name) for name in ("finished", "trapped", "escaped")},
    )


def _measured(estimate: Estimate) -> Measured:
    return Measured(np.asarray(estimate.value), np.asarray(estimate.error))


def _without_each(run: Ensemble) -> Iterator[Ensemble]:
    """The ensemble without one of its configurations, for each of them.

    Its averages are made of sums over configurations.
    """
    sums = {name: run.arrays[name] for name in ("moments", "path_sums")}
    totals = {name: array.sum(axis=0) for name, array in sums.items()}
    for left_out in range(run.media):
        rest = {name: (totals[name] - sums[name][left_out])[None] for name in sums}
        yield replace(run, arrays={**run.arrays, **rest})


def _values(run: Ensemble, early: int, half_rate: float) -> dict[str, Array]:
    averages = {name: np.asarray(getattr(run, name).value) for name in OVER_TIME}
    return _with_slopes(run.times, averages, early, half_rate)


def _with_slopes(
    times: Array, averages: dict[str, Array], early: int, half_rate: float
) -> dict[str, Array]:
    """Averages over time, and the cooling rate and the slope of <r^2> that they give."""
    rate = cooling_rate_between(times, averages["thermal_speed"], early, half_rate)
    slope = msd_slope_between(times, averages["msd"], early)
    return averages | {"cooling_rate": np.asarray(rate), "msd_slope": np.asarray(slope)}


def _rescaled_errors(
    run: Ensemble, rescaled: Solution, early: int, half_rate: float
) -> dict[str, Array]:
    """Standard errors of data minus theory, the theory having the run's own mean free path l.

    Both change when a configuration is left out: the theory by its derivative in ln l, which
    follows from dimensions: v0 and a2 depend on t/l alone, <r^2> is l^2 times a function of t/l.
    """
    theory = {name: np.asarray(getattr(rescaled, name)) for name in OVER_TIME}
    per_log_path = {
        name: (2 * values if name == "msd" else 0) - np.gradient(values, np.log(run.times))
        for name, values in theory.items()
    }
    log_path = np.log(float(run.mean_free_path.value))
    replicates = []
    for part in _without_each(run):
        moved = np.log(float(part.mean_free_path.value)) - log_path
        expected = {name: values + moved * per_log_path[name] for name, values in theory.items()}
        expected = _with_slopes(run.times, expected, early, half_rate)
        measured = _values(part, early, half_rate)
        replicates.append({name: measured[name] - expected[name] for name in measured})
    return {
        name: jackknife_error(np.array([values[name] for values in replicates]))
        for name in replicates[0]
    }
