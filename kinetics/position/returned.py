r"""Returns to the scatterer before, on the panels of a sweep (`kinetics.position.scattering`).

At a finite density (`kinetics.collision.medium`) collisions change a_m by

    psi = (K - 1)/(1 - eps S (K - 1)) a,      S f(X) = f(X + ln e),

K one collision and eps with the sign (-1)^m of a bounce straight back. With b = a + eps S psi this
is psi = (K - 1) b: collisions act on b, and psi at lower X says what has come back.
"""

from __future__ import annotations

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.numerics import FloatArray
from kinetics.numerics.panels import PanelRule, PanelShifts


class Returned:
    """psi on the panels so far, for harmonics up to some m.

    Parameters
    ----------
    law : of a medium
    rule : the collocation
    loss : 1 - K of a panel on itself, over the coupling, shape (m, nodes, nodes)
    coupling : of each harmonic, shape (m,)

    Attributes
    ----------
    loss : minus what psi of a panel is of a there, over the coupling, shape (m, nodes, nodes)
    """

    def __init__(
        self, law: CollisionLaw, rule: PanelRule, loss: FloatArray, coupling: FloatArray
    ) -> None:
        self._coupling = coupling[:, None, None]
        self._eps = np.array([law.returns(m)[0] for m in range(coupling.size)])[:, None, None]
        self._collided = loss * self._coupling
        shifts = PanelShifts(rule, np.array([law.returns(0)[1]]))
        self._span = range(int(shifts.below.min()), int(shifts.below.max()) + 1)
        self._moved = [(shifts.below == j) * shifts.rows[:, 0] for j in self._span]
        own = self._moved[0] if self._span[0] == 0 else np.zeros_like(rule.derivative)
        self._own = self._eps * own
        self._inner = np.linalg.inv(np.eye(rule.nodes) + self._collided @ self._own)
        self.loss = self._inner @ loss
        self._psi: list[FloatArray] = []
        self._back = self._come = np.zeros(0)

    @property
    def reach(self) -> int:
        """How many panels down S goes."""
        return self._span[-1]

    def start(self, below: FloatArray) -> None:
        """psi on the ``reach`` panels below the first, (reach, m, nodes, n_k)."""
        self._psi = list(below)

    def drive(self, gain: FloatArray) -> FloatArray:
        """What psi of the next panel is made of besides a there, over the coupling.

        gain : of b on the panels below it, over the coupling; both (m, nodes, n_k)
        """
        used = gain.shape[0]
        self._back = np.zeros_like(gain)
        for j, moved in zip(self._span, self._moved, strict=True):
            if j:
                self._back += moved @ self._psi[-j][:used]
        self._back *= self._eps[:used]
        lost = self._collided[:used] @ self._back / self._coupling[:used]
        self._come = self._inner[:used] @ (gain - lost)
        return self._come

    def collided(self, a: FloatArray) -> FloatArray:
        """b of the panel of which a is now known, (m, nodes, n_k); its psi is kept."""
        used = a.shape[0]
        psi = self._coupling[:used] * (self._come - self.loss[:used] @ a)
        kept = np.zeros((self._coupling.size, *a.shape[1:]))
        kept[:used] = psi
        self._psi.append(kept)
        if len(self._psi) > self.reach:
            del self._psi[: len(self._psi) - self.reach]
        return np.asarray(a + self._back + self._own[:used] @ psi)
