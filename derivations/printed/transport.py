"""Section 3, Chapman-Enskog expansion: diffuse1 ... diffuse22."""

from __future__ import annotations

from ..symbols import De, T, m, nuD, t, xi
from .entry import Section, eq

SECTION = Section("Section 3: Chapman-Enskog")
_add = SECTION.add

_add(
    "diffuse21",
    "diffusion coefficient",
    r"D_{e}(t)=\frac{T(t)}{m}(\nu_{D}-\frac{\xi(t)}{2})^{-1}",
    eq(De(t), T(t) / m / (nuD - xi(t) / 2)),
)
