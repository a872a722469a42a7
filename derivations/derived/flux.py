"""The diffusion coefficient in the first Sonine approximation (Appendix C)."""

from __future__ import annotations

import math
from functools import cache

import sympy as sp

from .. import symbols as s
from ..formal import eq
from ..premises import over_angle, parallel_component
from .chapman_enskog import thermal_speed
from .quadrature_values import a2_value, diffusion_slope_value
from .record import Derived, Number, Step, derives, numbers_at, result
from .sonine import at_restitution, polynomial, roots, sonine_average, sonine_cooling_rate, tidy

_D = s.De(s.t)
_MSD = s.msd(s.t)

_RESTITUTIONS = (0.6, 0.7, 0.9)  # above the threshold of the Sonine a_2
_V0 = s.v0(s.t)


@derives("ad3")
def _ad3() -> Derived:
    sonine, lorentz = elastic_diffusion()
    return result(
        None,
        note="At e = 1 the equation for B is solved exactly by B ~ v f/|v|, not v f, because the "
        "collision rate is proportional to the speed. This alone makes D_e 15 % low.",
        holds=False,
        numbers=(Number("D_e over its exact value at e = 1", float(sonine / lorentz)),),
    )


@derives("ad4")
def _ad4() -> Derived:
    return result(
        None,
        note="The truncated Sonine form; its tail is Gaussian, the exact one is exponential.",
        holds=False,
        numbers=numbers_at(
            _RESTITUTIONS,
            {
                "Sonine a_2 at e = {e}": lambda e: at_restitution(roots()[0], e),
                "exact a_2 at e = {e}": a2_value,
            },
        ),
    )


@derives("ad5")
def _ad5() -> Derived:
    scaled = sp.exp(-(s.c**2)) / sp.pi * (1 + s.a2 * polynomial(2).subs(s.x, s.c**2))
    dimensional = s.n / _V0**2 * scaled.subs(s.c, s.v / _V0)
    derived = dimensional.subs(_V0, thermal_speed())
    return result(
        eq(s.fa2(s.bv, s.t), derived),
        Step("scaled Sonine form", scaled),
        Step("f = (n/v0^2) F(v/v0)", dimensional),
        Step("v0 by the temperature", eq(_V0, thermal_speed())),
        note="The printed form lacks the factor n: by v0defi and tdepend the integral of f over v "
        "is n, that of the printed form is 1. Nothing follows: nu_D is a ratio in which it "
        "cancels.",
        numbers=(Number("integral of the printed form over v", 1.0),),
    )


@cache
def flux_relaxation() -> sp.Expr:
    """nu_D for B ~ v f with the Sonine VDF, as a function of v0(t), e and a2."""
    # int v.Lambda(v f) dv / int v.v f dv, with v.(v' - v) = v^2 (parallel - 1), rate d rho0 v dy
    transfer = over_angle(parallel_component() - 1)
    ratio = transfer * sonine_average(3) / sonine_average(2)
    return sp.factor(-s.d * s.rho0 * _V0 * ratio)


@derives("ad6")
def _ad6() -> Derived:
    loss = over_angle(parallel_component() - 1)
    return result(
        eq(s.nuD, flux_relaxation().subs(_V0, thermal_speed())),
        Step("v'.v/v^2 of one collision", parallel_component()),
        Step("its loss, over the impact parameter", sp.expand(loss)),
        Step("<c^3> of the Sonine VDF", sonine_average(3)),
        Step("<c^2> of the Sonine VDF", sonine_average(2)),
        Step("nu_D in terms of the thermal speed", eq(s.nuD, flux_relaxation())),
        note="Follows from the approximation B ~ v f; the speed dependence of B that this drops "
        "costs 15 % of D_e even at e = 1.",
    )


@cache
def sonine_diffusion() -> sp.Expr:
    """D_e in the first Sonine approximation, as a function of v0(t)."""
    cooling = 2 * s.d * s.rho0 * _V0 * sonine_cooling_rate()
    return tidy(_V0**2 / 2 / (flux_relaxation() - cooling / 2))


@cache
def elastic_diffusion() -> tuple[sp.Expr, sp.Expr]:
    """D/(l v0) at e = 1 for a Gaussian VDF: first Sonine, and exact.

    Exact: the flux at one speed decays at the rate 2 d rho0 v (1 - <v'.v>/v^2), so that
    D(v) = v^2/2 over it; then averaged over the Gaussian.
    """
    boltzmann_grad = {s.d: sp.Rational(1, 2), s.rho0: 1}  # l = 1/(2 d rho0) = 1
    sonine = (sonine_diffusion() / _V0).subs({s.a2: 0, s.e: 1}).subs(boltzmann_grad)
    decay = -over_angle(parallel_component() - 1).subs(s.e, 1) / 2
    exact = sonine_average(1).subs(s.a2, 0) / (2 * decay)
    return sp.simplify(sonine), sp.simplify(exact)


@derives("ad7")
def _ad7() -> Derived:
    derived = sp.simplify(sonine_diffusion().subs(_V0, thermal_speed()))
    sonine, lorentz = elastic_diffusion()
    return result(
        eq(_D, derived),
        Step("T/m = v0^2/2", eq(thermal_speed(), _V0)),
        Step("cooling rate xi = 2 d rho0 v0 h with h = M_2/2", eq(s.h, sonine_cooling_rate())),
        Step("D_e = (v0^2/2)/(nu_D - xi/2)", eq(_D, sonine_diffusion())),
        note="Follows from diffuse21 and ad6. At e = 1 with a Gaussian VDF the exact value is "
        "(3/8) l <v>: this is 15 % low.",
        numbers=(
            Number("D_e/(l v0) at e = 1, first Sonine", float(sonine)),
            Number("D_e/(l v0) at e = 1, exact", float(lorentz)),
            Number("their ratio", float(sonine / lorentz)),
        ),
    )


@derives("ad8")
def _ad8() -> Derived:
    # d<r^2>/dt = int r^2 D laplace(n) dr/n = 4 D: the Laplacian of r^2 in the plane is 4
    x_, y_ = sp.symbols("x y", real=True)
    laplacian = sp.diff(x_**2 + y_**2, x_, 2) + sp.diff(x_**2 + y_**2, y_, 2)
    return result(
        eq(_MSD, laplacian * sp.Integral(s.De(s.t1), (s.t1, 0, s.t))),
        Step("Laplacian of r^2 in the plane", laplacian),
        Step(
            "second moment of the diffusion equation", eq(sp.Derivative(_MSD, s.t), laplacian * _D)
        ),
        note="Misprint: the integrand is printed at the upper limit t, not at the integration "
        "variable t'. Taken at its word, 4 t D_e(t) levels off where the integral grows as ln t.",
        numbers=(Number("printed over derived at beta v0(0) t = 100", 100 / 101 / math.log(101)),),
    )


@cache
def sonine_msd() -> sp.Expr:
    """4 int_0^t D dt' with D = k v0(t') and v0 = 1/(1/v0(0) + beta t'), v0(0) = sqrt(2), U = 1."""
    beta, start = sp.symbols("beta v_00", positive=True)
    speed = 1 / (1 / start + beta * s.t)
    logarithm = sp.log(1 + start * beta * s.t) / beta
    if sp.cancel(sp.diff(logarithm, s.t) - speed) != 0 or logarithm.subs(s.t, 0) != 0:
        raise ArithmeticError("not the integral of v0 from 0 to t")
    total = 4 * sp.cancel(sonine_diffusion() / _V0) * logarithm
    cooling = s.d * s.rho0 * sonine_cooling_rate()
    return tidy(total.coeff(sp.log(1 + start * beta * s.t)).subs(beta, cooling)) * sp.log(
        1 + tidy((start * beta).subs({beta: cooling, start: sp.sqrt(2)})) * s.t
    )


@derives("ad8#2")
def _ad8_2() -> Derived:
    total = sonine_msd()
    return result(
        eq(_MSD, total),
        Step("D_e is proportional to v0", eq(_D, sonine_diffusion())),
        Step("4 int_0^t D_e dt' with v0 = 1/(1/v0(0) + d rho0 h t'), v0(0) = sqrt(2) U", total),
        note="In the paper's units (U = 1). Its slope in ln t is below the exact one.",
        numbers=numbers_at(
            _RESTITUTIONS,
            {
                "slope in ln t at e = {e}, Sonine (l^2)": sonine_slope,
                "slope in ln t at e = {e}, exact (l^2)": diffusion_slope_value,
            },
        ),
    )


def sonine_slope(value: float) -> float:
    """d<r^2>/d ln t in units of l^2 by the first Sonine approximation with the lower a_2."""
    slope = 4 * sp.cancel(sonine_diffusion() / _V0) / (s.d * s.rho0 * sonine_cooling_rate())
    slope = slope.subs({s.d: sp.Rational(1, 2), s.rho0: 1}).subs(s.a2, roots()[0])
    return float(slope.subs(s.e, value))
