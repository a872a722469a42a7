"""Tracers that fall among hard disks at a finite density: how fast, and how soon they are trapped.

The equation is that of the limit of low density. Disks that stand close are met sooner, and are
met again; and a tracer may come to rest in a corner of two disks, from which the field does not let
it go. Lengths in d, and the field is such that g l = U^2, with l = 1/(2 d rho) of the dilute limit.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kinetics.crosscheck.report.case import Array, Mask, Measured
from kinetics.crosscheck.report.field_rows import SOLVER
from kinetics.crosscheck.report.field_runs import FORGOTTEN, LONGER, relaxation_time
from kinetics.crosscheck.report.field_settings import FieldSettings
from kinetics.crosscheck.report.observables import contact_value, jackknife_error
from kinetics.crosscheck.report.row import TWO_SIDED, Row
from kinetics.crosscheck.verdicts import corrected_sigmas, judge_sigmas

if TYPE_CHECKING:
    from particles import Ensemble

HARD_DISKS = "hard disks, extrapolated"
_DISKS = 10_000  # in the periodic box
_TIMES = 14  # from the start on, at which the share of trapped tracers is given
_SEED = 7000  # added to the seed of these runs
# Of the picture: disks of diameter 1 at this density in a box of this side, in d.
_PICTURE_DENSITY, _PICTURE_SIDE, _PICTURE_SEED = 0.06, 40.0, 5
_PICTURE_TIME, _PICTURE_POINTS = 150.0, 1500


@dataclass(frozen=True)
class DensityCase:
    """Hard disks at several densities, at one restitution; arrays of shape (n_densities,).

    drift : mean velocity of tracers while they move, over that of the dilute equation
    path_alone : the same as it would be if only the mean free path were another
    captures : how often a tracer is trapped on a way of the length l
    times, trapped : of each density, in sqrt(l/g), and the share that is trapped by then
    """

    restitution: float
    densities: Array
    tracers: int
    groups: int
    drift: Measured
    path_alone: Array
    captures: Measured
    times: Array
    trapped: Measured


def density_case(restitution: float, settings: FieldSettings) -> DensityCase:
    """Follow tracers among hard disks at all densities of the settings."""
    from kinetics import solve_field

    state = solve_field(restitution, 2, rtol=1e-6)
    first = FORGOTTEN * relaxation_time(state)
    times = np.geomspace(1.0, LONGER * first, _TIMES)
    times = np.unique([*times, first])
    runs = [_among_disks(restitution, rho, times, settings) for rho in settings.densities]
    measured = [moving_drift(run, first, LONGER * first) for run in runs]
    captured = [captures(run) for run in runs]
    return DensityCase(
        restitution=restitution,
        densities=np.array(settings.densities),
        tracers=runs[0].media * runs[0].tracers,
        groups=runs[0].media,
        drift=_stacked(measured) / state.drift,
        path_alone=np.array([contact_value(rho) ** -0.5 for rho in settings.densities]),
        captures=_stacked(captured),
        times=times,
        trapped=Measured(
            np.array([run.trapped_fraction.value for run in runs]),
            np.array([run.trapped_fraction.error for run in runs]),
        ),
    )


def _stacked(measured: list[Measured]) -> Measured:
    return Measured(np.array([m.value for m in measured]), np.array([m.error for m in measured]))


def _among_disks(
    restitution: float, density: float, times: Array, settings: FieldSettings
) -> "Ensemble":
    """Times in sqrt(l/g). From a Gaussian start: from rest all of one configuration fall alike."""
    from particles import HardDisks, simulate

    path = 0.5 / density
    seed = settings.seed + _SEED + round(1e5 * density) + round(1e6 * restitution)
    return simulate(
        HardDisks(density, count=_DISKS), restitution, "gaussian", times * path,
        media=settings.configurations, tracers=settings.tracers, seed=seed,
        workers=settings.workers, field=1.0 / path, observables=("positions",),
    )  # fmt: skip


def moving_drift(run: "Ensemble", first: float, last: float) -> Measured:
    """How far tracers fall between two times, over how long they move between them, shape ().

    Times in sqrt(l/g), the result in sqrt(g l). What is trapped moves no more, and neither falls.
    """
    path = 0.5 / run.number_density
    at = np.searchsorted(run.times, np.array([first, last]) * path * (1 - 1e-12))
    x = run.positions[at, :, 0].reshape(2, run.media, run.tracers) / path
    ends = np.full((run.media, run.tracers), np.inf)
    where = run.statuses.trap_tracers
    ends[where[:, 0], where[:, 1]] = run.statuses.trap_times / path
    moving = ends > first
    fallen = ((x[1] - x[0]) * moving).sum(axis=1)
    elapsed = (np.clip(ends, first, last) - first).sum(axis=1)
    return _ratio(fallen, elapsed)


def captures(run: "Ensemble") -> Measured:
    """Trapped tracers over the way of all tracers in units of l, shape ()."""
    counts = np.bincount(run.statuses.trap_tracers[:, 0], minlength=run.media).astype(float)
    ways = run.arrays["path_sums"][:, 0] * 2.0 * run.number_density
    return _ratio(counts, ways)


def _ratio(above: Array, below: Array) -> Measured:
    """Sum over sum, of numbers of each configuration, and its standard error."""
    replicates = (above.sum() - above) / (below.sum() - below)
    return Measured(np.asarray(above.sum() / below.sum()), jackknife_error(replicates))


def extrapolated(case: DensityCase) -> Measured:
    """The drift over that of the equation as the density goes to 0, shape ().

    A fit of 1, n ln n and n, n = rho d^2, the orders in which a gas of fixed disks begins to differ
    from its dilute limit.
    """
    n = case.densities
    basis = np.stack([np.ones(n.size), n * np.log(n), n], axis=1) / case.drift.error[:, None]
    inverse = np.linalg.inv(basis.T @ basis)
    found = inverse @ basis.T @ (case.drift.value / case.drift.error)
    return Measured(np.asarray(found[0]), np.asarray(np.sqrt(inverse[0, 0])))


def density_row(case: DensityCase) -> Row:
    """Hard disks at vanishing density against the solver."""
    limit = extrapolated(case)
    value, error = float(limit.value), float(limit.error)
    sigmas = (value - 1.0) / error
    corrected = corrected_sigmas(sigmas, case.groups, 1)
    return Row(
        "drift_among_disks", case.restitution, "statistical", HARD_DISKS, SOLVER,
        value, 1.0, value - 1.0, error=error, sigmas=sigmas, corrected_sigmas=corrected,
        groups=case.groups, verdict=judge_sigmas(corrected),
        within=abs(value - 1.0) + TWO_SIDED * error,
    )  # fmt: skip


@dataclass(frozen=True)
class Trajectories:
    """Disks, and tracers that fall among them; lengths in d.

    disks : their centres, (n, 2), the first coordinate along the field
    paths : of each tracer, (n_times, n_tracers, 2)
    trapped : whether it is at rest in the end, (n_tracers,)
    """

    restitution: float
    number_density: float
    disks: Array
    paths: Array
    trapped: Mask


def trajectories(restitution: float) -> Trajectories:
    """Some tracers that start at one place with different velocities across the field."""
    from particles import Positions, simulate

    side, path = _PICTURE_SIDE, 0.5 / _PICTURE_DENSITY
    start = np.array([2.0, side / 2])
    disks = _placed(start)
    across = np.linspace(-1.0, 1.0, 6)
    velocities = np.stack([np.zeros(across.size), across], axis=1)
    run = simulate(
        Positions(disks, side, start=(float(start[0]), float(start[1]))), restitution,
        velocities, np.linspace(0.0, _PICTURE_TIME, _PICTURE_POINTS),
        media=1, tracers=across.size, field=1.0 / path, workers=1, observables=("positions",),
    )  # fmt: skip
    trapped = np.isin(np.arange(across.size), run.statuses.trap_tracers[:, 1])
    return Trajectories(restitution, _PICTURE_DENSITY, disks, run.positions + start, trapped)


def _placed(start: Array) -> Array:
    """Disks that do not overlap, in a periodic box, none over the start; shape (n, 2)."""
    rng, side = np.random.default_rng(_PICTURE_SEED), _PICTURE_SIDE
    found = np.empty((0, 2))
    while len(found) < _PICTURE_DENSITY * side**2:
        place = rng.uniform(0.0, side, 2)
        apart = np.abs(np.vstack([found, start]) - place)
        if np.hypot(*np.minimum(apart, side - apart).T).min() > 1.0:
            found = np.vstack([found, place])
    return found
