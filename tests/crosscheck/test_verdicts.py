"""Verdicts are right where the truth is known: how often they cry wolf, and what they see."""

import math

import numpy as np
import pytest
from scipy.stats import norm, t

from kinetics.crosscheck.verdicts import (
    AGREES_BELOW,
    DIFFERS_ABOVE,
    MEANING,
    Verdict,
    chance,
    corrected_sigmas,
    judge_approximation,
    judge_numerical,
    judge_sigmas,
    worst,
)


@pytest.mark.parametrize("z", [0.5, 2.0, -4.0, 8.0])
def test_one_look_with_many_groups_keeps_its_sigmas(z: float) -> None:
    assert corrected_sigmas(z, 10**8, 1) == pytest.approx(abs(z), rel=1e-5)


@pytest.mark.parametrize(("groups", "trials"), [(10, 1), (100, 1), (10, 30), (100, 1000)])
def test_the_correction_is_student_and_bonferroni(groups: int, trials: int) -> None:
    p = trials * 2 * t.sf(5.0, groups - 1)
    expected = norm.isf(p / 2) if p < 1 else 0.0
    assert corrected_sigmas(5.0, groups, trials) == pytest.approx(expected, rel=1e-10)


def test_huge_deviations_stay_finite() -> None:
    assert 30 < corrected_sigmas(1e6, 100, 1000) < 40
    assert judge_sigmas(corrected_sigmas(1e6, 100, 1000)) is Verdict.DIFFERS


def test_true_theories_rarely_fail() -> None:
    # 20 000 rows of 12 looks each, from 10 groups: every deviation is pure chance. The union bound
    # promises that at most p(2.5 sigma) = 1.24 % of the rows do not agree, 248; 5 sigma of a
    # Poisson count more is 327. At most 6.3e-5 differ, 1.3; seven or more are a 5e-4 chance.
    rng = np.random.default_rng(3)
    groups, looks = 10, 12
    samples = rng.standard_normal((20_000, looks, groups))
    z = samples.mean(-1) / (samples.std(-1, ddof=1) / math.sqrt(groups))
    verdicts = [
        judge_sigmas(corrected_sigmas(worst_z, groups, looks)) for worst_z in np.abs(z).max(axis=1)
    ]
    # Not far fewer either: independent looks use the bound up.
    assert 170 <= len(verdicts) - verdicts.count(Verdict.AGREES) <= 327
    assert verdicts.count(Verdict.DIFFERS) < 7
    assert chance(AGREES_BELOW) == pytest.approx(0.01242, abs=1e-5)


def test_verdicts_follow_the_thresholds() -> None:
    below, above = math.nextafter(AGREES_BELOW, 0), math.nextafter(DIFFERS_ABOVE, 0)
    assert [judge_sigmas(s) for s in (0, below, AGREES_BELOW, above, DIFFERS_ABOVE)] == [
        "agrees",
        "agrees",
        "unclear",
        "unclear",
        "differs",
    ]
    assert judge_sigmas(math.nan) is Verdict.UNDEFINED
    assert [judge_numerical(d, 1e-10) for d in (-1e-10, 1.1e-10, -2e-10)] == [
        "agrees",
        "differs",
        "differs",
    ]
    assert [judge_approximation(d) for d in (0.0, -0.019, 0.03, -0.2, math.nan)] == [
        "close",
        "close",
        "rough",
        "far",
        "undefined",
    ]


def test_every_verdict_has_a_meaning() -> None:
    assert set(MEANING) == set(Verdict)


def test_the_worst_look_is_found_and_unusable_ones_are_left_out() -> None:
    values = [1.0, 9.0, 2.0, 50.0, 3.0]
    errors = [0.1, 0.0, 0.5, 1.0, math.inf]
    theory = [1.2, 0.0, 0.5, math.nan, 0.0]
    found = worst(values, errors, theory)
    assert found is not None
    assert (found.index, found.sigmas, found.looks) == (2, 3.0, 2)
    assert worst([1.0], [0.0], [2.0]) is None
