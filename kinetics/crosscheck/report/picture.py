"""Pictures of the system in the head of a report: tracers among the disks, by their speed."""

import io
from typing import Any

from kinetics.crosscheck.report.figures import embeddable
from kinetics.crosscheck.report.layout import WIDTH
from kinetics.crosscheck.report.settings import ReportSettings
from kinetics.crosscheck.report.strokes import STYLE
from kinetics.crosscheck.report.templates import paragraphs
from particles import Ensemble, HardDisks, simulate

TRACERS = 3
COLLISIONS = 20
BOX = 2000
"""Disks in the box of a picture at most: it needs those that the tracers pass only."""
_IN_FIELD: dict[str, Any] = {"tracers": 4, "e": 0.5, "density": 0.06, "until": 150.0}


def picture(settings: ReportSettings) -> dict[str, str] | None:
    """Title, description and "svg" of a few tracers; None in space, where no disk can be drawn."""
    if settings.dimension != 2:
        return None
    # The restitution nearest to the middle: tracers stay near at 0, and fly far at 1.
    e = min(settings.restitutions, key=lambda each: abs(each - 0.7))
    until = settings.final_times[settings.restitutions.index(e)]
    run = simulate(
        HardDisks(settings.number_density, min(settings.count, BOX)), restitution=e, times=[until],
        media=2, tracers=TRACERS, seed=settings.seed, workers=1, observables=("finals",),
        tangential_restitution=settings.tangential_restitution,
    )  # fmt: skip
    words = paragraphs("headline.txt.j2", "picture", e=e, until=until, tracers=TRACERS)
    return _drawn(run, TRACERS, words, collisions=COLLISIONS)


def picture_in_field(seed: int) -> dict[str, str]:
    """The same of tracers that fall, in a field of U^2/l."""
    tracers, density = _IN_FIELD["tracers"], _IN_FIELD["density"]
    run = simulate(
        HardDisks(density, BOX), restitution=_IN_FIELD["e"], times=[_IN_FIELD["until"]],
        media=2, tracers=tracers, seed=seed, workers=1, field=2.0 * density,
    )  # fmt: skip
    words = paragraphs("field_figures.txt.j2", "trajectories", **_IN_FIELD)
    return _drawn(run, tracers, words)


def _drawn(run: Ensemble, tracers: int, words: list[str], **which: Any) -> dict[str, str]:
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    title, description = words
    buffer = io.BytesIO()
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 0.85 * WIDTH), layout="constrained")
        FigureCanvasAgg(figure)
        run.plot_trajectories(tracers, ax=figure.add_subplot(), **which)
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    drawn = embeddable(buffer.getvalue().decode(), "picture", title, description)
    return {"title": title, "description": description, "svg": drawn}
