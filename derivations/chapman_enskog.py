"""Chapman-Enskog expansion in the density gradient, and its first Sonine approximation."""

from __future__ import annotations

from functools import cache

import sympy as sp

from .collision_integrals import over_angle, parallel_component, sonine_average
from .record import Derived, Number, Step
from .registry import derives
from .sonine import eq, sonine_cooling_rate, tidy
from .symbols import De, T, a2, d, e, h, m, msd, nuD, rho0, t, t1, v0, xi


@cache
def thermal_speed() -> sp.Expr:
    """v0 as a function of the temperature, from T = m v0^2/2."""
    speed = sp.Symbol("speed", positive=True)
    (root,) = sp.solve(sp.Eq(T(t), m * speed**2 / 2), speed)
    return root


@derives("diffuse21")
def _diffuse21() -> Derived:
    # (xi T d/dT - nu_D) D = -T/m, with D ~ T^(1/2): T dD/dT = D/2
    unknown = sp.Symbol("D", positive=True)
    exponent = sp.Rational(1, 2)
    equation = xi(t) * exponent * unknown - nuD * unknown + T(t) / m
    (solution,) = sp.solve(equation, unknown)
    return Derived(
        eq(De(t), sp.factor(solution)),
        (
            Step("the equation for D with T dD/dT = D/2", eq(equation, 0)),
            Step("solved for D", solution),
        ),
    )


@cache
def flux_relaxation() -> sp.Expr:
    """nu_D for B ~ v f with the Sonine VDF, as a function of v0(t), e and a2."""
    # int v.Lambda(v f) dv / int v.v f dv, with v.(v' - v) = v^2 (parallel - 1), rate d rho0 v dy
    transfer = over_angle(parallel_component() - 1)
    ratio = transfer * sonine_average(3) / sonine_average(2)
    return sp.factor(-d * rho0 * v0(t) * ratio)


@derives("ad6")
def _ad6() -> Derived:
    derived = flux_relaxation().subs(v0(t), thermal_speed())
    return Derived(
        eq(nuD, derived),
        (
            Step("v'.v/v^2 of one collision", parallel_component()),
            Step(
                "its loss, integrated over the impact parameter",
                over_angle(parallel_component() - 1),
            ),
            Step("<c^3> of the Sonine VDF", sonine_average(3)),
            Step("<c^2> of the Sonine VDF", sonine_average(2)),
            Step("nu_D in terms of the thermal speed", eq(nuD, flux_relaxation())),
        ),
        "Follows from the approximation B ~ v f; the speed dependence of B that this drops costs "
        "15 % of D even at e = 1.",
    )


@cache
def sonine_diffusion() -> sp.Expr:
    """D_e in the first Sonine approximation, as a function of v0(t)."""
    cooling = 2 * d * rho0 * v0(t) * sonine_cooling_rate()
    return tidy(v0(t) ** 2 / 2 / (flux_relaxation() - cooling / 2))


@derives("ad7")
def _ad7() -> Derived:
    derived = sp.simplify(sonine_diffusion().subs(v0(t), thermal_speed()))
    lorentz = sp.Rational(3, 8) * sonine_average(1).subs(a2, 0)
    elastic = sonine_diffusion().subs({a2: 0, e: 1, d: sp.Rational(1, 2), rho0: 1}) / v0(t)
    return Derived(
        eq(De(t), derived),
        (
            Step("T/m = v0^2/2", eq(thermal_speed(), v0(t))),
            Step("cooling rate xi = 2 d rho0 v0 h with h = M_2/2", eq(h, sonine_cooling_rate())),
            Step("D = (v0^2/2)/(nu_D - xi/2)", eq(De(t), sonine_diffusion())),
        ),
        "At e = 1 with a Gaussian VDF the exact value is (3/8) l <v>: this is 15 % low.",
        numbers=(
            Number("D/(l v0) at e = 1, first Sonine", float(elastic)),
            Number("D/(l v0) at e = 1, exact", float(lorentz)),
            Number("their ratio", float(elastic / lorentz)),
        ),
    )


@derives("ad8")
def _ad8() -> Derived:
    # d<r^2>/dt = int r^2 D laplace(n) dr/n = 4 D: the Laplacian of r^2 in the plane is 4
    x_, y_ = sp.symbols("x y", real=True)
    laplacian = sp.diff(x_**2 + y_**2, x_, 2) + sp.diff(x_**2 + y_**2, y_, 2)
    return Derived(
        eq(msd(t), laplacian * sp.Integral(De(t1), (t1, 0, t))),
        (
            Step("Laplacian of r^2 in the plane", laplacian),
            Step(
                "second moment of the diffusion equation",
                eq(sp.Derivative(msd(t), t), laplacian * De(t)),
            ),
        ),
        "Misprint: the integrand is printed at the upper limit t, not at the integration variable "
        "t'. Taken at its word, 4 t D_e(t) levels off where the integral grows as ln t.",
        numbers=(
            Number("printed over derived at beta v0(0) t = 100", float(100 / 101 / sp.log(101))),
        ),
    )


@cache
def sonine_msd() -> sp.Expr:
    """4 int_0^t D dt' with D = k v0(t') and v0 = 1/(1/v0(0) + beta t'), v0(0) = sqrt(2), U = 1."""
    beta, start = sp.symbols("beta v_00", positive=True)
    speed = 1 / (1 / start + beta * t)
    logarithm = sp.log(1 + start * beta * t) / beta
    if sp.cancel(sp.diff(logarithm, t) - speed) != 0 or logarithm.subs(t, 0) != 0:
        raise ArithmeticError("not the integral of v0 from 0 to t")
    total = 4 * sp.cancel(sonine_diffusion() / v0(t)) * logarithm
    cooling = d * rho0 * sonine_cooling_rate()
    return tidy(total.coeff(sp.log(1 + start * beta * t)).subs(beta, cooling)) * sp.log(
        1 + tidy((start * beta).subs({beta: cooling, start: sp.sqrt(2)})) * t
    )


@derives("ad8#2")
def _ad8_2() -> Derived:
    total = sonine_msd()
    return Derived(
        eq(msd(t), total),
        (
            Step("D_e is proportional to v0", eq(De(t), sonine_diffusion())),
            Step("4 int_0^t D_e dt' with v0 = 1/(1/v0(0) + d rho0 h t'), v0(0) = sqrt(2) U", total),
        ),
        "In the paper's units (U = 1). Its slope in ln t is well below the exact one.",
        numbers=tuple(number for value in (0.6, 0.7, 0.9) for number in _slopes(value)),
    )


def _slopes(value: float) -> tuple[Number, Number]:
    from .scaling import diffusion_slope_value
    from .sonine import roots

    slope = 4 * sp.cancel(sonine_diffusion() / v0(t)) / (d * rho0 * sonine_cooling_rate())
    slope = slope.subs({d: sp.Rational(1, 2), rho0: 1}).subs(a2, roots()[0])
    return (
        Number(f"slope in ln t at e = {value}, Sonine (l^2)", float(slope.subs(e, value))),
        Number(f"slope in ln t at e = {value}, exact (l^2)", float(diffusion_slope_value(value))),
    )
