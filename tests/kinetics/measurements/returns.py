r"""The first order in the density of scatterers, as integrals: `kinetics/collision/returns.json`.

Lengths in the contact distance a, n = rho a^2, l = a/(2 n). In the clock of the path length the
integral J_m(p) of <(v/v_0)^p cos(m (phi - phi_0))>, in l, is

    J_m(p) = 1/lambda_m(p) + A n ln(1/n) + B n,      A = (-1)^m e^p 2 e/(1 + e),
    B = A (c_near - ln 4 - gamma) + 4 g + N/lambda^2,

and a tracer collides 1 + d n times as often. The parts of B and d, each a function of (e; m, p):

c_near : two disks. The tracer meets the first one with a uniform impact parameter; its bounce
    counts, less what goes on as if there were no disk. A second disk of density rho follows, and
    then all bounces from one to the other. Less A lambda^2/(1 + t) dt, t the flight between them.
g : the tracer comes back after two or more collisions in between, at distances of the order of l:
    the propagator of the Boltzmann equation at distance 0, less its first two terms.
    Such loops are spread over paths y of which the Laplace transform has lambda + s for lambda.
N, nested rings : the way back runs through a corridor that is known to be empty. It is damped by
    exp(-R (1 + |delta|/4)/l) in place of exp(-2 R/l), delta its distance from the way out.

    python -m tests.kinetics.measurements.returns     writes the file, in ten minutes
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from kinetics.collision.medium import CORRIDOR, OF_SPEED

Array = NDArray[Any]
FILE = Path(__file__).parents[3] / "kinetics" / "collision" / "returns.json"
RESTITUTIONS = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0)
PAIRS = ((0, 1), (1, 0), (2, 0), (0, 3))
FARTHEST = 3000.0  # of the second disk: beyond it the integrand is of the order of 1/t^2
MOST_BOUNCES = 400  # a tracer that bounces more often stays in the corner of two disks


def bounces(e: float, points: int = 400) -> tuple[Array, Array, Array, Array]:
    """Gauss points in y from 0 to 1: y, weight, speed ratio and deflection (positive)."""
    x, w = np.polynomial.legendre.leggauss(20)
    panel = 10.0 * math.pi / points  # of the angle between the velocity and the normal
    theta = (panel * (np.arange(points // 20)[:, None] + 0.5 * (x + 1.0))).ravel()
    y, w = np.sin(theta), np.tile(0.5 * panel * w, points // 20) * np.cos(theta)
    s = np.sqrt(e * e + (1.0 - e * e) * y * y)
    return y, w, s, math.pi - theta - np.arctan2(y, e * np.cos(theta))


def kept(e: float, m: int, p: float) -> float:
    """E[s^p cos(m chi)] = 1 - lambda_m(p)."""
    _, w, s, chi = bounces(e)
    return float(w @ (s**p * np.cos(m * chi)))


def leading(e: float, m: int, p: float) -> float:
    """A: the coefficient of n ln(1/n) in J_m(p)."""
    return (-1.0) ** m * e**p * 2.0 * e / (1.0 + e)


# -- two disks ------------------------------------------------------------------------------------


def _reflected(v: Array, normal: Array, e: float) -> Array:
    """v after a bounce; vectors in the plane are complex numbers."""
    return v - (1.0 + e) * (v * normal.conj()).real * normal


def _widest(e: float, t: Array) -> Array:
    """An impact parameter on the second disk beyond which no bounce leads back to the first.

    The deflection may miss the way straight back by twice the angle at which a disk is seen.
    """
    allowed = 2.0 * np.arcsin(1.0 / np.maximum(t - 1.0, 1.0))
    low, high = np.zeros_like(t), np.full_like(t, 0.5 * math.pi)
    for _ in range(50):
        middle = 0.5 * (low + high)
        wide = middle + np.arctan2(np.sin(middle), e * np.cos(middle)) > allowed
        low, high = np.where(wide, low, middle), np.where(wide, middle, high)
    return np.where(t <= 2.0, 1.0, np.sin(high))


def _follow(e: float, y: Array, flight: Array, real: bool) -> tuple[Array, Array, Array, Array]:
    """Bounces off a disk at the origin, a second one after this flight, the first one, ...

    y : impact parameters on the two disks, shape (2, n); without ``real`` the tracer goes straight
    on at the first one. Returns the velocity after the second bounce and the last one, the number
    of bounces in between, and whether they never end.
    """
    place = -np.sqrt(1.0 - y[0] ** 2) + 1j * y[0]
    velocity = np.ones_like(place)
    if real:
        velocity = _reflected(velocity, place, e)
    along = velocity / abs(velocity)
    place = place + flight * along
    second = place + along * (np.sqrt(1.0 - y[1] ** 2) + 1j * y[1])
    velocity = _reflected(velocity, place - second, e)
    before, last, count = velocity, velocity.copy(), np.zeros(place.size)
    there = np.arange(place.size)
    for k in range(MOST_BOUNCES):
        centre = second * (k % 2)
        r, along = place - centre, velocity / abs(velocity)
        towards, outside = (r * along.conj()).real, abs(r) ** 2 - 1.0
        room = towards**2 - outside
        hit = (towards < 0.0) & (room > 0.0) & (outside > -1e-11)
        there, second, centre = there[hit], second[hit], centre[hit]
        if not there.size:
            break
        step = np.maximum(outside[hit], 0.0) / (np.sqrt(room[hit]) - towards[hit])
        normal = r[hit] + step * along[hit]
        normal /= abs(normal)
        place, velocity = centre + normal, _reflected(velocity[hit], normal, e)
        last[there] = velocity
        count[there] += 1
    endless = np.zeros(count.size, dtype=bool)
    endless[there] = True
    return before, last, count, endless


def two_disks(
    e: float, pairs: tuple[tuple[int, int], ...], points: int = 19, shifts: int = 16
) -> dict[Any, tuple[float, float]]:
    """What two disks give, by 2^points Sobol points for each shift, with standard errors.

    By (m, p) it is c_near; "d" is the change of the number of collisions.
    """
    far = math.log1p(FARTHEST)
    found = []
    for shift in range(shifts):
        x = qmc.Sobol(3, seed=shift).random_base2(points)
        t = np.expm1(far * x[:, 0])
        widest = _widest(e, t)
        y = np.stack([2.0 * x[:, 1] - 1.0, widest * (2.0 * x[:, 2] - 1.0)])
        weight = 2.0 * widest * (1.0 + t) * far
        total, more = dict.fromkeys(pairs, 0.0), 0.0
        for real, sign in ((True, 1.0), (False, -1.0)):
            before, after, count, endless = _follow(e, y, t, real)
            more += sign * float(np.mean(weight * np.where(endless, 0.0, count)))
            for m, p in pairs:
                change = np.where(endless, 0.0, _power(after, m, p)) - _power(before, m, p)
                total[m, p] += sign * float(np.mean(weight * change))
        size = {(m, p): leading(e, m, p) * (1.0 - kept(e, m, p)) ** 2 for m, p in pairs}
        found.append([more] + [total[pair] / size[pair] - far for pair in pairs])
    table = np.array(found)
    mean, error = table.mean(axis=0), table.std(axis=0, ddof=1) / math.sqrt(shifts)
    both = zip(mean.tolist(), error.tolist(), strict=True)
    return dict(zip(("d", *pairs), both, strict=True))


def _power(velocity: Array, m: int, p: int) -> Array:
    """v^p cos(m phi)."""
    speed = abs(velocity)
    return np.asarray(speed**p * ((velocity / speed) ** m).real)


# -- loops of the size of l -----------------------------------------------------------------------


def far_ring(
    e: float, m: int, p: int, slower: float = 0.0, highest: float = 40.0, points: int = 36
) -> float:
    """g, by Gauss points in ln(1 + k) and the tail a/k^3 + b/k^4 of its integrand k R(k).

    slower : s, of the Laplace transform over the path of the loop
    """
    _, w, s, chi = bounces(e, 3000)
    most = int(13 * highest) + 60 + m
    gain = np.cos(np.outer(np.arange(most + 1), chi)) @ (w * s**p)
    x, weight = np.polynomial.legendre.leggauss(points)
    end = math.log1p(highest)
    x = 0.5 * end * (x + 1.0)
    k = np.expm1(x)
    rings = [_loops(gain, m, float(q), slower) for q in k]
    total = sum(0.5 * end * weight * (1.0 + k) * k * rings)
    half, whole = ((q**3 * _loops(gain, m, q, slower)) for q in (0.5 * highest, highest))
    b = highest * (half - whole)
    return float(total + (whole - 0.5 * b / highest) / highest) / (2.0 * math.pi)


def _loops(gain: Array, m: int, k: float, slower: float) -> float:
    """R_mm - G0_mm - (G0 K G0)_mm at the wave number k."""
    free = 1.0 + slower
    reach = min(int(13.0 * k) + 60, len(gain) - 1 - m)
    quarter = 0.25 * k * k

    def rate(j: int) -> float:
        return float(free - gain[abs(j)])

    above = below = 1.0
    for j in range(m + reach, m, -1):
        above = 1.0 / (rate(j) + quarter * above)
    for j in range(m - reach, m):
        below = 1.0 / (rate(j) + quarter * below)
    whole = 1.0 / (rate(m) + quarter * (above + below))
    root = math.sqrt(free * free + k * k)
    j = np.arange(m - reach, m + reach + 1)
    apart = np.abs(m - j)
    # G0_mj = (-i q)^|m - j|/root, q = (root - free)/k
    once = (-1.0) ** apart * ((root - free) / k) ** (2 * apart) / root**2
    return whole - 1.0 / root - float(once @ gain[np.abs(j)])


# -- nested rings ---------------------------------------------------------------------------------


def nested_ring(e: float, m: int, p: int, points: int = 200) -> float:
    """N: three of its four terms have the impact parameter of the first bounce, one has not."""
    y, w, s, chi = bounces(e, points)
    y, w = np.concatenate([-y, y]), 0.5 * np.concatenate([w, w])
    s, chi = np.concatenate([s, s]), np.concatenate([-chi, chi])
    once = s**p * np.exp(1j * m * chi)
    turned, straight = _corridor(y / s, y), _corridor(y, y)
    both = (once[:, None] * once).real
    terms = (both - once.real[:, None]) * turned + (1.0 - once.real) * straight
    return float(-leading(e, m, p) * (w @ terms @ w))


def nested_count(e: float, points: int = 200) -> float:
    """The same for the number of collisions: its share of d."""
    y, w, s, _ = bounces(e, points)
    y, w, s = np.concatenate([-y, y]), 0.5 * np.concatenate([w, w]), np.concatenate([s, s])
    more = _corridor(y / s, y) - _corridor(y, y)
    return float(-leading(e, 0, 0) * (w @ more @ w))


def _corridor(out: Array, back: Array) -> Array:
    """ln[(1 + |delta|/4)/2], delta = out + back, shape (n_out, n_back)."""
    return np.asarray(np.log(0.5 + 0.125 * abs(out[:, None] + back)))


# -- all of it ------------------------------------------------------------------------------------


def constants(e: float, points: int = 19, shifts: int = 16) -> dict[str, Any]:
    """One row of the file: d, and B + d/lambda for every (m, p), each with its error."""
    pairs = tuple(pair for pair in PAIRS if e < 1.0 or pair[0] > 0)
    disks = two_disks(e, pairs, points, shifts)
    more, error = disks["d"]
    row: dict[str, Any] = {"restitution": e, "d": [more + nested_count(e), error]}
    if e == 1.0:
        row["d"] = [0.0, 0.0]  # by the invariant measure
    for m, p in pairs:
        rate, a = 1.0 - kept(e, m, p), leading(e, m, p)
        near, error = disks[m, p]
        b = a * (near - math.log(4.0) - float(np.euler_gamma))
        b += 4.0 * far_ring(e, m, p) + nested_ring(e, m, p) / rate**2
        row[f"B {m} {p}"] = [b, abs(a) * error]
    if e < 1.0:
        row |= _of_speed(row)
    return row


def _of_speed(row: dict[str, Any]) -> dict[str, float]:
    """What powers of the speed meet again: near loops e^p + I q^p + F r^p, over n 2 e/(1 + e).

    Near loops of a path y are spread as exp(-0.6 y)/y from 2 n on: ln(1/n) - gamma - ln 1.2. Loops
    of the size of l are F r^p = 4 g, and y exp(-y/b)/b^2, b half of their mean path; what is left
    comes back at once. I, q, F and r are those of p = 1 and 3, and b that of p = 2.
    """
    e, once, loops = row["restitution"], [], []
    for p in (1, 3):
        near = float(np.euler_gamma) + math.log(2.0 * CORRIDOR)
        loops.append(4.0 * far_ring(e, 0, p) / leading(e, 0, 0))
        once.append(e**p * (near - _log_c(row, 0, p)[0]) - loops[-1])
    found = {}
    for name, (first, third) in (("at once", once), ("loops", loops)):
        ratio = math.sqrt(third / first)
        found |= {name: first / ratio, "ratio " + ("of " * (name == "loops")) + name: ratio}
    g = [far_ring(e, 0, 2, step) for step in (0.0, 5e-4, 1e-3)]
    return found | {"path of loops": 0.5 * (g[0] - g[2]) / (1e-3 * g[1])}


def document(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """The file: by restitution d, ln C = -(B + d/lambda)/A of (m, p), and their errors."""
    found: dict[str, Any] = {
        "made by": "python -m tests.kinetics.measurements.returns",
        "meaning": "eps = (2e/(1+e)) n ln(1/(C n)) for (m, p) = (0, 1), (1, 0), (2, 0); "
        "1 + d n collisions for one; then what powers of the speed meet, over n 2e/(1+e)",
        "restitution": [row["restitution"] for row in rows],
        "d": [round(row["d"][0], 4) for row in rows],
        "error of d": [round(row["d"][1], 4) for row in rows],
    }
    for m, p in PAIRS:
        logs = [_log_c(row, m, p) for row in rows if f"B {m} {p}" in row]
        name = f"{m}" if (m, p) in ((0, 1), (1, 0), (2, 0)) else f"{m} at p = {p}"
        found[f"ln C {name}"] = [round(value, 4) for value, _ in logs]
        found[f"error of ln C {name}"] = [round(error, 4) for _, error in logs]
    for name in OF_SPEED:
        found[name] = [round(row[name], 4) for row in rows if name in row]
    return found


def _log_c(row: dict[str, Any], m: int, p: int) -> tuple[float, float]:
    """ln C, with d in the unit of length, and its error."""
    e = row["restitution"]
    rate, a = 1.0 - kept(e, m, p), leading(e, m, p)
    (b, b_error), (d, d_error) = row[f"B {m} {p}"], row["d"]
    return -(b + d / rate) / a, math.hypot(b_error, d_error / rate) / abs(a)


if __name__ == "__main__":
    made = document([constants(e) for e in RESTITUTIONS])
    lines = [f"{json.dumps(name)}: {json.dumps(value)}" for name, value in made.items()]
    FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n")
