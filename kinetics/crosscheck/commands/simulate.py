"""What `lorentz simulate` does. The command itself is with the others, in kinetics.cli."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from tqdm import tqdm

from kinetics.crosscheck.plain import dumps
from kinetics.crosscheck.text import columns

if TYPE_CHECKING:
    from particles import Ensemble, Medium

# Name in the result, and the head of its column.
_ESTIMATES = {
    "thermal_speed": "v0 [U]",
    "a2": "a2",
    "msd": "<r^2> [d^2]",
    "kurtosis": "kurtosis",
    "collisions": "collisions",
}
_ENDS = ("finished", "collision_cap", "trapped", "escaped")


def make_medium(
    kind: str, number_density: float, count: int, box: str, positions: Path | None,
    box_side: float | None,
) -> "Medium":  # fmt: skip
    """Return the medium that the options describe. Raises ValueError where they do not fit."""
    from particles import BoltzmannGrad, HardDisks, Poisson, Positions

    if (positions is None) != (box_side is None):
        raise ValueError("--positions and --box-side: give both or neither")
    if positions is not None and box_side is not None:
        return Positions.from_csv(positions, box_side)
    if kind == "boltzmann-grad":
        return BoltzmannGrad(number_density)
    medium = HardDisks if kind == "hard-disks" else Poisson
    return medium(number_density, count, box=None if box == "none" else "periodic")


def run_simulation(
    medium: str, number_density: float, count: int, box: str, positions: Path | None,
    box_side: float | None, initial: Any, times: tuple[float, ...], observables: str,
    as_json: bool, **arguments: Any,
) -> None:  # fmt: skip
    """Simulate and print the estimates; the options of the command by their names."""
    from particles import simulate

    scatterers = make_medium(medium, number_density, count, box, positions, box_side)
    names = [name.strip() for name in observables.split(",") if name.strip()]
    with tqdm(
        total=arguments["media"], desc="configurations", file=sys.stderr, disable=None, leave=False
    ) as bar:
        run = simulate(
            scatterers,
            initial=initial,
            times=times or None,
            observables=names or None,
            progress=lambda done, total: bar.update(done - bar.n),
            **arguments,
        )
    ends = {name: getattr(run.statuses, name) for name in _ENDS}
    if as_json:
        document = {
            "medium": "positions" if positions is not None else medium,
            "restitution": run.restitution,
            "number_density": run.number_density,
            "initial": initial,
            "media": run.media,
            "tracers": run.tracers,
            "max_collisions": arguments["max_collisions"],
            "seed": arguments["seed"],
            "statuses": ends,
            "times": run.times,
            "samples": run.samples,
            "missing": run.missing,
            "trapped": run.trapped,
            "mean_free_path": _value_and_error(run.mean_free_path),
            **{name: _value_and_error(getattr(run, name)) for name in _ESTIMATES},
        }
        click.echo(dumps(document), nl=False)
    else:
        click.echo(_table(run))
        click.echo("tracers: " + ", ".join(f"{n} {name}" for name, n in ends.items()))


def _table(run: "Ensemble") -> str:
    path = run.mean_free_path
    line = f"mean free path: {path.value:.6g} +- {path.error:.2g} d"
    if not run.times.size:
        return line
    heads, values = ["t [d/U]"], [run.times]
    for name, head in _ESTIMATES.items():
        estimate = getattr(run, name)
        heads += [head, "+-"]
        values += [estimate.value, estimate.error]
    return f"{columns(heads, values)}\n{line}"


def _value_and_error(estimate: Any) -> dict[str, Any]:
    return {"value": estimate.value, "error": estimate.error}
