"""From rest among disks: every tracer begins at a place of its own."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from particles import Ensemble, HardDisks, Poisson, Positions, simulate
from particles.configuration import start_places
from particles.media import Medium
from particles.paths import disks_within
from particles.placement import build


def released(medium: Medium, media: int, tracers: int, last: float = 20.0) -> Ensemble:
    return simulate(
        medium, 0.7, "rest", [last], media=media, tracers=tracers, seed=3, field=1.0,
        observables=["positions", "finals"],
    )  # fmt: skip


@pytest.mark.parametrize("medium", [Poisson(0.2, 400, diameter=2.0), HardDisks(0.3, 400)])
def test_tracers_begin_at_free_places_all_over_the_box(medium: HardDisks | Poisson) -> None:
    n = 400
    plan = released(medium, 1, n, 0.1).plan
    cells = build(medium, np.uint64(plan.seed), 0)
    own = start_places(plan, 0, cells, 0, n)
    assert np.array_equal(start_places(plan, 0, cells, 30, 9), own[30:39])
    assert not own[0].any()
    places = own[:, :2] * cells.side + own[:, 2:]
    # The means of x/L and of its square, L the side; five standard deviations.
    share = places[1:] / (cells.side * cells.shape[0])
    assert abs(share).max() < 0.505
    np.testing.assert_allclose(share.mean(axis=0), 0.0, atol=5 / np.sqrt(12 * n))
    np.testing.assert_allclose((share**2).mean(axis=0), 1 / 12, atol=5 / np.sqrt(180 * n))
    d = medium.diameter
    near = places[abs(own[:, :2]).max(axis=1) < 12] * d
    disks = disks_within(plan, 0, near.min(axis=0) - 2 * d, near.max(axis=0) + 2 * d)
    assert disks is not None
    assert len(near) > 10
    assert cKDTree(disks).query(near)[0].min() > d * (1 - 1e-12)


def test_the_first_tracer_is_the_one_that_is_released_alone() -> None:
    alone, together = (released(HardDisks(0.1, 400), 3, n) for n in (1, 4))
    assert np.array_equal(alone.finals, together.finals[::4])


@pytest.mark.parametrize(("start", "paths"), [(None, 8), ((3.0, 4.0), 1)])
def test_among_given_positions_a_start_that_is_given_is_kept(
    start: tuple[float, float] | None, paths: int
) -> None:
    positions = np.random.default_rng(1).uniform(0.0, 40.0, (80, 2))
    for place in ((20.0, 20.0), (3.0, 4.0)):
        positions = positions[np.hypot(*(positions - place).T) > 1]
    run = released(Positions(positions, 40.0, start=start), 1, 8)
    assert len(np.unique(run.positions[0], axis=0)) == paths
