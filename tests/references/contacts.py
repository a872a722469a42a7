"""``python tests/references/contacts.py FILE``: makes the contacts in space of the tests again.

A tracer at the origin, a sphere of contact of radius 1, in 50 digits of mpmath: where the line of
flight meets the sphere, from the quadratic equation, and v' = et v - (et + e)(v.s) s with the
normal s. FILE is ``tests/particles/contacts_in_space.json``, or another. It takes a second.
"""

import json
import sys
from pathlib import Path

import mpmath as mp
import numpy as np

LAWS = [(0.7, 1.0), (0.0, 1.0), (1.0, 1.0), (0.3, 0.8), (0.9, 0.4), (0.5, 0.0)]
# Sizes of the impact parameter: along the normal, any, and nearly past the sphere.
IMPACTS = [1e-9, 1e-3, 0.2, 0.5, 0.8, 0.99, 1 - 1e-6, 1 - 1e-10]


def case(impact: float, law: tuple[float, float], rng: np.random.Generator) -> dict[str, object]:
    """Return one contact; numbers in and out are rounded to doubles."""
    u = rng.normal(size=3)
    u /= np.linalg.norm(u)
    side = np.cross(u, rng.normal(size=3))
    side /= np.linalg.norm(side)
    offset = rng.uniform(1.1, 8.0) * u + impact * side
    d, v = [mp.mpf(float(c)) for c in offset], [mp.mpf(float(c)) for c in u]
    size = mp.sqrt(mp.fdot(v, v))
    v = [c / size for c in v]
    along = mp.fdot(d, v)
    path = along - mp.sqrt(along**2 - mp.fdot(d, d) + 1)
    normal = [path * c - o for c, o in zip(v, d, strict=True)]
    e, et = (mp.mpf(number) for number in law)
    change = (et + e) * mp.fdot(v, normal)
    after = [et * c - change * n for c, n in zip(v, normal, strict=True)]
    ratio = mp.sqrt(mp.fdot(after, after))
    return {
        "offset": offset.tolist(),
        "direction": u.tolist(),
        "law": law,
        "path": float(path),
        "normal": [float(c) for c in normal],
        "new": [float(c / ratio) for c in after],
        "ratio": float(ratio),
    }


if __name__ == "__main__":
    mp.mp.dps = 50
    rng = np.random.default_rng(5)
    cases = [case(impact, law, rng) for impact in IMPACTS for law in LAWS]
    lines = ",\n".join(json.dumps(c) for c in cases)
    Path(sys.argv[1]).write_text(f"[\n{lines}\n]\n", encoding="utf-8")
