"""What `compare` and `fit` print and write, and the options that say so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click import option

from kinetics.crosscheck.cli.options import Output, Word, json_option
from kinetics.crosscheck.cli.track_options import Command
from kinetics.errors import InputError, printable

if TYPE_CHECKING:
    from kinetics.crosscheck.compare.result import Comparison


def output_options(command: Command) -> Command:
    """Add the options of `ComparisonOutput` to a command."""
    command = json_option(command)
    command = option(
        "--rows",
        is_flag=True,
        help="Print all tests, all averages over time, and all explanations that were tried too.",
    )(command)
    command = option(
        "--figures",
        multiple=True,
        type=Word(["pdf", "png", "svg"]),
        help="Write each figure as a file beside the page; may be repeated. Needs --output.",
    )(command)
    return option(
        "-o",
        "--output",
        type=Output(".html", ".htm"),
        metavar="PAGE.html",
        help="Write the page here, and beside it a .json file with every number in it.",
    )(command)


@dataclass(frozen=True)
class ComparisonOutput:
    """Where a comparison goes.

    Parameters
    ----------
    page : file of the page; None for none
    figures : formats of figures that are written beside the page
    rows : whether all tests and rows are printed, beside the answer
    as_json : whether the JSON document is printed, in place of words
    """

    page: Path | None
    figures: tuple[str, ...]
    rows: bool
    as_json: bool

    def check(self, data: Sequence[Path]) -> None:
        """Raise InputError if a file could not be written, or is one of the data."""
        from kinetics.crosscheck.files import require_file

        if self.page is None:
            if self.figures:
                formats = ", ".join(self.figures)
                raise InputError(f"figures: got {formats}; they need --output, the page")
            return
        for path in (self.page, self.page.with_suffix(".json")):
            require_file("output", path)
            if any(path.resolve() == source.resolve() for source in data):
                raise InputError(
                    f"output: {str(path)!r} is one of the data; they are never changed"
                )

    def show(self, comparison: Comparison) -> None:
        """Write the files, and print."""
        written = [] if self.page is None else self._write(comparison, self.page)
        if self.as_json:
            click.echo(comparison.to_json(), nl=False)
            return
        click.echo(self._text(comparison))
        if written:
            click.echo(f"wrote {', '.join(printable(path) for path in written)}")

    def _text(self, comparison: Comparison) -> str:
        """Return what is printed."""
        from kinetics.crosscheck.compare.tables import tables
        from kinetics.crosscheck.compare.text import answer_text

        answer = answer_text(comparison)
        if self.rows:
            return f"{answer}\n\n{tables(comparison)}"
        return answer

    def _write(self, comparison: Comparison, page: Path) -> list[Path]:
        """Write the page, its numbers and figures, all or none; return their paths."""
        from kinetics.crosscheck.compare.figures import picture
        from kinetics.crosscheck.compare.page import render
        from kinetics.crosscheck.files import write_together

        numbers = page.with_suffix(".json").name
        contents: dict[str, str | bytes] = {numbers: comparison.to_json()}
        contents[page.name] = render(comparison, numbers)
        for kind in self.figures:
            for name in comparison.figures:
                contents[f"{page.stem}-{name}.{kind}"] = picture(comparison, [name], kind)
        return write_together(page.parent, contents)
