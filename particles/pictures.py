"""The picture of a run: paths of tracers among the disks, coloured by the speed."""

from typing import TYPE_CHECKING, Any

import numpy as np

from particles.configuration import Plan
from particles.trajectories import Trajectory, scatterers, trajectories

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = "plasma"
# Nearly white in plasma: a path that ends there could not be seen on paper.
_BRIGHTEST = 0.88
_SLOWEST = 0.01  # share of the pieces of paths that have the colour of the scale's end
_DISK, _MARK = "#8d98a5", "#16191d"
_WIDTH = 6.4  # of a new figure, in inches
_FEW_DECADES = 1e3
_MARGIN = 0.06  # of the larger side, around the paths
_LEAST_SIDE = 8.0  # of the picture, in diameters
_FEW = 1500  # disks, around which the area is shaded that the tracer's centre cannot enter


def plot_trajectories(
    plan: Plan,
    tracers: int = 8,
    configuration: int = 0,
    until: float | None = None,
    collisions: int = 300,
    colour_bar: bool = True,
    ax: "Axes | None" = None,
) -> "Axes":
    """Draw paths of the first tracers of one configuration of a run, and the disks beside them.

    Arguments as of `trajectories`. In space the paths are projected on the plane of x and y, and no
    sphere is drawn. Returns the axes.
    """
    found = trajectories(plan, tracers, configuration, until, collisions)
    low, high = _window([path.places[:, :2] for path in found], plan.medium.diameter)
    if ax is None:
        from matplotlib import pyplot

        width, height = high - low
        size = _WIDTH, 0.4 + (_WIDTH - 1.4) * height / width
        _, ax = pyplot.subplots(figsize=size, layout="constrained")
    disks = scatterers(plan, configuration, low - plan.medium.diameter, high + plan.medium.diameter)
    if disks is not None:
        _draw_disks(ax, disks, plan.medium.diameter)
    lines = _draw_paths(ax, found)
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel="x [d]", ylabel="y [d]")
    ax.set_aspect("equal")
    ax.grid(False)
    if colour_bar:
        _draw_colour_bar(ax, lines)
    return ax


def _window(places: list[np.ndarray], diameter: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners of a rectangle about the paths; neither side much shorter than the other.

    A path that is nearly a straight line would else have no height.
    """
    every = np.concatenate(places)
    low, high = every.min(axis=0), every.max(axis=0)
    middle, sides = (low + high) / 2, high - low
    largest = max(float(sides.max()), _LEAST_SIDE * diameter)
    half = np.maximum(sides, 0.6 * largest) / 2 + _MARGIN * largest
    return middle - half, middle + half


def _draw_disks(ax: "Axes", disks: np.ndarray, diameter: float) -> None:
    """Draw the disks, and around few of them the circle on which the tracer's centre turns."""
    from matplotlib.collections import EllipseCollection

    few = len(disks) <= _FEW
    for size, strength, order in ((2.0, 0.2, 0.5), (1.0, 1.0, 0.6)):
        if size == 1.0 or few:
            width = [size * diameter]  # one for all: an SVG then holds the circle once
            ax.add_collection(
                EllipseCollection(
                    width, width, [0.0], units="xy", offsets=disks, offset_transform=ax.transData,
                    facecolor=_DISK, alpha=strength, edgecolor="none", zorder=order,
                )
            )  # fmt: skip


def _draw_paths(ax: "Axes", found: list[Trajectory]) -> Any:
    """Draw every path, its end and its start; return what a colour bar is made from."""
    from matplotlib import colormaps
    from matplotlib.collections import LineCollection
    from matplotlib.colors import ListedColormap, LogNorm

    speeds = np.concatenate([path.speeds for path in found])
    moving = speeds[speeds > 0.0]
    # a tracer that starts at rest is slower than all others for a moment only
    least, largest = np.quantile(moving, [_SLOWEST, 1.0]) if moving.size else (1.0, 1.0)
    if largest < 1.001 * least:  # all the same: a scale needs two ends
        least, largest = 0.9 * least, 1.1 * largest
    norm = LogNorm(least, largest)
    colours = ListedColormap(colormaps[COLOURS](np.linspace(0.0, _BRIGHTEST, 256)))
    for path in found:
        places = path.places[:, :2]
        segments = np.stack([places[:-1], places[1:]], axis=1)
        lines = LineCollection(
            list(segments), cmap=colours, norm=norm, linewidths=1.4, capstyle="round", zorder=2
        )
        lines.set_array(np.maximum(path.speeds, least))
        ax.add_collection(lines)
        ax.plot(*places[-1], "o", color=_MARK, markersize=3.2, zorder=3)
    for x, y in {tuple(path.places[0, :2]) for path in found}:
        ax.plot(x, y, "o", markerfacecolor="white", markeredgecolor=_MARK, markersize=6, zorder=4)
    return lines


def _draw_colour_bar(ax: "Axes", lines: Any) -> None:
    """Add the scale of the speeds, with its numbers written out where they span few decades."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    bar = ax.figure.colorbar(lines, ax=ax, label="speed v [U]", shrink=0.8)
    if lines.norm.vmax < _FEW_DECADES * lines.norm.vmin:
        bar.ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda speed, _: f"{speed:g}"))
    bar.ax.yaxis.set_minor_formatter(NullFormatter())
