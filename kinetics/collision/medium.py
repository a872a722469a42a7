r"""Scatterers at a finite density: how a tracer that meets them again changes the collision law.

In a medium of number density n (per d^2, d the contact distance) a tracer that is thrown back by a
second scatterer meets the first one again, and on its way it runs along a corridor that it knows to
be empty. e is the restitution, m an angular harmonic, p a power of the speed, and lambda_m(p) = 1 -
E[s^p cos(m chi)] what a collision (speed ratio s, deflection chi) takes of their average. In the
clock of the path length, with K one collision and B a bounce straight back (direction reversed,
speed times e), both together replace

    K - 1  by  (K - 1)/(1 - eps B (K - 1)),      eps = (2 e/(1 + e)) n ln(1/n),

so that on v^p exp(i m phi) lambda_m(p) becomes lambda_m(p)/(1 + eps (-1)^m e^p lambda_m(p)). The
derivation is in examples/docs/theory/density.md, how far it agrees with simulations in
examples/docs/validation.md. Orders of the theory ("density_order"):

"leading" : the above, without any number that is fitted or integrated
"first" : the order n too. eps = (2 e/(1 + e)) n ln(1/(C n)) with a constant C(e; m) of each
    harmonic m = 0, 1, 2 (above, the leading order), and collisions 1 + d(e) n times as often. C and
    d are integrals over two scatterers and over loops (`kinetics.collision.return_constants`)
"second" : with terms of the next order in the path and in the harmonic m = 1, fitted to
    simulations. The default, because it is the nearest

Begin with :meth:`Medium.returns`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from kinetics.collision.quadrature import ImpactQuadrature, Numbers
from kinetics.collision.return_constants import OF_SPEED as OF_SPEED
from kinetics.collision.return_constants import ReturnConstants, constants_at
from kinetics.scatterers import SCATTERERS, usual_word
from kinetics.validation import check_positive, one_of, refuse

#: The orders of the theory, see the module.
ORDERS = ("leading", "first", "second")

#: Largest n = rho d^2 that is allowed. Chosen: three times `TESTED_DENSITY`; the theory is of first
#: order in n.
HIGHEST_DENSITY = 0.3
#: Smallest one. Chosen: so that the mean free path, of the order of d/n, is finite.
LEAST_DENSITY = 1e-300
#: Largest n of the simulations that its fitted terms are from. Its error is measured up to
#: `HIGHEST_DENSITY` (`kinetics.collision.measured_errors`).
TESTED_DENSITY = 0.1
#: Smallest e of the constants of the first order: below they are held. It is where the table ends.
LEAST_RESTITUTION = 0.2
#: How fast near loops are cut off, per l: exp(-R (1 + |delta|/4)) averaged. Chosen: a rate of the
#: order of 1/l; at twice <v(0).v(t)> at late times, which is small, moves by 0.1 of itself.
CORRIDOR = 0.6
#: Largest eps. Chosen: returns of returns must add up, eps |lambda| < 1, and lambda is 2 at most.
#: It is reached above the tested densities only.
MAX_RETURNS = 0.45

# Fitted (tests/kinetics/measurements/density.py). In the order (n ln n)^2 J_1(0), the way of a
# tracer, is less by (a + b n) e^2 + (f + g n) sqrt(1 - e^2).

#: a and b of (a + b n) e^2, by the scatterers. Fitted, as above.
SHORTER_WAY = {"overlapping disks": (1.4, 5.0), "hard disks": (1.4, 12.0)}
#: f of (f + g n) sqrt(1 - e^2). Fitted, as above.
SHORTER_WAY_LOSSY = 0.2
#: g of the same. Fitted, as above.
SHORTER_WAY_LOSSY_PER_DENSITY = 3.2
#: Paths are longer by this times e (1 - e) n^2 ln(1/n). Fitted, as above.
LONGER_PATH = 4.0
#: J_1(0), near 1.07 - 0.45 e, loses twice what paths are longer by, because <r^2> is not longer.
#: The origin of both numbers is not recorded.
WAY_AT_REST = 1.07
#: By how much J_1(0) is less at e = 1 than at e = 0; origin as of `WAY_AT_REST`.
WAY_FALL = 0.45


def word_for_scatterers(scatterers: object, more: tuple[str, ...] = ()) -> str:
    """Return the word of `SCATTERERS` for scatterers; InputError for what is no such word.

    Parameters
    ----------
    scatterers : what a user gave
    more : other words that are allowed
    """
    if isinstance(scatterers, str):
        scatterers = usual_word(scatterers)
    return one_of("scatterers", scatterers, (*more, *SCATTERERS))


class BounceArguments(Protocol):
    """The arguments of a collision law by which it is decided whether a medium is derived."""

    @property
    def restitution(self) -> float | None:
        """e; None for samples and mixtures."""

    @property
    def tangential_restitution(self) -> float | None:
        """et; None for samples and mixtures."""

    @property
    def dimension(self) -> int:
        """2 or 3."""

    @property
    def mass_ratio(self) -> float:
        """The mass of a scatterer over that of the tracer."""


@dataclass(frozen=True)
class Medium:
    """Fixed smooth disks at a finite density.

    Parameters
    ----------
    scatterers : "overlapping disks" or "hard disks"
    density : n = rho d^2
    restitution : e
    order : of the theory, one of `ORDERS`
    """

    scatterers: str
    density: float
    restitution: float
    order: str

    @classmethod
    def checked(
        cls,
        law: BounceArguments,
        scatterers: object,
        number_density: object,
        diameter: object,
        order: object,
    ) -> Medium | None:
        """Return what a law finds among these scatterers; None where they are dilute.

        Raises
        ------
        InputError
            An argument is out of range, or the theory is not derived there: rough or moving
            scatterers, spheres, samples, mixtures.
        """
        scatterers = word_for_scatterers(scatterers)
        order = one_of("density_order", order, ORDERS)
        if scatterers == "dilute":
            return None
        must = f"with scatterers={scatterers!r} it must be"
        if law.mass_ratio < math.inf:
            refuse("mass_ratio", law.mass_ratio, f"{must} inf: fixed")
        if law.restitution is None or law.dimension == 3 or law.tangential_restitution != 1.0:
            refuse("scatterers", scatterers, "a finite density is derived for smooth disks only")
        rho = check_positive("number_density", number_density)
        d = check_positive("diameter", diameter)
        density = rho * d * d
        if not LEAST_DENSITY < density <= HIGHEST_DENSITY:
            refuse("number_density", number_density, f"{must} at most {HIGHEST_DENSITY:g} d^-2")
        return cls(scatterers, density, law.restitution, order)

    @cached_property
    def constants(self) -> ReturnConstants:
        """The constants of this restitution; at the leading order there are none."""
        if self.order == "leading":
            return ReturnConstants()
        return constants_at(self.restitution)

    # -- the path ---------------------------------------------------------------------------------

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
        collisions = 1.0 + self.constants.more_collisions * self.density
        return ratio * (1.0 + self._longer_path) / collisions

    @property
    def _longer_path(self) -> float:
        """By how much paths are longer than to the order n."""
        if self.order != "second":
            return 0.0
        e = self.restitution
        n = self.density
        return -LONGER_PATH * e * (1.0 - e) * n * n * math.log(n)

    # -- returns to the scatterer before ----------------------------------------------------------

    @property
    def _straight_back(self) -> float:
        """What eps has before its logarithm: n times collisions that go straight back, by angle."""
        return 2.0 * self.restitution / (1.0 + self.restitution) * self.density

    def returns(self, m: int) -> tuple[float, float]:
        """Return eps (-1)^m and -ln e of the bounces straight back; both are 0 where none comes.

        eps is the chance per collision to be thrown back to the scatterer before.
        """
        if self.restitution == 0.0:
            return 0.0, 0.0
        log_c = self.constants.log_c[m] if 0 <= m <= 2 else 0.0
        eps = -self._straight_back * (math.log(self.density) + log_c)
        if m == 1 and self.order == "second":
            eps += self._second_order_of_way()
        return (-1.0) ** m * min(eps, MAX_RETURNS), -math.log(self.restitution)

    def _second_order_of_way(self) -> float:
        """Return what the order after the first adds to eps of the harmonic m = 1."""
        e = self.restitution
        n = self.density
        constant, per_density = SHORTER_WAY[self.scatterers]
        shorter = (constant + per_density * n) * e * e
        shorter += (SHORTER_WAY_LOSSY + SHORTER_WAY_LOSSY_PER_DENSITY * n) * math.sqrt(1.0 - e * e)
        way = WAY_AT_REST - WAY_FALL * e
        return shorter * (n * math.log(n)) ** 2 + 2.0 * self._longer_path * way

    @property
    def of_speed(self) -> tuple[float, float]:
        """What brings powers of the speed back at once, as `returns`; no loops are in it."""
        constants = self.constants
        return self._straight_back * constants.at_once, -math.log(constants.ratio_at_once)

    @property
    def far_loops(self) -> tuple[float, float, float]:
        """Loops of the size of l, of powers of the speed: speed ratio, path b/l, and their eps."""
        constants = self.constants
        eps = self._straight_back * constants.loops
        return constants.ratio_of_loops, constants.path_of_loops, eps

    def met_again(self, z: Numbers, rate: list[Numbers], m: int) -> list[Numbers]:
        """Return the Taylor coefficients of lambda_m with returns: lambda/(1 + b lambda).

        Parameters
        ----------
        z : powers of the speed
        rate : Taylor coefficients of lambda_m at z without returns, each of the shape of z
        m : the harmonic, of b = eps (-1)^m e^z
        """
        eps, loss = self.returns(m)
        b = [eps * np.exp(-loss * z) * (-loss) ** n / math.factorial(n) for n in range(len(rate))]
        product = []  # b lambda
        with_returns: list[Numbers] = []
        for n in range(len(rate)):
            coefficient = np.zeros_like(z)
            for i in range(n + 1):
                coefficient = coefficient + b[i] * rate[n - i]
            product.append(coefficient)
            of_lower_orders = np.zeros_like(z)
            for i in range(1, n + 1):
                of_lower_orders = of_lower_orders + product[i] * with_returns[n - i]
            with_returns.append(np.asarray((rate[n] - of_lower_orders) / (1.0 + product[0])))
        return with_returns

    def lowest_power(self, q: ImpactQuadrature) -> float:
        """Return p where eps e^p (1 + E[s^p]) = 1; -inf if nowhere.

        Parameters
        ----------
        q : the average over a collision
        """
        from scipy.optimize import brentq

        largest_eps = max(abs(self.returns(m)[0]) for m in range(3))
        if self.restitution in (0.0, 1.0) or largest_eps == 0.0:
            return -math.inf
        loss = -math.log(self.restitution)
        with np.errstate(divide="ignore"):
            log_weight = np.log(q.weight)

        def log_size(p: float) -> float:
            """Return the ln of the left side, which falls with p, and is negative at p = 0."""
            # for e near 0 s^p alone would overflow, and its weight underflow
            log_mean = float(np.logaddexp.reduce(log_weight - p * q.log_loss))
            return math.log(largest_eps) - p * loss + float(np.logaddexp(0.0, log_mean))

        low = -1.0
        while log_size(low) < 0.0:
            low *= 2.0
        return float(brentq(log_size, low, 0.0, rtol=1e-12))

    # -- in words ---------------------------------------------------------------------------------

    @property
    def level(self) -> str:
        """The level of the theory in words."""
        descriptions = {
            "leading": "order n ln n, no fitted number",
            "first": "order n, no fitted number",
            "second": "order n, and (n ln n)^2 fitted to simulations",
        }
        text = f"{self.scatterers} at n = {self.density:g}: {descriptions[self.order]}"
        if self.order != "leading" and self.restitution < LEAST_RESTITUTION:
            text += f", with the constants of e = {LEAST_RESTITUTION:g}"
        return text

    def limits(self, errors: Mapping[str, float]) -> str:
        """Return what distributions lack, to follow a sentence; perhaps empty.

        Parameters
        ----------
        errors : largest error of the shares of tracers that a "speed_density", or a
            "position_density", has below any point; those that were asked for
        """
        n = self.density
        text = ""
        if n > TESTED_DENSITY:
            text += f"; n = {n:g} is outside the range to which the equation was fitted "
            text += f"(up to {TESTED_DENSITY:g})"
        if "speed_density" in errors:
            text += f"; the share of tracers slower than v {_off(errors['speed_density'])}, "
            text += "by slow ones, of which the density may be negative"
        if "position_density" in errors:
            text += f"; the share of tracers nearer than r {_off(errors['position_density'])}"
        return text


def _off(error: float) -> str:
    """Return by how much a share is off, in words; NaN where it was not measured."""
    if math.isnan(error):
        return "is off, by how much was not measured"
    return f"is off by up to {error:.2g}"
