"""Cooling: thermal velocity, scaling form, scaled equation (Section 3.2, start of Appendix B)."""

from __future__ import annotations

from functools import cache

import sympy as sp

from .. import symbols as s
from ..formal import Avg, Partial, dot, eq
from .record import Derived, Status, Verdict, defines, derives, result, row
from .scaling_state import cooling_rate_value, largest_cooling_ratio

_F_SCALED = s.F(s.bc)

_V0 = s.v0(s.t)
_T = s.T(s.t)
_ENERGY_LOSS = -2 * s.d * _V0 * s.rho0 * s.h * _T
"""dT/dt, with the cooling rate h."""


@derives("gtilde")
def _scaling_of_position() -> Derived:
    """(2): scaling of the position distribution, elastic."""
    root = sp.sqrt(s.msd1(s.t))
    return result(
        eq(s.g(s.r, s.t), sp.diff(s.r / root, s.r) * s.G(s.R)),
        ("g dr = G dR with R = r over the root of <r^2>", sp.diff(s.r / root, s.r)),
        note="The form is a change of variable; that G does not depend on time holds at e = 1, and "
        "only asymptotically.",
        verdict=Verdict.HOLDS,
    )


defines(
    {
        "v0defi": "The root of <v^2>: sqrt(2) U for the Gaussian start.",
        "thermo": "The mean energy; in the plane it is k_B T of a Gaussian.",
        "if": "The collision operator in units of the thermal velocity.",
        "mup": "Twice lambda(p) <c^(p+1)> by the weak form (sonine8).",
    }
)
# (5): energy loss
row(
    "tdiff",
    lambda: eq(sp.Derivative(_T, s.t), -2 * s.d * _V0 * s.rho0 * s.lam(2) * Avg(s.c**3) * _T),
    "weak form with Y = m v^2/2: the loss is E[1 - s^2] = lambda(2)",
    note="The exact rate has lambda(2) <c^3> in place of h. It is constant only in the scaling "
    "state; from the Gaussian start it begins at (sqrt(pi)/2)(1 - e^2) and tends to h.",
    verdict=Verdict.HOLDS,
    numbers={
        "rate at the Gaussian start at e = {e}": lambda e: (
            sp.sqrt(sp.pi) / 2 * (1 - sp.Float(e) ** 2)
        ),
        "h in the scaling state at e = {e}": cooling_rate_value,
    },
)


def _speed_equation(rate: sp.Expr) -> sp.Expr:
    """dv0/dt from dT/dt = rate and T = m v0^2/2."""
    slope = sp.Symbol("slope")
    energy = s.m * _V0**2 / 2
    balance = sp.diff(energy, _V0) * slope - rate.subs(_T, energy)
    (solution,) = sp.solve(balance, slope)
    return solution


# (6): equation for the thermal velocity
row("vdiff", lambda: eq(sp.Derivative(_V0, s.t), _speed_equation(_ENERGY_LOSS)))


@derives("veq")
def _speed_over_time() -> Derived:
    """(7): thermal velocity over time."""
    slope = _speed_equation(_ENERGY_LOSS)
    inverse = 1 / s.v0(0) + sp.integrate(sp.cancel(-slope / _V0**2), (s.t, 0, s.t))
    return result(eq(_V0, 1 / inverse))


# (8): cooling rate, fitted to the simulation
row(
    "hsimu",
    lambda: eq(s.h, 2 * sp.sqrt(s.klog * s.lam(1))),
    note="The exact h/(1 - e) is nearly constant: sqrt(2) at e = 0, 1.4297 at its largest, 4/3 as "
    "e -> 1. The fitted 1.45 lies above all of it; it takes 1/(2 d rho_0) for the mean free path, "
    "which is shorter where disks do not overlap.",
    status=Status.FIT,
    numbers={
        "exact h/(1 - e) at e = {e}": lambda e: cooling_rate_value(e) / (1 - e),
        "exact h/(1 - e) at e = 0": sp.sqrt(2),
        "exact h/(1 - e) as e -> 1": 4 / 3,
        "largest exact h/(1 - e)": lambda: largest_cooling_ratio()[1],
    },
)


def _second_moment_rate() -> sp.Expr:
    """dT/dt from the kinetic equation times m v^2/2.

    With v = v0 c every factor brings its power of v0, and the integral of c^2 I is -M_2.
    """
    rate = s.d * s.rho0 * _V0
    density = s.n / _V0**2
    volume = _V0**2
    return rate * density * volume / s.n * (-s.M2) * _T


def speed_equation_by_moment() -> sp.Expr:
    """dv0/dt in terms of M_2."""
    return _speed_equation(_second_moment_rate())


@cache
def _scaled_derivative() -> sp.Expr:
    """df/dt over (n d rho0/v0) for f = n/v0^2 Phi(v/v0): a combination of Phi and Phi'."""
    shape = sp.Function("Phi")
    slope = speed_equation_by_moment()
    rate = sp.diff(s.n / _V0**2 * shape(s.v / _V0), s.t)
    rate = rate.subs(sp.Derivative(_V0, s.t), slope).doit()
    return sp.simplify((rate * _V0 / (s.n * s.d * s.rho0)).subs(s.v, s.c * _V0).doit())


# (10): scaling form of the velocity distribution
row(
    "tdepend",
    lambda: (
        None,
        ("inserted in the kinetic equation, time separates", _scaled_derivative()),
        "all moments of F then follow: E[Y^(p+1)] = p E[Y^p]/lambda(p)",
    ),
    note="Holds: for 0 <= e < 1 a normalised F with all its moments exists (see the rows beyond "
    "the paper). At e = 1 nothing cools and any isotropic F is stationary.",
    verdict=Verdict.HOLDS,
)
# (13): energy loss by the second moment
row("tdiff2", lambda: eq(sp.Derivative(_T, s.t), _second_moment_rate()))


@derives("compare2")
def _cooling_rate_by_moment() -> Derived:
    """(14): cooling rate by the second moment."""
    difference = _ENERGY_LOSS - _second_moment_rate()
    (solution,) = sp.solve(difference, s.h)
    return result(
        eq(s.h, solution),
        ("difference of the two rates of T", difference),
        note="Exact; with the exact moments it gives h = 2 sqrt(kappa lambda(1)).",
    )


# (B1): thermal velocity by the second moment
row("rearramu2", lambda: eq(sp.Derivative(_V0, s.t), speed_equation_by_moment()))


def _scaled_coefficients() -> tuple[sp.Expr, sp.Expr]:
    """The factors of F and of c dF/dc in I(F)."""
    power = sp.Symbol("q", positive=True)
    shape = sp.Function("Phi")
    # on c^q the operator c d/dc is q: read both coefficients off a power
    expression = _scaled_derivative().replace(shape, lambda z: z**power).doit()
    image = sp.expand(sp.simplify(expression / s.c**power))
    return image.coeff(power, 0), image.coeff(power, 1)


@derives("ifmu2")
def _scaled_equation() -> Derived:
    """(B2): scaled equation."""
    plain, slope = _scaled_coefficients()
    return result(
        eq(s.I_(_F_SCALED), plain * _F_SCALED + slope * dot(s.bc, Partial(_F_SCALED, s.bc))),
        ("df/dt of the scaling form, over n d rho0/v0", _scaled_derivative()),
        ("factor of F", plain),
    )


@derives("mueq")
def _moment_condition() -> Derived:
    """(B3): moments of the scaled equation."""
    plain, slope = _scaled_coefficients()
    # int 2 pi c^(p+1) c F' dc = -(p + 2) int 2 pi c^(p+1) F dc
    by_parts = sp.simplify(-sp.diff(s.c ** (s.p + 2), s.c) / s.c ** (s.p + 1))
    factor = sp.factor(-(plain + slope * by_parts))
    return result(
        eq(s.Mp, factor * Avg(s.c**s.p)),
        ("integral by parts of c dF/dc against c^p in the plane", by_parts),
        ("M_p over <c^p>", factor),
        note="Exact for every real p for which the boundary terms vanish.",
    )
