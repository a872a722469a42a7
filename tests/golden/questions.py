"""The questions whose answers `numbers.json` keeps; as a script, this file makes them anew.

The numbers were made with the code of 22 November 2026 (commit 7baf535), before the package was
made half as big; they are the contract of that work. A number changes only by a decision that the
CHANGELOG names: chi-squares of the kurtosis are of 23, of a2 of 24 November 2026, as those of x^-3,
and so is <r^2> at a finite density, where returns take time.
Particles are followed for few collisions: among fixed scatterers a difference of one rounding grows
tenfold or more at each of them, and processors differ in roundings.
"""

from __future__ import annotations

import contextlib
import io
import json
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import particles as package
from kinetics import (
    Beam,
    CollisionLaw,
    ScalingSolution,
    Scene,
    SpeedTable,
    solve,
    solve_field,
    solve_scaled,
)
from kinetics.cli import main

NUMBERS = Path(__file__).with_name("numbers.json")
TIMES = [1.0, 30.0, 1e3, 1e6]
QUESTIONS: dict[str, tuple[float, Callable[[], Any]]] = {}
"""Name -> relative tolerance, and what answers with an array or a tuple of arrays."""


def question(
    rtol: float = 1e-9, **cases: dict[str, Any]
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    def add(function: Callable[..., Any]) -> Callable[..., Any]:
        for name, arguments in cases.items() or [("", {})]:
            key = " ".join([function.__name__, name]).strip().replace("_", " ")
            QUESTIONS[key] = rtol, lambda arguments=arguments: function(**arguments)
        return function

    return add


def averages(
    outputs: str = "thermal_speed a2 msd kurtosis", rtol: float = 1e-10, **scene: Any
) -> Any:
    found = solve(Scene(**{"times": TIMES, **scene}, outputs=tuple(outputs.split())), rtol=rtol)
    return [getattr(found, name) for name in outputs.split()]


@question(
    1e-11, disks={"restitution": 0.7}, inelastic={"restitution": 0.0},
    nearly_elastic={"restitution": 0.99}, spheres={"restitution": 0.4, "dimension": 3},
    rough={"restitution": 0.7, "tangential_restitution": 0.8},
)  # fmt: skip
def scaling_closed_form(**law: Any) -> Any:
    exact = ScalingSolution(**law)
    c = [0.3, 1.0, 2.5, 8.0]
    return exact.cooling_rate, exact.a2, exact.moment(3.5), exact.diffusion_slope, exact.vdf(c)


@question(
    3e-11, disks={"restitution": 0.7}, inelastic={"restitution": 0.0},
    spheres={"restitution": 0.4, "dimension": 3},
    rough={"restitution": 0.7, "tangential_restitution": 0.8},
)  # fmt: skip
def scaling_solver(**law: Any) -> Any:
    vdf = solve_scaled(**law)
    return vdf.cooling_rate, vdf.a2, vdf.moment(3.5), vdf.vdf([0.3, 1.0, 2.5, 8.0])


@question(
    1e-9, readme={"restitution": 0.7, "number_density": 0.04}, inelastic={"restitution": 0.0},
    elastic={"restitution": 1.0}, one_speed={"restitution": 0.4, "initial": "monoenergetic"},
    spheres={"restitution": 0.7, "dimension": 3},
    rough={"restitution": 0.7, "tangential_restitution": 0.5},
    dense={"restitution": 0.7, "number_density": 0.1},
)  # fmt: skip
def averages_over_time(**scene: Any) -> Any:
    return averages(**scene)


@question()
def averages_of_a_beam() -> Any:
    return averages(
        "mean_velocity velocity_autocorrelation msd", restitution=0.7, initial=Beam(direction=0.5)
    )


@question()
def averages_of_a_table_of_speeds() -> Any:
    v = np.linspace(0.0, 4.0, 41)
    f = v * np.exp(-(v**2))
    return averages(restitution=0.8, initial=SpeedTable(v, f / np.trapezoid(f, v)))


@question(1e-8)
def law_of_ones_own() -> Any:
    law = CollisionLaw.from_samples([0.5, 0.3, 0.2], [0.9, 0.5, 0.7], [-0.5, 0.1, 0.8], 2)
    exact = ScalingSolution(law)
    return exact.cooling_rate, exact.a2, averages(restitution=law)


@question(
    1e-9,
    hard_disks={"restitution": 0.7, "number_density": 0.04, "scatterers": "hard disks"},
    hard_disks_dense={"restitution": 0.9, "number_density": 0.1, "scatterers": "hard disks"},
    elastic_hard_disks={"restitution": 1.0, "number_density": 0.04, "scatterers": "hard disks"},
    overlapping={"restitution": 0.5, "number_density": 0.02, "scatterers": "overlapping"},
)
def finite_density(**scene: Any) -> Any:
    return averages("thermal_speed msd", **scene)


@question(
    1e-7, gaussian={"restitution": 0.7}, spheres={"restitution": 0.5, "dimension": 3},
    elastic={"restitution": 1.0},
)  # fmt: skip
def speed_density(**scene: Any) -> Any:
    solution = solve(Scene(**scene, times=[3.0, 300.0], outputs="speed_density"), rtol=1e-9)
    return solution.speed_density([0.01, 0.1, 0.5, 1.5])


@question(2e-7, late={"times": [300.0]}, early={"times": [20.0], "restitution": 0.9})
def position_density(restitution: float = 0.7, times: Any = ()) -> Any:
    scene = Scene(restitution, times=times, outputs=("position_density", "msd"))
    found = solve(scene, rtol=1e-8)
    return found.position_density([1.0, 20.0, 60.0]), found.scaled_position_density([0.5, 1.0, 2.0])


@question(1e-8, gaussian={"restitution": 0.7}, spheres={"restitution": 0.5, "dimension": 3})
def scattering_function(**scene: Any) -> Any:
    wanted = Scene(**scene, times=[3.0, 100.0], outputs="intermediate_scattering")
    return solve(wanted, rtol=1e-9).intermediate_scattering([0.01, 0.1, 0.5])


# The tables of section 3 of the theory, made by a spectral prototype that is not in this package.
FIELD = {
    "disks 0.5": (0.617488570787, 1.461042878482, 1.050469278790, 0.160476753702, 0.268043058233),
    "disks 0.7": (0.501926119920, 1.702146383757, 1.160252548014, 0.190614669672, 0.329659424454),
    "disks 0.9": (0.360142486812, 2.749139290890, 1.509687290815, 0.260928234751, 0.502760054023),
    "spheres 0.5": (0.739513156314, 2.117863778575, 1.320254784299, 0.207270834292, 0.332689794549),
    "spheres 0.9": (0.433647012969, 3.934205475335, 1.864407123796, 0.305814928981, 0.568114933278),
}


@question(3e-11, **{name: {"which": name} for name in FIELD})
def steady_state_in_a_field(which: str) -> Any:
    shape, e = which.split()
    state = solve_field(float(e), dimension=3 if shape == "spheres" else 2, rtol=1e-11)
    parts = ("drift", "mean_square_speed", "mean_speed", "diffusion_parallel")
    return [*(getattr(state, name) for name in parts), state.diffusion_perpendicular]


MEDIA: dict[str, dict[str, Any]] = {
    "BoltzmannGrad": {"number_density": 0.04},
    "BoltzmannGrad spheres": {"number_density": 0.04, "dimension": 3},
    "HardDisks": {"number_density": 0.04, "count": 400},
    "Poisson": {"number_density": 0.04, "count": 400},
    "HardSpheres": {"number_density": 0.04, "count": 400},
    "PoissonSpheres": {"number_density": 0.04, "count": 400},
}


@question(
    1e-6,
    **{name: {"medium": name} for name in MEDIA},
    HardDisks_in_a_field={"medium": "HardDisks", "field": 0.05},
    HardDisks_rough={"medium": "HardDisks", "tangential_restitution": 0.8},
)
def particles(medium: str, **arguments: Any) -> Any:
    made = getattr(package, medium.split()[0])(**MEDIA[medium])
    run = package.simulate(
        made, restitution=0.7, times=[0.5, 10.0, 25.0], media=2, tracers=20, seed=7, workers=1,
        observables=("positions", "velocities"), **arguments,
    )  # fmt: skip
    return run.positions[:, ::5], run.velocities[:, ::5]


def trajectories(dimension: int = 2, tracers: int = 150) -> tuple[Any, Any, Any]:
    """Times (4,), positions and velocities (4, tracers, d): a dilute gas, e = .7, l = 12.5."""
    u = iter(np.random.default_rng(3).uniform(size=200_000)).__next__
    times = np.array([0.0, 2.0, 20.0, 60.0])
    place, speed = np.zeros((2, 4, tracers, dimension))
    for n in range(tracers):
        v = np.array(
            [np.sqrt(-2 * np.log(u())) * np.cos(2 * np.pi * u()) for _ in range(dimension)]
        )
        r, t, k = np.array([25.0 * u() for _ in range(dimension)]), 0.0, 0
        while k < 4:
            end = t - 12.5 * np.log(u()) / np.linalg.norm(v)
            while k < 4 and times[k] <= end:
                place[k, n], speed[k, n] = r + (times[k] - t) * v, v
                k += 1
            r, t = r + (end - t) * v, end
            along = v / np.linalg.norm(v)
            while True:  # the impact is uniform over the cross-section
                across = np.array([2 * u() - 1 for _ in range(dimension)])
                across -= (across @ along) * along
                if across @ across < 1.0 and (dimension == 3 or u() < np.sqrt(1 - along[0] ** 2)):
                    break
            if dimension == 2:
                across = (2 * u() - 1) * np.array([-along[1], along[0]])
            normal = across - np.sqrt(1 - across @ across) * along
            v = v - 1.7 * (v @ normal) * normal
    return times, place, speed


def write_table(path: Path, times: Any, place: Any, speed: Any) -> None:
    found = {"t": np.repeat(times, place.shape[1])}
    found["id"] = np.tile(np.arange(place.shape[1]), times.size)
    for names, part in (("xyz", place), (("vx", "vy", "vz"), speed)):
        found |= dict(zip(names, part.reshape(-1, part.shape[2]).T, strict=False))
    pd.DataFrame(found).to_csv(path, index=False)


TOLD: dict[str, list[str]] = {
    "true": ["-e", "0.7", "--number-density", "0.04"],
    "false": ["-e", "0.85", "--number-density", "0.04"],
    "fitted": [],
}


def judged(file: Path, *told: str) -> Any:
    """What `lorentz compare --json` says of a file: the whole document."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        status = main(["compare", str(file), "--json", *told])
    assert status == 0
    return json.loads(out.getvalue())


def verdicts(document: Any) -> list[Any]:
    """The verdict, and of each test the observable, chi-square, degrees of freedom and p-value."""
    names = ("observable", "chi_square", "dof", "p_value", "verdict")
    return [
        document["verdict"],
        *([test.get(name) for name in names] for test in document["tests"]),
    ]


def flat(found: Any) -> list[float]:
    if isinstance(found, list | tuple):
        return [number for part in found for number in flat(part)]
    return np.asarray(found, dtype=float).ravel().tolist()


if __name__ == "__main__":
    made: dict[str, list[Any]] = {}
    for name, (_, answer) in QUESTIONS.items():
        print(name, flush=True)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            made[name] = flat(answer())
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "run.csv")
        write_table(file, *trajectories())
        for name, told in TOLD.items():
            made[f"compare {name}"] = verdicts(judged(file, *told))
        write_table(file, *trajectories(3))
        made["compare spheres"] = verdicts(judged(file, *TOLD["true"], "--dimension", "3"))
    lines = ",\n".join(f"{json.dumps(name)}: {json.dumps(values)}" for name, values in made.items())
    NUMBERS.write_text("{\n" + lines + "\n}\n", encoding="utf-8")
