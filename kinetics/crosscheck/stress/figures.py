"""The picture of a stability sweep."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from kinetics.crosscheck.bench.figures import svg
from kinetics.crosscheck.stress.case import StressCase

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MARKS = (("#0072b2", "o"), ("#d55e00", "^"), ("#009e73", "s"), ("#cc79a7", "v"), ("#e69f00", "D"),
          ("#222222", "x"), ("#56b4e9", "P"))  # fmt: skip


def reached_against_asked(cases: list[StressCase]) -> str:
    """A dot for each case that has a reference, in the colour of its group."""
    known = [c for c in cases if math.isfinite(c.reached) and math.isfinite(c.asked)]

    def draw(figure: Figure) -> None:
        axis = figure.add_subplot()
        for k, group in enumerate(dict.fromkeys(c.group for c in known)):
            colour, marker = _MARKS[k % len(_MARKS)]
            some = [c for c in known if c.group == group]
            axis.plot(
                [c.asked for c in some], [max(c.reached, 1e-17) for c in some],
                linestyle="none", marker=marker, color=colour, alpha=0.6, label=group,
            )  # fmt: skip
        ends = [1e-15, 1.0]
        axis.plot(ends, ends, color="#555555", linewidth=1.0)
        axis.set(
            xscale="log", yscale="log", xlabel="relative error asked",
            ylabel="relative error reached (0 drawn as 1e-17)",
            title="above the line: more than was asked",
        )  # fmt: skip
        figure.legend(loc="outside upper center", ncols=3)

    return svg(draw, 5.6, 5.2)
