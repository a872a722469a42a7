"""One configuration of scatterers and the tracers in it: the unit of work of an ensemble.

What a configuration leaves is a dictionary of arrays, by the names that they have in a file
(`particles.files`); `Totals` joins those of a run.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import reduce
from math import ceil, inf, log2, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from particles import outputs
from particles.impact import Law, compiled
from particles.media import BoltzmannGrad, Medium, Positions, dilute_mean_path
from particles.values import Value, short

if TYPE_CHECKING:
    from particles.cells import Cells

# Bins per octave of a histogram: each bin is 2**(1/16) - 1 = 4.4 % wide.
PER_OCTAVE = 16
# Tracers per kernel call: so the memory that a call needs does not grow with the number of tracers.
BLOCK = 4096
# A flight of so many mean free paths counts as endless; in a random medium the chance of one is
# about exp(-1e6).
ESCAPE_PATHS = 1e6
# Step of the noise, in the least of (l^2/D)^(1/3) and 1/gamma. Errors go with its square: measured
# at larger steps, .15 of that for <v^2>, .23 for <v^4>, .07 for <r^2>.
STEP = 0.02

Arrays = Mapping[str, np.ndarray]


@dataclass(frozen=True, eq=False)
class Plan(Value):
    """What is to be run, the arguments of `simulate` checked, in U and the user's unit of length.

    velocities (media or none, tracers, dimension), or None to draw them. rest: all tracers begin at
    rest. part: None for all configurations.
    """

    medium: Medium
    restitution: float | Law
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
    mass_ratio: float = inf
    bath_speed: float = 0.0
    heating: float = 0.0
    drag: float = 0.0
    capture_speed: float = 0.0
    part: tuple[int, int] | None = None

    @property
    def configurations(self) -> range:
        """The numbers of the configurations that are run: of the whole run, or of its part."""
        k, n = self.part or (1, 1)
        return range(self.media * (k - 1) // n, self.media * k // n)

    @property
    def stirred(self) -> bool:
        """Whether there is noise or drag: a path is then not made of flights."""
        return max(self.heating, self.drag) > 0.0

    @property
    def varies(self) -> bool:
        """Whether what a collision does depends on the impact speed."""
        return isinstance(self.restitution, Law) or self.capture_speed > 0.0

    @property
    def driven(self) -> bool:
        """Whether tracers are followed by `kernel.driven`."""
        return self.bath_speed > 0.0 or self.stirred or (self.field != 0.0 and self.varies)

    @property
    def law(self) -> tuple[float, float]:
        """By what a collision multiplies the components of the tracer's velocity, (e, et).

        Along the normal the impulse turns the velocity relative to the scatterer round, times the
        restitution; of the change M/(m + M) is the tracer's, so e may be negative: the tracer then
        follows the scatterer. Where it varies, e of slow impacts.
        """
        return float(self.table()[1][0]), self.tangential_restitution

    def table(self) -> tuple[int, np.ndarray]:
        """Return e over the impact speed as `impact.compiled`, with the share of the tracer."""
        lowest, e = compiled(self.restitution)
        if self.mass_ratio < inf:
            e = (1.0 + e) * (self.mass_ratio / (1.0 + self.mass_ratio)) - 1.0
        return lowest, e

    def told(self) -> dict[str, Any]:
        """Return the arguments of `simulate` that are of interest, without arrays."""
        names = ["medium", "restitution", "tangential_restitution", "field", "media", "tracers"]
        names += ["max_collisions", "seed", *(("mass_ratio",) if self.mass_ratio < inf else ())]
        names += [name for name in (*outputs.DRIVES, "part") if getattr(self, name)]
        return {name: getattr(self, name) for name in names}

    def unlike(self, other: "Plan") -> str:
        """Say in what another plan is another run's; empty if it is not."""
        for f in fields(self):
            ours, theirs = getattr(self, f.name), getattr(other, f.name)
            if not np.array_equal(ours, theirs):
                return f"another run, with {f.name} = {short(theirs)}, not {short(ours)}"
        return ""

    def scales(self) -> np.ndarray:
        """Return the powers of 2 that velocities are multiplied by in sums, (n_times,).

        The product v t stays near the mean free path at all times, while v^4 alone would underflow.
        In a field, or driven, a tracer does not slow down for ever, so there they are 1.
        """
        times = self.times / self.medium.diameter
        if self.field or self.driven:
            return np.ones(times.size)
        return np.asarray(2.0 ** np.round(np.log2(np.maximum(times, 1.0))))

    def grids(self) -> np.ndarray:
        """Return log2 of the first edge, bins per octave and bins of each histogram, (5, 3).

        Speeds from 2**-20 of 1 / (last time) to 4 times what start, field, bath and noise can give;
        distances and paths from 2**-12 d up to what the fastest can fly; flight times from those of
        the shortest path up to the last time.
        """
        fastest = 4.0
        if self.velocities is not None:
            fastest = float(speeds(self.velocities).max())
        last = float(self.times[-1]) if self.times.size else 1.0
        if self.field:
            fastest += min(abs(self.field) * last, 2.0**40)
        if self.bath_speed:  # elastic tracers gain speed for ever, fixed a share at each collision
            w, path = self.bath_speed, dilute_mean_path(self.medium) * self.medium.diameter
            fastest += min(20.0 * w * (1.0 + w * last / path), 2.0**40)
        fastest += min(10.0 * sqrt(self.heating * last), 2.0**40)
        top = ceil(log2(fastest)) + 2
        bottom = -ceil(log2(max(last, 1.0))) - 20
        far = min(max(ceil(log2(fastest) + log2(max(last, 1.0))) + 2, 4), 40)
        unit = max(last / self.medium.diameter, 1.0)
        latest = min(ceil(log2(unit)), 60) if self.times.size else 60
        rows = ((bottom, top), (bottom, top), (-12, far), (-12, 40), (-12 - top, latest))
        return np.array([(low, PER_OCTAVE, (high - low) * PER_OCTAVE) for low, high in rows], float)


def speeds(velocities: np.ndarray) -> np.ndarray:
    """Return the sizes of velocities (..., dimension), without overflow on the way."""
    return reduce(np.hypot, np.moveaxis(velocities, -1, 0))


def layout(plan: Plan, media: int, n: int) -> dict[str, tuple[tuple[int, ...], Any]]:
    """Return (shape, what it holds at first) of each array that so many configurations leave.

    n: tracers for whose raw data there is room. Of `histograms/<name>/sums` only the counts are
    there yet, (n_times, bins + 2).
    """
    n_times, d = plan.times.size, plan.medium.dimension
    flat = isinstance(plan.medium, BoltzmannGrad) and not plan.capture_speed
    arrays: dict[str, tuple[tuple[int, ...], Any]] = {
        "moments": ((media, n_times, outputs.MOMENTS), 0.0),
        "path_sums": ((media, outputs.TOTALS), 0.0),
        "statuses": ((outputs.STATUSES,), 0),
        "traps": ((n, 1 + outputs.TRAPS[2 if flat else d]), np.nan),
        "raw/positions": ((n_times, n, d), np.nan),
        "raw/velocities": ((n_times, n, d), np.nan),
        "raw/finals": ((n, outputs.FINALS[d]), np.nan),
    }
    arrays = {k: v for k, v in arrays.items() if k[:4] != "raw/" or k[4:] in plan.observables}
    if plan.field:
        arrays["field_sums"] = (media, n_times, outputs.FIELD_SUMS[d]), 0.0
    if plan.depth is not None:
        arrays["raw/passages"] = (n,), np.inf
    for name, bins in zip(outputs.HISTOGRAMS, plan.grids()[:, 2], strict=True):
        if name in plan.observables:
            rows = 1 if name in outputs.OF_FLIGHTS else n_times
            arrays[f"histograms/{name}/sums"] = (rows, int(bins) + 2), 0
    return arrays


def nothing(plan: Plan, media: int = 0, n: int = 0) -> dict[str, np.ndarray]:
    """Return the arrays of `layout` of configurations in which nothing has happened."""
    return {name: np.full(*shape) for name, shape in layout(plan, media, n).items()}


class Totals:
    """What configurations 0, 1, ... have left, joined; arrays: of the first `done`, to go on from.

    A signal may interrupt `add` anywhere: `_state` alone says what has been added.
    """

    def __init__(self, plan: Plan, arrays: Arrays | None = None, done: int = 0) -> None:
        self.plan = plan
        first = dict(arrays or _with_squares(nothing(plan)))
        sums = {k: first.pop(k) for k in list(first) if k == "statuses" or k[:4] == "hist"}
        self._state = sums, done, 1
        self._pieces = {name: [array] for name, array in first.items()}

    @property
    def configurations(self) -> int:
        """How many have been added."""
        return self._state[1]

    def add(self, arrays: Arrays, count: int = 1) -> None:
        """Add what the next configuration has left, or the next `count`."""
        sums, done, n = self._state
        for name, pieces in self._pieces.items():
            pieces.append(arrays[name])
        sums = {name: array + arrays[name] for name, array in sums.items()}
        self._state = sums, done + count, n + 1

    def arrays(self) -> dict[str, np.ndarray]:
        """Return everything added so far, by its name in a file."""
        sums, _, n = self._state
        return {name: _join(name, pieces[:n]) for name, pieces in self._pieces.items()} | sums


def _join(name: str, pieces: list[np.ndarray]) -> np.ndarray:
    """Join arrays of configurations, or of tracers of one."""
    return np.concatenate(pieces, axis=1 if name in ("raw/positions", "raw/velocities") else 0)


def run_configuration(plan: Plan, configuration: int) -> Arrays:
    """Place the scatterers of one configuration and follow its tracers."""
    from particles.placement import build

    cells = build(plan.medium, np.uint64(plan.seed), configuration)
    return follow_tracers(plan, configuration, cells)


def follow_tracers(plan: Plan, configuration: int, cells: "Cells | None") -> Arrays:
    """Follow the tracers of one configuration among its scatterers."""
    sums = nothing(plan, 1)
    blocks = [
        _follow_block(plan, configuration, cells, first, sums)
        for first in range(0, plan.tracers, BLOCK)
    ]
    kept = {name: _join(name, [block[name] for block in blocks]) for name in blocks[0]}
    return _with_squares(sums) | kept


def _with_squares(arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Add to the counts c of each histogram, of the sum m at one time, c^2, c m, and m and m^2."""
    for name, c in list(arrays.items()):
        if name.startswith("histograms/"):
            m = c.sum(axis=1)
            arrays[name] = np.stack((c, c * c, c * m[:, None]))
            arrays[name.replace("/sums", "/samples")] = np.stack((m, m * m))
    return arrays


def _follow_block(
    plan: Plan, configuration: int, cells: "Cells | None", first: int, sums: Arrays
) -> Arrays:
    """Follow at most BLOCK tracers from number `first` on, adding to the sums; return the rest."""
    from particles.events import Varying
    from particles.kernel import (
        among_disks,
        among_scatterers,
        cell_walk,
        driven,
        falling,
        random_flights,
        random_parabolas,
        records,
        tracer,
    )

    medium, n = plan.medium, min(BLOCK, plan.tracers - first)
    unit, mean_path = medium.diameter, dilute_mean_path(medium)
    given = np.empty((0, medium.dimension))
    if plan.velocities is not None:
        every = plan.velocities.ndim == 2
        given = (plan.velocities if every else plan.velocities[configuration])[first:][:n]
    if plan.rest:
        given = np.zeros((n, medium.dimension))
    given = given.view()
    given.flags.writeable = False  # as those of a plan are: for numba that is another type
    start = tracer.Batch(
        first, n, medium.dimension, given, plan.monoenergetic, np.uint64(plan.seed), configuration,
        plan.law, plan.max_collisions or 0,
        start_places(plan, configuration, cells, first, n),
    )  # fmt: skip
    kept = nothing(plan, 0, n)
    counts = [sums.get(f"histograms/{name}/sums") for name in outputs.HISTOGRAMS]
    record = records.Records(
        times=plan.times / unit,
        scales=plan.scales(),
        moments=sums["moments"][0],
        totals=sums["path_sums"][0],
        statuses=sums["statuses"],
        field_sums=sums["field_sums"][0] if plan.field else np.empty((0, 0)),
        grids=np.ascontiguousarray(plan.grids()[:, :2]),
        counts=tuple(np.zeros((0, 0), np.int64) if one is None else one for one in counts),
        positions=kept.get("raw/positions", np.empty((0, 0, 0))),
        velocities=kept.get("raw/velocities", np.empty((0, 0, 0))),
        finals=kept.get("raw/finals", np.empty((0, 0))),
        passages=kept.get("raw/passages", np.empty(0)),
        depth=(plan.depth or 0.0) / unit,
        traps=kept["traps"][:, 1:].copy(),
        queue=np.empty(records.QUEUE, records.OUTPUT),
        filled=np.zeros(2, np.int64),
    )
    field, varying = plan.field * unit, None
    if plan.driven or plan.varies:
        lowest, values = plan.table()
        endless = 1.0 if plan.capture_speed else float(values[0])
        varying = Varying(lowest, values.copy(), plan.capture_speed, endless)
    limit = ESCAPE_PATHS * mean_path
    if plan.driven:
        heating, drag = plan.heating * unit, plan.drag * unit
        scale = (mean_path * mean_path / heating) ** (1.0 / 3.0) if heating else inf
        step = STEP * min(scale, 1.0 / drag if drag else inf)
        drive = driven.Driving(mean_path, field, plan.bath_speed, heating, drag, step)
        driven.follow_driven(start, drive, varying, np.empty(16, driven.LANE), record)
    elif cells is None and not field:
        random_flights.follow_random_flights(
            start, varying, mean_path, np.empty(16, random_flights.LANE), record
        )
    elif cells is None:
        random_parabolas.follow_random_parabolas(
            start, field, mean_path, np.empty(16, random_parabolas.LANE), record
        )
    elif not field:
        among_scatterers.follow_among_scatterers(
            start, cells, varying, limit, np.empty(16, cell_walk.LANE), record
        )
    else:
        among_disks.follow_among_disks(
            start, cells, field, limit, np.empty(16, falling.LANE), record
        )
    traps = record.traps[: record.filled[records.CAUGHT]]
    kept["traps"] = np.insert(traps, 0, configuration, axis=1)
    return {name: kept[name] for name in kept if name == "traps" or name.startswith("raw/")}


def start_places(
    plan: Plan, configuration: int, cells: "Cells | None", first: int, n: int
) -> np.ndarray:
    """Return where n tracers from number `first` on start, (n, 4), as `placement.free_places`.

    (0, 4) where all start at the centre: those that move, those without scatterers, and those among
    `Positions` for which the user gave another start.
    """
    from particles.kernel.tracer import AT_THE_CENTRE
    from particles.placement import free_places

    medium = plan.medium
    given = isinstance(medium, Positions) and medium.start != (medium.box_side / 2,) * 2
    if cells is None or given or not plan.rest:
        return AT_THE_CENTRE
    return np.asarray(free_places(cells, np.uint64(plan.seed), configuration, first, n))
