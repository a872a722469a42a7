"""Averages over one collision, and the scaling state that follows from them, in mpmath.

With the mean free path as the unit of length, a tracer of speed v collides at the rate v and keeps
the fraction s(y) = sqrt(e^2 + (1-e^2) y^2) of its speed, y uniform on [0, 1]; it is turned by chi,
cos(chi) = (s^2 - e)/((1 - e) s). Then

- E[s^p] = e^p 2F1(-p/2, 1/2; 3/2; -(1-e^2)/e^2), and (p+1) E[s^p] = 1 + p e^2 E[s^(p-2)];
- nu_m(p) = 1 - E[s^p cos(m chi)] is the rate at which <v^p cos(m phi)> decays, lambda = nu_0;
- Q_m(z) = nu_m(z) Q_m(z+1), Q_m(1) = 1, has one solution that does not oscillate: `Product`;
- E[Y^z] = Gamma(z) Q_0(z)/kappa for the limit law of Y = v t/l, kappa = E[-ln s].
"""

from __future__ import annotations

import itertools
from typing import Any

import mpmath as mp


def speed_ratio_power(e: Any, p: Any) -> Any:
    """E[s^p] in closed form, e as the double that it is."""
    e, p = mp.mpf(e), mp.mpmathify(p)
    if e == 1:
        return mp.mpf(1)
    if e == 0:
        return 1 / (1 + p)
    half, c = mp.mpf(1) / 2, mp.mpf(3) / 2
    if e > half:  # the same by Pfaff's transformation, with an argument that converges
        return mp.hyp2f1(-p / 2, 1, c, 1 - e**2)
    return e**p * mp.hyp2f1(-p / 2, half, c, -(1 - e**2) / e**2)


def speed_ratio_powers(e: Any, p: Any, count: int) -> list[Any]:
    """E[s^p], E[s^(p+1)], ...: two closed forms and the recursion, which is stable upwards."""
    e, p = mp.mpf(e), mp.mpmathify(p)
    if e == 0:
        return [1 / (1 + p + k) if 1 + p + k != 0 else mp.inf for k in range(count)]
    phi = [speed_ratio_power(e, p), speed_ratio_power(e, p + 1)]
    for k in range(2, count):
        q = p + k
        phi.append(speed_ratio_power(e, q) if q == -1 else (1 + q * e**2 * phi[k - 2]) / (q + 1))
    return phi[:count]


def mean_log_loss(e: Any) -> Any:
    """kappa = E[-ln s]."""
    e = mp.mpf(e)
    return 1 - e * mp.acos(e) / mp.sqrt(1 - e**2) if e < 1 else mp.mpf(0)


def _chebyshev_terms(e: Any, m: int) -> list[tuple[int, Any]]:
    """(i, c_i) with cos(m chi) = sum of c_i s^i, e < 1; they cancel as (1-e)^-m."""
    e = mp.mpf(e)
    below, here = {0: mp.mpf(1)}, {1: 1 / (1 - e), -1: -e / (1 - e)}
    if m == 0:
        return list(below.items())
    for _ in range(m - 1):
        above: dict[int, Any] = {i: -c for i, c in below.items()}
        for i, c in here.items():
            above[i + 1] = above.get(i + 1, mp.mpf(0)) + 2 * c / (1 - e)
            above[i - 1] = above.get(i - 1, mp.mpf(0)) - 2 * c * e / (1 - e)
        below, here = here, above
    return sorted((i, c) for i, c in here.items() if c != 0)


def ratio_power_cosine(e: Any, p: Any, m: int) -> Any:
    """E[s^p cos(m chi)]; at e = 1, where s = 1 and cos(chi) = 2 y^2 - 1, it is 1/(1 - 4 m^2)."""
    if mp.mpf(e) == 1:
        return mp.mpf(1) / (1 - 4 * m * m)
    return sum(c * speed_ratio_power(e, mp.mpmathify(p) + i) for i, c in _chebyshev_terms(e, m))


def decay_rates(e: Any, m: int, z: Any, count: int) -> list[Any]:
    """nu_m(z), nu_m(z+1), ..., count of them."""
    if mp.mpf(e) == 1:
        return [1 - ratio_power_cosine(e, z, m)] * count
    phi = speed_ratio_powers(e, mp.mpmathify(z) - m, count + 2 * m)
    terms = _chebyshev_terms(e, m)
    return [1 - sum(c * phi[k + m + i] for i, c in terms) for k in range(count)]


class Product:
    """Q_m(z) for complex z: Newton's interpolation far to the right, and the product back.

    With forward differences D at a large integer N,
    ln Q(N+z) = ln Q(N) - sum_k C(z, k) D^(k-1) ln nu(N).
    """

    def __init__(self, e: Any, m: int, size: float) -> None:
        """For |z| up to `size`."""
        self.e, self.m = mp.mpf(e), m
        self.kappa = mean_log_loss(e)
        self.shift = 40 + int(2.5 * size)
        with mp.workdps(mp.mp.dps + 160):  # differences and binomials magnify the rounding
            rates = decay_rates(e, m, mp.mpf(1), self.shift + 140)
            row = [mp.log(rate) for rate in rates]
            self.log_at_shift = -mp.fsum(row[: self.shift - 1])
            row = row[self.shift - 1 :]
            self.differences = []
            while row:
                self.differences.append(row[0])
                row = [b - a for a, b in itertools.pairwise(row)]

    def __call__(self, z: Any) -> Any:
        """Q_m(z)."""
        z = mp.mpmathify(z)
        total, binomial = self.log_at_shift, mp.mpf(1)
        small = mp.mpf(10) ** (-mp.mp.dps + 12)
        for k, difference in enumerate(self.differences, start=1):
            binomial *= (z - k + 1) / k
            term = binomial * difference
            total -= term
            if k > 3 and abs(term) < small:
                break
        else:
            raise ArithmeticError(f"Q({z}) needs a larger shift: {abs(term)}")
        value = mp.exp(total)
        for rate in decay_rates(self.e, self.m, z, self.shift):
            value *= rate
        return value

    def moment(self, z: Any) -> Any:
        """E[Y^z], for m = 0; z not 0, -1, -2, ..."""
        return mp.gamma(z) * self(z) / self.kappa


def integer_moment(e: Any, n: int) -> Any:
    """E[Y^n] = (n-1)!/(kappa lambda(1) ... lambda(n-1)) for n >= 1; by recursion for n < 0."""
    if n >= 1:
        rates = [1 - power for power in speed_ratio_powers(e, 1, n)]
        return mp.factorial(n - 1) / (mean_log_loss(e) * mp.fprod(rates[: n - 1]))
    product = mp.mpf(1)
    for i in range(1, -n + 1):  # E[Y^-i] = (E[s^-i] - 1)/i E[Y^(1-i)]
        product *= (speed_ratio_power(e, -i) - 1) / i
    return product


def scaled_density(e: Any, tilts: list[float]) -> dict[str, list[float]]:
    """F(c) by Mellin inversion, trapezoid rule on the lines Re z = a for a of tilts.

    At each a for the c whose saddle it is, so that nothing cancels: c, rounded to a double, and F.
    """
    out: dict[str, list[float]] = {"c": [], "F": []}
    width = float(mp.sqrt((1 - mp.mpf(e) ** 2) / 5))
    moment = Product(e, 0, 40 + max(map(abs, tilts)) + 12 / width).moment
    root = mp.sqrt(moment(2))
    d = mp.mpf(1) / 100
    for a in map(mp.mpf, tilts):
        low, top, high = mp.log(moment(a - d)), moment(a), mp.log(moment(a + d))
        c = float(mp.exp((high - low) / (2 * d)) / root)
        spread = mp.sqrt((high + low - 2 * mp.log(top)) / d**2)
        step = mp.pi / (14 * spread)  # images 28 standard deviations of x apart
        x = mp.log(mp.mpf(c) * root)
        total = top / 2
        for n in range(1, 4000):
            value = moment(mp.mpc(a, n * step))
            total += (value * mp.expj(-n * step * x)).real
            if abs(value) < top * mp.mpf(10) ** -22:
                break
        density = total * step / mp.pi * mp.exp(-a * x)
        out["c"].append(c)
        out["F"].append(float(density / (2 * mp.pi * mp.mpf(c) ** 2)))
    return out


def scaled_density_table() -> dict[str, Any]:
    """The table "scaled_density": ten restitutions, F from its maximum down to 1e-25 of it."""
    table = {}
    for e in (1e-3, 0.05, 0.2, 0.4, 0.6, 0.8, 0.9, 0.95, 0.99, 0.999):
        width = ((1 - e**2) / 5) ** 0.5
        left = 0.55 if e < 0.5 else 1.2
        tilts = [2.0 - left * k / width for k in range(5, -1, -1)]
        tilts += [2.0 + 1.5 * k**1.35 / width for k in range(1, 9)]
        found = scaled_density(e, tilts)
        least = 1e-25 * max(found["F"])
        pairs = [(c, f) for c, f in zip(found["c"], found["F"], strict=True) if f > least]
        table[str(e)] = {"c": [c for c, _ in pairs], "F": [f for _, f in pairs]}
    return table
