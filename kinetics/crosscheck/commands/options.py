"""Options that several commands have, and what all commands print alike."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

MOST_NUMBERS = 100_000  # of one range

UNITS = (
    "Lengths are in d (diameter of a scatterer and of the tracer), speeds in U (standard deviation "
    "of one component of the initial velocity), times in d/U, densities in d^-2 (in space d^-3)."
)


class Numbers(click.ParamType):
    """Numbers and ranges of numbers, "0,1,10:1000:5": a tuple of floats, perhaps empty.

    A range A:B:N is N numbers from A to B, each larger than the one before by the same factor.
    """

    name = "numbers"

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[float, ...]:
        """The numbers, or click's complaint that names the option and the text."""
        if isinstance(value, tuple):
            return value
        if not value.strip():
            return ()
        try:
            return tuple(x for part in value.split(",") for x in _numbers(part))
        except ValueError:
            what = "it must be numbers separated by commas, or a range such as 1:1e6:50"
            self.fail(f"{value!r}: {what}, from 1 to 1e6 in 50", param, ctx)


class OutputPath(click.Path):
    """A path to write to. The empty text, as of a variable that is not set, is refused."""

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        """The path, or click's complaint that names the option."""
        if value == "":
            self.fail("'' is no path; it must name a file or a folder", param, ctx)
        return super().convert(value, param, ctx)


output_path = OutputPath(path_type=Path)


def _numbers(part: str) -> tuple[float, ...]:
    """One number, or those of a range."""
    if ":" not in part:
        return (float(part),)
    first, last, count = part.split(":")
    low, high, n = float(first), float(last), int(count)
    if not (0.0 < low < math.inf and 0.0 < high < math.inf and 2 <= n <= MOST_NUMBERS):
        raise ValueError(part)
    inner = (low * (high / low) ** (k / (n - 1)) for k in range(1, n - 1))
    return (low, *(float(f"{x:.14g}") for x in inner), high)


restitution_option = click.option(
    "-e", "--restitution", type=float, default=0.7, help="Coefficient of restitution, 0 to 1."
)
tangential_option = click.option(
    "--tangential-restitution",
    type=float,
    default=1.0,
    help="What a collision leaves of the tangential velocity, 0 to 1.",
)
density_option = click.option(
    "--number-density", type=float, default=0.04, help="Scatterers per d^2; in space per d^3."
)
times_option = click.option(
    "--times",
    type=Numbers(),
    default="1,3,10,30,100,300,1000",
    help="Output times in d/U, increasing, separated by commas; 1:1e6:50 is 50 of them from 1 to "
    "1e6, at equal ratios.",
)
until_option = click.option(
    "-t",
    "--until",
    type=float,
    help="Last time in d/U: in place of --times, 31 times up to it, 10 in a decade.",
)
seed_option = click.option("--seed", type=int, default=1, help="Seed of every random number.")
workers_option = click.option(
    "--workers", type=int, default=None, help="Threads. [default: one per processor]"
)
json_option = click.option(
    "--json", "as_json", is_flag=True, help="Print one JSON document and nothing else."
)


def names_in(text: str) -> tuple[str, ...]:
    """The names in a text that separates them by commas."""
    return tuple(part.strip() for part in text.split(",") if part.strip())


def given(names: Iterable[str]) -> list[str]:
    """Those of the parameters that stand on the command line, as their options are written."""
    context = click.get_current_context()
    return [
        parameter.opts[-1]
        for name in names
        for parameter in context.command.params
        if parameter.name == name
        and context.get_parameter_source(name) is not ParameterSource.DEFAULT
    ]


def refuse_given(names: Iterable[str], beside: str) -> None:
    """Raise click.UsageError if one of the parameters was given, which mean nothing `beside`."""
    for option in given(names):
        raise click.UsageError(f"{option}: not with {beside}")


def times_until(times: tuple[float, ...], until: float | None) -> tuple[float, ...]:
    """The times of --times, or of --until in its place. Raises ValueError for one not above 0."""
    if until is None:
        return times
    refuse_given(["times"], "--until, which stands in its place")
    if not 0.0 < until < math.inf:
        raise ValueError(f"until: got {until:g}; it must be a finite time above 0")
    return _numbers(f"{until / 1e3!r}:{until!r}:31")


def print_json(document: Any) -> None:
    """Print one strict JSON document on standard output."""
    from kinetics.crosscheck.strict_json import dumps

    click.echo(dumps(document), nl=False)
