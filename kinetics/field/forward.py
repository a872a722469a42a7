"""The density over time in a field, with its first moments of the place, and averages over it.

The harmonics f_m obey the equation of `elimination`. With x f and y f, integrated over the place,

    d_t (x f) = (field + collisions) (x f) + v_x f

and the same for y, all averages of the velocity and the displacement up to second order follow.
Of a start that is a few velocities, those that have not collided are in closed form (`starts`), and
the equation is that of the others: what collides first is their source. So all averages over smooth
functions are right, however rough the density is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.field import radau
from kinetics.field.elimination import Chain, Elimination
from kinetics.field.grid import SpeedPanels, loss_matrices
from kinetics.numerics import FloatArray

AVERAGES = (
    *("v_x", "v_y", "v^2", "v^2 cos 2", "v_x v_y", "v^4", "v"),
    *("v_x x", "v_y y", "v_x y + v_y x", "1"),
)


class ForwardEquation:
    """Takes the density, and x f and y f, over one step of time after another.

    law : the collision law
    panels : the speed axis
    highest : M, odd; harmonics 0 ... M
    symmetric : whether f is symmetric about the field; else it has two families
    moving : whether x f and y f are solved
    """

    def __init__(
        self, law: CollisionLaw, panels: SpeedPanels, highest: int, symmetric: bool, moving: bool
    ) -> None:
        self.panels, self.highest = panels, highest
        self.dimension = d = law.dimension
        self.families = 1 if symmetric else 2
        self.fields = [("f", k) for k in range(self.families)]
        if moving:
            self.fields += [("x", k) for k in range(self.families)]
            self.fields += [("y", 1 - k) for k in range(self.families)]
        self._loss = loss_matrices(panels, law, highest)
        self._lost = panels.speeds[:, None] * self._loss
        self._chains = [Chain(panels, d, family) for family in (0, 1)]
        self._modes = radau.modes()
        self._factors: tuple[float, list[dict[int, Elimination]]] = (0.0, [])
        m = np.arange(highest + 1.0)[:, None]
        if d == 2:
            norms = law.unit_surface * np.where(m == 0, [[1.0, 1.0]], 0.5)
        else:
            norms = law.unit_surface / (2.0 * m + 1.0) * np.hstack([m * 0.0 + 1.0, m * (m + 1.0)])
            norms[0, 1] = 1.0  # harmonic 0 of the second family is 0
        self._volume = norms.T[:, :, None] * panels.speeds ** (d - 1.0) * panels.weights
        self._weights = [self._average(*one) for one in self._observed(1.0 / (d - 1.0))]

    @staticmethod
    def _observed(half: float) -> list[tuple[tuple[str, int, int, float, float], ...]]:
        """Field, family, harmonic, power of v and a factor of each part of AVERAGES."""
        return [
            (("f", 0, 1, 1.0, 1.0),), (("f", 1, 1, 1.0, 1.0),), (("f", 0, 0, 2.0, 1.0),),
            (("f", 0, 2, 2.0, 1.0),), (("f", 1, 2, 2.0, 0.5),), (("f", 0, 0, 4.0, 1.0),),
            (("f", 0, 0, 1.0, 1.0),), (("x", 0, 1, 1.0, 1.0),), (("y", 1, 1, 1.0, half),),
            (("y", 0, 1, 1.0, 1.0), ("x", 1, 1, 1.0, 1.0)), (("f", 0, 0, 0.0, 1.0),),
        ]  # fmt: skip

    def _average(self, *parts: tuple[str, int, int, float, float]) -> FloatArray:
        """The weights (n_fields, M + 1, size) of an average."""
        out = np.zeros((len(self.fields), *self._volume.shape[1:]))
        for name, family, m, power, factor in parts:
            if (name, family) in self.fields:
                weight = factor * self._volume[family, m] * self.panels.speeds**power
                out[self.fields.index((name, family)), m] = weight
        return out

    def averages(self, f: FloatArray) -> FloatArray:
        """AVERAGES of densities (n, n_fields, M + 1, size), shape (n, n_averages)."""
        return np.stack([np.tensordot(f, weight, axes=3) for weight in self._weights], axis=1)

    def density(self, sums: FloatArray) -> FloatArray:
        """Densities of which these are the sums `Start.projected`, (..., n_fields, M + 1, size)."""
        family = [family for _, family in self.fields[: sums.shape[-3]]]
        return np.asarray(sums / self._volume[family])

    def gained(self, f: FloatArray) -> FloatArray:
        """What densities (..., M + 1, size) gain by collisions per unit time."""
        return np.asarray(self.panels.speeds * f - np.einsum("mij,...mj->...mi", self._loss, f))

    def step(self, f: FloatArray, h: float, source: FloatArray | None) -> FloatArray:
        """The densities (n_fields, M + 1, size) at all points of a step, (STAGES + 1, *f.shape).

        source : at the stages, (STAGES, *f.shape); None for none
        """
        if h != self._factors[0]:
            self._factors = h, [self._eliminations(1.0 / (h * value)) for value, *_ in self._modes]
        out = np.zeros((radau.STAGES + 1, *f.shape))
        out[0] = f
        by_mode = zip(self._modes, self._factors[1], strict=True)
        for (value, share, of_source, stages), eliminations in by_mode:
            right = share / (h * value) * f
            if source is not None:
                right = right + np.tensordot(of_source, source, axes=1)
            found: NDArray[np.complexfloating] = np.zeros(f.shape, dtype=complex)
            for k, (name, family) in enumerate(self.fields):
                if name == "x":
                    moved = self._chains[family].along(found[family])
                elif name == "y":
                    moved = self._chains[1 - family].across(found[1 - family])
                else:
                    moved = np.zeros(1)
                elimination = eliminations[family]
                part = slice(family, elimination.highest + 1)
                every = (right[k] + moved)[part] * self.panels.speeds
                found[k, part] = elimination.solve(every)
            out[1:] += (stages[:, None, None, None] * found).real
        return out

    def _eliminations(self, shift: complex) -> dict[int, Elimination]:
        used = {family for _, family in self.fields}
        real = shift.real if abs(shift.imag) < 1e-12 * abs(shift) else shift
        return {k: Elimination(self._chains[k], self._lost, real) for k in used}
