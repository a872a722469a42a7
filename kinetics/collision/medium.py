r"""Scatterers at a finite density: how a tracer that meets them again changes the collision law.

The kinetic equation of the paper forgets every scatterer that was hit. In a medium of number
density n (per d^2, d the contact distance) a tracer that is thrown back by a second scatterer meets
the first one again, and on its way it runs along a corridor that it knows to be empty. In the clock
of the path length, with K one collision and B a bounce straight back (direction reversed, speed
times e), both together replace

    K - 1  by  (K - 1)/(1 - eps B (K - 1)),      eps = (2 e/(1 + e)) n ln(1/n),

to the order n ln n, for every restitution e. On v^p exp(i m phi) all of these are numbers:

    lambda_m(p)  becomes  lambda_m(p)/(1 + eps (-1)^m e^p lambda_m(p)),

so that the integral over the path of <(v/v_0)^p cos(m (phi - phi_0))>, in mean free paths, is
1/lambda_m(p) + (-1)^m e^p eps. The paper has none of this; the coefficient 4/3 of the elastic gas
at m = 1, p = 0 is that of van Leeuwen and Weijland, Physica 36 (1967) 457.

Orders of the theory ("density_order"):

"leading" : the above, without any number that is fitted or integrated
"first" : the order n too. eps = (2 e/(1 + e)) n ln(1/(C n)) with a constant C(e; m) of each
    harmonic m = 0, 1, 2, and collisions 1 + d(e) n times as often. C and d are integrals over two
    scatterers and over loops, in returns.json (tests/kinetics/measurements/returns.py makes it).
    C depends on the power p of the speed: it is that of the average which is slowest, p = 1 for
    m = 0 and p = 0 for the others. For m > 2, and for e < 0.2, where many tracers end in corners
    of two disks, it is the leading order.
"second" : with a term of the order (n ln n)^2 in the harmonic m = 1, fitted to simulations

The default is "second", because it is the nearest. Deviations of <r^2> from simulations from
100 l/U on, in per cent, the largest of e = .3, .5, .7, .9 and of hard disks and overlapping ones;
their standard errors are .2 to .4, at n = .1 .4 to .7 (tests/kinetics/measurements/density.py):

    n      dilute    leading    first    second
    .02      11        1.5      1.3        .8
    .04      22        2.9      4.2        .9
    .1       47        9.5       19       3.4

v0 deviates by at most .6, .9 and 2.8 per cent in the last two. The returns need some free paths to
build up: before, <r^2> is too small. At n = .04 the simulations are above it by .9, 2.7 and 5.3 per
cent at 2 l/U (e = .4, .7, 1), by 1.0, 1.2 and 2.0 at 10 l/U, and by .6, .5 and .4 at 30 l/U.

Densities follow from the same operator. G(R) of hard disks at n = .04 and e = .7 (30,000 tracers,
2, 10 and 40 l/U) deviates from it by chi^2 = 6, 9 and 21 in 14 bins from R = .05 to 3.7, from the
dilute equation by 101, 69 and 59. At low speeds less is known: the constants C(e; 0) are those of
v_0. The speed density of the same disks, c = .03 to 3, has chi^2 = 66, 48 and 71 in 14 bins, at the
leading order 37, 7 and 37, and the dilute equation 21, 197 and 494; the largest differences are at
c < .4: there the particles are 8 to 27 per cent below the theory down to c = .1, at 2 l/U as at
40 l/U, and at 40 l/U above it by a factor 2 to 5 below c = .08.
The operator is no jump process: the speed density may fall below zero at low speeds. Among hard
disks at c > .01 it does not up to n = .02; at n = .04 below c = .11 for e = .2 (by up to .2 of its
maximum) and c = .02 for e = .3; at n = .1 below c = .2 for e <= .4 (by up to .7), and below c = .03
by less than .005 for e from .6 to .8.

The elastic diffusion coefficient is that of the Boltzmann equation times 1 + (4/3) n ln n + b n
- c (n ln n)^2, b = (4/3) ln C(1; 1) = 1.260(1). Measured among overlapping disks from n = .0025 to
.04, by <r^2> and by the integral over the path (commit 7baf535 has the script):
b = 1.31(4) and c = 2.2(2), with a term n^2 as well b = 1.20(9), and with the b of the theory
c = 2.04(6).
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import cache, cached_property
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.collision.law import CollisionLaw
from kinetics.validation import refuse

SCATTERERS = ("dilute", "overlapping", "hard disks")
ORDERS = ("leading", "first", "second")
HIGHEST_DENSITY = 0.3  # n = rho d^2 above which nothing is tried
TESTED_DENSITY = 0.1  # and above which nothing was compared with simulations
SETTLED = 30.0  # in l/U: the returns need some free paths to build up
_EARLY = 1.3  # at e = 1 and 2 l/U, see above
_LEAST_RESTITUTION = 0.2  # of the constants of the first order
_LAST_COOLING = 0.9  # above it C(e; 0) is held: eps lambda_0 vanishes with 1 - e
# Returns of returns must add up, eps |lambda| < 1: reached above the tested densities only.
_MOST_RETURNS = 0.45
# J_1(0) less (a + b n) (e n ln n)^2: fitted, see tests/kinetics/measurements/density.py
_SECOND = {"overlapping": (1.4, 5.0), "hard disks": (1.4, 12.0)}
_SWEEPS = 100  # of Newton's method: never reached


@dataclass(frozen=True)
class Medium:
    """Fixed disks at a finite density.

    Attributes
    ----------
    scatterers : "overlapping" (placed independently) or "hard disks"
    density : n = rho d^2, dimensionless
    restitution : e of smooth disks
    order : the level of the theory, one of ORDERS
    """

    scatterers: str
    density: float
    restitution: float
    order: str

    @cached_property
    def path_ratio(self) -> float:
        """The mean path between collisions over 1/(2 d rho), with 1 + d n of the order n.

        Overlapping disks leave it as it is at every density (Santalo). Among hard disks it is
        pi (free area)/(exposed arc), (1 - eta)^2/(1 - 7 eta/16) with eta = pi n/4, the share of
        the area that disks cover (Henderson's contact value of the pair distribution).
        """
        ratio = 1.0
        if self.scatterers == "hard disks":
            eta = 0.25 * math.pi * self.density
            ratio = (1.0 - eta) ** 2 / (1.0 - 7.0 * eta / 16.0)
        return ratio / (1.0 + self._row[0] * self.density)

    def returns(self, m: int) -> float:
        """eps: the chance per collision to be thrown back to the scatterer before."""
        e, n = self.restitution, self.density
        log = math.log(1.0 / n)
        if m in (0, 1, 2):
            log -= self._row[1 + m]
        eps = 2.0 * e / (1.0 + e) * n * log
        if m == 1 and self.order == "second":
            a, b = _SECOND[self.scatterers]
            eps += (a + b * n) * (e * n * math.log(n)) ** 2
        return min(eps, _MOST_RETURNS)

    @cached_property
    def _row(self) -> tuple[float, float, float, float]:
        """d, and ln C of the harmonics 0, 1 and 2; zeros at the leading order."""
        if self.order == "leading" or self.restitution < _LEAST_RESTITUTION:
            return 0.0, 0.0, 0.0, 0.0
        e, table = self.restitution, _constants()
        cooling = _interpolated(min(e, _LAST_COOLING), table["restitution"], table["ln C 0"])
        rest = [_interpolated(e, table["restitution"], table[k]) for k in ("d", "ln C 1", "ln C 2")]
        return rest[0], cooling, rest[1], rest[2]

    @property
    def level(self) -> str:
        """The level of the theory in words."""
        what = {
            "leading": "order n ln n, no fitted number",
            "first": "order n, no fitted number",
            "second": "order n, and (n ln n)^2 for <r^2>, fitted to simulations",
        }[self.order]
        if self.order != "leading" and self.restitution < _LEAST_RESTITUTION:
            what = f"order n ln n: constants of the order n begin at e = {_LEAST_RESTITUTION:g}"
        return f"{self.scatterers} at n = {self.density:g}: {what}"

    def limits(self, first: float) -> str:
        """What averages from this time on, in l/U, lack, to follow a sentence; perhaps empty."""
        found = ""
        if self.density > TESTED_DENSITY:
            found += f"; n = {self.density:g} is outside the range where the correction for the "
            found += f"density was tested (up to {TESTED_DENSITY:g})"
        if first < SETTLED:
            found += f"; <r^2> before {SETTLED:g} l/U is too small, by up to {_EARLY:g} n of itself"
        return found


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


@dataclass(frozen=True)
class MediumLaw(CollisionLaw):
    """A collision law whose operator knows that scatterers are met again, see :class:`Medium`.

    What belongs to one collision (``quadrature``, ``mean_cosine``, ``mean_speed_ratio_power``) is
    as without the medium; the rates of decay are those of the medium. ``lowest_power`` is that
    above which returns of returns add up to something finite: the operator means nothing for lower
    powers of the speed.
    """

    medium: Medium | None = None

    def density_theory(self, first: float) -> tuple[str, str]:
        """See :attr:`Medium.level` and :meth:`Medium.limits`."""
        return self._medium.level, self._medium.limits(first)

    @property
    def _medium(self) -> Medium:
        assert self.medium is not None
        return self.medium

    def mean_free_path(self, number_density: float, diameter: float) -> float:
        """The mean path between collisions in the medium, in the unit of the diameter."""
        return self._medium.path_ratio * super().mean_free_path(number_density, diameter)

    @property
    def described(self) -> str:
        """The arguments, for texts."""
        return f"{super().described}, scatterers={self._medium.scatterers!r}"

    def _exponents(self, p: ArrayLike) -> NDArray[Any]:
        if self.restitution and np.any(np.real(p) <= self.lowest_power):
            refuse("p", p, f"among these scatterers it must be above {self.lowest_power:g}")
        return super()._exponents(p)

    @property
    def _return_loss(self) -> float:
        """-ln e, what a bounce straight back costs."""
        assert self.restitution is not None
        return 0.0 - math.log(self.restitution)

    def returns(self, m: int) -> tuple[float, float]:
        """eps (-1)^m, and x = -ln e, of the bounces straight back; eps is 0 at e = 0.

        K - 1 on harmonic m is replaced by (K - 1)/(1 - eps S (K - 1)), S f(ln v) = f(ln v - x).
        """
        if self.restitution == 0.0:
            return 0.0, 0.0
        return self._medium.returns(m) * (-1.0) ** m, self._return_loss

    @cached_property
    def lowest_power(self) -> float:
        """Where eps e^p (1 + E[s^p]) = 1, and that of one collision if it is higher."""
        lowest = self._bounce.lowest_power
        largest = max(abs(self.returns(m)[0]) for m in range(3))
        if self.restitution in (0.0, 1.0) or largest == 0.0:
            return lowest
        loss, q = self._return_loss, self.quadrature
        # ln of the left-hand side is convex in p, and negative at p = 0: Newton's method
        p = 0.0
        for _ in range(_SWEEPS):
            top = max(0.0, -p * float(q.log_loss.max()))  # e near 0: s^p alone would overflow
            tilted = np.exp(-p * q.log_loss - top) * q.weight
            log_mean = top + math.log(tilted.sum())
            lost = float(tilted @ q.log_loss / tilted.sum())
            log_sum = float(np.logaddexp(0.0, log_mean))  # of 1 + E[s^p]
            log_size = math.log(largest) - p * loss + log_sum
            step = log_size / (-lost * math.exp(log_mean - log_sum) - loss)
            p -= step
            if abs(step) < 1e-9 * abs(p):
                break
        return max(p, lowest)

    def decay_symbol(self, z: NDArray[Any]) -> NDArray[Any]:
        """lambda(z) of the medium, shape of z; without checks of the range."""
        return self.met_again(z, super().decay_symbol(z), 0)

    def harmonic_decay_rate(self, p: ArrayLike, m: int) -> Any:
        """lambda_m(p) of the medium: see :meth:`CollisionLaw.harmonic_decay_rate`."""
        if m == 0:
            return self.decay_rate(p)
        rate = np.asarray(super().harmonic_decay_rate(p, m))
        return self.met_again(np.asarray(p), rate, m)[()]

    def met_again(self, z: NDArray[Any], rate: NDArray[Any], m: int) -> NDArray[Any]:
        """lambda_m of the medium at z from that of one collision, shape of z."""
        eps, loss = self.returns(m)
        return np.asarray(rate / (1.0 + eps * np.exp(-loss * z) * rate))

    def decay_taylor(self, z: NDArray[Any], orders: int) -> list[NDArray[Any]]:
        """Taylor coefficients of lambda at z, of the medium."""
        rate = [super().decay_symbol(z), *super().decay_taylor(z, orders)[1:]]
        return self.taylor_met_again(z, rate, 0)

    def taylor_met_again(self, z: Any, rate: list[NDArray[Any]], m: int) -> list[NDArray[Any]]:
        """Those of one collision, over those of 1 + eps (-1)^m e^z lambda_m(z)."""
        eps, loss = self.returns(m)
        orders = len(rate)
        back = [eps * np.exp(-loss * z)]
        for n in range(1, orders):
            back.append(back[-1] * (-loss / n))
        below = [sum(back[i] * rate[n - i] for i in range(n + 1)) for n in range(orders)]
        below[0] = below[0] + 1.0
        out: list[NDArray[Any]] = []
        for n in range(orders):
            known = sum((below[i] * out[n - i] for i in range(1, n + 1)), np.zeros_like(z))
            out.append(np.asarray((rate[n] - known) / below[0]))
        return out
