"""The command `explore`."""

from __future__ import annotations

from pathlib import Path

import click

from kinetics.crosscheck.cli import options
from kinetics.errors import printable


@click.command(
    epilog=options.example("lorentz explore -o explorer.html"),
    short_help="Make a page to play with: one HTML file.",
)
@click.option(
    "-o",
    "--output",
    type=options.Output(".html"),
    default=Path("explorer.html"),
    help="The page; it needs no network, and nothing beside it.",
)
def explore(output: Path) -> None:
    """Make one HTML file with a tracer among disks and the exact curves over it.

    Sliders set restitution, density and a field, or a bath or noise drives the tracer; a table of
    data that is dropped on the page is drawn over the curves. The solver makes the tables of the
    curves, which takes some seconds.
    """
    from kinetics.crosscheck.explore import all_tables, render
    from kinetics.crosscheck.files import write_together

    with options.progress(4) as tell:
        text = render(all_tables(tell))
    write_together(output.parent, {output.name: text})
    size = len(text.encode()) / 1000
    click.echo(f"wrote {printable(output)} ({size:.0f} kB): open it in a browser")
