"""The README's figure: one tracer among the disks, and the cooling rate by three methods.

python examples/overview.py [--figure FILE]
"""

import sys

import numpy as np

from kinetics import ScalingSolution, sonine
from particles import BoltzmannGrad, Positions, simulate

RESTITUTIONS = np.array([0.0, 0.2, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9])
NUMBER_DENSITY = 0.04  # d^-2
LATE = np.array([1e3, 1e5])  # d/U
BOX = 60.0  # d
PATH_TIMES = np.geomspace(1e-2, 500, 6000)  # d/U, so close that the corners are sharp


def disks(generator: np.random.Generator) -> np.ndarray:
    """Centres of disks in a box, shape (count, 2), that neither overlap nor cover its middle."""
    centres = np.full((1, 2), BOX / 2)  # the tracer's place
    while len(centres) <= NUMBER_DENSITY * BOX**2:
        one = generator.uniform(0, BOX, 2)
        apart = np.abs(centres - one)
        if np.hypot(*np.minimum(apart, BOX - apart).T).min() > 1.05:
            centres = np.vstack([centres, one])
    return centres[1:]


def particle_rate(restitution: float) -> tuple[float, float]:
    """h and its standard error, from the growth of 1/v0 of tracers with random free paths."""
    medium = BoltzmannGrad(NUMBER_DENSITY)
    v0 = simulate(medium, restitution, times=LATE, media=50, tracers=200, seed=4).thermal_speed
    slope = np.diff(1 / v0.value)[0] / np.diff(LATE)[0] / NUMBER_DENSITY
    error = np.hypot(*(v0.error / v0.value**2)) / np.diff(LATE)[0] / NUMBER_DENSITY
    return float(slope), float(error)


CENTRES = disks(np.random.default_rng(3))
PATH = simulate(
    Positions(CENTRES, BOX), 0.7, initial=np.array([[1.3, 0.5]]), times=PATH_TIMES, media=1,
    tracers=1, observables=("positions", "velocities"),
)  # fmt: skip
EXACT = np.array([ScalingSolution(e).cooling_rate for e in RESTITUTIONS])
PARTICLES = np.array([particle_rate(e) for e in RESTITUTIONS])


def draw(path: str) -> None:
    """The path, coloured by the speed; h/(1 - e) over e."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.collections import EllipseCollection, LineCollection
    from matplotlib.colors import LogNorm

    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.9), layout="constrained")
    r = PATH.positions[:, 0] + BOX / 2
    speed = np.hypot(*PATH.velocities[:, 0].T)
    shifts = BOX * np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)])
    images = (CENTRES[:, None] + shifts).reshape(-1, 2)
    one = np.ones(len(images))
    left.add_collection(
        EllipseCollection(
            one, one, one, units="xy", offsets=images, offset_transform=left.transData, color="0.8"
        )
    )
    lines = LineCollection(
        np.stack([r[:-1], r[1:]], axis=1), array=speed[1:], norm=LogNorm(), cmap="viridis", lw=1.3,
        rasterized=True,
    )  # fmt: skip
    left.add_collection(lines)
    left.plot(*r[0], "k.", ms=5)
    low, high = r.min(axis=0), r.max(axis=0)
    middle, half = (low + high) / 2, 0.5 * (high - low).max() + 2
    edges = np.array([-half, half])
    left.set(xlim=middle[0] + edges, ylim=middle[1] + edges, aspect="equal")
    left.set(xlabel="x [d]", ylabel="y [d]", title="one tracer among the disks, e = 0.7")
    figure.colorbar(lines, ax=left, label="speed [U]")

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
