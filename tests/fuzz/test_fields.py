"""A uniform field: the steady state and averages over time, right or refused."""

from typing import Any

import numpy as np
from fuzzing import broken, examples, extremes, fuzz, geometric, mostly, restitutions
from fuzzing import result_or_refusal as tried
from hypothesis import strategies as st

from kinetics import Scene, SolverStatus, solve, solve_field
from kinetics.outputs import FIELD_OUTPUTS

_LAW = {
    "restitution": mostly(restitutions()),
    "dimension": mostly(st.sampled_from([2, 3])),
    "tangential_restitution": mostly(st.just(1.0), restitutions() | broken()),
}
STEADY = st.fixed_dictionaries(
    {
        **_LAW,
        "rtol": mostly(st.sampled_from([1e-2, 1e-4, 1e-8])),
        "p": mostly(st.floats(-1.5, 4.0), extremes() | broken()),
        "m": mostly(st.integers(0, 3), st.integers() | broken()),
        "points": mostly(st.lists(geometric(1e-3, 1e2), min_size=1, max_size=3), broken()),
    }
)
_time = mostly(geometric(1e-2, 1e3), extremes())
SCENES = st.fixed_dictionaries(
    {
        **_LAW,
        "number_density": mostly(st.just(0.04), extremes() | broken()),
        "field": mostly(geometric(1e-3, 1e2), extremes() | broken()),
        "initial": mostly(st.sampled_from(["gaussian", "monoenergetic", "rest"])),
        "times": mostly(st.lists(_time, min_size=1, max_size=2).map(sorted)),
        "outputs": mostly(st.lists(st.sampled_from(sorted(FIELD_OUTPUTS)), min_size=1, max_size=3)),
    }
)


@examples(10)
def test_the_steady_state(tries: int) -> None:
    fuzz(check_state, STEADY, tries)


def check_state(asked: dict[str, Any]) -> None:
    state = tried(solve_field, **{k: asked[k] for k in (*_LAW, "rtol")})
    if state is None:
        return
    assert state.message
    for found in (
        tried(state.moment, asked["p"], asked["m"]),
        tried(state.vdf, asked["points"], 0.3),
    ):
        assert found is None or np.all(np.isfinite(found))
    if state.status is SolverStatus.CONVERGED:
        law, rtol = state.law, 10.0 * state.rtol
        assert state.error_estimate <= state.rtol
        # exact: <v v_z> = 1/lambda_1(1), 2 <v_z> = lambda(2) <v^3>
        assert np.isclose(state.moment(2.0, 1), 1.0 / law.harmonic_decay_rate(1.0, 1), rtol=rtol)
        assert np.isclose(2.0 * state.drift, law.decay_rate(2.0) * state.moment(3.0), rtol=rtol)


@examples(3)
def test_averages_over_time(tries: int) -> None:
    fuzz(check_scene, SCENES, tries)


def check_scene(asked: dict[str, Any]) -> None:
    scene = tried(Scene, **asked)
    solution = None if scene is None else tried(solve, scene, 1e-3)
    if solution is None:
        return
    assert solution.message
    for name, array in solution.values.items():
        assert np.all(np.isfinite(array)), name
    if solution.status is SolverStatus.CONVERGED:
        assert solution.error_estimate <= solution.rtol
