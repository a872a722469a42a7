"""The command `solve`: prints what the kinetic equation gives for a scene, or for one state."""

import io
import math
import os
import textwrap
import warnings
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click import option

from kinetics.crosscheck.cli import options
from kinetics.errors import InputError, suggestion
from kinetics.outputs import ALIASES, DRIVEN_OUTPUTS, FIELD_OUTPUTS, OUTPUTS

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
    from pandas import DataFrame

    from kinetics import Solution

    FloatArray = NDArray[np.float64]

LAW = ("restitution", "tangential_restitution", "dimension", "mass_ratio")
MEDIUM = ("scatterers", "density_order", "number_density")
#: Averages that are printed -> their heads.
HEADS = {row.name: row.head for row in OUTPUTS.values() if row.shape == ("n_times",)}


@dataclass(frozen=True)
class Component:
    """A component of a vector or tensor that is printed: its output, its place, its head."""

    output: str
    axes: tuple[int, ...]
    head: str


COMPONENTS = (
    Component("mean_velocity", (0,), "<v_x> [U]"),
    Component("mean_displacement", (0,), "<x> [d]"),
    Component("velocity_tensor", (0, 0), "<v_x^2> [U^2]"),
    Component("velocity_tensor", (1, 1), "<v_y^2> [U^2]"),
    Component("displacement_tensor", (0, 0), "var(x) [d^2]"),
    Component("displacement_tensor", (1, 1), "var(y) [d^2]"),
)


@dataclass(frozen=True)
class DensityColumns:
    """A density that is asked for at points: its name in a Solution, the heads of its columns."""

    name: str
    head: str

    @property
    def output(self) -> str:
        """The output of a Scene that it needs."""
        return self.name.removeprefix("scaled_")


#: Names of points -> the density that is asked for at them.
DENSITIES = {
    "speeds": DensityColumns("speed_density", "f({} U)"),
    "scaled_radii": DensityColumns("scaled_position_density", "G({})"),
    "wave_numbers": DensityColumns("intermediate_scattering", "F({}/d)"),
}
_PRINTED = (*HEADS, *(component.output for component in COMPONENTS))
#: Averages that can be asked for with --field, and of driven tracers.
IN_FIELD = tuple(name for name in FIELD_OUTPUTS if name in _PRINTED)
DRIVEN = tuple(name for name in DRIVEN_OUTPUTS if name in _PRINTED)
#: Averages that are printed by collision number as well.
BY_COLLISION = ("thermal_speed", "a2", "msd")


@dataclass(frozen=True)
class StateMode:
    """An option that asks for a state without time.

    Parameters
    ----------
    solver : function of `kinetics`
    arguments : options that it takes beside those of all
    figures : of its state
    """

    solver: str
    arguments: tuple[str, ...]
    figures: tuple[str, ...]


MODES = {
    "scaled": StateMode("solve_scaled", (*LAW, *MEDIUM), ("cooling_rate", "a2", "nodes")),
    "field_steady": StateMode(
        "solve_field",
        (*LAW, "field_units"),
        (
            "drift",
            "mean_square_speed",
            "mean_square_along",
            "mean_speed",
            "diffusion_parallel",
            "diffusion_perpendicular",
        ),
    ),
    "steady": StateMode(
        "solve_steady",
        ("restitution", "viscoelastic", "dimension", "mass_ratio", *options.DRIVES, "field"),
        (
            "thermal_speed",
            "a2",
            "drift",
            "mean_square_along",
            "collision_rate",
            "diffusion_coefficient",
            "diffusion_parallel",
            "diffusion_perpendicular",
            "mobility",
            "capture_time",
            "capture_depth",
        ),
    ),
}
OPTIONS_OF_ALL = ("rtol", "output", "as_json")
#: Tolerances if --rtol is not given: of averages; of G(R) and in a field, where 1e-10 cannot be
#: had; of other driven tracers over time, which take long for it.
USUAL_RTOL = 1e-10
#: The same for scenes in a field.
ROUGH_RTOL = 1e-6
#: The same for other driven tracers over time.
DRIVEN_RTOL = 1e-8
EPILOG = f"""{options.UNITS} The example solves for the steady state of a tracer in a bath of
scatterers four times as heavy; without --steady it is solved over time."""
PICTURES = (".png", ".svg", ".pdf")
ENDINGS = (".csv", ".parquet", ".nc", ".h5", *PICTURES)
#: Resolution of PNG pictures.
DOTS_PER_INCH = 160
#: Bytes of a file of speeds at most: a larger one is another file.
MAX_TABLE_BYTES = 10_000_000
#: Powers of c of which --scaled prints moments.
SCALED_MOMENTS = range(1, 7)
#: Figures of a state that may be 0: what is below the error is nothing else.
MAY_VANISH = ("a2", "drift")
#: Digits of the figures of a state.
DIGITS_OF_STATE = 13

#: What --json prints.
Document = dict[str, Any]
#: Points by their names in `DENSITIES`.
Points = dict[str, tuple[float, ...]]

_points = partial(option, type=options.Numbers(), default="")


# fmt: off
@click.command(
    epilog=options.example("lorentz solve --steady -e 0.7 --bath-speed 1 --mass-ratio 4", EPILOG),
    short_help="Solve the kinetic equation.",
)
@options.restitution_option
@options.tangential_option
@options.mass_option
@options.dimension_option
@options.density_option
@option("--initial", default="gaussian", metavar="NAME|FILE.csv",
        help="Initial velocities: gaussian; monoenergetic (all speeds alike); beam (all along one "
        "direction); rest (only with --field); or a .csv file of two columns, the speed in U and "
        "its density in 1/U.")
@option("--speed", type=float, default=1.0, help="Speed of the start monoenergetic or beam, in U.")
@option("--direction", type=float, default=0.0,
        help="Angle of the start beam to the x axis, in radians.")
@option("--scatterers", type=options.Scatterers(["dilute", "hard disks", "overlapping disks"]),
        default="dilute",
        help="Medium. dilute is the paper's equation; the others include the finite density.")
@option("--density-order", type=options.Word(["leading", "first", "second"]), default="second",
        help="Order of the theory for a finite density n: n ln n, n, or a fitted (n ln n)^2.")
@options.times_option
@options.until_option
@option("--scaled", is_flag=True, help="Solve the scaled equation: h, a2 and moments of F(c).")
@option("--field", type=float, default=0.0,
        help="Uniform acceleration along x, in U^2/d; for averages, and for f(v) with --speeds.")
@option("--field-steady", is_flag=True,
        help="Solve the steady state in a uniform field g: drift and dispersion, in units of g and "
        "the mean free path l.")
@options.drive_options
@option("--steady", is_flag=True,
        help="Solve the steady state of a driven tracer. The unit of length is then the mean free "
        "path l, also in --heating, --drag and --field.")
@_points("--field-units", metavar="G,D,RHO",
         help="With --field-steady: print the results in your units too. Specify acceleration, "
         "diameter and density of scatterers, such as 9.81,0.001,1e8 in SI units.")
@option("--outputs", default="thermal_speed,a2,msd",
        help=f"Averages to print, separated by commas: {', '.join(HEADS)}. With --field: "
        f"{', '.join(IN_FIELD)}.")
@_points("--speeds", help="Speeds v in U at which to print f(v), separated by commas.")
@_points("--radii", help="Radii R at which to print G(R), separated by commas.")
@_points("--collision-numbers", help="Numbers N of collisions after which to print averages.")
@_points("--wave-numbers", help="Wave numbers k in 1/d at which to print F(k, t).")
@option("--rtol", type=float,
        help="Relative tolerance. [default: 1e-10; with --radii or a field 1e-6; for other driven "
        "tracers over time 1e-8]")
@option("-o", "--output", type=options.Output(*ENDINGS), metavar="FILE",
        help="Write the result to this file: .csv or .parquet (a row for each time), .nc (netCDF), "
        ".h5 (for kinetics.load), or a figure of all quantities: .png, .svg or .pdf.")
@options.json_option
def solve(
    outputs: str,
    rtol: float | None,
    output: Path | None,
    as_json: bool,
    until: float | None,
    viscoelastic: float | None,
    **system: Any,
) -> None:
    """Solve the kinetic equation: averages over time or by collision number, densities, F(k, t)."""
    # fmt: on
    field_units: tuple[float, ...] = system.pop("field_units")
    mode = _requested_mode(system)
    _check_field_units(field_units, mode)
    law = options.impact_law(viscoelastic, "kinetics", system["restitution"])
    system["restitution"] = law
    system["times"] = options.times_until(system["times"], until)
    if system["mass_ratio"] == math.inf:  # the default, which JSON cannot hold
        del system["mass_ratio"]
    points = {
        "speeds": system.pop("speeds"),
        "scaled_radii": system.pop("radii"),
        "wave_numbers": system.pop("wave_numbers"),
    }
    points = {name: values for name, values in points.items() if values}
    with options.progress(name="solving"):
        if mode:
            result, document = solve_state(mode, system, rtol or USUAL_RTOL)
        else:
            result, document = solve_over_time(system, outputs, points, rtol)
    if field_units:
        document["in_units"] = asdict(result.in_units(*field_units))
    if output is not None:
        write_result(result, output, points)
    if as_json:
        options.print_json(document)
    elif mode:
        click.echo(text_of_state(document))
    else:
        click.echo(text_over_time(document))


def _requested_mode(system: dict[str, Any]) -> str:
    """Take the options of `MODES` out of the arguments; return the first that was given, or "".

    Options that mean nothing beside it are refused.
    """
    requested = [name for name in MODES if system.pop(name)]
    if not requested:
        return ""
    mode = requested[0]
    all_options = {str(option.name) for option in click.get_current_context().command.params}
    if mode == "field_steady" and options.is_given("field"):
        raise click.UsageError(
            "--field: not with --field-steady, whose unit of acceleration is the field; "
            "--field-units gives the results in other units"
        )
    meaningless = all_options - {mode, *MODES[mode].arguments, *OPTIONS_OF_ALL}
    options.refuse_given(sorted(meaningless), f"--{mode.replace('_', '-')}")
    return mode


def _check_field_units(field_units: tuple[float, ...], mode: str) -> None:
    """Raise click.UsageError for units that are not three positive numbers, or of no field."""
    if not field_units:
        return
    if mode != "field_steady" or len(field_units) != 3 or min(field_units) <= 0:
        raise click.UsageError("--field-units takes three numbers above 0, with --field-steady")


# -- over time -------------------------------------------------------------------------------------
def solve_over_time(
    system: dict[str, Any], outputs: str, points: Points, rtol: float | None
) -> "tuple[Solution, Document]":
    """Return the Solution and the JSON document."""
    from kinetics import ModelWarning, Scene, ToleranceWarning
    from kinetics import solve as solve_scene

    drives = {name: system[name] for name in options.DRIVES if system[name]}
    is_driven = bool(drives) or not isinstance(system["restitution"], float)
    if rtol is None:
        rtol = USUAL_RTOL
        if "scaled_radii" in points or system["field"]:
            rtol = ROUGH_RTOL
        elif is_driven:
            rtol = DRIVEN_RTOL
    names = _names_of_averages(outputs, is_driven, bool(system["field"]))
    _check_points(points)
    initial = initial_state(system.pop("initial"), system.pop("speed"), system.pop("direction"))
    needed = (*names, *(DENSITIES[name].output for name in points))
    scene = Scene(**system, initial=initial, outputs=needed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ToleranceWarning)  # the status says it
        warnings.simplefilter("ignore", ModelWarning)  # the line of the model error says it
        solution = solve_scene(scene, rtol=rtol)
    document: Document = {name: system[name] for name in (*LAW, *MEDIUM) if name in system}
    document |= options.law_keys(system["restitution"])
    document |= drives
    document["initial"] = initial if isinstance(initial, str) else repr(scene.state)
    if system["field"]:
        document["field"] = system["field"]
    document["rtol"] = rtol
    document["status"] = solution.status.name.lower()
    document["message"] = solution.message
    if "capture_speed" in drives:
        names.append("captured")
    if system["field"] and "speeds" in points:
        names.append("uncollided")
    for name in ("times", *names):
        document[name] = getattr(solution, name)
    if scene.scatterers != "dilute":
        document["model_error"] = dict(solution.model_error)
    for name, values in points.items():
        density = DENSITIES[name].name
        document[name] = values
        document[density] = getattr(solution, density)(values)
    if system["collision_numbers"]:
        document["by_collision"] = _by_collision(solution, system["collision_numbers"])
    return solution, document


def _names_of_averages(outputs: str, is_driven: bool, has_field: bool) -> list[str]:
    """Return the names in --outputs; InputError for others, or for none."""
    from kinetics.validation import refuse

    known: Iterable[str] = HEADS
    if is_driven:
        known = DRIVEN
    elif has_field:
        known = IN_FIELD
    names = options.names_in(outputs)
    for name in names:
        if name not in known:
            near = suggestion(name, known, ALIASES)
            refuse("outputs", name, f"it must be one of {', '.join(known)}{near}")
    if not names:
        refuse("outputs", outputs, f"name at least one of {', '.join(known)}")
    return list(names)


def _check_points(points: Points) -> None:
    """Raise InputError for points that are negative, before minutes of work."""
    from kinetics.validation import not_negative

    for name, values in points.items():
        not_negative(name.removeprefix("scaled_"), values)


def _by_collision(solution: "Solution", numbers: Iterable[float]) -> Document:
    """Return averages by collision number."""
    document: Document = {"collision_numbers": [int(number) for number in numbers]}
    for name in BY_COLLISION:
        document[name] = getattr(solution.by_collision, name)
    return document


def text_over_time(document: Document) -> str:
    """Return the same as tables, one row for each time, and the status."""
    from kinetics.model_error import summary

    averages = {head: document[name] for name, head in HEADS.items() if name in document}
    for component in COMPONENTS:
        if component.output in document:
            averages[component.head] = document[component.output][:, *component.axes]
    if "captured" in document:
        averages["captured"] = document["captured"]
    tables = [averages]
    for points, density in DENSITIES.items():
        if density.name in document:
            heads = [density.head.format(options.written(float(x))) for x in document[points]]
            tables.append(dict(zip(heads, document[density.name].T, strict=True)))
    times = {"t [d/U]": document["times"]}
    lines = [options.columns(times | table) for table in tables]
    if "by_collision" in document:
        by_collision = document["by_collision"]
        table = {"N": by_collision["collision_numbers"]}
        for name in BY_COLLISION:
            table[HEADS[name]] = by_collision[name]
        lines.append(options.columns(table))
    lines += textwrap.wrap(f"status: {document['message']}", options.WIDTH)
    if "model_error" in document:
        text = f"error of the equation itself up to: {summary(document['model_error'])}"
        lines += textwrap.wrap(text, options.WIDTH)
    return "\n".join(lines)


# -- states without time ---------------------------------------------------------------------------
def solve_state(mode: str, system: dict[str, Any], rtol: float) -> tuple[Any, Document]:
    """Return a state without time and its JSON document; what tracers that stick lack is left out.

    mode : one of `MODES`
    """
    import kinetics

    absent = {name for name in (*options.DRIVES, "field") if not system[name]}
    if system["scatterers"] == "dilute":
        absent |= set(MEDIUM)
    arguments: dict[str, Any] = {}
    for name in MODES[mode].arguments:
        if name in system and name not in absent:
            arguments[name] = system[name]
    state = getattr(kinetics, MODES[mode].solver)(**arguments, rtol=rtol)
    document: Document = {**arguments, **options.law_keys(arguments["restitution"])}
    for name in (*MODES[mode].figures, "error_estimate"):
        value = getattr(state, name)
        if not isinstance(value, float) or math.isfinite(value):
            document[name] = value
    document["status"] = state.status.name.lower()
    if mode == "scaled":
        document["moments"] = {str(power): state.moment(power) for power in SCALED_MOMENTS}
        return state, document
    if mode == "steady":
        document["unit_of_length"] = "l"
    document["message"] = state.message
    document["plan"] = [asdict(step) for step in state.plan]
    return state, document


def text_of_state(document: Document) -> str:
    """Return the same, one line for each figure."""
    lines = []
    if "plan" in document and "unit_of_length" not in document:
        lines.append("speeds in sqrt(g l), diffusion coefficients in sqrt(g l^3)")
    for name, value in document.items():
        if name in MAY_VANISH and abs(value) < document["error_estimate"]:
            value = 0.0
        if not isinstance(value, dict | list):
            lines.append(_line_of(name, value))
    for power, moment in document.get("moments", {}).items():
        lines.append(_line_of(f"<c^{power}>", moment))
    if "in_units" in document:
        lines.append("in the units of acceleration, diameter and number density:")
        lines += [_line_of(name, value) for name, value in document["in_units"].items()]
    return "\n".join(lines)


def _line_of(name: str, value: object) -> str:
    """Return the line of one figure."""
    return f"{name:24} {options.written(value, DIGITS_OF_STATE)}"


# -- the initial state -----------------------------------------------------------------------------
def initial_state(text: str, speed: float, direction: float) -> Any:
    """Return what a Scene takes as `initial`: a word, a beam, or a .csv file of speeds."""
    from kinetics import Beam, Monoenergetic, SpeedTable

    meaningless = {"beam": (), "monoenergetic": ("direction",)}.get(text, ("speed", "direction"))
    options.refuse_given(meaningless, f"--initial {text}")
    if text == "beam":
        return Beam(direction, Monoenergetic(speed))
    if text == "monoenergetic" and speed != 1.0:
        return Monoenergetic(speed)
    if text.endswith(".csv"):
        speeds, densities = _two_columns(text)
        return SpeedTable(speeds, densities)
    return text


def _two_columns(path: str) -> "FloatArray":
    """Return two columns of numbers, below one line of names if there is one, (2, n)."""
    import numpy as np

    with suppress(OSError, ValueError, IndexError):  # a line of other columns, or no text
        if not os.path.isfile(path) or os.path.getsize(path) > MAX_TABLE_BYTES:
            raise ValueError(path)
        rows = np.atleast_2d(np.genfromtxt(path, delimiter=",", encoding="utf-8"))
        first = int(np.isnan(rows[0]).any())
        table = rows[first:]
        if table.shape[1] == 2 and len(table) > 1 and np.all(np.isfinite(table)):
            return np.asarray(table.T)
    allowed = "it must be a CSV file of two columns, a speed and its density, of two rows at least"
    allowed += f" and {MAX_TABLE_BYTES:g} bytes at most"
    raise InputError(f"initial: got {path!r}; {allowed}")


# -- files -----------------------------------------------------------------------------------------
def write_result(result: Any, path: Path, points: Points) -> None:
    """Write a result, whole or not at all, with its densities at the points."""
    from kinetics.crosscheck.files import write_together

    ending = path.suffix.lower()
    if ending == ".h5":
        result.save(path)
        return
    contents: str | bytes
    if ending == ".nc":
        contents = bytes(result.to_xarray(**points).to_netcdf(engine="scipy"))
    elif ending in PICTURES:
        contents = picture_of(result, ending.removeprefix("."))
    elif ending == ".csv":
        contents = rows_of(result, points).to_csv(index=False)
    else:
        contents = rows_of(result, points).to_parquet(index=False)
    write_together(path.parent, {path.name: contents})


def picture_of(result: Any, kind: str) -> bytes:
    """Return a picture of all of a result, at points of its own, which are many."""
    from matplotlib import pyplot

    result.plot_all()
    buffer = io.BytesIO()
    pyplot.savefig(buffer, format=kind, dpi=DOTS_PER_INCH)
    pyplot.close()
    return buffer.getvalue()


def rows_of(result: Any, points: Points) -> "DataFrame":
    """Return the data frame of a result, heads with units, a column for each point of a density."""
    frame: DataFrame = result.to_dataframe(**points)
    units = dict(frame.attrs["units"])
    for name in points:
        long = result.to_dataframe(DENSITIES[name].name, **points)
        _, point_name, *densities = long.columns  # two densities for what is complex
        for density in densities:
            for point, rows in long.groupby(point_name, sort=False):
                head = f"{density}({point_name}={point:g})"
                frame[head] = rows[density].values
                units[head] = long.attrs["units"][density]
    frame.attrs = {}  # which a Parquet file cannot hold
    heads = {name: name if unit == "1" else f"{name} [{unit}]" for name, unit in units.items()}
    return frame.rename(columns=heads)
