"""A law of one's own, and mixtures of laws: averages are known; no law is refused."""

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from marking import slow_but

from kinetics import (
    CollisionLaw,
    Monoenergetic,
    ScalingSolution,
    Scene,
    solve,
    solve_field,
    solve_scaled,
)

GIVEN = ([0.25, 0.75], [0.5, 0.9], [0.3, -1.0])


def test_sums_over_samples() -> None:
    law = CollisionLaw.from_samples(*GIVEN)
    assert law.mean_speed_ratio_power(3.0) == pytest.approx(0.25 * 0.5**3 + 0.75 * 0.9**3)
    assert law.mean_cosine == pytest.approx(0.25 * 0.3 - 0.75)
    # cos(2 chi) = 2 cos^2 - 1 in the plane, P_2 = (3 cos^2 - 1)/2 in space
    plane = 1.0 - (0.25 * 0.5 * (2 * 0.09 - 1) + 0.75 * 0.9)
    assert law.harmonic_decay_rate(1.0, 2) == pytest.approx(plane)
    space = CollisionLaw.from_samples(*GIVEN, dimension=3)
    assert space.harmonic_decay_rate(1.0, 2) == pytest.approx(
        1.0 - (0.25 * 0.5 * 0.5 * (3 * 0.09 - 1) + 0.75 * 0.9)
    )
    assert (law.least_loss, law.largest_loss) == pytest.approx((-np.log(0.9), np.log(2.0)))
    u, weight = law.survival_for(3.0)
    assert weight @ np.exp(-2.0 * u) == pytest.approx(law.decay_rate(2.0) / 2.0, rel=1e-13)


# -- mixtures -------------------------------------------------------------------------------------

PARTS = [
    (0.5, 1.0, 2),
    (0.0, 1.0, 2),
    (0.8, 0.8, 2),
    (0.6, 0.0, 2),
    (0.0, 1.0, 3),
    (0.9, 0.7, 3),
]


@pytest.mark.parametrize(("e", "et", "dimension"), slow_but([PARTS[2]], PARTS))
def test_the_scaled_speeds_of_a_law_mixed_with_itself(e: float, et: float, dimension: int) -> None:
    """Where a bounce may stop the tracer, the closed form of a mixture takes 15 s."""
    law, c = CollisionLaw(e, et, dimension), np.array([0.2, 1.0, 3.0])
    mixed = ScalingSolution(CollisionLaw.mixture([1.0, 2.0], [law, law]))
    assert mixed.vdf(c) == pytest.approx(ScalingSolution(law).vdf(c), rel=1e-12)


def test_samples_that_few_nodes_do_not_resolve_do_not_warn() -> None:
    """The first try overflowed, with NumPy's warnings, before nodes were doubled."""
    weight = [0.22124852141751775, 0.6353547857956121, 0.14339669278687014]
    ratio = [0.8758143626156287, 0.9887806325647014, 0.4098700181355197]
    law = CollisionLaw.from_samples(weight, ratio, [0.0, 0.0, 0.0])
    found, exact = solve_scaled(law, 1e-4), ScalingSolution(law)
    assert found.vdf(1.1) == pytest.approx(exact.vdf(1.1), rel=1e-4)


@pytest.mark.parametrize(("e", "et", "dimension"), PARTS)
def test_a_law_mixed_with_itself_is_that_law(e: float, et: float, dimension: int) -> None:
    law = CollisionLaw(e, et, dimension)
    mixed = CollisionLaw.mixture([1.0, 2.0], [law, law])
    one, other = ScalingSolution(law), ScalingSolution(mixed)
    assert other.cooling_rate == pytest.approx(one.cooling_rate, rel=1e-12)
    assert other.a2 == pytest.approx(one.a2, rel=1e-12, abs=1e-12)
    outputs = ("thermal_speed", "a2", "msd", "kurtosis")
    scenes = [
        Scene(x, dimension=dimension, times=[0.5, 10.0, 1e6], outputs=outputs) for x in (law, mixed)
    ]
    first, second = (solve(scene) for scene in scenes)
    for name in outputs:
        assert getattr(second, name) == pytest.approx(getattr(first, name), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (CollisionLaw(0.5), CollisionLaw(0.9)),
        (CollisionLaw(0.0), CollisionLaw(1.0)),
        (CollisionLaw(0.4, 0.8, 3), CollisionLaw(1.0, 1.0, 3, mass_ratio=0.2)),
        (CollisionLaw(0.3), CollisionLaw.from_samples(*GIVEN)),
    ],
    ids=repr,
)
def test_averages_of_a_mixture_are_those_of_its_laws(
    first: CollisionLaw, second: CollisionLaw
) -> None:
    mixed = CollisionLaw.mixture([0.3, 0.7], [first, second])

    def mean(of: Callable[[CollisionLaw], float]) -> object:
        return pytest.approx(0.3 * of(first) + 0.7 * of(second), rel=1e-13, abs=1e-15)

    # -0.999 is next to the lowest power at e = 0, where the points alone leave a share out
    for p, m in [(-0.999, 0), (1e-9, 0), (2.5, 0), (30.0, 0), (-0.9, 2), (1.0, 1), (3.0, 40)]:
        of_law = partial(CollisionLaw.harmonic_decay_rate, p=p, m=m)
        assert mixed.harmonic_decay_rate(p, m) == mean(of_law)
    assert mixed.mean_log_loss == mean(lambda law: law.mean_log_loss)
    assert mixed.mean_cosine == mean(lambda law: law.mean_cosine)
    # the chance to lose more than u, over e^u e^(-3 u): lambda(2)/2
    loss, weight = mixed.survival_for(3.0)
    found = weight @ np.exp(-2.0 * loss)
    assert found == pytest.approx(mixed.decay_rate(2.0) / 2.0, rel=1e-13)
    nested = CollisionLaw.mixture([1.0, 1.0], [mixed, first])
    assert nested.decay_rate(2.0) == pytest.approx(
        0.65 * first.decay_rate(2.0) + 0.35 * second.decay_rate(2.0), rel=1e-13
    )


def test_a_mixture_is_its_joined_points() -> None:
    one, other = CollisionLaw(0.5), CollisionLaw(0.9)
    mixed = CollisionLaw.mixture([0.4, 0.6], [one, other])
    # the points for slow functions alone give F(k, t) with an error of 7e-8 at k l = 1
    q = mixed.quadrature_for(80.0, 80)
    joined = CollisionLaw.from_samples(q.weight, q.ratio, q.cosine)
    outputs = ("thermal_speed", "a2", "msd", "kurtosis", "intermediate_scattering")
    found, expected = (
        solve(Scene(law, times=[1.0, 30.0], outputs=outputs), rtol=1e-9) for law in (mixed, joined)
    )
    for name in outputs[:-1]:
        assert getattr(found, name) == pytest.approx(getattr(expected, name), rel=1e-11)
    k = np.array([0.1, 1.0])
    apart = found.intermediate_scattering(k) - expected.intermediate_scattering(k)
    assert np.abs(apart).max() < 1e-9
    field = [solve_field(law, rtol=1e-6).drift for law in (mixed, joined)]
    assert field[0] == pytest.approx(field[1], rel=1e-6)
    # the scaled speeds as well, and a smooth law has a tail, where the points have none
    exact = ScalingSolution(mixed)
    assert solve_scaled(mixed).vdf([0.3, 1.0]) == pytest.approx(exact.vdf([0.3, 1.0]), rel=1e-9)
    assert mixed.tail_exponent == pytest.approx(0.4 / 0.75 + 0.6 / 0.19)
    assert ScalingSolution(joined).cooling_rate == pytest.approx(exact.cooling_rate, rel=1e-13)


def test_a_mixture_meets_tracers_that_are_thrown() -> None:
    """A path of numpy, with a bounce of its own; each collision off e = .5 or .9 at random."""
    random, count, t = np.random.default_rng(39), 200_000, 6.0
    v = np.stack([np.ones(count), np.zeros(count)])
    r, left = np.zeros((2, count)), np.full(count, t)
    while np.any(left > 0.0):
        flight = random.exponential(size=count) / np.hypot(*v)
        flown = np.minimum(flight, left)
        r += v * flown
        left -= flown
        speed = np.hypot(*v)
        along = v / speed
        y = random.uniform(-1.0, 1.0, count)
        normal = -np.sqrt(1.0 - y**2) * along + y * np.stack([-along[1], along[0]])
        e = np.where(random.random(count) < 0.3, 0.5, 0.9)
        after = v - (1.0 + e) * (v * normal).sum(axis=0) * normal
        v = np.where(left > 0.0, after, v)
    law = CollisionLaw.mixture([0.3, 0.7], [CollisionLaw(0.5), CollisionLaw(0.9)])
    scene = Scene(law, initial=Monoenergetic(), number_density=0.5, times=[t],
                  outputs=("thermal_speed", "msd"))  # fmt: skip
    solution = solve(scene)  # l = 1
    for sample, value in (
        ((v**2).sum(axis=0), solution.thermal_speed[0] ** 2),
        ((r**2).sum(axis=0), solution.msd[0]),
    ):
        assert abs(sample.mean() - value) < 4.0 * sample.std() / count**0.5


def test_densities_of_a_mixture() -> None:
    """From one speed: fronts where either law begins; the density has the moments."""
    law = CollisionLaw.mixture([0.5, 0.5], [CollisionLaw(0.5), CollisionLaw(0.9)])
    outputs = ("speed_density", "thermal_speed")
    scene = Scene(law, initial=Monoenergetic(), number_density=0.5, times=[1.0], outputs=outputs)
    solution = solve(scene)
    assert {0.5, 0.9} <= set(np.round(solution.speed_fronts, 12))
    edges = np.unique(np.clip(np.append(solution.speed_fronts, [1e-3, 1.0]), 1e-3, 1.0))
    node, weight = np.polynomial.legendre.leggauss(40)
    half = 0.5 * np.diff(edges)[:, None]
    v = edges[:-1, None] + half * (node + 1.0)
    f = solution.speed_density(v.ravel()).reshape(v.shape)
    peak = np.exp(-1.0)
    second = float((half * weight * f * v**2).sum())
    assert second + peak == pytest.approx(float(solution.thermal_speed[0]) ** 2, rel=1e-3)
