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
from .any_law import space_cosine, space_log_loss
from .record import Derived, derives, result, row


@cache
def effective_restitution() -> sp.Expr:
    """e* in alpha and A, from the momentum and the relative velocity along the normal."""
    before, after, struck = sp.symbols("v_n w_n V_n", real=True)
    momentum = before - after - s.masses * struck  # over m; the scatterer was at rest
    relative = after - struck + s.relative * before
    (found,) = sp.solve([momentum, relative], [after, struck], dict=True)
    return sp.factor(-found[after] / before)


row(
    "beyond:mass-map",
    lambda: eq(s.effective, sp.factor(1 + effective_restitution()) - 1),
    "m v_n = m v'_n + M V'_n and v'_n - V'_n = -alpha v_n give v'_n = -e* v_n",
    note="e* lies between -1 and 1: alpha for A -> oo, 0 at A = 1/alpha, and below 0 for "
    "lighter scatterers, behind which the tracer goes on. The tangential part is kept.",
)


@cache
def mean_lethargy() -> sp.Expr:
    """xi = E[-ln s^2] of smooth spheres, in the least share a = e*^2 of the energy that is left."""
    return 2 * space_log_loss().subs({s.et: 1, s.e: sp.sqrt(s.least_share)})


@cache
def least_share() -> sp.Expr:
    """a in A, with alpha = 1."""
    return sp.factor(effective_restitution().subs(s.relative, 1) ** 2)


@derives("beyond:mass-log-loss")
def _log_loss() -> Derived:
    xi = mean_lethargy()
    equal = sp.limit(xi, s.least_share, 0)
    return result(
        sp.Tuple(eq(2 * s.klog, xi), eq(s.least_share, least_share())),
        note=f"xi = 2 kappa of neutron physics: {equal} at A = 1, 2/A + ... for heavy scatterers.",
        numbers={
            f"xi at A = {a}": xi.subs(s.least_share, least_share().subs(s.masses, a))
            for a in (2, 12)
        }
        | {"xi at A = 1": equal},
    )


@cache
def mean_cosine(heavier: bool) -> sp.Expr:
    """E[cos(chi)] in A with alpha = 1, for scatterers heavier than the tracer, or lighter."""
    cosine = space_cosine(s.e if heavier else -s.e).subs(s.et, 1)
    return sp.expand(sp.cancel(cosine.subs(s.e, effective_restitution().subs(s.relative, 1))))


row(
    "beyond:mass-cosine",
    lambda: sp.Tuple(eq(s.cos_chi, mean_cosine(True)), eq(s.cos_chi, mean_cosine(False))),
    "s runs from |e*| to 1, and e* changes its sign at A = 1: A >= 1, then A <= 1",
    note="The angle of the tracer in the laboratory. 2/(3 A) holds for A >= 1 only: at A = 1 "
    "both are 2/3, and light scatterers leave the direction, cos(chi) -> 1, as A -> 0.",
)


@derives("beyond:mass-age")
def _age() -> Derived:
    slope = 2 / (s.klog * (1 - s.cos_chi))  # beyond:any-slope, over l^2
    found = sp.cancel(slope.subs(s.klog, s.lethargy / 2))

    def of_mass(mass: int) -> sp.Expr:
        xi = sp.limit(mean_lethargy(), s.least_share, least_share().subs(s.masses, mass))
        cosine = mean_cosine(True).subs(s.masses, mass)
        return found.subs({s.lethargy: xi, s.cos_chi: cosine}).evalf(20)

    return result(
        eq(Partial(s.msd(s.t), sp.log(s.t)) / s.l**2, found),
        note="Per lethargy ln(E_0/E), which is 2 ln t, it is half as large; a sixth of that is "
        "Fermi's age, l^2/(3 xi (1 - <cos chi>)).",
        numbers={f"slope at A = {mass}": of_mass(mass) for mass in (1, 2, 12, 238)},
    )
