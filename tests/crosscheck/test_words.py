"""Verdicts are right where the truth is known, and numbers are shown with their errors."""

import math

import numpy as np
import pytest
from scipy.stats import norm, t

from kinetics.crosscheck import words
from kinetics.crosscheck.words import Verdict, number, numeral


@pytest.mark.parametrize(("groups", "trials"), [(10**8, 1), (10, 1), (10, 30), (100, 1000)])
def test_the_correction_is_student_and_bonferroni(groups: int, trials: int) -> None:
    p = trials * 2 * t.sf(5.0, groups - 1)
    expected = norm.isf(p / 2) if p < 1 else 0.0
    assert words.corrected_sigmas(-5.0, groups, trials) == pytest.approx(expected, rel=1e-10)
    assert words.gaussian_sigmas(2.0 * norm.sf(8.0)) == pytest.approx(8.0, rel=1e-12)
    assert 30 < words.corrected_sigmas(1e6, 100, 1000) < 40


def test_true_theories_rarely_fail() -> None:
    # 20 000 rows of 12 looks each, from 10 groups: every deviation is pure chance. The union bound
    # promises that at most p(2.5 sigma) = 1.24 % of the rows do not agree, 248; 5 sigma of a
    # Poisson count more is 327. At most 6.3e-5 differ, 1.3; seven or more are a 5e-4 chance.
    samples = np.random.default_rng(3).standard_normal((20_000, 12, 10))
    z = np.abs(samples.mean(-1) / (samples.std(-1, ddof=1) / math.sqrt(10))).max(axis=1)
    verdicts = [words.judge_sigmas(words.corrected_sigmas(one, 10, 12)) for one in z]
    # not far fewer either: independent looks use the bound up
    assert 170 <= len(verdicts) - verdicts.count(Verdict.AGREES) <= 327
    assert verdicts.count(Verdict.DIFFERS) < 7


def test_verdicts_follow_the_thresholds() -> None:
    below, above = words.AGREES_BELOW, words.DIFFERS_ABOVE
    sigmas = (math.nextafter(below, 0), below, math.nextafter(above, 0), above, math.nan)
    verdicts = ["agrees", "unclear", "unclear", "differs", "undefined"]
    assert [*map(words.judge_sigmas, sigmas)] == verdicts
    assert [words.judge_numerical(x, 1e-10) for x in (-1e-10, 1.1e-10)] == ["agrees", "differs"]
    assert [*map(words.judge_approximation, (-0.019, 0.03, -0.2))] == ["close", "rough", "far"]
    assert set(words.MEANING) == set(Verdict)


def test_the_worst_look_is_found_and_unusable_ones_are_left_out() -> None:
    values, errors = [1.0, 9.0, 2.0, 50.0, 3.0], [0.1, 0.0, 0.5, 1.0, math.inf]
    assert words.worst(values, errors, [1.2, 0.0, 0.5, math.nan, 0.0]) == (2, 3.0, 2)
    assert words.worst([1.0], [0.0], [2.0]) is None


def test_numbers_show_their_error() -> None:
    assert number(12.34567, 0.0123) == "12.346 ± 0.012"
    assert number(-1.5, 0.5, "+") == "−1.50 ± 0.50"
    shown = [number(x) for x in (None, 0.123456789, -0.173316, 2.2e7)]
    assert shown == ["–", "0.123457", "−0.173316", "2.2·10⁷"]
    shown = [numeral(*x) for x in ((1e-10, "g"), (2200, ".2g"), (-0.2, "+.0f"))]
    assert shown == ["10⁻¹⁰", "2200", "0"]
