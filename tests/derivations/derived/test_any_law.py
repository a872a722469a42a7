"""Any collision law, plane and space: the closed forms and the chain of <r^4> by other routes."""

from collections.abc import Callable

import mpmath as mp
import numpy as np
import pytest
import sympy as sp

from derivations import symbols as sy
from derivations import verify
from derivations.derived import any_dimension, any_law, closed_forms
from derivations.premises import contact
from kinetics import CollisionLaw
from kinetics.moments.backward import Observable, quartic_displacement

RANDOM = np.random.default_rng(20241116)
LAWS = [tuple(map(float, pair)) for pair in RANDOM.uniform(0.02, 0.98, (10, 2))]
TOLERANCE = 1e-13  # what the closed forms of the solver promise
ORDERS = [float(order) for order in RANDOM.uniform(-1.5, 9.0, 10)]


def in_space(weight: Callable[[mp.mpf, mp.mpf], mp.mpf], e: float, et: float) -> mp.mpf:
    """The average of weight(s, cos chi) over y^2 uniform on [0, 1], by quadrature."""

    def integrand(u: mp.mpf) -> mp.mpf:
        ratio = mp.sqrt(mp.mpf(e) ** 2 + (mp.mpf(et) ** 2 - mp.mpf(e) ** 2) * u)
        return weight(ratio, (-mp.mpf(e) + (mp.mpf(e) + mp.mpf(et)) * u) / ratio)

    return mp.quad(integrand, mp.linspace(0, 1, 9))


@pytest.mark.parametrize(
    ("closed", "weight"),
    [
        (any_law.space_log_loss, lambda ratio, cosine: -mp.log(ratio)),
        (any_law.space_cosine, lambda ratio, cosine: cosine),
    ],
)
def test_closed_forms_in_space_meet_quadrature(closed, weight) -> None:
    function = sp.lambdify((sy.e, sy.et), closed(), "mpmath")
    with mp.workdps(40):
        for e, et in LAWS:
            # 9 panels of a function that is singular at u = -e^2/(et^2 - e^2), outside [0, 1]
            found = function(mp.mpf(e), mp.mpf(et)) - in_space(weight, e, et)
            assert abs(found) < mp.mpf(10) ** -25


def test_the_power_of_the_speed_ratio_in_space_meets_quadrature() -> None:
    function = sp.lambdify((sy.p, sy.e, sy.et), any_law.space_power(), "mpmath")
    with mp.workdps(40):
        for order, (e, et) in zip(ORDERS, LAWS, strict=True):
            measured = in_space(lambda ratio, cosine, order=order: ratio**order, e, et)
            exact = function(mp.mpf(order), mp.mpf(e), mp.mpf(et))
            assert abs(exact / measured - 1) < mp.mpf(10) ** -25


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_polynomials_of_a_collision_meet_the_rule_in_numbers(dimension: int) -> None:
    normal, angles = contact(dimension)
    square, along = any_law.one_collision(dimension)
    for e, et in LAWS:
        at = dict(zip(angles, RANDOM.uniform(0.1, 1.5, len(angles)), strict=True))
        sigma = np.array(normal.subs(at), dtype=float).ravel()
        velocity = np.eye(dimension)[-1]
        head_on = (velocity @ sigma) * sigma
        after = et * (velocity - head_on) - e * head_on
        values = {sy.e: e, sy.et: et, sy.y: np.sin(at[sy.theta])}
        assert float(square.subs(values)) == pytest.approx(after @ after, rel=1e-13)
        assert float(along.subs(values)) == pytest.approx(after @ velocity, rel=1e-13)


def test_smooth_disks_are_the_law_of_the_paper() -> None:
    (row,) = verify(["beyond:one-collision"])
    square, along = (part.rhs.subs(sy.et, 1) for part in row.derived)
    assert sp.expand(square - closed_forms.speed_ratio_squared()) == 0
    assert sp.expand(along - closed_forms.parallel_component()) == 0
    assert any_law.plane_average(1 - square) == sp.expand(closed_forms.loss_two())


def test_the_scaled_equation_of_spheres_at_e_zero_has_no_residual() -> None:
    gain, lost, rate, residual = any_law.space_e_zero_residual()
    assert residual == 0
    assert gain != lost
    assert rate**2 == sp.limit(any_law.space_cooling_rate() ** 2, sy.e, 0)


def test_the_displacement_of_any_collision_number_meets_a_sum_over_pairs() -> None:
    (row,) = verify(["beyond:any-slope"])
    formula = row.derived[0].rhs
    for flights in (1, 2, 7, 40):
        for cosine in (sp.Rational(-1, 3), sp.Rational(2, 3), sp.Integer(0)):
            lags = np.abs(np.subtract.outer(range(flights), range(flights)))
            pairs = sum(cosine ** int(lag) for lag in lags.ravel()) + flights
            found = formula.subs({sy.N: flights, sy.cos_chi: cosine, sy.l: 1})
            assert found == pairs


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_chain_gives_the_flights_of_at_most_one_collision(dimension: int) -> None:
    chain, flights = any_dimension.one_collision_terms(dimension)
    assert chain == flights
    assert chain[0] == 1
    assert chain[1].has(sy.s, sp.cos(sy.chi))


@pytest.mark.parametrize(("dimension", "gaussian"), [(2, 2), (3, sp.Rational(5, 3))])
def test_the_elastic_chain_tends_to_a_gaussian(dimension: int, gaussian: sp.Expr) -> None:
    late = sp.limit(any_dimension.elastic_transform(dimension) * sy.laplace**3, sy.laplace, 0)
    # <r^4> = late zeta^2/2 and <r^2> = 2 zeta/nu_1
    assert sp.cancel(late / 2 / (2 / sy.nu1) ** 2) == gaussian


def chain_of(top: Observable) -> dict[str, float]:
    """The factors of the solver's chain below <r^4>, by where they stand."""
    ((of_third, third),) = top.sources
    (of_square, square), (of_second, second) = third.sources
    ((of_along, along),) = second.sources
    ((to_square, again),) = square.sources
    assert along == again
    assert (top.harmonic, third.harmonic, second.harmonic, along.harmonic) == (0, 1, 2, 1)
    assert along.constant == 1.0
    return {
        "fourth": of_third, "third from square": of_square, "third from second": of_second,
        "second": of_along, "square": to_square,
    }  # fmt: skip


def derived_chain(dimension: int) -> dict[str, float]:
    """The same factors as they are derived."""
    drive = any_dimension.sources(dimension)
    return {
        "fourth": float(drive[4, 0][3, 1]),
        "third from square": float(drive[3, 1][2, 0]),
        "third from second": float(drive[3, 1][2, 2]),
        "second": float(drive[2, 2][1, 1]),
        "square": float(drive[2, 0][1, 1]),
    }


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_chain_of_the_solver_is_the_derived_one(dimension: int) -> None:
    assert chain_of(quartic_displacement(dimension)) == derived_chain(dimension)


@pytest.mark.parametrize(("e", "et"), LAWS)
def test_the_law_of_the_solver_in_space_meets_the_closed_forms(e: float, et: float) -> None:
    law = CollisionLaw(e, tangential_restitution=et, dimension=3)
    arguments = (sy.p, sy.e, sy.et)
    power, log_loss, cosine = (
        sp.lambdify(arguments, closed(), "mpmath")
        for closed in (any_law.space_power, any_law.space_log_loss, any_law.space_cosine)
    )
    with mp.workdps(40):
        at = mp.mpf(e), mp.mpf(et)
        for order in ORDERS:
            exact = float(power(mp.mpf(order), *at))
            assert law.mean_speed_ratio_power(order) == pytest.approx(exact, rel=TOLERANCE)
        assert law.mean_log_loss == pytest.approx(float(log_loss(0, *at)), rel=TOLERANCE)
        assert law.mean_cosine == pytest.approx(float(cosine(0, *at)), abs=TOLERANCE)


@pytest.mark.parametrize("e", [0.3, 0.8, 1.0])
def test_equal_restitutions_in_the_solver_meet_the_closed_forms(e: float) -> None:
    disks = CollisionLaw(e, tangential_restitution=e)
    (row,) = verify(["beyond:plane-equal"])
    power, log_loss, cosine = (part.rhs.subs({sy.e: e, sy.p: 2.5}) for part in row.derived)
    assert disks.mean_speed_ratio_power(2.5) == pytest.approx(float(power), rel=TOLERANCE)
    assert disks.mean_log_loss == pytest.approx(float(log_loss), rel=TOLERANCE)
    assert disks.mean_cosine == pytest.approx(float(cosine), rel=TOLERANCE)
    spheres = CollisionLaw(e, tangential_restitution=e, dimension=3)
    for order in (1, 2, 3, 4):
        assert spheres.harmonic_decay_rate(0.0, order) == pytest.approx(1.0, abs=TOLERANCE)


def test_the_numbers_of_spheres_that_the_issue_states() -> None:
    (row,) = verify(["beyond:space-cooling"])
    found = [number.value for number in row.numbers]
    assert found == pytest.approx([0.57859, 0.29805, 0.09994], abs=5e-6)
