"""Integrals along the path: closed forms of the Boltzmann-Grad limit, exact sums, what is refused.

Sigmas are at fixed seeds; the numbers of one run are correlated.
"""

import os
import subprocess
import sys
import textwrap
from typing import Any

import numpy as np
import pytest

from particles import (
    BoltzmannGrad,
    HardDisks,
    HardSpheres,
    Medium,
    Poisson,
    PoissonSpheres,
    path_integrals,
)

POWERS = [(1, 0.0), (2, 0.0), (0, 1.0), (0, 2.5), (1, 1.0), (3, 0.5)]
PATHS = np.array([0.7, 3.0, 12.0])


def collision_rates(e: float, et: float, dimension: int) -> np.ndarray:
    """1 - E[s^p cos(m chi)], in space with P_m, by quadrature over the impact parameter."""
    y, weight = np.polynomial.legendre.leggauss(4000)
    y, weight = 0.5 * (1.0 + y), 0.5 * weight * (1.0 if dimension == 2 else 1.0 + y)
    s = np.sqrt(e**2 * (1.0 - y * y) + et**2 * y * y)
    cosine = np.clip(((e + et) * y * y - e) / s, -1.0, 1.0)
    rates = []
    for m, p in POWERS:
        plane = np.cos(m * np.arccos(cosine))
        space = np.polynomial.legendre.legval(cosine, [0.0] * m + [1.0])
        rates.append(1.0 - np.sum(weight * s**p * (plane if dimension == 2 else space)))
    return np.array(rates)


def in_the_limit(rates: np.ndarray) -> np.ndarray:
    """The integrals up to each of PATHS, (n_paths, n_powers): a mean over exponential flights."""
    return (1.0 - np.exp(-rates * PATHS[:, None])) / rates


@pytest.mark.parametrize(
    ("e", "et"),
    [
        (0.6, 0.8),
        pytest.param(0.5, 1.0, marks=pytest.mark.slow),
        pytest.param(0.2, 1.0, marks=pytest.mark.slow),
        pytest.param(0.9, 1.0, marks=pytest.mark.slow),
        pytest.param(0.0, 0.9, marks=pytest.mark.slow),
    ],
)
def test_boltzmann_grad_has_the_closed_form(e: float, et: float) -> None:
    run = path_integrals(
        BoltzmannGrad(0.02), e, POWERS, PATHS, windows=20, settling=2.5, media=12, tracers=60,
        seed=5, tangential_restitution=et,
    )  # fmt: skip
    exact = in_the_limit(collision_rates(e, et, 2))
    found = run.integrals
    assert np.all(abs(found.value - exact) < 3.5 * found.error)
    assert np.all(found.error[-1] < 0.04)
    assert abs(run.mean_free_path.value - 1.0) < 3.0 * run.mean_free_path.error
    part = exact[-1] - exact[-2]
    assert np.all(abs(run.last_part.value - part) < 3.5 * run.last_part.error)
    assert run.windows == 12 * 60 * 20
    assert run.trapped == 0


@pytest.mark.slow
def test_thin_spheres_have_the_closed_form_with_legendre_polynomials() -> None:
    # The density changes the integrals by about rho d^3 = 1e-3.
    run = path_integrals(
        PoissonSpheres(1e-3, count=None), 0.5, POWERS, PATHS, windows=5, media=60, tracers=20,
        seed=3,
    )  # fmt: skip
    found = run.integrals
    exact = in_the_limit(collision_rates(0.5, 1.0, 3))
    assert np.all(abs(found.value - exact) < 3.5 * found.error)
    assert np.all(found.error[-1] < 0.08)


@pytest.mark.parametrize(
    "medium",
    [
        BoltzmannGrad(3.0, diameter=0.2),
        Poisson(0.1, 400),
        pytest.param(HardDisks(0.2, box=None), marks=pytest.mark.slow),
        HardSpheres(0.1, count=200),
    ],
)
def test_every_path_is_cut_into_whole_windows(medium: Medium) -> None:
    """The integral of 1 is the path, and P_m = P_m(1) = 1 on a first flight longer than a path."""
    paths = [1e-9, 0.3, 2.0, 2.5]
    run = path_integrals(
        medium, 1.0, [(0, 0.0), (0, 3.0), (5, 1.0)], paths, windows=7, settling=0.4, media=3,
        tracers=30,
    )  # fmt: skip
    np.testing.assert_allclose(run.integrals.value[:, 0], paths, rtol=1e-12)
    np.testing.assert_allclose(run.integrals.value[:, 1], paths, rtol=1e-12)
    np.testing.assert_allclose(run.integrals.value[0], 1e-9, rtol=1e-5)
    assert run.windows == 3 * 30 * 7
    assert np.all(run.totals[:, 1] == pytest.approx(30 * (0.4 + 7 * 2.5), rel=1e-12))


def test_the_length_of_a_unit_changes_nothing() -> None:
    one = path_integrals(Poisson(0.25, 400), 0.7, POWERS, PATHS, media=2, tracers=5)
    other = path_integrals(Poisson(1.0, 400, diameter=0.5), 0.7, POWERS, PATHS, media=2, tracers=5)
    assert np.array_equal(one.sums, other.sums)


def test_a_trapped_tracer_ends_in_its_window() -> None:
    run = path_integrals(
        Poisson(0.3, 1000), 0.2, [(0, 0.0)], [50.0], windows=5, media=4, tracers=50
    )
    assert run.trapped > 50
    assert run.windows < 4 * 50 * 5
    assert run.integrals.value[0, 0] < 0.9 * 50.0
    assert f"{run.trapped} tracers trapped" in repr(run)


def test_results_do_not_depend_on_the_number_of_threads() -> None:
    runs = [
        path_integrals(HardDisks(0.2, 200), 0.6, POWERS, PATHS, media=5, tracers=20, workers=w)
        for w in (1, 3)
    ]
    assert runs[0] == runs[1]
    assert runs[0] != path_integrals(
        HardDisks(0.2, 200), 0.6, POWERS, PATHS, media=5, tracers=20, seed=2
    )


PROGRAM = """
    import hashlib
    from particles import *
    media = (
        Poisson(0.3, 80), BoltzmannGrad(0.1), HardSpheres(0.4, count=40), ForgetfulPoisson(0.3, 4),
    )
    for medium in media:
        run = path_integrals(medium, 0.4, [(1, 0.0), (3, 1.5)], [0.5, 2.0], 2, 1.0, 2, 18)
        print(hashlib.sha256(run.sums.tobytes() + run.totals.tobytes()).hexdigest())
    names = [name for name in OBSERVABLES]
    run = simulate(ForgetfulPoisson(0.3, 4), 0.4, times=[0.0, 1.0, 40.0], media=2, tracers=18,
                   observables=names)
    for name in sorted(run.arrays):
        print(name, hashlib.sha256(run.arrays[name].tobytes()).hexdigest())
"""


def test_interpreted_and_compiled_kernels_give_the_same_bits() -> None:
    def run(**environment: str) -> str:
        command = [sys.executable, "-W", "ignore::RuntimeWarning", "-c", textwrap.dedent(PROGRAM)]
        return subprocess.run(
            command, env=os.environ | environment, capture_output=True, text=True, check=True
        ).stdout

    compiled = run()
    assert len(compiled.splitlines()) == 4 + 15
    assert run(NUMBA_DISABLE_JIT="1") == compiled


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"medium": BoltzmannGrad(0.1, dimension=3)}, "medium = .*in the plane"),
        ({"restitution": 2.0}, "restitution = 2.0: must be"),
        ({"powers": []}, "powers = "),
        ({"powers": [(0.5, 1.0)]}, "powers = .*whole number"),
        ({"powers": [(1, -1.0)]}, "powers = "),
        ({"powers": [(1, np.nan)]}, "powers = "),
        ({"powers": [(2000, 1.0)]}, "powers = .*1000"),
        ({"powers": "ab"}, "powers = 'ab'"),
        ({"paths": []}, "paths = "),
        ({"paths": [0.0, 1.0]}, "paths = .*positive"),
        ({"paths": [2.0, 1.0]}, "paths = .*increase"),
        ({"paths": [np.inf]}, "paths = .*finite"),
        ({"windows": 0}, "windows = 0"),
        ({"windows": 10**6}, "windows = 1000000: all windows"),
        ({"settling": -1.0}, "settling = -1.0"),
        ({"tracers": 0}, "tracers = 0"),
        ({"workers": 0}, "workers = 0"),
    ],
)
def test_bad_arguments_are_refused(wrong: dict[str, Any], words: str) -> None:
    good: dict[str, Any] = {
        "medium": BoltzmannGrad(0.1), "restitution": 0.5, "powers": [(1, 0.0)], "paths": [1.0, 2.0],
    }  # fmt: skip
    with pytest.raises(ValueError, match=words):
        path_integrals(**good | wrong)
