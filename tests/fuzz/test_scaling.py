"""The collision law and the scaled distribution: of any argument, right or refused."""

import math
from typing import Any

import numpy as np
from fuzzing import broken, examples, extremes, fuzz, mostly, restitutions, result_or_refusal
from hypothesis import strategies as st

from kinetics import CollisionLaw, ScalingSolution, SolverStatus, solve_scaled

POWERS = mostly(st.floats(-5.0, 12.0), extremes() | broken())
SPEEDS = mostly(
    st.lists(st.floats(0.0, 8.0), min_size=1, max_size=3), st.lists(extremes()) | broken()
)

ENDS = st.sampled_from([0.0, 1e-250, 1e-3, 0.99, 1 - 2.0**-53, 1.0])  # others take seconds

LAWS = st.fixed_dictionaries(
    {
        "restitution": mostly(restitutions()),
        "p": POWERS,
        "m": mostly(st.integers(-3, 40), st.integers() | broken()),
    }
)


@examples(90)
def test_the_averages_of_a_collision(tries: int) -> None:
    fuzz(_law, LAWS, tries)


def _law(asked: dict[str, Any]) -> None:
    law = result_or_refusal(CollisionLaw, asked["restitution"])
    if law is None:
        return
    assert 0.0 <= law.mean_log_loss <= 1.0 + 1e-12
    assert -1 / 3 - 1e-12 <= law.mean_cosine <= 0.5 + 1e-12
    mean = result_or_refusal(law.mean_speed_ratio_power, asked["p"])
    rate = result_or_refusal(law.decay_rate, asked["p"])
    decay = result_or_refusal(law.harmonic_decay_rate, asked["p"], asked["m"])
    for found in (mean, rate, decay):
        assert found is None or np.all(np.isfinite(found))
    if mean is not None and rate is not None:
        assert np.allclose(mean, 1.0 - np.asarray(rate), rtol=1e-10, atol=1e-12)


SCALED = st.fixed_dictionaries(
    {
        "restitution": mostly(st.integers(5, 95).map(lambda k: k / 100), ENDS | broken()),
        "rtol": mostly(st.sampled_from([1e-12, 1e-10, 1e-6, 1e-3, 0.1])),
        "nodes": mostly(st.none(), st.integers(8, 200) | broken()),
        "p": POWERS,
        "c": SPEEDS,
    }
)


@examples(30)
def test_the_scaled_distribution(tries: int) -> None:
    fuzz(_scaled, SCALED, tries)


def _scaled(asked: dict[str, Any]) -> None:
    exact = result_or_refusal(ScalingSolution, asked["restitution"])
    values = {}
    if exact is not None:
        assert 0.0 <= exact.cooling_rate <= math.sqrt(2.0) * (1.0 + 1e-12)
        assert exact.a2 >= -0.5 - 1e-12
        values = {
            "moment": result_or_refusal(exact.moment, asked["p"]),
            "vdf": result_or_refusal(exact.vdf, asked["c"]),
        }
        amplitude = result_or_refusal(lambda: exact.log_tail_amplitude)
        assert amplitude is None or math.isfinite(amplitude)
    found = result_or_refusal(solve_scaled, asked["restitution"], asked["rtol"], asked["nodes"])
    if found is None:
        return
    assert exact is not None
    moment = result_or_refusal(found.moment, asked["p"])
    density = result_or_refusal(found.vdf, asked["c"])
    if found.status is not SolverStatus.CONVERGED:
        assert "error estimate" in found.message
        return
    rtol = found.rtol
    assert np.isclose(found.cooling_rate, exact.cooling_rate, rtol=4 * rtol)
    assert np.isclose(1.0 + found.a2, 1.0 + exact.a2, rtol=8 * rtol)
    if moment is not None and values["moment"] is not None:
        p = abs(float(asked["p"]))
        assert np.isclose(moment, values["moment"], rtol=4 * (1 + p) * rtol)
    if density is not None and values["vdf"] is not None:
        # near e = 1 rounding of c itself is amplified
        rounding = 1e-14 / (1.0 - found.restitution)
        assert np.allclose(density, values["vdf"], rtol=4 * rtol + rounding, atol=1e-290)
