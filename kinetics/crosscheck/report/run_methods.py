"""Asks the witnesses: solves and simulates one restitution, and reduces the runs to evidence."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from kinetics.crosscheck.report.case import Array, Case, Measured, ParticleEvidence
from kinetics.crosscheck.report.histograms import jackknife_error, measured_exponent, scaled_density
from kinetics.crosscheck.report.row import cooling_rate_between, msd_slope_between
from kinetics.crosscheck.report.settings import ReportSettings
from kinetics.errors import InputError

if TYPE_CHECKING:
    from kinetics import Solution
    from particles import BoltzmannGrad, HardDisks
    from particles.ensemble import Ensemble
    from particles.estimators import Estimate

PAPER_CAP = 100
"""Collisions after which the paper stops a sample."""
GROUPS = 100
"""Independent groups that a Boltzmann-Grad run is split into for its jackknife."""
OUTPUTS = ("thermal_speed", "a2", "msd", "kurtosis", "speed_density")
LATE_OUTPUTS = ("thermal_speed", "a2", "msd", "kurtosis", "diffusion_coefficient")
LATEST, LATE_TIMES = 1e9, 55
"""Last time in d/U of the equation alone, and how many there are, evenly spaced in ln t."""
SPEED_EDGES = np.concatenate([np.linspace(0.0, 2.0, 21), np.linspace(2.25, 6.0, 16)])
"""Bins of c = v/v0 for F(c)."""
POSITION_EDGES = np.concatenate([np.linspace(0.0, 3.0, 31), np.linspace(3.25, 6.0, 12)])
"""Bins of R = r/sqrt(<r^2>) for G(R)."""


def output_times(last: float, count: int) -> Array:
    """`count` times up to the last, evenly spaced in ln t from 1 d/U (or a tenth of the last)."""
    return np.geomspace(min(1.0, last / 10), last, count)


def media(settings: ReportSettings) -> "tuple[BoltzmannGrad, HardDisks]":
    """The media of both particle runs. ValueError for a density at which disks cannot be placed."""
    from particles import BoltzmannGrad, HardDisks

    density = settings.number_density
    return BoltzmannGrad(density), HardDisks(density, settings.count)


def gather_case(
    restitution: float, last: float, settings: ReportSettings, tell: Callable[[str], None]
) -> Case:
    """Every witness on one restitution, until the last time (in d/U). Calls `tell` three times.

    ValueError, before anything is solved, for a system that cannot be simulated.
    """
    from kinetics import ScalingSolution, Scene, solve, solve_scaled
    from particles import simulate

    e = restitution
    times = output_times(last, settings.n_times)
    free_medium, disk_medium = media(settings)

    def equation(
        number_density: float,
        times: Array = times,
        outputs: tuple[str, ...] = OUTPUTS,
        rtol: float = settings.rtol,
    ) -> "Solution":
        scene = Scene(
            restitution=e,
            number_density=number_density,
            initial="gaussian",
            times=times,
            outputs=outputs,
        )
        return solve(scene, rtol=rtol)

    tell(f"e = {e:g}: kinetic equation")
    kinetic = equation(settings.number_density)
    late = equation(
        settings.number_density,
        np.geomspace(times[0], max(LATEST, 10 * last), LATE_TIMES),
        LATE_OUTPUTS,
    )
    position = equation(
        settings.number_density,
        times[-1:],
        ("msd", "position_density"),
        settings.position_rtol,
    )
    exact = ScalingSolution(e) if e < 1 else None
    scaled = solve_scaled(restitution=e, rtol=settings.rtol) if e < 1 else None

    early = int(np.searchsorted(times, last / 10))
    index = settings.restitutions.index(e)
    tell(f"e = {e:g}: Boltzmann-Grad particles")
    groups = min(GROUPS, settings.free_tracers // 2)
    free = simulate(
        free_medium,
        restitution=e,
        times=times,
        media=groups,
        tracers=settings.free_tracers // groups,
        seed=settings.seed + 2 * index,
        workers=settings.workers,
        observables=("finals",),
    )
    tell(f"e = {e:g}: hard disks")
    disks = simulate(
        disk_medium,
        restitution=e,
        times=times,
        media=settings.media,
        tracers=settings.tracers,
        seed=settings.seed + 2 * index + 1,
        workers=settings.workers,
        observables=("finals",),
    )
    path = float(disks.mean_free_path.value)
    if not np.isfinite(path):
        raise InputError(
            f"final_times: got {last:g}; no hard-disk tracer has collided by then, some must"
        )
    rescaled = equation(1 / (2 * path))
    return Case(
        restitution=e,
        times=times,
        early=early,
        speed_edges=SPEED_EDGES,
        position_edges=POSITION_EDGES,
        exact=exact,
        scaled=scaled,
        kinetic=kinetic,
        rescaled=rescaled,
        late=late,
        position=position,
        free=_evidence("Boltzmann-Grad", free, early, settings.number_density),
        disks=_evidence("hard disks", disks, early, settings.number_density),
        rescaled_errors=_rescaled_errors(disks, rescaled, early, settings.number_density),
    )


def _evidence(name: str, run: "Ensemble", early: int, number_density: float) -> ParticleEvidence:
    """The run reduced to arrays; every error is a jackknife over its configurations."""
    by_group = run.finals.reshape(run.media, run.tracers, -1)
    log_speed, _, x, y, collisions = np.moveaxis(by_group, -1, 0)
    speeds = np.exp(log_speed)
    # What was caught in a corner is at rest there.
    caught = run.statuses.trap_tracers
    speeds[caught[:, 0], caught[:, 1]] = 0.0

    def slopes(part: "Ensemble") -> tuple[float, float]:
        return (
            cooling_rate_between(run.times, part.thermal_speed.value, early, number_density),
            msd_slope_between(run.times, part.msd.value, early),
        )

    cooling_rate, msd_slope = (
        Measured(np.asarray(value), jackknife_error(replicates))
        for value, replicates in zip(
            slopes(run), np.array([slopes(part) for part in _without_each(run)]).T, strict=True
        )
    )
    distances = np.hypot(x, y)
    return ParticleEvidence(
        name=name,
        samples=run.media * run.tracers,
        groups=run.media,
        thermal_speed=_measured(run.thermal_speed),
        a2=_measured(run.a2),
        msd=_measured(run.msd),
        kurtosis=_measured(run.kurtosis),
        cooling_rate=cooling_rate,
        msd_slope=msd_slope,
        free_path=_measured(run.mean_free_path),
        vdf=scaled_density(speeds, SPEED_EDGES, np.pi * np.diff(SPEED_EDGES**2)),
        position=scaled_density(distances, POSITION_EDGES, np.diff(POSITION_EDGES)),
        tail_exponent=measured_exponent(distances),
        mean_collisions=float(np.mean(collisions)),
        most_collisions=int(np.max(collisions)),
        above_cap=float(np.mean(collisions > PAPER_CAP)),
        statuses={
            "finished": run.statuses.finished,
            "trapped": run.statuses.trapped,
            "escaped": run.statuses.escaped,
        },
    )


def _measured(estimate: "Estimate") -> Measured:
    return Measured(np.asarray(estimate.value), np.asarray(estimate.error))


def _without_each(run: "Ensemble") -> Iterator["Ensemble"]:
    """The ensemble without one of its configurations, for each: their sums just add up."""
    sums = {name: run.arrays[name] for name in ("moments", "path_sums")}
    totals = {name: array.sum(axis=0) for name, array in sums.items()}
    for left_out in range(run.media):
        rest = {name: (totals[name] - sums[name][left_out])[None] for name in sums}
        yield replace(run, arrays={**run.arrays, **rest})


def _rescaled_errors(
    run: "Ensemble", rescaled: "Solution", early: int, number_density: float
) -> dict[str, Array]:
    """Errors of data minus theory where the theory has the run's own mean free path l put in.

    Both move when a configuration is left out. The theory moves by its derivative in ln l, which
    follows from dimensions: v0 and a2 depend on t/l alone, <r^2> on l^2 times such a function.
    """
    log_path = np.log(float(run.mean_free_path.value))
    times = run.times

    def per_log_path(values: Array, power: int) -> Array:
        return np.asarray(power * values - np.gradient(values, np.log(times)))

    speed_slope = per_log_path(rescaled.thermal_speed, 0)
    shifts = {
        "thermal_speed": speed_slope,
        "a2": per_log_path(rescaled.a2, 0),
        "msd": per_log_path(rescaled.msd, 2),
        "kurtosis": per_log_path(rescaled.kurtosis, 0),
    }
    replicates: dict[str, list[Array]] = {
        name: [] for name in (*shifts, "cooling_rate", "msd_slope")
    }
    for part in _without_each(run):
        moved = np.log(float(part.mean_free_path.value)) - log_path
        for name, shift in shifts.items():
            replicates[name].append(getattr(part, name).value - moved * shift)
        data, theory = (
            cooling_rate_between(times, speed, early, number_density)
            for speed in (
                part.thermal_speed.value,
                rescaled.thermal_speed + moved * speed_slope,
            )
        )
        replicates["cooling_rate"].append(np.asarray(data - theory))
        data, theory = (
            msd_slope_between(times, msd, early)
            for msd in (part.msd.value, rescaled.msd + moved * shifts["msd"])
        )
        replicates["msd_slope"].append(np.asarray(data - theory))
    return {name: jackknife_error(np.array(values)) for name, values in replicates.items()}
