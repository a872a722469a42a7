"""The figures of a comparison: lines for the theory, points with standard errors for the data.

Begin with `draw`; `picture` makes a file of several.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from kinetics.crosscheck.compare.observables import BETWEEN_FRAMES, OBSERVABLES, SPEED_DENSITY
from kinetics.crosscheck.words import LIMIT_SHARE, limit_factor
from kinetics.outputs import OUTPUTS, described
from kinetics.results.labels import axis_label, system_items
from kinetics.results.plot import POWERS_OF_TIME, SOURCE, add_legend, n_curves_of

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

#: The name of the figure of e and l together.
CONFIDENCE = "confidence"
#: The share of a Gaussian within one standard deviation.
ONE_SIGMA_SHARE = 0.6827
#: Points of an ellipse: a polygon of so many sides looks smooth.
POINTS_OF_ELLIPSE = 121
#: Width in inches of one of several figures in a picture. Chosen.
WIDTH_OF_FIGURE = 4.6
#: Height in inches of one of several figures in a picture. Chosen.
HEIGHT_OF_FIGURE = 3.2
#: Space above and below ellipses, of their height, so that the legend covers none of them.
SPACE_FOR_LEGEND = 0.2
#: Dots per inch of a PNG.
RESOLUTION = 150
#: Metadata without which files of two runs are the same.
WITHOUT_DATE: dict[str, dict[str, None]] = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}
#: Columns of figures in a picture at most.
MAX_COLUMNS = 2
#: What the points of data are, in a legend.
WHAT_IS_SHOWN = "mean and standard error"
#: The legend of data.
DATA = f"data ({WHAT_IS_SHOWN})"
#: How data are drawn.
POINTS: dict[str, Any] = {"fmt": "o", "ms": 4, "lw": 1}
#: Multiples of powers of ten that have ticks beside these: labels of all would overlap.
MINOR_TICKS = [2.0, 5.0]


class HasValue(Protocol):
    """A number of the theory, of which the figures need the value."""

    @property
    def value(self) -> float | None:
        """The value; None where no model fits."""


class Drawable(Protocol):
    """What the figures need of a `Comparison`, whose attributes these are."""

    @property
    def rows(self) -> pd.DataFrame:
        """The rows of all observables."""

    @property
    def medium(self) -> str:
        """The scatterers of the theory."""

    @property
    def groups(self) -> int:
        """The number of independent groups."""

    @property
    def covariance(self) -> tuple[tuple[float, ...], ...]:
        """The covariance of those that were fitted of e and ln l."""

    @property
    def parameters(self) -> Mapping[str, HasValue]:
        """The numbers of the theory by name."""

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""


def figure_names(comparison: Drawable) -> list[str]:
    """Return the names of the figures: of each observable, and of e and l if both were fitted."""
    rows = _rows_over_time(comparison)
    is_average = rows["low"].isna()
    drawn = {*rows[is_average | _has_place_on_logarithmic_axes(rows)]["observable"]}
    names = [name.replace("_", "-") for name in OBSERVABLES if name in drawn]
    are_two_fitted = np.shape(comparison.covariance) == (2, 2)
    are_two_fitted &= bool(np.all(np.isfinite(comparison.covariance)))
    if are_two_fitted and comparison.parameters["restitution"].value:
        names.append(CONFIDENCE)
    return names


def draw(comparison: Drawable, figure: str, ax: Axes) -> None:
    """Draw one figure on matplotlib's axes."""
    if figure == CONFIDENCE:
        _draw_confidence(comparison, ax)
    else:
        _draw_observable(comparison, figure.replace("-", "_"), ax)
    if ax.get_xscale() == "log":
        _thin_out_ticks(ax)


def system_of(comparison: Drawable) -> tuple[str, ...]:
    """Return what the title of a figure says of the theory: e, n and the scatterers."""
    arguments = {}
    for name in ("restitution", "number_density"):
        if name in comparison.parameters and comparison.parameters[name].value is not None:
            arguments[name] = comparison.parameters[name].value
    return system_items(arguments, comparison.medium, comparison.dimension)


def picture(comparison: Drawable, names: Sequence[str], kind: str = "svg") -> bytes:
    """Return figures in two columns as one picture, in a format of matplotlib's."""
    from matplotlib.figure import Figure

    n_columns = min(MAX_COLUMNS, len(names))
    n_rows = -(-len(names) // n_columns)
    size = (WIDTH_OF_FIGURE * n_columns, HEIGHT_OF_FIGURE * n_rows)
    figure = Figure(figsize=size, layout="constrained")
    figure.suptitle(", ".join(system_of(comparison)), fontsize="medium")
    for position, name in enumerate(names, start=1):
        draw(comparison, name, figure.add_subplot(n_rows, n_columns, position))
    buffer = io.BytesIO()
    metadata: Any = WITHOUT_DATE.get(kind)
    figure.savefig(buffer, format=kind, dpi=RESOLUTION, metadata=metadata)
    return buffer.getvalue()


def _rows_over_time(comparison: Drawable) -> pd.DataFrame:
    """Return the rows that have a place on a logarithmic axis of time."""
    rows = comparison.rows
    return rows[rows["time"] > 0]


def _has_place_on_logarithmic_axes(rows: pd.DataFrame) -> pd.Series:
    """Return which rows are bins with two ends and with samples."""
    return rows["high"].notna() & (rows["low"] > 0) & (rows["value"] > 0)


def _draw_observable(comparison: Drawable, name: str, ax: Axes) -> None:
    """Draw an average over time, or a density at its times."""
    rows = _rows_over_time(comparison)
    rows = rows[rows["observable"] == name]
    label = f"{SOURCE}, {comparison.medium}"
    if name == BETWEEN_FRAMES:
        _draw_between_frames(rows, label, ax)
    elif rows["low"].notna().any():
        _draw_density(name, rows[_has_place_on_logarithmic_axes(rows)], label, ax)
    else:
        _draw_average(name, rows, label, ax)
    ax.set_xscale("log")
    add_legend(ax)


def _draw_average(name: str, rows: pd.DataFrame, label: str, ax: Axes) -> None:
    """Draw an average over time."""
    colour = f"C{n_curves_of(ax, SOURCE)}"
    ax.plot(rows["time"], rows["theory"], color=colour, label=label)
    ax.errorbar(rows["time"], rows["value"], rows["error"], color="black", label=DATA, **POINTS)
    if name in POWERS_OF_TIME:
        ax.set_yscale("log")
    ax.set_xlabel(axis_label("t", "d/U"))
    ax.set_ylabel(_label_of(name))


def _draw_between_frames(rows: pd.DataFrame, label: str, ax: Axes) -> None:
    """Draw the mean square displacement over the time between frames, a colour for each first."""
    for index, (since, of_first_frame) in enumerate(rows.groupby("since")):
        ordered = of_first_frame.sort_values("time")
        elapsed = ordered["time"] - ordered["since"]
        color = f"C{index}"
        theory_label = label if index == 0 else None
        ax.plot(elapsed, ordered["theory"], color=color, label=theory_label)
        data_label = f"data, s = {since:.3g} d/U"  # with bars of one standard error
        values = ordered["value"]
        ax.errorbar(elapsed, values, ordered["error"], color=color, label=data_label, **POINTS)
    ax.set_yscale("log")
    ax.set_xlabel(axis_label("t - s", "d/U"))
    ax.set_ylabel(_label_of(BETWEEN_FRAMES))


def _draw_density(name: str, bins: pd.DataFrame, label: str, ax: Axes) -> None:
    """Draw a density in its bins, a colour for each time."""
    for index, (time, at_time) in enumerate(bins.groupby("time")):
        middle = np.sqrt(at_time["low"] * at_time["high"])
        color = f"C{index}"
        theory_label = label if index == 0 else None
        ax.plot(middle, at_time["theory"], color=color, label=theory_label)
        data_label = f"data, t = {time:.4g} d/U ({WHAT_IS_SHOWN})"
        values = at_time["value"]
        ax.errorbar(middle, values, at_time["error"], color=color, label=data_label, **POINTS)
    ax.set_yscale("log")
    symbol = "v" if name == SPEED_DENSITY else "r"
    ax.set_xlabel(axis_label(symbol, OBSERVABLES[name].unit))
    ax.set_ylabel(_label_of(name))


def _draw_confidence(comparison: Drawable, ax: Axes) -> None:
    """Draw the ellipses within which e and ln l are with a probability."""
    restitution = comparison.parameters["restitution"].value
    path = comparison.parameters["mean_free_path"].value
    assert restitution is not None
    assert path is not None
    angle = np.linspace(0.0, 2.0 * np.pi, POINTS_OF_ELLIPSE)
    circle = np.stack([np.cos(angle), np.sin(angle)])
    ellipse = np.linalg.cholesky(comparison.covariance) @ circle
    for share in (ONE_SIGMA_SHARE, LIMIT_SHARE):
        radius = limit_factor(comparison.groups, share, numbers=2)
        restitutions = restitution + radius * ellipse[0]
        paths = path * np.exp(radius * ellipse[1])
        ax.plot(restitutions, paths, label=f"{100 * share:.0f} %")
    ax.plot(restitution, path, "ko", ms=4, label=f"fitted, {comparison.medium}")
    ax.set_xlabel("restitution $e$")
    ax.set_ylabel(f"mean free path {axis_label('l', 'd')}")
    ax.margins(y=SPACE_FOR_LEGEND)
    add_legend(ax)


def _label_of(name: str) -> str:
    """Return the label of an ordinate, the one that a Solution has, where it has this quantity."""
    if name in OUTPUTS:
        unit, _, symbol = described(name, 2)
        return axis_label(symbol, unit)
    observable = OBSERVABLES[name]
    if not observable.unit:
        return observable.symbol
    return f"{observable.symbol} [${observable.unit.replace('²', '^2')}$]"


def _thin_out_ticks(ax: Axes) -> None:
    """Label only some of the ticks between powers of ten."""
    from matplotlib.ticker import LogLocator

    ax.xaxis.set_minor_locator(LogLocator(subs=MINOR_TICKS))
