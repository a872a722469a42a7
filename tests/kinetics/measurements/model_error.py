"""Measures the error of the equation itself at a finite density.

Tracers among hard and among overlapping disks are simulated on a grid of restitutions, densities
and times, and compared with the solver at the default order of the theory. A deviation is that of
the simulation from the theory, over the size that `kinetics.collision.measured_errors` names, over
n; kinetics/collision/measured_errors.json has it and its standard error for each point of the grid.

Starts are Gaussian, with stratified speeds and directions evenly spread in each medium. All tracers
of a medium start at one place, so that there are few of them in many media. Standard errors are
from a jackknife over batches of media.

    python -m tests.kinetics.measurements.model_error FILE [SCALE]

SCALE multiplies the numbers of tracers; with 1 (the stored file) it takes about an hour of a core.
A file that is there already is gone on with.
"""

from __future__ import annotations

import itertools
import json
import sys
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import j0

from kinetics import ModelWarning, Scene, Solution, ToleranceWarning, solve
from kinetics.numerics import FloatArray
from particles import HardDisks, Poisson, simulate

RESTITUTIONS = (0.1, 0.3, 0.5, 0.7, 0.9, 0.98, 1.0)
#: Densities n = rho d^2, and tracers of each restitution in each medium.
TRACERS = {
    0.1: 400_000,
    0.05: 400_000,
    0.02: 500_000,
    0.01: 1_000_000,
    0.3: 240_000,
    0.0025: 1_000_000,
}
#: In l/U, l = 1/(2 n) d.
TIMES = np.array([0.1, 0.2, 0.5, 1.0, 2.0, 4.0, 8.0, 15.0, 30.0, 60.0, 100.0, 250.0, 500.0, 1000.0])
#: Elastic tracers never slow down: they are followed up to this time in l/U, at low densities,
#: where late errors are far below what can be measured, and from `DENSE_FROM` on.
LAST_ELASTIC_TIMES = (100.0, 1000.0)
#: So many of the tracers are elastic ones from `DENSE_FROM` on: they take the longest.
SHARE_OF_ELASTIC = 0.5
#: The density from which media are small, and distributions are compared: their errors over n are
#: nearly the same below.
DENSE_FROM = 0.05
#: Tracers of one medium: the fewer, the denser it is, as they share what is around their start.
TRACERS_PER_MEDIUM = {0.0025: 100, 0.01: 100, 0.02: 50, 0.05: 40, 0.1: 40, 0.3: 40}
#: Below `DENSE_FROM` and from it on: fifty batches, so that the jackknife is certain to a tenth.
TRACERS_PER_BATCH = (20_000, 8_000)
#: Of one medium, below `DENSE_FROM` and from it on.
SCATTERERS = (4000, 2000)
#: Which of the times distributions are compared at, as they take longer.
DISTRIBUTIONS_AT = np.array([0, 2, 4, 6, 8, 11, 13])

AVERAGES = (
    "thermal_speed",
    "mean_speed",
    "a2",
    "collisions",
    "msd",
    "kurtosis",
    "velocity_autocorrelation",
    "diffusion_coefficient",
    "mean_displacement",
)
DISTRIBUTIONS = ("speed_density", "position_density", "intermediate_scattering")
OUTPUTS = (*AVERAGES, *DISTRIBUTIONS)

#: Speeds over v0(t) below which tracers are counted.
SPEEDS = np.geomspace(0.02, 2.5, 18)
#: Distances over sqrt(<r^2>) within which tracers are counted.
RADII = np.geomspace(0.05, 2.5, 14)
#: Wave numbers times sqrt(<r^2>).
WAVES = np.array([0.5, 1.0, 1.5, 2.0, 3.0, 5.0])


class Theory:
    """The theory of everything that is compared, each of the shape (n_times, ...)."""

    def __init__(self, medium: str, e: float, n: float, times: FloatArray) -> None:
        names = ("thermal_speed", "a2", "collisions", "msd", "kurtosis")
        names += ("velocity_autocorrelation",)
        scene = Scene(e, n, times=times, scatterers=medium, outputs=names)
        averages = solve(scene, rtol=1e-8)
        self.thermal_speed = averages.thermal_speed
        self.rms_distance = np.sqrt(averages.msd)
        self.averages = {name: np.asarray(getattr(averages, name)) for name in names}
        self.averages["mean_speed"] = averages.moment(1.0)
        self.averages["mean_displacement"] = _mean_displacement(scene)
        self.averages["diffusion_coefficient"] = _increments(averages.msd)
        self.sizes = {name: np.abs(values) for name, values in self.averages.items()}
        self.sizes["a2"] = 1.0 + self.averages["a2"]
        self.sizes["velocity_autocorrelation"] = np.sqrt(2.0) * self.thermal_speed
        self.sizes["mean_displacement"] = np.sqrt(2.0) * self.rms_distance
        self.chosen = np.empty(0, int)
        self.distributions: dict[str, FloatArray] = {}
        if n >= DENSE_FROM:
            self._add_distributions(scene)

    def _add_distributions(self, scene: Scene) -> None:
        times = np.asarray(scene.times)
        self.chosen = DISTRIBUTIONS_AT[times.size > DISTRIBUTIONS_AT]
        functions = replace(scene, times=times[self.chosen], outputs=DISTRIBUTIONS[:2])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ToleranceWarning)  # of G(R), where few have collided
            solution = solve(functions, rtol=1e-3)
        self.speeds = SPEEDS * self.thermal_speed[self.chosen, None]
        self.radii = RADII * self.rms_distance[self.chosen, None]
        self.waves = WAVES / self.rms_distance[self.chosen, None]
        self.distributions = {
            "speed_density": self._slower(solution, scene.restitution),
            "position_density": self._nearer(solution),
            "intermediate_scattering": self._waves(functions),
        }

    def _slower(self, solution: Solution, e: float) -> FloatArray:
        """Return the share of tracers slower than `SPEEDS` times v0(t)."""
        limits = self.speeds
        if e == 1.0:
            return -np.expm1(-0.5 * limits**2)
        speeds = np.geomspace(1e-3 * limits.min(), 2.0 * limits.max(), 6000)
        weighted = solution.speed_density(speeds) * speeds
        steps = np.diff(np.log(speeds))
        shares = np.cumsum(0.5 * (weighted[:, 1:] + weighted[:, :-1]) * steps, axis=1)
        pairs = zip(limits, shares, strict=True)
        return np.array([np.interp(limit, speeds[1:], share) for limit, share in pairs])

    def _nearer(self, solution: Solution) -> FloatArray:
        """Return the share of tracers nearer than `RADII` times sqrt(<r^2>)."""
        limits = self.radii
        edges, index = np.unique(limits, return_inverse=True)
        fractions = solution.position_fraction(np.append(0.0, edges))
        within = np.cumsum(fractions, axis=1)
        return np.take_along_axis(within, index.reshape(limits.shape), axis=1)

    def _waves(self, scene: Scene) -> FloatArray:
        """Return F at `WAVES` over sqrt(<r^2>), each time by itself: early k are large."""
        rows = []
        for time, waves in zip(scene.times, self.waves, strict=True):
            at_time = replace(scene, times=[time], outputs="intermediate_scattering")
            rows.append(solve(at_time, rtol=1e-6).intermediate_scattering(waves)[0].real)
        return np.array(rows)


def _mean_displacement(scene: Scene) -> FloatArray:
    """Return <r.v(0)>, the integral of <v(0).v(t)>."""
    last = scene.times[-1]
    times = np.unique(np.concatenate([[0.0], np.geomspace(1e-3 * scene.times[0], last, 1500)]))
    outputs = "velocity_autocorrelation"
    fine = Scene(
        scene.restitution,
        scene.number_density,
        times=times,
        scatterers=scene.scatterers,
        outputs=outputs,
    )
    correlation = solve(fine, rtol=1e-8).velocity_autocorrelation
    return np.asarray(CubicSpline(times, correlation).antiderivative()(scene.times))


def _increments(squares: FloatArray) -> FloatArray:
    """Return by how much <r^2> has grown since the time before, which D is over."""
    return np.diff(squares, prepend=0.0)


def start_velocities(rng: np.random.Generator, media: int, tracers: int) -> FloatArray:
    """Return Gaussian velocities in U, (media, tracers, 2), of stratified speeds."""
    count = media * tracers
    share = (rng.permutation(count) + rng.random(count)) / count
    speed = np.sqrt(-2.0 * np.log1p(-share)).reshape(media, tracers)
    angle = rng.random((media, 1)) + np.arange(tracers) / tracers
    phase = 2.0 * np.pi * angle
    return np.stack([speed * np.cos(phase), speed * np.sin(phase)], axis=-1)


def batch_means(
    medium: str, e: float, n: float, times: FloatArray, theory: Theory, seed: int
) -> dict[str, FloatArray]:
    """Return means over the tracers of one batch of media."""
    tracers = TRACERS_PER_MEDIUM[n]
    media = TRACERS_PER_BATCH[n >= DENSE_FROM] // tracers
    rng = np.random.default_rng(seed)
    start = start_velocities(rng, media, tracers)
    place = HardDisks if medium == "hard disks" else Poisson
    run = simulate(
        place(n, count=SCATTERERS[n >= DENSE_FROM]),
        restitution=e,
        initial=start,
        times=times,
        media=media,
        tracers=tracers,
        seed=seed,
        workers=1,
        observables=("positions", "velocities", "collisions"),
    )
    first = start.reshape(-1, 2)
    r = run.positions
    v = run.velocities
    r2 = np.sum(r * r, axis=-1)
    v2 = np.sum(v * v, axis=-1)
    speed = np.sqrt(v2)
    distance = np.sqrt(r2)
    means = {
        "v": speed.mean(axis=1),
        "v2": v2.mean(axis=1),
        "v4": (v2 * v2).mean(axis=1),
        "r2": r2.mean(axis=1),
        "r4": (r2 * r2).mean(axis=1),
        "vv0": np.sum(v * first, axis=-1).mean(axis=1),
        "rv0": np.sum(r * first, axis=-1).mean(axis=1),
        "collisions": run.collisions.value,
    }
    if theory.distributions:
        speeds = speed[theory.chosen]
        distances = distance[theory.chosen]
        means["speed_density"] = _shares_below(speeds, theory.speeds)
        means["position_density"] = _shares_below(distances, theory.radii)
        waves = [j0(theory.waves[:, k, None] * distances).mean(axis=1) for k in range(WAVES.size)]
        means["intermediate_scattering"] = np.stack(waves, axis=1)
    return means


def _shares_below(values: FloatArray, limits: FloatArray) -> FloatArray:
    """Return the share of values below limits, row by row."""
    rows = []
    for row, limit in zip(values, limits, strict=True):
        rows.append(np.searchsorted(np.sort(row), limit) / row.size)
    return np.array(rows)


def averages(means: dict[str, FloatArray]) -> dict[str, FloatArray]:
    """Return what is compared, of means over tracers."""
    return {
        "thermal_speed": np.sqrt(means["v2"]),
        "mean_speed": means["v"],
        "a2": means["v4"] / (2.0 * means["v2"] ** 2) - 1.0,
        "collisions": means["collisions"],
        "msd": means["r2"],
        "kurtosis": means["r4"] / means["r2"] ** 2,
        "velocity_autocorrelation": means["vv0"],
        "diffusion_coefficient": _increments(means["r2"]),
        "mean_displacement": means["rv0"],
        **{name: means[name] for name in DISTRIBUTIONS if name in means},
    }


def relative_deviations(means: dict[str, FloatArray], theory: Theory) -> dict[str, FloatArray]:
    """Return deviations from the theory over their sizes."""
    measured = averages(means)
    deviations = {}
    for name in AVERAGES:
        deviations[name] = (measured[name] - theory.averages[name]) / theory.sizes[name]
    for name in theory.distributions:
        deviations[name] = measured[name] - theory.distributions[name]
    return deviations


def measure(medium: str, e: float, n: float, tracers: int) -> dict[str, list[list[int]]]:
    """Return deviations of each output, and their standard errors, at `TIMES`, in n/1000."""
    paths = TIMES
    if e == 1.0:
        paths = TIMES[LAST_ELASTIC_TIMES[n >= DENSE_FROM] >= TIMES]
    times = paths / (2.0 * n)
    if e == 1.0 and n >= DENSE_FROM:
        tracers = int(SHARE_OF_ELASTIC * tracers)
    theory = Theory(medium, e, n, times)
    batches = []
    for batch in range(max(tracers // TRACERS_PER_BATCH[n >= DENSE_FROM], 2)):
        batches.append(batch_means(medium, e, n, times, theory, seed=1000 + batch))
    n_batches = len(batches)
    total = {name: np.mean([batch[name] for batch in batches], axis=0) for name in batches[0]}
    without = []
    for batch in batches:
        others = {name: (n_batches * total[name] - batch[name]) / (n_batches - 1) for name in total}
        without.append(relative_deviations(others, theory))
    deviations = relative_deviations(total, theory)
    row: dict[str, list[list[int]]] = {}
    for name, deviation in deviations.items():
        jackknife = np.array([others[name] for others in without])
        error = np.sqrt((n_batches - 1) * jackknife.var(axis=0))
        if deviation.ndim == 2:  # a distribution: the point where it is largest
            worst = np.abs(deviation).argmax(axis=1)[:, None]
            deviation = np.take_along_axis(deviation, worst, axis=1)[:, 0]
            error = np.take_along_axis(error, worst, axis=1)[:, 0]
        thousandths = np.round([1e3 * deviation / n, 1e3 * error / n]).astype(int)
        row[name] = thousandths.tolist()
    return row


def key(medium: str, n: float, e: float) -> str:
    """Return the name of a system in the file."""
    return f"{medium}, n = {n:g}, e = {e:g}"


def in_lines(document: dict[str, Any]) -> str:
    """Return the document as JSON, one line for each entry and each system."""
    entries = []
    for name, value in document.items():
        text = json.dumps(value, separators=(",", ":"))
        if name == "systems":
            rows = [
                f"{json.dumps(system)}:{json.dumps(row, separators=(',', ':'))}"
                for system, row in value.items()
            ]
            text = "{\n" + ",\n".join(rows) + "\n}"
        entries.append(f"{json.dumps(name)}:{text}")
    return "{\n" + ",\n".join(entries) + "\n}\n"


def main(path: Path, scale: float) -> None:
    """Measure all systems that the file does not have."""
    document: dict[str, Any] = {
        "about": "Deviations of simulations from the equation over their sizes, and their "
        "standard errors, in thousandths of n: python -m tests.kinetics.measurements.model_error",
        "times": TIMES.tolist(),
        "times_of_distributions": TIMES[DISTRIBUTIONS_AT].tolist(),
        "distributions": list(DISTRIBUTIONS),
        "restitution": list(RESTITUTIONS),
        "density": sorted(TRACERS),
        "systems": {},
    }
    if path.exists():
        document = json.loads(path.read_text("utf-8"))
    media = ("hard disks", "overlapping disks")
    for n, e, medium in itertools.product(TRACERS, RESTITUTIONS, media):
        name = key(medium, n, e)
        if name in document["systems"]:
            continue
        document["systems"][name] = measure(medium, e, n, int(scale * TRACERS[n]))
        path.write_text(in_lines(document), "utf-8")
        print(name, flush=True)


if __name__ == "__main__":
    warnings.simplefilter("ignore", ModelWarning)  # it is what is measured
    main(Path(sys.argv[1]), float(sys.argv[2]) if len(sys.argv) > 2 else 1.0)
