"""A law of one's own: the samples of a known law give its averages; no law is refused."""

import pickle

import numpy as np
import pytest
from numpy.typing import ArrayLike

from kinetics import CollisionLaw, InputError

GIVEN = ([0.25, 0.75], [0.5, 0.9], [0.3, -1.0])


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_nodes_of_a_law_are_that_law(dimension: int) -> None:
    law = CollisionLaw(0.4, 0.8, dimension)
    q = law.quadrature_for(10.0, 4)
    own = CollisionLaw.from_samples(q.weight, q.ratio, q.cosine, dimension)
    for p, m in [(0.5, 0), (2.0, 0), (1.0, 1), (3.0, 4)]:
        same = pytest.approx(law.harmonic_decay_rate(p, m), rel=1e-13)
        assert own.harmonic_decay_rate(p, m) == same
    assert own.mean_log_loss == pytest.approx(law.mean_log_loss, rel=1e-14)
    assert own.mean_cosine == pytest.approx(law.mean_cosine, rel=1e-13)


def test_two_laws_mix_by_joining_their_samples() -> None:
    one, other = CollisionLaw(0.9).quadrature, CollisionLaw(0.2).quadrature
    mixed = CollisionLaw.from_samples(
        np.concatenate([0.3 * one.weight, 0.7 * other.weight]),
        np.concatenate([one.ratio, other.ratio]),
        np.concatenate([one.cosine, other.cosine]),
    )
    expected = 0.3 * CollisionLaw(0.9).decay_rate(2.0) + 0.7 * CollisionLaw(0.2).decay_rate(2.0)
    assert mixed.decay_rate(2.0) == pytest.approx(expected, rel=1e-13)


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


def test_a_law_is_a_value() -> None:
    law = CollisionLaw.from_samples(*GIVEN)
    assert law == CollisionLaw.from_samples(*GIVEN)
    assert hash(law) == hash(CollisionLaw.from_samples(*GIVEN))
    assert law != CollisionLaw.from_samples(*GIVEN, dimension=3)
    assert pickle.loads(pickle.dumps(law)) == law
    assert repr(law) == "CollisionLaw.from_samples(2 samples, dimension=2)"
    assert repr(CollisionLaw(0.5, 0.8, 3)) == (
        "CollisionLaw(restitution=0.5, tangential_restitution=0.8, dimension=3)"
    )


@pytest.mark.parametrize(
    ("samples", "line"),
    [
        (([-0.1, 1.1], [0.5, 0.9], [0.0, 0.0]), "weight: got -0.1; weights must not be negative"),
        (([0.5, 0.4], [0.5, 0.9], [0.0, 0.0]), "weight: got "),
        (([0.5, 0.5], [0.0, 0.9], [0.0, 0.0]), "ratio: got 0.0; speed ratios must be above 0"),
        (([0.5, 0.5], [0.5, 0.9], [0.0, 1.1]), "cosine: got 1.1; it must be from -1 to 1"),
        (([0.5, 0.5], [0.5], [0.0, 1.0]), "ratio: got "),
        (([], [], []), "weight: got "),
        (([1.0], [np.nan], [0.0]), "ratio: got "),
        (([1.0], [0.5], ["x"]), "cosine: got "),
    ],
)
def test_what_is_no_law_is_one_line(samples: tuple[ArrayLike, ...], line: str) -> None:
    with pytest.raises(InputError) as caught:
        CollisionLaw.from_samples(*samples)
    assert str(caught.value).startswith(line)
    assert "\n" not in str(caught.value)
