"""Fitted values over many made sets: unbiased, with honest errors, and none where nothing fits."""

from typing import Any

import numpy as np
import pytest

from kinetics.crosscheck import compare_data
from kinetics.crosscheck.comparison.data.columns import Rows
from kinetics.crosscheck.comparison.fit import Components, Unknown, fit
from kinetics.crosscheck.comparison.question import compare_sample, fitted_to
from kinetics.crosscheck.comparison.reduction import Reduction
from kinetics.crosscheck.comparison.sample import Sample
from particles import BoltzmannGrad, HardDisks, simulate

TIMES = np.geomspace(1.0, 500.0, 8)
TRACERS = 1500
TRUTH = np.array([0.7, np.log(12.5)])
"""Restitution and ln l."""


def made_set(seed: int) -> Sample:
    """Independent tracers among scatterers in the Boltzmann-Grad limit, from a Gaussian start."""
    run = simulate(
        BoltzmannGrad(0.04), restitution=0.7, times=TIMES, media=15, tracers=TRACERS // 15,
        seed=seed, workers=1, observables=("positions", "velocities"),
    )  # fmt: skip
    reduction = Reduction("tracer")
    for time, r, v in zip(TIMES, run.positions, run.velocities, strict=True):
        reduction.add(Rows(np.full(TRACERS, time), *r.T, *v.T, tracer=np.arange(TRACERS)))
    return reduction.sample(("made",))


def pulls(sets: int) -> tuple[Any, list[float]]:
    """(fitted - truth)/error of restitution and ln l, (sets, 2), and what p-values fits leave."""
    found, p_values = [], []
    for seed in range(sets):
        fit = fitted_to(made_set(5000 + seed), None, None, "gaussian")
        found.append((fit.values - TRUTH) / fit.errors)
        assert fit.chi_square is not None
        p_values.append(fit.chi_square.p_value)
    return np.array(found), p_values


def skewed_pulls(logarithms: bool) -> Any:
    """Pulls of the scale of 16 averages of exponential numbers, in 300 sets, (300,).

    As <v^2> of a Gaussian, whose variance is proportional to its square.
    """
    rng, truth, found = np.random.default_rng(7), np.geomspace(1, 0.01, 16), []
    every = Components(np.arange(16), np.arange(16), logarithms)
    for _ in range(300):
        values = rng.exponential(size=(250, 6, 16)) * truth
        groups = values.sum(axis=1)
        total = groups.sum(axis=0)
        data = total / 1500, (total - groups) / (1500 - 6)
        fitted = fit([Unknown("logarithm", -3, 3)], scaled(truth), data, every, [[0.0]])
        assert fitted is not None
        found.append(float(fitted.values[0] / fitted.errors[0]))
    return np.array(found)


def scaled(truth: Any) -> Any:
    """A model: all averages times the exponential of one parameter."""
    return lambda at: (truth * np.exp(at[0]), truth * np.exp(at[0]))


@pytest.mark.slow
def test_logarithms_take_the_bias_away() -> None:
    """Fitted as they are, averages give a scale that is too small: theirs is -0.20 here."""
    right, wrong = skewed_pulls(logarithms=True), skewed_pulls(logarithms=False)
    assert abs(right.mean()) < 0.15
    assert abs(right.std(ddof=1) - 1) < 0.12
    assert right.mean() - wrong.mean() > 0.1


@pytest.mark.slow
def test_fitted_values_have_honest_errors() -> None:
    """Over 200 sets; with a2 and the kurtosis in the fit the means are +0.6 and -0.6, and the
    standard deviations 1.5."""
    from scipy.stats import kstest

    found, p_values = pulls(200)
    assert np.all(np.abs(found.mean(axis=0)) < 0.15)
    assert np.all(np.abs(found.std(axis=0, ddof=1) - 1) < 0.12)
    assert kstest(p_values, "uniform").pvalue > 1e-3


def test_a_model_that_does_not_fit_has_no_value() -> None:
    """Overlapping in nothing: dense hard disks, which no restitution and density explain."""
    run = simulate(
        HardDisks(0.2, 3000), restitution=0.75, times=TIMES, media=120, tracers=100, seed=5,
        workers=1,
    )  # fmt: skip
    told = compare_data(run, explain=False)
    assert told.parameters["restitution"].value == 0.75
    from kinetics.crosscheck.comparison.data.ensemble_files import from_ensemble

    sample = from_ensemble(run)
    sample.told.clear()
    found = compare_sample(sample, explain=False)
    assert found.verdict == "differs"
    for parameter in found.parameters.values():
        assert (parameter.value, parameter.error) == (None, None)
        assert parameter.source.startswith("no value: the model does not fit (chi-square ")
    assert "no value: the model does not fit" in found.to_json()
