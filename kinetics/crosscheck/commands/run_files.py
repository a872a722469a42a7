"""Files of `lorentz simulate`: the picture of a run, and what to do with a run that was stopped."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from particles import Ensemble

PICTURES = (".png", ".svg", ".pdf")
_TRACERS, _DOTS_PER_INCH = 8, 160


def check_files() -> None:
    """Raise ValueError, before any work, for files of this command that cannot be made."""
    from kinetics.crosscheck.files import require_file

    options = click.get_current_context().params
    for name, endings in (("output", ()), ("picture", PICTURES)):
        if options[name] is not None:
            require_file(name, options[name], endings)


def write_picture(run: Ensemble, path: Path) -> None:
    """Draw the paths of the first tracers of the first configuration."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    from kinetics.crosscheck.files import write_together

    figure = Figure(figsize=(6.4, 6.0), layout="constrained")
    FigureCanvasAgg(figure)
    run.plot_trajectories(min(_TRACERS, run.tracers), ax=figure.subplots())
    file = io.BytesIO()
    figure.savefig(file, format=path.suffix[1:].lower(), dpi=_DOTS_PER_INCH, bbox_inches="tight")
    write_together(path.parent, {path.name: file.getvalue()})


@contextmanager
def saying_how_to_go_on() -> Iterator[None]:
    """After Ctrl-C or SIGTERM, say on standard error what is saved and how the run goes on."""
    try:
        yield
    except (KeyboardInterrupt, SystemExit):
        options = click.get_current_context().params
        output, media = options["output"], options["media"]
        done = None if output is None else _saved(output)
        if done is not None:
            click.echo(
                f"lorentz: {done} of {media} configurations are saved in {output}; the same "
                "command with --resume goes on",
                err=True,
            )
        raise


def _saved(path: Path) -> int | None:
    """How many configurations a file of a run holds, None where there is no such file."""
    import h5py

    try:
        with h5py.File(path, "r") as file:
            return int(file.attrs["done"])
    except (OSError, KeyError):
        return None
