"""One configuration of scatterers and the tracers in it: the unit of work of an ensemble.

What a configuration leaves is a dictionary of arrays, by the names that they have in a file
(`particles.files`). Begin reading with `run_configuration`.

d is the diameter of a scatterer and of the tracer, U the standard deviation of one component of the
initial velocity.
"""

from collections.abc import Mapping
from math import inf
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from particles import outputs
from particles.media import BoltzmannGrad, Positions, dilute_mean_path
from particles.plan import Plan

if TYPE_CHECKING:
    from particles.cells import Cells
    from particles.events import Varying
    from particles.kernel.driven import Driving
    from particles.kernel.records import Records
    from particles.kernel.tracer import Batch

#: Tracers at most that a kernel is called with: the memory of a call does not grow with their
#: number. Chosen: per tracer, random flights take a third longer in batches of 256, and the same
#: within 5 % in batches of 2048 and 8192.
BATCH_SIZE = 4096
#: Mean free paths after which a flight counts as endless. Chosen: in a random medium the chance of
#: one is about exp(-1e6).
ESCAPE_PATHS = 1e6
#: Time step of the noise, over the least of (l^2/D)^(1/3) and 1/gamma. Relative errors go with its
#: square: they were 0.15, 0.23 and 0.07 times that for <v^2>, <v^4>, <r^2>, measured at larger
#: steps. Chosen: they are 6e-5, 9e-5 and 3e-5, and <v^2> of fewer than 1e8 tracers is less certain;
#: at half of it steps are twice as many, at twice of it the errors four times as large.
NOISE_STEP = 0.02

#: Arrays of a configuration, by the names that they have in a file.
Arrays = Mapping[str, np.ndarray]
#: Shape of an array, and what it holds at first.
ArrayLayout = tuple[tuple[int, ...], float | int]


def layout(plan: Plan, media: int, n: int) -> dict[str, ArrayLayout]:
    """Return (shape, what it holds at first) of each array that so many configurations leave.

    n: tracers for whose raw data there is room. Of `histograms/<name>/sums` only the counts are
    included, shape (n_times, bins + 2).
    """
    n_times = plan.times.size
    dimension = plan.medium.dimension
    # Without scatterers and sticking nothing is caught: the table has no rows, and in files it has
    # the columns of the plane.
    has_plane_traps = isinstance(plan.medium, BoltzmannGrad) and not plan.capture_speed
    trap_columns = 1 + outputs.TRAPS[2 if has_plane_traps else dimension]
    arrays: dict[str, ArrayLayout] = {
        "moments": ((media, n_times, outputs.MOMENTS), 0.0),
        "path_sums": ((media, outputs.TOTALS), 0.0),
        "statuses": ((outputs.STATUSES,), 0),
        "traps": ((n, trap_columns), np.nan),
    }
    raw: dict[str, ArrayLayout] = {
        "positions": ((n_times, n, dimension), np.nan),
        "velocities": ((n_times, n, dimension), np.nan),
        "finals": ((n, outputs.FINALS[dimension]), np.nan),
    }
    for name, shape in raw.items():
        if name in plan.observables:
            arrays[f"raw/{name}"] = shape
    if plan.drive.field:
        arrays["field_sums"] = (media, n_times, outputs.FIELD_SUMS[dimension]), 0.0
    if plan.depth is not None:
        arrays["raw/passages"] = (n,), np.inf
    for name, bins in zip(outputs.HISTOGRAMS, plan.grids()[:, 2], strict=True):
        if name in plan.observables:
            rows = 1 if name in outputs.OF_FLIGHTS else n_times
            arrays[f"histograms/{name}/sums"] = (rows, int(bins) + 2), 0
    return arrays


def empty_arrays(plan: Plan, media: int = 0, n: int = 0) -> dict[str, np.ndarray]:
    """Return the arrays of `layout` of configurations in which nothing has happened."""
    return {name: np.full(*shape) for name, shape in layout(plan, media, n).items()}


class StoredArray(NamedTuple):
    """The shape and the type of an array in a file."""

    shape: tuple[int, ...]
    dtype: np.dtype


def stored_arrays(plan: Plan, media: int, n: int) -> dict[str, StoredArray]:
    """Return what a file has of so many configurations and tracers, by the names of the arrays.

    `traps` has no more rows than there are tracers, and may have fewer.
    """
    stored = {}
    for name, (shape, at_first) in layout(plan, media, n).items():
        dtype = np.dtype(type(at_first))
        if name.startswith("histograms/"):  # with products, as `_with_squares` makes them
            stored[name] = StoredArray((3, *shape), dtype)
            stored[name.replace("/sums", "/samples")] = StoredArray((2, shape[0]), dtype)
        else:
            stored[name] = StoredArray(shape, dtype)
    return stored


class _Sum(NamedTuple):
    """Sums over configurations, how many these are, and in how many pieces other arrays are."""

    arrays: dict[str, np.ndarray]
    configurations: int
    pieces: int


class Totals:
    """What the configurations from the first one on have left, joined.

    A signal may interrupt `add` anywhere: `_sum` alone says what has been added.

    Parameters
    ----------
    plan : of the run
    arrays : of the configurations that have been run, to go on from; None if there are none
    configurations : how many there are
    """

    def __init__(self, plan: Plan, arrays: Arrays | None = None, configurations: int = 0) -> None:
        self.plan = plan
        sums = {}
        self._pieces = {}  # of arrays that have an element for each configuration or tracer
        for name, array in (arrays or _with_squares(empty_arrays(plan))).items():
            if name == "statuses" or name.startswith("histograms/"):
                sums[name] = array
            else:
                self._pieces[name] = [array]
        self._sum = _Sum(sums, configurations, 1)

    @property
    def configurations(self) -> int:
        """How many have been added."""
        return self._sum.configurations

    def add(self, arrays: Arrays, count: int = 1) -> None:
        """Add what the next configuration has left, or the next `count`."""
        previous = self._sum
        for name, pieces in self._pieces.items():
            # A piece that an interrupted call has added is replaced.
            pieces[previous.pieces :] = [arrays[name]]
        sums = {name: array + arrays[name] for name, array in previous.arrays.items()}
        self._sum = _Sum(sums, previous.configurations + count, previous.pieces + 1)

    def arrays(self) -> dict[str, np.ndarray]:
        """Return everything added so far, by its name in a file."""
        n = self._sum.pieces
        joined = {name: _join(name, pieces[:n]) for name, pieces in self._pieces.items()}
        return joined | self._sum.arrays


def _join(name: str, pieces: list[np.ndarray]) -> np.ndarray:
    """Join arrays of configurations, or of tracers of one."""
    axis = 1 if name in ("raw/positions", "raw/velocities") else 0
    return np.concatenate(pieces, axis=axis)


def run_configuration(plan: Plan, configuration: int) -> Arrays:
    """Place the scatterers of one configuration and follow its tracers."""
    from particles.placement import build

    cells = build(plan.medium, np.uint64(plan.seed), configuration)
    return follow_tracers(plan, configuration, cells)


def follow_tracers(plan: Plan, configuration: int, cells: "Cells | None") -> Arrays:
    """Follow the tracers of one configuration among its scatterers."""
    sums = empty_arrays(plan, 1)
    batches = []
    for first_number in range(0, plan.tracers, BATCH_SIZE):
        batches.append(_follow_batch(plan, configuration, cells, first_number, sums))
    raw = {}
    for name in batches[0]:
        raw[name] = _join(name, [batch[name] for batch in batches])
    return _with_squares(sums) | raw


def _with_squares(arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return arrays with products of the counts c of each histogram, and of their sums m at a time.

    `sums` are then of c, of c^2 and of c m, and `samples` of m and of m^2.
    """
    with_products = dict(arrays)
    for name, counts in arrays.items():
        if name.startswith("histograms/"):
            totals = counts.sum(axis=1)
            products = (counts, counts * counts, counts * totals[:, None])
            with_products[name] = np.stack(products)
            with_products[name.replace("/sums", "/samples")] = np.stack((totals, totals * totals))
    return with_products


def _follow_batch(
    plan: Plan, configuration: int, cells: "Cells | None", first_number: int, sums: Arrays
) -> dict[str, np.ndarray]:
    """Follow at most BATCH_SIZE tracers from a number on, adding to the sums; return raw data."""
    from particles.kernel.records import TRAP_ROWS

    n = min(BATCH_SIZE, plan.tracers - first_number)
    raw = empty_arrays(plan, 0, n)
    records = _make_records(plan, sums, raw)
    batch = _make_batch(plan, configuration, cells, first_number, n)
    _call_kernel(plan, cells, batch, records)
    traps = records.traps[: records.filled[TRAP_ROWS]]
    raw["traps"] = np.insert(traps, 0, configuration, axis=1)
    return {name: array for name, array in raw.items() if name == "traps" or name[:4] == "raw/"}


def _make_batch(
    plan: Plan, configuration: int, cells: "Cells | None", first_number: int, n: int
) -> "Batch":
    """Return n tracers from a number on as a kernel takes them."""
    from particles.kernel.tracer import Batch

    velocities = _specified_velocities(plan, configuration, first_number, n).view()
    velocities.flags.writeable = False  # as those of a plan are: for numba that is another type
    return Batch(
        first=first_number,
        size=n,
        dimension=plan.medium.dimension,
        velocities=velocities,
        monoenergetic=plan.monoenergetic,
        seed=np.uint64(plan.seed),
        configuration=configuration,
        law=plan.drive.law,
        max_collisions=plan.max_collisions or 0,
        places=start_places(plan, configuration, cells, first_number, n),
    )


def _specified_velocities(plan: Plan, configuration: int, first_number: int, n: int) -> np.ndarray:
    """Return the initial velocities of n tracers, (n, dimension); none where they are drawn."""
    dimension = plan.medium.dimension
    if plan.rest:
        return np.zeros((n, dimension))
    if plan.velocities is None:
        return np.empty((0, dimension))
    is_shared = plan.velocities.ndim == 2
    velocities = plan.velocities if is_shared else plan.velocities[configuration]
    return velocities[first_number : first_number + n]


def _make_records(plan: Plan, sums: Arrays, raw: Arrays) -> "Records":
    """Return the arrays that a kernel adds to."""
    from particles.kernel.records import OUTPUT, QUEUE, Records

    unit = plan.medium.diameter
    # of each histogram log2 of its lowest edge, and bins per octave
    grids = np.ascontiguousarray(plan.grids()[:, :2])
    no_counts = np.zeros((0, 0), np.int64)
    counts = []
    for name in outputs.HISTOGRAMS:
        counts.append(sums.get(f"histograms/{name}/sums", no_counts))
    return Records(
        times=plan.times / unit,
        scales=plan.scales(),
        moments=sums["moments"][0],
        totals=sums["path_sums"][0],
        statuses=sums["statuses"],
        field_sums=sums["field_sums"][0] if plan.drive.field else np.empty((0, 0)),
        grids=grids,
        counts=tuple(counts),
        positions=raw.get("raw/positions", np.empty((0, 0, 0))),
        velocities=raw.get("raw/velocities", np.empty((0, 0, 0))),
        finals=raw.get("raw/finals", np.empty((0, 0))),
        passages=raw.get("raw/passages", np.empty(0)),
        depth=(plan.depth or 0.0) / unit,
        traps=raw["traps"][:, 1:].copy(),
        queue=np.empty(QUEUE, OUTPUT),
        filled=np.zeros(2, np.int64),  # states that wait in the queue, rows of traps
    )


def _call_kernel(plan: Plan, cells: "Cells | None", batch: "Batch", records: "Records") -> None:
    """Follow a batch of tracers with the kernel for this kind of run."""
    from particles.kernel import (
        among_disks,
        among_scatterers,
        cell_walk,
        driven,
        falling,
        random_flights,
        random_parabolas,
    )
    from particles.kernel.tracer import LANES

    field = plan.drive.field * plan.medium.diameter
    mean_path = dilute_mean_path(plan.medium)
    longest_flight = ESCAPE_PATHS * mean_path
    # In a field with a law that varies the drive needs a clock: kernels of parabolas take none.
    varying = _varying(plan)
    if plan.drive.needs_clock:
        assert varying is not None
        lanes = np.empty(LANES, driven.LANE)
        driven.follow_driven(batch, _driving(plan), varying, lanes, records)
    elif cells is None and not field:
        lanes = np.empty(LANES, random_flights.LANE)
        random_flights.follow_random_flights(batch, varying, mean_path, lanes, records)
    elif cells is None:
        lanes = np.empty(LANES, random_parabolas.LANE)
        random_parabolas.follow_random_parabolas(batch, field, mean_path, lanes, records)
    elif not field:
        lanes = np.empty(LANES, cell_walk.LANE)
        among_scatterers.follow_among_scatterers(
            batch, cells, varying, longest_flight, lanes, records
        )
    else:
        lanes = np.empty(LANES, falling.LANE)
        among_disks.follow_among_disks(batch, cells, field, longest_flight, lanes, records)


def _varying(plan: Plan) -> "Varying | None":
    """Return the restitution over the impact speed, None where the law holds at every speed."""
    from particles.events import Varying

    drive = plan.drive
    if not (drive.needs_clock or drive.depends_on_speed):
        return None
    lowest_octave, values = drive.restitution_table()
    # Of bounces that follow one another without end, ever slower. Where slow tracers stick they are
    # captured before: with 1 the kernel looks for no such bounces.
    slowest = 1.0 if drive.capture_speed else float(values[0])
    return Varying(lowest_octave, values.copy(), drive.capture_speed, slowest)


def _driving(plan: Plan) -> "Driving":
    """Return what drives the tracers, in d and U, and the step of the noise."""
    from particles.kernel.driven import Driving

    unit = plan.medium.diameter
    mean_path = dilute_mean_path(plan.medium)
    heating = plan.drive.heating * unit
    drag = plan.drive.drag * unit
    noise_time = inf
    if heating:
        noise_time = (mean_path * mean_path / heating) ** (1.0 / 3.0)
    drag_time = inf
    if drag:
        drag_time = 1.0 / drag
    return Driving(
        mean_path=mean_path,
        field=plan.drive.field * unit,
        bath_speed=plan.drive.bath_speed,
        heating=heating,
        drag=drag,
        longest_step=NOISE_STEP * min(noise_time, drag_time),
    )


def start_places(
    plan: Plan, configuration: int, cells: "Cells | None", first_number: int, n: int
) -> np.ndarray:
    """Return where n tracers from a number on start, shape (n, 4), as `placement.free_places`.

    The columns are i, j of the cell, from the middle one, and x, y from its centre in d. Shape
    (0, 4) stands for the place where all tracers of a medium start by default, its centre or the
    start of `Positions`: there start those that move, and those of a start that the user specified.
    """
    from particles.kernel.tracer import AT_THE_CENTRE
    from particles.placement import free_places

    medium = plan.medium
    if cells is None or not plan.rest:
        return AT_THE_CENTRE
    if isinstance(medium, Positions):
        centre = (medium.box_side / 2, medium.box_side / 2)
        if medium.start != centre:
            return AT_THE_CENTRE
    return free_places(cells, np.uint64(plan.seed), configuration, first_number, n)
