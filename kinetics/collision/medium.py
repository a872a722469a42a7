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
"second" : with terms of the next order in the path and in the harmonic m = 1, fitted to
    simulations. The default, because it is the nearest
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import cache, cached_property
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision.quadrature import ImpactQuadrature
from kinetics.numerics import FloatArray
from kinetics.numerics.chebyshev import barycentric_weights, interpolation_rows
from kinetics.validation import check_positive, one_of, refuse

SCATTERERS = ("dilute", "overlapping", "hard disks")
ORDERS = ("leading", "first", "second")
HIGHEST_DENSITY = 0.3  # n = rho d^2 above which nothing is tried
TESTED_DENSITY = 0.1  # and above which nothing was compared with simulations
# Simulations over n: the share of tracers slower than v, less 1 - e, and of those nearer than r
_SLOW, _NEAR = 1.15, 0.2
# Constants of powers of the speed: of what comes back at once, and of loops of the size of l
OF_SPEED = ("at once", "ratio at once", "loops", "ratio of loops", "path of loops")
CORRIDOR = 0.6  # per l: how fast near loops are cut off, exp(-R (1 + |delta|/4)) averaged
LEAST_RESTITUTION = 0.2  # of the constants of the first order: below they are held
# Fitted (tests/kinetics/measurements/density.py): of the order (n ln n)^2 J_1(0) is less by
# (a + b n) e^2 and by (f + g n) sqrt(1 - e^2); paths are longer by 4 e (1 - e) n^2 ln(1/n), and
# J_1(0), near 1.07 - .45 e, loses twice that, because <r^2> is not longer
_SECOND = {"overlapping": (1.4, 5.0), "hard disks": (1.4, 12.0)}
_LOSSY, _LONGER, _J1 = (0.2, 3.2), 4.0, (1.07, 0.45)


@dataclass(frozen=True)
class Medium:
    """Fixed smooth disks at a finite density, of restitution e: density is n = rho d^2."""

    scatterers: str
    density: float
    restitution: float
    order: str

    @classmethod
    def checked(
        cls, law: Any, scatterers: Any, number_density: Any, diameter: Any, order: Any
    ) -> Medium | None:
        """What a CollisionLaw finds among these scatterers; None where they are dilute.

        Raises InputError for arguments out of range, and where the theory is not derived: rough or
        moving scatterers, spheres, samples, mixtures.
        """
        scatterers = one_of("scatterers", scatterers, SCATTERERS)
        order = one_of("density_order", order, ORDERS)
        if scatterers == "dilute":
            return None
        given = f"with scatterers={scatterers!r} it must be"
        if law.mass_ratio < math.inf:
            refuse("mass_ratio", law.mass_ratio, f"{given} inf: fixed")
        if law.restitution is None or law.dimension == 3 or law.tangential_restitution != 1.0:
            refuse("scatterers", scatterers, "a finite density is derived for smooth disks only")
        rho = check_positive("number_density", number_density)
        d = check_positive("diameter", diameter)
        if not 1e-300 < rho * d * d <= HIGHEST_DENSITY:
            refuse("number_density", number_density, f"{given} at most {HIGHEST_DENSITY:g} d^-2")
        return cls(scatterers, rho * d * d, law.restitution, order)

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
        return ratio * (1.0 + self._longer) / (1.0 + self.constants["d"] * self.density)

    @property
    def _longer(self) -> float:
        """By how much paths are longer than to the order n."""
        e, n = self.restitution, self.density
        return -_LONGER * e * (1.0 - e) * n * n * math.log(n) if self.order == "second" else 0.0

    def returns(self, m: int) -> tuple[float, float]:
        """eps (-1)^m and -ln e of the bounces straight back; both are 0 where none comes.

        eps is the chance per collision to be thrown back to the scatterer before.
        """
        e, n = self.restitution, self.density
        if e == 0.0:
            return 0.0, 0.0
        log_n = math.log(n)
        log = log_n + self.constants.get(f"ln C {m}", 0.0)
        eps = -self._straight * log
        if m == 1 and self.order == "second":
            (a, b), (f, g) = _SECOND[self.scatterers], _LOSSY
            more = (a + b * n) * e * e + (f + g * n) * math.sqrt(1.0 - e * e)
            eps += more * (n * log_n) ** 2 + 2.0 * self._longer * (_J1[0] - _J1[1] * e)
        # returns of returns must add up, eps |lambda| < 1: above the tested densities only
        return (-1.0) ** m * min(eps, 0.45), -math.log(e)

    @property
    def of_speed(self) -> tuple[float, float]:
        """What brings powers of the speed back at once, as `returns`; no loops are in it."""
        share, ratio = (self.constants.get(name, 0.0) for name in OF_SPEED[:2])
        return self._straight * share, -math.log(ratio or 1.0)

    @property
    def far_loops(self) -> tuple[float, float, float]:
        """Loops of the size of l, of powers of the speed: speed ratio, path b/l, and their eps."""
        share, ratio, path = (self.constants[name] for name in OF_SPEED[2:])
        return ratio, path, self._straight * share

    @property
    def _straight(self) -> float:
        """What eps has before its logarithm: n times collisions that go straight back, by angle."""
        return 2.0 * self.restitution / (1.0 + self.restitution) * self.density

    def met_again(self, z: Any, rate: list[NDArray[Any]], m: int) -> list[NDArray[Any]]:
        """Taylor coefficients of lambda_m at z from those without returns, each of the shape of z.

        Of lambda/(1 + b lambda), b = eps (-1)^m e^z.
        """
        eps, loss = self.returns(m)
        orders = range(len(rate))
        back = [eps * np.exp(-loss * z) * (-loss) ** n / math.factorial(n) for n in orders]
        below = [sum(back[i] * rate[n - i] for i in range(n + 1)) for n in orders]
        out: list[NDArray[Any]] = []
        for n in orders:
            known = sum((below[i] * out[n - i] for i in range(1, n + 1)), np.zeros_like(z))
            out.append(np.asarray((rate[n] - known) / (1.0 + below[0])))
        return out

    def lowest_power(self, q: ImpactQuadrature) -> float:
        """p where eps e^p (1 + E[s^p]) = 1, q the average over a collision; -inf if nowhere."""
        from scipy.optimize import brentq

        largest = max(abs(self.returns(m)[0]) for m in range(3))
        if self.restitution in (0.0, 1.0) or largest == 0.0:
            return -math.inf
        loss = -math.log(self.restitution)
        with np.errstate(divide="ignore"):
            log_weight = np.log(q.weight)

        def log_size(p: float) -> float:  # it falls with p, and is negative at p = 0
            # for e near 0 s^p alone would overflow, and its weight underflow
            mean = float(np.logaddexp.reduce(log_weight - p * q.log_loss))
            return math.log(largest) - p * loss + float(np.logaddexp(0.0, mean))

        low = -1.0
        while log_size(low) < 0.0:
            low *= 2.0
        return float(brentq(log_size, low, 0.0, rtol=1e-12))

    @cached_property
    def constants(self) -> dict[str, float]:
        """Those of the file by their names there; at the leading order d = 0 and no other."""
        if self.order == "leading":
            return {"d": 0.0}
        found: dict[str, float] = {}
        for at, columns in _constants():
            x = min(max(self.restitution, at[0]), at[-1])  # beyond the table they are held
            near = np.argsort(np.abs(at - x))[:4]  # the cubic through these
            rows = interpolation_rows(x - at[near], barycentric_weights(at[near]))
            found |= {name: float(rows @ values[near]) for name, values in columns.items()}
        return found

    @property
    def level(self) -> str:
        """The level of the theory in words."""
        what = {
            "leading": "order n ln n, no fitted number",
            "first": "order n, no fitted number",
            "second": "order n, and (n ln n)^2 fitted to simulations",
        }[self.order]
        if self.order != "leading" and self.restitution < LEAST_RESTITUTION:
            what += f", with the constants of e = {LEAST_RESTITUTION:g}"
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
def _constants() -> list[tuple[FloatArray, dict[str, FloatArray]]]:
    """Restitutions and constants of the file; those of speeds end before 1, where none is lost."""
    text = files("kinetics.collision").joinpath("returns.json").read_text("utf-8")
    table = {name: np.array(values) for name, values in json.loads(text).items()}
    e, wanted = table["restitution"], ("d", "ln C 0", "ln C 1", "ln C 2", *OF_SPEED)
    sizes = sorted({table[name].size for name in wanted})
    return [(e[:n], {name: table[name] for name in wanted if table[name].size == n}) for n in sizes]
