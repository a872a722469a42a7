"""Moments of the displacement: against Mellin-Barnes and series references, limits, identities."""

from typing import Any

import mpmath as mp
import numpy as np
import pytest

from kinetics import Beam, CollisionLaw, Scene, SolverStatus, solve
from kinetics.crosscheck.references import load

NAMES = ("msd", "kurtosis")
LENGTH = 12.5  # mean free path at the default density, in d
TABLE = load()["displacement"]
"""<r^2> and <r^4> at 113 times, in mpmath."""


def run(
    e: float | CollisionLaw,
    outputs: tuple[str, ...],
    times: Any,
    initial: Any = "gaussian",
    **more: Any,
):
    return solve(Scene(e, initial=initial, times=times, outputs=outputs), **more)


@pytest.mark.parametrize("initial", ["gaussian", "monoenergetic"])
@pytest.mark.parametrize("e", [0.0, 0.05, 0.4, 0.7, 0.9, 0.99])
def test_the_references_at_113_times(e: float, initial: str) -> None:
    times = np.asarray(TABLE["T"]) * LENGTH
    found = run(e, NAMES, times, initial)
    assert found.status is SolverStatus.CONVERGED
    reference = TABLE[str(e)][initial]
    square, fourth = (np.asarray(reference[key]) for key in ("square", "fourth"))
    assert np.abs(found.msd / LENGTH**2 / square - 1.0).max() < 1e-10
    quartic = found.kurtosis * (found.msd / LENGTH**2) ** 2
    assert np.abs(quartic / fourth - 1.0).max() < 1e-9


@pytest.mark.parametrize("c", [-1.0, -1.0 / 3.0, 0.9, 1.0 - 1e-6, 1.0 - 1e-12, 1.0])
def test_elastic_moments_are_those_of_the_hierarchy(c: float) -> None:
    """d<v^p z^a conj(z)^b>/dt at one speed is a linear system of constant coefficients.

    Every bounce turns by the same angle; where it hardly turns, closed forms lose all digits.
    """
    law = CollisionLaw.from_samples([1.0], [1.0], [c])
    times = np.array([0.01, 0.3, 1.01, 20.0, 200.0])
    found = run(law, (*NAMES, "mean_displacement"), times * LENGTH, Beam(), rtol=1e-11)
    assert found.status is SolverStatus.CONVERGED
    with mp.workdps(60):
        a, b = 1 - mp.mpf(c), 2 - 2 * mp.mpf(c) ** 2
        # (1, M10, M20, M11, M21, M22) of tests/references/displacement.py
        m = mp.zeros(6)
        m[1, 0], m[1, 1] = 1, -a
        m[2, 1], m[2, 2] = 2, -b
        m[3, 1] = 2
        m[4, 3], m[4, 2], m[4, 4] = 2, 1, -a
        m[5, 4] = 4
        exact = [mp.expm(m * float(t), method="taylor")[:, 0] for t in times]
        x, square, fourth = ([float(state[k]) for state in exact] for k in (1, 3, 5))
    assert np.allclose(found.mean_displacement[:, 0] / LENGTH, x, rtol=1e-11, atol=0.0)
    assert np.allclose(found.msd / LENGTH**2, square, rtol=1e-11, atol=0.0)
    assert np.allclose(found.kurtosis, np.divide(fourth, np.square(square)), rtol=1e-10, atol=0.0)


@pytest.mark.parametrize("c", [-1.0, 0.5, 1.0])
def test_elastic_displacement_to_the_end_of_the_range(c: float) -> None:
    """<r^2> = 2 l^2 T/(1-c), and T^2 l^2 where nothing turns; along one line the kurtosis is 3."""
    law = CollisionLaw.from_samples([1.0], [1.0], [c])
    times = np.array([1e13, 2e13, 1e150])
    found = run(law, (*NAMES, "diffusion_coefficient"), times, "monoenergetic", rtol=1e-10)
    exact = times**2 if c == 1.0 else 2.0 * LENGTH * times / (1.0 - c)
    assert np.allclose(found.msd, exact, rtol=1e-11, atol=0.0)
    growth = 2.0 if c == 1.0 else 1.0
    assert np.allclose(found.msd_slope, growth * exact, rtol=1e-11, atol=0.0)
    assert np.allclose(found.diffusion_coefficient, growth * exact / (4.0 * times), rtol=1e-11)
    assert np.allclose(found.kurtosis, {-1.0: 3.0, 0.5: 2.0, 1.0: 1.0}[c], rtol=1e-10, atol=0.0)


@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-10])
@pytest.mark.parametrize("e", [0.83, 1.0])
def test_the_error_of_the_autocorrelation_is_relative_to_the_speeds(e: float, rtol: float) -> None:
    """To v_rms(0) v_rms(t): the autocorrelation itself passes through 0, or falls much faster."""
    times = np.concatenate([[0.0], np.geomspace(0.1, 1e5, 60)])
    names = ("velocity_autocorrelation", "temperature")
    found = run(e, names, times, "monoenergetic", rtol=rtol)
    exact = run(e, names, times, "monoenergetic", rtol=1e-13)
    expected = exact.velocity_autocorrelation
    if e == 1.0:
        with np.errstate(under="ignore"):
            expected = np.exp(-4.0 / 3.0 * times / LENGTH)
    scale = np.sqrt(2.0 * exact.temperature)  # v_rms(0) = 1
    assert found.status is SolverStatus.CONVERGED
    assert np.abs((found.velocity_autocorrelation - expected) / scale).max() <= rtol
