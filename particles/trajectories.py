"""The paths of a few tracers of a run, and the scatterers beside them: what a picture shows.

A run keeps sums, not paths. A path is found again by following the same tracers, among the same
scatterers and with the same random numbers, up to 1, 2, 3 ... collisions: each such run ends at the
place of a collision, to the same bits as the run itself. In a field, where paths are curved, the
places at many times are taken instead.
"""

from dataclasses import dataclass, replace

import numpy as np

from particles.checks import check_positive, check_whole, refuse
from particles.configuration import Plan, follow_tracers, start_places
from particles.kernel.columns import (
    COLLISION_CAP,
    FINAL_COLLISIONS,
    FINAL_X,
    FINAL_Y,
    FINAL_Z,
    LN_SPEED,
    LN_TIME,
)
from particles.media import HardDisks, Poisson, Positions
from particles.placement import build
from particles.results import Value

MOST_COLLISIONS = 1000  # of one path; the time that it takes grows as the square of this
CURVE_POINTS = 2001  # of a curved path
MOST_SCATTERERS = 50_000  # in one picture


@dataclass(frozen=True, eq=False)
class Trajectory(Value):
    """The path of one tracer: straight from each place to the next, or nearly so in a field.

    times (n,) in d/U: of the start, of each collision and of the end. places (n, dimension) in d,
    from the start, or, of tracers that begin at rest among disks, from the start of the first one.
    speeds (n - 1,) in U: between two places.
    """

    times: np.ndarray
    places: np.ndarray
    speeds: np.ndarray


def trajectories(
    plan: Plan,
    tracers: int = 8,
    configuration: int = 0,
    until: float | None = None,
    collisions: int = 300,
) -> list[Trajectory]:
    """Return the paths of the first tracers of one configuration of a run.

    tracers: how many. until: the time in d/U at which they end, that of the run's last output if
    None. collisions: where they end at the latest, 1000 at most (not in a field).

    Raises ValueError for a number out of range.
    """
    tracers = check_whole("tracers", tracers, 1, plan.tracers)
    configuration = check_whole("configuration", configuration, 0, plan.media - 1)
    collisions = check_whole("collisions", collisions, 1, MOST_COLLISIONS)
    if until is None:
        until = float(plan.times[-1]) if plan.times.size else np.inf
    else:
        until = check_positive("until", until)
    if until == 0.0:
        refuse("until", until, "the run ends where it starts: give a time above 0")
    if plan.max_collisions is not None:
        collisions = min(collisions, plan.max_collisions)
    plan = replace(plan, tracers=tracers, depth=None, velocities=_given(plan, tracers))
    if plan.field:
        return _curves(plan, configuration, until)
    return _flights(plan, configuration, until, collisions)


def _given(plan: Plan, tracers: int) -> np.ndarray | None:
    return None if plan.velocities is None else plan.velocities[..., :tracers, :]


def _curves(plan: Plan, configuration: int, until: float) -> list[Trajectory]:
    """Places at equal steps of time, and the speeds between them."""
    if not np.isfinite(until):
        refuse("until", None, "in a field it is needed where the run has no output times")
    times = np.linspace(0.0, until, CURVE_POINTS)
    asked = replace(plan, times=times, observables=frozenset({"positions", "velocities"}))
    cells = build(plan.medium, _seed(plan), configuration)
    found = follow_tracers(asked, configuration, cells)
    places = np.moveaxis(found.raw["positions"], 1, 0)
    free = start_places(plan, configuration, cells, 0, plan.tracers)
    if cells is not None and len(free):
        places = places + (free[:, None, :2] * cells.side + free[:, None, 2:])
    places = places * plan.medium.diameter
    speeds = np.linalg.norm(np.moveaxis(found.raw["velocities"], 1, 0), axis=-1)
    made = []
    for where, speed in zip(places, speeds, strict=True):
        n = int(np.isfinite(where[:, 0]).sum())  # NaN after the end of a tracer
        made.append(Trajectory(times[:n], where[:n], 0.5 * (speed[1:n] + speed[: n - 1])))
    return made


def _flights(plan: Plan, configuration: int, until: float, collisions: int) -> list[Trajectory]:
    """The places of the start, of the collisions and of the end, and the speeds between them."""
    d, dimension = plan.medium.diameter, plan.medium.dimension
    cells = build(plan.medium, _seed(plan), configuration)
    place_of = [FINAL_X, FINAL_Y, FINAL_Z][:dimension]
    last = np.array([until]) if np.isfinite(until) else np.empty(0)
    start = replace(plan, times=np.zeros(1), observables=frozenset({"velocities"}))
    first = follow_tracers(start, configuration, cells).raw["velocities"][0]
    times = [[0.0] for _ in first]
    places = [[np.zeros(dimension)] for _ in first]
    speeds = [[float(np.linalg.norm(v))] for v in first]
    ended = np.zeros(len(first), bool)
    asked = replace(plan, times=last, observables=frozenset({"finals"}))
    for n in range(1, collisions + 1):
        tally = follow_tracers(replace(asked, max_collisions=n), configuration, cells)
        for k in np.nonzero(~ended)[0]:
            end = tally.raw["finals"][k]
            times[k].append(float(np.exp(end[LN_TIME])) * d)
            places[k].append(end[place_of] * d)
            speeds[k].append(float(np.exp(end[LN_SPEED])))
            ended[k] = end[FINAL_COLLISIONS] < n
        if not tally.statuses[COLLISION_CAP]:
            break
    return [
        Trajectory(np.array(t), np.array(where), np.array(v[:-1]))
        for t, where, v in zip(times, places, speeds, strict=True)
    ]


def _seed(plan: Plan) -> np.uint64:
    return np.uint64(plan.seed)


def scatterers(
    plan: Plan, configuration: int, low: np.ndarray, high: np.ndarray
) -> np.ndarray | None:
    """Return the disks of one configuration in a rectangle, (n, 2), in d from the start.

    low, high (2,): its corners in d. None where there are none to draw: in the Boltzmann-Grad
    limit, in space, and where the rectangle holds more than a picture can show.
    """
    medium = plan.medium
    d = medium.diameter
    if medium.dimension != 2 or np.prod(high - low) * medium.number_density > MOST_SCATTERERS:
        return None
    cells = build(medium, _seed(plan), configuration)
    if cells is None or not isinstance(medium, HardDisks | Poisson | Positions):
        return None
    if isinstance(medium, Positions) or medium.box:
        found = _of_a_box(cells, medium.count, low / d, high / d)
    else:
        found = _of_the_plane(cells, low / d, high / d)
    inside = np.all((found >= low / d) & (found <= high / d), axis=1)
    return found[inside] * d


def _of_a_box(cells: Cells, count: int, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The disks of a periodic box, with their images as far as a rectangle reaches, in d."""
    own = np.empty((count, 2))
    centres(cells, own)
    box = cells.side * cells.n
    images = [
        np.arange(np.floor(a / box), np.ceil(b / box) + 1) for a, b in zip(low, high, strict=True)
    ]
    shifts = np.stack(np.meshgrid(*images), axis=-1).reshape(-1, 1, 2) * box
    return np.asarray((own + shifts).reshape(-1, 2))


def _of_the_plane(cells: Cells, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The disks of the cells of the unbounded plane that overlap a rectangle, in d."""
    half = 0.5 * cells.side
    first, last = (np.floor(x / cells.side + 0.5).astype(int) for x in (low, high))
    found = [np.empty((0, 2))]
    for i in range(first[0], last[0] + 1):
        for j in range(first[1], last[1] + 1):
            cell = make_cell(cells, i, j)
            own = [p for p in listed(cells, cell) if -half <= min(p) and max(p) < half]
            found.append(np.reshape(own, (-1, 2)) + np.array([i, j]) * cells.side)
    return np.concatenate(found)
