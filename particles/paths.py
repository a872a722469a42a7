"""The paths of a few tracers of a run among the scatterers, and a picture of them.

A run keeps sums, not paths. A path is found again by following the same tracers up to 1, 2, 3 ...
collisions: each such run ends at the place of a collision, to the same bits as the run itself.
Where paths are curved, in a field and with noise and drag, the places at many times are taken
instead; with noise a tracer whose outputs are at other times has another path of the same kind.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from particles import outputs
from particles.configuration import follow_tracers, start_places
from particles.media import BoltzmannGrad
from particles.placement import build, placed
from particles.plan import Plan
from particles.values import Value, check_positive, check_whole, refuse

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_COLLISIONS = 1000  # of one path; the time that it takes grows as the square of this
CURVE_POINTS = 2001  # of a curved path
MOST_SCATTERERS = 50_000  # in one picture
_DISK, _MARK = "#8d98a5", "#16191d"


@dataclass(frozen=True, eq=False)
class Trajectory(Value):
    """The path of one tracer: straight from each place to the next, or nearly so in a field.

    times (n,) in d/U: of the start, of each collision and of the end. places (n, dimension) in d,
    from the start of the first tracer. speeds (n - 1,) in U: between two places.
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
    """Return the paths of the first so many tracers of one configuration of a run.

    until: the time in d/U at which they end, that of the run's last output if None. collisions:
    where they end at the latest, 1000 at most (not in a field).
    """
    tracers = check_whole("tracers", tracers, 1, plan.tracers)
    configuration = check_whole("configuration", configuration, 0, plan.media - 1)
    collisions = check_whole("collisions", collisions, 1, MOST_COLLISIONS)
    if until is not None:
        until = check_positive("until", until)
    elif plan.times.size:
        until = float(plan.times[-1])
    if until == 0.0 or (until is None and (plan.drive.field or plan.drive.is_noisy)):
        refuse("until", until, "it must be a time above 0, given where the run has no output times")
    velocities = None if plan.velocities is None else plan.velocities[..., :tracers, :]
    plan = plan.replaced(tracers=tracers, depth=None, velocities=velocities)
    if plan.drive.field or plan.drive.is_noisy:
        return _curves(plan, configuration, until or 0.0)
    return _flights(plan, configuration, until, min(collisions, plan.max_collisions or collisions))


def _curves(plan: Plan, configuration: int, until: float) -> list[Trajectory]:
    """Places at equal steps of time, and the speeds between them."""
    times = np.linspace(0.0, until, CURVE_POINTS)
    asked = plan.replaced(times=times, observables=frozenset({"positions", "velocities"}))
    cells = build(plan.medium, np.uint64(plan.seed), configuration)
    found = follow_tracers(asked, configuration, cells)
    places = np.moveaxis(found["raw/positions"], 1, 0)
    free = start_places(plan, configuration, cells, 0, plan.tracers)
    if cells is not None and len(free):
        places = places + (free[:, None, :2] * cells.side + free[:, None, 2:])
    places = places * plan.medium.diameter
    speeds = np.linalg.norm(np.moveaxis(found["raw/velocities"], 1, 0), axis=-1)
    made = []
    for where, speed in zip(places, speeds, strict=True):
        n = int(np.isfinite(where[:, 0]).sum())  # NaN after the end of a tracer
        made.append(Trajectory(times[:n], where[:n], 0.5 * (speed[1:n] + speed[: n - 1])))
    return made


def _flights(
    plan: Plan, configuration: int, until: float | None, collisions: int
) -> list[Trajectory]:
    """The places of the start, of the collisions and of the end, and the speeds between them."""
    d, dimension = plan.medium.diameter, plan.medium.dimension
    cells = build(plan.medium, np.uint64(plan.seed), configuration)
    place_of = [outputs.FINAL_X, outputs.FINAL_Y, outputs.FINAL_Z][:dimension]
    start = plan.replaced(times=np.zeros(1), observables=frozenset({"velocities"}))
    first = follow_tracers(start, configuration, cells)["raw/velocities"][0]
    times, places = [[0.0] for _ in first], [[np.zeros(dimension)] for _ in first]
    speeds, ended = [[float(np.linalg.norm(v))] for v in first], np.zeros(len(first), bool)
    last = np.empty(0) if until is None else np.array([until])
    asked = plan.replaced(times=last, observables=frozenset({"finals"}))
    for n in range(1, collisions + 1):
        found = follow_tracers(asked.replaced(max_collisions=n), configuration, cells)
        for k in np.nonzero(~ended)[0]:
            end = found["raw/finals"][k]
            times[k].append(float(np.exp(end[outputs.LN_TIME])) * d)
            places[k].append(end[place_of] * d)
            speeds[k].append(float(np.exp(end[outputs.LN_SPEED])))
            ended[k] = end[outputs.FINAL_COLLISIONS] < n
        if not found["statuses"][outputs.COLLISION_CAP]:
            break
    return [
        Trajectory(np.array(t), np.array(where), np.array(v[:-1]))
        for t, where, v in zip(times, places, speeds, strict=True)
    ]


def disks_within(
    plan: Plan, configuration: int, low: np.ndarray, high: np.ndarray
) -> np.ndarray | None:
    """Return the disks between two corners, (n, 2), in d from the start; None if there are many."""
    medium = plan.medium
    if medium.dimension != 2 or np.prod(high - low) * medium.number_density > MOST_SCATTERERS:
        return None
    if isinstance(medium, BoltzmannGrad):
        return None
    own = placed(medium, np.uint64(plan.seed), configuration)[1]
    d, box = medium.diameter, medium.box_side
    images = [np.arange(np.floor(a / box), np.ceil(b / box) + 1) for a, b in zip(low, high)]  # noqa: B905
    shifts = np.stack(np.meshgrid(*images), axis=-1).reshape(-1, 1, 2) * box
    found = (own[:, :2] * d + shifts).reshape(-1, 2)
    return np.asarray(found[np.all((found >= low) & (found <= high), axis=1)])


def plot_trajectories(
    plan: Plan, tracers: int = 8, ax: "Axes | None" = None, colour_bar: bool = True, **which: Any
) -> "Axes":
    """Draw `trajectories`, in space projected on x and y, and the disks beside them."""
    from matplotlib import colormaps
    from matplotlib.collections import EllipseCollection, LineCollection
    from matplotlib.colors import ListedColormap, LogNorm

    found, d = trajectories(plan, tracers, **which), plan.medium.diameter
    every = np.concatenate([path.places[:, :2] for path in found])
    middle, sides = (every.min(axis=0) + every.max(axis=0)) / 2, np.ptp(every, axis=0)
    largest = max(float(sides.max()), 8.0 * d)
    half = np.maximum(sides, 0.6 * largest) / 2 + 0.06 * largest
    low, high = middle - half, middle + half
    if ax is None:
        from matplotlib import pyplot

        _, ax = pyplot.subplots(layout="constrained")
    disks = disks_within(plan, which.get("configuration", 0), low - d, high + d)
    # of not too many disks the area is shaded that the tracer's centre cannot enter
    for size, alpha in ((2.0, 0.2), (1.0, 1.0)):
        if disks is not None and (size == 1.0 or len(disks) <= 1500):
            width = [size * d]  # one for all: an SVG then holds the circle once
            ax.add_collection(
                EllipseCollection(
                    width, width, [0.0], units="xy", offsets=disks, offset_transform=ax.transData,
                    facecolor=_DISK, alpha=alpha, edgecolor="none", zorder=0.5 + 0.1 * alpha,
                )
            )  # fmt: skip
    speeds = np.concatenate([path.speeds for path in found])
    moving = speeds[speeds > 0.0]
    # a tracer that starts at rest is slower than all others for a moment only
    least, most = np.quantile(moving, [0.01, 1.0]) if moving.size else (1.0, 1.0)
    norm = LogNorm(least, most) if most > 1.001 * least else LogNorm(0.9 * least, 1.1 * most)
    # nearly white could not be seen on paper
    colours = ListedColormap(colormaps["plasma"](np.linspace(0.0, 0.88, 256)))
    for path in found:
        at = path.places[:, :2]
        lines = LineCollection(
            list(np.stack([at[:-1], at[1:]], axis=1)), cmap=colours, norm=norm, linewidths=1.4,
            capstyle="round", zorder=2,
        )  # fmt: skip
        lines.set_array(np.maximum(path.speeds, least))
        ax.add_collection(lines)
        ax.plot(*at[-1], "o", color=_MARK, markersize=3.2, zorder=3)
        ax.plot(*at[0], "o", markerfacecolor="white", markeredgecolor=_MARK, markersize=6, zorder=4)
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel="x [d]", ylabel="y [d]")
    ax.set_aspect("equal")
    ax.grid(False)
    if colour_bar:
        ax.figure.colorbar(lines, ax=ax, label="speed v [U]", shrink=0.8)
    return ax
