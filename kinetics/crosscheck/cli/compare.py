"""The commands `lorentz compare` and `lorentz fit`; what they need is imported when they run."""

from pathlib import Path
from typing import Any

import click
from click import Choice, option

from kinetics.crosscheck.cli import options
from kinetics.crosscheck.cli.options import Output, json_option

COLUMNS = """DATA is a table with columns time, x, y, vx, vy and, where known, tracer and medium
(the configuration of scatterers), one row for each tracer at each time: text (.csv, .tsv, .txt,
.csv.gz; separated by commas, semicolons, tabs or blanks), .npz, .mat, .h5, or .parquet (with the
package pyarrow); or a file of an Ensemble; or frames of H5MD (.h5md, .h5), a LAMMPS text dump
(.dump, .lammpstrj), extended XYZ (.xyz, .extxyz) or GSD (.gsd, with the package gsd). Usual other
names (t, frame, particle, TRACK_ID, POSITION_X, v_x, replica ...) are known. Rows in which a number
is missing are left out, and counted. Lengths are in d, speeds in U (standard deviation of one
component of the initial velocity), times in d/U, unless --length-unit, --speed-unit and --time-unit
say otherwise. Several files are several runs of the same system. Data are only read."""


# fmt: off
@click.command(
    epilog=options.example("lorentz compare data.csv -e 0.7 -o compared.html", COLUMNS),
    short_help="Compare anybody's particle data with the kinetic equation.",
)
@click.argument("data", nargs=-1, required=True, type=click.Path(path_type=Path))
@option("-e", "--restitution", type=float,
        help="Coefficient of restitution, 0 to 1. [default: an Ensemble's own, or fitted]")
@option("--tangential-restitution", type=float,
        help="Coefficient of tangential restitution, 0 to 1. [default: an Ensemble's own, or 1]")
@option("--number-density", type=float,
        help="Scatterers per area (volume), in the data's unit of length. [default: as of -e]")
@option("--dimension", type=click.IntRange(2, 3),
        help="3: motion among spheres in space, columns z and vz too. [default: an Ensemble's, 2]")
@option("--field", type=float, default=0.0,
        help="Uniform acceleration along +x in U^2/d: drift, speed and variances are compared.")
@options.mass_option
@options.drive_options
@option("--initial", type=Choice(["auto", "gaussian", "monoenergetic", "beam", "data", "rest"]),
        default="auto",
        help="Speeds at time 0: Gaussian, all U, all U along x, as in the data, or none; auto: the "
        "first of these that the data allow.")
@option("--scatterers", type=options.Scatterers(["auto", "dilute", "hard disks", "overlapping"]),
        default="auto",
        help="dilute: the kinetic equation; auto: as an Ensemble says, or the likeliest.")
@option("--positions", type=Choice(["auto", "displacement", "absolute"]), default="auto",
        help="Relative to the place at time 0, or not; auto: absolute if not 0 at time 0.")
@option("--speed-unit", type=float, default=1.0, help="U in the data's unit of speed.")
@option("--diameter", "--length-unit", "diameter", type=float, default=1.0, help="d in theirs.")
@option("--time-unit", type=float, help="d/U in theirs. [default: --length-unit over --speed-unit]")
@option("--timestep", type=float, help="Time of one step, where a file gives steps (dumps).")
@option("--frame-interval", type=float, help="Time between frames, where a file numbers these.")
@option("--fps", type=float, help="The same as frames in a unit of time.")
@option("--decimal", type=Choice([".", ","]), default=".", help="Decimal sign in text files.")
@option("--columns", default="", metavar="NAME=THEIRS,...",
        help="Names of columns in the files, as in time=t_sim,tracer=id.")
@option("--type", help="Particles of this type (species) alone, where a file has several.")
@option("-o", "--output", type=Output(".html", ".htm"), metavar="PAGE.html",
        help="Write the page here, and beside it a .json file with every number in it.")
@option("--figures", multiple=True, type=Choice(["pdf", "png", "svg"]),
        help="Write each figure as a file beside the page; may be repeated. Needs --output.")
@option("--fail-on", type=Choice(["differs", "unclear"]),
        help="End with exit status 1 where data and equation differ (or may: unclear).")
@json_option
def compare(viscoelastic: float | None, fail_on: str | None, **told: Any) -> int:
    """Compare particle data, from any code, with the kinetic equation.

    Restitution, density and start are found in the data where they are not given. Prints data with
    standard errors, theory, differences and verdicts over time; a chi-square with its p-value for
    each observable; and what explains a difference.
    """
    # fmt: on
    from kinetics.crosscheck.compare.ask import compare_data

    law = options.impact_law(viscoelastic, "kinetics", told["restitution"])
    result = _done(compare_data, **told | {"restitution": law})
    return int(fail_on is not None and result.verdict in {"differs", fail_on})


def _fit(**told: Any) -> None:
    """Find restitution and density of the scatterers in particle data, from any code.

    Prints both with their errors, the medium that was taken and why, and how well its theory fits;
    the page has their joint confidence region.
    """
    from kinetics.crosscheck.compare.ask import fit_data

    _done(fit_data, **told)


_TOLD = {"restitution", "number_density", "field", "fail_on", "viscoelastic", "mass_ratio"}
fit = click.Command(
    "fit", callback=_fit, help=_fit.__doc__, short_help="Find e and the density.",
    epilog=options.example("lorentz fit data.csv -o fitted.html", COLUMNS),
    params=[one for one in compare.params if one.name not in {*_TOLD, *options.DRIVES}],
)  # fmt: skip


def _done(
    work: Any, data: tuple[Path, ...], output: Path | None, figures: tuple[str, ...],
    as_json: bool, fps: float | None = None, **told: Any,
) -> Any:  # fmt: skip
    """Compare, write what is asked for, and print."""
    from kinetics.crosscheck.compare.result import drawn, render, tables
    from kinetics.crosscheck.files import require_file, write_together
    from kinetics.errors import InputError

    if fps is not None:
        if told["frame_interval"] is not None or not fps > 0.0:
            raise InputError(f"fps: got {fps}; it must be above 0, and without --frame-interval")
        told["frame_interval"] = 1.0 / fps
    if figures and output is None:
        raise InputError(f"figures: got {', '.join(figures)}; they need --output, the page")
    for path in () if output is None else (output, output.with_suffix(".json")):
        require_file("output", path)  # before anything is read
        if any(path.resolve() == other.resolve() for other in data):
            raise InputError(f"output: {str(path)!r} is one of the data; they are never changed")
    with options.progress(name="comparing"):
        result = work(list(data), **told)
    text = result.to_json() if as_json else tables(result) + "\n"
    if output is not None:
        numbers = output.with_suffix(".json").name
        contents = {numbers: result.to_json(), output.name: render(result, numbers)}
        for kind in figures:
            for name in result.figures:
                contents[f"{output.stem}-{name}.{kind}"] = drawn(result, [name], kind)
        written = write_together(output.parent, contents)
        text += "" if as_json else f"wrote {', '.join(map(str, written))}\n"
    click.echo(text, nl=False)
    return result
