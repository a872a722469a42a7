"""Options of the commands that read tracks of particles: `compare` and `fit`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import click
from click import Choice, option

from kinetics.crosscheck.cli.options import Scatterers, Word
from kinetics.errors import InputError

Command = Callable[..., Any]

DATA_HELP = """DATA is a table with columns time, x, y and, if known, vx, vy, tracer and medium (the
number of the configuration of scatterers), one row for each tracer at each time. It may be text
(.csv, .tsv, .txt, .csv.gz; separated by commas, semicolons, tabs or blanks), .npz, .mat, .h5, or
.parquet (needs the package pyarrow). DATA may also be a run saved by `lorentz simulate`, or frames
in H5MD (.h5md, .h5), a LAMMPS text dump (.dump, .lammpstrj), extended XYZ (.xyz, .extxyz) or GSD
(.gsd, needs the package gsd); or a table of averages with columns such as t, v0, v0_error, msd,
msd_error. Common other names of columns (t, frame, particle, TRACK_ID, POSITION_X, v_x, replica
...) are recognised. Rows in which a number is missing are left out and counted. Several files are
several runs of the same system. Files of data are never changed. Lengths are in d (diameter of a
scatterer and of the tracer), speeds in U (standard deviation of one component of the initial
velocity), times in d/U, unless --length-unit, --speed-unit and --time-unit specify others."""
#: Words for the speeds at time 0, and the name that `kinetics.compare` has for each.
STARTS = {
    "auto": "auto",
    "gaussian": "gaussian",
    "one speed": "monoenergetic",
    "monoenergetic": "monoenergetic",
    "first frames": "data",
    "data": "data",
    "beam": "beam",
    "rest": "rest",
}


class Start(Choice):
    """A word for the speeds at time 0; a space in it may be a hyphen."""

    def __init__(self) -> None:
        super().__init__(list(STARTS))

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the name that `kinetics.compare` has for a word, or fail as click does."""
        word = super().convert(value.replace("-", " "), param, ctx)
        return STARTS[word]


def data_argument(command: Command) -> Command:
    """Add the files of data to a command."""
    path = click.Path(path_type=Path)
    return click.argument("data", nargs=-1, required=True, type=path)(command)


def system_options(command: Command) -> Command:
    """Add what is known of the system to a command: start, medium, dimension."""
    return _with_options(
        command,
        option(
            "--start",
            "--initial",
            "initial",
            type=Start(),
            default="auto",
            help="Velocities at time 0. gaussian; one speed (or monoenergetic): all have the speed "
            "U; beam: all have the velocity U along x; first frames (or data): the speeds of the "
            "data at time 0; rest: zero, for driven tracers. auto: the first of these that the "
            "data allow.",
        ),
        option(
            "--scatterers",
            type=Scatterers(["auto", "dilute", "hard disks", "overlapping disks"]),
            default="auto",
            help="Medium of the theory; dilute is the paper's equation. auto: from a saved run, "
            "else dilute or hard disks, whichever fits better.",
        ),
        option(
            "--dimension",
            type=click.IntRange(2, 3),
            help="2: disks in the plane; 3: spheres in space, with columns z and vz. "
            "[default: from a saved run, else 2]",
        ),
        option(
            "--tangential-restitution",
            type=float,
            help="Coefficient of tangential restitution, 0 to 1. "
            "[default: from a saved run, else 1]",
        ),
    )


def reading_options(command: Command) -> Command:
    """Add how files are to be read to a command."""
    return unit_options(file_options(command))


def unit_options(command: Command) -> Command:
    """Add the units and the accuracy of the data to a command."""
    return _with_options(
        command,
        option(
            "--length-unit",
            "--diameter",
            "diameter",
            type=float,
            default=1.0,
            help="The diameter d in the data's unit of length.",
        ),
        option(
            "--speed-unit",
            type=float,
            help="The speed U in the data's unit of speed. "
            "[default: 1; for positions alone, fitted]",
        ),
        option(
            "--time-unit",
            type=float,
            help="The time d/U in the data's unit of time. [default: --length-unit divided by "
            "--speed-unit]",
        ),
        option(
            "--localisation-error",
            type=float,
            help="Standard deviation of the error of each coordinate of a position, in the data's "
            "unit of length; 0: no error. [default: for positions alone, fitted]",
        ),
    )


def file_options(command: Command) -> Command:
    """Add what columns, frames and positions mean to a command."""
    return _with_options(
        command,
        option(
            "--positions",
            type=Word(["auto", "displacement", "absolute"]),
            default="auto",
            help="displacement: positions are relative to that at time 0. auto: displacement if "
            "they are 0 at time 0, else absolute.",
        ),
        option(
            "--timestep", type=float, help="Time of one step, for files that count steps (dumps)."
        ),
        option(
            "--frame-interval",
            type=float,
            help="Time between frames, for tables that number frames.",
        ),
        option("--fps", type=float, help="Frames per unit of time, instead of --frame-interval."),
        option(
            "--decimal",
            type=Word([".", ","]),
            default=".",
            help="Decimal sign in text files.",
        ),
        option(
            "--columns",
            default="",
            metavar="NAME=THEIRS,...",
            help="Names of columns in the files, such as time=t_sim,tracer=id.",
        ),
        option(
            "--type",
            help="Use only particles of this type (species), for files that have several.",
        ),
    )


def with_frame_interval(arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments of `kinetics.compare`: --fps becomes the time between frames.

    Raises
    ------
    InputError
        Both are specified, or the rate is not positive.
    """
    converted = dict(arguments)
    rate = converted.pop("fps")
    if rate is None:
        return converted
    if converted["frame_interval"] is not None or not rate > 0.0:
        raise InputError(f"fps: got {rate}; it must be above 0, and without --frame-interval")
    converted["frame_interval"] = 1.0 / rate
    return converted


def _with_options(command: Command, *decorators: Callable[[Command], Command]) -> Command:
    """Return a command with options, which its help shows in this order."""
    for decorate in reversed(decorators):
        command = decorate(command)
    return command
