"""Section 3.2: the random walk and its mean square displacement."""

from __future__ import annotations

import sympy as sp

from ..formal import chain, eq
from ..symbols import G, N, R, alpha, beta, d, ge, h, k, l, msd, r, rho0, t, tau, tc, v0
from .entry import Section

SECTION = Section("Section 3: random walk")
_add = SECTION.add

_add(
    "ab",
    "alpha and beta",
    r"\alpha \equiv \frac{1}{v_{0}(0)},\quad \beta \equiv d\rho_{0} h(e)",
    sp.Tuple(eq(alpha, 1 / v0(0)), eq(beta, d * rho0 * h)),
)
_add(
    "taun",
    "time between two collisions",
    r"\tau_{N} \simeq \frac{l}{v_{0}( t_{N-1})}=l(\alpha +\beta t_{N-1})",
    chain(tau(N), l / v0(tc(N - 1)), l * (alpha + beta * tc(N - 1))),
)
_add(
    "taun#2",
    "the same as a function of the number of collisions",
    r"\tau_{N} = l\alpha (1+l\beta )^{N-1}",
    eq(tau(N), l * alpha * (1 + l * beta) ** (N - 1)),
)
_add(
    "tn",
    "time of collision N",
    r"t_{N} = \tau_{1}+\tau_{2}+\cdot \cdot \cdot+\tau_{N} = \frac{\alpha }{\beta } "
    r"\{(1+l\beta )^{N}-1\}",
    chain(tc(N), sp.Sum(tau(k), (k, 1, N)), alpha / beta * ((1 + l * beta) ** N - 1)),
)
_add(
    "N",
    "number of collisions until a time",
    r"N=\frac{\ln(\frac{\beta }{\alpha }t_{N}+1)}{\ln(1+l\beta)}",
    eq(N, sp.log(beta / alpha * tc(N) + 1) / sp.log(1 + l * beta)),
)
_add(
    "msd",
    "mean square displacement of the random walk",
    r"\langle{\bf r}^{2}(t)\rangle_{e} = l^{2}N \simeq l^{2}\frac{\ln(\frac{\beta }"
    r"{\alpha}t+1)}{\ln(1+l\beta)}",
    chain(msd(t), l**2 * N, l**2 * sp.log(beta / alpha * t + 1) / sp.log(1 + l * beta)),
)
_add(
    "scaledposi",
    "scaled position distribution",
    r"G(R) \equiv \sqrt{\langle{\bf r}^{2}(t)\rangle_{e}} \times g_{e}(r,t)",
    eq(G(R), sp.sqrt(msd(t)) * ge(r, t)),
)
