"""Collisions and path at late times: against mpmath, known laws, and a chain of collisions."""

import math

import mpmath as mp
import numpy as np
import pytest

from kinetics import CollisionLaw, ScalingSolution

MIXED = CollisionLaw.mixture([0.5, 0.5], [CollisionLaw(1.0), CollisionLaw(0.5)])


def test_the_power_found_by_other_means() -> None:
    """Plane, e = .5, z = 1/2, in mpmath with the product summed far out."""
    theta, amplitude = ScalingSolution(0.5).collision_power(0.5)
    assert theta == pytest.approx(-1.60142934545042, rel=1e-14)
    assert amplitude == pytest.approx(3.8302576537231, rel=1e-12)


@pytest.mark.parametrize("z", [0.01, 0.5, 1.0 - 1e-7, 1.0, 1.0 + 1e-7, 2.0, 2.999, 3.0, 10.0])
def test_powers_at_e_zero(z: float) -> None:
    """phi(p) = 1/(1 + p): E[z^N] = 1F1(1 - z; 1; -t) ~ t^(z - 1)/Gamma(z)."""
    theta, amplitude = ScalingSolution(0.0).collision_power(z)
    assert theta == pytest.approx(z - 1.0, rel=1e-13, abs=1e-15)
    assert amplitude == pytest.approx(1.0 / math.gamma(z), rel=1e-12)


@pytest.mark.parametrize(
    ("law", "z"),
    [(CollisionLaw(0.4, 0.8, 3), 1.3), (MIXED, 0.7)],
    ids=repr,
)
def test_the_series_in_time_tends_to_the_power(law: CollisionLaw, z: float) -> None:
    """The series has every digit in mpmath; what is left of it falls as 1/t, to (1/t)^2 below."""
    theta, amplitude = ScalingSolution(law).collision_power(z)
    q, left = law.quadrature_for(300.0), []
    with mp.workdps(140):
        weight = mp.matrix([mp.mpf(x) for x in q.weight.tolist()])
        ratio = [mp.mpf(x) for x in q.ratio.tolist()]
        weight /= mp.fsum(weight)
        now, phi = list(weight), []
        for _ in range(330):
            phi.append(mp.fsum(now))
            now = [a * b for a, b in zip(now, ratio, strict=True)]
        for t in (25.0, 50.0, 100.0):
            term, total = mp.mpf(1), mp.mpf(1)
            for k, one in enumerate(phi):
                term *= -mp.mpf(t) / (k + 1) * (1 - z * one)
                total += term
            left.append(float(total / (amplitude * mp.mpf(t) ** theta)) - 1.0)
    assert abs(left[2]) < 0.2
    twice = [2.0 * left[1] - left[0], 2.0 * left[2] - left[1]]  # without the term 1/t
    assert abs(twice[1]) < 0.35 * abs(twice[0])  # a quarter, and further terms
    assert abs(4.0 * twice[1] - twice[0]) / 3.0 < 0.004


@pytest.mark.parametrize("law", [CollisionLaw(0.5), CollisionLaw(0.9, dimension=3), MIXED])
def test_cumulants(law: CollisionLaw) -> None:
    exact, q = ScalingSolution(law), law.quadrature
    kappa, second = law.mean_log_loss, float(q.weight @ q.log_loss**2)
    found, path = exact.collision_cumulants(), exact.path_cumulants()
    assert found[:2] == pytest.approx([1.0 / kappa, second / kappa**3 - 1.0 / kappa], rel=1e-12)
    assert path[:2] == pytest.approx([1.0 / kappa, second / kappa**3], rel=1e-12)
    # derivatives of theta(u), in steps of u, by Richardson's extrapolation
    step = 2e-2 * kappa

    def third(h: float) -> float:
        at = [exact.collision_power(math.exp(n * h))[0] for n in (-2, -1, 1, 2)]
        return (at[3] - 2.0 * at[2] + 2.0 * at[1] - at[0]) / (2.0 * h**3)

    best = (4.0 * third(step / 2.0) - third(step)) / 3.0
    assert found[2] == pytest.approx(best, rel=1e-3)


def test_cumulants_of_a_poisson_process() -> None:
    """At e = 0 in the plane ln s is exponential: N is Poisson in ln t, and X = N + 1 flights."""
    exact = ScalingSolution(0.0)
    assert exact.collision_cumulants(8) == pytest.approx(np.ones(8), rel=1e-10)
    # E[exp(u X)] ~ t^theta with theta/(1 + theta) = u: theta = u + u^2 + ...
    assert exact.path_cumulants(6) == pytest.approx([1.0, 2.0, 6.0, 24.0, 120.0, 720.0], rel=1e-10)
