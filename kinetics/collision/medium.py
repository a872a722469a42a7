r"""Scatterers at a finite density: how a tracer that meets them again changes the collision law.

In a medium of number density n (per d^2, d the contact distance) a tracer that is thrown back by a
second scatterer meets the first one again, and on its way it runs along a corridor that it knows to
be empty. In the clock of the path length, with K one collision and B a bounce straight back
(direction reversed, speed times e), both together replace

    K - 1  by  (K - 1)/(1 - eps B (K - 1)),      eps = (2 e/(1 + e)) n ln(1/n),

so that on v^p exp(i m phi) lambda_m(p) becomes lambda_m(p)/(1 + eps (-1)^m e^p lambda_m(p)). The
derivation is in examples/docs/theory/density.md, how far it agrees with simulations in
examples/docs/validation.md. Orders of the theory ("density_order"):

"leading" : the above, without any number that is fitted or integrated
"first" : the order n too. eps = (2 e/(1 + e)) n ln(1/(C n)) with a constant C(e; m) of each
    harmonic m = 0, 1, 2 (above, the leading order), and collisions 1 + d(e) n times as often. C and
    d are integrals over two scatterers and over loops, in returns.json
"second" : with terms of the order (n ln n)^2 in the path and in the harmonic m = 1, fitted to
    simulations. The default, because it is the nearest
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import cache, cached_property
from importlib.resources import files

import numpy as np

from kinetics.collision.bounce import ImpactQuadrature

SCATTERERS = ("dilute", "overlapping", "hard disks")
ORDERS = ("leading", "first", "second")
HIGHEST_DENSITY = 0.3  # n = rho d^2 above which nothing is tried
TESTED_DENSITY = 0.1  # and above which nothing was compared with simulations
# Simulations over n: the share of tracers slower than v, less 1 - e, and of those nearer than r
_SLOW, _NEAR = 1.15, 0.2
_LEAST_RESTITUTION = 0.2  # of the constants of the first order: below they are held
# Of the order (n ln n)^2, fitted (tests/kinetics/measurements/density.py): J_1(0) is less by
# (a + b n) e^2 and by (f + g n) sqrt(1 - e^2); paths are longer by 1.5 e (1 - e), and J_1(0), near
# 1.07 - .45 e, loses twice that, because <r^2> is not longer
_SECOND = {"overlapping": (1.4, 5.0), "hard disks": (1.4, 12.0)}
_LOSSY, _LONGER, _J1 = (0.29, 3.2), 1.5, (1.07, 0.45)


@dataclass(frozen=True)
class Medium:
    """Fixed smooth disks at a finite density, of restitution e: density is n = rho d^2."""

    scatterers: str
    density: float
    restitution: float
    order: str

    @cached_property
    def path_ratio(self) -> float:
        """The mean path between collisions over 1/(2 d rho), with 1 + d n of the order n.

        Overlapping disks leave it as it is (Santalo). Among hard disks it is (1 - eta)^2/(1 - 7
        eta/16), eta = pi n/4, the share of the area that disks cover (Henderson).
        """
        ratio = 1.0
        if self.scatterers == "hard disks":
            eta = 0.25 * math.pi * self.density
            ratio = (1.0 - eta) ** 2 / (1.0 - 7.0 * eta / 16.0)
        return ratio * (1.0 + self._longer) / (1.0 + self._row[0] * self.density)

    @property
    def _longer(self) -> float:
        """By how much paths are longer than to the order n."""
        e, n = self.restitution, self.density
        return _LONGER * e * (1.0 - e) * (n * math.log(n)) ** 2 if self.order == "second" else 0.0

    def returns(self, m: int) -> float:
        """eps: the chance per collision to be thrown back to the scatterer before."""
        e, n = self.restitution, self.density
        log_n = math.log(n)
        log = log_n + self._row[1 + m] if m in (0, 1, 2) else log_n
        eps = -2.0 * e / (1.0 + e) * n * log
        if m == 1 and self.order == "second":
            (a, b), (f, g) = _SECOND[self.scatterers], _LOSSY
            more = (a + b * n) * e * e + (f + g * n) * math.sqrt(1.0 - e * e)
            eps += more * (n * log_n) ** 2 + 2.0 * self._longer * (_J1[0] - _J1[1] * e)
        # returns of returns must add up, eps |lambda| < 1: above the tested densities only
        return min(eps, 0.45)

    def lowest_power(self, q: ImpactQuadrature) -> float:
        """p where eps e^p (1 + E[s^p]) = 1, q the average over a collision; -inf if nowhere."""
        from scipy.optimize import brentq

        largest = max(abs(self.returns(m)) for m in range(3))
        if self.restitution in (0.0, 1.0) or largest == 0.0:
            return -math.inf
        loss = -math.log(self.restitution)

        def log_size(p: float) -> float:  # it falls with p, and is negative at p = 0
            top = max(0.0, -p * float(q.log_loss.max()))  # for e near 0 s^p alone would overflow
            mean = top + math.log(float(np.exp(-p * q.log_loss - top) @ q.weight))
            return math.log(largest) - p * loss + float(np.logaddexp(0.0, mean))

        low = -1.0
        while log_size(low) < 0.0:
            low *= 2.0
        return float(brentq(log_size, low, 0.0, rtol=1e-12))

    @cached_property
    def _row(self) -> tuple[float, float, float, float]:
        """d, and ln C of the harmonics 0, 1 and 2; zeros at the leading order."""
        if self.order == "leading":
            return 0.0, 0.0, 0.0, 0.0
        e, table = max(self.restitution, _LEAST_RESTITUTION), _constants()
        # above .9 C(e; 0) is held: eps lambda_0 vanishes with 1 - e
        cooling = _interpolated(min(e, 0.9), table["restitution"], table["ln C 0"])
        rest = [_interpolated(e, table["restitution"], table[k]) for k in ("d", "ln C 1", "ln C 2")]
        return rest[0], cooling, rest[1], rest[2]

    @property
    def level(self) -> str:
        """The level of the theory in words."""
        what = {
            "leading": "order n ln n, no fitted number",
            "first": "order n, no fitted number",
            "second": "order n, and (n ln n)^2 fitted to simulations",
        }[self.order]
        if self.order != "leading" and self.restitution < _LEAST_RESTITUTION:
            what += f", with the constants of e = {_LEAST_RESTITUTION:g}"
        return f"{self.scatterers} at n = {self.density:g}: {what}"

    def limits(self, of_speeds: bool, of_displacements: bool) -> str:
        """What averages and these distributions lack, to follow a sentence; perhaps empty."""
        text = ""
        if self.density > TESTED_DENSITY:
            tested = f"was tested (up to {TESTED_DENSITY:g})"
            text = f"; n = {self.density:g} is outside the range where the correction {tested}"
        if of_speeds:
            share = f"by up to {(_SLOW - self.restitution) * self.density:.2g}, by slow ones"
            text += f"; the share of tracers slower than v is off {share}, of which the density "
            text += "may be negative"
        if of_displacements:
            near = f"{_NEAR * self.density:.2g}"
            text += f"; the share of tracers nearer than r is off by up to {near}"
        return text


@cache
def _constants() -> dict[str, list[float]]:
    """d and ln C of each harmonic, by restitution, from the file."""
    text = files("kinetics.collision").joinpath("returns.json").read_text("utf-8")
    table = json.loads(text)
    return {name: table[name] for name in ("restitution", "d", "ln C 0", "ln C 1", "ln C 2")}


def _interpolated(x: float, at: list[float], values: list[float]) -> float:
    """The cubic through the four nearest points."""
    near = sorted(range(len(values)), key=lambda i: abs(at[i] - x))[:4]
    total = 0.0
    for i in near:
        share = math.prod((x - at[j]) / (at[i] - at[j]) for j in near if j != i)
        total += share * values[i]
    return total
