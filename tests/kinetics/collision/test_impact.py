"""Disks and spheres, smooth and rough: averages against closed forms and mpmath integrals."""

import math
from itertools import product

import mpmath as mp
import numpy as np
import pytest

from kinetics import CollisionLaw, InputError

LIMIT = 1e-13
NORMAL = [0.0, 1e-6, 0.3, 0.7, 0.999, 1.0]
TANGENTIAL = [0.0, 0.01, 0.7, 0.8, 1.0]
LAWS = [(e, et) for e, et in product(NORMAL, TANGENTIAL) if e + et > 0.0]
POWERS = [-0.9, -0.5, 0.5, 1.0, 2.0, 3.7, 40.0]


def relative(found: float, exact: mp.mpf) -> float:
    return float(abs(mp.mpf(found) / exact - 1))


def sphere_decay(e: float, et: float, p: float) -> mp.mpf:
    """1 - E[s^p] of spheres: s^2 is uniform between e^2 and et^2."""
    e, et, p = mp.mpf(e), mp.mpf(et), mp.mpf(p)
    if e == et:
        return 1 - e**p
    return 1 - 2 * (et ** (p + 2) - e ** (p + 2)) / ((p + 2) * (et**2 - e**2))


def decay(e: float, et: float, dimension: int, p: float, m: int) -> mp.mpf:
    """1 - E[s^p cos(m chi)] or 1 - E[s^p P_m(cos chi)], as an integral over y."""
    e, et = mp.mpf(e), mp.mpf(et)

    def kept(y: mp.mpf) -> mp.mpf:
        s = mp.sqrt(e**2 + (et**2 - e**2) * y**2)
        if not s:
            return s
        cosine = (-e + (e + et) * y**2) / s
        angular = mp.chebyt(m, cosine) if dimension == 2 else mp.legendre(m, cosine)
        return (dimension - 1) * y ** (dimension - 2) * s**p * angular

    ends = [0, 1e-6, 1e-3, 0.1, 0.5, 0.9, 0.999, 1 - mp.mpf(10) ** -6, 1]
    return 1 - mp.quad(kept, ends)


@pytest.mark.parametrize(("e", "et"), LAWS)
def test_spheres_against_the_closed_form(e: float, et: float) -> None:
    law = CollisionLaw(e, et, dimension=3)
    with mp.workdps(300):  # E[s^40] may be 1e-240
        for p in POWERS:
            exact = sphere_decay(e, et, p)
            if exact:
                assert relative(law.decay_rate(p), exact) <= LIMIT
            assert relative(law.mean_speed_ratio_power(p), 1 - exact) <= LIMIT


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(
    ("e", "et"),
    [
        (0.0, 0.5),
        (0.9, 0.6),
        *(
            pytest.param(*law, marks=pytest.mark.slow)
            for law in ((0.3, 0.0), (0.3, 0.7), (1.0, 0.5))
        ),
    ],
)
def test_harmonics_against_integrals(e: float, et: float, dimension: int) -> None:
    law = CollisionLaw(e, et, dimension)
    with mp.workdps(30):
        for p, m in [(0.5, 0), (-0.5, 0), (0.0, 1), (2.0, 1), (1.0, 3), (3.0, 7), (-0.5, 2)]:
            exact = decay(e, et, dimension, p, m)
            assert float(abs(law.harmonic_decay_rate(p, m) - exact)) <= LIMIT


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(("e", "et"), [(0.0, 1.0), (0.3, 0.8), (0.8, 0.3), (1.0, 0.4), (0.5, 0.5)])
def test_the_chance_to_lose_more(e: float, et: float, dimension: int) -> None:
    """int P(xi > u) e^(-p u) du = (1 - E[s^p])/p, by partial integration."""
    law = CollisionLaw(e, et, dimension)
    u, weight = law.survival_for(4.0)
    for p in (0.5, 2.0, 3.0):
        found = weight @ np.exp(-p * u)
        assert found == pytest.approx(law.decay_rate(p) / p, rel=1e-13)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(("e", "et"), [(0.0, 1.0), (0.3, 0.8), (0.8, 0.3), (1.0, 0.0), (0.5, 0.5)])
def test_cells_of_the_loss(e: float, et: float, dimension: int) -> None:
    law = CollisionLaw(e, et, dimension)
    q, cell = law.cells(0.05)
    assert q.weight.sum() == pytest.approx(1.0, rel=1e-12)
    assert np.all(q.log_loss >= 0.05 * cell - 1e-9)
    assert np.all((q.log_loss <= 0.05 * (cell + 1) + 1e-9) | (cell == cell.max()))
    assert q.weight @ q.ratio**2 == pytest.approx(law.mean_speed_ratio_power(2.0), rel=1e-9)


@pytest.mark.parametrize(
    ("law", "least", "largest", "lowest", "tail"),
    [
        (CollisionLaw(0.5), 0.0, math.log(2), -math.inf, 1 / 0.75),
        (CollisionLaw(0.5, dimension=3), 0.0, math.log(2), -math.inf, 2 / 0.75),
        (CollisionLaw(0.0), 0.0, math.inf, -1.0, 1.0),
        (CollisionLaw(0.0, dimension=3), 0.0, math.inf, -2.0, 2.0),
        (CollisionLaw(0.5, 0.0), math.log(2), math.inf, -2.0, 0.0),
        (CollisionLaw(0.5, 0.25), math.log(2), math.log(4), -math.inf, 0.0),
        (CollisionLaw(1.0, 0.5, 3), 0.0, math.log(2), -math.inf, 2 / 0.75),
    ],
)
def test_what_kind_of_law_it_is(
    law: CollisionLaw, least: float, largest: float, lowest: float, tail: float
) -> None:
    assert law.least_loss == pytest.approx(least, abs=1e-15)
    assert law.largest_loss == pytest.approx(largest)
    assert law.lowest_power == lowest
    assert law.tail_exponent == pytest.approx(tail)
    assert not law.is_elastic
    assert CollisionLaw(1.0).is_elastic
    assert CollisionLaw(1.0, 0.5).tail_exponent != CollisionLaw(1.0, 0.5).tail_exponent


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        *(({"restitution": e}, "restitution: got ") for e in (-0.1, 1.0000001, math.nan, "x", 1j)),
        ({"restitution": 0.5, "tangential_restitution": 1.5}, "tangential_restitution: got 1.5; "),
        ({"restitution": 0.5, "tangential_restitution": "x"}, "tangential_restitution: got 'x'; "),
        ({"restitution": 0.0, "tangential_restitution": 0.0}, "tangential_restitution: got 0.0; "),
        ({"restitution": 0.5, "dimension": 4}, "dimension: got 4; it must be a whole number"),
        ({"restitution": 0.5, "dimension": 2.0}, "dimension: got 2.0; it must be a whole number"),
    ],
)
def test_what_is_no_law_is_one_line(arguments: dict[str, object], line: str) -> None:
    with pytest.raises(InputError) as caught:
        CollisionLaw(**arguments)  # type: ignore[arg-type]
    assert str(caught.value).startswith(line)
    assert "\n" not in str(caught.value)
    with pytest.raises(InputError, match="above -2"):
        CollisionLaw(0.0, dimension=3).decay_rate(-2.0)
