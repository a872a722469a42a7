"""The derived formulas by a second route in numbers, and the numbers of the solver against them."""

import math
from collections.abc import Callable

import mpmath as mp
import numpy as np
import pytest
import sympy as sp
from scipy.special import j0

from derivations import symbols as sy
from derivations.derived import (
    any_dimension,
    any_law,
    finite_density,
    position,
    scaling_state,
    steepest_descent,
)
from derivations.derived.driven import bath_rates
from derivations.derived.uniform_field import field_row
from derivations.formal import Second
from derivations.premises import loss
from derivations.printed import ROWS, printed_equation
from derivations.symbols import R, e, eta, p
from kinetics import CollisionLaw, ScalingSolution
from kinetics import sonine as printed_numbers
from kinetics.collision import law_in_medium
from kinetics.drive import Drive
from kinetics.driven.chebyshev_axis import ChebyshevSpeedAxis
from kinetics.driven.generator import Generator
from kinetics.driven.resolution import ChebyshevResolution
from kinetics.moments.observables import Observable, quartic_displacement

RANDOM = np.random.default_rng(20240607)
RESTITUTIONS = [float(value) for value in RANDOM.uniform(0.02, 0.98, 5)]
EXPONENTS = [float(value) for value in RANDOM.uniform(-0.9, 12.0, 5)]
LAWS = [tuple(map(float, pair)) for pair in RANDOM.uniform(0.02, 0.98, (10, 2))]
TOLERANCE = 1e-13  # what the closed forms of the solver promise


def average(weight: Callable, restitution: mp.mpf) -> mp.mpf:
    """E over the impact parameter of a function of the speed ratio s and of s cos(chi)."""

    def integrand(y: mp.mpf) -> mp.mpf:
        square = restitution**2 + (1 - restitution**2) * y * y
        return weight(mp.sqrt(square), -restitution + (1 + restitution) * y * y)

    points = (restitution / 4, restitution, 4 * restitution)  # s leaves e there
    return mp.quad(integrand, [0, *(x for x in points if x < 0.5), 1])


def test_closed_forms_meet_quadrature_at_50_digits() -> None:
    power = scaling_state.mean_ratio_power()
    forms: list[tuple[sp.Expr, Callable]] = [
        (scaling_state.loss_one(), lambda s, along: 1 - s),
        (loss(2), lambda s, along: 1 - s * s),
        (scaling_state.mean_log_loss(), lambda s, along: -mp.log(s)),
        (scaling_state.mean_cosine(), lambda s, along: along / s),
    ]
    for n in map(sp.Rational, EXPONENTS):
        forms.append((power.subs(p, n), lambda s, along, n=n: s ** (mp.mpf(n.p) / n.q)))
    with mp.workdps(60):
        for closed, weight in forms:
            function = sp.lambdify(e, closed, "mpmath")
            for value in map(mp.mpf, RESTITUTIONS):
                assert abs(function(value) / average(weight, value) - 1) < mp.mpf(10) ** -50


def test_the_integral_of_the_paper_is_the_bessel_function_at_50_digits() -> None:
    closed_form = sp.lambdify((R, eta), position.closed_form(), "mpmath")
    random = np.random.default_rng(1)
    radii = random.uniform(0.05, 6, 5)
    widths = random.uniform(0.1, 2, 5)
    with mp.workdps(60):
        for radius, width in zip(map(mp.mpf, radii), map(mp.mpf, widths), strict=True):
            # V = exp(u): the integrand is then even in u about its saddle, for the trapezoid rule
            root = mp.sqrt(radius**2 / (2 * width))
            step = mp.mpf(1) / 64
            total = mp.fsum(mp.exp(-2 * root * mp.cosh(2 * step * k)) for k in range(-320, 321))
            integral = 2 * radius / width * step * total
            assert abs(integral / closed_form(radius, width) - 1) < mp.mpf(10) ** -50


def test_far_out_the_integral_of_the_paper_is_its_tail_by_steepest_descent() -> None:
    closed_form = sp.lambdify((R, eta), position.closed_form(), "mpmath")
    tail = sp.lambdify((R, eta), steepest_descent.tail(), "mpmath")
    radius = 10**7
    with mp.workdps(60):
        for width in (0.1, 0.5, 2.0):
            # the next term is smaller by 1/R
            assert abs(tail(radius, width) / closed_form(radius, width) - 1) < 1e-6


def test_the_position_integral_of_the_solver_is_the_derived_one() -> None:
    closed_form = sp.lambdify((R, eta), position.closed_form(), "mpmath")
    random = np.random.default_rng(2)
    radii = random.uniform(0.05, 6, 5)
    widths = random.uniform(0.1, 2, 5)
    derived = [float(closed_form(r, w)) for r, w in zip(radii, widths, strict=True)]
    solver = printed_numbers.position_integral(radii, widths)
    np.testing.assert_allclose(solver, derived, rtol=TOLERANCE)


def squared_cooling_rate(restitution: mp.mpf) -> mp.mpf:
    """h^2 = 4 kappa lambda(1) by quadrature."""
    log_loss = average(lambda s, _: -mp.log(s), restitution)
    speed_loss = average(lambda s, _: 1 - s, restitution)
    return 4 * log_loss * speed_loss


def test_the_series_of_the_cooling_rate_at_small_restitution(rows) -> None:
    series = sp.lambdify(e, rows["beyond:cooling-small-e"].derived.rhs, "mpmath")
    with mp.workdps(40):
        restitution = mp.mpf(10) ** -4
        exact = mp.sqrt(squared_cooling_rate(restitution))
        # the next term is of the order e^3 ln e
        assert abs(exact - series(restitution)) < 20 * restitution**3


def test_the_series_of_the_cooling_rate_near_the_elastic_gas(rows) -> None:
    series = sp.lambdify(sy.gap, rows["beyond:cooling-near-1"].derived.rhs, "mpmath")
    with mp.workdps(40):
        gap = mp.mpf(10) ** -4
        exact = mp.sqrt(squared_cooling_rate(1 - gap)) / gap
        assert abs(exact - series(gap)) < gap**3  # the next term is of that order


@pytest.mark.parametrize("restitution", [0.2, 0.6])
def test_the_ratio_of_high_moments_is_that_of_the_derived_tail(restitution: float) -> None:
    """E[Y^(p+1)]/E[Y^p] = p/lambda(p) = p + 1/(1 - e^2) + O(1/p)."""

    def difference(order: int) -> float:
        loss_of_order = average(lambda s, _: 1 - s**order, mp.mpf(restitution))
        return float(order / loss_of_order - order - 1 / (1 - restitution**2))

    assert abs(difference(400)) < 0.02  # of the order 1/p
    assert difference(200) / difference(400) == pytest.approx(2, rel=0.05)


@pytest.mark.parametrize("value", RESTITUTIONS[:3])
def test_the_averages_of_the_solver_are_the_derived_ones(value: float) -> None:
    law = CollisionLaw(restitution=value)
    exact = ScalingSolution(value)
    seventh_moment = scaling_state.moment(7) / scaling_state.moment(2) ** sp.Rational(7, 2)
    for solver, formula in [
        (law.mean_log_loss, sy.klog),
        (law.mean_cosine, sy.cos_chi),
        (law.decay_rate(2.5), sy.lam(2.5)),
        (exact.cooling_rate, scaling_state.cooling_rate()),
        (exact.diffusion_slope, scaling_state.slope()),
        (exact.a2, scaling_state.a2()),
        (exact.moment(7), seventh_moment),
    ]:
        derived = float(scaling_state.exact_value(formula, value))
        assert solver == pytest.approx(derived, rel=TOLERANCE, abs=TOLERANCE)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_scaled_vdf_of_the_solver_at_e_zero_is_the_derived_one(dimension: int) -> None:
    speeds = np.random.default_rng(3).uniform(0.05, 12, 20)
    derived = sp.lambdify(sy.c, any_law.e_zero_solution(dimension), "numpy")(speeds)
    solver = ScalingSolution(0.0, dimension=dimension).vdf(speeds)
    np.testing.assert_allclose(solver, derived, rtol=TOLERANCE)


# -- the paper's approximations --


def test_the_first_sonine_order_of_the_solver_meets_the_derived_one(rows) -> None:
    def of(label: str, *arguments: sp.Symbol):
        system = {sy.T(sy.t): sy.v**2 / 2, sy.m: 1, sy.d: 1, sy.rho0: sp.Rational(1, 25)}
        return sp.lambdify(arguments, rows[label].derived.rhs.subs(system), "numpy")

    law = printed_numbers
    random = np.random.default_rng(4)
    above = random.uniform(0.59, 0.99, 20)  # restitutions above the threshold of a_2
    a2 = random.uniform(-0.4, 0.4, 20)
    thermal = random.uniform(0.1, 2, 20)
    root = of("sonine12", e)(above)
    for solver, derived in [
        (law.m2(above, a2), of("sonine9", e, sy.a2)(above, a2)),
        (law.m4(above, a2), of("sonine10", e, sy.a2)(above, a2)),
        (law.a2(above), root),
        (law.cooling_rate(above), of("compare3", e)(above) / 2),
        (law.stability(above), of("ac7", e, sy.a2bar)(above, root)),
        (law.diffusion_rate(thermal, above, a2), of("ad6", e, sy.a2, sy.v)(above, a2, thermal)),
        (
            law.diffusion_coefficient(thermal, above, a2),
            of("ad7", e, sy.a2, sy.v)(above, a2, thermal),
        ),
        (
            law.msd_sonine(thermal * 100, above),
            of("ad8#2", e, sy.a2, sy.t)(above, root, thermal * 100),
        ),
    ]:
        np.testing.assert_allclose(solver, derived, rtol=TOLERANCE, atol=TOLERANCE)


def test_the_printed_curves_of_the_solver_meet_the_printed_formulas() -> None:
    fitted = sp.Rational(145, 100) * (1 - e)
    start = sp.sqrt(2)
    walk = {
        sy.alpha: 1 / start,
        sy.beta: fitted / 25,
        sy.l: sp.Rational(27, 2),
        sy.v0(0): start,
        sy.d: 1,
        sy.rho0: sp.Rational(1, 25),
        sy.h: fitted,
    }

    def of(label: str, *arguments: sp.Symbol, system=None):
        formula = ROWS[label].formula
        if isinstance(formula, sp.Tuple):
            formula = formula[-1]
        return sp.lambdify(arguments, formula.rhs.subs(system or {}).doit(), "numpy")

    other_walk = {sy.alpha: sp.Rational(5, 6), sy.beta: sp.Rational(3, 200), sy.l: 3}
    law = printed_numbers
    random = np.random.default_rng(5)
    radii = random.uniform(0.3, 6, 20)
    time = random.uniform(1, 3000, 20)
    value = random.uniform(0.1, 0.95, 20)
    saddle = of("csolu", R, eta)(radii, 0.25)
    exponent = ROWS["pdefi"].formula.rhs
    height, bend = sp.symbols("height bend")
    pieces = {Second(sy.pd(sy.V, R), sy.V, sy.Vs): bend, sy.pd(sy.Vs, R): height}
    pieces |= {sy.gamma: sp.Rational(739, 100), eta: sp.Rational(1, 4)}
    at_saddle = [
        sp.lambdify((sy.V, R, eta), function)(saddle, radii, 0.25)
        for function in (exponent, sp.diff(exponent, sy.V, 2))
    ]
    tail = sp.lambdify((R, height, bend), ROWS["gammatailg"].formula.rhs.subs(pieces), "numpy")
    rate = of("hsimu", e)(value)
    shape = 1 + 0.3 * of("sonine2", sy.x)((radii / 3) ** 2)
    for solver, printed in [
        (law.cooling_rate_fitted(value), rate),
        (law.thermal_speed(time, rate), of("veq", e, sy.t, system=walk)(value, time)),
        (law.msd_random_walk(time, value), of("msd", e, sy.t, system=walk)(value, time)),
        (
            law.msd_random_walk(time, 1, 0.1, 0.5, 3.0, 1.2, 0.3),
            of("msd", sy.t, system=other_walk)(time),
        ),
        (law.position_given_speed(radii, 0.75, 0.6), of("posivel", R, eta, sy.V)(radii, 0.75, 0.6)),
        (law.position_peak(radii), of("peakg", R, eta, sy.Vbar)(radii, 0.75, np.sqrt(0.5))),
        (law.position_far_tail(radii, 0.25), of("semig", R, eta)(radii, 0.25)),
        (law.position_tail(radii), tail(radii, *at_saddle)),
        (law.vdf(radii / 3, 0.3), np.exp(-((radii / 3) ** 2)) / np.pi * shape),
        (law.THRESHOLD_RESTITUTION, float(ROWS["compare1"].formula.lhs)),
    ]:
        np.testing.assert_allclose(solver, printed, rtol=TOLERANCE)


# -- any collision law --


@pytest.mark.parametrize(("e_", "et"), LAWS)
def test_closed_forms_in_space_meet_quadrature_and_the_solver(e_: float, et: float) -> None:
    law = CollisionLaw(e_, tangential_restitution=et, dimension=3)
    order = EXPONENTS[0]

    def average(weight) -> float:
        """Over y^2 uniform on [0, 1], of a function of s and cos(chi)."""

        def integrand(u: mp.mpf) -> mp.mpf:
            ratio = mp.sqrt(e_**2 + (et**2 - e_**2) * u)
            return weight(ratio, (-e_ + (e_ + et) * u) / ratio)

        return float(mp.quad(integrand, mp.linspace(0, 1, 9)))

    for closed, solver, weight in (
        (any_law.space_power(), law.mean_speed_ratio_power(order), lambda s, cosine: s**order),
        (any_law.space_log_loss(), law.mean_log_loss, lambda s, cosine: -mp.log(s)),
        (any_law.space_cosine(), law.mean_cosine, lambda s, cosine: cosine),
    ):
        with mp.workdps(30):
            function = sp.lambdify((p, e, sy.et), closed, "mpmath")
            exact = float(function(mp.mpf(order), mp.mpf(e_), mp.mpf(et)))
        assert solver == pytest.approx(exact, rel=TOLERANCE, abs=TOLERANCE)
        assert average(weight) == pytest.approx(exact, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("value", [0.3, 0.8, 1.0])
def test_disks_with_equal_restitutions_are_as_derived(rows, value: float) -> None:
    disks = CollisionLaw(value, tangential_restitution=value)
    solver = [disks.mean_speed_ratio_power(2.5), disks.mean_log_loss, disks.mean_cosine]
    equations = rows["beyond:plane-equal"].derived
    derived = [float(equation.rhs.subs({e: value, p: 2.5})) for equation in equations]
    assert solver == pytest.approx(derived, rel=TOLERANCE)


@pytest.mark.parametrize("value", [0.3, 0.8, 1.0])
def test_spheres_with_equal_restitutions_scatter_isotropically(value: float) -> None:
    spheres = CollisionLaw(value, tangential_restitution=value, dimension=3)
    for order in (1, 2, 3, 4):
        assert spheres.harmonic_decay_rate(0.0, order) == pytest.approx(1.0, abs=TOLERANCE)


@pytest.mark.parametrize(("dimension", "gaussian"), [(2, 2), (3, sp.Rational(5, 3))])
def test_the_elastic_chain_tends_to_a_gaussian(dimension: int, gaussian: sp.Expr) -> None:
    late = sp.limit(any_dimension.elastic_transform(dimension) * sy.laplace**3, sy.laplace, 0)
    # <r^4> = late zeta^2/2 and <r^2> = 2 zeta/nu_1
    assert sp.cancel(late / 2 / (2 / sy.nu1) ** 2) == gaussian


def test_the_density_of_isotropic_scattering_in_the_plane_has_that_transform(rows) -> None:
    transform, density = (equation.rhs for equation in rows["beyond:isotropic-plane"].derived)
    ring = sp.exp(-sy.zeta) * sy.delta(sy.r - sy.zeta)
    spread = sp.lambdify((sy.r, sy.zeta), density - ring, "numpy")
    x, weight = np.polynomial.legendre.leggauss(100)
    time = 20.0 * (1.0 + x)
    angle = np.pi / 4 * (1.0 + x[:, None])
    radius = time * np.sin(angle)  # the density is infinite at r = zeta
    inside = spread(radius, time) * time * np.cos(angle) * j0(1.3 * radius)
    over_radii = np.exp(-time) * j0(1.3 * time) + np.pi / 4 * weight @ inside
    quadrature = 20.0 * weight @ (np.exp(-time) * over_radii)
    derived = float(transform.subs({sy.wave: 1.3, sy.laplace: 1}))
    assert quadrature == pytest.approx(derived, rel=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_chain_of_the_solver_is_the_derived_one(dimension: int) -> None:
    top: Observable = quartic_displacement(dimension)
    ((third_in_top, third),) = top.sources
    (square_in_third, square), (second_in_third, second) = third.sources
    ((along_in_second, along),) = second.sources
    ((along_in_square, along_again),) = square.sources
    assert along == along_again
    assert (top.harmonic, third.harmonic, second.harmonic, along.harmonic) == (0, 1, 2, 1)
    assert along.constant == 1.0
    derived = any_dimension.sources(dimension)
    assert third_in_top == float(derived[4, 0][3, 1])
    assert square_in_third == float(derived[3, 1][2, 0])
    assert second_in_third == float(derived[3, 1][2, 2])
    assert along_in_second == float(derived[2, 2][1, 1])
    assert along_in_square == float(derived[2, 0][1, 1])


# -- scatterers that are met again, and a uniform field --


@pytest.mark.parametrize("value", [0.3, 0.7, 1.0])
def test_the_density_of_deflections_straight_back_is_that_of_bounces(value: float) -> None:
    y = np.random.default_rng(17).uniform(-1.0, 1.0, 2_000_000)
    cosine = (-value + (1 + value) * y**2) / np.sqrt(value**2 + (1 - value**2) * y**2)
    window = 0.05  # radians to each side
    density = np.mean(cosine < -math.cos(window)) / (2 * window)
    derived = float(finite_density.straight_back().subs(e, value))
    assert density == pytest.approx(derived, rel=0.02)  # three standard errors at e = 0.3


@pytest.mark.parametrize("value", [0.3, 0.7, 1.0])
def test_the_operator_of_returns_of_the_solver_is_the_derived_one(value: float) -> None:
    n = 0.05
    law = law_in_medium(CollisionLaw(value), "overlapping", n, 1.0, "leading")
    # the derived chance counts from d to l; the solver's logarithm is ln(1/n)
    length = sp.Symbol("length", positive=True)
    chance = sp.integrate(finite_density.return_chance(), (sy.dist, 1, length))
    chance = float(chance.subs({e: value, sy.d: 1, sy.rho0: n, length: 1 / n}))
    _, summed = finite_density.return_symbols()
    for m, order in [(0, 1.0), (1, 0.0), (1, 2.5), (2, 3.0)]:
        rate = CollisionLaw(value).harmonic_decay_rate(order, m)
        case = {sy.harm: m, p: order, e: value, sy.lamm: rate, sy.ret: chance}
        derived = pytest.approx(float(summed.subs(case)), rel=1e-13, abs=1e-15)
        assert law.harmonic_decay_rate(order, m) == derived


def test_the_area_that_two_circles_share() -> None:
    x, y = np.random.default_rng(17).uniform(-1.0, 2.0, (2, 1_000_000))
    is_inside = (x**2 + y**2 < 1) & ((x - 1) ** 2 + y**2 < 1)
    derived = float(finite_density.shared_area().subs(sy.d, 1))
    assert 9 * is_inside.mean() == pytest.approx(derived, rel=0.01)  # four standard errors


@pytest.mark.parametrize(("order", "wave"), [(0, 0.7), (1, 3.0), (4, 2.0)])
def test_a_free_flight_in_fourier_space(rows, order: int, wave: float) -> None:
    angle = (np.arange(400) + 0.5) * np.pi / 400
    quadrature = np.mean(np.cos(order * angle) / (1 + 1j * wave * np.cos(angle)))
    formula = rows["beyond:free-flight"].derived.rhs
    derived = complex(formula.subs({sy.harm: order, sy.wave: wave}))
    assert derived == pytest.approx(complex(quadrature), abs=1e-12)


def test_the_corridor_of_the_way_back(rows) -> None:
    """Per path the strips of width 2 d sweep 2 d; both cover what is within d of one of them."""
    rate = float(rows["beyond:corridor"].derived[0].rhs.subs(sy.offset, 1.4))
    assert rate == pytest.approx(1 + 1.4 / 2 / 2, rel=1e-6)


def test_the_transform_of_near_pairs_in_numbers(rows) -> None:
    case = {sy.rho0: 0.04, sy.d: 1, e: 0.7, sy.loop0: 0.05, sy.lost: 0.6, sy.pathz: 1.3}
    derived = float(rows["beyond:return-delay"].derived[0].rhs.subs(case))
    y = np.exp(np.linspace(np.log(0.05), 4.0, 20001))
    exact = np.trapezoid(np.exp(-0.6 * y - 1.3 * (y - 0.05)), np.log(y))
    assert derived == pytest.approx(2 * 0.7 / 1.7 * 0.04 * exact, rel=1e-7)


@pytest.mark.parametrize(("dimension", "m"), [(d, m) for d in (2, 3) for m in (0, 1, 2)])
def test_rows_of_the_field_against_a_function_of_the_vector(dimension: int, m: int) -> None:
    """f = v_z^3 + v^2 v_z has the harmonics 1 and 3; its derivative by v_z is 5 v_z^2 + v^2."""
    if dimension == 2:
        cosine, weight = np.cos((np.arange(64) + 0.5) * math.pi / 64), np.full(64, 1 / 64)
    else:
        cosine, weight = np.polynomial.legendre.leggauss(20)
    family = np.polynomial.Chebyshev if dimension == 2 else np.polynomial.Legendre

    def harmonic(values: np.ndarray, k: int) -> float:
        basis = family.basis(k)(cosine)
        return float((values * basis) @ weight / ((basis**2) @ weight))

    v = 1.3
    shape = {}
    for k, f_k in enumerate((sy.f0, sy.f1, sy.f2, sy.f3)):
        shape[f_k(sy.v)] = sy.v**3 * harmonic(cosine**3 + cosine, k)
    row = field_row(dimension, m).subs(shape).doit().subs(sy.v, v)
    assert float(row) == pytest.approx(harmonic(v**2 * (5 * cosine**2 + 1), m), abs=1e-12)


def test_constants_of_the_nearly_elastic_limit() -> None:
    formula = printed_equation("beyond:field-nearly-elastic").formula
    constants = [equation.rhs for equation in formula if equation.lhs != sy.f0(sy.v)]
    values = [float(sp.N(constant.subs(sy.deficit, 1))) for constant in constants]
    assert values == pytest.approx([0.52666478, 0.37760980, 0.63452714, 0.41337540], abs=5e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_what_a_bath_does_is_what_the_generator_of_the_solver_does(dimension: int) -> None:
    e_star = 0.3
    w = 0.8
    # far above the speeds at which it is tested
    axis = ChebyshevSpeedAxis(16.0, w, 30, 1.0, True)
    generator = Generator(
        Drive(restitution=e_star, dimension=dimension, bath_speed=w),
        axis,
        ChebyshevResolution(30, 40, 1, 1e-12),
    )
    # rate and pull by quadrature over g = v - V: its length, and its cosine to v
    nodes, weights = np.polynomial.legendre.leggauss(80)
    g = 6.0 * (nodes[:, None] + 1.0)
    weight = 6.0 * weights[:, None] * g ** (dimension - 1)
    if dimension == 2:
        cosine, share = np.cos((np.arange(80) + 0.5) * math.pi / 80), np.full(80, math.pi / 40)
    else:
        cosine, share = np.polynomial.legendre.leggauss(80)
        share = 2.0 * math.pi * share
    along, square = bath_rates(dimension)
    for i in (0, 5, 10, 15):
        v = axis.speeds[i]
        exponent = (v * v + g * g - 2.0 * v * g * cosine) / (2.0 * w * w)
        density = np.exp(-exponent) / (2.0 * math.pi * w * w) ** (dimension / 2)
        probability = density * weight * share
        case = {
            sy.bath_rate(sy.v): (probability * g).sum(),
            sy.bath_pull(sy.v): v * (probability * g * g * cosine).sum(),
            sy.v: v,
            sy.bath: w,
            sy.effective: e_star,
        }
        of_square = generator.matrices[0, i] @ axis.speeds**2
        of_velocity = generator.matrices[1, i] @ axis.speeds
        assert of_square == pytest.approx(float(square.subs(case)), rel=1e-9)
        assert of_velocity == pytest.approx(float((sy.v * along).subs(case)), rel=1e-9)
