"""The density over time in a field, by its harmonics on speed panels.

f_m obeys the equation of `ladder` forwards. With (-1)^m f_m in place of f_m the field acts as it
does backwards, and the same continuation beyond the last harmonic is stable. What is found has the
right averages over smooth functions even if the start is a few velocities; point by point the
density is what tracers bring along their last free flight, see `last_flight`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.field.collisions import gain_matrices, rate_matrix
from kinetics.field.first_collision import Rays, angular
from kinetics.field.ladder import Chain, Elimination
from kinetics.field.panels import SpeedPanels
from kinetics.field.radau import RadauRule
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import gauss_legendre

_RATE = 70.0  # of the quadrature over the impact parameter
_SOURCE_POINTS = 16  # times of a step at which tracers of a ray collide
_GONE = 1e-18  # rate of collisions below which a ray is forgotten


@dataclass
class ForwardField:
    """Takes a density over one step of time after another.

    Parameters
    ----------
    law : the collision law
    panels : the speed axis
    highest : M, odd; harmonics 0 ... M
    families : 1 for a density that is symmetric about the field, else 2: cos(m phi) and sin(m phi)
    """

    law: CollisionLaw
    panels: SpeedPanels
    highest: int
    families: int = 1
    rule: RadauRule = field(default_factory=RadauRule)

    def __post_init__(self) -> None:
        v, d = self.panels.speeds, self.law.dimension
        self.gain = gain_matrices(self.panels, self.law, self.highest, _RATE)
        self._lost = v[:, None] * (rate_matrix(self.panels, d) - self.gain)
        self._chains = [Chain(self.panels, d, family, True) for family in range(self.families)]
        self.signs = ((-1.0) ** np.arange(self.highest + 1))[:, None]
        self._factors: dict[float, list[list[Elimination]]] = {}
        surface = np.array([_surface(self.law, m) for m in range(self.highest + 1)])
        self.volume = surface[:, None] * v ** (d - 1.0) * self.panels.weights
        """Weights of the integral of harmonic m of a function times that of f, (M + 1, size)."""

    def step(self, f: FloatArray, h: float, source: FloatArray | None) -> FloatArray:
        """The density (families, M + 1, size) at all points of a step, (stages + 1, *f.shape).

        source : of the density, at the stages; None for none. All times (-1)^m.
        """
        if h not in self._factors:
            self._factors = {h: self._eliminations(h)}
        out = np.zeros((self.rule.stages + 1, *f.shape))
        out[0] = f
        for mode, (value, share, stages) in enumerate(self.rule.modes):
            right = share / (h * value) * f
            if source is not None:
                right = right + np.tensordot(self.rule.source_rows[mode], source, axes=1)
            for family, chain in enumerate(self._chains):
                top = chain.highest(self.highest)
                part = right[family, family : top + 1] * self.panels.speeds
                found = self._factors[h][family][mode].solve(part)[0]
                every = (stages[:, None, None] * found).real
                out[1:, family, family : top + 1] += every
        return out

    def _eliminations(self, h: float) -> list[list[Elimination]]:
        shifts = [1.0 / (h * value) for value, _, _ in self.rule.modes]
        return [
            [
                Elimination(
                    chain,
                    self._lost,
                    None,
                    sign=-1.0,
                    shift=shift.real if shift.imag == 0.0 else shift,
                )
                for shift in shifts
            ]
            for chain in self._chains
        ]

    def made(self, stages: FloatArray) -> FloatArray:
        """v times what collisions make at the points of a step, of the shape of ``stages``."""
        made = np.einsum("mij,sfmj->sfmi", self.gain, stages * self.signs)
        return np.asarray(made * self.panels.speeds)

    def roughness(self, stages: FloatArray) -> float:
        """What the polynomial in time of a step leaves out of the mass of a panel."""
        first = [part.start for part in self.panels.parts]
        masses = np.add.reduceat(stages * self.volume, first, axis=-1)
        return float(self.rule.roughness(masses).max())

    def first_collided(self, rays: Rays, now: float, h: float) -> FloatArray | None:
        """The source that tracers of rays are which collide first, at the stages of a step.

        Its integral over the step with every polynomial that the rule takes is right. None where
        no tracer is left.
        """
        if np.all(np.exp(-rays.way(np.full(rays.along.size, now))) < _GONE):
            return None
        x, w = gauss_legendre(_SOURCE_POINTS)
        found = np.array([self._collided_at(rays, now + h * local) for local in x])
        order = np.arange(self.rule.stages)
        inside = np.polynomial.legendre.legvander(2.0 * x - 1.0, order[-1])
        at_stages = np.polynomial.legendre.legvander(2.0 * self.rule.points[1:] - 1.0, order[-1])
        taken = at_stages @ ((2.0 * order + 1.0)[:, None] * (inside * w[:, None]).T)
        return np.asarray(np.tensordot(taken, found, axes=1))

    def _collided_at(self, rays: Rays, time: float) -> FloatArray:
        """The density that rays make per unit time by their first collision, times (-1)^m."""
        q = self.law.quadrature_for(_RATE, self.highest)
        kept = q.weight * np.array([q.harmonic(m) for m in range(self.highest + 1)])
        u, across = rays.along + time, rays.across
        v = np.hypot(u, across)
        rate = rays.weight * v * np.exp(-rays.way(np.full(v.size, time)))
        live = rate > _GONE
        out = np.zeros((self.families, self.highest + 1, self.panels.size))
        for i in np.nonzero(live)[0]:
            reached = np.minimum(v[i], self.panels.highest) * np.exp(-q.log_loss)
            made = rate[i] * (kept @ self.panels.interpolation(reached))
            one = np.array([u[i] / v[i]]), np.array([across[i] / v[i]])
            tables = angular(*one, self.highest + 1, self.law.dimension)
            for family in range(self.families):
                out[family] += tables[family] * made
        return out * self.signs / self.volume


def _surface(law: CollisionLaw, m: int) -> float:
    """Integral of the square of harmonic m over all directions."""
    if m == 0:
        return law.unit_surface
    return law.unit_surface / (2.0 if law.dimension == 2 else 2.0 * m + 1.0)
