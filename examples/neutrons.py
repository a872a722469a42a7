"""How far does a pulse of neutrons come in graphite while it slows down?

python examples/neutrons.py

Neutrons of 2 MeV meet carbon nuclei at rest, twelve times as heavy as they are: elastic spheres of
one cross section at all energies, so that the free path is always 2.6 cm. The equation stands
beside particles, which are another method for the same gas, and beside Fermi's age: a sixth of
what <r^2> grows by while the energy falls to 1/e.
"""

import numpy as np

from kinetics import ScalingSolution, Scene, solve
from particles import BoltzmannGrad, simulate

MASS_RATIO, FREE_PATH, ENERGY = 12.0, 2.6, 2e6  # FREE_PATH in cm, ENERGY at the start in eV
SPEED = 1956.0  # at the start, in cm/us
DENSITY = 1 / np.pi  # nuclei per d^3, so that the free path is d
TIMES = np.geomspace(10.0, 1e5, 9)  # in free paths over the initial speed
USUAL = dict(initial="monoenergetic", times=TIMES, mass_ratio=MASS_RATIO)

EXACT = ScalingSolution(1.0, dimension=3, mass_ratio=MASS_RATIO)
AGE = EXACT.diffusion_slope / 12 * FREE_PATH**2  # the energy falls as 1/t^2; in cm^2
SOLUTION = solve(Scene(1.0, DENSITY, dimension=3, outputs=("thermal_speed", "msd"), **USUAL))
ENERGIES, SPREAD = ENERGY * SOLUTION.thermal_speed**2, FREE_PATH * np.sqrt(SOLUTION.msd)
RUN = simulate(BoltzmannGrad(DENSITY, dimension=3), 1.0, media=100, tracers=500, **USUAL)

if __name__ == "__main__":
    for row in zip(TIMES * FREE_PATH / SPEED, ENERGIES, SPREAD, RUN.msd.value, strict=True):
        time, energy, spread, msd = row
        words = f"{time:9.3f} us: {energy:9.3g} eV, {spread:5.2f} cm from the start"
        print(f"{words} (particles {FREE_PATH * msd**0.5:5.2f})")
    print(f"age: {AGE:.3f} cm^2 for each factor e of the energy")
