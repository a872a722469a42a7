"""The README's figure: one tracer among the disks, and the cooling rate by three methods.

python examples/overview.py [--figure FILE]
"""

import sys

import numpy as np

from kinetics import ScalingSolution, sonine
from particles import BoltzmannGrad, HardDisks, simulate

RESTITUTIONS = np.array([0.0, 0.2, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9])
NUMBER_DENSITY = 0.04  # d^-2
LATE = np.array([1e3, 1e5])  # d/U


def particle_rate(restitution: float) -> tuple[float, float]:
    """h and its standard error, from the growth of 1/v0 of tracers with random free paths."""
    medium = BoltzmannGrad(NUMBER_DENSITY)
    v0 = simulate(medium, restitution, times=LATE, media=50, tracers=200, seed=4).thermal_speed
    slope = np.diff(1 / v0.value)[0] / np.diff(LATE)[0] / NUMBER_DENSITY
    error = np.hypot(*(v0.error / v0.value**2)) / np.diff(LATE)[0] / NUMBER_DENSITY
    return float(slope), float(error)


RUN = simulate(HardDisks(NUMBER_DENSITY, 4000), 0.7, times=[500.0], media=1, tracers=1, seed=14)
EXACT = np.array([ScalingSolution(e).cooling_rate for e in RESTITUTIONS])
PARTICLES = np.array([particle_rate(e) for e in RESTITUTIONS])


def draw(path: str) -> None:
    """The path, coloured by the speed; h/(1 - e) over e."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.9), layout="constrained")
    RUN.plot_trajectories(tracers=1, ax=left)
    left.set(title="one tracer among the disks, e = 0.7")

    fine = np.linspace(0, 0.99, 100)
    rates = np.array([ScalingSolution(e).cooling_rate for e in fine])
    right.plot(fine, rates / (1 - fine), "C0", label="closed form and solver")
    value, error = PARTICLES.T / (1 - RESTITUTIONS)
    right.errorbar(RESTITUTIONS, value, error, fmt="o", color="C0", ms=4, label="particles")
    right.plot(fine, sonine.cooling_rate(fine) / (1 - fine), "C1--", label="the paper's expansion")
    right.axhline(1.45, color="C3", ls=":", label="the paper's simulation")
    right.set(
        xlabel="restitution e", ylabel="h / (1 - e)", ylim=(1.2, 1.8), title="cooling rate h(e)"
    )
    right.legend(frameon=False, loc="upper left")
    figure.get_layout_engine().set(wspace=0.07)
    figure.savefig(path, dpi=130)
    plt.close(figure)


if __name__ == "__main__":
    print("  e   exact     particles")
    for e, exact, (value, error) in zip(RESTITUTIONS, EXACT, PARTICLES, strict=True):
        print(f"{e:4.1f}  {exact:8.5f}  {value:8.5f} +- {error:.5f}")
    if len(sys.argv) == 3 and sys.argv[1] == "--figure":
        draw(sys.argv[2])
