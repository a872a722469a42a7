"""What is stated about scatterers that are met again: rows beyond the paper, apart from proofs."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import eq
from .equation import PrintedEquation

_n = s.rho0 * s.d**2
_sign = (-1) ** s.harm
_next = s.harm + 1
_before = s.harm - 1

_STATED: dict[str, tuple[str, sp.Basic]] = {
    "beyond:straight-back": (
        "density of the deflections straight back",
        eq(s.back, s.e / (2 * (1 + s.e))),
    ),
    "beyond:return-chance": (
        "chance to be thrown back to the scatterer before",
        sp.Tuple(
            eq(s.retR(s.dist), 2 * s.e * _n / ((1 + s.e) * s.dist)),
            eq(s.ret, 2 * s.e * _n * sp.log(s.l / s.d) / (1 + s.e)),
        ),
    ),
    "beyond:return-operator": (
        "the operator of returns on v^p exp(i m phi): to first order, and summed",
        sp.Tuple(
            eq(s.lamd, s.lamm - s.ret * _sign * s.e**s.p * s.lamm**2),
            eq(s.lamd, s.lamm / (1 + s.ret * _sign * s.e**s.p * s.lamm)),
        ),
    ),
    "beyond:return-slope": (
        "what returns do to the displacement, and to elastic diffusion",
        sp.Tuple(
            eq(s.coefA(s.e), 2 * s.e * (1 - s.cos_chi) / (1 + s.e)),
            eq(s.coefA(1), sp.Rational(4, 3)),
        ),
    ),
    "beyond:enskog-path": (
        "mean free path among hard disks, to first order in their density",
        eq(s.ln, s.l * (1 - (2 * sp.pi / 3 - sp.sqrt(3) / 2) * _n)),
    ),
    "beyond:two-disks": (
        "returns of an impact parameter y on the second of two distant disks",
        sp.Tuple(
            eq(s.offset, (1 + s.e) * s.y * s.dist / (s.e * s.d)),
            eq(s.retR(s.dist), 2 * s.e * _n / ((1 + s.e) * s.dist)),
        ),
    ),
    "beyond:corridor": (
        "the way back runs in the corridor of the way out",
        sp.Tuple(eq(s.damp, 1 + s.offset / 4), eq(s.Lnest, sp.log((1 + s.offset / 4) / 2))),
    ),
    "beyond:free-flight": (
        "one free flight in Fourier space, harmonic by harmonic",
        eq(
            s.free(s.harm),
            (-sp.I * (sp.sqrt(1 + s.wave**2) - 1) / s.wave) ** s.harm / sp.sqrt(1 + s.wave**2),
        ),
    ),
    "beyond:loops": (
        "the propagator in Fourier space as continued fractions, upwards and downwards",
        sp.Tuple(
            eq(s.tail(s.k), 1 / (s.lamj(s.k) + s.wave**2 * s.tail(s.k + 1) / 4)),
            eq(s.prop, 1 / (s.lamm + s.wave**2 * (s.tail(_next) + s.tail(_before)) / 4)),
        ),
    ),
}

EQUATIONS = {
    label: PrintedEquation(label, title, "Beyond the paper: finite density", formula=formula)
    for label, (title, formula) in _STATED.items()
}
