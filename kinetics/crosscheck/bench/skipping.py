"""What skipping saves: each output of a scene alone, with the rest, and the rest without it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from kinetics.crosscheck.bench.record import SKIPPING, Record, failed, timed
from kinetics.crosscheck.bench.timing import Effort, measure_together

OUTPUTS = ("thermal_speed", "a2", "collisions", "msd", "kurtosis", "speed_density")
DIRECTED_OUTPUTS = (
    "thermal_speed", "mean_velocity", "velocity_tensor", "msd", "speed_density", "velocity_density",
)  # fmt: skip
MOMENTS = ("msd", "kurtosis", "diffusion_coefficient")
OBSERVABLES = (
    "speed_histogram", "velocity_component_histogram", "displacement_histogram",
    "free_path_histogram",
)  # fmt: skip

Works = dict[str, Callable[[], Any]]


def skipping(effort: Effort) -> list[Record]:
    """Rows with the ratio of the whole scene's time to the part's in `extra`."""
    from kinetics import Gaussian

    times = np.geomspace(1.0, 1e4, 20)
    groups = {
        "isotropic scene": _scene("gaussian", OUTPUTS, times),
        "two-temperature scene": _scene(Gaussian(2.0, 1.0), DIRECTED_OUTPUTS, times[::4]),
        "displacement, e = 0.6, t = 300": _position(),
        # the elastic scene solves nothing
        "elastic scene, v0, a2 and density": {
            f"e = {e:g}": _solve(e, times, ("thermal_speed", "a2", "speed_density"))
            for e in (0.99, 1.0)
        },
        # once the scaling state is reached, later times cost nothing
        "last time in d/U, v0 and a2": {
            f"t <= {last:.0e}": _solve(0.7, np.geomspace(1.0, last, 20), ("thermal_speed", "a2"))
            for last in (1e300, 1e20, 1e12, 1e4)
        },
        "Boltzmann-Grad run, 4000 tracers": _particles(times),
    }
    return ratios(groups, effort)


def ratios(groups: dict[str, Works], effort: Effort) -> list[Record]:
    """A row per piece of work; `extra["ratio"]` is the time of the group's first over its own."""
    works = {(group, name): work for group, some in groups.items() for name, work in some.items()}
    timings = measure_together(works, effort)
    rows = []
    for (group, name), timing in timings.items():
        whole = timings[group, next(iter(groups[group]))]
        if isinstance(timing, Exception) or isinstance(whole, Exception):
            met = timing if isinstance(timing, Exception) else whole
            rows.append(failed(SKIPPING, group, name, met))
            continue
        ratio = whole.cpu[1] / max(timing.cpu[1], 1e-9)
        rows.append(timed(SKIPPING, group, name, timing, extra={"ratio": ratio}))
    return rows


def _solve(e: float, times: Any, outputs: tuple[str, ...], rtol: float = 1e-8, **scene: Any) -> Any:
    """Work: to solve this scene."""
    from kinetics import Scene, solve

    made = Scene(e, times=times, outputs=outputs, **scene)
    return lambda: solve(made, rtol)


def _scene(start: Any, outputs: tuple[str, ...], times: np.ndarray) -> Works:
    def of(*names: str) -> Callable[[], Any]:
        return _solve(0.7, times, names, initial=start, harmonics=4)

    works = {"everything": of(*outputs)}
    works |= {f"{name} alone": of(name) for name in outputs}
    works |= {f"all but {name}": of(*(o for o in outputs if o != name)) for name in outputs}
    return works


def _position() -> Works:
    """The density solves wave numbers and harmonics; the moments do not."""

    def of(*names: str) -> Callable[[], Any]:
        return _solve(0.6, [300.0], names, 1e-4)

    density = "position_density"
    works = {"everything": of(*MOMENTS, density), f"all but {density}": of(*MOMENTS)}
    works |= {f"{name} alone": of(name) for name in (*MOMENTS, density)}
    return works


def _particles(times: np.ndarray) -> Works:
    """A simulation keeps only what is asked for."""
    from particles import BoltzmannGrad, simulate

    def of(*names: str) -> Callable[[], Any]:
        return lambda: simulate(
            BoltzmannGrad(0.04), 0.7, times=times, media=4, tracers=1000, workers=1,
            observables=names or None,
        )  # fmt: skip

    works = {"every histogram": of(*OBSERVABLES), "scalars alone": of()}
    works |= {f"{name} alone": of(name) for name in OBSERVABLES}
    return works
