"""The picture of a stability sweep: error reached against error asked."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from kinetics.crosscheck.bench.figures import svg
from kinetics.crosscheck.stress.case import CAREFUL, SAYS_SO, StressCase

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MARKS = (("#0072b2", "o"), ("#d55e00", "^"), ("#009e73", "s"), ("#cc79a7", "v"), ("#e69f00", "D"),
          ("#222222", "h"), ("#56b4e9", "P"))  # fmt: skip
_PANELS = {
    "averages": ("cooling", "starts", "random", "sizes", "moments of position"),
    "scaled equation": ("scaled equation", "scaled equation, nodes given"),
    "densities of the speed": ("spectral density", "late density", "conservative density"),
    "position": ("position density", "scattering function"),
    "particles": ("sizes of media", "thin media"),
}
_LEAST, _MOST = 1e-17, 10.0
_SPREAD = 0.12  # decades over which cases of the same tolerance are laid out


def reached_against_asked(cases: list[StressCase]) -> str:
    """A mark for each case that has a reference, a panel for each kind of answer.

    Hollow where the status does not claim the error asked for.
    """
    known = [c for c in cases if math.isfinite(c.reached) and math.isfinite(c.asked)]
    groups = dict.fromkeys(c.group for c in known)
    placed = {group for some in _PANELS.values() for group in some}
    panels = {**_PANELS, "others": tuple(g for g in groups if g not in placed)}
    panels = {name: tuple(g for g in some if g in groups) for name, some in panels.items()}
    panels = {name: some for name, some in panels.items() if some}
    columns = min(3, max(1, len(panels)))
    rows = max(1, math.ceil(len(panels) / columns))

    def draw(figure: Figure) -> None:
        axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
        for axis, (name, some) in zip(axes, panels.items(), strict=False):
            _panel(axis, name, {g: [c for c in known if c.group == g] for g in some})
        for axis, above in zip(axes[len(panels) :], axes[len(panels) - columns :], strict=False):
            axis.remove()
            above.tick_params(labelbottom=True)
        figure.supxlabel("relative error asked", fontsize="medium")
        figure.supylabel(f"relative error reached, from {_LEAST:g} to {_MOST:g}", fontsize="medium")
        figure.suptitle(
            "shaded: more error than was asked for; hollow: the status does not claim it",
            fontsize="medium",
        )

    return svg(draw, 3.4 * columns + 0.4, 3.6 * rows + 0.5)


def _panel(axis: Axes, title: str, groups: dict[str, list[StressCase]]) -> None:
    ends = [1e-15, _MOST]
    axis.fill_between(ends, ends, [_MOST * 3] * 2, color="#d55e00", alpha=0.08, linewidth=0)
    axis.plot(ends, ends, color="#555555", linewidth=1.0)
    for k, (group, cases) in enumerate(groups.items()):
        colour, marker = _MARKS[k % len(_MARKS)]
        style: dict[str, Any] = {"linestyle": "none", "marker": marker, "color": colour}
        shift = {c: _SPREAD * (2.0 * i / max(1, len(cases) - 1) - 1.0) for i, c in enumerate(cases)}
        for face, unclaimed in ((colour, False), ("none", True)):
            some = [c for c in cases if (c.verdict in (SAYS_SO, CAREFUL)) is unclaimed]
            axis.plot(
                [min(c.asked, _MOST) * 10.0 ** shift[c] for c in some],
                [min(max(c.reached, _LEAST), _MOST) for c in some],
                markerfacecolor=face,
                markersize=3.5,
                alpha=0.7,
                **style,
            )
        axis.plot([], [], label=f"{group} ({len(cases)})", markersize=4.5, **style)
    axis.set(xscale="log", yscale="log", title=title, ylim=(0.3 * _LEAST, 3.0 * _MOST))
    axis.set_xticks([1e-15, 1e-10, 1e-5, 1.0])
    axis.set_yticks([1e-15, 1e-10, 1e-5, 1.0])
    axis.legend(loc="upper left", fontsize="x-small", handletextpad=0.2, borderaxespad=0.2)
