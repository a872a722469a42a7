r"""Measures J_m(p) among overlapping disks against the first order of kinetics/collision/medium.py.

J_m(p) is the integral over the path x of <(v/v_0)^p cos(m (phi - phi_0))>, in mean free paths l.
Without memory it is 1/lambda, lambda = 1 - E[s^p cos(m chi)], and the first order in n is

    J = 1/lambda + A n ln(1/n) + B n,    A = (-1)^m e^p 2 e/(1 + e),   B = -A ln C - d/lambda

with C and d from returns.json. Plain averages over windows (`particles.path_integrals`) would need
some 1e10 collisions for B to 0.1. Here only what memory changes is averaged. The medium is made
where the tracer goes: scatterers are proposed as without memory, at the rate 1 per l and with a
uniform impact parameter, and those are rejected that lie in the area that is known to be empty,
because the tracer passed there. Were all of them accepted, and no known scatterer met again, then

    integral of A dx + A(v_X)/lambda - A(v_0)/lambda,     A(v) = v^p cos(m (phi - phi_0)),

would be zero on average. So J - 1/lambda is the average of the sum over what memory changes alone:
plus (change of A)/lambda for each bounce on a scatterer that was met before, minus the same for
each proposal that is rejected, minus A/lambda where a tracer is caught in a corner. Every place of
a path is a start at once; events later than `WINDOW/lambda` (at least `LEAST_WINDOW`) are left out.

    python -m tests.kinetics.measurements.path_integrals [minutes]     12 on one core
"""

from __future__ import annotations

import json
import math
import sys
import time

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tests.kinetics.measurements.returns import FILE, PAIRS, kept, leading

Array = NDArray[np.float64]
DENSITIES = (0.0025, 0.005, 0.01, 0.02, 0.04)
SHARES = (0.4, 0.2, 0.15, 0.15, 0.1)  # of the time: the lowest densities decide on B
RESTITUTIONS = (0.5, 0.7, 0.9, 1.0, 0.3)
WINDOW, LEAST_WINDOW = 12.0, 24.0  # in l; at m = 1 about 0.02 of B is beyond (a tail 1/x^2)
SETTLING = 15.0  # in l: a random start is stationary where e = 1 only
STARTS = 100.0  # in l, of each path
_MOST = 20_000  # flights of one path
_SHORTEST = 1e-9  # a shorter flight is that of a tracer caught in a corner
_BATCHES = 40  # at least, for the errors


@njit(cache=True)
def _is_known(x: float, y: float, places: Array, last: int) -> bool:
    """Whether a point lies nearer than 1 to the path so far."""
    if (x - places[0, 0]) ** 2 + (y - places[0, 1]) ** 2 < 1.0:
        return True
    for i in range(last):
        ax, ay = places[i, 0], places[i, 1]
        bx, by = places[i + 1, 0] - ax, places[i + 1, 1] - ay
        square = bx * bx + by * by
        if ((x - ax) * by - (y - ay) * bx) ** 2 > square:  # even from the line; most are
            continue
        share = ((x - ax) * bx + (y - ay) * by) / square if square > 0.0 else 0.0
        share = min(1.0, max(0.0, share))
        if (x - ax - share * bx) ** 2 + (y - ay - share * by) ** 2 < 1.0:
            return True
    return False


@njit(cache=True)
def _bounce(ux: float, uy: float, nx: float, ny: float, e: float) -> tuple[float, float, float]:
    """The direction after a bounce off the normal n, and the logarithm of the speed ratio."""
    normal = (1.0 + e) * (ux * nx + uy * ny)
    wx, wy = ux - normal * nx, uy - normal * ny
    speed = math.sqrt(wx * wx + wy * wy)
    return wx / speed, wy / speed, math.log(speed)


@njit(cache=True)
def _add(
    sums: Array, sign: float, flights: Array, last: int, x: float, before: Array, after: Array,
    kinds: Array, ends: Array,
) -> None:  # fmt: skip
    """Adds sign times the change of A, for every start on the path so far.

    flights: x at the start, angle and ln(speed) of each; before and after: angle, ln(speed) and
    1 or 0 (caught); kinds: m, p and window; ends: the first and the last x of a start.
    """
    for k in range(len(kinds)):
        m, p, window = kinds[k]
        total = 0.0
        for i in range(last, -1, -1):
            end = min(flights[i + 1, 0] if i < last else x, ends[1])
            start = max(flights[i, 0], x - window, ends[0])
            if end > start:
                old = math.cos(m * (before[0] - flights[i, 1]))
                old *= math.exp(p * (before[1] - flights[i, 2]))
                new = 0.0
                if after[2] > 0.0:
                    new = math.cos(m * (after[0] - flights[i, 1]))
                    new *= math.exp(p * (after[1] - flights[i, 2]))
                total += (end - start) * (new - old)
            if flights[i, 0] <= max(x - window, ends[0]):
                break
        sums[k] += sign * total


@njit(cache=True)
def _paths(
    random: np.random.Generator,
    paths: int,
    e: float,
    n: float,
    kinds: Array,
    ends: Array,
    length: float,
) -> tuple[Array, float, int]:
    """Sums of the changes, length of all starts (both in l) and collisions of so many paths."""
    free = 0.5 / n
    places, flights = np.empty((_MOST + 1, 2)), np.empty((_MOST + 1, 3))
    disks = np.empty((_MOST, 2))
    before, after = np.ones(3), np.ones(3)
    sums, starts, collisions = np.zeros(len(kinds)), 0.0, 0
    for _ in range(paths):
        places[0] = 0.0
        ux, uy, speed, x = 1.0, 0.0, 0.0, 0.0  # ln(speed) and the path, in l
        known, last, angle = 0, 0, 0.0
        while last < _MOST - 1:
            px, py = places[last]
            flights[last] = x, angle, speed
            before[0], before[1], after[2] = angle, speed, 1.0
            flight, met = math.inf, -1
            for j in range(known):
                rx, ry = disks[j, 0] - px, disks[j, 1] - py
                along = rx * ux + ry * uy
                if along > 0.0:
                    room = 1.0 - (rx * uy - ry * ux) ** 2
                    if room > 0.0 and along - math.sqrt(room) < flight:
                        flight, met = along - math.sqrt(room), j
            far = 0.0
            while True:
                far -= free * math.log(1.0 - random.random())
                if far >= min(flight, free * (length - x)):
                    break
                side = 2.0 * random.random() - 1.0
                ahead = far + math.sqrt(1.0 - side * side)
                cx, cy = px + ahead * ux - side * uy, py + ahead * uy + side * ux
                if not _is_known(cx, cy, places, last):
                    disks[known] = cx, cy
                    flight, met = far, -1
                    known += 1
                    break
                nx, ny = px + far * ux - cx, py + far * uy - cy
                wx, wy, loss = _bounce(ux, uy, nx, ny, e)
                after[0], after[1] = math.atan2(wy, wx), speed + loss
                _add(sums, -1.0, flights, last, x + far / free, before, after, kinds, ends)
            x += max(flight, 0.0) / free
            if x >= length:
                x = length
                break
            collisions += 1
            px, py = px + flight * ux, py + flight * uy
            j = met if met >= 0 else known - 1
            nx, ny = px - disks[j, 0], py - disks[j, 1]
            size = math.sqrt(nx * nx + ny * ny)
            ux, uy, loss = _bounce(ux, uy, nx / size, ny / size, e)
            angle, speed = math.atan2(uy, ux), speed + loss
            after[0], after[1] = angle, speed
            caught = met >= 0 and flight < _SHORTEST
            if caught:
                after[2] = 0.0
            if met >= 0:
                _add(sums, 1.0, flights, last, x, before, after, kinds, ends)
            if caught:
                break
            last += 1
            places[last] = px, py
        starts += max(0.0, min(x, ends[1]) - ends[0])
    return sums, starts, collisions


def measured(e: float, n: float, seconds: float, seed: int = 1) -> tuple[Array, Array, int]:
    """(J - 1/lambda)/n for every pair, with standard errors, and the number of collisions."""
    pairs = pairs_at(e)
    rates = np.array([1.0 - kept(e, m, p) for m, p in pairs])
    windows = np.maximum(LEAST_WINDOW, WINDOW / rates)
    kinds = np.column_stack([np.array(pairs, dtype=float), windows])
    ends = np.array([SETTLING, SETTLING + STARTS])
    length = ends[1] + windows.max()
    random = np.random.default_rng([seed, round(1e6 * n)])
    found: list[list[float]] = []
    collisions, begun = 0, time.process_time()
    while len(found) < _BATCHES or time.process_time() - begun < seconds:
        sums, starts, more = _paths(random, 25, e, n, kinds, ends, length)
        found.append([*(sums / rates / n), starts])
        collisions += more
    table = np.array(found)
    weight = table[:, -1] / np.sum(table[:, -1])
    parts = table[:, :-1] / table[:, -1:]
    value = weight @ parts
    error = np.sqrt((weight**2) @ (parts - value) ** 2)
    return value, error, collisions


def pairs_at(e: float) -> tuple[tuple[int, int], ...]:
    """(m, p): at e = 1 the power of the speed does not matter."""
    return tuple(pair for pair in PAIRS if e < 1.0 or pair[1] == 0)


def predicted(e: float, m: int, p: int) -> tuple[float, float, float]:
    """A, and B with its error, from returns.json."""
    table = json.loads(FILE.read_text())
    at = table["restitution"].index(e)
    name = f"ln C {m}" if (m, p) in ((0, 1), (1, 0), (2, 0)) else f"ln C {m} at p = {p}"
    a, rate = leading(e, m, p), 1.0 - kept(e, m, p)
    # d is a part of C as well: the error of C holds that of d.
    constant = -a * table[name][at] - table["d"][at] / rate
    return a, constant, abs(a) * table[f"error of {name}"][at]


def fitted(value: Array, error: Array, held: dict[str, float]) -> tuple[Array, Array, float]:
    """a, b, c, d of a ln(1/n) + b + c n ln(n)^2 + d n, some of them held; errors, chi-square."""
    n = np.array(DENSITIES)
    basis = {"a": -np.log(n), "b": np.ones_like(n), "c": n * np.log(n) ** 2, "d": n}
    rest = value - sum((held[name] * basis[name] for name in held), np.zeros_like(n))
    free = np.column_stack([basis[name] for name in basis if name not in held]) / error[:, None]
    covariance = np.linalg.inv(free.T @ free)
    best = covariance @ (free.T @ (rest / error))
    chi_square = float(np.sum((rest / error - free @ best) ** 2))
    return best, np.sqrt(np.diag(covariance)), chi_square


def main(minutes: float) -> None:
    """Prints (J - 1/lambda)/n, and the fits against the theory."""
    each = 60.0 * minutes / len(RESTITUTIONS)
    for e in RESTITUTIONS:
        pairs = zip(DENSITIES, SHARES, strict=True)
        runs = [measured(e, n, share * each) for n, share in pairs]
        values, sigmas, collisions = zip(*runs, strict=True)
        print(f"e = {e:g}: collisions", *(f"{count:.2g}" for count in collisions), flush=True)
        for k, (m, p) in enumerate(pairs_at(e)):
            value, error = (np.array([x[k] for x in of]) for of in (values, sigmas))
            a, b, b_error = predicted(e, m, p)
            print(
                f"  ({m}, {p})", *(f"{v:8.3f}({s:.3f})" for v, s in zip(value, error, strict=True))
            )
            for what, theory, own, held in (
                ("slope", a, 0.0, {"b": b, "d": 0.0}),
                ("constant", b, b_error, {"a": a, "d": 0.0}),
                ("constant, with n^2", b, b_error, {"a": a}),
            ):
                best, errors, chi_square = fitted(value, error, held)
                off = (best[0] - theory) / math.hypot(errors[0], own)
                print(
                    f"    {what}: {best[0]:.3f}({errors[0]:.3f}), theory {theory:.3f}({own:.3f}),"
                    f" {off:+.1f} sigma; second order {best[1]:.2f}({errors[1]:.2f}),"
                    f" chi-square {chi_square:.1f}",
                    flush=True,
                )


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 12.0)
