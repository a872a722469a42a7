"""Results beyond the paper at a finite density of scatterers, as they are stated."""

from __future__ import annotations

import sympy as sp
from sympy import Rational as Q
from sympy import exp, log, oo, pi, sqrt

from ..formal import eq
from ..symbols import (
    Lnest,
    back,
    coefA,
    cos_chi,
    d,
    damp,
    dist,
    e,
    free,
    harm,
    k,
    l,
    lamd,
    lamj,
    lamm,
    ln,
    loop0,
    lost,
    offset,
    p,
    pathz,
    prop,
    ret,
    retR,
    retz,
    rho0,
    tail,
    wave,
    y,
)
from .rows import Result

number_in_d2 = rho0 * d**2  # n = rho_0 d^2
sign = (-1) ** harm

FINITE_DENSITY: tuple[Result, ...] = (
    Result(
        label="beyond:straight-back",
        title="density of the deflections straight back",
        formulas=(eq(back, e / (2 * (1 + e))),),
    ),
    Result(
        label="beyond:return-chance",
        title="chance to be thrown back to the scatterer before",
        formulas=(
            eq(retR(dist), 2 * e * number_in_d2 / ((1 + e) * dist)),
            eq(ret, 2 * e * number_in_d2 * log(l / d) / (1 + e)),
        ),
    ),
    Result(
        label="beyond:return-operator",
        title="the operator of returns on v^p exp(i m phi): to first order, and summed",
        formulas=(
            eq(lamd, lamm - ret * sign * e**p * lamm**2),
            eq(lamd, lamm / (1 + ret * sign * e**p * lamm)),
        ),
    ),
    Result(
        label="beyond:return-slope",
        title="what returns do to the displacement, and to elastic diffusion",
        formulas=(
            eq(coefA(e), 2 * e * (1 - cos_chi) / (1 + e)),
            eq(coefA(1), Q(4, 3)),
        ),
    ),
    Result(
        label="beyond:enskog-path",
        title="mean free path among hard disks, to first order in their density",
        formulas=(eq(ln, l * (1 - (2 * pi / 3 - sqrt(3) / 2) * number_in_d2)),),
    ),
    Result(
        label="beyond:two-disks",
        title="returns of an impact parameter y on the second of two distant disks",
        formulas=(
            eq(offset, (1 + e) * y * dist / (e * d)),
            eq(retR(dist), 2 * e * number_in_d2 / ((1 + e) * dist)),
        ),
    ),
    Result(
        label="beyond:corridor",
        title="the way back runs in the corridor of the way out",
        formulas=(
            eq(damp, 1 + offset / 4),
            eq(Lnest, log((1 + offset / 4) / 2)),
        ),
    ),
    Result(
        label="beyond:return-delay",
        title=(
            "near pairs of scatterers when a return takes its path: at any path, summed "
            "to n ln(1/n) over all paths, and at none"
        ),
        formulas=(
            eq(
                retz(pathz),
                -2
                * e
                * number_in_d2
                / (1 + e)
                * exp(loop0 * pathz)
                * sp.Ei(-loop0 * (lost + pathz)),
            ),
            eq(coefA(e), 2 * e / (1 + e)),
            eq(retz(oo), 0),
        ),
    ),
    Result(
        label="beyond:free-flight",
        title="one free flight in Fourier space, harmonic by harmonic",
        formulas=(
            eq(free(harm), (-sp.I * (sqrt(1 + wave**2) - 1) / wave) ** harm / sqrt(1 + wave**2)),
        ),
    ),
    Result(
        label="beyond:loops",
        title="the propagator in Fourier space as continued fractions, upwards and downwards",
        formulas=(
            eq(tail(k), 1 / (lamj(k) + wave**2 * tail(k + 1) / 4)),
            eq(prop, 1 / (lamm + wave**2 * (tail(harm + 1) + tail(harm - 1)) / 4)),
        ),
    ),
)
"""Smooth disks that the tracer meets again."""
