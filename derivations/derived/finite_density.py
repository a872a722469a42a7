"""Smooth disks at a finite density: the tracer meets a scatterer again; beyond the paper.

Premises: those of one collision (`premises`), scatterers placed independently with density rho0
(hard disks: with no two of them closer than d), and what a scatterer does when it is met again.
There, as at the first meeting, a bounce K takes the place of going on: each meeting counts K - 1.
"""

from __future__ import annotations

from functools import cache

import sympy as sp

from .. import symbols as s
from ..formal import eq
from ..premises import impact_density, mean_free_path, over_impact, velocity_after
from .record import Derived, derives, result, row


@cache
def straight_back() -> sp.Expr:
    """The density of the deflection at pi, per radian, from both sides."""
    across, along = velocity_after().subs(s.et, 1)
    angle_from_pi = sp.atan(across / along)  # pi - chi, for contacts that are nearly head-on
    angle_per_contact = sp.simplify(sp.diff(angle_from_pi, s.theta).subs(s.theta, 0))
    contact_density = impact_density(2) * sp.diff(sp.sin(s.theta), s.theta)
    return sp.factor(contact_density.subs(s.theta, 0) / angle_per_contact)


# density of the deflections straight back
row("beyond:straight-back", lambda: eq(s.back, straight_back()))


@cache
def return_chance() -> sp.Expr:
    """The chance per collision, per unit of the distance, to come straight back."""
    ratio = sp.Symbol("small", positive=True)  # d/R
    window = sp.series(2 * sp.asin(ratio), ratio, 0, 2).removeO()
    return sp.factor(straight_back() * window.subs(ratio, s.d / s.dist) / mean_free_path(2))


@derives("beyond:return-chance")
def _chance_of_return() -> Derived:
    """Chance to be thrown back to the scatterer before."""
    total = sp.integrate(return_chance(), (s.dist, s.d, s.l))
    return result(
        sp.Tuple(eq(s.retR(s.dist), return_chance()), eq(s.ret, total)),
        ("directions that meet a disk at the distance R: 2 asin(d/R)", 2 * s.d / s.dist),
        note="Where it begins and ends changes the order n, not n ln(1/n), n = rho_0 d^2.",
    )


@cache
def return_symbols() -> tuple[sp.Expr, sp.Expr]:
    """What takes the place of lambda_m(p): to first order in the chance, and summed."""
    reversed_power = sp.cos(sp.pi * s.harm) * s.e**s.p  # v^p exp(i m phi) with e v and phi + pi
    meeting = -s.lamm  # K - 1
    series = sp.Symbol("again")
    (summed,) = sp.solve(series - meeting - s.ret * meeting * reversed_power * series, series)
    zeroth_order = summed.subs(s.ret, 0)
    first_order = s.ret * sp.diff(summed, s.ret).subs(s.ret, 0)
    return -(zeroth_order + first_order), -summed


# the operator of returns on v^p exp(i m phi): to first order, and summed
row("beyond:return-operator", lambda: sp.Tuple(*(eq(s.lamd, rate) for rate in return_symbols())))


@cache
def slope_coefficient() -> sp.Expr:
    """A where the slope of <r^2> is multiplied by 1 - A n ln(1/n)."""
    decay_with_returns, _ = return_symbols()
    decay_of_flux = decay_with_returns.subs({s.harm: 1, s.p: 0})
    relative_change = sp.diff(s.lamm / decay_of_flux, s.ret).subs(s.ret, 0)
    relative_change = relative_change.subs(s.lamm, 1 - s.cos_chi)
    chance_per_log = sp.cancel(return_chance() * s.dist / (s.rho0 * s.d**2))
    return sp.factor(-relative_change * chance_per_log)


@derives("beyond:return-slope")
def _return_slope() -> Derived:
    """What returns do to the displacement, and to elastic diffusion."""
    mean_cosine = over_impact(2 * s.y**2 - 1)  # cos(chi) of an elastic bounce
    elastic = slope_coefficient().subs({s.e: 1, s.cos_chi: mean_cosine})
    return result(
        sp.Tuple(eq(s.coefA(s.e), slope_coefficient()), eq(s.coefA(1), elastic)),
        "2 l^2/[kappa lambda_1(0)]; returns change lambda_0(p) by p^2 as p -> 0, and kappa not",
        note="At e = 1 the diffusion coefficient is that of the Boltzmann equation times 1 + (4/3) "
        "n ln n, as van Leeuwen and Weijland found in 1967.",
    )


@cache
def shared_area() -> sp.Expr:
    """The area that two circles of radius d share, their centres at the distance d."""
    chord = 2 * sp.sqrt(s.d**2 - s.x**2)  # at the distance x from one centre
    return sp.simplify(2 * sp.integrate(chord, (s.x, s.d / 2, s.d)))


@derives("beyond:enskog-path")
def _enskog_path() -> Derived:
    """Mean free path among hard disks, to first order in their density."""
    order = sp.Symbol("small", positive=True)
    path = s.l / (1 + order * s.rho0 * shared_area())
    path_to_first_order = s.l + sp.diff(path, order).subs(order, 0)
    return result(
        eq(s.ln, sp.factor(path_to_first_order)),
        ("no scatterer is within d of the tracer or of one that it touches", sp.pi * s.d**2),
        note="The tracer, at random in the free area, is one more hard disk.",
    )


@derives("beyond:two-disks")
def _two_disks() -> Derived:
    """Returns of an impact parameter y on the second of two distant disks."""
    across, along = velocity_after().subs(s.et, 1)
    tangent = (across / along).subs(s.theta, sp.asin(s.y))
    slope = sp.simplify(sp.diff(tangent, s.y).subs(s.y, 0))
    offset = sp.factor(slope * s.y * s.dist / s.d)
    impact_per_offset = sp.cancel(1 / sp.diff(offset, s.y))  # dy of the second disk
    # it is met with the chance rho0 d dy dR, and meets the first disk again over |offset| < 1
    chance = sp.factor(2 * impact_per_offset * s.rho0 * s.d)
    return result(
        sp.Tuple(eq(s.offset, offset), eq(s.retR(s.dist), chance)),
        ("tan(pi - chi) per impact parameter, head-on", slope),
        note="The integrand of the two-disk integral at large R: a uniform impact parameter on the "
        "first disk at the second meeting, whatever it was at the first one.",
    )


@derives("beyond:corridor")
def _corridor() -> Derived:
    """The way back runs in the corridor of the way out."""
    u = sp.Symbol("u", positive=True)  # distance from the second scatterer, over R
    # scatterers per path that the way out has not met: outside of its corridor
    unmet = s.offset * u * s.d * s.rho0
    rate = 1 + sp.integrate(unmet * mean_free_path(2), (u, 0, 1))
    # the integral of [exp(-a R) - exp(-2 R)]/R over R > 0 is ln(2/a) (Frullani)
    return result(
        sp.Tuple(eq(s.damp, rate), eq(s.Lnest, sp.log(rate / 2))),
        ("the way back leaves the corridor, of width 2 d, by", s.offset * u * s.d),
    )


@derives("beyond:return-delay")
def _return_delay() -> Derived:
    """Near pairs of scatterers when a return takes its path: at any path, summed to n ln(1/n) over
    all paths, and at none.
    """
    distance = s.loop * s.l / 2  # of the scatterer at which a loop turns
    chance = return_chance().subs(s.dist, distance) * sp.diff(distance, s.loop)
    chance_per_path = sp.cancel(chance).subs(s.l, mean_free_path(2))
    # exp(-c y - z (y - a))/y: of the path y, y - a is flown
    shortest, rate = sp.symbols("a rate", positive=True)
    integral = -sp.Ei(-shortest * rate)  # of exp(-rate y)/y over y > a
    integral = integral.subs({shortest: s.loop0, rate: s.lost + s.pathz})
    strength = sp.factor(sp.cancel(chance_per_path * s.loop))
    transform = strength * sp.exp(s.loop0 * s.pathz) * integral
    n = sp.Symbol("small", positive=True)  # a loop begins at a path of the order n
    at_late_times = (transform / (s.rho0 * s.d**2)).subs(s.pathz, 0).subs(s.loop0, n)
    return result(
        sp.Tuple(
            eq(s.retz(s.pathz), transform),
            eq(s.coefA(s.e), sp.limit(at_late_times / sp.log(1 / n), n, 0)),
            eq(s.retz(sp.oo), sp.limit(transform, s.pathz, sp.oo)),
        ),
        ("loops of the path y, there and back, per unit of it", sp.factor(chance_per_path)),
        note="Late, where all loops are closed, returns are the operator above; before the first "
        "loop there are none. What is left of its chance is of the order n, in loops of the size "
        "of l.",
    )


@derives("beyond:free-flight")
def _free_flight() -> Derived:
    """One free flight in Fourier space, harmonic by harmonic."""
    q, amplitude = sp.symbols("q size")
    # (1 + i K cos(phi)) G = 1, harmonic m: G_m + (i K/2)(G_(m-1) + G_(m+1)) = 1 at m = 0, else 0
    roots = sp.solve(1 + sp.I * s.wave / 2 * (q + 1 / q), q)
    (decaying,) = [root for root in roots if abs(sp.N(root.subs(s.wave, 1))) < 1]
    row_0 = amplitude + sp.I * s.wave / 2 * 2 * decaying * amplitude - 1
    (harmonic_0,) = sp.solve(row_0, amplitude)
    harmonic_m = sp.simplify(harmonic_0) * sp.simplify(decaying) ** s.harm
    return result(eq(s.free(s.harm), harmonic_m))


@derives("beyond:loops")
def _loops() -> Derived:
    """The propagator in Fourier space as continued fractions, upwards and downwards."""
    i_half = sp.I * s.wave / 2
    x_j, x_lower, x_above, x_below = sp.symbols("x_j x_before x_above x_below")
    # the harmonics beyond j are x_(j+1) = -(i K/2) F_(j+1) x_j: no source there
    row_j = s.lamj(s.k) * x_j + i_half * (x_lower - i_half * s.tail(s.k + 1) * x_j)
    (solution,) = sp.solve(row_j, x_j)
    tail = sp.cancel(solution / (-i_half * x_lower))
    above = -i_half * s.tail(s.harm + 1) * x_j
    below = -i_half * s.tail(s.harm - 1) * x_j
    row_m = s.lamm * x_j + i_half * (x_above + x_below) - 1
    (propagator,) = sp.solve(row_m.subs({x_above: above, x_below: below}), x_j)
    return result(
        sp.Tuple(eq(s.tail(s.k), tail), eq(s.prop, propagator)),
        ("row j of (lambda + i K cos(phi)) x = 0", row_j),
        note="Downwards the same with j - 1 in place of j + 1.",
    )
