"""The collision law, the scaled distribution and the state in a field: right, or refused."""

from typing import Any

import numpy as np
from fuzzing import extremes, fuzz, laws, mostly, points, restitutions, tried
from hypothesis import strategies as st

from kinetics import CollisionLaw, ScalingSolution, SolverStatus, solve_field, solve_scaled
from kinetics.crosscheck.stress_work import steady_errors

powers = mostly(st.floats(-5.0, 12.0), extremes)


def finite(*values: Any) -> bool:
    return all(value is None or np.all(np.isfinite(value)) for value in values)


@fuzz(90, law=st.fixed_dictionaries(laws), p=powers, m=mostly(st.integers(-3, 40)))
def test_the_averages_of_a_collision(law: Any, p: Any, m: Any) -> None:
    found = tried(CollisionLaw, **law)
    if found is None:
        return
    mean, rate = tried(found.mean_speed_ratio_power, p), tried(found.decay_rate, p)
    assert finite(mean, rate, tried(found.harmonic_decay_rate, p, m))
    assert -1.0 <= found.mean_cosine <= 1.0
    if mean is not None and rate is not None:
        assert np.allclose(mean, 1.0 - np.asarray(rate), rtol=1e-10, atol=1e-12)


@fuzz(
    15, e=mostly(st.integers(5, 95).map(lambda k: k / 100), restitutions),
    rtol=mostly([1e-12, 1e-10, 1e-6, 1e-3, 0.1]), nodes=mostly(st.none() | st.integers(8, 200)),
    p=powers, c=mostly(st.lists(st.floats(0.001, 8.0), min_size=1, max_size=3)),
)  # fmt: skip
def test_the_scaled_distribution(e: Any, rtol: Any, nodes: Any, p: Any, c: Any) -> None:
    exact = tried(ScalingSolution, e)
    found = tried(solve_scaled, e, rtol, nodes)
    if found is None or exact is None:
        assert found is None
        return
    assert exact.cooling_rate <= np.sqrt(2.0) * (1.0 + 1e-12)
    pairs = [(tried(one.moment, p), tried(one.vdf, c)) for one in (found, exact)]
    assert finite(*pairs[0], *pairs[1])
    if found.status is SolverStatus.CONVERGED:
        assert np.isclose(found.cooling_rate, exact.cooling_rate, rtol=4 * found.rtol)
        assert np.isclose(1.0 + found.a2, 1.0 + exact.a2, rtol=8 * found.rtol)
        # near e = 1 rounding of c itself is amplified
        for k, (slack, floor) in enumerate(((4 * 14, 0.0), (4, 1e-14 / (1.0 - found.restitution)))):
            if pairs[0][k] is not None and pairs[1][k] is not None:
                allowed = slack * found.rtol + floor
                assert np.allclose(pairs[0][k], pairs[1][k], rtol=allowed, atol=1e-290)


@fuzz(
    4, law=st.fixed_dictionaries(laws), rtol=mostly([1e-2, 1e-4, 1e-8]), p=powers,
    m=mostly(st.integers(0, 3)), at=points,
)  # fmt: skip
def test_the_steady_state_in_a_field(law: Any, rtol: Any, p: Any, m: Any, at: Any) -> None:
    state = tried(solve_field, **law, rtol=rtol)
    if state is None:
        return
    assert state.message
    assert finite(tried(state.moment, p, m), tried(state.vdf, at, 0.3))
    if state.status is SolverStatus.CONVERGED:
        assert state.error_estimate <= state.rtol
        assert max(steady_errors(state)) <= 10.0 * state.rtol
