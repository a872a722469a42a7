"""The derived formulas by a second route in numbers, and the numbers of the solver against them."""

import math
from collections.abc import Callable

import mpmath as mp
import numpy as np
import pytest
import sympy as sp
from scipy.special import j0

from derivations import symbols as sy
from derivations.derived import any_dimension, any_law, finite_density, position, scaling_state
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
    closed = sp.lambdify((R, eta), position.closed_form(), "mpmath")
    tail = sp.lambdify((R, eta), position.tail(), "mpmath")
    radii, widths = RANDOM.uniform(0.05, 6, 5), RANDOM.uniform(0.1, 2, 5)
    with mp.workdps(60):
        for radius, width in zip(map(mp.mpf, radii), map(mp.mpf, widths), strict=True):
            # V = exp(u): the integrand is then even in u about its saddle, for the trapezoid rule
            root, step = mp.sqrt(radius**2 / (2 * width)), mp.mpf(1) / 64
            total = mp.fsum(mp.exp(-2 * root * mp.cosh(2 * step * k)) for k in range(-320, 321))
            integral = 2 * radius / width * step * total
            assert abs(integral / closed(radius, width) - 1) < mp.mpf(10) ** -50
            # far out it is the tail that steepest descent gives, up to a part of 1/R
            assert abs(tail(10**7, width) / closed(10**7, width) - 1) < mp.mpf(10) ** -6
    ours = printed_numbers.position_integral(radii, widths)
    theirs = [float(closed(r, w)) for r, w in zip(radii, widths, strict=True)]
    np.testing.assert_allclose(ours, theirs, rtol=TOLERANCE)


def test_the_series_of_the_cooling_rate_and_the_tail_of_the_moments(rows) -> None:
    near, small = (rows[f"beyond:cooling-{which}"].derived.rhs for which in ("near-1", "small-e"))
    with mp.workdps(40):
        tiny = mp.mpf(10) ** -4
        small, near = sp.lambdify(e, small, "mpmath"), sp.lambdify(sy.gap, near, "mpmath")
        squares = [
            4 * average(lambda s, _: -mp.log(s), x) * average(lambda s, _: 1 - s, x)
            for x in (tiny, 1 - tiny)
        ]
        assert abs(mp.sqrt(squares[0]) - small(tiny)) < 20 * tiny**3  # e^3 ln e
        assert abs(mp.sqrt(squares[1]) / tiny - near(tiny)) < tiny**3
    # E[Y^(p+1)]/E[Y^p] = p/lambda(p) = p + 1/(1 - e^2) + O(1/p)
    for value in (0.2, 0.6):
        gaps = [
            n / average(lambda s, _, n=n: 1 - s**n, mp.mpf(value)) - n - 1 / (1 - value**2)
            for n in (200, 400)
        ]
        assert abs(gaps[1]) < 0.02
        assert gaps[0] / gaps[1] == pytest.approx(2, rel=0.05)


@pytest.mark.parametrize("value", RESTITUTIONS[:3])
def test_the_solver_meets_its_twin(value: float) -> None:
    law, exact = CollisionLaw(restitution=value), ScalingSolution(value)
    for ours, theirs in [
        (law.mean_log_loss, sy.klog),
        (law.mean_cosine, sy.cos_chi),
        (law.decay_rate(2.5), sy.lam(2.5)),
        (exact.cooling_rate, scaling_state.cooling_rate()),
        (exact.diffusion_slope, scaling_state.slope()),
        (exact.a2, scaling_state.a2()),
        (exact.moment(7), scaling_state.moment(7) / scaling_state.moment(2) ** sp.Rational(7, 2)),
    ]:
        derived = float(scaling_state.exact_value(theirs, value))
        assert ours == pytest.approx(derived, rel=TOLERANCE, abs=TOLERANCE)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_scaled_vdf_of_the_solver_at_e_zero_is_the_derived_one(dimension: int) -> None:
    speeds = RANDOM.uniform(0.05, 12, 20)
    derived = sp.lambdify(sy.c, any_law.e_zero_solution(dimension), "numpy")(speeds)
    found = ScalingSolution(0.0, dimension=dimension).vdf(speeds)
    np.testing.assert_allclose(found, derived, rtol=TOLERANCE)


# -- the paper's approximations --


def test_the_first_sonine_order_of_the_solver_meets_the_derived_one(rows) -> None:
    def of(label: str, *arguments: sp.Symbol):
        system = {sy.T(sy.t): sy.v**2 / 2, sy.m: 1, sy.d: 1, sy.rho0: sp.Rational(1, 25)}
        return sp.lambdify(arguments, rows[label].derived.rhs.subs(system), "numpy")

    law, above = printed_numbers, RANDOM.uniform(0.59, 0.99, 20)
    a2, thermal = RANDOM.uniform(-0.4, 0.4, 20), RANDOM.uniform(0.1, 2, 20)
    root = of("sonine12", e)(above)
    for ours, derived in [
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
        np.testing.assert_allclose(ours, derived, rtol=TOLERANCE, atol=TOLERANCE)


def test_the_printed_curves_of_the_solver_meet_the_printed_formulas() -> None:
    fitted, start = sp.Rational(145, 100) * (1 - e), sp.sqrt(2)
    walk = {
        sy.alpha: 1 / start,
        sy.beta: fitted / 25,
        sy.l: sp.Rational(27, 2),
        sy.v0(0): start,
        sy.d: 1,
        sy.rho0: sp.Rational(1, 25),
        sy.h: fitted,
    }

    def of(label: str, *arguments: sp.Symbol, at=None):
        formula = ROWS[label].formula
        side = formula[-1].rhs if isinstance(formula, sp.Tuple) else formula.rhs
        return sp.lambdify(arguments, side.subs(at or {}).doit(), "numpy")

    other = {sy.alpha: sp.Rational(5, 6), sy.beta: sp.Rational(3, 200), sy.l: 3}
    law, radii = printed_numbers, RANDOM.uniform(0.3, 6, 20)
    time, value = RANDOM.uniform(1, 3000, 20), RANDOM.uniform(0.1, 0.95, 20)
    saddle = of("csolu", R, eta)(radii, 0.25)
    exponent = ROWS["pdefi"].formula.rhs
    height, bend = sp.symbols("height bend")
    pieces = {Second(sy.pd(sy.V, R), sy.V, sy.Vs): bend, sy.pd(sy.Vs, R): height}
    pieces |= {sy.gamma: sp.Rational(739, 100), eta: sp.Rational(1, 4)}
    at_saddle = [
        sp.lambdify((sy.V, R, eta), part)(saddle, radii, 0.25)
        for part in (exponent, sp.diff(exponent, sy.V, 2))
    ]
    tail = sp.lambdify((R, height, bend), ROWS["gammatailg"].formula.rhs.subs(pieces), "numpy")
    rate = of("hsimu", e)(value)
    shape = 1 + 0.3 * of("sonine2", sy.x)((radii / 3) ** 2)
    for ours, theirs in [
        (law.cooling_rate_fitted(value), rate),
        (law.thermal_speed(time, rate), of("veq", e, sy.t, at=walk)(value, time)),
        (law.msd_random_walk(time, value), of("msd", e, sy.t, at=walk)(value, time)),
        (law.msd_random_walk(time, 1, 0.1, 0.5, 3.0, 1.2, 0.3), of("msd", sy.t, at=other)(time)),
        (law.position_given_speed(radii, 0.75, 0.6), of("posivel", R, eta, sy.V)(radii, 0.75, 0.6)),
        (law.position_peak(radii), of("peakg", R, eta, sy.Vbar)(radii, 0.75, np.sqrt(0.5))),
        (law.position_far_tail(radii, 0.25), of("semig", R, eta)(radii, 0.25)),
        (law.position_tail(radii), tail(radii, *at_saddle)),
        (law.vdf(radii / 3, 0.3), np.exp(-((radii / 3) ** 2)) / np.pi * shape),
        (law.THRESHOLD_RESTITUTION, float(ROWS["compare1"].formula.lhs)),
    ]:
        np.testing.assert_allclose(ours, theirs, rtol=TOLERANCE)


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

    for closed, found, weight in (
        (any_law.space_power(), law.mean_speed_ratio_power(order), lambda s, cosine: s**order),
        (any_law.space_log_loss(), law.mean_log_loss, lambda s, cosine: -mp.log(s)),
        (any_law.space_cosine(), law.mean_cosine, lambda s, cosine: cosine),
    ):
        with mp.workdps(30):
            function = sp.lambdify((p, e, sy.et), closed, "mpmath")
            exact = float(function(mp.mpf(order), mp.mpf(e_), mp.mpf(et)))
        assert found == pytest.approx(exact, rel=TOLERANCE, abs=TOLERANCE)
        assert average(weight) == pytest.approx(exact, rel=1e-12, abs=1e-12)


def test_equal_restitutions(rows) -> None:
    for value in (0.3, 0.8, 1.0):
        disks = CollisionLaw(value, tangential_restitution=value)
        at = {e: value, p: 2.5}
        derived = [float(x.rhs.subs(at)) for x in rows["beyond:plane-equal"].derived]
        found = [disks.mean_speed_ratio_power(2.5), disks.mean_log_loss, disks.mean_cosine]
        assert found == pytest.approx(derived, rel=TOLERANCE)
        spheres = CollisionLaw(value, tangential_restitution=value, dimension=3)
        for order in (1, 2, 3, 4):
            assert spheres.harmonic_decay_rate(0.0, order) == pytest.approx(1.0, abs=TOLERANCE)


@pytest.mark.parametrize(("dimension", "gaussian"), [(2, 2), (3, sp.Rational(5, 3))])
def test_the_elastic_chain_tends_to_a_gaussian(dimension: int, gaussian: sp.Expr) -> None:
    late = sp.limit(any_dimension.elastic_transform(dimension) * sy.laplace**3, sy.laplace, 0)
    # <r^4> = late zeta^2/2 and <r^2> = 2 zeta/nu_1
    assert sp.cancel(late / 2 / (2 / sy.nu1) ** 2) == gaussian


def test_the_density_of_isotropic_scattering_in_the_plane_has_that_transform(rows) -> None:
    transform, density = (part.rhs for part in rows["beyond:isotropic-plane"].derived)
    ring = sp.exp(-sy.zeta) * sy.delta(sy.r - sy.zeta)
    spread = sp.lambdify((sy.r, sy.zeta), density - ring, "numpy")
    x, weight = np.polynomial.legendre.leggauss(100)
    time, angle = 20.0 * (1.0 + x), np.pi / 4 * (1.0 + x[:, None])
    radius = time * np.sin(angle)  # the density is infinite at r = zeta
    inside = spread(radius, time) * time * np.cos(angle) * j0(1.3 * radius)
    over_radii = np.exp(-time) * j0(1.3 * time) + np.pi / 4 * weight @ inside
    found = 20.0 * weight @ (np.exp(-time) * over_radii)
    assert found == pytest.approx(float(transform.subs({sy.wave: 1.3, sy.laplace: 1})), rel=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_chain_of_the_solver_is_the_derived_one(dimension: int) -> None:
    top: Observable = quartic_displacement(dimension)
    ((of_third, third),) = top.sources
    (of_square, square), (of_second, second) = third.sources
    ((of_along, along),) = second.sources
    ((to_square, again),) = square.sources
    assert along == again
    assert (top.harmonic, third.harmonic, second.harmonic, along.harmonic) == (0, 1, 2, 1)
    assert along.constant == 1.0
    drive = any_dimension.sources(dimension)
    assert [of_third, of_square, of_second, of_along, to_square] == [
        float(drive[to][of])
        for to, of in (
            ((4, 0), (3, 1)),
            ((3, 1), (2, 0)),
            ((3, 1), (2, 2)),
            ((2, 2), (1, 1)),
            ((2, 0), (1, 1)),
        )
    ]


# -- scatterers that are met again, and a uniform field --


@pytest.mark.parametrize("value", [0.3, 0.7, 1.0])
def test_returns_meet_bounces_and_the_operator_of_the_solver(value: float) -> None:
    y = np.random.default_rng(17).uniform(-1.0, 1.0, 2_000_000)
    cosine = (-value + (1 + value) * y**2) / np.sqrt(value**2 + (1 - value**2) * y**2)
    share = np.mean(cosine < -math.cos(0.05)) / 0.1
    assert share == pytest.approx(float(finite_density.straight_back().subs(e, value)), rel=0.02)
    n, length = 0.05, sp.Symbol("length", positive=True)
    law = law_in_medium(CollisionLaw(value), "overlapping", n, 1.0, "leading")
    # the derived chance counts from d to l; the solver's logarithm is ln(1/n)
    chance = sp.integrate(finite_density.return_chance(), (sy.dist, 1, length))
    eps = float(chance.subs({e: value, sy.d: 1, sy.rho0: n, length: 1 / n}))
    _, summed = finite_density.return_symbols()
    for m, order in [(0, 1.0), (1, 0.0), (1, 2.5), (2, 3.0)]:
        rate = CollisionLaw(value).harmonic_decay_rate(order, m)
        at = {sy.harm: m, p: order, e: value, sy.lamm: rate, sy.ret: eps}
        exact = pytest.approx(float(summed.subs(at)), rel=1e-13, abs=1e-15)
        assert law.harmonic_decay_rate(order, m) == exact


def test_areas_and_flights_in_numbers(rows) -> None:
    x, y = np.random.default_rng(17).uniform(-1.0, 2.0, (2, 1_000_000))
    inside = (x**2 + y**2 < 1) & ((x - 1) ** 2 + y**2 < 1)
    area = float(finite_density.shared_area().subs(sy.d, 1))
    assert 9 * inside.mean() == pytest.approx(area, rel=0.01)
    for order, wave in [(0, 0.7), (1, 3.0), (4, 2.0)]:
        angle = (np.arange(400) + 0.5) * np.pi / 400
        exact = np.mean(np.cos(order * angle) / (1 + 1j * wave * np.cos(angle)))
        found = rows["beyond:free-flight"].derived.rhs.subs({sy.harm: order, sy.wave: wave})
        assert complex(found) == pytest.approx(complex(exact), abs=1e-12)
    # the corridor: per path the strips of width 2 d sweep 2 d; both cover what is within d of one
    rate = float(rows["beyond:corridor"].derived[0].rhs.subs(sy.offset, 1.4))
    assert rate == pytest.approx(1 + 1.4 / 2 / 2, rel=1e-6)


def test_the_transform_of_near_pairs_in_numbers(rows) -> None:
    at = {sy.rho0: 0.04, sy.d: 1, e: 0.7, sy.loop0: 0.05, sy.lost: 0.6, sy.pathz: 1.3}
    found = float(rows["beyond:return-delay"].derived[0].rhs.subs(at))
    y = np.exp(np.linspace(np.log(0.05), 4.0, 20001))
    exact = np.trapezoid(np.exp(-0.6 * y - 1.3 * (y - 0.05)), np.log(y))
    assert found == pytest.approx(2 * 0.7 / 1.7 * 0.04 * exact, rel=1e-7)


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

    v, parts = 1.3, (sy.f0, sy.f1, sy.f2, sy.f3)
    shape = {f(sy.v): sy.v**3 * harmonic(cosine**3 + cosine, k) for k, f in enumerate(parts)}
    row = field_row(dimension, m).subs(shape).doit().subs(sy.v, v)
    assert float(row) == pytest.approx(harmonic(v**2 * (5 * cosine**2 + 1), m), abs=1e-12)


def test_constants_of_the_nearly_elastic_limit() -> None:
    formula = printed_equation("beyond:field-nearly-elastic").formula
    at = {sy.deficit: 1}
    values = [float(sp.N(x.rhs.subs(at))) for x in formula if x.lhs != sy.f0(sy.v)]
    assert values == pytest.approx([0.52666478, 0.37760980, 0.63452714, 0.41337540], abs=5e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_what_a_bath_does_is_what_the_generator_of_the_solver_does(dimension: int) -> None:
    e_star, w = 0.3, 0.8
    # far above the speeds at which it is tested
    axis = ChebyshevSpeedAxis(16.0, w, 30, 1.0, True)
    one = Generator(
        Drive(restitution=e_star, dimension=dimension, bath_speed=w),
        axis,
        ChebyshevResolution(30, 40, 1, 1e-12),
    )
    # rate and pull by quadrature over g = v - V: its length, and its cosine to v
    g, weight = (part[:, None] for part in np.polynomial.legendre.leggauss(80))
    g = 6.0 * (g + 1.0)
    weight = 6.0 * weight * g ** (dimension - 1)
    if dimension == 2:
        cosine, share = np.cos((np.arange(80) + 0.5) * math.pi / 80), np.full(80, math.pi / 40)
    else:
        cosine, share = np.polynomial.legendre.leggauss(80)
        share = 2.0 * math.pi * share
    along, square = bath_rates(dimension)
    for i in (0, 5, 10, 15):
        v = axis.speeds[i]
        there = np.exp(-(v * v + g * g - 2.0 * v * g * cosine) / (2.0 * w * w)) * weight * share
        there /= (2.0 * math.pi * w * w) ** (dimension / 2)
        at = {
            sy.bath_rate(sy.v): (there * g).sum(),
            sy.bath_pull(sy.v): v * (there * g * g * cosine).sum(),
            sy.v: v,
            sy.bath: w,
            sy.effective: e_star,
        }
        found = one.matrices[0, i] @ axis.speeds**2, one.matrices[1, i] @ axis.speeds
        assert found[0] == pytest.approx(float(square.subs(at)), rel=1e-9)
        assert found[1] == pytest.approx(float((sy.v * along).subs(at)), rel=1e-9)
