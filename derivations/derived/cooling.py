"""Cooling: thermal velocity, scaling form, scaled equation (Section 3.2, start of Appendix B)."""

from __future__ import annotations

from functools import cache

import sympy as sp

from ..formal import Avg, Partial, dot, eq
from ..symbols import (
    I_,
    M2,
    F,
    G,
    Mp,
    R,
    T,
    bc,
    c,
    d,
    g,
    h,
    klog,
    lam,
    m,
    msd1,
    n,
    p,
    r,
    rho0,
    t,
    v,
    v0,
)
from .closed_form_values import largest_cooling_ratio
from .quadrature_values import cooling_rate_value
from .record import Derived, Number, Status, Step, definition
from .registry import derives


@derives("gtilde")
def _gtilde() -> Derived:
    root = sp.sqrt(msd1(t))
    return Derived(
        eq(g(r, t), sp.diff(r / root, r) * G(R)),
        (Step("g dr = G dR with R = r over the root of <r^2>", sp.diff(r / root, r)),),
        "The form is a change of variable; that G does not depend on time holds at e = 1, and "
        "only asymptotically.",
        Status.ASSUMPTION,
        holds=True,
    )


@derives("v0defi")
def _v0defi() -> Derived:
    return definition("The root of <v^2>: sqrt(2) U for the Gaussian start.")


@derives("thermo")
def _thermo() -> Derived:
    return definition("The mean energy; in the plane it is k_B T of a Gaussian.")


@derives("if")
def _if() -> Derived:
    return definition("The collision operator in units of the thermal velocity.")


@derives("mup")
def _mup() -> Derived:
    return definition("Twice lambda(p) <c^(p+1)> by the weak form (sonine8).")


@derives("tdiff")
def _tdiff() -> Derived:
    exact = -2 * d * v0(t) * rho0 * lam(2) * Avg(c**3) * T(t)
    return Derived(
        eq(sp.Derivative(T(t), t), exact),
        (
            Step("weak form with Y = m v^2/2: the loss is E[1 - s^2] = lambda(2)", None),
            Step("d<v^2>/dt = -2 d rho0 lambda(2) <v^3>, scaled", exact),
        ),
        "The exact rate has lambda(2) <c^3> in place of h. It is constant only in the scaling "
        "state; from the Gaussian start it begins at (sqrt(pi)/2)(1 - e^2) and tends to h.",
        Status.ASSUMPTION,
        holds=True,
        numbers=tuple(
            Number(f"{name} at e = {value}", float(number))
            for value in (0.4, 0.6, 0.7, 0.9)
            for name, number in (
                ("rate at the Gaussian start", sp.sqrt(sp.pi) / 2 * (1 - sp.Float(value) ** 2)),
                ("h in the scaling state", cooling_rate_value(value)),
            )
        ),
    )


def _speed_equation(rate: sp.Expr) -> sp.Expr:
    """dv0/dt from dT/dt = rate and T = m v0^2/2."""
    slope = sp.Symbol("slope")
    energy = m * v0(t) ** 2 / 2
    balance = sp.diff(energy, v0(t)) * slope - rate.subs(T(t), energy)
    (solution,) = sp.solve(balance, slope)
    return solution


@derives("vdiff")
def _vdiff() -> Derived:
    rate = -2 * d * v0(t) * rho0 * h * T(t)
    return Derived(
        eq(sp.Derivative(v0(t), t), _speed_equation(rate)),
        (
            Step("dT/dt", rate),
            Step("T = m v0^2/2 inserted, solved for dv0/dt", _speed_equation(rate)),
        ),
    )


@derives("veq")
def _veq() -> Derived:
    slope = _speed_equation(-2 * d * v0(t) * rho0 * h * T(t))
    inverse = 1 / v0(0) + sp.integrate(sp.cancel(-slope / v0(t) ** 2), (t, 0, t))
    solution = 1 / inverse
    if sp.simplify(sp.diff(solution, t) - slope.subs(v0(t), solution)) != 0:
        raise ArithmeticError("the thermal velocity does not solve its equation")
    return Derived(
        eq(v0(t), solution),
        (
            Step("rate of 1/v0", sp.cancel(-slope / v0(t) ** 2)),
            Step("1/v0, integrated from 0 to t", inverse),
        ),
    )


@derives("hsimu")
def _hsimu() -> Derived:
    values = [
        Number(f"exact h/(1 - e) at e = {value}", float(cooling_rate_value(value)) / (1 - value))
        for value in (0.4, 0.6, 0.7, 0.9)
    ]
    limits = [
        Number("exact h/(1 - e) at e = 0", float(sp.sqrt(2))),
        Number("exact h/(1 - e) as e -> 1", 4 / 3),
        Number("largest exact h/(1 - e)", largest_cooling_ratio()[1]),
    ]
    return Derived(
        eq(h, 2 * sp.sqrt(klog * lam(1))),
        note="The exact h/(1 - e) is nearly constant: sqrt(2) at e = 0, 1.4297 at its largest, 4/3 "
        "as e -> 1. The fitted 1.45 lies above all of it; it takes 1/(2 d rho_0) for the mean "
        "free path, which is shorter where disks do not overlap.",
        status=Status.FIT,
        numbers=(*values, *limits),
    )


@derives("tdepend")
def _tdepend() -> Derived:
    return Derived(
        None,
        (
            Step("inserted in the kinetic equation, time separates", _scaled_derivative()),
            Step("all moments of F then follow: E[Y^(p+1)] = p E[Y^p]/lambda(p)", None),
        ),
        "Holds: for 0 <= e < 1 a normalised F with all its moments exists (see the rows beyond "
        "the paper). At e = 1 nothing cools and any isotropic F is stationary.",
        Status.ASSUMPTION,
        holds=True,
    )


def _second_moment_rate() -> sp.Expr:
    """dT/dt from the kinetic equation times m v^2/2: with v = v0 c, powers of v0 collect."""
    return sp.cancel(_energy_rate() / (m * v0(t) ** 2 / 2)) * T(t)


def _energy_rate() -> sp.Expr:
    """d<m v^2/2>/dt: every factor brings its power of v0, and the integral of c^2 I is -M_2."""
    energy, rate = m / 2 * v0(t) ** 2, d * rho0 * v0(t)
    density, volume = n / v0(t) ** 2, v0(t) ** 2
    return energy * rate * density * volume / n * (-M2)


@derives("tdiff2")
def _tdiff2() -> Derived:
    return Derived(
        eq(sp.Derivative(T(t), t), _second_moment_rate()),
        (
            Step(
                "kinetic equation times m v^2/2, with f dv = n F dc and v.sigma = v0 c.sigma",
                _energy_rate(),
            ),
            Step("m v0^2/2 = T", _second_moment_rate()),
        ),
    )


@derives("compare2")
def _compare2() -> Derived:
    difference = -2 * d * v0(t) * rho0 * h * T(t) - _second_moment_rate()
    (solution,) = sp.solve(difference, h)
    return Derived(
        eq(h, solution),
        (Step("difference of the two rates of T", difference),),
        "Exact; with the exact moments it gives h = 2 sqrt(kappa lambda(1)).",
    )


@derives("rearramu2")
def _rearramu2() -> Derived:
    return Derived(
        eq(sp.Derivative(v0(t), t), speed_equation_by_moment()),
        (Step("dT/dt", _second_moment_rate()), Step("T = m v0^2/2 inserted", None)),
    )


def speed_equation_by_moment() -> sp.Expr:
    """dv0/dt in terms of M_2."""
    return _speed_equation(_second_moment_rate())


@cache
def _scaled_derivative() -> sp.Expr:
    """df/dt over (n d rho0/v0) for f = n/v0^2 Phi(v/v0): a combination of Phi and Phi'."""
    shape = sp.Function("Phi")
    slope = speed_equation_by_moment()
    rate = sp.diff(n / v0(t) ** 2 * shape(v / v0(t)), t)
    rate = rate.subs(sp.Derivative(v0(t), t), slope).doit()
    return sp.simplify((rate * v0(t) / (n * d * rho0)).subs(v, c * v0(t)).doit())


def _scaled_coefficients() -> tuple[sp.Expr, sp.Expr]:
    """The factors of F and of c dF/dc in I(F)."""
    power = sp.Symbol("q", positive=True)
    shape = sp.Function("Phi")
    # on c^q the operator c d/dc is q: read both coefficients off a power
    expression = _scaled_derivative().replace(shape, lambda z: z**power).doit()
    image = sp.expand(sp.simplify(expression / c**power))
    return image.coeff(power, 0), image.coeff(power, 1)


@derives("ifmu2")
def _ifmu2() -> Derived:
    plain, slope = _scaled_coefficients()
    return Derived(
        eq(I_(F(bc)), plain * F(bc) + slope * dot(bc, Partial(F(bc), bc))),
        (
            Step("df/dt of the scaling form, over n d rho0/v0", _scaled_derivative()),
            Step("factor of F", plain),
            Step("factor of c.dF/dc", slope),
        ),
    )


@derives("mueq")
def _mueq() -> Derived:
    plain, slope = _scaled_coefficients()
    # int 2 pi c^(p+1) c F' dc = -(p + 2) int 2 pi c^(p+1) F dc
    by_parts = sp.simplify(-sp.diff(c ** (p + 2), c) / c ** (p + 1))
    factor = sp.factor(-(plain + slope * by_parts))
    return Derived(
        eq(Mp, factor * Avg(c**p)),
        (
            Step("integral by parts of c dF/dc against c^p in the plane", by_parts),
            Step("M_p over <c^p>", factor),
        ),
        "Exact for every real p for which the boundary terms vanish.",
    )
