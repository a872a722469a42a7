"""The speed axis: Gauss-Legendre nodes on panels of any length, joined by one-sided values.

Functions are polynomials on each panel, and need not be continuous. Tracers gain and lose speed, so
a panel needs values from both neighbours: the derivative of an even harmonic, which acts on odd
ones, takes that at its upper end from the panel above; that of an odd one takes that at the lower
end from the panel below. At rest nothing is imposed. Integrals by parts with the volume v^(d-1) dv
hold exactly for the sums over the nodes: without collisions the integral of the square of a
function is conserved, as it is for tracers that fall freely, and no error grows over time.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise, product
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebvander
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import gauss_legendre, panels_between

_RATIO = 3.0  # of the ends of a panel, at most
_FEWEST = 6  # nodes of a panel: v^4 (1 - v t) is a polynomial on it


@dataclass(frozen=True)
class Resolution:
    """How finely the velocity, and the time, are resolved.

    nodes : of a panel of speeds
    harmonics : M, odd; harmonics 0 ... M are solved
    lowest : the first panel is so long, of the usual speed
    rtol : what speeds above the highest, and a step of time, may miss
    step : the first step of time, over the longest: a finer solution has others
    """

    nodes: int
    harmonics: int
    lowest: float
    rtol: float
    step: float = 1.0

    @classmethod
    def steady(cls, rtol: float, harmonics: int) -> Resolution:
        """One for the density of the steady state; harmonics : as many as averages need."""
        digits = -math.log10(max(rtol, 1e-12))
        nodes = max(math.ceil(4.4 + 0.85 * digits), _FEWEST)
        return cls(nodes, harmonics | 1, 0.35 * 10.0 ** (-digits / 6.0), 10.0**-digits)

    @classmethod
    def over_time(cls, rtol: float) -> Resolution:
        """A first one for averages and densities over time."""
        digits = -math.log10(max(rtol, 1e-7))  # more takes a minute
        nodes = max(math.ceil(2.5 + 1.3 * digits), _FEWEST)
        harmonics = 2 * math.ceil(max(digits, 4.0)) - 1
        return cls(nodes, harmonics, 0.6 * 10.0 ** (-digits / 6.0), 2.0 * 10.0**-digits)

    def finer(self) -> Resolution:
        """With more nodes and harmonics, and shorter steps.

        Nodes grow fastest: of a start of one speed, or from rest, averages miss what a polynomial
        misses at one point, and four more nodes leave a tenth of that.
        """
        return Resolution(
            nodes=self.nodes + 4,
            harmonics=self.harmonics + 2 * math.ceil(self.harmonics / 6),
            lowest=0.7 * self.lowest,
            rtol=0.1 * self.rtol,
            step=0.7 * self.step,
        )


@dataclass(frozen=True)
class SpeedPanels:
    """Panels from rest to the largest speed.

    edges : ends of the panels, rising from 0, n_panels + 1 of them
    counts : nodes of each panel, n_panels of them
    """

    edges: tuple[float, ...]
    counts: tuple[int, ...]

    @classmethod
    def rising(cls, highest: float, lowest: float, nodes: int, tail: bool = False) -> SpeedPanels:
        """Panels up to a speed, the first one to ``lowest`` if that is below it.

        Above the speed 1 each has ``nodes`` nodes, and fewer below, where averages vary less.
        tail : whether the last one is cut in two, so that the density is resolved that falls there
        """
        lowest = min(lowest, highest / _RATIO)
        count = math.ceil(math.log(highest / lowest) / math.log(_RATIO))
        edges = np.geomspace(lowest, highest, count + 1).tolist()
        fewest = max(_FEWEST, nodes // 2)
        rising = max(1, math.ceil(-math.log(lowest) / math.log(_RATIO)))
        share = np.minimum(1.0, np.arange(1, count + 1) / rising)
        counts = np.ceil(fewest + (nodes - fewest) * share).astype(int)
        if tail:
            edges.insert(-1, 0.5 * (edges[-2] + highest))
            counts = np.append(counts, nodes)
        return cls((0.0, *edges), (fewest, *counts.tolist()))

    @cached_property
    def parts(self) -> list[slice]:
        """Where the nodes of each panel are."""
        ends = np.cumsum([0, *self.counts]).tolist()
        return [slice(a, b) for a, b in pairwise(ends)]

    @property
    def size(self) -> int:
        """The number of nodes."""
        return sum(self.counts)

    @property
    def highest(self) -> float:
        """The largest speed."""
        return self.edges[-1]

    @cached_property
    def speeds(self) -> FloatArray:
        """The nodes, shape (size,)."""
        panels = zip(self.edges[:-1], self.edges[1:], self.counts, strict=True)
        return np.concatenate([a + (b - a) * gauss_legendre(n)[0] for a, b, n in panels])

    @cached_property
    def weights(self) -> FloatArray:
        """Of the integral over the speed, shape (size,)."""
        panels = zip(self.edges[:-1], self.edges[1:], self.counts, strict=True)
        return np.concatenate([(b - a) * gauss_legendre(n)[1] for a, b, n in panels])

    def volumes(self, dimension: int) -> FloatArray:
        """By which f at a node is a sum, whose total is the integral of f over all v, (size,)."""
        return np.asarray(self.speeds ** (dimension - 1.0) * self.weights)

    def panel_of(self, v: FloatArray) -> NDArray[np.intp]:
        """The panel in which each speed lies; the last one above all, shape of v."""
        return np.clip(np.searchsorted(self.edges, v, side="left") - 1, 0, len(self.counts) - 1)

    def polynomials(self, panel: int, v: FloatArray) -> FloatArray:
        """Chebyshev's of a panel at speeds in it, (*v.shape, nodes)."""
        low, high = self.edges[panel : panel + 2]
        return np.asarray(chebvander(2.0 * (v - low) / (high - low) - 1.0, self.counts[panel] - 1))

    @cached_property
    def to_coefficients(self) -> list[FloatArray]:
        """From values at the nodes of a panel to coefficients of these, (nodes, nodes) each."""
        parts = enumerate(self.parts)
        found = (np.linalg.inv(self.polynomials(p, self.speeds[part])) for p, part in parts)
        return [np.asarray(each, dtype=float) for each in found]

    def rows(self, panel: int, v: FloatArray) -> FloatArray:
        """Interpolation in a panel to speeds in it, (*v.shape, nodes)."""
        return self.polynomials(panel, v) @ self.to_coefficients[panel]

    def derivative(self, panel: int) -> FloatArray:
        """d/dv of polynomials at the nodes of a panel, shape (nodes, nodes)."""
        low, high = self.edges[panel : panel + 2]
        values = self.polynomials(panel, self.speeds[self.parts[panel]])[:, :-1]
        return values @ chebder(self.to_coefficients[panel], scl=2.0 / (high - low))

    def interpolation(self, v: FloatArray, parity: int = 0) -> FloatArray:
        """Rows that take values at the nodes to those at speeds v (n,): shape (n, size)."""
        del parity  # of the function: all are polynomials
        out = np.zeros((v.size, self.size))
        panel = self.panel_of(v)
        for p in np.unique(panel):
            at = np.nonzero(panel == p)[0]
            out[at, self.parts[p]] = self.rows(p, v[at])
        return out

    def averaged(self, density: Callable[[FloatArray], Any], parity: int, kinks: Any) -> Any:
        """Averages, over a density of the speed, of the polynomials of each node, (size,)."""
        edges = np.union1d(self.edges, kinks)
        v, w = panels_between(edges[edges <= self.highest], max(self.counts) + 2)
        return (w * density(v)) @ self.interpolation(v, parity)

    def slopes(self, dimension: int) -> tuple[FloatArray, FloatArray]:
        """d/dv of even and of odd harmonics, from sums to sums, shape (size, size) each.

        Even harmonics are 0 at the highest speed; on odd ones nothing is imposed there.
        Source: the strong form of the discontinuous Galerkin method; Hesthaven and Warburton,
        Nodal Discontinuous Galerkin Methods, section 3.2.
        """
        both = np.zeros((2, self.size, self.size))
        last = len(self.counts) - 1
        for (p, part), even in product(enumerate(self.parts), (True, False)):
            nodes, out = self.speeds[part], both[0 if even else 1]
            out[part, part] = self.derivative(p)
            for sign in (1, -1):
                neighbour, end = p + sign, self.edges[p + (sign > 0)]
                if end == 0.0 or not (even == (sign > 0) or (p == last and neighbour > last)):
                    continue
                own = self.rows(p, np.array([end]))[0]
                jump = sign * own * (end / nodes) ** (dimension - 1) / self.weights[part]
                out[part, part] -= np.outer(jump, own)
                if neighbour <= last:
                    row = self.rows(neighbour, np.array([end]))
                    out[part, self.parts[neighbour]] += np.outer(jump, row)
        volumes = self.volumes(dimension)
        both *= volumes[:, None] / volumes
        return both[0], both[1]


#: f falls no faster than v^-70 where it counts: for the average over impacts. Origin not recorded.
FASTEST_POWER = 70.0
_SMALL = 0.1  # -ln s below which changes of polynomials would lose digits
_STOPPED = 14.0  # -ln s of bounces that count as one: so slow tracers, 1e-6, are as few as that


def bounces(
    law: CollisionLaw, rate: float, highest: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """What harmonics keep and lose in bounces, (highest + 1, n) each, and -ln s of these, (n,).

    For functions as fast as s^rate; all bounces that nearly stop a tracer are one.
    """
    q = law.quadrature_for(rate, highest // 2)
    gone = np.array(list(q.harmonic_losses(highest)))
    kept, gone, lost = q.weight * (1.0 - gone), q.weight * gone, q.log_loss
    stopped = lost > _STOPPED
    if stopped.any():
        kept, gone = (np.c_[x[:, ~stopped], x[:, stopped].sum(axis=1)] for x in (kept, gone))
        mean = q.weight[stopped] @ q.ratio[stopped] / q.weight[stopped].sum()
        lost = np.append(lost[~stopped], -np.log(mean))
    return kept, gone, lost


def loss_matrices(panels: SpeedPanels, law: CollisionLaw, highest: int) -> FloatArray:
    """What harmonics 0 ... highest of a density lose by collisions per unit time, less their gain.

    Shape (highest + 1, size, size). A tracer of speed v collides at the rate v, and leaves with
    v s; of harmonic m cos(m chi) is kept, in space P_m(cos chi). Integrals over the speed are split
    where tracers change to another panel, so mass and the balance of each power of the speed are
    kept, also of densities that are not smooth. Only what changes in a bounce is summed: no digits
    are lost as bounces become elastic.
    """
    kept, gone, lost = bounces(law, FASTEST_POWER, highest)
    ratio, edges, d = np.exp(-lost), np.array(panels.edges), law.dimension
    out = np.zeros((highest + 1, panels.size, panels.size))
    for p, source in enumerate(panels.parts):
        for t, target in enumerate(panels.parts[: p + 1]):
            low = np.maximum(edges[p], edges[t] / ratio)
            width = np.minimum(edges[p + 1], edges[t + 1] / ratio) - low
            if t == p - 1:  # to all digits
                short = np.minimum(edges[p] * np.expm1(lost), width)
                width = np.where(lost < _SMALL, short, width)
            used = np.nonzero(width > 0.0)[0]
            if used.size == 0:
                continue
            x, w = gauss_legendre(max(panels.counts[p], panels.counts[t]) + 1)
            v = low[used, None] + width[used, None] * x  # (n_used, n_points)
            weight = width[used, None] * w * v**d  # the volume, and the rate of collisions
            change = -np.expm1(-lost[used])[:, None] * v
            before = panels.rows(p, v)
            weighed = weight[..., None] * before
            loss = np.tensordot(gone[:, used], np.matmul(before.swapaxes(1, 2), weighed), axes=1)
            after = panels.rows(t, v - change)
            if t == p:
                changed = before - after
                small = np.nonzero(lost[used] < _SMALL)[0]
                if small.size:
                    changed[small] = _changes(panels, p, v[small], change[small])
            else:
                gained = np.matmul(after.swapaxes(1, 2), weighed)
                out[:, target, source] -= np.tensordot(kept[:, used], gained, axes=1)
                changed = before
            changed = np.matmul(changed.swapaxes(1, 2), weighed)
            out[:, source, source] += loss + np.tensordot(kept[:, used], changed, axes=1)
    return np.asarray(out / panels.volumes(d))


def _changes(panels: SpeedPanels, panel: int, v: FloatArray, change: FloatArray) -> FloatArray:
    """Polynomials at v less those at v - change, (*v.shape, nodes): integrals of their slope."""
    x, w = gauss_legendre(panels.counts[panel] // 2)
    parts = zip(x, w, strict=True)
    slopes = sum(share * panels.rows(panel, v - point * change) for point, share in parts)
    return np.asarray(change[..., None] * (slopes @ panels.derivative(panel)))
