"""solve_scaled against closed forms and Mellin inversion, which it does not use."""

import itertools
import math
from types import ModuleType
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from marking import slow_but

from kinetics import InputError, ScaledVDF, ScalingSolution, SolverStatus, solve_scaled
from kinetics.collision import CollisionLaw
from kinetics.scaling.symbols import decay_symbol_on_line

# what is promised: h, a2, moments to 1e-12 and F(c) to 1e-9 at these restitutions
TABLE = [0.0, 1e-3, *np.round(np.arange(0.05, 0.951, 0.05), 2).tolist(), 0.99, 0.999]
EXTREME = [1e-12, 1e-8, 1e-6, 1e-5, 1e-4, 1 - 1e-6, 1 - 1e-10]


class Exact:
    """h, a2 and <c^n> from the product of decay rates at 60 digits."""

    def __init__(self, e: float, formulas: ModuleType) -> None:
        with mp.workdps(60):
            lowest = 1 if e == 0.0 else -2
            y = {n: formulas.integer_moment(e, n) for n in range(lowest, 9) if n != 0}
            y[0] = mp.mpf(1)
            self.h = float(2 / mp.sqrt(y[2]))
            self.a2 = float(y[4] / (2 * y[2] ** 2) - 1)
            self.moments = {n: float(v / y[2] ** (mp.mpf(n) / 2)) for n, v in y.items()}

    def worst(self, vdf: ScaledVDF, highest: int = 8) -> float:
        """Largest error of h, a2 and the moments; of a2 relative to 1 + a2."""
        errors = [abs(vdf.cooling_rate / self.h - 1), abs(vdf.a2 - self.a2) / (1 + self.a2)]
        errors += [abs(vdf.moment(n) / m - 1) for n, m in self.moments.items() if n <= highest]
        return max(errors)


@pytest.mark.parametrize("e", TABLE)
def test_cooling_rate_a2_and_moments(e: float, formulas: ModuleType) -> None:
    vdf = solve_scaled(e)
    assert Exact(e, formulas).worst(vdf) <= 1e-12
    assert vdf.status is SolverStatus.CONVERGED
    assert vdf.error_estimate <= 1e-12


def test_vdf_relative_to_itself(numbers: Any) -> None:
    """Every c with F above 1e-25 of its maximum."""
    for e, reference in numbers["scaled_density"].items():
        found = solve_scaled(float(e)).vdf(np.array(reference["c"]))
        np.testing.assert_allclose(found, reference["F"], rtol=1e-9, err_msg=f"e = {e}")


def test_vdf_at_zero_restitution() -> None:
    c = np.geomspace(1e-12, 40.0, 60)
    f = np.exp(-math.sqrt(2) * c) / (math.sqrt(2) * math.pi * c)
    vdf = solve_scaled(0.0)
    np.testing.assert_allclose(vdf.vdf(c), f, rtol=1e-9)
    assert vdf.vdf(0.0) == math.inf


@pytest.mark.parametrize("e", [0.3, 0.9])
def test_tail_amplitude(e: float, formulas: ModuleType) -> None:
    """E[Y^p]/Gamma(p+b) tends to 2 pi A (h/2)^b, with corrections in 1/p; b = 1/(1-e^2)."""
    with mp.workdps(60):
        b = 1 / (1 - mp.mpf(e) ** 2)
        logs, n = [], 500
        product = mp.log(mp.mpf(1) / formulas.mean_log_loss(e))
        phi = formulas.speed_ratio_powers(e, 1, 8 * n + 2)
        for k in range(1, 8 * n + 1):
            if k in (n, 2 * n, 4 * n, 8 * n):
                logs.append(product - mp.loggamma(k + b))
            product += mp.log(k / (1 - phi[k - 1]))
        while len(logs) > 1:  # Richardson in 1/p
            order = 4 - len(logs) + 1
            logs = [(2**order * y - x) / (2**order - 1) for x, y in itertools.pairwise(logs)]
        h = 2 / mp.sqrt(formulas.integer_moment(e, 2))
        amplitude = float(logs[0] - mp.log(2 * mp.pi) - b * mp.log(h / 2))
    assert solve_scaled(e).log_tail_amplitude == pytest.approx(amplitude, abs=1e-7)


@pytest.mark.parametrize("e", [0.05, 0.4, 0.8, 0.95])
def test_convergence_is_exponential_in_the_nodes(e: float, formulas: ModuleType) -> None:
    """ln(error) against nodes over at least five resolutions: a straight line, steep enough."""
    exact = Exact(e, formulas)
    chosen = solve_scaled(e)._axis.tilts[0].grid.nodes
    nodes = np.unique(2 * (np.linspace(0.35, 0.85, 7) * chosen / 2).round().astype(int))
    errors = []
    for n in nodes:
        vdf = solve_scaled(e, nodes=int(n))
        errors.append(
            abs(vdf.moment(3.0) / exact.moments[3] - 1) + abs(vdf.cooling_rate / exact.h - 1)
        )
    fit = np.array(errors) > 1e-13
    assert fit.sum() >= 5, errors
    slope, offset = np.polyfit(nodes[fit], np.log(np.array(errors)[fit]), 1)
    spread = np.log(np.array(errors)[fit]) - (slope * nodes[fit] + offset)
    # 15 digits within twice the nodes the solver takes, and no algebraic flattening
    assert slope * chosen < -30.0
    assert np.all(np.abs(spread) < 5.0)
    finest = solve_scaled(e, nodes=int(1.1 * chosen) + 2)
    assert exact.worst(finest, highest=4) <= 1e-12


@pytest.mark.parametrize("e", [0.0, 0.1, 0.5, 0.9, 0.99])
def test_the_error_is_below_what_is_asked_for(e: float, formulas: ModuleType) -> None:
    """Never less accurate than asked without a status, and not 1000 times more work."""
    exact = Exact(e, formulas)
    nodes = []
    for k in range(3, 13):
        vdf = solve_scaled(e, rtol=10.0**-k)
        error = exact.worst(vdf, highest=4)
        assert vdf.status is SolverStatus.CONVERGED
        assert error <= 10.0**-k, k
        nodes.append(vdf.nodes)
    assert nodes == sorted(nodes)
    assert nodes[0] < 0.5 * nodes[-1]


@pytest.mark.parametrize("e", [0.0, 0.01, 0.2, 0.5, 0.7, 0.95])
def test_no_more_accurate_than_asked(e: float, formulas: ModuleType) -> None:
    """h, a2 and moments -2 to 8, the worst of them: within a factor 100 of rtol as a rule."""
    exact = Exact(e, formulas)
    ratios = []
    for k in range(3, 13):
        vdf = solve_scaled(e, rtol=10.0**-k)
        ratios.append(exact.worst(vdf) * 10.0**k)
        assert vdf.status is SolverStatus.CONVERGED
    assert max(ratios) <= 1.0
    assert np.median(ratios) >= 0.01
    assert min(ratios) >= 1e-3


@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-9, 1e-11])
def test_tails_are_as_accurate_as_asked(rtol: float, numbers: Any) -> None:
    """F relative to itself, wherever it is above 1e-25 of its maximum."""
    for e, reference in numbers["scaled_density"].items():
        vdf = solve_scaled(float(e), rtol)
        found = vdf.vdf(np.array(reference["c"]))
        np.testing.assert_allclose(found, reference["F"], rtol=rtol, err_msg=f"e = {e}")
        assert vdf.status is SolverStatus.CONVERGED


@pytest.mark.parametrize("e", [0.3, 0.7, 0.95])
def test_far_out_the_bulk_is_solved_again(e: float) -> None:
    """At F = 1e-200 an error of the unit of speed is multiplied by 460."""
    c = 220.0 * ScalingSolution(e).cooling_rate
    exact = ScalingSolution(e).vdf(c)
    assert 1e-250 < exact < 1e-150
    for rtol in (1e-3, 1e-6, 1e-9):
        vdf = solve_scaled(e, rtol)
        vdf.vdf(1.0)
        assert not vdf._axis.refined
        assert vdf.vdf(c) == pytest.approx(exact, rel=2 * rtol, abs=0.0)
        assert vdf._axis.refined
        # the parts still fit together
        assert vdf.moment(3.0) == pytest.approx(ScalingSolution(e).moment(3.0), rel=rtol)


@pytest.mark.parametrize("e", [0.0, 1e-3, 0.3, 0.79, 1 - 1e-8])
@pytest.mark.parametrize("theta", [-0.05, 1e-6, 20.0])
def test_symbol_on_a_line(e: float, theta: float) -> None:
    law = CollisionLaw(e)
    k = 0.25 * np.arange(500)
    found = decay_symbol_on_line(law, theta, k)
    np.testing.assert_allclose(found, law.decay_symbol(theta - 1j * k), rtol=2e-14)


@pytest.mark.parametrize("e", slow_but([0.0, 0.5, 0.99], [0.0, 0.05, 0.5, 0.9, 0.99]))
@pytest.mark.parametrize("nodes", slow_but([8, 16, 48], [8, 12, 16, 24, 32, 48]))
def test_the_status_tells_of_too_few_nodes(e: float, nodes: int, formulas: ModuleType) -> None:
    vdf = solve_scaled(e, rtol=1e-12, nodes=nodes)
    try:
        error = Exact(e, formulas).worst(vdf, highest=4)
    except InputError:  # a moment that overflows, with so few nodes
        error = math.inf
    if error > 1e-12:
        assert vdf.status is SolverStatus.TOLERANCE_NOT_REACHED
    assert vdf.error_estimate >= 0.03 * min(error, 1.0)
    assert "more nodes" in SolverStatus.TOLERANCE_NOT_REACHED.value


@pytest.mark.parametrize("e", EXTREME)
def test_extreme_restitutions_end_with_what_their_estimate_says(
    e: float, formulas: ModuleType
) -> None:
    vdf = solve_scaled(e)
    error = Exact(e, formulas).worst(vdf)
    assert math.isfinite(vdf.error_estimate)
    assert error <= max(1e-11, 30 * vdf.error_estimate)
    if error > 1e-12:
        assert vdf.status is SolverStatus.TOLERANCE_NOT_REACHED
    f = vdf.vdf(np.array([0.0, 1e-300, 0.5, 1.0, 1.0 + 1e-6, 3.0, 1e300]))
    assert not np.any(np.isnan(f))
    assert np.all(f >= 0.0)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(e=st.floats(1e-3, 0.995), rtol=st.sampled_from([1e-4, 1e-8, 1e-12]))
def test_any_restitution(e: float, rtol: float) -> None:
    """The scaled equation's own identities: <c^0> = <c^2> = 1 and h = M2/2, M2 = lambda(2)<c^3>."""
    vdf = solve_scaled(e, rtol=rtol)
    assert vdf.moment(0) == 1.0
    assert vdf.moment(2) == 1.0
    # paper, the scaled energy balance: h = lambda(2) <c^3>/2 ... with v0' = -h v0^2/(2 l)
    energy = 2.0 / 3.0 * (1.0 - e * e) * vdf.moment(3.0)
    assert vdf.cooling_rate == pytest.approx(energy, rel=20 * rtol + 1e-12, abs=0.0)
    assert vdf.error_estimate <= max(rtol, 5e-12)
    assert (vdf.status is SolverStatus.CONVERGED) == (vdf.error_estimate <= rtol)


def test_the_mass_is_one_by_another_rule() -> None:
    vdf = solve_scaled(0.6)
    node, weight = np.polynomial.legendre.leggauss(40)
    edges = np.array([0.0, 0.02, 0.1, 0.3, 0.6, 1.0, 1.5, 2.5, 4.0, 7.0, 12.0, 20.0])
    half = 0.5 * np.diff(edges)[:, None]
    c = edges[:-1, None] + half * (1.0 + node)
    mass = 2 * math.pi * c * vdf.vdf(c) * half * weight
    assert mass.sum() == pytest.approx(1.0, abs=1e-11)
    assert (mass * c**2).sum() == pytest.approx(1.0, abs=1e-11)


def test_more_is_solved_only_when_it_is_asked_for() -> None:
    vdf = solve_scaled(0.4)
    before = vdf.nodes
    vdf.vdf(1e-6)
    assert vdf.nodes >= before
    h = vdf.cooling_rate
    vdf.moment(30.0)
    assert vdf.cooling_rate == h
    assert solve_scaled(0.4).vdf(0.7) == pytest.approx(vdf.vdf(0.7), rel=1e-11, abs=0.0)


@pytest.mark.parametrize("e", [1.0, -0.1, 1.1, math.nan, "x", None])
def test_bad_restitution(e: Any) -> None:
    with pytest.raises(InputError, match=r"^restitution: got ") as caught:
        solve_scaled(e)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("rtol", [0.0, -1e-3, 1e-15, 0.2, math.nan, "tight", None])
def test_bad_rtol(rtol: Any) -> None:
    with pytest.raises(InputError, match=r"^rtol: got .*1e-14 to 0\.1"):
        solve_scaled(0.5, rtol=rtol)


@pytest.mark.parametrize("nodes", [7, 0, -8, 4097, 16.0, True, "64"])
def test_bad_nodes(nodes: Any) -> None:
    with pytest.raises(InputError, match=r"^nodes: got .*8 to 4096"):
        solve_scaled(0.5, nodes=nodes)


@pytest.mark.parametrize("p", [math.nan, math.inf, 301.0, "x", None])
def test_bad_moment(p: Any) -> None:
    with pytest.raises(InputError, match=r"^p: got "):
        solve_scaled(0.5).moment(p)


def test_moments_that_do_not_exist_or_overflow() -> None:
    with pytest.raises(InputError, match="p > -1"):
        solve_scaled(0.0).moment(-1.0)
    with pytest.raises(InputError, match="overflows"):
        solve_scaled(0.1).moment(300.0)


@pytest.mark.parametrize("c", [-1e-9, math.nan, [1.0, math.inf]])
def test_bad_speed(c: Any) -> None:
    with pytest.raises(InputError, match=r"^c: got "):
        solve_scaled(0.5).vdf(c)


@pytest.mark.parametrize("e", slow_but([1e-8], [1e-8, 1e-6, 1e-5]))
def test_vdf_at_small_restitutions(e: float) -> None:
    """Held against the closed form, itself held against Mellin inversion in mpmath."""
    c = np.array([18.0, 22.5])
    exact = np.array([ScalingSolution(e).vdf(x) for x in c])
    np.testing.assert_allclose(solve_scaled(e).vdf(c), exact, rtol=1e-9)


@pytest.mark.parametrize(
    ("e", "rtol"),
    slow_but(
        [(0.9999, 1e-9), (0.78, 3e-8)],
        [(0.9999, 1e-9), (0.997, 1e-7), (0.9995, 1e-3), (0.78, 3e-8), (0.3, 1e-8), (0.14, 1e-7)],
    ),
)
def test_both_tails_keep_the_accuracy_asked(e: float, rtol: float) -> None:
    """F down to 1e-290: errors of joins add up, and one of the unit of speed counts where steep."""
    exact = ScalingSolution(e)
    c = np.concatenate(
        [np.geomspace(1e-3, 0.5, 6), np.geomspace(0.6, 5.0, 20), [20.0, 60.0, 100.0]]
    )
    f = exact.vdf(c)
    seen = f > 1e-290
    state = solve_scaled(e, rtol)
    error = np.abs(state.vdf(c)[seen] / f[seen] - 1.0).max()
    assert error <= rtol
    assert state.status is SolverStatus.CONVERGED


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


@pytest.mark.parametrize(
    ("e", "nodes"), [(0.0, 14), (0.999, 16), (1.0 - 1e-10, 14), (1.0 - 1e-10, 18)]
)
def test_far_too_few_nodes_say_so_and_raise_nothing(e: float, nodes: int) -> None:
    """Moments of a nonsensical axis are no overflow of what was asked."""
    vdf = solve_scaled(e, nodes=nodes)
    vdf.vdf(np.geomspace(1e-3, 30.0, 50))
    found = [vdf.cooling_rate, vdf.a2, *(vdf.moment(p) for p in (0.0, 1.0, 4.0, 20.0))]
    assert np.all(np.isfinite(found))
    assert vdf.status is SolverStatus.TOLERANCE_NOT_REACHED
    with pytest.raises(InputError, match="overflows"):
        solve_scaled(0.0).moment(300.0)
