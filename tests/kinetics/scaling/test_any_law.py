"""The scaling state of spheres, of rough scatterers and of laws of one's own."""

from typing import Any

import numpy as np
import pytest

from kinetics import CollisionLaw, ScalingSolution, solve_scaled
from kinetics.errors import SolverStatus

# e, et, dimension: s rising and falling with the impact parameter, one ratio for all bounces,
# ratios down to 0
LAWS = [
    (0.5, 1.0, 3), (0.9, 1.0, 3), (0.0, 1.0, 2), (0.0, 1.0, 3), (0.5, 0.8, 2), (0.8, 0.5, 2),
    (0.7, 0.7, 2), (1.0, 0.5, 2), (0.3, 0.05, 3), (0.0, 0.5, 3),
]  # fmt: skip
C = np.concatenate([np.geomspace(1e-3, 0.05, 6), np.linspace(0.1, 4.0, 40)])


@pytest.mark.parametrize(("e", "et", "dimension"), LAWS)
def test_solver_against_closed_form(e: float, et: float, dimension: int) -> None:
    exact = ScalingSolution(e, et, dimension)
    vdf = solve_scaled(e, 1e-12, tangential_restitution=et, dimension=dimension)
    same = {"rel": 1e-11, "abs": 0.0}
    assert vdf.cooling_rate == pytest.approx(exact.cooling_rate, **same)
    for p in (0.5, 1.0, 4.0, 7.0):
        assert vdf.moment(p) == pytest.approx(exact.moment(p), **same)
    assert vdf.status is SolverStatus.CONVERGED
    c = C[exact.vdf(C) > 1e-90]
    assert np.allclose(vdf.vdf(c), exact.vdf(c), rtol=3e-12, atol=0.0)
    assert vdf.error_estimate < 3e-12
    assert vdf.a2 == pytest.approx(
        dimension / (dimension + 2.0) * exact.moment(4.0) - 1.0, rel=1e-9
    )


@pytest.mark.parametrize(("e", "et", "dimension"), [(0.0, 0.8, 2), (0.0, 0.5, 3), (0.5, 0.0, 2)])
def test_speeds_next_to_rest(e: float, et: float, dimension: int) -> None:
    """F is a power of c there: moments close to the lowest one, and F far below the solved axis."""
    law = CollisionLaw(e, et, dimension)
    exact, vdf = ScalingSolution(law), solve_scaled(law, rtol=1e-12)
    for p in law.lowest_power + np.array([0.02, 0.1, 0.5]):
        assert vdf.moment(p) == pytest.approx(exact.moment(p), rel=1e-12)
    low = vdf.vdf(np.array([1e-12, 1e-22]))
    assert low[1] / low[0] == pytest.approx(1e-10 ** (-law.lowest_power - dimension), rel=1e-10)


@pytest.mark.parametrize(
    ("e", "et", "dimension"),
    [(0.0, 1.0, 2), (0.0, 0.5, 3), (0.5, 0.0, 2), (0.8, 0.0, 2), (0.5, 0.0, 3), (0.5, 1.0, 2)],
)
def test_the_density_at_rest_is_the_limit_of_that_beside_it(
    e: float, et: float, dimension: int
) -> None:
    """It is infinite, finite (q = d) or zero, as c^(q - d) is, -q the lowest power of the law."""
    law = CollisionLaw(e, et, dimension)
    power = -law.lowest_power - dimension
    for solution in (ScalingSolution(law), solve_scaled(law, rtol=1e-10)):
        at_rest = float(solution.vdf(0.0))
        if power < 0.0:
            assert at_rest == np.inf
        elif power > 0.0:
            assert at_rest == 0.0
        else:
            assert at_rest > 0.0
            assert at_rest == pytest.approx(float(solution.vdf(1e-9)), rel=1e-7)


@pytest.mark.parametrize(
    "law",
    [
        {"restitution": 0.0, "dimension": 3},
        {"restitution": 0.3},
        {"restitution": 1.0, "tangential_restitution": 0.5},
        {"restitution": CollisionLaw.from_samples([0.5, 0.5], [0.9, 0.4], [0.0, 0.0])},
        # half of the bounces keep the speed; those of an elastic law do, nearly
        {"restitution": CollisionLaw.from_samples([0.2, 0.3, 0.5], [0.9, 0.5, 1.0], [0.0] * 3)},
        {"restitution": CollisionLaw.mixture([0.6, 0.4], [CollisionLaw(1.0), CollisionLaw(0.6)])},
    ],
)
def test_the_estimate_is_above_the_error(law: dict[str, Any]) -> None:
    """Of h, a2 and F(c) from the bulk up to 1e-97 of it, against the closed form."""
    exact = ScalingSolution(**law)
    c = np.linspace(1.0, 300.0 * exact.cooling_rate, 100)
    f = exact.vdf(c)
    c, f = c[f > 1e-97], f[f > 1e-97]
    for rtol in (1e-2, 1e-4, 1e-6, 1e-9):
        found = solve_scaled(**law, rtol=rtol)
        h, a2 = found.cooling_rate / exact.cooling_rate, (1.0 + found.a2) / (1.0 + exact.a2)
        assert max(abs(h - 1.0), abs(a2 - 1.0)) <= found.error_estimate
        error = np.abs(found.reached_vdf(c) / f - 1.0).max()
        assert error <= found.error_estimate + 1e-12 <= rtol


def test_a_narrow_part_of_a_mixture_gets_the_nodes_that_it_needs() -> None:
    """Half of the bounces keep nearly the whole speed, the other half a third of it."""
    law = CollisionLaw.mixture([0.5, 0.5], [CollisionLaw(0.999), CollisionLaw(0.3)])
    exact = ScalingSolution(law)
    vdf = solve_scaled(law, rtol=1e-12)
    assert vdf.status is SolverStatus.CONVERGED
    for p in (1.0, 4.0):
        assert vdf.moment(p) == pytest.approx(exact.moment(p), rel=1e-11)
