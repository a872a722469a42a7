"""The command `compare`. What it needs is imported when it runs: --help stays quick."""

from __future__ import annotations

from pathlib import Path

import click

COLUMNS = (
    "DATA is .csv, .parquet, .npz or .h5 with columns time, x, y, vx, vy and, where known, tracer "
    "and medium (the configuration of scatterers), one row for each tracer at each time; or a file "
    "of an Ensemble; or frames of H5MD (.h5md, .h5), a LAMMPS text dump (.dump, .lammpstrj) or "
    "extended XYZ (.xyz, .extxyz). Usual other names (t, id, v_x, replica ...) are known; "
    "--columns says others. "
    "Lengths are in d, speeds in U (standard deviation of one component of the initial "
    "velocity), times in d/U, unless --length-unit, --speed-unit and --time-unit say otherwise. "
    "Several files are several runs of the same system. Data are only read."
)
FORMATS = ("pdf", "png", "svg")


@click.command(
    epilog=COLUMNS, short_help="Compare anybody's particle data with the kinetic equation."
)
@click.argument("data", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "-e", "--restitution", type=float, default=None,
    help="Coefficient of restitution, 0 to 1. [default: an Ensemble's own, or fitted]",
)  # fmt: skip
@click.option(
    "--tangential-restitution", type=float, default=None,
    help="Coefficient of tangential restitution, 0 to 1. [default: an Ensemble's own, or 1]",
)  # fmt: skip
@click.option(
    "--number-density", type=float, default=None,
    help="Scatterers per area, in the data's unit of length. [default: an Ensemble's own, or "
    "fitted]",
)  # fmt: skip
@click.option(
    "--initial", type=click.Choice(["auto", "gaussian", "monoenergetic", "data"]), default="auto",
    help="Speeds at time 0: Gaussian, all U, or as in the data; auto: the first of these that the "
    "data allow, Gaussian if they have no time 0.",
)  # fmt: skip
@click.option(
    "--positions", type=click.Choice(["auto", "displacement", "absolute"]), default="auto",
    help="x and y are relative to the tracer's place at time 0, or absolute; auto: absolute if "
    "they are not 0 at time 0. Absolute ones need the column tracer, and must not be wrapped.",
)  # fmt: skip
@click.option(
    "--speed-unit", default="1", metavar="NUMBER|data",
    help="U in the data's unit of speed; data: from the speeds at time 0.",
)  # fmt: skip
@click.option(
    "--diameter", "--length-unit", "diameter", type=float, default=1.0,
    help="Diameter d in the data's unit of length.",
)  # fmt: skip
@click.option(
    "--time-unit", type=float, default=None,
    help="d/U in the data's unit of time. [default: --length-unit over --speed-unit]",
)  # fmt: skip
@click.option(
    "--timestep", type=float, default=None,
    help="Time of one step, where a file gives steps and no times (dumps).",
)  # fmt: skip
@click.option(
    "--columns", default="", metavar="NAME=THEIRS,...",
    help="Names of columns in the files, as in time=t_sim,tracer=id.",
)  # fmt: skip
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), default=None, metavar="PAGE.html",
    help="Write the page here, and beside it a .json file with every number in it.",
)  # fmt: skip
@click.option(
    "--figures", multiple=True, type=click.Choice(FORMATS),
    help="Write each figure as a file beside the page; may be repeated. Needs --output.",
)  # fmt: skip
@click.option(
    "--fail-on", type=click.Choice(["differs", "unclear"]), default=None,
    help="End with exit status 1 where data and equation differ (unclear: also where a difference "
    "is possible).",
)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document and nothing else.")
def compare(
    data: tuple[Path, ...],
    restitution: float | None,
    tangential_restitution: float | None,
    number_density: float | None,
    initial: str,
    positions: str,
    speed_unit: str,
    diameter: float,
    time_unit: float | None,
    columns: str,
    timestep: float | None,
    output: Path | None,
    figures: tuple[str, ...],
    fail_on: str | None,
    as_json: bool,
) -> int:
    """Compare particle data, from any code, with the kinetic equation.

    Restitution, density and start are found in the data where they are not given. Prints, for each
    observable and time, the data with their standard error, the theory, the difference in standard
    errors and a verdict; a chi-square with its p-value for each observable; and what explains a
    difference.
    """
    from kinetics.errors import InputError

    if figures and output is None:
        raise InputError(f"figures: got {', '.join(figures)}; they need --output, the page")
    if output is not None:
        from kinetics.crosscheck.comparison.page import files_of, prepare
        from kinetics.crosscheck.files import write_together

        prepare(output, data)
    from kinetics.crosscheck.comparison.data.columns import parsed_columns
    from kinetics.crosscheck.comparison.data.read import read_sample
    from kinetics.crosscheck.comparison.question import (
        compare_sample,
        in_diameters,
        with_tangential,
    )
    from kinetics.validation import check_positive

    unit = _speed_unit(speed_unit)
    named = parsed_columns(columns)
    sample = read_sample(data, positions, unit, diameter, True, time_unit, named, timestep)
    if tangential_restitution is not None:
        sample = with_tangential(sample, tangential_restitution)
    if number_density is not None:
        number_density = in_diameters(check_positive("number_density", number_density), diameter)
    result = compare_sample(sample, restitution, number_density, initial)
    written = []
    if output is not None:
        written = write_together(output.parent, files_of(result, output, figures))
    if as_json:
        click.echo(result.to_json(), nl=False)
    else:
        from kinetics.crosscheck.comparison.page import tables

        click.echo(tables(result))
        if written:
            click.echo(f"wrote {', '.join(str(path) for path in written)}")
    return int(fail_on is not None and result.verdict in {"differs", fail_on})


def _speed_unit(text: str) -> float | str:
    if text == "data":
        return text
    try:
        return float(text)
    except ValueError:
        raise click.BadParameter(f"{text!r}: it must be a number, or data") from None


if __name__ == "__main__":
    compare()
