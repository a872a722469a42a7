"""Scatterers at rest that a collision sets in motion; beyond the paper.

A tracer of mass m strikes a smooth one of mass M = A m. Its own velocity changes as by a bounce off
a fixed scatterer of another restitution e*, which may be negative: every average over a collision
is the one known, with e* for e. In space and without loss (alpha = 1) these are the figures of
neutrons that slow down.
"""

from __future__ import annotations

from functools import cache

import sympy as sp

from .. import symbols as s
from ..formal import Partial, eq
from .any_law import impact_density, one_collision
from .record import Derived, derives, must, result, zero


@cache
def effective_restitution() -> sp.Expr:
    """e* in alpha and A, from the momentum and the relative velocity along the normal."""
    before, after, struck = sp.symbols("v_n w_n V_n", real=True)
    momentum = before - after - s.masses * struck  # over m; the scatterer was at rest
    relative = after - struck + s.relative * before
    (found,) = sp.solve([momentum, relative], [after, struck], dict=True)
    return sp.factor(-found[after] / before)


@derives("beyond:mass-map")
def _map() -> Derived:
    e_star = effective_restitution()
    struck = (1 + e_star) / s.masses
    kept = e_star**2 + s.masses * struck**2  # of the energy m v_n^2/2
    reduced = s.masses / (1 + s.masses)
    zero(1 - kept - reduced * (1 - s.relative**2), "the energy lost is not that of two masses")
    return result(
        eq(s.effective, sp.factor(1 + e_star) - 1),
        "m v_n = m v'_n + M V'_n and v'_n - V'_n = -alpha v_n give v'_n = -e* v_n",
        ("e*", e_star),
        note="e* lies between -1 and 1: alpha for A -> oo, 0 at A = 1/alpha, and below 0 for "
        "lighter scatterers, behind which the tracer goes on. The tangential part is kept.",
    )


@cache
def _in_space() -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """(density of s^2, s cos(chi) in s, e*) of smooth spheres with alpha = 1."""
    square, along = (part.subs(s.et, 1).subs(s.e, s.effective) for part in one_collision(3))
    density = sp.cancel(impact_density(3) / sp.diff(square, s.y))
    in_ratio = sp.cancel((s.s**2 - square.coeff(s.y, 0)) / square.coeff(s.y, 2))  # y^2
    must(not density.has(s.y), "s^2 is not uniform")
    along = sp.cancel(sp.expand(along).subs(s.y, sp.sqrt(in_ratio)))
    return density, along, effective_restitution().subs(s.relative, 1)


@cache
def mean_lethargy() -> sp.Expr:
    """xi = E[-ln s^2], in the least share a of the energy that is left."""
    density, _, _ = _in_space()
    share = sp.Symbol("share", positive=True)
    least = density.subs(s.effective, sp.sqrt(s.least_share))
    total = sp.expand(sp.integrate(-sp.log(share), (share, s.least_share, 1)) * least)
    logarithm = sp.log(s.least_share)
    rest = sp.cancel(total.subs(logarithm, 0))
    return rest + sp.factor(total.coeff(logarithm)) * logarithm


@derives("beyond:mass-log-loss")
def _log_loss() -> Derived:
    least = sp.factor(_in_space()[2] ** 2)
    xi = mean_lethargy()
    equal = sp.limit(xi, s.least_share, 0)
    return result(
        sp.Tuple(eq(2 * s.klog, xi), eq(s.least_share, least)),
        ("density of the share s^2 of the energy, from a = e*^2 to 1", _in_space()[0]),
        note=f"xi = 2 kappa of neutron physics: {equal} at A = 1, 2/A + ... for heavy scatterers.",
        numbers={f"xi at A = {a}": xi.subs(s.least_share, least.subs(s.masses, a)) for a in (2, 12)}
        | {"xi at A = 1": equal},
    )


@cache
def mean_cosine(heavier: bool) -> sp.Expr:
    """E[cos(chi)] in A, for scatterers heavier than the tracer, or lighter."""
    density, along, e_star = _in_space()
    low = e_star if heavier else -e_star  # the least speed ratio, |e*|
    integrand = sp.expand(sp.cancel(along / s.s * density * 2 * s.s))
    parts = sp.integrate(integrand, s.s)
    mean = (parts.subs(s.s, 1) - parts.subs(s.s, low)).subs(s.effective, e_star)
    return sp.expand(sp.cancel(mean))


@derives("beyond:mass-cosine")
def _cosine() -> Derived:
    cosine = sp.Symbol("cosine", real=True)  # in the frame of the centre of mass: uniform
    speed = sp.sqrt(1 + s.masses**2 + 2 * s.masses * cosine)  # of the tracer, times 1 + A
    slope = sp.integrate(sp.expand(cosine * (1 + s.masses * cosine)), (cosine, -1, 1)) / 2
    must(slope == s.masses / 3, "the centre of mass is not as it was")
    for mass, heavier in ((3, True), (sp.Rational(1, 3), False)):
        other = ((1 + s.masses * cosine) / speed).subs(s.masses, mass) / 2
        zero(
            sp.integrate(other, (cosine, -1, 1)) - mean_cosine(heavier).subs(s.masses, mass),
            "the frame of the centre of mass gives another mean",
        )
    return result(
        sp.Tuple(eq(s.cos_chi, mean_cosine(True)), eq(s.cos_chi, mean_cosine(False))),
        "s runs from |e*| to 1, and e* changes its sign at A = 1: A >= 1, then A <= 1",
        "second route, at A = 3 and 1/3: uniform directions in the frame of the centre of mass",
        note="The angle of the tracer in the laboratory. 2/(3 A) holds for A >= 1 only: at A = 1 "
        "both are 2/3, and light scatterers leave the direction, cos(chi) -> 1, as A -> 0.",
    )


@derives("beyond:mass-age")
def _age() -> Derived:
    slope = 2 / (s.klog * (1 - s.cos_chi))  # beyond:any-slope, over l^2
    found = sp.cancel(slope.subs(s.klog, s.lethargy / 2))

    def of_mass(mass: int) -> sp.Expr:
        least = _in_space()[2].subs(s.masses, mass) ** 2
        xi = mean_lethargy().subs(s.least_share, least) if least else sp.Integer(1)
        cosine = mean_cosine(True).subs(s.masses, mass)
        return found.subs({s.lethargy: xi, s.cos_chi: cosine}).evalf(20)

    return result(
        eq(Partial(s.msd(s.t), sp.log(s.t)) / s.l**2, found),
        note="Per lethargy ln(E_0/E), which is 2 ln t, it is half as large; a sixth of that is "
        "Fermi's age, l^2/(3 xi (1 - <cos chi>)).",
        numbers={f"slope at A = {mass}": of_mass(mass) for mass in (1, 2, 12, 238)},
    )
