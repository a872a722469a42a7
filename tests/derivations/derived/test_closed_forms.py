"""The closed forms by two routes each, and the numbers of the solver against them."""

import mpmath as mp
import numpy as np
import pytest
import sympy as sp
from scipy.special import k0

from derivations import symbols as sy
from derivations import verify
from derivations.derived import closed_form_values as exact_values
from derivations.derived import closed_forms, position, scaling_state
from derivations.derived import quadrature_values as quadrature
from derivations.formal import Second
from derivations.printed import ROWS
from derivations.symbols import R, e, eta, p
from kinetics import CollisionLaw, ScalingSolution
from kinetics import sonine as printed_numbers

RANDOM = np.random.default_rng(20240607)
RESTITUTIONS = [float(value) for value in RANDOM.uniform(0.02, 0.98, 20)]
EXPONENTS = [float(value) for value in RANDOM.uniform(-0.9, 12.0, 20)]
TOLERANCE = 1e-13  # what the closed forms of the solver promise
# Of the twenty restitutions five by default, in a test for each or together.
EACH = pytest.mark.parametrize(
    "value",
    [*RESTITUTIONS[:5], *(pytest.param(e, marks=pytest.mark.slow) for e in RESTITUTIONS[5:])],
)
MANY = pytest.mark.parametrize("many", [5, pytest.param(20, marks=pytest.mark.slow)])


@MANY
@pytest.mark.parametrize(
    ("closed", "by_quadrature"),
    [
        ("loss_one", lambda z: quadrature.loss_value(1, z)),
        ("loss_two", lambda z: quadrature.loss_value(2, z)),
        ("mean_log_loss", quadrature.log_loss_value),
        ("mean_cosine", quadrature.mean_cosine_value),
    ],
)
def test_closed_forms_meet_quadrature_at_50_digits(closed: str, by_quadrature, many: int) -> None:
    function = sp.lambdify(e, getattr(closed_forms, closed)(), "mpmath")
    with mp.workdps(60):
        for value in RESTITUTIONS[:many]:
            exact, measured = function(mp.mpf(value)), by_quadrature(mp.mpf(value))
            assert abs(exact / measured - 1) < mp.mpf(10) ** -50


@MANY
def test_the_hypergeometric_loss_meets_quadrature_at_50_digits(many: int) -> None:
    function = sp.lambdify((p, e), closed_forms.mean_ratio_power(), "mpmath")
    with mp.workdps(60):
        for order, value in zip(EXPONENTS[:many], RESTITUTIONS[:many], strict=True):
            exact = 1 - function(mp.mpf(order), mp.mpf(value))
            assert abs(exact / quadrature.loss_value(order, mp.mpf(value)) - 1) < mp.mpf(10) ** -50


@MANY
def test_the_integral_of_the_paper_is_the_bessel_function_at_50_digits(many: int) -> None:
    closed = sp.lambdify((R, eta), position.closed_form(), "mpmath")
    radii, widths = RANDOM.uniform(0.05, 6, many), RANDOM.uniform(0.1, 2, many)
    with mp.workdps(60):
        for radius, width in zip(map(mp.mpf, radii), map(mp.mpf, widths), strict=True):
            # V = exp(u): the integrand is then even in u about its saddle, for the trapezoid rule
            centre, step = mp.log(radius**2 / (2 * width)) / 4, mp.mpf(1) / 64
            root = mp.exp(2 * centre)
            total = mp.fsum(
                mp.exp(-2 * root * mp.cosh(2 * step * index)) for index in range(-320, 321)
            )
            integral = 2 * radius / width * step * total
            assert abs(integral / closed(radius, width) - 1) < mp.mpf(10) ** -50


def test_the_series_of_the_cooling_rate_meet_it() -> None:
    with mp.workdps(40):
        small = mp.mpf(10) ** -4
        stated = mp.sqrt(2) * (
            1
            - mp.pi * small / 4
            + small**2 * (mp.mpf(1) / 2 - mp.pi**2 / 32 - mp.log(2) / 2 + mp.log(small) / 2)
        )
        # the next order is e^3 ln e
        assert abs(exact_values.cooling_rate(small) - stated) < 20 * small**3
        near = exact_values.cooling_rate(1 - small) / small
        assert abs(near - mp.mpf(4) / 3 - 2 * small / 15 - 2 * small**2 / 175) < small**3


def test_the_tail_of_the_moments_has_the_derived_power() -> None:
    # E[Y^(p+1)]/E[Y^p] = p/lambda(p) = p + 1/(1 - e^2) + O(1/p)
    for value in (0.2, 0.6):
        gaps = [
            mp.mpf(order) / exact_values.decay_rate(order, value)
            - order
            - 1 / (1 - mp.mpf(value) ** 2)
            for order in (200, 400)
        ]
        assert abs(gaps[1]) < 0.02
        assert gaps[0] / gaps[1] == pytest.approx(2, rel=0.05)


def relative(number: float, twin: mp.mpf) -> float:
    return abs(float(mp.mpf(float(number)) / twin - 1))


@EACH
def test_the_collision_law_meets_its_twin(value: float) -> None:
    law = CollisionLaw(restitution=value)
    with mp.workdps(40):
        for order in EXPONENTS[:5]:
            power = exact_values.mean_speed_ratio_power(order, value)
            assert relative(law.mean_speed_ratio_power(order), power) < TOLERANCE
            assert (
                relative(law.decay_rate(order), exact_values.decay_rate(order, value)) < TOLERANCE
            )
        assert relative(law.mean_log_loss, exact_values.mean_log_loss(value)) < TOLERANCE
        flux = quadrature.flux_loss_value(EXPONENTS[0], mp.mpf(value))
        assert relative(law.harmonic_decay_rate(EXPONENTS[0], 1), flux) < TOLERANCE
        # <cos chi> has a zero in e: absolute, it is of order one
        assert abs(law.mean_cosine - exact_values.mean_cosine(value)) < TOLERANCE


@EACH
def test_the_scaling_solution_meets_its_twin(value: float) -> None:
    exact = ScalingSolution(value)
    with mp.workdps(40):
        assert relative(exact.cooling_rate, exact_values.cooling_rate(value)) < TOLERANCE
        assert relative(exact.diffusion_slope, exact_values.diffusion_slope(value)) < TOLERANCE
        assert abs(exact.a2 - exact_values.a2(value)) < TOLERANCE * (
            1 + abs(exact_values.a2(value))
        )
        assert relative(exact.tail_rate, 2 / exact_values.cooling_rate(value)) < TOLERANCE
        assert exact.tail_power == pytest.approx(1 / (1 - value**2) - 2, rel=TOLERANCE)


@pytest.mark.parametrize(
    "index", [0, 9, *(pytest.param(k, marks=pytest.mark.slow) for k in (3, 6, 12, 15, 18))]
)
def test_the_moments_meet_their_twin(index: int) -> None:
    value = RESTITUTIONS[index]
    with mp.workdps(30):
        for order in (EXPONENTS[index], EXPONENTS[(index + 1) % 20], -1.5):
            twin = exact_values.moment(order, value)
            assert relative(ScalingSolution(value).moment(order), twin) < TOLERANCE


def lambdified(label: str, *arguments: sp.Symbol, at: dict[sp.Expr, sp.Expr] | None = None):
    """The right-hand side of a derived formula as a numpy function of some of its symbols."""
    (check,) = verify([label])
    return sp.lambdify(arguments, check.derived.rhs.subs(at or {}), "numpy")


def test_the_first_sonine_order_of_the_solver_meets_the_derived_one() -> None:
    law = printed_numbers
    e_above = RANDOM.uniform(0.59, 0.99, 20)
    coefficients = RANDOM.uniform(-0.4, 0.4, 20)
    thermal = RANDOM.uniform(0.1, 2, 20)
    system = {sy.T(sy.t): sy.v**2 / 2, sy.m: 1, sy.d: 1, sy.rho0: sp.Rational(1, 25)}
    pairs = [
        (law.m2(e_above, coefficients), lambdified("sonine9", e, sy.a2)(e_above, coefficients)),
        (law.m4(e_above, coefficients), lambdified("sonine10", e, sy.a2)(e_above, coefficients)),
        (law.a2(e_above), lambdified("sonine12", e)(e_above)),
        (law.cooling_rate(e_above), lambdified("compare3", e)(e_above) / 2),
        (
            law.stability(e_above),
            lambdified("ac7", e, sy.a2bar)(e_above, lambdified("sonine12", e)(e_above)),
        ),
        (
            law.diffusion_rate(thermal, e_above, coefficients),
            lambdified("ad6", e, sy.a2, sy.v, at=system)(e_above, coefficients, thermal),
        ),
        (
            law.diffusion_coefficient(thermal, e_above, coefficients),
            lambdified("ad7", e, sy.a2, sy.v, at=system)(e_above, coefficients, thermal),
        ),
        (
            law.msd_sonine(thermal * 100, e_above),
            lambdified("ad8#2", e, sy.a2, sy.t, at=system)(
                e_above, lambdified("sonine12", e)(e_above), thermal * 100
            ),
        ),
    ]
    for ours, derived in pairs:
        np.testing.assert_allclose(ours, derived, rtol=TOLERANCE, atol=TOLERANCE)


def stated(label: str, *arguments: sp.Symbol, at: dict[sp.Expr, sp.Expr] | None = None):
    """The right-hand side of a printed formula as a numpy function of some of its symbols."""
    formula = ROWS[label].formula
    side = formula[-1].rhs if isinstance(formula, sp.Tuple) else formula.rhs
    return sp.lambdify(arguments, side.subs(at or {}).doit(), "numpy")


def test_the_printed_curves_of_the_solver_meet_the_printed_formulas() -> None:
    law = printed_numbers
    time, value = RANDOM.uniform(1, 3000, 20), RANDOM.uniform(0.1, 0.95, 20)
    start = sp.sqrt(2)
    fitted = sp.Rational(145, 100) * (1 - e)
    walk = {
        sy.alpha: 1 / start,
        sy.beta: fitted / 25,
        sy.l: sp.Rational(27, 2),
        sy.v0(0): start,
        sy.d: 1,
        sy.rho0: sp.Rational(1, 25),
        sy.h: fitted,
    }
    radii = RANDOM.uniform(0.3, 6, 20)
    saddle = stated("csolu", R, eta)(radii, 0.25)
    exponent, curvature = (
        sp.lambdify((sy.V, R, eta), part)
        for part in (
            ROWS["pdefi"].formula.rhs,
            sp.diff(ROWS["pdefi"].formula.rhs, sy.V, 2),
        )
    )
    fit = {sy.gamma: sp.Rational(739, 100), eta: sp.Rational(1, 4)}
    bend, height = sp.symbols("bend height")
    tail = ROWS["gammatailg"].formula.rhs.subs(fit)
    tail = tail.subs({Second(sy.pd(sy.V, R), sy.V, sy.Vs): bend, sy.pd(sy.Vs, R): height})
    pairs = [
        (law.cooling_rate_fitted(value), stated("hsimu", e)(value)),
        (
            law.thermal_speed(time, law.cooling_rate_fitted(value)),
            stated("veq", e, sy.t, at=walk)(value, time),
        ),
        (law.msd_random_walk(time, value), stated("msd", e, sy.t, at=walk)(value, time)),
        (
            law.position_given_speed(radii, 0.75, 0.6),
            stated("posivel", R, eta, sy.V)(radii, 0.75, 0.6),
        ),
        (
            law.position_peak(radii),
            stated("peakg", R, eta, sy.Vbar)(radii, 0.75, np.sqrt(0.5)),
        ),
        (law.position_far_tail(radii, 0.25), stated("semig", R, eta)(radii, 0.25)),
        (
            law.position_tail(radii),
            sp.lambdify((R, bend, height), tail, "numpy")(
                radii, curvature(saddle, radii, 0.25), exponent(saddle, radii, 0.25)
            ),
        ),
        (
            law.vdf(radii / 3, 0.3),
            np.exp(-((radii / 3) ** 2))
            / np.pi
            * (1 + 0.3 * stated("sonine2", sy.x)((radii / 3) ** 2)),
        ),
    ]
    for ours, theirs in pairs:
        np.testing.assert_allclose(ours, theirs, rtol=TOLERANCE)
    assert (
        pytest.approx(float(ROWS["compare1"].formula.lhs), rel=TOLERANCE)
        == law.THRESHOLD_RESTITUTION
    )


def test_the_tail_amplitude_is_that_of_the_exponential_at_e_zero() -> None:
    with mp.workdps(40):
        # F = exp(-sqrt(2) c)/(sqrt(2) pi c)
        assert abs(exact_values.log_tail_amplitude(0) + mp.log(mp.sqrt(2) * mp.pi)) < 1e-20


def test_the_scaled_vdf_of_the_solver_at_e_zero_is_the_derived_one() -> None:
    speeds = RANDOM.uniform(0.05, 12, 20)
    derived = sp.lambdify(sy.c, scaling_state.e_zero_solution(), "numpy")(speeds)
    np.testing.assert_allclose(ScalingSolution(0.0).vdf(speeds), derived, rtol=TOLERANCE)
    gain, loss, residual = scaling_state.e_zero_residual()
    assert residual == 0
    assert gain != loss


def test_the_position_curves_of_the_solver_meet_the_derived_ones() -> None:
    radii = RANDOM.uniform(0.1, 5, 20)
    for width in (0.25, 0.5, 0.75):
        bessel = 2 * radii / width * k0(radii * np.sqrt(2 / width))
        closed = sp.lambdify((R, eta), position.closed_form(), "mpmath")
        derived = [float(closed(radius, width)) for radius in radii]
        np.testing.assert_allclose(bessel, derived, rtol=TOLERANCE)
        np.testing.assert_allclose(
            printed_numbers.position_integral(radii, width), derived, rtol=TOLERANCE
        )
