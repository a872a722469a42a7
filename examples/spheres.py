"""The cooling rate h(e) of disks and of spheres: the closed form, and particles of both kinds.

python examples/spheres.py [--figure FILE]

In the scaling state 1/v0 grows as h t/(2 l), with the mean free path l = 1/(2 d rho0) among disks
and 1/(pi d^2 rho0) among spheres. Particles: random free paths (the Boltzmann-Grad limit), and
event by event among overlapping scatterers of low density, where l is the measured one.
"""

import sys

import numpy as np

from kinetics import ScalingSolution
from particles import BoltzmannGrad, Ensemble, Medium, Poisson, PoissonSpheres, simulate

RESTITUTIONS = (0.1, 0.3, 0.5, 0.7, 0.9)
DENSITY = {2: 1e-3, 3: 1e-3}  # in d^-2 and d^-3
SCATTERERS = 20_000
DIMENSIONS = {2: "disks", 3: "spheres"}


def media(dimension: int) -> dict[str, Medium]:
    """What particles are followed in, by name."""
    density = DENSITY[dimension]
    if dimension == 2:
        return {"random paths": BoltzmannGrad(density), "events": Poisson(density, SCATTERERS)}
    return {
        "random paths": BoltzmannGrad(density, dimension=3),
        "events": PoissonSpheres(density, count=SCATTERERS),
    }


def cooling_rate(run: Ensemble) -> tuple[float, float]:
    """h and its standard error, from the growth of 1/v0 between two times."""
    v0 = run.thermal_speed
    slope = np.diff(1 / v0.value)[0] / np.diff(run.times)[0]
    error = np.hypot(*(v0.error / v0.value**2)) / np.diff(run.times)[0]
    length = run.mean_free_path.value
    return float(2 * length * slope), float(2 * length * error)


def measure(medium: Medium, restitution: float) -> tuple[float, float]:
    """h and its standard error from 10 000 tracers, between 1e3 and 1e5 free times."""
    length = simulate(medium, restitution, max_collisions=20, media=5).mean_free_path.value
    times = np.array([1e3, 1e5]) * length
    return cooling_rate(simulate(medium, restitution, times=times, media=100, tracers=100, seed=3))


EXACT = {
    (dimension, e): ScalingSolution(e, dimension=dimension).cooling_rate
    for dimension in DIMENSIONS
    for e in RESTITUTIONS
}
PARTICLES = {
    (dimension, e, name): measure(medium, e)
    for dimension in DIMENSIONS
    for name, medium in media(dimension).items()
    for e in RESTITUTIONS
}


def draw(path: str) -> None:
    """h(e)/(1 - e) of disks and spheres: lines for the closed form, points for particles."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axis = plt.subplots(figsize=(5.4, 3.8), layout="constrained")
    fine = np.linspace(0, 0.98, 99)
    for k, (dimension, what) in enumerate(DIMENSIONS.items()):
        rates = [ScalingSolution(e, dimension=dimension).cooling_rate for e in fine]
        axis.plot(fine, rates / (1 - fine), color=f"C{k}", label=f"{what}, closed form")
        for name, marker, shift in (("random paths", "o", -0.006), ("events", "s", 0.006)):
            found = np.array([PARTICLES[dimension, e, name] for e in RESTITUTIONS])
            value, error = found.T / (1 - np.array(RESTITUTIONS))
            axis.errorbar(
                np.array(RESTITUTIONS) + shift, value, error, fmt=marker, ms=4, color=f"C{k}",
                mfc="white" if name == "events" else None, capsize=2, label=f"{what}, {name}",
            )  # fmt: skip
    axis.set(xlabel="restitution $e$", ylabel="$h/(1-e)$", ylim=(0, 1.6))
    axis.legend(fontsize="small", frameon=False, ncols=2)
    figure.savefig(path, dpi=150)
    plt.close(figure)


if __name__ == "__main__":
    print("                h(e)     random paths      events")
    for (dimension, e), exact in EXACT.items():
        points = [PARTICLES[dimension, e, name] for name in ("random paths", "events")]
        shown = "  ".join(f"{value:7.4f} +- {error:.4f}" for value, error in points)
        print(f"{DIMENSIONS[dimension]:8s} e = {e:3.1f}  {exact:7.4f}  {shown}")
    if len(sys.argv) == 3 and sys.argv[1] == "--figure":
        draw(sys.argv[2])
