"""Equilibration leads to the equilibrium: all configurations without overlap equally likely."""

import numpy as np

from particles import HardDisks
from particles.grid.build import build
from particles.grid.equilibrate import centres, equilibrate


def configurations(medium: HardDisks, sweeps: int, n: int) -> np.ndarray:
    """Return the disks of n configurations from the middle of the box, (n, count, 2)."""
    found = np.empty((n, medium.count, 2))
    for c in range(n):
        cells = build(medium, np.uint64(9), c)
        found[c] = equilibrate(cells, medium.count, sweeps, np.uint64(9), c)
    return found


def rejected(medium: HardDisks, draws: int) -> np.ndarray:
    """Draw all disks at once, uniform in the box; keep the configurations without an overlap."""
    box = medium.box_side
    disks = np.random.default_rng(1).uniform(-box / 2, box / 2, (draws, medium.count, 2))
    # The clearing in the middle is a disk that stays.
    everything = np.concatenate([np.zeros((draws, 1, 2)), disks], axis=1)
    return disks[np.all(distances(everything, box) >= 1, axis=1)]


def distances(disks: np.ndarray, box: float) -> np.ndarray:
    """Return the distances of all pairs, (n, pairs), to the nearest image."""
    i, j = np.triu_indices(disks.shape[1], 1)
    apart = disks[:, i] - disks[:, j]
    return np.hypot(*np.moveaxis(apart - box * np.round(apart / box), -1, 0))


def statistics(disks: np.ndarray, box: float) -> np.ndarray:
    """Return statistics of each configuration, (n, 6)."""
    x, y = np.moveaxis(disks, -1, 0)
    near = np.mean(distances(disks, box) < 1.2, axis=1)
    clearing = np.mean(np.hypot(x, y) < 1.2, axis=1)
    columns = (x.mean(1), y.mean(1), (x**2).mean(1), (y**2).mean(1), near, clearing)
    return np.stack(columns, axis=1)


def test_few_disks_reach_the_equilibrium_that_rejection_draws() -> None:
    # 5 disks in a box of 4.08 d, 2000 configurations after 60 sweeps and some 5000 from rejection:
    # six means agree within 4 sigma. Places are not symmetric about the clearing if a step is
    # biased; pairs and the disks at the clearing are as frequent as their exclusion alone makes it.
    medium = HardDisks(0.3, 5)
    found = statistics(configurations(medium, 60, 2000), medium.box_side)
    drawn = statistics(rejected(medium, 150_000), medium.box_side)
    assert len(drawn) > 3000
    error = np.sqrt(found.var(axis=0) / len(found) + drawn.var(axis=0) / len(drawn))
    sigmas = (found.mean(axis=0) - drawn.mean(axis=0)) / error
    assert np.all(abs(sigmas) < 4), sigmas


def test_steps_are_as_likely_forth_as_back() -> None:
    # The mean displacement in 4 sweeps, over 3000 disks and 12 configurations, is 0 within 4 sigma
    # in x and in y; sigma from the spread over configurations. It is 0.003 d; a step drawn from
    # (-0.45, 0.55) instead of (-0.5, 0.5) of its length would move the disks by some 0.2 d.
    medium, n = HardDisks(0.3, 3000), 12
    means = np.empty((n, 2))
    for c in range(n):
        cells = build(medium, np.uint64(4), c)
        before = np.empty((medium.count, 2))
        centres(cells, before)
        moved = equilibrate(cells, medium.count, 4, np.uint64(4), c) - before
        moved -= medium.box_side * np.round(moved / medium.box_side)
        means[c] = moved.mean(axis=0)
    sigma = means.std(axis=0, ddof=1) / np.sqrt(n)
    assert np.all(sigma < 0.01)
    assert np.all(abs(means.mean(axis=0)) < 4 * sigma), (means.mean(axis=0), sigma)
