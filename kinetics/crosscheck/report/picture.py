"""The picture of the system in the head of the report: tracers among the disks, by their speed."""

import io
from typing import Any

from kinetics.crosscheck.report.figures import embeddable
from kinetics.crosscheck.report.layout import WIDTH
from kinetics.crosscheck.report.settings import ReportSettings
from kinetics.crosscheck.report.strokes import STYLE
from kinetics.crosscheck.report.templates import paragraphs

TRACERS = 3
COLLISIONS = 20
BOX = 2000
"""Disks in the box of the picture at most: it needs those that the tracers pass only."""


def picture(settings: ReportSettings) -> dict[str, str] | None:
    """Title, description and "svg" of a few tracers; None in space, where no disk can be drawn."""
    if settings.dimension != 2:
        return None
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    from particles import HardDisks, simulate

    # The restitution nearest to the middle: tracers stay near at 0, and fly far at 1.
    e = min(settings.restitutions, key=lambda each: abs(each - 0.7))
    until = settings.final_times[settings.restitutions.index(e)]
    run = simulate(
        HardDisks(settings.number_density, min(settings.count, BOX)), restitution=e, times=[until],
        media=2, tracers=TRACERS, seed=settings.seed, workers=1, observables=("finals",),
        tangential_restitution=settings.tangential_restitution,
    )  # fmt: skip
    title, description = paragraphs("headline.txt.j2", "picture", e=e, until=until, tracers=TRACERS)
    buffer = io.BytesIO()
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 0.85 * WIDTH), layout="constrained")
        FigureCanvasAgg(figure)
        run.plot_trajectories(TRACERS, collisions=COLLISIONS, ax=figure.add_subplot())
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    drawn: Any = embeddable(buffer.getvalue().decode(), "picture", title, description)
    return {"title": title, "description": description, "svg": drawn}
