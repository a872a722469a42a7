"""The paths of a few tracers of a run among the scatterers, and a picture of them.

A run keeps sums, not paths. A path is found again by following the same tracers up to 1, 2, 3 ...
collisions: each such run ends at the place of a collision, to the same bits as the run itself.
Where paths are curved, in a field and with noise and drag, the places at many times are taken
instead; with noise a tracer whose outputs are at other times has another path of the same kind.
Begin reading with `trajectories`.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from particles import outputs
from particles.configuration import follow_tracers, start_places
from particles.media import BoltzmannGrad
from particles.placement import build, placed
from particles.plan import Plan
from particles.plots import describe_system
from particles.values import Value, check_positive, check_whole, refuse

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap, Normalize

#: Most collisions of one path. Chosen: the time that a path takes grows as the square of this.
MOST_COLLISIONS = 1000
#: Points of a curved path. The origin of the number is not recorded.
CURVE_POINTS = 2001
#: Most disks in one picture. The origin of the number is not recorded.
MOST_SCATTERERS = 50_000
#: Most disks in a picture that shades what a tracer's centre cannot enter. The origin of the number
#: is not recorded.
MOST_SHADED = 1500
#: Colour of disks.
DISK_COLOUR = "#8d98a5"
#: Colour of the marks where paths begin and end.
MARK_COLOUR = "#16191d"
#: Smallest width of a picture in d. The origin of the number is not recorded.
SMALLEST_WIDTH = 8.0
#: Tracers that a picture shows unless it is asked for others: more hide each other.
USUAL_TRACERS = 8
#: Smallest ratio of the sides of a picture. The origin of the number is not recorded.
SMALLEST_ASPECT = 0.6
#: Margin around paths, as a share of the longer side. The origin of the number is not recorded.
MARGIN = 0.06
#: Share of the speeds that have the first colour. Chosen: a tracer that starts at rest is slower
#: than all others for a moment only.
SHARE_OF_SLOWEST = 0.01
#: End of the colour map that is used. Chosen: beyond, it is nearly white and not seen on paper.
LAST_COLOUR = 0.88
#: Colours of speeds. The origin of the number is not recorded.
COLOURS = 256


@dataclass(frozen=True, eq=False)
class Trajectory(Value):
    """The path of one tracer: straight from each place to the next, or nearly so in a field.

    times (n,) in d/U: of the start, of each collision and of the end. places (n, dimension) in d,
    from the start of the first tracer. speeds (n - 1,) in U: between two places.
    """

    times: np.ndarray
    places: np.ndarray
    speeds: np.ndarray


def is_curved(plan: Plan) -> bool:
    """Tell whether paths are curved: in a field, and with noise or drag."""
    return plan.drive.field != 0.0 or plan.drive.is_noisy


# -- the paths -------------------------------------------------------------------------------------


def trajectories(
    plan: Plan,
    tracers: int | None = None,
    configuration: int = 0,
    until: float | None = None,
    collisions: int = 300,
) -> list[Trajectory]:
    """Return the paths of the first tracers of one configuration of a run.

    tracers: how many; None: `USUAL_TRACERS`, or all where a configuration has fewer. until: the
    time in d/U at which they end, that of the run's last output if None. collisions: where they end
    at the latest, 1000 at most (not in a field).
    """
    if tracers is None:
        tracers = min(USUAL_TRACERS, plan.tracers)
    tracers = check_whole("tracers", tracers, 1, plan.tracers)
    configuration = check_whole("configuration", configuration, 0, plan.media - 1)
    collisions = check_whole("collisions", collisions, 1, MOST_COLLISIONS)
    if until is not None:
        until = check_positive("until", until)
    elif plan.times.size:
        until = float(plan.times[-1])
    if until == 0.0 or (until is None and is_curved(plan)):
        refuse("until", until, "it must be a time above 0, given where the run has no output times")
    velocities = None if plan.velocities is None else plan.velocities[..., :tracers, :]
    plan = plan.replaced(tracers=tracers, depth=None, velocities=velocities)
    if is_curved(plan):
        return _curved_paths(plan, configuration, until or 0.0)
    if plan.max_collisions:
        collisions = min(collisions, plan.max_collisions)
    return _straight_paths(plan, configuration, until, collisions)


def _curved_paths(plan: Plan, configuration: int, until: float) -> list[Trajectory]:
    """Return places at equal steps of time, and the speeds between them."""
    times = np.linspace(0.0, until, CURVE_POINTS)
    plan = plan.replaced(times=times, observables=frozenset({"positions", "velocities"}))
    cells = build(plan.medium, np.uint64(plan.seed), configuration)
    arrays = follow_tracers(plan, configuration, cells)
    places = np.moveaxis(arrays["raw/positions"], 1, 0)
    velocities = np.moveaxis(arrays["raw/velocities"], 1, 0)
    starts = start_places(plan, configuration, cells, 0, plan.tracers)
    if cells is not None and len(starts):
        cell_of_start = starts[:, None, :2]
        place_in_cell = starts[:, None, 2:]
        places = places + (cell_of_start * cells.side + place_in_cell)
    places = places * plan.medium.diameter
    speeds = np.linalg.norm(velocities, axis=-1)
    paths = []
    for places_of_tracer, speeds_of_tracer in zip(places, speeds, strict=True):
        n = int(np.isfinite(places_of_tracer[:, 0]).sum())  # NaN after the end of a tracer
        mean_speeds = 0.5 * (speeds_of_tracer[1:n] + speeds_of_tracer[: n - 1])
        paths.append(Trajectory(times[:n], places_of_tracer[:n], mean_speeds))
    return paths


class _GrowingPath:
    """The path of one tracer up to the last collision that it has been followed to."""

    def __init__(self, velocity: np.ndarray) -> None:
        self.times = [0.0]
        self.places = [np.zeros(velocity.size)]
        self.speeds = [float(np.linalg.norm(velocity))]
        self.has_ended = False

    def extend(self, end: np.ndarray, collisions: int, unit: float) -> None:
        """Add the end of a run up to so many collisions, a row of `raw/finals`; unit: d."""
        dimension = self.places[0].size
        place = end[[outputs.FINAL_X, outputs.FINAL_Y, outputs.FINAL_Z][:dimension]]
        self.times.append(float(np.exp(end[outputs.LN_TIME])) * unit)
        self.places.append(place * unit)
        self.speeds.append(float(np.exp(end[outputs.LN_SPEED])))
        self.has_ended = bool(end[outputs.FINAL_COLLISIONS] < collisions)

    def trajectory(self) -> Trajectory:
        """Return the path; nothing follows the last speed."""
        return Trajectory(np.array(self.times), np.array(self.places), np.array(self.speeds[:-1]))


def _straight_paths(
    plan: Plan, configuration: int, until: float | None, collisions: int
) -> list[Trajectory]:
    """Return the places of the start, of collisions and of the end, and the speeds between them."""
    cells = build(plan.medium, np.uint64(plan.seed), configuration)
    start = plan.replaced(times=np.zeros(1), observables=frozenset({"velocities"}))
    velocities = follow_tracers(start, configuration, cells)["raw/velocities"][0]
    paths = [_GrowingPath(velocity) for velocity in velocities]
    times = np.empty(0) if until is None else np.array([until])
    plan = plan.replaced(times=times, observables=frozenset({"finals"}))
    for n in range(1, collisions + 1):
        arrays = follow_tracers(plan.replaced(max_collisions=n), configuration, cells)
        for path, end in zip(paths, arrays["raw/finals"], strict=True):
            if not path.has_ended:
                path.extend(end, n, plan.medium.diameter)
        if arrays["statuses"][outputs.COLLISION_CAP] == 0:
            break
    return [path.trajectory() for path in paths]


def disks_within(
    plan: Plan, configuration: int, low: np.ndarray, high: np.ndarray
) -> np.ndarray | None:
    """Return the disks between two corners, (n, 2), in d from the start; None if there are many."""
    medium = plan.medium
    if isinstance(medium, BoltzmannGrad) or medium.dimension != 2:
        return None
    area = np.prod(high - low)
    if area * medium.number_density > MOST_SCATTERERS:
        return None
    _cells, places = placed(medium, np.uint64(plan.seed), configuration)
    box = medium.box_side
    images_x = np.arange(np.floor(low[0] / box), np.ceil(high[0] / box) + 1)
    images_y = np.arange(np.floor(low[1] / box), np.ceil(high[1] / box) + 1)
    shifts = np.stack(np.meshgrid(images_x, images_y), axis=-1).reshape(-1, 1, 2) * box
    disks = (places[:, :2] * medium.diameter + shifts).reshape(-1, 2)
    is_within = np.all((disks >= low) & (disks <= high), axis=1)
    return np.asarray(disks[is_within])


# -- the picture -----------------------------------------------------------------------------------


def plot_trajectories(
    plan: Plan,
    tracers: int | None = None,
    ax: "Axes | None" = None,
    colour_bar: bool = True,
    configuration: int = 0,
    until: float | None = None,
    collisions: int = 300,
) -> "Axes":
    """Draw `trajectories`, in space projected on x and y, and the disks beside them."""
    paths = trajectories(plan, tracers, configuration, until, collisions)
    d = plan.medium.diameter
    low, high = corners_of_picture(paths, d)
    if ax is None:
        from matplotlib import pyplot

        _figure, ax = pyplot.subplots(layout="constrained")
    disks = disks_within(plan, configuration, low - d, high + d)
    if disks is not None:
        if len(disks) <= MOST_SHADED:
            # The area that a tracer's centre cannot enter.
            draw_circles(ax, disks, 2.0 * d, alpha=0.2)
        draw_circles(ax, disks, d, alpha=1.0)
    _draw_paths(ax, paths, colour_bar)
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel="$x$ [$d$]", ylabel="$y$ [$d$]")
    if not ax.get_title():
        ax.set_title(", ".join(describe_system(plan)), fontsize="medium")
    ax.set_aspect("equal")
    ax.grid(False)
    return ax


def corners_of_picture(paths: list[Trajectory], d: float) -> tuple[np.ndarray, np.ndarray]:
    """Return two corners of a picture with all paths in it, neither too small nor too narrow."""
    places = np.concatenate([path.places[:, :2] for path in paths])
    lowest = places.min(axis=0)
    highest = places.max(axis=0)
    middle = (lowest + highest) / 2
    sides = np.ptp(places, axis=0)
    longest = max(float(sides.max()), SMALLEST_WIDTH * d)
    half = np.maximum(sides, SMALLEST_ASPECT * longest) / 2 + MARGIN * longest
    return middle - half, middle + half


def draw_circles(ax: "Axes", centres: np.ndarray, diameter: float, alpha: float) -> None:
    """Draw filled circles, one that is less transparent on top of the others."""
    from matplotlib.collections import EllipseCollection

    width = [diameter]  # one for all: an SVG then holds the circle once
    circles = EllipseCollection(
        width,
        width,
        [0.0],
        units="xy",
        offsets=centres,
        offset_transform=ax.transData,
        facecolor=DISK_COLOUR,
        alpha=alpha,
        edgecolor="none",
        zorder=0.5 + 0.1 * alpha,
    )
    ax.add_collection(circles)


def _draw_paths(ax: "Axes", paths: list[Trajectory], colour_bar: bool) -> None:
    """Draw paths in the colours of their speeds, and marks where they begin and end."""
    from matplotlib.collections import LineCollection

    slowest, colours, norm = colours_of_speeds(paths)
    for path in paths:
        places = path.places[:, :2]
        lines = LineCollection(
            list(np.stack([places[:-1], places[1:]], axis=1)),
            cmap=colours,
            norm=norm,
            linewidths=1.4,
            capstyle="round",
            zorder=2,
        )
        lines.set_array(np.maximum(path.speeds, slowest))
        ax.add_collection(lines)
        ax.plot(*places[-1], "o", color=MARK_COLOUR, markersize=3.2, zorder=3)
        ax.plot(
            *places[0],
            "o",
            markerfacecolor="white",
            markeredgecolor=MARK_COLOUR,
            markersize=6,
            zorder=4,
        )
    if colour_bar:
        ax.figure.colorbar(lines, ax=ax, label="speed $v$ [$U$]", shrink=0.8)


def colours_of_speeds(paths: list[Trajectory]) -> tuple[float, "Colormap", "Normalize"]:
    """Return the speed of the first colour, the colours, and what maps speeds to them."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap, LogNorm

    speeds = np.concatenate([path.speeds for path in paths])
    moving = speeds[speeds > 0.0]
    slowest = 1.0
    fastest = 1.0
    if moving.size:
        slowest, fastest = np.quantile(moving, [SHARE_OF_SLOWEST, 1.0])
    colours = ListedColormap(colormaps["plasma"](np.linspace(0.0, LAST_COLOUR, COLOURS)))
    if fastest > 1.001 * slowest:
        norm = LogNorm(slowest, fastest)
    else:
        norm = LogNorm(0.9 * slowest, 1.1 * fastest)
    return slowest, colours, norm
