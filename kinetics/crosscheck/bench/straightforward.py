r"""The solver that a user would write: uniform speeds, a dense gain matrix, BDF. For comparison.

The isotropic inelastic Lorentz equation (paper, label ``inelaslorentz2``) for masses p_j at the
speeds v_j = j dv is the linear system

    dp/dt = (G - 1) diag(v) p / l,     G_ij : the share of bounces at v_j that arrive at v_i.

G is projected on hat functions exactly, so that mass and <v> of a bounce are exact; the scheme is
of second order in dv. It gets its exact Jacobian. It shares nothing with the solvers of the
package; the collision enters through y(s) = sqrt((s^2 - e^2)/(1 - e^2)), 0 <= e < 1.

Lengths in d, speeds in U, times in d/U.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

FloatArray = NDArray[np.float64]

FASTEST = {"gaussian": 8.0, "monoenergetic": 1.0}
"""Largest speed of the grid in U: e^-32 of the Gaussian lies above it, and speeds never grow."""


def gain_matrix(restitution: float, nodes: int) -> FloatArray:
    """G, shape (nodes, nodes), upper triangular; columns sum to 1.

    Node i of column j stands for the speed ratio i/j. A hat function is a second difference of
    ramps, and the mean of a ramp over the impact parameter is elementary:
    E[(s - S)_+] = (s sqrt(s^2 - e^2) - e^2 ln((s + sqrt(s^2 - e^2))/e)) / (2 sqrt(1 - e^2)).
    """
    e = restitution
    j = np.arange(1.0, nodes)
    i = np.arange(-1.0, nodes + 1.0)
    s = np.clip(i[:, None] / j, e, 1.0)
    root = np.sqrt((s - e) * (s + e))
    ramp = s * root
    if e > 0.0:
        ramp -= e * e * np.log((s + root) / e)
    ramp /= 2.0 * math.sqrt((1.0 - e) * (1.0 + e))
    ramp += np.maximum(i[:, None] / j - 1.0, 0.0)  # every bounce ends below s = 1
    gain = np.zeros((nodes, nodes))
    gain[:, 1:] = np.triu(j * (ramp[2:] - 2.0 * ramp[1:-1] + ramp[:-2]), k=-1)[:nodes]
    gain[0, 0] = 1.0
    return gain


def solve_cooling(
    restitution: float,
    mean_free_path: float,
    initial: str,
    times: FloatArray,
    nodes: int,
    rtol: float,
) -> tuple[FloatArray, FloatArray]:
    """v0(t) in U and a2(t), shape (n_times,) each, from a "gaussian" or a "monoenergetic" start.

    0 <= e < 1. NaN at the times that the integration did not reach.
    """
    v = np.linspace(0.0, FASTEST[initial], nodes)
    if initial == "gaussian":
        p = v * np.exp(-0.5 * v * v)
        p /= p.sum()
    else:
        p = np.zeros(nodes)
        p[-1] = 1.0
    matrix = (gain_matrix(restitution, nodes) - np.eye(nodes)) * (v / mean_free_path)
    result = solve_ivp(
        lambda t, y: matrix @ y,
        (0.0, float(times[-1])),
        p,
        method="BDF",
        t_eval=times,
        jac=matrix,
        rtol=rtol,
        atol=rtol * p.max(),
    )
    out = np.full((2, times.size), np.nan)
    second, fourth = v**2 @ result.y, v**4 @ result.y
    done = second.size
    with np.errstate(divide="ignore", invalid="ignore"):
        out[0, :done] = np.sqrt(np.where(second > 0.0, second, np.nan))
        out[1, :done] = 0.5 * fourth / second**2 - 1.0
    return out[0], out[1]


@dataclass(frozen=True)
class Scaled:
    """The scaling state: y = v t/l on the grid and its density, and what follows from them."""

    y: FloatArray
    density: FloatArray

    def mean(self, p: float) -> float:
        """E[y^p], p > 0."""
        return float(self.y**p @ self.density) * float(self.y[1])

    @property
    def cooling_rate(self) -> float:
        """h = 2/sqrt(E[y^2]), from v0 = 2 l/(h t) (paper, label ``compare2``)."""
        return 2.0 / math.sqrt(self.mean(2.0))

    @property
    def a2(self) -> float:
        """<c^4>/2 - 1."""
        return 0.5 * self.mean(4.0) / self.mean(2.0) ** 2 - 1.0

    def vdf(self, c: FloatArray) -> FloatArray:
        """F(c) by cubic splines, c > 0."""
        unit = math.sqrt(self.mean(2.0))
        density = CubicSpline(self.y, self.density)(c * unit)
        return np.asarray(np.where(c * unit <= self.y[-1], density, 0.0) * unit / (2 * math.pi * c))


def solve_scaled(restitution: float, nodes: int, fastest: float) -> Scaled:
    """The stationary state of y = v t/l on 0 <= y <= fastest, by one dense solve.

    0 = -d(y g)/dy - y g + gain. Quicker than marching to it with BDF.
    """
    y = np.linspace(0.0, fastest, nodes)
    inner = np.arange(nodes - 1)
    matrix = (gain_matrix(restitution, nodes) - np.eye(nodes)) * y
    # -d(y g)/dy from y (g + g)/2 at the middles between nodes; nothing passes the ends, and the
    # equation of node 0, which stands for half a cell, is that of its mass
    half = 0.5 * (inner + 0.5)
    matrix[inner, inner] -= half
    matrix[inner, inner + 1] -= half
    matrix[inner + 1, inner] += half
    matrix[inner + 1, inner + 1] += half
    # the equations sum to zero: the last one gives way to the norm
    matrix[-1] = y[1]
    matrix[-1, [0, -1]] *= 0.5
    right = np.zeros(nodes)
    right[-1] = 1.0
    return Scaled(y, np.asarray(np.linalg.solve(matrix, right)))
