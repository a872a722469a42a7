"""A film of a few tracers among the scatterers, in a clock that goes with the collisions.

Tracers that lose energy collide at ever longer times: N grows as ln t. Frames at equal times would
show all collisions in the first of them, so frames are equally spaced in the logarithm of the time
or in the mean number of collisions. No positions need to be recorded: paths are found again, as of
`particles.paths`, to the same bits. Begin reading with `animate`.
"""

import os
from collections.abc import Sequence
from os import PathLike
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from particles.paths import (
    Trajectory,
    colours_of_speeds,
    corners_of_picture,
    disks_within,
    draw_circles,
    is_curved,
    trajectories,
)
from particles.plan import Plan
from particles.plots import describe_system
from particles.values import check_number, check_path, check_whole, refuse

if TYPE_CHECKING:
    from matplotlib.animation import AbstractMovieWriter, FuncAnimation
    from matplotlib.lines import Line2D

Clock = Literal["log time", "collisions"]
#: How frames may be spaced.
CLOCKS = ("log time", "collisions")
#: Most frames. Chosen: a minute at 30 a second; more take minutes to draw.
MOST_FRAMES = 2000
#: Most frames in a second.
MOST_PER_SECOND = 100.0
#: Time of the second frame over the mean time of the first collision. Chosen: with equal ratios of
#: times from an earlier one on, half of the film would show free flights.
FIRST_FRAME = 0.5
#: Dots per inch, and the width of a picture in inches. Chosen: 480 dots, a GIF of a megabyte or so.
DOTS_PER_INCH = 80
#: Width of a picture in inches.
WIDTH_OF_PICTURE = 6.0
#: Size of the marker of a tracer, in points^2.
SIZE_OF_TRACER = 40.0
#: Colour and width in points of the path behind a tracer.
COLOUR_OF_TRAIL = "#16191d"
#: Width in points of the path behind a tracer.
WIDTH_OF_TRAIL = 0.7
#: Opacity of the path behind a tracer.
OPACITY_OF_TRAIL = 0.45


class Moment(NamedTuple):
    """Where tracers are at a time, and how fast.

    places (n, 2) in d, projected on x and y; speeds (n,) in U; collisions: mean number so far,
    where paths are straight.
    """

    time: float
    places: np.ndarray
    speeds: np.ndarray
    collisions: float


def moment_of(paths: Sequence[Trajectory], time: float) -> Moment:
    """Return where tracers are; one that has ended stays where it ended, with its last speed."""
    places = []
    speeds = []
    collisions = []
    for path in paths:
        x = np.interp(time, path.times, path.places[:, 0])
        y = np.interp(time, path.times, path.places[:, 1])
        flight = int(np.searchsorted(path.times, time, side="right")) - 1
        flight = min(flight, len(path.speeds) - 1)
        places.append((x, y))
        speeds.append(path.speeds[flight])
        collisions.append(flight)
    return Moment(time, np.array(places), np.array(speeds), float(np.mean(collisions)))


def frame_times(paths: Sequence[Trajectory], frames: int, clock: Clock) -> np.ndarray:
    """Return the times of frames in d/U, (frames,), rising, from 0 to the end of the longest path.

    clock: "log time", equal ratios from `FIRST_FRAME` on; or "collisions", equal numbers of
    collisions between one frame and the next.
    """
    events = np.sort(np.concatenate([path.times[1:] for path in paths]))
    if clock == "log time":
        first = FIRST_FRAME * float(np.mean([path.times[1] for path in paths]))
        first = min(first, float(events[-1]) / 2.0)
        return np.concatenate([[0.0], np.geomspace(first, events[-1], frames - 1)])
    numbers = np.arange(events.size + 1) / len(paths)
    known = np.concatenate([[0.0], events])
    return np.interp(np.linspace(0.0, numbers[-1], frames), numbers, known)


def animate(
    plan: Plan,
    path: str | PathLike[str] | None = None,
    tracers: int | None = None,
    frames: int = 120,
    clock: Clock = "log time",
    per_second: float = 20.0,
    configuration: int = 0,
    until: float | None = None,
    collisions: int = 100,
) -> "FuncAnimation":
    """Return a film of tracers among the scatterers, and save it where a path is given."""
    frames = check_whole("frames", frames, 2, MOST_FRAMES)
    if clock not in CLOCKS:
        refuse("clock", clock, "it must be 'log time' or 'collisions'")
    if clock == "collisions" and is_curved(plan):
        refuse("clock", clock, "curved paths, in a field or with noise, have 'log time' only")
    allowed = f"it must be a number above 0, {MOST_PER_SECOND:g} at most"
    per_second = check_number("per_second", per_second, 1e-3, MOST_PER_SECOND, allowed)
    writer = None
    if path is not None:
        path = check_path("path", path)
        writer = _writer_of(path, per_second)
    paths = trajectories(plan, tracers, configuration, until, collisions)
    film = _Film(plan, paths, configuration, frame_times(paths, frames, clock), clock)
    animation = film.animation(1000.0 / per_second)
    if writer is not None:
        assert path is not None
        _save(animation, path, writer)
    return animation


def _writer_of(path: str, per_second: float) -> "AbstractMovieWriter":
    """Return what writes a film of this name; ValueError where there is nothing that can."""
    from matplotlib.animation import FFMpegWriter, PillowWriter

    ending = os.path.splitext(path)[1].lower()
    if ending == ".gif":
        return PillowWriter(fps=per_second)  # type: ignore[arg-type]  # it takes any number
    if ending != ".mp4":
        refuse("path", path, "it must end in .gif or .mp4")
    if not FFMpegWriter.isAvailable():
        refuse("path", path, "MP4 needs the program ffmpeg, which is not there; .gif needs none")
    return FFMpegWriter(fps=per_second)  # type: ignore[arg-type]


def _save(animation: "FuncAnimation", path: str, writer: "AbstractMovieWriter") -> None:
    """Write a film to a file; ValueError if it cannot be written."""
    try:
        animation.save(path, writer=writer, dpi=DOTS_PER_INCH)
    except OSError as error:
        refuse("path", path, f"it cannot be written ({error.strerror or error})")


class _Film:
    """The picture that the frames of a film change: tracers, their trails, and the title."""

    def __init__(
        self,
        plan: Plan,
        paths: list[Trajectory],
        configuration: int,
        times: np.ndarray,
        clock: Clock,
    ) -> None:
        from matplotlib import pyplot

        self.paths = paths
        self.times = times
        self.is_curved = is_curved(plan)
        self.system = ", ".join(describe_system(plan))
        self.slowest, colours, norm = colours_of_speeds(paths)
        d = plan.medium.diameter
        low, high = corners_of_picture(paths, d)
        height = WIDTH_OF_PICTURE * float((high[1] - low[1]) / (high[0] - low[0]))
        size = (WIDTH_OF_PICTURE, max(height, 0.5 * WIDTH_OF_PICTURE))
        self.figure, self.axes = pyplot.subplots(figsize=size, layout="constrained")
        disks = disks_within(plan, configuration, low - d, high + d)
        if disks is not None:
            draw_circles(self.axes, disks, d, alpha=1.0)
        self.trails: list[Line2D] = []
        for _ in paths:
            (trail,) = self.axes.plot(
                [], [], color=COLOUR_OF_TRAIL, lw=WIDTH_OF_TRAIL, alpha=OPACITY_OF_TRAIL
            )
            self.trails.append(trail)
        first = moment_of(paths, 0.0)
        self.dots = self.axes.scatter(
            first.places[:, 0],
            first.places[:, 1],
            c=np.maximum(first.speeds, self.slowest),
            cmap=colours,
            norm=norm,
            s=SIZE_OF_TRACER,
            edgecolors=COLOUR_OF_TRAIL,
            linewidths=WIDTH_OF_TRAIL,
            zorder=3,
        )
        self.figure.colorbar(self.dots, ax=self.axes, label="speed $v$ [$U$]", shrink=0.8)
        self.axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        self.axes.set(xlabel="$x$ [$d$]", ylabel="$y$ [$d$]")
        self.axes.set_aspect("equal")
        self.axes.grid(False)
        self.draw(0)
        self.figure.draw_without_rendering()
        self.figure.set_layout_engine("none")  # what it found stays, and frames do not jump

    def draw(self, frame: int) -> list["Line2D"]:
        """Draw one frame."""
        now = moment_of(self.paths, float(self.times[frame]))
        self.dots.set_offsets(now.places)
        self.dots.set_array(np.maximum(now.speeds, self.slowest))
        for trail, path, place in zip(self.trails, self.paths, now.places, strict=True):
            behind = path.places[path.times <= now.time, :2]
            trail.set_data(*np.vstack([behind, place]).T)
        title = f"{self.system}\nt = {now.time:.4g} d/U"
        if not self.is_curved:
            title += f", {now.collisions:.1f} collisions per tracer"
        self.axes.set_title(title, fontsize="medium")
        return self.trails

    def animation(self, interval: float) -> "FuncAnimation":
        """Return the film, whose frames follow after so many ms."""
        from matplotlib.animation import FuncAnimation

        n = len(self.times)
        film = FuncAnimation(self.figure, self.draw, frames=n, interval=interval)
        return film
