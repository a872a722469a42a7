"""A made-up case whose truth is known: a Gaussian VDF, a cooling law and an msd by formula."""

import math
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from kinetics import CollisionLaw
from kinetics.crosscheck.report.case import (
    Case,
    DensityScan,
    Measured,
    ParticleRun,
    Scans,
    TrapScan,
)
from kinetics.crosscheck.report.observables import (
    bands_of,
    bin_average,
    bin_density,
    cooling_rate_between,
    last_vdf,
    msd_slope_between,
)
from kinetics.crosscheck.report.settings import ReportSettings

sys.path.insert(0, str(Path(__file__).parent))  # for chromium.py and pages.py

from chromium import Browser, found

TIMES = np.geomspace(1.0, 1000.0, 12)
EDGES = np.linspace(0.0, 4.0, 21)
EARLY = 8


def gaussian_vdf(c: Any) -> Any:
    return np.exp(-np.square(c)) / math.pi


def made_up_solution(rate: float = 0.4) -> Any:
    """A solution with v0 = 1/(1/sqrt(2) + 0.04 rate t), a2 = 0.1 and a Gaussian VDF."""
    speed = 1 / (1 / math.sqrt(2) + 0.04 * rate * TIMES)

    def speed_density(v: Any) -> Any:
        c = np.asarray(v)[None, :] / speed[:, None]
        return 2 * c * np.exp(-(c**2)) / speed[:, None]

    return SimpleNamespace(
        times=TIMES,
        scene=SimpleNamespace(mean_free_path=12.5, law=CollisionLaw(0.7)),
        thermal_speed=speed,
        a2=np.full(TIMES.size, 0.1),
        msd=800 * np.log1p(TIMES / 30),
        msd_slope=800 * TIMES / (30 + TIMES),
        kurtosis=np.full(TIMES.size, 2.5),
        speed_density=speed_density,
    )


def made_up_position() -> Any:
    """A displacement density G(R) = 4 R exp(-2 R), whose R is not scaled by its own <R^2>."""

    def within(r: Any) -> Any:
        return 1 - (1 + 2 * r) * np.exp(-2 * r)

    return SimpleNamespace(
        msd=np.ones(1),
        rtol=1e-6,
        scaled_position_density=lambda r: (4 * r * np.exp(-2 * r))[None],
        position_fraction=lambda edges: np.diff(within(edges))[None],
        position_tail=lambda r: (np.ones((1, len(r))), np.full((1, len(r)), 2.0)),
    )


def made_up_run(name: str, solution: Any, sigmas: float, free_path: float) -> ParticleRun:
    """A run that deviates from a solution by so many standard errors, each 1 % of the value."""

    def off(theory: Any) -> Measured:
        theory = np.asarray(theory, dtype=float)
        error = 0.01 * np.abs(theory) + 1e-300
        return Measured(theory + sigmas * error, error)

    rate = cooling_rate_between(TIMES, solution.thermal_speed, EARLY, 0.04)
    slope = msd_slope_between(TIMES, solution.msd, EARLY)
    tail: Any = SimpleNamespace(position=made_up_position(), dimension=2)
    return ParticleRun(
        name=name,
        samples=10_000,
        groups=100,
        thermal_speed=off(solution.thermal_speed),
        a2=off(solution.a2),
        msd=off(solution.msd),
        kurtosis=off(solution.kurtosis),
        cooling_rate=off(rate),
        msd_slope=off(slope),
        free_path=Measured(np.asarray(free_path + sigmas * 0.02), np.asarray(0.02)),
        vdf=off(bin_average(last_vdf(solution), EDGES)),
        position=off(bin_density(tail, EDGES)),
        tail_exponent=off(bands_of(tail)),
        mean_collisions=12.5,
        most_collisions=40,
        above_cap=0.0,
        statuses={"finished": 10_000, "trapped": 0, "escaped": 0},
    )


def made_up_case(
    free: float = 0.5, disks: float = 0.5, restitution: float = 0.7, dense: bool = True
) -> Case:
    """A case whose Boltzmann-Grad and hard-disk runs deviate by so many standard errors."""
    solution = made_up_solution()
    scaled: Any = SimpleNamespace(
        cooling_rate=0.4,
        a2=0.1,
        vdf=gaussian_vdf,
        diffusion_slope=9.0,
        tail_rate=5.0,
        tail_power=0.5,
        log_tail_amplitude=0.0,
    )
    run = made_up_run("hard disks", solution, disks, 12.5)
    return Case(
        restitution=restitution,
        law=CollisionLaw(restitution),
        times=TIMES,
        early=EARLY,
        speed_edges=EDGES,
        position_edges=EDGES,
        exact=scaled if restitution < 1 else None,
        scaled=scaled if restitution < 1 else None,
        kinetic=solution,
        rescaled=solution,
        late=solution,
        position=made_up_position(),
        free=made_up_run("Boltzmann-Grad", solution, free, 12.5),
        hard=run,
        dense=SimpleNamespace(**(vars(solution) | {"msd": 0.9 * solution.msd})) if dense else None,
        dense_slope=1000.0 if dense else None,
        rescaled_errors={
            name: getattr(run, name).error
            for name in ("thermal_speed", "a2", "msd", "kurtosis", "cooling_rate", "msd_slope")
        },
    )


@pytest.fixture(scope="session")
def make_case() -> Callable[..., Case]:
    return made_up_case


@pytest.fixture(scope="session")
def scans() -> Scans:
    """Scans of which all is known: ratios 1 - x, and one density without any trap."""
    x = np.array([0.01, 0.02, 0.04])
    ratio = Measured(1 - x, np.full(3, 0.01))
    names = ("free_path", "thermal_speed", "msd")
    return Scans(
        DensityScan(
            restitution=0.7,
            densities=x,
            samples=1000,
            degree=1,
            ratios=dict.fromkeys(names, ratio),
            fits={name: np.array([1.0, -1.0]) for name in names},
            limits=dict.fromkeys(names, Measured(np.asarray(1.0), np.asarray(0.01))),
        ),
        TrapScan(
            time=1000.0,
            restitutions=np.array([0.0, 0.3, 0.6]),
            densities=np.array([0.04, 0.16]),
            samples=1000,
            share=Measured(
                np.array([[0.1, 0.01, 0.0], [0.3, 0.03, 0.001]]),
                np.array([[0.01, 0.003, 0.0], [0.02, 0.006, 0.001]]),
            ),
        ),
    )


@pytest.fixture(scope="session")
def settings() -> ReportSettings:
    return ReportSettings(restitutions=(0.7,), final_times=(1000.0,))


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """Debian's Chromium; skips where there is none."""
    program = found()
    if program is None:
        pytest.skip("no Chromium on PATH")
    with Browser(program) as opened:
        yield opened
