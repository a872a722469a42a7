"""Section 3.2: the random walk and its mean square displacement."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import chain, eq
from .equation import Section

SECTION = Section("Section 3: random walk")
_add = SECTION.add

_add(
    "ab",
    "alpha and beta",
    r"\alpha \equiv \frac{1}{v_{0}(0)},\quad \beta \equiv d\rho_{0} h(e)",
    sp.Tuple(eq(s.alpha, 1 / s.v0(0)), eq(s.beta, s.d * s.rho0 * s.h)),
)
_add(
    "taun",
    "time between two collisions",
    r"\tau_{N} \simeq \frac{l}{v_{0}( t_{N-1})}=l(\alpha +\beta t_{N-1})",
    chain(s.tau(s.N), s.l / s.v0(s.tc(s.N - 1)), s.l * (s.alpha + s.beta * s.tc(s.N - 1))),
)
_add(
    "taun#2",
    "the same as a function of the number of collisions",
    r"\tau_{N} = l\alpha (1+l\beta )^{N-1}",
    eq(s.tau(s.N), s.l * s.alpha * (1 + s.l * s.beta) ** (s.N - 1)),
)
_add(
    "tn",
    "time of collision N",
    r"t_{N} = \tau_{1}+\tau_{2}+\cdot \cdot \cdot+\tau_{N} = \frac{\alpha }{\beta } "
    r"\{(1+l\beta )^{N}-1\}",
    chain(
        s.tc(s.N),
        sp.Sum(s.tau(s.k), (s.k, 1, s.N)),
        s.alpha / s.beta * ((1 + s.l * s.beta) ** s.N - 1),
    ),
)
_add(
    "N",
    "number of collisions until a time",
    r"N=\frac{\ln(\frac{\beta }{\alpha }t_{N}+1)}{\ln(1+l\beta)}",
    eq(s.N, sp.log(s.beta / s.alpha * s.tc(s.N) + 1) / sp.log(1 + s.l * s.beta)),
)
_add(
    "msd",
    "mean square displacement of the random walk",
    r"\langle{\bf r}^{2}(t)\rangle_{e} = l^{2}N \simeq l^{2}\frac{\ln(\frac{\beta }"
    r"{\alpha}t+1)}{\ln(1+l\beta)}",
    chain(
        s.msd(s.t),
        s.l**2 * s.N,
        s.l**2 * sp.log(s.beta / s.alpha * s.t + 1) / sp.log(1 + s.l * s.beta),
    ),
)
_add(
    "scaledposi",
    "scaled position distribution",
    r"G(R) \equiv \sqrt{\langle{\bf r}^{2}(t)\rangle_{e}} \times g_{e}(r,t)",
    eq(s.G(s.R), sp.sqrt(s.msd(s.t)) * s.ge(s.r, s.t)),
)
