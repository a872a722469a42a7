"""The command `solve`: prints what the kinetic equation gives for a scene."""

from __future__ import annotations

from typing import Any

import click

from kinetics.crosscheck.commands.options import (
    UNITS,
    Numbers,
    density_option,
    initial_option,
    json_option,
    names_in,
    print_json,
    restitution_option,
    tangential_option,
    times_option,
)  # fmt: skip
from kinetics.outputs import OUTPUTS

LAW = ("restitution", "tangential_restitution", "dimension")
HEADS = {row.name: row.head for row in OUTPUTS.values() if row.is_number}
"""Outputs that are one number for each time -> heads of their columns."""
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
@initial_option
@times_option
@click.option(
    "--scaled", is_flag=True, help="Solve the scaled equation: h, a2 and moments of F(c)."
)
@click.option(
    "--outputs",
    default="thermal_speed,a2,msd",
    help=f"Averages, separated by commas, of {', '.join(HEADS)}.",
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
    outputs: str,
    radii: tuple[float, ...],
    wave_numbers: tuple[float, ...],
    collision_numbers: tuple[float, ...],
    rtol: float | None,
    as_json: bool,
    **system: Any,
) -> None:
    """Solve the kinetic equation: averages over time or by collision number, G(R) and F(k, t)."""
    if rtol is None:  # G(R) cannot have 1e-10
        rtol = 1e-6 if radii and not scaled else 1e-10
    if scaled:
        law = {name: system[name] for name in LAW}
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

    names = [one_of("outputs", name, HEADS) for name in names_in(outputs)]
    if not names:
        refuse("outputs", outputs, f"name at least one of {', '.join(HEADS)}")
    not_negative("radii", radii)  # refused before minutes of work
    not_negative("wave_numbers", wave_numbers)
    wanted = names + ["position_density"] * bool(radii)
    wanted += ["intermediate_scattering"] * bool(wave_numbers)
    solution = solve_scene(Scene(**system, outputs=tuple(wanted)), rtol=rtol)
    found: dict[str, Any] = {
        **{name: system[name] for name in (*LAW, "number_density", "initial")},
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
    tables = [columns(heads, [found[name] for name in ("times", *names)])]
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
