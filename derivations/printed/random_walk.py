"""Section 3.2: the random walk and its mean square displacement."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import chain, eq

FORMULAS: dict[str, sp.Basic] = {
    "ab": sp.Tuple(eq(s.alpha, 1 / s.v0(0)), eq(s.beta, s.d * s.rho0 * s.h)),
    "taun": chain(s.tau(s.N), s.l / s.v0(s.tc(s.N - 1)), s.l * (s.alpha + s.beta * s.tc(s.N - 1))),
    "taun#2": eq(s.tau(s.N), s.l * s.alpha * (1 + s.l * s.beta) ** (s.N - 1)),
    "tn": chain(
        s.tc(s.N),
        sp.Sum(s.tau(s.k), (s.k, 1, s.N)),
        s.alpha / s.beta * ((1 + s.l * s.beta) ** s.N - 1),
    ),
    "N": eq(s.N, sp.log(s.beta / s.alpha * s.tc(s.N) + 1) / sp.log(1 + s.l * s.beta)),
    "msd": chain(
        s.msd(s.t),
        s.l**2 * s.N,
        s.l**2 * sp.log(s.beta / s.alpha * s.t + 1) / sp.log(1 + s.l * s.beta),
    ),
    "scaledposi": eq(s.G(s.R), sp.sqrt(s.msd(s.t)) * s.ge(s.r, s.t)),
}
