"""Axes, strokes and legend of a figure of a report, and the figure as a file or part of a page.

The same value of the parameter has the same colour and marker in every figure; a stroke is who says
so. An SVG in a page takes its colours from the page's CSS variables: one picture serves light and
dark.
"""

import io
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from typing import Literal, TypedDict

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator
from numpy.typing import ArrayLike

from kinetics.crosscheck.report.cases import FIT, SONINE, Measured
from kinetics.crosscheck.report.systems import System
from kinetics.crosscheck.words import numeral

INK = "#16191d"
FAINT = "#dde1e6"
#: Colours of the values of the parameter, in their order (after Okabe and Ito, dark enough for
#: text).
COLOURS = ("#0072b2", "#c04f00", "#007a58", "#b3478f", "#876600", "#3c4bb0")
#: Colours of what is no value of the parameter: disks and spheres, observables, densities.
GROUP_COLOURS = ("#8a1538", "#00707a", "#6b4a2b", "#5a6572")
VARIABLES = {
    INK: "var(--ink)",
    FAINT: "var(--faint)",
    **{colour: f"var(--series-{index})" for index, colour in enumerate(COLOURS)},
    **{colour: f"var(--group-{index})" for index, colour in enumerate(GROUP_COLOURS)},
}
MARKERS = "os^DvP"
STYLE = str(files("kinetics.crosscheck") / "templates" / "report.mplstyle")

#: Stroke of a line as matplotlib takes it: a name, or an offset and a sequence of lengths.
LineStyle = Literal["-", "none"] | tuple[float, Sequence[float]]


def stroke(*lengths: float) -> LineStyle:
    """Return a stroke without offset; lengths of dash, gap, dash, gap, ... in line widths."""
    return 0, lengths


#: Stroke of dashes, as long as they can be told from dots. Its lengths' origin is not recorded.
DASHED = stroke(4, 2)
#: Stroke of dots. The origin of its lengths is not recorded.
DOTTED = stroke(1, 1.5)
#: Stroke of dashes and dots in turns. The origin of its lengths is not recorded.
DASH_DOTTED = stroke(6, 1.5, 1, 1.5)
CORRECTED = "corrected equation"
INTEGRAL = "paper's integral"
PEAK = "paper, peak"
TAIL = "paper, tail"
GAUSSIAN = "Gaussian"
LIMITING_LAW = "limiting law"
#: Stroke of who draws a line; all others draw solid ones.
LINE_STYLES: dict[str, LineStyle] = {
    SONINE: DASHED,
    TAIL: DASHED,
    INTEGRAL: DOTTED,
    LIMITING_LAW: DOTTED,
    FIT: DASH_DOTTED,
    PEAK: DASH_DOTTED,
    GAUSSIAN: DASH_DOTTED,
    CORRECTED: DASHED,
    "root of eq. (B17)": DASHED,
    "paper: 0.058 t": DASHED,
}
#: Width of a figure in inches. The origin is not recorded.
WIDTH = 5.0
#: Inches below the axes for the labels of the abscissa.
HEIGHT_OF_LABELS = 0.5
#: Inches of a line of the legend.
HEIGHT_OF_LEGEND_LINE = 0.2
#: Inches above a panel for its title.
HEIGHT_OF_PANEL_TITLE = 0.35
#: Inches between rows without titles.
HEIGHT_BETWEEN_ROWS = 0.15
#: Entries in a line of the legend: as many as the width holds.
LEGEND_COLUMNS = 3
#: Range of a logarithmic axis from which on only powers of ten are labelled.
DECADES_ONLY_FROM = 30
#: Largest relative error of a point on a logarithmic axis: the bar of a larger one fills the axis.
MAX_RELATIVE_ERROR_ON_LOG = 0.5
#: Resolution of PNG files.
DOTS_PER_INCH = 200

FileKind = Literal["svg", "pdf", "png"]


class Stroke(TypedDict, total=False):
    """How matplotlib draws a line or points."""

    color: str
    linestyle: LineStyle
    marker: str
    markersize: float
    markerfacecolor: str


@dataclass(frozen=True)
class Group:
    """What a line belongs to that is no value of the parameter: its name and its number."""

    name: str
    index: int


#: A value of the parameter, a group, or nothing (ink).
Key = float | Group | None


@dataclass(frozen=True)
class Drawn:
    """A figure with its words."""

    name: str
    title: str
    caption: str
    figure: Figure

    @property
    def words(self) -> dict[str, str]:
        """Name, title and caption."""
        return {"name": self.name, "title": self.title, "caption": self.caption}

    def file(self, kind: str) -> bytes:
        """Return it as a file, in the page's light colours: kind "svg", "pdf" or "png"."""
        buffer = io.BytesIO()
        undated: dict[str, dict[str, None]] = {
            "svg": {"Date": None},
            "pdf": {"CreationDate": None},
            "png": {"Software": None},
        }
        with mpl.rc_context(fname=STYLE):
            self.figure.savefig(buffer, format=kind, metadata=undated[kind], dpi=DOTS_PER_INCH)
        return buffer.getvalue()

    def svg(self) -> str:
        """Return an element of a page: own ids, the page's colours, words for screen readers."""
        prefix = f"fig-{self.name}-"
        text = self.file("svg").decode()
        text = text[text.index("<svg") :]
        text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
        text = re.sub(r'\s+xmlns(:\w+)?="[^"]*"', "", text).replace("xlink:href=", "href=")
        text = re.sub(r'\b(id="|href="#)(?=[^"])', rf"\1{prefix}", text)
        text = text.replace("url(#", f"url(#{prefix}")
        for colour, variable in VARIABLES.items():
            text = text.replace(colour, variable)
        head, body = text.split(">", 1)
        head = re.sub(r'\s(width|height)="[^"]*"', "", head)  # the page gives the size
        title = f'<title id="{prefix}title">{escape(self.title)}</title>'
        description = f'<desc id="{prefix}desc">{escape(self.caption)}</desc>'
        labels = f'role="img" aria-labelledby="{prefix}title {prefix}desc"'
        return f"{head} {labels}>{title}{description}{body.strip()}"


class Sheet:
    """Axes in a grid of rows of these heights, in inches, and a legend of all that is on them."""

    def __init__(
        self,
        system: System,
        heights: Sequence[float] = (2.9,),
        columns: int = 1,
        has_panels: bool = False,
    ) -> None:
        self.system = system
        self.columns = columns
        self.figure = Figure(layout="constrained")
        FigureCanvasAgg(self.figure)  # knows the other formats as well
        around_row = HEIGHT_OF_PANEL_TITLE if has_panels else HEIGHT_BETWEEN_ROWS
        self.height = sum(heights) + len(heights) * around_row
        axes = self.figure.subplots(
            len(heights),
            columns,
            squeeze=False,
            sharex="all",
            sharey="all" if has_panels else "none",
            height_ratios=heights,
        )
        self.axes: list[Axes] = list(axes.flat)
        self._legend: dict[str, Stroke] = {}

    def colour(self, key: Key) -> str:
        """Return the colour of a value of the parameter or a group; else that of ink."""
        if key is None:
            return INK
        if isinstance(key, Group):
            return GROUP_COLOURS[key.index % len(GROUP_COLOURS)]
        return COLOURS[self.system.values.index(key) % len(COLOURS)]

    def marker(self, key: Key) -> str:
        """Return the marker of a value of the parameter or a group."""
        if key is None:
            return "o"
        index = key.index if isinstance(key, Group) else self.system.values.index(key)
        return MARKERS[index % len(MARKERS)]

    def _add_to_legend(self, source: str, stroke: Stroke, key: Key) -> None:
        """Enter who says something, in ink, and the key, if there is one, in its colour."""
        in_ink: Stroke = {"color": INK, **stroke}
        self._legend.setdefault(source, in_ink)
        if key is None:
            return
        label = key.name if isinstance(key, Group) else f"{self.system.parameter} = {key:g}"
        of_key: Stroke = {"color": self.colour(key), "marker": self.marker(key), "linestyle": "-"}
        self._legend.setdefault(label, of_key)

    def line(
        self,
        ax: Axes,
        source: str,
        x: ArrayLike,
        y: ArrayLike,
        key: Key = None,
        in_legend: bool = True,
    ) -> None:
        """Draw a line; its key is in the legend only if `in_legend`."""
        stroke: Stroke = {"linestyle": LINE_STYLES.get(source, "-")}
        abscissa, ordinate = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        ax.plot(abscissa, ordinate, color=self.colour(key), **stroke)
        self._add_to_legend(source, stroke, key if in_legend else None)

    def points(
        self,
        ax: Axes,
        source: str,
        x: ArrayLike,
        measured: Measured,
        key: Key = None,
        in_legend: bool = True,
        max_error: float = math.inf,
    ) -> None:
        """Draw points with bars of one standard error; without those of a larger error."""
        abscissa, value, error = np.broadcast_arrays(x, measured.value, measured.error)
        is_shown = np.isfinite(value) & (error > 0) & (error < max_error)
        if ax.get_yscale() == "log":
            is_shown &= (value > 0) & (error < MAX_RELATIVE_ERROR_ON_LOG * value)
        stroke: Stroke = {"linestyle": "none", "markersize": 3.8}
        if source.startswith("hard"):
            stroke = {"linestyle": "none", "markersize": 4.6, "markerfacecolor": "none"}
        ax.errorbar(
            abscissa[is_shown],
            value[is_shown],
            error[is_shown],
            color=self.colour(key),
            marker=self.marker(key),
            elinewidth=1.0,
            **stroke,
        )
        in_legend_stroke: Stroke = {"marker": "o", **stroke}
        self._add_to_legend(source, in_legend_stroke, key if in_legend else None)

    def marks(self, ax: Axes, source: str, x: ArrayLike, y: ArrayLike, marker: str) -> None:
        """Draw open marks without errors, in ink."""
        stroke: Stroke = {
            "marker": marker,
            "linestyle": "none",
            "markersize": 7.0,
            "markerfacecolor": "none",
        }
        ax.plot(x, y, color=INK, **stroke)
        self._add_to_legend(source, stroke, None)

    def finish(self, x_label: str, *y_labels: str) -> Figure:
        """Set labels (one of y for each row, or for all), ticks and the legend."""
        lines = math.ceil(len(self._legend) / LEGEND_COLUMNS)
        height = self.height + HEIGHT_OF_LABELS + HEIGHT_OF_LEGEND_LINE * lines
        self.figure.set_size_inches(WIDTH, height)
        for index, ax in enumerate(self.axes):
            row, column = divmod(index, self.columns)
            if index >= len(self.axes) - self.columns:
                ax.set_xlabel(ax.get_xlabel() or x_label)
            if column == 0:
                ax.set_ylabel(y_labels[min(row, len(y_labels) - 1)])
            self._set_ticks(ax.xaxis)
            self._set_ticks(ax.yaxis)
        self.figure.legend(
            [Line2D([], [], **stroke) for stroke in self._legend.values()],
            list(self._legend),
            loc="outside upper left",
            ncols=LEGEND_COLUMNS,
        )
        return self.figure

    def _set_ticks(self, axis: Axis) -> None:
        """Set ticks that do not collide: few where there are several axes."""
        has_several = len(self.axes) > 1
        if axis.get_scale() != "log":
            prune: Literal["both"] | None = "both" if self.columns > 1 else None
            count = 4 if has_several else 6
            axis.set_major_locator(MaxNLocator(count, prune=prune, steps=[1, 2, 2.5, 5, 10]))
            return
        low, high = axis.get_view_interval()
        subdivisions: tuple[float, ...] = (1.0, 2.0, 5.0)
        if high > DECADES_ONLY_FROM * low:
            subdivisions = (1.0,)
        axis.set_major_locator(LogLocator(subs=subdivisions, numticks=5 if has_several else 7))
        axis.set_minor_locator(NullLocator())
        if len(subdivisions) == 1:
            axis.set_major_formatter(lambda value, _: numeral(value, ".0e"))
        else:
            axis.set_major_formatter("{x:g}")
