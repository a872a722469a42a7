"""Options that several commands have, and what all commands print alike."""

from __future__ import annotations

from typing import Any

import click

UNITS = (
    "Lengths are in d (diameter of a scatterer and of the tracer), speeds in U (standard deviation "
    "of one component of the initial velocity), times in d/U, densities in d^-2 (in space d^-3)."
)


class Numbers(click.ParamType):
    """Numbers separated by commas, "1,10,100": a tuple of floats, perhaps empty."""

    name = "numbers"

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[float, ...]:
        """The numbers, or click's complaint that names the option and the text."""
        if isinstance(value, tuple):
            return value
        try:
            return tuple(float(part) for part in value.split(",") if part.strip())
        except ValueError:
            self.fail(f"{value!r}: it must be numbers separated by commas", param, ctx)


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
    help="Output times in d/U, increasing, separated by commas.",
)
initial_option = click.option(
    "--initial",
    type=click.Choice(["gaussian", "monoenergetic"]),
    default="gaussian",
    help="Initial velocities: Gaussian, or all of speed U.",
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


def print_json(document: Any) -> None:
    """Print one strict JSON document on standard output."""
    from kinetics.crosscheck.strict_json import dumps

    click.echo(dumps(document), nl=False)
