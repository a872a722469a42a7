"""Every event of many: contact, order, collision rule, nothing inside, nothing twice."""

from typing import Any

import numpy as np
import pytest
from scattered import Around

import particles
from particles import BoltzmannGrad, HardDisks, HardSpheres, Poisson, PoissonSpheres, simulate

INSIDE = 1e-13  # no tracer is nearer to a scatterer than 1 - INSIDE; rounding of 100 d is 1e-14
PLACE = {2: [2, 3], 3: [2, 3, 5]}  # columns of `finals`


MORE = [
    (HardDisks(0.04, 4000), (0.7, 0.9)), (HardDisks(0.3, 4000), (1.0, 1.0)),
    (Poisson(0.1, 4000), (0.0, 1.0)), (HardSpheres(0.4, count=3000), (1.0, 1.0)),
    (PoissonSpheres(0.03, count=3000), (0.9, 0.4)),
]  # fmt: skip


@pytest.mark.parametrize(
    ("medium", "law"),
    [
        (Poisson(0.3, 4000), (0.9, 1.0)),
        (HardSpheres(0.03, count=3000), (0.7, 1.0)),
        (PoissonSpheres(0.2, count=3000), (0.5, 1.0)),
        *(pytest.param(*case, marks=pytest.mark.slow) for case in MORE),
    ],
)
def test_every_event(medium: Any, law: tuple[float, float]) -> None:
    # The same tracers stopped after 1, 2, ... collisions: in contact, nothing in the way, and the
    # rule of the collision from the geometry alone.
    tracers, seed, (e, et) = 4_000, 11, law
    around, columns = Around(medium, seed), PLACE[medium.dimension]
    seen = 0
    before: Any = None
    direction: Any = None
    for n in range(1, 13):
        run = simulate(
            medium, e, media=1, tracers=tracers, max_collisions=n, seed=seed,
            observables=["finals"], tangential_restitution=et,
        )  # fmt: skip
        finals = run.finals
        alive = finals[:, 4] == n
        assert alive.sum() >= tracers - run.statuses.trapped
        place = finals[:, columns]
        distance, struck = around.nearest(place, 2)
        # In contact with one, inside none. In a corner, the second one may be as near.
        assert np.all(distance[:, 0] > 1 - INSIDE)
        assert np.all(distance[:, 0] < 1 + 1e-12)
        normal = around.offset(place, struck[:, 0])
        alone = distance[:, 1] > 1 + 1e-8  # in no corner
        if before is not None:
            old, old_normal, old_alone, old_struck = before
            flight = place - old[:, columns]
            length = np.linalg.norm(flight, axis=1)
            clear = alive & alone & old_alone & (length > 1e-5)
            seen += clear.sum()
            # Nobody meets the same scatterer twice running.
            again = (struck[:, 0] == old_struck)[clear]
            assert not np.any(again & (length[clear] < around.box / 2))
            # Later, by what the flight takes at the speed before.
            elapsed = np.exp(finals[:, 1]) - np.exp(old[:, 1])
            np.testing.assert_allclose(
                elapsed[clear] * np.exp(old[clear, 0]), length[clear], rtol=1e-8, atol=1e-9
            )
            for f in np.linspace(0.1, 0.9, 5):  # nothing in the way
                between, _ = around.nearest(old[clear][:, columns] + f * flight[clear])
                assert np.all(between > 1 - INSIDE)
            u = flight / np.maximum(length, 1e-300)[:, None]
            approach = np.sum(u * normal, axis=1)
            assert np.all(approach[clear] < 1e-9)
            ratio = np.sqrt(et**2 - (et**2 - e**2) * approach**2)
            firm = clear & (length > 1e-3) & (ratio > 1e-3)
            loss = np.exp(finals[:, 0] - old[:, 0])
            # At e = 0 a small ratio is the root of a difference, with some 1e-14 over it in error.
            close = dict(rtol=1e-8, atol=1e-10 if e == 0.0 else 0.0)
            np.testing.assert_allclose(loss[firm], ratio[firm], **close)
            if direction is not None:
                # Momentum at the bounce between the two flights: et tangential, -e normal.
                old_u, old_firm = direction
                w = np.sum(old_u * old_normal, axis=1)[:, None]
                v = et * old_u - (e + et) * w * old_normal
                v /= np.maximum(np.linalg.norm(v, axis=1), 1e-300)[:, None]
                both = firm & old_firm
                np.testing.assert_allclose(u[both], v[both], rtol=0, atol=1e-9)
            direction = u, firm
        before = finals, normal, alone, struck[:, 0]
    # At e = 0 a third of all are trapped before their twentieth collision.
    assert seen > 0.6 * 11 * tracers


@pytest.mark.slow
@pytest.mark.parametrize("kind", [HardDisks, Poisson, HardSpheres, PoissonSpheres])
def test_1e8_events_keep_the_energy_and_no_tracer_is_inside(kind: Any) -> None:
    # pytest -m slow -k 1e8_events: 1e8 collisions of each medium at l = 10 d or so, and the places
    # and speeds of all tracers at 20 times among them.
    medium = kind(0.05 if kind.dimension == 2 else 0.1 / np.pi, count=40_000)
    tracers, times = 20_000, np.linspace(2_000, 52_000, 20)
    run = simulate(
        medium, 1.0, "monoenergetic", times=times, media=1, tracers=tracers, seed=2,
        observables=["positions"],
    )  # fmt: skip
    assert run.collision_total > 1e8
    assert run.statuses.finished == tracers
    np.testing.assert_allclose(run.thermal_speed.value, 1.0, rtol=1e-12)
    around = Around(medium, 2)
    for places in run.positions:
        assert around.nearest(places)[0].min() > 1 - INSIDE


@pytest.mark.parametrize("medium", [Poisson(0.3, 4000), PoissonSpheres(0.2, count=4000)])
def test_outputs_are_never_inside_a_scatterer(medium: Any) -> None:
    run = simulate(
        medium, 0.5, times=np.geomspace(0.01, 1e4, 40), media=1, tracers=5000, seed=12,
        observables=["positions"],
    )  # fmt: skip
    distance, _ = Around(medium, 12).nearest(run.positions.reshape(-1, medium.dimension))
    assert 1 - INSIDE < distance.min() < 1 + 1e-4


@pytest.mark.slow
def test_without_restitution_no_digit_is_lost_after_1e5_collisions() -> None:
    # e = 0: -ln s of a collision is exponential with mean 1 (y uniform), so after N collisions
    # -ln v is N +- sqrt(N); v reaches exp(-1e5), far below the smallest double. Y = v t just after
    # a collision obeys Y' = s (Y + L) with E[s] = 1/2, so E[Y] = l. Both within 4 sigma.
    n, tracers = 100_000, 200
    run = simulate(
        BoltzmannGrad(0.04), 0.0, "monoenergetic", media=5, tracers=tracers, max_collisions=n,
        observables=["finals"],
    )  # fmt: skip
    ln_v, ln_t, *_ = run.finals.T
    assert np.isfinite(run.finals).all()
    assert abs(np.mean(ln_v) / n + 1) < 4 / np.sqrt(5 * tracers * n)
    y = np.exp(ln_v + ln_t)
    assert abs(y.mean() - 12.5) < 4 * y.std() / np.sqrt(y.size)


@pytest.mark.parametrize("medium", [BoltzmannGrad(0.04), Poisson(0.001, 4000)])
def test_the_scaling_state_looks_the_same_at_any_time(medium: Any) -> None:
    # v0(t) t = sqrt(2) l for e = 0 once t is large, until 1e300. Among scatterers recollisions and
    # traps change it by some percent.
    run = simulate(medium, 0.0, times=[1e9, 1e50, 1e150, 1e300], media=200, tracers=20, seed=3)
    scaled, error = run.thermal_speed.value * run.times, run.thermal_speed.error * run.times
    assert run.missing.sum() == 0
    assert np.isfinite(scaled).all()
    if isinstance(medium, BoltzmannGrad):
        assert np.all(abs(scaled - np.sqrt(2) * 12.5) < 4 * error)
        assert np.all(error < 0.05 * scaled)


@pytest.mark.parametrize("field", [0.0, 1.0])
def test_a_free_road_is_an_escape(field: float) -> None:
    # A square lattice with a tracer along its axis meets nothing, ever.
    lattice = np.stack(np.meshgrid([0.0, 5.0], [0.0, 5.0]), axis=-1).reshape(-1, 2)
    arguments: Any = dict(media=1, tracers=1, field=field, depth=50.0 if field else None)
    medium, ahead = particles.Positions(lattice, 10.0, start=(2.5, 2.5)), np.array([[1.0, 0.0]])
    run = simulate(medium, 0.5, ahead, [10.0, 1e9], **arguments)
    assert run.statuses.escaped == 1
    assert list(run.samples) == [1, 0]
    assert run.msd.value[0] == pytest.approx((10.0 + 50.0 * field) ** 2, rel=1e-12)
    if field:
        assert run.passage_times[0] == pytest.approx(np.sqrt(101.0) - 1.0, rel=1e-12)
    else:  # before the limit it is a flight like any other
        run = simulate(medium, 0.5, ahead, [1.0, 1e5], **arguments)
        assert run.statuses.finished == 1
        assert run.msd.value[1] == pytest.approx(1e10, rel=1e-12)


@pytest.mark.parametrize("law", [(1.0, 1.0), (0.5, 0.5), (0.9, 0.3), (0.5, 0.0)])
@pytest.mark.parametrize("medium", [HardDisks(0.5, 1000), HardSpheres(0.4, count=500)])
def test_nobody_is_trapped_where_the_tangential_factor_is_not_the_larger(
    medium: Any, law: tuple[float, float]
) -> None:
    run = simulate(
        medium, law[0], media=4, tracers=10, max_collisions=20_000, tangential_restitution=law[1]
    )
    assert run.statuses.collision_cap == 40
