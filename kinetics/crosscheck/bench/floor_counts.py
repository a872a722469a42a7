"""What the slowest pieces of work cannot leave out, counted: operations of each kind, or bytes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

# (what, how many, the rate at which it can be done: kinetics/crosscheck/bench/rates.py)
Counts = list[tuple[str, float, str]]

DISKS, DENSITY, TRACERS, BOUNCES = 10_000, 0.04, 2000, 1000


def averages(solution: Any, times: Any) -> Counts:
    """Of msd and kurtosis from a Gaussian: sums over its speeds at nodes in ln t, and between them.

    Both need the displacement squared, the kurtosis its fourth power as well: three averages, each
    an interpolation in ln T for every speed and node, and one in ln t for every time.
    """
    nodes = solution.stats["nodes_per_panel"]
    panels = math.ceil(math.log(times[-1] / times[0]))
    points = (nodes + 2) * panels * solution.stats["initial_points"]
    places = points + times.size
    return [
        ("interpolation weights, once for each place", places * nodes, "divisions"),
        ("interpolations of three averages", 3.0 * places * nodes, "multiply-adds"),
    ]


def fly() -> Any:
    """Hard disks and tracers with a number of collisions each."""
    from particles import HardDisks, simulate

    return simulate(
        HardDisks(DENSITY, count=DISKS), 0.9, max_collisions=BOUNCES, media=1, tracers=TRACERS,
        workers=1,
    )  # fmt: skip


def flights(ensemble: Any) -> Counts:
    """Of a collision: the cells that a free path crosses are searched, and one scatterer is hit."""
    from particles.grid.cells import cell_side

    # of a point among disks of radius d, the path before one is met is the free area over the
    # perimeter that it can hit: (1 - pi rho)/(2 rho) d at small densities
    free_path = (1.0 - math.pi * DENSITY) / (2.0 * DENSITY)
    searched = 1.0 + 4.0 / math.pi * free_path / cell_side(DENSITY)
    total = float(np.sum(ensemble.collision_total))
    return [
        ("cells of eight scatterers searched", total * searched, "cells searched"),
        ("bounces", total, "bounces"),
    ]


def waves(solution: Any) -> Counts:
    """Of a position density: the block systems of F(k), each with one right-hand side a column."""
    return [
        ("blocks of two harmonics at one k", float(count), f"solves of {size}")
        for size, count in sorted(solution.stats["systems"].items(), key=lambda item: int(item[0]))
    ]


def densities(solution: Any, turned: bool = False) -> Counts:
    """Of spectral densities: the gain of each harmonic, and its transforms at every time.

    turned : whether the axis is turned into the plane, where a field is complex
    """
    from kinetics import CollisionLaw

    law = CollisionLaw(solution.scene.restitution)
    products = exponentials = multiply_adds = 0.0
    transforms: Counts = []
    for m, profile in solution._profiles.items():
        grid = profile.at.early.grid
        modes, highest = grid.nodes // 2 + 1, math.pi / grid.spacing
        points = law.quadrature_for(highest, m).weight.size
        # the average over the impact parameter: phases, each the product of two that are known,
        # and a matrix product with 38 columns
        products += 4.0 * modes * points
        multiply_adds += 2.0 * modes * points * 38
        kinds = 2.0 if turned else 1.0
        fields = (2.0 if m == 0 else 1.0) * kinds
        size = grid.nodes * solution.times.size
        transforms.append(
            ("to the wave numbers and back", solution.times.size * (kinds + fields),
             f"transforms of {grid.nodes}")
        )  # fmt: skip
        exponentials += kinds * size
        products += 3.0 * (fields + 1.0) * size
    return [
        ("averages of the gain", multiply_adds, "multiply-adds"),
        ("decay at every time", exponentials, "exponentials"),
        ("phases of the gain, fields at every time", products, "products"),
        *_together(transforms),
    ]


def _together(counts: Counts) -> Counts:
    """Entries of one kind summed."""
    found: dict[tuple[str, str], float] = {}
    for what, number, rate in counts:
        found[what, rate] = found.get((what, rate), 0.0) + number
    return [(what, number, rate) for (what, rate), number in found.items()]
