"""What `lorentz solve --scaled` and `--field-steady` print: one state, with no time in it."""

from __future__ import annotations

from typing import Any

Found = tuple[Any, dict[str, Any]]
"""A result and its JSON document."""

_SCALED = ("cooling_rate", "a2", "error_estimate", "nodes")
_STEADY = (
    "drift", "mean_square_speed", "mean_square_along", "mean_speed", "diffusion_parallel",
    "diffusion_perpendicular", "error_estimate", "message",
)  # fmt: skip


def scaled_state(law: dict[str, Any], rtol: float) -> Found:
    """The scaling state: h, a2 and the moments <c> to <c^6>."""
    from kinetics import solve_scaled

    state = solve_scaled(**law, rtol=rtol)
    return state, _figures(law, state, _SCALED) | {
        "moments": {f"{p}": state.moment(p) for p in range(1, 7)}
    }


def steady_state(law: dict[str, Any], units: tuple[float, ...], rtol: float) -> Found:
    """The steady state in a field, in units of g and l, and in the user's own.

    units : acceleration, diameter and number density, in any consistent units; or nothing
    """
    from dataclasses import asdict

    from kinetics import solve_field

    state = solve_field(**law, rtol=rtol)
    found = _figures(law, state, _STEADY) | {"plan": [asdict(step) for step in state.plan]}
    return state, found | ({"in_units": asdict(state.in_units(*units))} if units else {})


def _figures(law: dict[str, Any], state: Any, names: tuple[str, ...]) -> dict[str, Any]:
    figures = {name: getattr(state, name) for name in names}
    return law | figures | {"status": state.status.name.lower()}


def state_text(found: dict[str, Any]) -> str:
    """The same, one line for each figure."""
    from kinetics.crosscheck.text_tables import figure, written

    lines = [
        f"{name:24} {figure(x)}" for name, x in found.items() if not isinstance(x, dict | list)
    ]
    if "plan" in found:
        lines.insert(0, "speeds in sqrt(g l), diffusion coefficients in sqrt(g l^3)")
    lines += [f"<c^{p}>{'':20}{figure(x)}" for p, x in found.get("moments", {}).items()]
    if "in_units" in found:
        lines.append("in the units of acceleration, diameter and number density:")
        lines += [f"{name:24} {written(x, 10)}" for name, x in found["in_units"].items()]
    return "\n".join(lines)
