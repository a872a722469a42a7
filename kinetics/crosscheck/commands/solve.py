"""The command `solve`: prints what the kinetic equation gives for a scene."""

from __future__ import annotations

from typing import Any

import click

from kinetics.crosscheck.commands.field import field_document, field_text
from kinetics.crosscheck.commands.options import (
    UNITS,
    Numbers,
    density_option,
    json_option,
    names_in,
    print_json,
    restitution_option,
    tangential_option,
    times_option,
)  # fmt: skip
from kinetics.outputs import FIELD_OUTPUTS, OUTPUTS

LAW = ("restitution", "tangential_restitution", "dimension")
MEDIUM = ("scatterers", "density_order", "number_density")
HEADS = {row.name: row.head for row in OUTPUTS.values() if row.is_number}
"""Outputs that are one number for each time -> heads of their columns."""
TENSORS = {
    "mean_velocity": (("<v_x> [U]", (0,)),),
    "mean_displacement": (("<x> [d]", (0,)),),
    "velocity_tensor": (("<v_x^2> [U^2]", (0, 0)), ("<v_y^2> [U^2]", (1, 1))),
    "displacement_tensor": (("var(x) [d^2]", (0, 0)), ("var(y) [d^2]", (1, 1))),
}
"""Outputs that are vectors or tensors, with --field -> heads of the parts that are printed."""
BY_COLLISION = ("thermal_speed", "a2", "msd")
"""Those that are printed by collision number as well."""


@click.command(epilog=UNITS, short_help="Solve the kinetic equation.")
@restitution_option
@tangential_option
@click.option(
    "--dimension",
    type=int,
    default=2,
    help="3: spheres; number densities are then in d^-3.",
)
@density_option
@click.option(
    "--initial",
    type=click.Choice(["gaussian", "monoenergetic", "rest"]),
    default="gaussian",
    help="Initial velocities: Gaussian, all of speed U, or with --field all at rest.",
)
@click.option(
    "--scatterers",
    type=click.Choice(["dilute", "overlapping", "hard disks"]),
    default="dilute",
    help="Dilute: the paper's equation; else with the correction for this density.",
)
@click.option(
    "--density-order",
    type=click.Choice(["leading", "first", "second"]),
    default="second",
    help="How far that correction goes: n ln n, n, or a fitted (n ln n)^2.",
)
@times_option
@click.option(
    "--scaled", is_flag=True, help="Solve the scaled equation: h, a2 and moments of F(c)."
)
@click.option(
    "--field",
    type=float,
    default=0.0,
    help="A uniform acceleration along x, in U^2/d: averages over time with it.",
)
@click.option(
    "--field-steady",
    is_flag=True,
    help="Solve the steady state in a uniform field: drift and dispersion, in units of g and l.",
)
@click.option(
    "--field-units",
    type=Numbers(),
    default="",
    metavar="G,D,RHO",
    help="With --field-steady, also in your units: the acceleration, the diameter and the density "
    "of the scatterers, separated by commas, such as 9.81,0.001,1e8 in SI units.",
)
@click.option(
    "--outputs",
    default="thermal_speed,a2,msd",
    help=f"Averages, separated by commas, of {', '.join(HEADS)}; with --field of "
    f"{', '.join(FIELD_OUTPUTS)}.",
)
@click.option("--radii", type=Numbers(), default="", help="R at which to print G(R), commas.")
@click.option(
    "--collision-numbers", type=Numbers(), default="", help="N at which to print averages, commas."
)
@click.option("--wave-numbers", type=Numbers(), default="", help="k in 1/d at which to print F.")
@click.option(
    "--rtol", type=float, help="Relative tolerance asked for; by default 1e-10, with --radii 1e-6."
)
@json_option
def solve(
    scaled: bool,
    field_steady: bool,
    field_units: tuple[float, ...],
    outputs: str,
    radii: tuple[float, ...],
    wave_numbers: tuple[float, ...],
    collision_numbers: tuple[float, ...],
    rtol: float | None,
    as_json: bool,
    **system: Any,
) -> None:
    """Solve the kinetic equation: averages over time or by collision number, G(R) and F(k, t)."""
    over_time = not scaled and not field_steady
    if rtol is None:  # G(R) cannot have 1e-10, and averages in a field take long for it
        rtol = 1e-6 if (radii or system["field"]) and over_time else 1e-10
    law = {name: system[name] for name in LAW}
    if field_units and (not field_steady or len(field_units) != 3):
        raise click.UsageError("--field-units takes three numbers, with --field-steady")
    if field_steady:
        if scaled:
            raise click.UsageError("give --scaled or --field-steady, not both")
        found, text = field_document(law, field_units, rtol), field_text
    elif scaled:
        if system["scatterers"] != "dilute":
            law |= {name: system[name] for name in MEDIUM}
        found, text = scaled_document(law, rtol), scaled_text
    else:
        system["collision_numbers"] = collision_numbers
        found, text = solve_document(system, outputs, radii, wave_numbers, rtol), solve_text
    if as_json:
        print_json(found)
    else:
        click.echo(text(found))


def scaled_document(law: dict[str, Any], rtol: float) -> dict[str, Any]:
    """The JSON document of the scaled equation: h, a2 and the moments <c> to <c^6>."""
    from kinetics import solve_scaled

    state = solve_scaled(**law, rtol=rtol)
    return {
        **law,
        "cooling_rate": state.cooling_rate,
        "a2": state.a2,
        "moments": {str(p): state.moment(p) for p in range(1, 7)},
        "error_estimate": state.error_estimate,
        "nodes": state.nodes,
        "status": state.status.name.lower(),
    }


def scaled_text(found: dict[str, Any]) -> str:
    """The same, one line for each figure."""
    lines = [f"{name:22} {value}" for name, value in found.items() if name != "moments"]
    lines += [f"<c^{p}>{'':18}{value}" for p, value in found["moments"].items()]
    return "\n".join(lines)


def solve_document(
    system: dict[str, Any],
    outputs: str,
    radii: tuple[float, ...],
    wave_numbers: tuple[float, ...],
    rtol: float,
) -> dict[str, Any]:
    """The JSON document: arguments of the scene, its arrays, G(R) and F(k) where asked for."""
    from kinetics import Scene
    from kinetics import solve as solve_scene
    from kinetics.validation import not_negative, one_of, refuse

    known = FIELD_OUTPUTS if system.get("field") else HEADS
    names = [one_of("outputs", name, known) for name in names_in(outputs)]
    if not names:
        refuse("outputs", outputs, f"name at least one of {', '.join(known)}")
    not_negative("radii", radii)  # refused before minutes of work
    not_negative("wave_numbers", wave_numbers)
    wanted = names + ["position_density"] * bool(radii)
    wanted += ["intermediate_scattering"] * bool(wave_numbers)
    solution = solve_scene(Scene(**system, outputs=tuple(wanted)), rtol=rtol)
    found: dict[str, Any] = {
        **{name: system[name] for name in (*LAW, *MEDIUM, "initial")},
        **({"field": system["field"]} if system.get("field") else {}),
        "rtol": rtol,
        "status": solution.status.name.lower(),
        "message": solution.message,
        "times": solution.times,
        **{name: getattr(solution, name) for name in names},
    }
    if radii:
        found["scaled_radii"] = radii
        found["scaled_position_density"] = solution.scaled_position_density(radii)
    if wave_numbers:
        found["wave_numbers"] = wave_numbers
        found["intermediate_scattering"] = solution.intermediate_scattering(wave_numbers)
    collision_numbers = system.get("collision_numbers", ())
    if collision_numbers:
        after = solution.by_collision
        found["by_collision"] = {
            "collision_numbers": [int(n) for n in collision_numbers],
            **{name: getattr(after, name) for name in BY_COLLISION},
        }
    return found


def solve_text(found: dict[str, Any]) -> str:
    """The same as tables, one row per time, and the status."""
    from kinetics.crosscheck.text_tables import columns

    names = [name for name in HEADS if name in found]
    heads = ["t [d/U]", *(HEADS[name] for name in names)]
    arrays = [found[name] for name in ("times", *names)]
    for name, parts in TENSORS.items():
        for head, place in parts if name in found else ():
            heads.append(head)
            arrays.append(found[name][(slice(None), *place)])
    tables = [columns(heads, arrays)]
    for head, at, name in (
        ("G({:g})", "scaled_radii", "scaled_position_density"),
        ("F({:g}/d)", "wave_numbers", "intermediate_scattering"),
    ):
        if name in found:
            heads = ["t [d/U]", *(head.format(x) for x in found[at])]
            tables.append(columns(heads, [found["times"], *found[name].T]))
    if "by_collision" in found:
        heads = ["N", *(HEADS[name] for name in BY_COLLISION)]
        tables.append(columns(heads, list(found["by_collision"].values())))
    return "\n".join([*tables, f"status: {found['message']}"])
