"""Histograms of velocities among particles without recollisions, for rough spheres."""

from functools import partial

import numpy as np
from example_values import DENSITY, gaussian_speeds
from sigmas import check_counts

from kinetics import AngularHarmonics, CollisionLaw, Scene, solve
from particles import BoltzmannGrad, simulate

TRACERS = 150_000
TIMES = np.array([0.7, 4.0])


def test_speeds_and_angles_in_space() -> None:
    """From f = maxwell(v) (1 + 0.8 cos(theta))/(4 pi): the two harmonics that there are."""
    e, et = 0.6, 0.9

    maxwell = partial(gaussian_speeds, dimension=3)
    scene = Scene(
        CollisionLaw(e, et, 3), number_density=DENSITY[3], times=TIMES,
        initial=AngularHarmonics({0: maxwell, 1: lambda v: 0.8 / 3.0 * maxwell(v)}),
        outputs=("velocity_density", "thermal_speed"),
    )  # fmt: skip
    solution = solve(scene, 1e-8)
    rng = np.random.default_rng(5)
    speed = np.linalg.norm(rng.normal(size=(TRACERS, 3)), axis=1)
    # the share below x = cos(theta) is (x + 1)/2 + 0.2 (x^2 - 1)
    share = rng.uniform(size=TRACERS)
    cosine = (np.sqrt(0.25 - 0.8 * (0.3 - share)) - 0.5) / 0.4
    angle, sine = rng.uniform(0.0, 2.0 * np.pi, TRACERS), np.sqrt(1.0 - cosine**2)
    direction = np.stack([cosine, sine * np.cos(angle), sine * np.sin(angle)], axis=1)
    ensemble = simulate(
        BoltzmannGrad(DENSITY[3], dimension=3), e, (speed[:, None] * direction)[None], TIMES,
        media=1, tracers=TRACERS, seed=8, observables=["velocities"], tangential_restitution=et,
    )  # fmt: skip
    x, w = np.polynomial.legendre.leggauss(6)
    for i, thermal in enumerate(solution.thermal_speed):
        edges, sides = np.linspace(0.0, 2.6, 21) * thermal, np.linspace(-1.0, 1.0, 6)
        velocity = ensemble.velocities[i]
        speed = np.linalg.norm(velocity, axis=1)
        counts = np.histogram2d(speed, velocity[:, 0] / speed, [edges, sides])[0]
        v = (0.5 * (edges[1:] + edges[:-1])[:, None] + 0.5 * np.diff(edges)[:, None] * x).ravel()
        c = (0.5 * (sides[1:] + sides[:-1])[:, None] + 0.5 * np.diff(sides)[:, None] * x).ravel()
        f = solution.velocity_density(v, np.arccos(c))[i] * (2.0 * np.pi * v**2)[:, None]
        f = f.reshape(20, 6, 5, 6)
        shares = np.einsum("aibj,i,j->ab", f, w, w) * np.outer(np.diff(edges), np.diff(sides)) / 4
        check_counts(TRACERS, counts, shares)
