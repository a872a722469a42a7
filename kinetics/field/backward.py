"""Averages over time in a field, as functions of the velocity at time 0: the backward equation.

The mean y(v, t) of an observable, for tracers that start with the velocity v, obeys the adjoint
equation

    dy/dt = d_z y - v (1 - K) y + sources,       y(v, 0) = the observable itself

Sources make the displacement: x has the source v_x, x^2 has 2 v_x times the mean of x, and so on.
All observables of one family (even or odd across the field) are solved together.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.field.collisions import collision_matrices
from kinetics.field.ladder import Chain, Elimination
from kinetics.field.panels import SpeedPanels
from kinetics.field.radau import RadauRule
from kinetics.numerics import FloatArray

_RATIO = 3.0  # of the ends of a panel
_FEWEST = 6  # nodes of a panel: v^4 (1 - v t) is a polynomial on it
_STEEPEST = 30.0  # averages change no faster than v^30

# Observables of family 0, even across the field, and of family 1. The displacements come last in
# each, in the order in which one is a source of the next.
EVEN = ("v_x", "v^2", "v^2 cos 2", "v^3", "v^4", "collisions", "x")
ODD = ("v_y", "v_x v_y", "y")
SQUARES = ("x^2", "y^2")
PRODUCT = ("x y",)
ALL = (*EVEN, *SQUARES, *ODD, *PRODUCT)
IS_EVEN = np.array([name in (*EVEN, *SQUARES) for name in ALL])
_SOURCES = {"x^2": {"x"}, "y^2": {"y"}, "x y": {"x", "y", *SQUARES}}


def needed_for(asked: Iterable[str], symmetric: bool) -> frozenset[str]:
    """The observables to solve for those that are asked: with their sources, and their scales.

    symmetric : whether the start is symmetric about the field: averages that are odd across it
        vanish, and are not solved
    """
    wanted = {"v^2", *asked}
    if symmetric:
        wanted -= {*ODD, *PRODUCT}
    if wanted & {"x", "y"}:  # relative to the root mean square
        wanted |= {"x^2"} if symmetric else {*SQUARES}
    return frozenset(wanted.union(*(_SOURCES.get(name, set()) for name in wanted)))


def backward_panels(highest: float, lowest: float, nodes: int) -> SpeedPanels:
    """Panels for averages over time: up to a speed, the first one to about ``lowest``.

    Above the speed 1 each panel has ``nodes`` of them, and fewer below, where averages vary less.
    """
    count = max(1, math.ceil(math.log(highest / lowest) / math.log(_RATIO)))
    edges = [highest * _RATIO ** (j - count) for j in range(count + 1)]
    fewest = max(_FEWEST, nodes // 2)
    rising = max(1, math.ceil(-math.log(lowest) / math.log(_RATIO)))
    share = np.minimum(1.0, np.arange(1, count + 1) / rising)
    counts = np.ceil(fewest + (nodes - fewest) * share).astype(int)
    return SpeedPanels((0.0, *edges), (fewest, *counts.tolist()))


@dataclass
class BackwardField:
    """Takes the averages over one step of time after another.

    Parameters
    ----------
    law : the collision law
    panels : speeds at time 0
    highest : M, odd; harmonics 0 ... M
    names : the observables that are solved, from `needed_for`; the others stay 0
    rule : the collocation in time
    """

    law: CollisionLaw
    panels: SpeedPanels
    highest: int
    names: frozenset[str] = frozenset(ALL)
    rule: RadauRule = field(default_factory=RadauRule)

    def __post_init__(self) -> None:
        d = self.law.dimension
        self._chains = [Chain(self.panels, d, family, False) for family in (0, 1)]
        self._tops = [chain.highest(self.highest) for chain in self._chains]
        self._factors: dict[tuple[float, int], list[Elimination]] = {}

    @cached_property
    def collisions(self) -> FloatArray:
        """v^2 (1 - K_m), shape (M + 1, size, size)."""
        return collision_matrices(self.panels, self.law, self.highest, False, _STEEPEST)

    @property
    def start(self) -> FloatArray:
        """The observables themselves, shape (M + 1, size, n_observables), in the order of ALL."""
        v, d = self.panels.speeds, self.law.dimension
        y = np.zeros((self.highest + 1, v.size, len(ALL)))
        y[1, :, ALL.index("v_x")] = y[1, :, ALL.index("v_y")] = v
        y[2, :, ALL.index("v^2 cos 2")] = v**2
        for p in (2, 3, 4):
            y[0, :, ALL.index(f"v^{p}")] = v**p
        # sin(2 phi)/2 in the plane; of P_2^1 = 3 sin cos in space
        y[2, :, ALL.index("v_x v_y")] = v**2 / (2.0 if d == 2 else 3.0)
        return y * np.isin(ALL, list(self.names))

    def step(self, y: FloatArray, h: float) -> FloatArray:
        """The averages at all points of a step, shape (stages + 1, *y.shape)."""
        out = np.zeros((self.rule.stages + 1, *y.shape))
        out[0] = y
        for mode, (value, share, stages) in enumerate(self.rule.modes):
            rate = 1.0 / (h * value)
            source = share * rate * y
            found = np.zeros_like(source)
            source[0, :, ALL.index("collisions")] += share * self.panels.speeds
            source[1, :, ALL.index("x")] += share * self.panels.speeds
            source[1, :, ALL.index("y")] += share * self.panels.speeds
            for family, group in ((0, EVEN), (1, ODD), (0, SQUARES), (1, PRODUCT)):
                columns = self._columns(group)
                if columns and group is SQUARES:  # x and y, their sources, are there
                    self._add_products(source, found)
                if columns:
                    found[:, :, columns] = self._solve(family, h, mode, source[:, :, columns])
            out[1:] += (stages[:, None, None, None] * found).real
        return out

    def _solve(self, family: int, h: float, mode: int, source: NDArray[Any]) -> NDArray[Any]:
        """One stage of one family; its harmonics that do not exist are 0."""
        if (h, family) not in self._factors:
            self._factors[h, family] = self._eliminations(family, h)
        top, out = self._tops[family], np.zeros_like(source)
        part = source[family : top + 1] * self.panels.speeds[:, None]
        out[family : top + 1] = self._factors[h, family][mode].solve(part)[0]
        return out

    def _columns(self, group: tuple[str, ...]) -> list[int]:
        """Where the observables of a group are that are solved."""
        return [ALL.index(name) for name in group if name in self.names]

    def _eliminations(self, family: int, h: float) -> list[Elimination]:
        shifts = [1.0 / (h * value) for value, _, _ in self.rule.modes]
        return [
            Elimination(
                self._chains[family],
                self.collisions,
                None,
                sign=-1.0,
                shift=shift.real if shift.imag == 0.0 else shift,
            )
            for shift in shifts
        ]

    def _add_products(self, source: NDArray[Any], found: NDArray[Any]) -> None:
        """Add 2 v_x x, 2 v_y y and v_x y + v_y x to the sources of x^2, y^2 and x y.

        In space the average of v_y y over the azimuth: states are symmetric about the field.
        """
        x, y = found[:, :, ALL.index("x")], found[:, :, ALL.index("y")]
        v, even, odd = self.panels.speeds, *self._chains
        squares = [ALL.index(name) for name in SQUARES]
        for m in range(self.highest + 1):
            for n, factor in ((m + 1, even.up(m)), (m - 1, even.down(m) if m else 0.0)):
                if 0 <= n <= self.highest and factor:
                    source[m, :, squares[0]] += 2.0 * factor * v * x[n]
                    source[m, :, squares[1]] += 2.0 * self._across(m, n) * v * y[n]
            if self.law.dimension == 2 and m > 0:
                for n, factor in ((m + 1, odd.up(m)), (m - 1, odd.down(m))):
                    if n <= self.highest:
                        source[m, :, -1] += factor * v * y[n]
                        twice = 2.0 if n == 0 else 1.0
                        source[m, :, -1] += (0.5 if n < m else -0.5) * twice * v * x[n]

    def _across(self, m: int, n: int) -> float:
        """What harmonic n of y adds to harmonic m of v_y y/v, n = m + 1 or m - 1."""
        if self.law.dimension == 2:
            return 0.5 if n > m else -0.5
        if n > m:
            return 0.5 * (m + 1.0) * (m + 2.0) / (2.0 * m + 3.0)
        return -0.5 * (m - 1.0) * m / (2.0 * m - 1.0)

    def forget(self, h: float) -> None:
        """Free the memory of steps of another length than h."""
        self._factors = {key: value for key, value in self._factors.items() if key[0] == h}

    def scattered(self, y: FloatArray, transposed: bool = False) -> FloatArray:
        """K_m y_m, the harmonics of the mean after a collision; shape of y (..., M + 1, size, n).

        transposed : applies the transposed matrices, to weights of an average
        """
        kept = np.eye(self.panels.size) - self.collisions / self.panels.speeds[:, None] ** 2
        return np.asarray(np.matmul(kept.swapaxes(1, 2) if transposed else kept, y))
