"""Tracers that fall among hard disks at a finite density: how fast, and how soon they are trapped.

The equation is that of the limit of low density. Disks that stand close are met sooner, and are
met again; and a tracer may come to rest in a corner of two disks, from which the field does not let
it go. Lengths in d, and the field is such that g l = U^2, with l = 1/(2 d rho) of the dilute limit.
"""

from dataclasses import dataclass

import numpy as np

from kinetics import solve_field
from kinetics.crosscheck.report.case import Array, Measured
from kinetics.crosscheck.report.field_runs import FORGOTTEN, LONGER, relaxation_time
from kinetics.crosscheck.report.field_settings import FieldSettings
from kinetics.crosscheck.report.observables import contact_value, jackknife_error, weighted_fit
from kinetics.crosscheck.report.row import SOLVER, Row, estimated
from particles import Ensemble, HardDisks, simulate

HARD_DISKS = "hard disks, extrapolated"
_DISKS = 10_000  # in the periodic box
_TIMES = 14  # from the start on, at which the share of trapped tracers is given
_SEED = 7000  # added to the seed of these runs


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
    state = solve_field(restitution, 2, rtol=1e-6)
    first = FORGOTTEN * relaxation_time(state)
    times = np.geomspace(1.0, LONGER * first, _TIMES)
    times = np.unique([*times, first])
    runs = [_among_disks(restitution, rho, times, settings) for rho in settings.densities]
    measured = [moving_drift(run, first, LONGER * first) for run in runs]
    return DensityCase(
        restitution=restitution,
        densities=np.array(settings.densities),
        tracers=runs[0].media * runs[0].tracers,
        groups=runs[0].media,
        drift=Measured.joined(measured) / state.drift,
        path_alone=np.array([contact_value(rho) ** -0.5 for rho in settings.densities]),
        captures=Measured.joined(map(captures, runs)),
        times=times,
        trapped=Measured.joined(run.trapped_fraction for run in runs),
    )


def _among_disks(
    restitution: float, density: float, times: Array, settings: FieldSettings
) -> Ensemble:
    """Times in sqrt(l/g). From a Gaussian start: from rest all of one configuration fall alike."""
    path = 0.5 / density
    seed = settings.seed + _SEED + round(1e5 * density) + round(1e6 * restitution)
    return simulate(
        HardDisks(density, count=_DISKS), restitution, "gaussian", times * path,
        media=settings.configurations, tracers=settings.tracers, seed=seed,
        workers=settings.workers, field=1.0 / path, observables=("positions",),
    )  # fmt: skip


def moving_drift(run: Ensemble, first: float, last: float) -> Measured:
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


def captures(run: Ensemble) -> Measured:
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
    return weighted_fit(np.stack([np.ones(n.size), n * np.log(n), n], axis=1), case.drift)[1]


def density_row(case: DensityCase) -> Row:
    """Hard disks at vanishing density against the solver."""
    limit = extrapolated(case)
    who = (HARD_DISKS, SOLVER)
    (row,) = estimated(case.restitution, "drift_among_disks", who, limit, 1.0, case.groups)
    return row
