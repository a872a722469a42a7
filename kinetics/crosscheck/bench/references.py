r"""References for v0(t), a2(t), <r^2>(t) and its kurtosis in high precision, sharing no code.

With T = v_i t/l and G(z+1) = lambda(z) G(z), lambda(z) = 1 - E[s^z], G(1) = 1, the power series of
the moment hierarchy d<v^p>/dt = -lambda(p) <v^(p+1)>/l is a sum over the residues of

    <v^p>(t) = 1/(2 pi i) int Gamma(p - z) G(z)/G(p) <v_i^z> (t/l)^(z-p) dz,    0 < Re z < p,

which holds for every t > 0: one line of G serves all times, powers and starts. G comes from far to
the right, where Newton's interpolation of ln lambda converges, by the product back. <r^2> and
<r^4> for t/l <= 8 are power series in T, summed with the digits that they lose.

The values are kept in :mod:`kinetics.crosscheck.bench.reference_values`, which
``python -m kinetics.crosscheck.bench.references FILE`` writes (some minutes).
"""

from __future__ import annotations

import itertools
import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

MEAN_FREE_PATH = 12.5
"""l in d, of the paper's number density 0.04."""
RESTITUTIONS = (0.0, 0.2, 0.5, 0.7, 0.95, 0.99)
STARTS = ("gaussian", "monoenergetic")
HORIZONS = {"short": (0.1, 1e2, 25), "long": (1.0, 1e8, 25)}
"""Name: first and last time in d/U, and how many, log-spaced."""

_STEP, _HALF = 1 / 32, 44.0  # of the line: images of ln t are 2 pi/_STEP apart


def times(horizon: str) -> FloatArray:
    """Output times in d/U, shape (25,)."""
    first, last, count = HORIZONS[horizon]
    return np.geomspace(first, last, count)


def speed_ratio_powers(e: float, z: Any, count: int) -> list[Any]:
    """E[s^z], E[s^(z+1)], ...: a closed form for two, (z+1) E[s^z] = 1 + z e^2 E[s^(z-2)]."""
    import mpmath as mp

    e_ = mp.mpf(e)
    if e == 0.0:
        return [1 / (1 + z + k) for k in range(count)]
    half = mp.mpf(1) / 2
    phi = [
        e_**p * mp.hyp2f1(-p / 2, half, 3 * half, 1 - 1 / e_**2) for p in (z, z + 1)
    ]  # fmt: skip
    for k in range(2, count):
        phi.append((1 + (z + k) * e_**2 * phi[k - 2]) / (z + k + 1))
    return phi


class Gain:
    """G(z), 0 < Re z, |Im z| <= half; to 28 digits where the caller works with enough."""

    def __init__(self, e: float, half: float) -> None:
        import mpmath as mp

        self.e = e
        self.far = 40 + int(2.5 * half)
        count = self.far + int(90 + 2 * half)
        with mp.workdps(int(80 + half)):  # each difference doubles the rounding
            logs = [mp.log(1 - f) for f in speed_ratio_powers(e, mp.mpf(1), count)]
            self.log_far = mp.fsum(logs[: self.far - 1])
            row, self.differences = logs[self.far - 1 :], []
            while row:
                self.differences.append(row[0])
                row = [b - a for a, b in itertools.pairwise(row)]

    def __call__(self, z: Any) -> Any:
        """G(z)."""
        import mpmath as mp

        total, binomial = self.log_far, mp.mpf(1)
        for k, difference in enumerate(self.differences, start=1):
            binomial *= (z - k + 1) / k
            total += binomial * difference
            if k > 3 and abs(binomial * difference) < mp.mpf(10) ** -28:
                break
        else:
            raise ArithmeticError(f"no convergence at z = {z}")
        value = mp.exp(total)
        for f in speed_ratio_powers(self.e, z, self.far):
            value /= 1 - f
        return value


def initial_moment(start: str, z: Any) -> Any:
    """<v_i^z> in U^z."""
    import mpmath as mp

    return mp.mpf(1) if start == "monoenergetic" else 2 ** (z / 2) * mp.gamma(1 + z / 2)


class Cooling:
    """<v^p>(t) of one restitution, 0 <= e < 1."""

    def __init__(self, e: float) -> None:
        import mpmath as mp

        mp.mp.dps = 36
        self.gain = Gain(e, _HALF)
        step, real = mp.mpf(_STEP), mp.mpf("0.6")
        self.z = [mp.mpc(real, n * step) for n in range(int(_HALF / _STEP))]
        self.line = [self.gain(z) for z in self.z]

    def weights(self, p: int, start: str) -> list[Any]:
        """What multiplies (t/l)^(z-p) on the line."""
        import mpmath as mp

        norm = self.gain(mp.mpf(p))
        return [
            mp.gamma(p - z) * g / norm * initial_moment(start, z)
            for z, g in zip(self.z, self.line, strict=True)
        ]

    def power(self, p: int, weights: list[Any], t: float) -> Any:
        """<v^p> in U^p at t in d/U."""
        import mpmath as mp

        log_t = mp.log(mp.mpf(float(t)) / mp.mpf(MEAN_FREE_PATH))
        step = mp.mpf(_STEP)
        turn, phase, total = mp.expj(step * log_t), mp.mpc(1), mp.mpf(0)
        for n, weight in enumerate(weights):
            total += (weight * phase).real * (1 if n else mp.mpf(1) / 2)
            phase *= turn
        return total * step / mp.pi * mp.exp((self.z[0].real - p) * log_t)


def power_by_series(e: float, p: int, start: str, t: float, digits: int = 120) -> Any:
    """<v^p>(t) by the power series itself, t/l up to about 8: an independent look."""
    import mpmath as mp

    with mp.workdps(digits):
        reduced = mp.mpf(float(t)) / mp.mpf(MEAN_FREE_PATH)
        count = 120 + int(30 * reduced)
        if start == "gaussian":
            count += int(6 * reduced**2)
        phi = speed_ratio_powers(e, mp.mpf(p), count)
        term = total = mp.mpf(1)
        total = initial_moment(start, mp.mpf(p))
        for k in range(count):
            term *= -reduced * (1 - phi[k]) / (k + 1)
            total += term * initial_moment(start, mp.mpf(p + k + 1))
        return total


def square_displacement(e: float, start: str, t: float, digits: int = 120) -> Any:
    """<r^2> in d^2 at t in d/U, t/l up to about 8.

    chi = <v_i.r>/(v_i l) and rho = <r^2>/l^2 are functions of T: chi' = 1 - nu chi and
    rho' = 2 chi - lambda rho in powers of T, where bounces send T to s T and turn v_i by angle chi.
    """
    import mpmath as mp

    with mp.workdps(digits):
        reduced, e_ = mp.mpf(float(t)) / mp.mpf(MEAN_FREE_PATH), mp.mpf(e)
        count = 120 + int(30 * reduced) + (int(6 * reduced**2) if start == "gaussian" else 0)
        # phi[k] = E[s^(k-1)]; at e = 0 the first one is not needed
        below = mp.mpf(0) if e == 0.0 else speed_ratio_powers(e, mp.mpf(-1), 1)[0]
        phi = [below, *speed_ratio_powers(e, mp.mpf(0), count + 2)]
        along = square = total = mp.mpf(0)
        for k in range(count):
            turned = 1 - (phi[k + 2] - e_ * phi[k]) / (1 - e_)  # 1 - E[s^k cos(chi)]
            along, square = (
                ((1 if k == 0 else 0) - turned * along) / (k + 1),
                (2 * along - (1 - phi[k + 1]) * square) / (k + 1),
            )
            total += square * reduced ** (k + 1) * initial_moment(start, mp.mpf(k + 1))
        return total * mp.mpf(MEAN_FREE_PATH) ** 2


def quartic_displacement(e: float, start: str, t: float, digits: int = 140) -> Any:
    """<r^4> in d^4 at t in d/U, t/l up to about 8.

    The mean of exp(i k.r) over the paths is a sum of i^m a_m exp(i m theta), theta the angle of
    v_i to k, with a_m' = (K/2) (a_(m-1) - a_(m+1)) - (1 - B_m) a_m and a_0' = -K a_1, K = k l; B_m
    is a bounce: the factor E[s^j cos(m chi)] on T^j. <r^4>/(64 l^4) is the K^4 of a_0.
    """
    import mpmath as mp

    with mp.workdps(digits):
        reduced, e_ = mp.mpf(float(t)) / mp.mpf(MEAN_FREE_PATH), mp.mpf(e)
        count = 120 + int(30 * reduced) + (int(6 * reduced**2) if start == "gaussian" else 0)
        # phi[j] = E[s^(j-2)]; at e = 0 the first two are multiplied by e
        low = [mp.mpf(0)] * 2 if e == 0.0 else speed_ratio_powers(e, mp.mpf(-2), 2)
        phi = [*low, *speed_ratio_powers(e, mp.mpf(0), count + 2)]
        a11, a02, a22, a13, a04 = (mp.mpf(0) for _ in range(5))  # a_m of K^n, coefficient of T^j
        total = mp.mpf(0)
        for j in range(count):
            once = 1 - (phi[j + 3] - e_ * phi[j + 1]) / (1 - e_)
            # cos(chi) = (s - e/s)/(1 - e), cos(2 chi) = 2 cos(chi)^2 - 1
            square = (phi[j + 4] - 2 * e_ * phi[j + 2] + e_**2 * phi[j]) / (1 - e_) ** 2
            twice = 1 - (2 * square - phi[j + 2])
            none = 1 - phi[j + 2]
            half = mp.mpf(1) / 2
            a11, a02, a22, a13, a04 = (
                ((half if j == 0 else 0) - once * a11) / (j + 1),
                (-a11 - none * a02) / (j + 1),
                (half * a11 - twice * a22) / (j + 1),
                (half * (a02 - a22) - once * a13) / (j + 1),
                (-a13 - none * a04) / (j + 1),
            )
            total += a04 * reduced ** (j + 1) * initial_moment(start, mp.mpf(j + 1))
        return 64 * total * mp.mpf(MEAN_FREE_PATH) ** 4


def reference(quantity: str, e: float, start: str, horizon: str) -> FloatArray:
    """Kept values at `times(horizon)`: "thermal_speed" (U), "a2"; of the short one also "msd" (d^2)
    and "kurtosis".

    KeyError for what is not kept.
    """
    from kinetics.crosscheck.bench.reference_values import VALUES

    return np.array(VALUES[quantity, e, start, horizon])


def make() -> dict[tuple[str, float, str, str], list[float]]:
    """All of `reference_values.VALUES`."""
    import mpmath as mp

    values: dict[tuple[str, float, str, str], list[float]] = {}
    for e in RESTITUTIONS:
        cooling = Cooling(e)
        for start in STARTS:
            second, fourth = cooling.weights(2, start), cooling.weights(4, start)
            for horizon in HORIZONS:
                v2 = [cooling.power(2, second, t) for t in times(horizon)]
                v4 = [cooling.power(4, fourth, t) for t in times(horizon)]
                values["thermal_speed", e, start, horizon] = [float(mp.sqrt(x)) for x in v2]
                values["a2", e, start, horizon] = [
                    float(b / (2 * a**2) - 1) for a, b in zip(v2, v4, strict=True)
                ]
            square = [square_displacement(e, start, t) for t in times("short")]
            values["msd", e, start, "short"] = [float(x) for x in square]
            values["kurtosis", e, start, "short"] = [
                float(quartic_displacement(e, start, t) / x**2)
                for t, x in zip(times("short"), square, strict=True)
            ]
    return values


def _write(path: Path) -> None:
    lines = ['"""Written by kinetics.crosscheck.bench.references; not edited by hand."""', ""]
    lines += ["# fmt: off", "VALUES: dict[tuple[str, float, str, str], tuple[float, ...]] = {"]
    for key, row in make().items():
        lines.append(f"    {key!r}: (".replace("'", '"'))
        for i in range(0, len(row), 3):
            lines.append("        " + " ".join(f"{x!r}," for x in row[i : i + 3]))
        lines.append("    ),")
    path.write_text("\n".join([*lines, "}", ""]), encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python -m kinetics.crosscheck.bench.references FILE")
    _write(Path(sys.argv[1]))
