"""solve_scaled against closed forms and Mellin inversion, which it does not use."""

import math

import mpmath as mp
import numpy as np
import pytest
from collision import integer_moment
from marking import slow_but

from kinetics import InputError, ScaledVDF, ScalingSolution, SolverStatus, solve_scaled
from kinetics.crosscheck.references import load

EXTREME = [1e-12, 1e-8, 1e-6, 1e-5, 1e-4, 1 - 1e-6, 1 - 1e-10]


class Exact:
    """h, a2 and <c^n> from the product of decay rates at 60 digits."""

    def __init__(self, e: float) -> None:
        with mp.workdps(60):
            lowest = 1 if e == 0.0 else -2
            y = {n: integer_moment(e, n) for n in range(lowest, 9) if n != 0}
            y[0] = mp.mpf(1)
            self.h = float(2 / mp.sqrt(y[2]))
            self.a2 = float(y[4] / (2 * y[2] ** 2) - 1)
            self.moments = {n: float(v / y[2] ** (mp.mpf(n) / 2)) for n, v in y.items()}

    def worst(self, vdf: ScaledVDF, highest: int = 8) -> float:
        """Largest error of h, a2 and the moments; of a2 relative to 1 + a2."""
        errors = [abs(vdf.cooling_rate / self.h - 1), abs(vdf.a2 - self.a2) / (1 + self.a2)]
        errors += [abs(vdf.moment(n) / m - 1) for n, m in self.moments.items() if n <= highest]
        return max(errors)


@pytest.mark.parametrize("e", [0.0, 1e-3, 0.1, 0.5, 0.9, 0.99])
def test_the_error_is_below_what_is_asked_for(e: float) -> None:
    """Never less accurate than asked without a status, and not 1000 times more work."""
    exact = Exact(e)
    nodes = []
    for k in range(3, 13):
        vdf = solve_scaled(e, rtol=10.0**-k)
        error = exact.worst(vdf, highest=4)
        assert vdf.status is SolverStatus.CONVERGED
        assert error <= 10.0**-k, k
        nodes.append(vdf.nodes)
    assert nodes == sorted(nodes)
    assert nodes[0] <= 0.5 * nodes[-1]


@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-9, 1e-11])
def test_tails_are_as_accurate_as_asked(rtol: float) -> None:
    """F relative to itself, wherever it is above 1e-25 of its maximum."""
    for e, reference in load()["scaled_density"].items():
        vdf = solve_scaled(float(e), rtol)
        found = vdf.vdf(np.array(reference["c"]))
        np.testing.assert_allclose(found, reference["F"], rtol=rtol, err_msg=f"e = {e}")
        assert vdf.status is SolverStatus.CONVERGED


@pytest.mark.parametrize("e", slow_but([0.0, 0.9, 0.99], [0.0, 0.05, 0.5, 0.9, 0.99]))
@pytest.mark.parametrize("nodes", slow_but([8, 12, 48], [8, 9, 10, 12, 14, 48]))
def test_the_status_tells_of_too_few_nodes(e: float, nodes: int) -> None:
    vdf = solve_scaled(e, rtol=1e-12, nodes=nodes)
    try:
        error = Exact(e).worst(vdf, highest=4)
    except InputError:  # a moment that overflows, with so few nodes
        error = math.inf
    if error > 1e-12:
        assert vdf.status is SolverStatus.TOLERANCE_NOT_REACHED
    assert vdf.error_estimate >= 0.03 * min(error, 1.0)
    assert "more nodes" in SolverStatus.TOLERANCE_NOT_REACHED.value


@pytest.mark.parametrize("e", EXTREME)
def test_extreme_restitutions_end_with_what_their_estimate_says(e: float) -> None:
    vdf = solve_scaled(e)
    error = Exact(e).worst(vdf)
    assert math.isfinite(vdf.error_estimate)
    assert error <= max(1e-11, 30 * vdf.error_estimate)
    if error > 1e-12:
        assert vdf.status is SolverStatus.TOLERANCE_NOT_REACHED
    f = vdf.vdf(np.array([1.0, 1.0 + 1e-6]))
    assert np.all(f > 0.0)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-6, 1e-8, 1e-10])
def test_the_rounding_of_a_steep_density_is_in_the_estimate(gap: float, dimension: int) -> None:
    """Near e = 1, F is so steep that rounding alone moves it by more than 1e-12.

    On any processor: the floor has a margin of ten, so half of the estimate is asked for.
    """
    state = solve_scaled(1.0 - gap, 1e-12, dimension=dimension)
    c = 1.0 + math.sqrt(gap) * np.linspace(-2.0, 2.0, 9)
    exact = ScalingSolution(1.0 - gap, dimension=dimension).vdf(c)
    assert np.abs(state.vdf(c) / exact - 1.0).max() <= 0.5 * state.error_estimate
    assert state.status is SolverStatus.TOLERANCE_NOT_REACHED
    coarser = solve_scaled(1.0 - gap, 1e-14 / gap + 1e-9, dimension=dimension)
    coarser.vdf(c)
    assert coarser.status is SolverStatus.CONVERGED


@pytest.mark.parametrize("e", [0.0, 0.5, 0.99])
def test_speeds_beyond_its_reach_are_refused_by_the_name_of_the_closed_form(e: float) -> None:
    """F is below 1e-100 there; in a density over time it is 0."""
    vdf = solve_scaled(e, 1e-6)
    far = 400.0 * ScalingSolution(e).cooling_rate
    with pytest.raises(InputError, match=r"^c: got .* only ScalingSolution gives$"):
        vdf.vdf([1.0, far])
    near = 80.0 * ScalingSolution(e).cooling_rate
    assert vdf.vdf(near) == pytest.approx(ScalingSolution(e).vdf(near), rel=1e-6, abs=0.0)
    assert vdf.reached_vdf(np.array([far]))[0] == 0.0
    if e == 0.5:
        with pytest.raises(InputError, match="only ScalingSolution gives"):
            vdf.vdf(1e-12)
        assert vdf.vdf(0.0) == 0.0
