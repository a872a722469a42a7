"""The command `solve`: prints what the kinetic equation gives for a scene, or for one state."""

import io
import math
import os
import textwrap
from contextlib import suppress
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import click
from click import Choice, option

from kinetics.crosscheck.cli import options
from kinetics.errors import InputError
from kinetics.outputs import DRIVEN_OUTPUTS, FIELD_OUTPUTS, OUTPUTS

LAW = ("restitution", "tangential_restitution", "dimension", "mass_ratio")
MEDIUM = ("scatterers", "density_order", "number_density")
# outputs that are one number for each time -> heads of their columns
HEADS = {row.name: row.head for row in OUTPUTS.values() if row.is_number}
# those that are vectors or tensors, with --field -> heads of the parts that are printed
TENSORS = {
    "mean_velocity": (("<v_x> [U]", (0,)),),
    "mean_displacement": (("<x> [d]", (0,)),),
    "velocity_tensor": (("<v_x^2> [U^2]", (0, 0)), ("<v_y^2> [U^2]", (1, 1))),
    "displacement_tensor": (("var(x) [d^2]", (0, 0)), ("var(y) [d^2]", (1, 1))),
}
# points -> the density that is asked for at them, and the heads of its columns
DENSITIES = {
    "speeds": ("speed_density", "f({} U)"),
    "scaled_radii": ("scaled_position_density", "G({})"),
    "wave_numbers": ("intermediate_scattering", "F({}/d)"),
}
# options that mean nothing where no scene is solved over time
OVER_TIME = (
    "times", "until", "initial", "speed", "direction", "field", "outputs", "speeds", "radii",
    "collision_numbers", "wave_numbers",
)  # fmt: skip
IN_FIELD = tuple(name for name in FIELD_OUTPUTS if name in (*HEADS, *TENSORS))  # with --field
DRIVEN = tuple(name for name in DRIVEN_OUTPUTS if name in (*HEADS, *TENSORS))
BY_COLLISION = ("thermal_speed", "a2", "msd")  # those that are printed by collision number as well
STATES = ("gaussian", "monoenergetic", "beam", "rest")
SCALED = ("cooling_rate", "a2", "nodes")
STEADY = (
    "drift", "mean_square_speed", "mean_square_along", "mean_speed", "diffusion_parallel",
    "diffusion_perpendicular",
)  # fmt: skip
IN_STEADY = (
    "thermal_speed", "a2", "drift", "mean_square_along", "collision_rate", "diffusion_coefficient",
    "diffusion_parallel", "diffusion_perpendicular", "mobility", "capture_time", "capture_depth",
)  # fmt: skip
MODES = {"--scaled": ("solve_scaled", SCALED), "--field-steady": ("solve_field", STEADY),
         "--steady": ("solve_steady", IN_STEADY)}  # fmt: skip
EPILOG = f"""{options.UNITS} The example is a tracer in a bath of scatterers four times as heavy;
without --steady the same over time."""
_LARGEST = 10_000_000  # bytes of a table of speeds
PICTURES = (".png", ".svg", ".pdf")
ENDINGS = (".csv", ".parquet", ".nc", ".h5", *PICTURES)

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
        help="Initial velocities: gaussian, monoenergetic, beam (all along one direction), with "
        "--field also rest; or a .csv file of two columns, the speed in U and its density in 1/U.")
@option("--speed", type=float, default=1.0, help="Of monoenergetic or beam, in U.")
@option("--direction", type=float, default=0.0,
        help="Of beam: its angle to the x axis, in radians.")
@option("--scatterers", type=options.Scatterers(["dilute", "hard disks", "overlapping"]),
        default="dilute",
        help="Dilute: the paper's equation; else with the correction for this density.")
@option("--density-order", type=Choice(["leading", "first", "second"]), default="second",
        help="How far that correction goes: n ln n, n, or a fitted (n ln n)^2.")
@options.times_option
@options.until_option
@option("--scaled", is_flag=True, help="Solve the scaled equation: h, a2 and moments of F(c).")
@option("--field", type=float, default=0.0,
        help="A uniform acceleration along x, in U^2/d: averages, and f(v) with --speeds, with it.")
@option("--field-steady", is_flag=True,
        help="Solve the steady state in a uniform field: drift and dispersion, in units of g and "
        "l.")
@options.drive_options
@option("--steady", is_flag=True,
        help="Solve the steady state of a driven tracer: lengths are in l, also those of "
        "--heating, --drag and --field, and speeds in the unit of these options.")
@_points("--field-units", metavar="G,D,RHO",
         help="With --field-steady, also in your units: the acceleration, the diameter and the "
         "density of the scatterers, separated by commas, such as 9.81,0.001,1e8 in SI units.")
@option("--outputs", default="thermal_speed,a2,msd",
        help=f"Averages, separated by commas, of {', '.join(HEADS)}; with --field of "
        f"{', '.join(IN_FIELD)}.")
@_points("--speeds", help="v in U at which to print f(v).")
@_points("--radii", help="R at which to print G(R), commas.")
@_points("--collision-numbers", help="N at which to print averages, commas.")
@_points("--wave-numbers", help="k in 1/d at which to print F.")
@option("--rtol", type=float,
        help="Relative tolerance asked for; by default 1e-10, with --radii or a field 1e-6, of "
        "other driven tracers over time 1e-8.")
@option("-o", "--output", type=options.Output(*ENDINGS), metavar="FILE",
        help="Write the result here: .csv or .parquet (a row for each time), .nc (netCDF), .h5 "
        "(for kinetics.load), or a picture of all of it, .png, .svg or .pdf.")
@option("--plot", is_flag=True, help="Show the same picture in a window.")
@options.json_option
def solve(
    scaled: bool, field_steady: bool, steady: bool, field_units: tuple[float, ...], outputs: str,
    speeds: tuple[float, ...], radii: tuple[float, ...], wave_numbers: tuple[float, ...],
    rtol: float | None, output: Path | None, plot: bool, as_json: bool, until: float | None,
    viscoelastic: float | None, **system: Any,
) -> None:
    """Solve the kinetic equation: averages over time or by collision number, densities, F(k, t)."""
    # fmt: on
    chosen = zip(MODES, (scaled, field_steady, steady), strict=True)
    mode = next((name for name, given in chosen if given), "")
    if mode:
        nothing = {*OVER_TIME, *options.DRIVES, "viscoelastic"}
        if steady:
            nothing = {*OVER_TIME, "tangential_restitution"} - {"field"}
        others = [name[2:].replace("-", "_") for name in MODES if name != mode]
        options.refuse_given((*sorted(nothing), *others, *(() if scaled else MEDIUM)), mode)
    told = system["restitution"]
    system["restitution"] = options.impact_law(viscoelastic, "kinetics", told)
    drives = {name: x for name in options.DRIVES if (x := system[name])}
    system["times"] = options.times_until(system["times"], until)
    asked: dict[str, Any] = {}
    plot &= output is None or output.suffix.lower() not in PICTURES
    if plot:
        from matplotlib import pyplot

        if pyplot.figure().canvas.required_interactive_framework is None:
            raise InputError("plot: there is no window to show it in; write it with -o FILE.png")
        pyplot.close()
    if rtol is None:  # G(R) cannot have 1e-10, and averages of driven tracers take long for it
        driven = drives or viscoelastic is not None
        rtol = 1e-6 if radii or system["field"] else 1e-8 if driven else 1e-10
        rtol = 1e-10 if mode else rtol
    if system["mass_ratio"] == math.inf:  # the default, which JSON cannot hold
        del system["mass_ratio"]
    law = {name: system[name] for name in LAW if name in system}
    if field_units and (not field_steady or len(field_units) != 3 or not min(field_units) > 0):
        raise click.UsageError("--field-units takes three numbers above 0, with --field-steady")
    if mode:
        if steady:
            del law["tangential_restitution"]
            law |= drives | ({"field": system["field"]} if system["field"] else {})
        elif system["scatterers"] != "dilute":
            law |= {name: system[name] for name in MEDIUM}
        with options.progress(name="solving"):
            result, found = solved_state(*MODES[mode], law, rtol)
        if field_units:
            found["in_units"] = asdict(result.in_units(*field_units))
    else:
        points = {"speeds": speeds, "scaled_radii": radii, "wave_numbers": wave_numbers}
        asked = {name: at for name, at in points.items() if at}
        with options.progress(name="solving"):
            result, found = over_time(system, outputs, asked, rtol)
    if output is not None:
        write_result(result, output, asked)
    if as_json:
        options.print_json(found)
    else:
        click.echo(state_text(found) if mode else text_over_time(found))
    if plot:
        result.plot_all()
        pyplot.show()


def over_time(
    system: dict[str, Any], outputs: str, asked: dict[str, Any], rtol: float
) -> tuple[Any, dict[str, Any]]:
    """The Solution and the JSON document; asked : points by the names in :data:`DENSITIES`."""
    import warnings

    from kinetics import Scene, ToleranceWarning
    from kinetics import solve as solve_scene
    from kinetics.validation import not_negative, one_of, refuse

    drives = {name: x for name in options.DRIVES if (x := system.get(name))}
    driven = bool(drives) or not isinstance(system["restitution"], float)
    known = DRIVEN if driven else IN_FIELD if system.get("field") else HEADS
    names = [one_of("outputs", name, known) for name in options.names_in(outputs)]
    if not names:
        refuse("outputs", outputs, f"name at least one of {', '.join(known)}")
    for name, at in asked.items():  # refused before minutes of work
        not_negative(name.removeprefix("scaled_"), at)
    densities = [DENSITIES[name][0] for name in asked]
    wanted = names + [name.removeprefix("scaled_") for name in densities]
    initial = initial_state(*(system.pop(name) for name in ("initial", "speed", "direction")))
    scene = Scene(**system, initial=initial, outputs=tuple(wanted))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ToleranceWarning)  # the status says it
        solution = solve_scene(scene, rtol=rtol)
    found: dict[str, Any] = {name: system[name] for name in (*LAW, *MEDIUM) if name in system}
    found |= options.law_keys(system["restitution"]) | drives
    found["initial"] = initial if isinstance(initial, str) else repr(scene.state)
    if system.get("field"):
        found["field"] = system["field"]
    found |= {"rtol": rtol, "status": solution.status.name.lower(), "message": solution.message}
    found |= {name: getattr(solution, name) for name in ("times", *names)}
    found |= {"captured": solution.captured} if "capture_speed" in drives else {}
    for (name, at), density in zip(asked.items(), densities, strict=True):
        found |= {name: at, density: getattr(solution, density)(at)}
    if system.get("field") and "speed_density" in found:
        found["uncollided"] = solution.uncollided
    if numbers := system.get("collision_numbers", ()):
        after = {name: getattr(solution.by_collision, name) for name in BY_COLLISION}
        found["by_collision"] = {"collision_numbers": [int(n) for n in numbers], **after}
    return solution, found


def text_over_time(found: dict[str, Any]) -> str:
    """The same as tables, one row per time, and the status."""
    shown = {HEADS[name]: found[name] for name in HEADS if name in found}
    for name, parts in TENSORS.items():
        shown |= {head: found[name][:, *place] for head, place in parts if name in found}
    shown |= {"captured": found["captured"]} if "captured" in found else {}
    tables = [shown]
    for at, (name, head) in DENSITIES.items():
        if name in found:
            heads = [head.format(options.written(float(x))) for x in found[at]]
            tables.append(dict(zip(heads, found[name].T, strict=True)))
    lines = [options.columns(["t [d/U]", *t], [found["times"], *t.values()]) for t in tables]
    if "by_collision" in found:
        heads = ["N", *(HEADS[name] for name in BY_COLLISION)]
        lines.append(options.columns(heads, found["by_collision"].values()))
    return "\n".join([*lines, *textwrap.wrap(f"status: {found['message']}", options.WIDTH)])


def solved_state(
    solver: str, names: tuple[str, ...], asked: dict[str, Any], rtol: float
) -> tuple[Any, dict[str, Any]]:
    """A state without time and its JSON document; what tracers that stick lack is left out.

    solver, asked : a function of kinetics, and its arguments
    """
    import kinetics

    state = getattr(kinetics, solver)(**asked, rtol=rtol)
    found = asked | options.law_keys(asked["restitution"])
    values = {name: getattr(state, name) for name in (*names, "error_estimate")}
    found |= {n: x for n, x in values.items() if not isinstance(x, float) or math.isfinite(x)}
    found["status"] = state.status.name.lower()
    if solver == "solve_scaled":
        return state, found | {"moments": {f"{p}": state.moment(p) for p in range(1, 7)}}
    found |= {"unit_of_length": "l"} if solver == "solve_steady" else {}
    return state, found | {"message": state.message, "plan": [asdict(x) for x in state.plan]}


def state_text(found: dict[str, Any]) -> str:
    """The same, one line for each figure."""

    def line(name: str, value: Any) -> str:
        return f"{name:24} {options.written(value, 13)}"

    lines = [line(name, x) for name, x in found.items() if not isinstance(x, dict | list)]
    if "plan" in found and "unit_of_length" not in found:
        lines.insert(0, "speeds in sqrt(g l), diffusion coefficients in sqrt(g l^3)")
    lines += [line(f"<c^{p}>", x) for p, x in found.get("moments", {}).items()]
    if "in_units" in found:
        lines.append("in the units of acceleration, diameter and number density:")
        lines += [line(name, x) for name, x in found["in_units"].items()]
    return "\n".join(lines)


def initial_state(text: str, speed: float, direction: float) -> Any:
    """What a Scene takes as `initial`: one of `STATES`, or a .csv file of speeds."""
    from kinetics import Beam, Monoenergetic, SpeedTable

    if text not in STATES and not text.endswith(".csv"):
        names = ", ".join(STATES)
        raise InputError(f"initial: got {text!r}; it must be {names}, or a .csv file of speeds")
    if text not in ("monoenergetic", "beam") and speed != 1.0:
        raise InputError(f"speed: got {speed:g}; it is of --initial monoenergetic and beam")
    if text != "beam" and direction != 0.0:
        raise InputError(f"direction: got {direction:g}; it is of --initial beam")
    if text == "beam":
        return Beam(direction, Monoenergetic(speed))
    if text == "monoenergetic" and speed != 1.0:
        return Monoenergetic(speed)
    return text if text in STATES else SpeedTable(*_two_columns(text))


def _two_columns(path: str) -> Any:
    """Two columns of numbers, below one line of names if there is one: (2, n)."""
    allowed = "it must be a CSV file of two columns, a speed and its density, of two rows at least"
    allowed += f" and {_LARGEST:g} bytes at most"
    import numpy as np

    with suppress(OSError, ValueError, IndexError):  # a line of other columns, or no text
        if not os.path.isfile(path) or os.path.getsize(path) > _LARGEST:
            raise ValueError
        rows = np.atleast_2d(np.genfromtxt(path, delimiter=",", encoding="utf-8"))
        table = rows[int(np.isnan(rows[0]).any()) :]
        if table.shape[1] == 2 and len(table) > 1 and np.all(np.isfinite(table)):
            return table.T
    raise InputError(f"initial: got {path!r}; {allowed}")


def write_result(result: Any, path: Path, points: dict[str, Any]) -> None:
    """Write a result, whole or not at all; points : where its densities are asked for."""
    from kinetics.crosscheck.files import write_together

    ending = path.suffix.lower()
    if ending == ".h5":
        result.save(path)
    elif ending == ".nc":
        contents = bytes(result.to_xarray(**points).to_netcdf(engine="scipy"))
        write_together(path.parent, {path.name: contents})
    elif ending in PICTURES:
        from matplotlib import pyplot

        result.plot_all()  # at points of its own, which are many
        pyplot.savefig(picture := io.BytesIO(), format=ending[1:], dpi=160)
        pyplot.close()
        write_together(path.parent, {path.name: picture.getvalue()})
    else:
        frame = rows_of(result, points)
        write = frame.to_csv if ending == ".csv" else frame.to_parquet
        write_together(path.parent, {path.name: write(index=False)})


def rows_of(result: Any, points: dict[str, Any]) -> Any:
    """The data frame of a result, its heads with units, a column for each point of a density."""
    frame = result.to_dataframe()
    units = dict(frame.attrs["units"])
    for name, one in (result.to_xarray(**points) if points else {}).items():
        unit = one.attrs["units"]
        if one.dims == ("time",) and name not in frame:  # it comes with a density
            frame[name], units[name] = one.values, unit
        elif name.startswith(tuple(DENSITIES[at][0] for at in points)) and len(one.dims) == 2:
            for x, column in zip(one[one.dims[1]].values, one.values.T, strict=True):
                head = f"{name}({one.dims[1]}={x:g})"
                frame[head], units[head] = column, unit
    heads = {n: n if units.get(n, "1") == "1" else f"{n} [{units[n]}]" for n in frame}
    frame.attrs = {}  # which a Parquet file cannot hold
    return frame.rename(columns=heads)
