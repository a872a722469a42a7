"""What the cases of the solvers share: laws, times, and limits known in closed form.

A law is a restitution, which stands for smooth disks, or a `CollisionLaw`.
"""

from __future__ import annotations

import math
from functools import cache, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw

Law = float | CollisionLaw
FloatArray = NDArray[np.float64]

RESTITUTIONS = (
    0.0, 1e-10, 1e-8, 1e-4, 0.01, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.99, 0.999,
    1.0 - 1e-6, 1.0 - 1e-10, 1.0,
)  # fmt: skip
FEWER = (0.0, 1e-10, 1e-4, 0.2, 0.7, 0.99, 1.0 - 1e-6, 1.0 - 1e-10, 1.0)
TIMES = np.array([0.0, 1e-300, 1e-3, 1.0, 1e3, 1e8, 1e30, 1e300])
PATH = 12.5  # l at the default density, in d
ROUNDING = 1e-14  # that a reference in doubles, and the average over a start, may add
GROWTH = 1e-13  # of a thermal speed that must not grow, relative
REFERENCE_SHARE = 0.3  # of an rtol: the most that the error estimate of a tighter solution may be


def label_of(law: Law) -> str:
    """A law as the name of a case has it."""
    if not isinstance(law, CollisionLaw):
        return f"e = {law:g}" if law < 0.9995 or law == 1.0 else f"e = 1 - {1.0 - law:.0e}"
    kind = "disks" if law.dimension == 2 else "spheres"
    if law.restitution is None:
        return f"{kind}, {law.quadrature.weight.size} samples"
    smooth = law.tangential_restitution == 1.0
    rough = "" if smooth else f", et = {law.tangential_restitution:g}"
    return f"{kind}, {label_of(law.restitution)}{rough}"


def as_law(law: Law) -> CollisionLaw:
    """The collision law; a restitution is that of smooth disks."""
    return law if isinstance(law, CollisionLaw) else CollisionLaw(law)


@cache
def other_laws(quick: bool) -> tuple[CollisionLaw, ...]:
    """Laws that are not smooth disks: spheres, rough scatterers, mixtures; with their ends."""
    near = 1.0 - 1e-10
    spheres = [(e, 1.0, 3) for e in (0.0, 0.7, near)]
    one_loss = [(0.5, 0.5, 3)]  # et = e: s = e in every bounce
    sticky = [(0.5, 0.0, 2)]
    rough = [(0.7, 0.8, 2), (0.7, 0.8, 3)]
    if not quick:
        spheres += [(e, 1.0, 3) for e in (1e-10, 1e-4, 0.2, 0.99, 1.0 - 1e-6, 1.0)]
        one_loss += [(x, x, 2) for x in (1e-7, 1e-4, 0.01, 0.5, near)] + [(0.99, 0.99, 3)]
        sticky += [(1.0, 0.0, 2), (0.5, 0.0, 3), (1.0, 0.0, 3), (1e-10, 0.5, 3), (0.5, 1e-10, 2)]
        rough += [(0.0, 0.8, 2), (1.0, 0.8, 2), (0.7, near, 2)]
        rough += [(0.0, 0.8, 3), (1.0, 0.8, 3), (near, 0.7, 3)]
    # a third of the bounces keeps the speed
    bounces = [0.2, 0.3, 0.2, 0.3], [0.9, 0.5, 1.0, 1.0], [-1.0, 0.0, 0.5, 1.0]
    return (
        *(CollisionLaw(*arguments) for arguments in (*spheres, *one_loss, *sticky, *rough)),
        CollisionLaw.from_samples(*bounces, dimension=2),
        CollisionLaw.from_samples(*bounces, dimension=3),
        _mixture(CollisionLaw(0.9), CollisionLaw(0.4)),
    )


def _mixture(one: CollisionLaw, other: CollisionLaw) -> CollisionLaw:
    """Half of the scatterers follow each of two laws."""
    weight, ratio, cosine = (
        np.concatenate([getattr(law.quadrature, name) for law in (one, other)])
        for name in ("weight", "ratio", "cosine")
    )
    return CollisionLaw.from_samples(0.5 * weight, ratio, cosine, one.dimension)


# -- closed forms in high precision, so that no e is near a limit of doubles ----------------------


def scaling(law: Law) -> tuple[float, float, float, float]:
    """h, 1 + a2, kappa and d<r^2>/d ln t in l^2 of the scaling state; not elastic."""
    return _scaling(as_law(law))


@lru_cache(maxsize=256)
def _scaling(law: CollisionLaw) -> tuple[float, float, float, float]:
    """The same, by integrals over the impact parameter y from 0 to 1.

    s^2 = e^2 + (et^2 - e^2) y^2 and s cos(chi) = -e + (e + et) y^2, y uniform among disks, y^2
    among spheres; sums for a law of samples. The fourth moment is as in any dimension,
    1 + a2 = 6 d/(d+2) kappa lambda(1)/(lambda(2) lambda(3)).
    """
    import mpmath as mp

    d = law.dimension
    with mp.workdps(30):
        if law.restitution is None:
            q = law.quadrature
            pairs = list(zip(q.weight, q.ratio, q.cosine, strict=True))
            weight = mp.fsum(mp.mpf(float(w)) for w, _, _ in pairs)

            def mean(f: Any) -> Any:
                terms = (mp.mpf(float(w)) * f(mp.mpf(float(s)), mp.mpf(float(c)))
                         for w, s, c in pairs)  # fmt: skip
                return mp.fsum(terms) / weight

        else:
            e, et = mp.mpf(law.restitution), mp.mpf(float(law.tangential_restitution or 0.0))
            edges = [0, *(mp.mpf(10) ** -k for k in range(12, 0, -1)), mp.mpf(1) / 2, 1]

            def mean(f: Any) -> Any:
                def at(y: Any) -> Any:
                    s = mp.sqrt(e**2 * (1 - y**2) + et**2 * y**2)
                    cosine = (-e * (1 - y**2) + et * y**2) / s
                    return f(s, cosine) * (1 if d == 2 else 2 * y)

                return mp.quad(at, edges)

        one, two, three = (mean(lambda s, _, p=p: 1 - s**p) for p in (1, 2, 3))
        kappa, turn = mean(lambda s, _: -mp.log(s)), mean(lambda _, c: 1 - c)
        return (
            float(2 * mp.sqrt(kappa * one)),
            float(mp.mpf(6 * d) / (d + 2) * kappa * one / (two * three)),
            float(kappa),
            float(2 / (kappa * turn)),
        )


def forgets(law: CollisionLaw) -> bool:
    """Whether late averages forget the start, to 1e-20 of them.

    Where all bounces take the same share of the speed (et = e), averages go on oscillating in ln t
    by about exp(-pi^2/(2 kappa)).
    """
    return law.least_loss < law.largest_loss or law.mean_log_loss < 0.1


def takes_single_shares(law: CollisionLaw) -> bool:
    """Whether bounces multiply the speed by some single values: no densities from sharp speeds."""
    return law.restitution is None or law.least_loss == law.largest_loss > 0.0


def late_thermal_speed(e: Law, mean_free_path: float, time: float) -> float:
    """v0 = 2 l/(h t), the limit of late times."""
    return 2.0 * (mean_free_path / time) / scaling(e)[0]


def early_and_late(e: Law, reduced_time: float, rtol: float) -> tuple[bool, bool]:
    """Whether v t/l is so small, or so large, that v0 and a2 are their limits within rtol/10.

    v0 changes by less than v t/l at first, and is that of the scaling state up to a few
    l/(kappa v t).
    """
    law = as_law(e)
    early, late = reduced_time < 0.01 * rtol, False
    if not law.is_elastic and forgets(law):
        late = math.log(reduced_time) > math.log(1e3 / rtol) - math.log(scaling(law)[2])
    return early, late


def limit_errors(
    solution: Any, first: tuple[float, float], rtol: float, places: slice = slice(None)
) -> float:
    """Error of v0 and a2 at the times that are early or late enough for the limits; NaN if none is.

    first : v0 and a2 of the start; places : of the times that are looked at
    """
    e, path = solution.scene.law, solution.scene.mean_free_path
    averages = (solution.times, solution.thermal_speed, solution.a2)
    errors = []
    for t, v0, a in zip(*(values[places] for values in averages), strict=True):
        # in logarithms: v t may overflow
        logarithm = -math.inf if t == 0.0 else math.log(first[0]) + math.log(t) - math.log(path)
        reduced = math.exp(max(min(logarithm, 700.0), -700.0))
        early, late = early_and_late(e, reduced, rtol)
        if early or e.is_elastic:
            errors += [abs(v0 / first[0] - 1.0), abs((1.0 + a) / (1.0 + first[1]) - 1.0)]
        elif late:
            expected = late_thermal_speed(e, path, float(t))
            if expected < 1e-290:  # at the end of the doubles
                continue
            errors += [abs(v0 / expected - 1.0), abs((1.0 + a) / scaling(e)[1] - 1.0)]
    return max(errors, default=math.nan)


# -- violations of what holds at all times ---------------------------------------------------------


def growth(speed: FloatArray) -> float:
    """Largest relative growth from one time to the next."""
    with np.errstate(invalid="ignore", divide="ignore"):
        change = speed[1:] / speed[:-1] - 1.0
    return max(0.0, float(np.max(change, initial=0.0)))


def below(values: Any, least: float = 0.0) -> float:
    """How far the smallest value is below the least that is allowed; 0 if it is not."""
    return max(0.0, least - float(np.min(values)))


def above(values: Any, most: float = 1.0) -> float:
    """How far the largest value is above the most that is allowed; 0 if it is not."""
    return max(0.0, float(np.max(values)) - most)


def finite(*values: Any) -> bool:
    """Whether all numbers of all arrays are finite."""
    return all(bool(np.all(np.isfinite(value))) for value in values)


def difference(
    speed: FloatArray, a2: FloatArray, expected: FloatArray, expected_a2: FloatArray
) -> float:
    """Largest relative difference of the thermal speeds, and of 1 + a2."""
    with np.errstate(all="ignore"):
        errors = [speed / expected - 1.0, (1.0 + a2) / (1.0 + expected_a2) - 1.0]
    found = float(np.max(np.abs(errors)))
    return found if math.isfinite(found) else math.inf
