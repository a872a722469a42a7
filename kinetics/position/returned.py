r"""Returns to the scatterer before, on the panels of a sweep (`kinetics.position.scattering`).

At a finite density (`kinetics.collision.medium`) collisions change a_m by

    psi = (K - 1)/(1 - eps S (K - 1)) a,      S f(X) = f(X + ln e),

K one collision and eps with the sign (-1)^m of a bounce straight back. With b = a + eps S psi this
is psi = (K - 1) b: collisions act on b, and psi at lower X says what has come back.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics import FloatArray
from kinetics.numerics.panels import PanelRule, PanelShifts

# Talbot's inversion of Laplace transforms (Weideman, SIAM J. Numer. Anal. 44 (2006) 2342): so many
# points leave 1e-10 of functions that fall. Chains of more bounces back weigh less than that.
_TALBOT, _MOST_BACK, _LEAST_BACK = 20, 20, 1e-11
_FALLEN = 60.0  # 2 e T/(1 + e) beyond which the density is below e^-60


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


def density_at_origin(law: CollisionLaw, path: FloatArray) -> FloatArray:
    """Of tracers on the line of their first flight that were only thrown straight back, at 0.

    path : T = v t/l, shape (n,). Per unit of l on the line, with the signs of the operator, so that
    F(k) tends to 2/K times it; without the tracers that have not collided. Shape (n,).

    After j bounces back a tracer has the speed e^j, and the operator leads from j to j + n at the
    rate -(-eps)^n e^j. In the Laplace transform over T this is a triangular matrix N - i k over the
    velocities; the integral over k makes half its matrix sign of it.
    """
    eps, e = abs(law.returns(3)[0]), float(np.exp(-law.returns(3)[1]))
    out = np.zeros(path.shape)
    near = (path > 0.0) & (2.0 * e * path < _FALLEN * (1.0 + e))
    if eps == 0.0 or not near.any():
        return out
    count = 2 + min(_MOST_BACK, int(np.log(_LEAST_BACK) / np.log(eps)))
    theta = (2.0 * np.arange(_TALBOT) + 1.0) * np.pi / _TALBOT - np.pi
    a, b, c = 0.5017, 0.6407, 0.2645  # of the contour, see the source
    scaled = a * theta / np.tan(b * theta) - 0.6122 + 1j * c * theta
    slope = a / np.tan(b * theta) - a * b * theta / np.sin(b * theta) ** 2 + 1j * c
    rate = _TALBOT * scaled / path[near][:, None]
    value = 0.5 * _column_of_sign(rate, e, eps, count) * np.exp(rate * path[near][:, None])
    total = (value * slope).sum(axis=1) / (1j * path[near])
    out[near] = total.real
    return out


def _column_of_sign(rate: NDArray[Any], e: float, eps: float, count: int) -> NDArray[Any]:
    """Sum over j > 0 of the first column of the sign of N, (-1)^j on its diagonal; shape of rate.

    Column by column from S N = N S and S S = 1 (Higham, Functions of Matrices, section 5.2).
    """
    j = np.arange(count)
    sign, speed = (-1.0) ** j, e**j
    sizes = (-eps) ** np.maximum(np.subtract.outer(j, j), 0) * speed / (sign * speed)[:, None]
    matrix = np.where(np.subtract.outer(j, j) > 0, sizes, 0.0)  # below the diagonal
    diagonal = [sign[i] * (1.0 + rate / speed[i]) for i in j]
    found: dict[tuple[int, int], Any] = {(i, i): sign[i] for i in j.tolist()}
    for apart in range(1, count):
        for low in range(count - apart):
            i, between = low + apart, range(low + 1, low + apart)
            if sign[i] == sign[low]:
                product = sum(found[i, k] * found[k, low] for k in between)
                found[i, low] = -product / (2.0 * sign[i])
            else:
                rest = matrix[i, low] * (sign[i] - sign[low])
                for k in between:
                    rest = rest + found[i, k] * matrix[k, low] - matrix[i, k] * found[k, low]
                found[i, low] = rest / (diagonal[i] - diagonal[low])
    return np.asarray(sum(found[i, 0] for i in range(1, count)))
