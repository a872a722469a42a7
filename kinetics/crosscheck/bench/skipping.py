"""What skipping saves: each output of a scene alone, with the rest, and the rest without it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from kinetics import Gaussian, Scene, solve
from kinetics.crosscheck.bench.measuring import Effort, Work, measure
from kinetics.crosscheck.bench.record import FAILED, SKIPPING, Record
from particles import BoltzmannGrad, simulate

ISOTROPIC = ("thermal_speed", "a2", "collisions", "msd", "kurtosis", "speed_density")
DIRECTED = (
    "thermal_speed", "mean_velocity", "velocity_tensor", "msd", "speed_density", "velocity_density",
)  # fmt: skip
MOMENTS = ("msd", "kurtosis", "diffusion_coefficient")
DENSITY = "position_density"
OBSERVABLES = (
    "speed_histogram", "velocity_component_histogram", "displacement_histogram",
    "free_path_histogram",
)  # fmt: skip

Parts = dict[str, Callable[[], Any]]


def skipping(effort: Effort) -> list[Record]:
    """Rows with the ratio of the whole scene's time to the part's in `extra`."""
    times = np.geomspace(1.0, 1e4, 20)
    cooling = ("thermal_speed", "a2")
    groups: dict[str, Parts] = {
        "isotropic scene": _outputs(ISOTROPIC, ISOTROPIC, times=times, harmonics=4),
        "two-temperature scene": _outputs(
            DIRECTED, DIRECTED, times=times[::4], initial=Gaussian(2.0, 1.0), harmonics=4
        ),
        # the density solves wave numbers and harmonics; the moments do not
        "displacement, e = 0.6, t = 300": _outputs(
            (*MOMENTS, DENSITY), (DENSITY,), restitution=0.6, times=[300.0], rtol=1e-4
        ),
        # the elastic scene solves nothing
        "elastic scene, v0, a2 and density": {
            f"e = {e:g}": _solve((*cooling, "speed_density"), restitution=e, times=times)
            for e in (0.99, 1.0)
        },
        # once the scaling state is reached, later times cost nothing
        "last time in d/U, v0 and a2": {
            f"t <= {last:.0e}": _solve(cooling, times=np.geomspace(1.0, last, 20))
            for last in (1e300, 1e20, 1e12, 1e4)
        },
        "Boltzmann-Grad run, 4000 tracers": _particles(times),
    }
    return ratios(groups, effort)


def ratios(groups: dict[str, Parts], effort: Effort) -> list[Record]:
    """A row per part; `extra["ratio"]` is the time of the group's first part over its own."""
    works = [
        Work(SKIPPING, group, name, call)
        for group, parts in groups.items()
        for name, call in parts.items()
    ]
    rows = measure(works, effort)
    whole = {row.problem: row for row in reversed(rows)}
    return [_compared(row, whole[row.problem]) for row in rows]


def _compared(row: Record, whole: Record) -> Record:
    if whole.seconds is None or row.seconds is None:
        return replace(row, status=FAILED, note=row.note or whole.note)
    return replace(row, extra={"ratio": whole.seconds / max(row.seconds, 1e-9)})


def _solve(outputs: Sequence[str], rtol: float = 1e-8, **scene: Any) -> Callable[[], Any]:
    """A function that solves this scene, at e = 0.7 where nothing else is said."""
    made = Scene(**{"restitution": 0.7, "outputs": tuple(outputs), **scene})
    return lambda: solve(made, rtol)


def _outputs(outputs: Sequence[str], left_out: Sequence[str], **scene: Any) -> Parts:
    """All outputs, each one alone, and all but one of those in `left_out`."""
    parts = {"everything": _solve(outputs, **scene)}
    parts |= {f"{name} alone": _solve([name], **scene) for name in outputs}
    for name in left_out:
        parts[f"all but {name}"] = _solve([o for o in outputs if o != name], **scene)
    return parts


def _particles(times: np.ndarray) -> Parts:
    """A simulation keeps only what is asked for."""

    def of(*names: str) -> Callable[[], Any]:
        return lambda: simulate(
            BoltzmannGrad(0.04), 0.7, times=times, media=4, tracers=1000, workers=1,
            observables=names or None,
        )  # fmt: skip

    parts = {"every histogram": of(*OBSERVABLES), "scalars alone": of()}
    return parts | {f"{name} alone": of(name) for name in OBSERVABLES}
