"""One configuration of scatterers and the tracers in it: the unit of work of an ensemble."""

from dataclasses import dataclass, field, replace
from functools import reduce
from math import ceil, log2
from typing import TYPE_CHECKING

import numpy as np

from particles.kernel.columns import (
    FIELD_SUMS,
    FINALS,
    HISTOGRAMS,
    MOMENTS,
    STATUSES,
    TOTALS,
    TRAPS,
)
from particles.media import BoltzmannGrad, Medium, Positions, dilute_mean_path
from particles.results import Value

if TYPE_CHECKING:
    from particles.cells import Cells
    from particles.kernel.records import Records

SCALARS = (
    "thermal_speed",
    "a2",
    "msd",
    "kurtosis",
    "collisions",
    "velocity_autocorrelation",
    "mean_free_path",
)
RAW = ("positions", "velocities", "finals")
OBSERVABLES = SCALARS + HISTOGRAMS + RAW

# Bins per octave of a histogram: each bin is 2**(1/16) - 1 = 4.4 % wide.
PER_OCTAVE = 16
# Tracers per kernel call: so the memory that a call needs does not grow with the number of tracers.
BLOCK = 4096
# A flight of so many mean free paths counts as endless; in a random medium the chance of one is
# about exp(-1e6).
ESCAPE_PATHS = 1e6


@dataclass(frozen=True, eq=False)
class Plan(Value):
    """What is to be run, checked.

    velocities (media or none, tracers, dimension), or None to draw them. rest: all tracers begin at
    rest. field: acceleration along x in U^2 over the user's unit of length. depth: x in that unit
    whose first passage is recorded.
    """

    medium: Medium
    restitution: float
    tangential_restitution: float
    monoenergetic: bool
    velocities: np.ndarray | None
    times: np.ndarray
    media: int
    tracers: int
    max_collisions: int | None
    seed: int
    observables: frozenset[str]
    field: float = 0.0
    rest: bool = False
    depth: float | None = None

    @property
    def raw(self) -> tuple[str, ...]:
        """Names of what is kept of each tracer."""
        names = tuple(name for name in RAW if name in self.observables)
        return names if self.depth is None else (*names, "passages")

    def scales(self) -> np.ndarray:
        """Return the numbers that velocities are multiplied by in sums, (n_times,).

        In a field a tracer does not slow down for ever, so there they are 1.
        """
        times = self.times / self.medium.diameter
        return np.ones(times.size) if self.field else time_scales(times)

    def grids(self) -> np.ndarray:
        """Return log2 of the first edge, bins per octave and bins of each histogram, (4, 3).

        Speeds from 2**-20 of 1 / (last time) to 2**6 times the fastest start; distances and paths
        from 2**-12 d up to what the fastest start can fly, 2**40 d at most. In a field the speed of
        a free fall is added to that of the start, 2**40 U at most.
        """
        fastest = 4.0
        if self.velocities is not None:
            fastest = float(speeds(self.velocities).max())
        last = float(self.times[-1]) if self.times.size else 1.0
        if self.field:
            fastest += min(abs(self.field) * last, 2.0**40)
        top = ceil(log2(fastest)) + 2
        bottom = -ceil(log2(max(last, 1.0))) - 20
        far = min(max(ceil(log2(fastest) + log2(max(last, 1.0))) + 2, 4), 40)
        rows = ((bottom, top), (bottom, top), (-12, far), (-12, 40))
        return np.array([(low, PER_OCTAVE, (high - low) * PER_OCTAVE) for low, high in rows], float)


@dataclass(frozen=True, eq=False)
class Tally:
    """Sums over the tracers of one configuration (columns: particles.kernel.columns).

    moments (n_times, 8), totals (2,) path in d and collisions, statuses (4,), traps
    (n, trap_columns) tracer, time, place; histograms name -> (n_times, bins + 2); raw name ->
    arrays, time first. field_sums (n_times, FIELD_SUMS[dimension]) in a field, else empty.
    """

    configuration: int
    moments: np.ndarray
    totals: np.ndarray
    statuses: np.ndarray
    traps: np.ndarray
    histograms: dict[str, np.ndarray] = field(default_factory=dict)
    raw: dict[str, np.ndarray] = field(default_factory=dict)
    field_sums: np.ndarray = field(default_factory=lambda: np.empty((0, 0)))


def speeds(velocities: np.ndarray) -> np.ndarray:
    """Return the sizes of velocities (..., dimension), without overflow on the way."""
    return reduce(np.hypot, np.moveaxis(velocities, -1, 0))


def trap_columns(medium: Medium) -> int:
    """Return the number of columns of the trapped tracers (columns: kernel.columns)."""
    return TRAPS[2 if isinstance(medium, BoltzmannGrad) else medium.dimension]


def time_scales(times: np.ndarray) -> np.ndarray:
    """Return the power of 2 by which velocities are multiplied in sums at each time.

    times (n_times,) in d/U. The product v t stays near the mean free path at all times, while v^4
    alone would underflow.
    """
    return 2.0 ** np.round(np.log2(np.maximum(times, 1.0)))


def run_configurations(plan: Plan, start: int, stop: int) -> list[Tally]:
    """Run configurations start to stop - 1, one after another."""
    return [run_configuration(plan, c) for c in range(start, stop)]


def run_configuration(plan: Plan, configuration: int) -> Tally:
    """Place the scatterers of one configuration and follow its tracers."""
    from particles.placement import build

    return follow_tracers(plan, configuration, build(plan.medium, np.uint64(plan.seed), configuration))


def follow_tracers(plan: Plan, configuration: int, cells: "Cells | None") -> Tally:
    """Follow the tracers of one configuration among its scatterers."""
    tally = _empty_tally(plan, configuration)
    traps: list[np.ndarray] = [tally.traps]
    raw: dict[str, list[np.ndarray]] = {name: [] for name in plan.raw}
    for first in range(0, plan.tracers, BLOCK):
        block = _follow_block(plan, tally, cells, first)
        traps.append(block.pop("traps"))
        for name, pieces in raw.items():
            pieces.append(block[name])
    return replace(
        tally,
        traps=np.concatenate(traps),
        raw={
            name: np.concatenate(pieces, axis=0 if name in ("finals", "passages") else 1)
            for name, pieces in raw.items()
        },
    )


def _empty_tally(plan: Plan, configuration: int) -> Tally:
    n_times, bins = plan.times.size, plan.grids()[:, 2].astype(int)
    rows = {name: 1 if name == "free_path_histogram" else n_times for name in HISTOGRAMS}
    return Tally(
        configuration,
        moments=np.zeros((n_times, MOMENTS)),
        totals=np.zeros(TOTALS),
        statuses=np.zeros(STATUSES, np.int64),
        traps=np.empty((0, trap_columns(plan.medium))),
        histograms={
            name: np.zeros((rows[name], bins[k] + 2), np.int64)
            for k, name in enumerate(HISTOGRAMS)
            if name in plan.observables
        },
        field_sums=np.zeros((n_times if plan.field else 0, FIELD_SUMS[plan.medium.dimension])),
    )


def _follow_block(
    plan: Plan, tally: Tally, cells: "Cells | None", first: int
) -> dict[str, np.ndarray]:
    """Follow at most BLOCK tracers from number `first` on, adding to the sums of the tally.

    Return what is kept of each tracer: "traps" and the raw observables; those not asked for are
    empty.
    """
    from particles.kernel import follow, follow_falling, lane

    medium = plan.medium
    mean_path, field, dimension = dilute_mean_path(medium), plan.field * medium.diameter, medium.dimension
    n = min(BLOCK, plan.tracers - first)
    given = np.empty((0, dimension))
    if plan.velocities is not None:
        every = plan.velocities.ndim == 2
        given = (plan.velocities if every else plan.velocities[tally.configuration])[first:][:n]
    if plan.rest:
        given = np.zeros((n, dimension))
    given = given.view()
    given.flags.writeable = False  # as those of a plan are: for numba that is another type
    start = lane.Start(
        first, n, dimension, given, plan.monoenergetic, np.uint64(plan.seed), tally.configuration,
        (plan.restitution, plan.tangential_restitution), plan.max_collisions or 0,
        start_places(plan, tally.configuration, cells, first, n),
    )  # fmt: skip
    record = _make_records(plan, tally, n)
    caught = np.empty((n, trap_columns(medium)))
    n_caught = 0
    lanes = np.empty(lane.LANES, lane.FALLING_LANE if field else lane.LANE)
    limit = ESCAPE_PATHS * mean_path
    if cells is None and field:
        follow_falling.follow_free_falls(start, mean_path, field, lanes, record)
    elif cells is None:
        follow.follow_free_paths(start, mean_path, lanes, record)
    elif field:
        n_caught = follow_falling.follow_falling(
            start, cells, (field, limit), caught, lanes, record
        )
    else:
        n_caught = follow.follow(start, cells, limit, caught, lanes, record)
    return {"traps": caught[:n_caught]} | {name: getattr(record, name) for name in plan.raw}


def start_places(
    plan: Plan, configuration: int, cells: "Cells | None", first: int, n: int
) -> np.ndarray:
    """Return the free places where n tracers from number `first` on start, (n, 4).

    (0, 4) where all tracers start at the centre: those that move, those without scatterers, and
    those among `Positions` for which the user gave another start. Columns: placement.free_places.
    """
    from particles.kernel.lane import AT_THE_CENTRE
    from particles.placement import free_places

    medium = plan.medium
    if isinstance(medium, Positions) and medium.start != (medium.box_side / 2,) * 2:
        return AT_THE_CENTRE
    if cells is None or not plan.rest:
        return AT_THE_CENTRE
    return np.asarray(free_places(cells, np.uint64(plan.seed), configuration, first, n))


def _make_records(plan: Plan, tally: Tally, n: int) -> "Records":
    """Return the arrays of the tally, and new ones for what is kept of each of n tracers."""
    from particles.kernel import records

    dimension, times = plan.medium.dimension, plan.times / plan.medium.diameter
    raw = {
        name: np.full(shape if name in plan.observables else (0,) * len(shape), np.nan)
        for name, shape in {
            "positions": (times.size, n, dimension),
            "velocities": (times.size, n, dimension),
            "finals": (n, FINALS[dimension]),
        }.items()
    }
    nothing = np.zeros((0, 0), np.int64)
    speeds, components, distances, paths = (
        tally.histograms.get(name, nothing) for name in HISTOGRAMS
    )
    return records.Records(
        times=times,
        scales=plan.scales(),
        moments=tally.moments,
        totals=tally.totals,
        statuses=tally.statuses,
        field_sums=tally.field_sums,
        grids=np.ascontiguousarray(plan.grids()[:, :2]),
        speeds=speeds,
        components=components,
        distances=distances,
        paths=paths,
        passages=np.full(0 if plan.depth is None else n, np.inf),
        depth=(plan.depth or 0.0) / plan.medium.diameter,
        queue=np.empty(records.QUEUE, records.OUTPUT),
        queued=np.zeros(1, np.int64),
        **raw,
    )
