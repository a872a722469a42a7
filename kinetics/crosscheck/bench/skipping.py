"""What skipping saves: each output of a scene alone, with the rest, and the rest without it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from kinetics.crosscheck.bench.record import Record, failed, timed
from kinetics.crosscheck.bench.timing import Effort, measure_together

SECTION = "skipping"
OUTPUTS = ("thermal_speed", "a2", "collisions", "msd", "kurtosis", "speed_density")
POSITION_OUTPUTS = ("msd", "kurtosis", "diffusion_coefficient", "position_density")
DIRECTED_OUTPUTS = (
    "thermal_speed", "mean_velocity", "velocity_tensor", "msd", "speed_density", "velocity_density",
)  # fmt: skip
OBSERVABLES = (
    "speed_histogram", "velocity_component_histogram", "displacement_histogram",
    "free_path_histogram",
)  # fmt: skip


def skipping(effort: Effort) -> list[Record]:
    """Rows with the ratio of the whole scene's time to the part's in `extra`."""
    from kinetics import Gaussian

    times = np.geomspace(1.0, 1e4, 20)
    wide = Gaussian(2.0, 1.0)
    groups = {
        "isotropic scene": _scene("gaussian", OUTPUTS, times),
        "two-temperature scene": _scene(wide, DIRECTED_OUTPUTS, times[::4]),
        "displacement, e = 0.6, t = 300": _position(),
        "elastic scene, v0, a2 and density": _elastic(times),
        "last time in d/U, v0 and a2": _horizon(),
        "Boltzmann-Grad run, 4000 tracers": _particles(),
    }
    return ratios(groups, effort)


Works = dict[str, Callable[[], Any]]


def ratios(groups: dict[str, Works], effort: Effort) -> list[Record]:
    """A row per piece of work; `extra["ratio"]` is the time of the group's first over its own."""
    works = {(group, name): work for group, some in groups.items() for name, work in some.items()}
    timings = measure_together(works, effort)
    rows = []
    for (group, name), timing in timings.items():
        whole = timings[group, next(iter(groups[group]))]
        if isinstance(timing, Exception) or isinstance(whole, Exception):
            met = timing if isinstance(timing, Exception) else whole
            rows.append(failed(SECTION, group, name, f"{type(met).__name__}: {met}"))
            continue
        ratio = whole.cpu.median / max(timing.cpu.median, 1e-9)
        rows.append(timed(SECTION, group, name, timing, extra={"ratio": ratio}))
    return rows


def _scene(start: Any, outputs: tuple[str, ...], times: np.ndarray) -> Works:
    from kinetics import Scene, solve

    def of(names: tuple[str, ...]) -> Callable[[], Any]:
        scene = Scene(0.7, initial=start, times=times, outputs=names, harmonics=4)
        return lambda: solve(scene, 1e-8)

    works = {"everything": of(outputs)}
    works |= {f"{name} alone": of((name,)) for name in outputs}
    works |= {
        f"all but {name}": of(tuple(other for other in outputs if other != name))
        for name in outputs
    }
    return works


def _position() -> Works:
    """The density solves wave numbers and harmonics; the moments do not."""
    from kinetics import Scene, solve

    def of(*names: str) -> Callable[[], Any]:
        scene = Scene(0.6, times=[300.0], outputs=names)
        return lambda: solve(scene, 1e-4)

    *moments, density = POSITION_OUTPUTS
    works = {"everything": of(*POSITION_OUTPUTS), f"all but {density}": of(*moments)}
    works |= {f"{name} alone": of(name) for name in POSITION_OUTPUTS}
    return works


def _elastic(times: np.ndarray) -> Works:
    """The elastic scene solves nothing."""
    from kinetics import Scene, solve

    def of(e: float) -> Callable[[], Any]:
        scene = Scene(e, times=times, outputs=("thermal_speed", "a2", "speed_density"))
        return lambda: solve(scene, 1e-8)

    return {"e = 0.99": of(0.99), "e = 1": of(1.0)}


def _horizon() -> Works:
    """Once the scaling state is reached, later times cost nothing."""
    from kinetics import Scene, solve

    def of(last: float) -> Callable[[], Any]:
        scene = Scene(0.7, times=np.geomspace(1.0, last, 20), outputs=("thermal_speed", "a2"))
        return lambda: solve(scene, 1e-8)

    return {f"t <= {last:.0e}": of(last) for last in (1e300, 1e20, 1e12, 1e4)}


def _particles() -> Works:
    """A simulation keeps only what is asked for."""
    from particles import BoltzmannGrad, simulate

    times = np.geomspace(1.0, 1e4, 20)

    def of(names: tuple[str, ...]) -> Callable[[], Any]:
        return lambda: simulate(
            BoltzmannGrad(0.04), 0.7, times=times, media=4, tracers=1000, workers=1,
            observables=names or None,
        )  # fmt: skip

    works = {"every histogram": of(OBSERVABLES), "scalars alone": of(())}
    works |= {f"{name} alone": of((name,)) for name in OBSERVABLES}
    return works
