"""Measures again what a panel of `kinetics.collision.impact` resolves.

E[s^z cos(m chi)] by one panel length after another, against ten times as many points: the largest
(|z| + m) times length at which 20 Gauss points are right to rounding, beside the constant used.
"""

from __future__ import annotations

import itertools

import numpy as np

from kinetics.collision import DiskBounce, impact


def average(e: float, z: complex, m: int, longest: float) -> complex:
    """E[s^z cos(m chi)] with panels no longer than this."""
    q = DiskBounce(e).average(longest)
    return complex(np.exp(-z * q.log_loss) @ (q.weight * q.harmonic(m)))


def error(e: float, z: complex, m: int, longest: float) -> float:
    """Relative to E[s^(Re z)]."""
    size = average(e, complex(z.real), 0, 0.1 * longest).real
    return abs(average(e, z, m, longest) - average(e, z, m, 0.1 * longest)) / size


if __name__ == "__main__":
    print("turns of a panel   largest error")
    good = 0.0
    for turns in (15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 50.0, 60.0):
        worst = 0.0
        for e, m, angle in itertools.product(
            (1e-6, 0.01, 0.1, 0.3, 0.5, 0.8, 0.95), (0, 1, 4), np.linspace(0.0, 0.5 * np.pi, 7)
        ):
            for longest in (1.0, 0.25):
                z = (turns / longest - m) * complex(np.cos(angle), np.sin(angle))
                worst = max(worst, error(e, z, m, longest))
        print(f"{turns:16g}   {worst:.1e}")
        if worst < 1e-13:
            good = turns
    print(f"right to 1e-13 up to {good:g}; used is RESOLVED = {impact.RESOLVED:g}")
