"""Every event of millions: contact, order, collision rule, nothing inside, nothing twice."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from particles import BoltzmannGrad, HardDisks, Poisson, Positions, simulate
from particles.grid.build import build
from particles.grid.equilibrate import centres

INSIDE = 1e-13  # no tracer is nearer to a scatterer than 1 - INSIDE; rounding of 100 d is 1e-14


def tree_of(medium: HardDisks | Poisson, seed: int) -> tuple[cKDTree, float]:
    cells = build(medium, np.uint64(seed), 0)
    positions = np.empty((medium.count, 2))
    centres(cells, positions)
    box = medium.box_side
    return cKDTree((positions + box / 2) % box, boxsize=box), box


def nearest(tree: cKDTree, box: float, places: np.ndarray, k: int = 1) -> tuple:
    return tree.query((places + box / 2) % box, k=k)


@pytest.mark.parametrize(
    ("medium", "restitution"),
    [
        pytest.param(HardDisks(0.04, 4000), 0.7, marks=pytest.mark.slow),
        pytest.param(HardDisks(0.3, 4000), 1.0, marks=pytest.mark.slow),
        pytest.param(Poisson(0.1, 4000), 0.0, marks=pytest.mark.slow),
        (Poisson(0.3, 4000), 0.9),
    ],
)
def test_every_event_of_a_million(medium: HardDisks | Poisson, restitution: float) -> None:
    # The same tracers stopped after 1, 2, ... collisions: 20 x 15 000 events for each medium.
    tracers, events, seed = 15_000, 20, 11
    tree, box = tree_of(medium, seed)
    before = None
    seen = 0
    for k in range(1, events + 1):
        ensemble = simulate(
            medium, restitution, media=1, tracers=tracers, max_collisions=k, seed=seed, workers=1,
            observables=["finals"],
        )  # fmt: skip
        finals = ensemble.finals
        # Trapped tracers end before, at their sixteenth tiny flight.
        alive = finals[:, 4] == k
        assert alive.sum() >= tracers - ensemble.statuses.trapped
        place = finals[:, 2:4]
        distance, struck = nearest(tree, box, place, 2)
        # In contact with one, inside none. In a corner, the second one may be as near.
        assert np.all(distance[:, 0] > 1 - INSIDE)
        assert np.all(distance[:, 0] < 1 + 1e-12)
        if before is not None:
            old, old_struck, old_distance = before
            flight = place - old[:, 2:4]
            length = np.hypot(*flight.T)
            clear = alive & (distance[:, 1] > 1 + 1e-9) & (old_distance[:, 1] > 1 + 1e-9)
            clear &= length > 1e-6
            seen += clear.sum()
            # Nobody meets the same scatterer twice running.
            assert not np.any((struck[:, 0] == old_struck[:, 0])[clear] & (length[clear] < box / 2))
            # Later, by what the flight takes at the speed before; slower, by a ratio from e to 1.
            elapsed = np.exp(finals[:, 1]) - np.exp(old[:, 1])
            assert np.all(finals[alive, 1] >= old[alive, 1])
            np.testing.assert_allclose(
                elapsed[clear] * np.exp(old[clear, 0]), length[clear],
                rtol=1e-9, atol=1e-9,
            )  # fmt: skip
            loss = finals[:, 0] - old[:, 0]
            assert np.all(loss[alive] <= 1e-15)
            if restitution > 0:
                assert np.all(loss[alive] >= np.log(restitution) - 1e-13)
            # Nothing in the way: 9 places on each flight, and no event was passed over.
            for f in np.linspace(0.1, 0.9, 9):
                between, _ = nearest(tree, box, old[clear, 2:4] + f * flight[clear])
                assert np.all(between > 1 - INSIDE)
            # The speed ratio is that of the impact parameter, from the geometry alone.
            scatterer = tree.data[struck[:, 0]]
            normal = (place + box / 2 - scatterer + box / 2) % box - box / 2
            direction = flight / np.maximum(length, 1e-300)[:, None]
            approach = np.sum(direction * normal, axis=1)
            assert np.all(approach[clear] < 1e-9)
            ratio = np.sqrt(1 - (1 - restitution**2) * approach**2)
            long = clear & (length > 1e-3) & (ratio > 1e-3)
            np.testing.assert_allclose(np.exp(loss[long]), ratio[long], rtol=1e-8, atol=1e-10)
        before = finals, struck, distance
    # At e = 0 a third of all are trapped before their twentieth collision.
    assert seen > 0.6 * (events - 1) * tracers


def test_outputs_are_never_inside_a_scatterer() -> None:
    medium = Poisson(0.3, 4000)
    tree, box = tree_of(medium, 12)
    ensemble = simulate(
        medium, 0.5, times=np.geomspace(0.01, 1e4, 50), media=1, tracers=10_000, seed=12,
        observables=["positions"],
    )  # fmt: skip
    distance, _ = nearest(tree, box, ensemble.positions.reshape(-1, 2))
    assert distance.min() > 1 - INSIDE
    assert distance.min() < 1 + 1e-4


def test_elastic_energy_after_a_million_collisions() -> None:
    ensemble = simulate(
        Poisson(0.1, 1000), 1.0, "monoenergetic", times=[5.3e6], media=2, tracers=1,
        observables=["velocities"],
    )  # fmt: skip
    assert np.all(ensemble.collisions.value > 1e6)
    speeds = np.hypot(*ensemble.velocities[0].T)
    assert np.all(abs(speeds**2 - 1) < 1e-12)


@pytest.mark.slow
def test_without_restitution_no_digit_is_lost_after_1e5_collisions() -> None:
    # e = 0: -ln s of a collision is exponential with mean 1 (y uniform), so after N collisions
    # -ln v is N +- sqrt(N); v reaches exp(-1e5), far below the smallest double. Y = v t just after
    # a collision obeys Y' = s (Y + L) with E[s] = 1/2, so E[Y] = l. Both within 4 sigma.
    for n in (1000, 100_000):
        tracers = 200
        ensemble = simulate(
            BoltzmannGrad(0.04), 0.0, "monoenergetic", media=5, tracers=tracers, max_collisions=n,
            observables=["finals"],
        )  # fmt: skip
        ln_v, ln_t, *_ = ensemble.finals.T
        assert np.isfinite(ensemble.finals).all()
        assert abs(np.mean(ln_v) / n + 1) < 4 / np.sqrt(5 * tracers * n)
        y = np.exp(ln_v + ln_t)
        assert abs(y.mean() - 12.5) < 4 * y.std() / np.sqrt(y.size)


@pytest.mark.parametrize(
    "medium",
    [BoltzmannGrad(0.04), pytest.param(Poisson(0.001, box=None), marks=pytest.mark.slow)],
)
def test_the_scaling_state_looks_the_same_at_any_time(medium: BoltzmannGrad | Poisson) -> None:
    # v0(t) t = sqrt(2) l for e = 0 once t is large, until 1e300. In the plane, recollisions and
    # traps change it by some percent, at all times alike.
    ensemble = simulate(medium, 0.0, times=[1e9, 1e50, 1e150, 1e300], media=200, tracers=20, seed=3)
    scaled = ensemble.thermal_speed.value * ensemble.times
    error = ensemble.thermal_speed.error * ensemble.times
    length = 0.5 / medium.number_density
    if isinstance(medium, BoltzmannGrad):
        assert np.all(abs(scaled - np.sqrt(2) * length) < 4 * error)
        assert np.all(error < 0.05 * scaled)
    else:
        assert np.isfinite(scaled).all()
        assert ensemble.missing.sum() == 0


def test_a_free_road_is_an_escape() -> None:
    # A square lattice with a tracer along its axis meets nothing, ever.
    lattice = np.stack(np.meshgrid([0.0, 5.0], [0.0, 5.0]), axis=-1).reshape(-1, 2)
    medium = Positions(lattice, 10.0, start=(2.5, 2.5))
    ensemble = simulate(
        medium, 0.5, np.array([[1.0, 0.0]]), times=[1.0, 1e9], media=1, tracers=1,
    )  # fmt: skip
    assert ensemble.statuses.escaped == 1
    assert list(ensemble.samples) == [1, 0]
    assert ensemble.msd.value[0] == 1.0
    # Before the limit it is a flight like any other.
    ensemble = simulate(medium, 0.5, np.array([[1.0, 0.0]]), times=[1.0, 1e5], media=1, tracers=1)
    assert ensemble.statuses.finished == 1
    assert ensemble.msd.value[1] == pytest.approx(1e10, rel=1e-12)
