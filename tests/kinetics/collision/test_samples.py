"""A law of one's own, and mixtures of laws: averages are known; no law is refused."""

import math
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from kinetics import CollisionLaw, ScalingSolution, Scene, solve, solve_field, solve_scaled

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


def test_samples_that_few_nodes_do_not_resolve_do_not_warn() -> None:
    """The first try overflowed, with NumPy's warnings, before nodes were doubled."""
    weight = [0.22124852141751775, 0.6353547857956121, 0.14339669278687014]
    ratio = [0.8758143626156287, 0.9887806325647014, 0.4098700181355197]
    law = CollisionLaw.from_samples(weight, ratio, [0.0, 0.0, 0.0])
    found, exact = solve_scaled(law, 1e-4), ScalingSolution(law)
    assert found.vdf(1.1) == pytest.approx(exact.vdf(1.1), rel=1e-4)


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
    assert math.isnan(CollisionLaw(1.0, 0.5).tail_exponent)
    assert ScalingSolution(joined).cooling_rate == pytest.approx(exact.cooling_rate, rel=1e-13)
