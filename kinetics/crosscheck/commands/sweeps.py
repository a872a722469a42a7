"""What `lorentz bench` and `lorentz stress` do alike: show progress, print, and write files."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol, TypeVar

import click

from kinetics.crosscheck.commands.options import output_path


class Report(Protocol):
    """The result of a benchmark or of a stability sweep."""

    def to_json(self) -> str:
        """One strict JSON document."""

    def markdown(self) -> str:
        """The tables that are printed."""

    def files(self) -> dict[str, str]:
        """Contents by name, of what is written."""


R = TypeVar("R", bound=Report)


def output_option(names: str) -> Any:
    """The option -o of a command that writes files of these names."""
    return click.option(
        "-o",
        "--output",
        type=output_path,
        default=None,
        help=f"Folder for {names}. [default: none is written]",
    )


@contextmanager
def progress(total: int | None = None) -> Iterator[Callable[..., None]]:
    """A function tell(name, total) for the beginning of each part of long work.

    It moves a bar on standard error, if that is a terminal.
    """
    from tqdm import tqdm

    with tqdm(total=total, file=sys.stderr, disable=None, leave=False) as bar:

        def tell(name: str, total: int | None = None) -> None:
            bar.total = total or bar.total
            bar.set_description(name, refresh=False)
            bar.update(1)

        yield tell


def run_and_write(run: Callable[[Callable[..., None]], R], output: Path | None, as_json: bool) -> R:
    """Run, print what the run gives, and write its files.

    run is called with the function tell(name, total) that it calls as each of its parts starts.
    Raises ValueError, before the run, for a folder that cannot be written.
    """
    from kinetics.crosscheck.files import require_writable_folder

    if output is not None:
        require_writable_folder(output)
    with progress() as tell:
        report = run(tell)
    show(report, output, as_json)
    return report


def show(report: Report, output: Path | None, as_json: bool) -> None:
    """Print what a run gave, and write its files."""
    from kinetics.crosscheck.files import write_together

    click.echo(report.to_json() if as_json else report.markdown(), nl=False)
    if output is not None:
        for path in write_together(output, report.files()):
            if not as_json:
                click.echo(f"wrote {path}")
