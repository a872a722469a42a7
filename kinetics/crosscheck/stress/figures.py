"""The picture of a stability sweep."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from kinetics.crosscheck.bench.figures import svg
from kinetics.crosscheck.stress.case import SAYS_SO, StressCase

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MARKS = (("#0072b2", "o"), ("#d55e00", "^"), ("#009e73", "s"), ("#cc79a7", "v"), ("#e69f00", "D"),
          ("#222222", "h"), ("#56b4e9", "P"))  # fmt: skip


def reached_against_asked(cases: list[StressCase]) -> str:
    """A mark for each case that has a reference, by group; hollow where the status says so."""
    known = [c for c in cases if math.isfinite(c.reached) and math.isfinite(c.asked)]

    def draw(figure: Figure) -> None:
        axis = figure.add_subplot()
        handles = []
        for k, group in enumerate(dict.fromkeys(c.group for c in known)):
            colour, marker = _MARKS[k % len(_MARKS)]
            style: dict[str, Any] = {"linestyle": "none", "marker": marker, "color": colour}
            for face, said in ((colour, False), ("none", True)):
                some = [c for c in known if c.group == group and (c.verdict == SAYS_SO) is said]
                axis.plot(
                    [c.asked for c in some],
                    [min(max(c.reached, 1e-17), 10.0) for c in some],
                    markerfacecolor=face,
                    alpha=0.7,
                    **style,
                )
            handles.append(Line2D([], [], label=group, **style))
        ends = [1e-15, 1.0]
        axis.plot(ends, ends, color="#555555", linewidth=1.0)
        axis.set(
            xscale="log",
            yscale="log",
            xlabel="relative error asked",
            ylabel="relative error reached, between 1e-17 and 10",
            title="above the line: more than was asked; hollow: and the status says so",
        )
        figure.legend(handles=handles, loc="outside upper center", ncols=2)

    from matplotlib.lines import Line2D

    return svg(draw, 6.4, 5.8)
