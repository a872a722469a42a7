"""g(r, t) of the equation against flights of independent tracers, as `compare` judges them.

The counts of a Boltzmann-Grad run are multinomial, and Pearson's sum over the bins is chi-square.
The seed is fixed; a right density fails at p = 1e-4 for one seed in 10 000.
"""

from functools import cache
from typing import Any

import pytest
from marking import slow_but

from kinetics import Scene, solve
from kinetics.crosscheck import compare
from particles import BoltzmannGrad, simulate

CASES = [(0.4, "gaussian"), (0.9, "gaussian"), (1.0, "gaussian"), (0.7, "monoenergetic")]
TIMES = {"gaussian": [60.0, 300.0, 1500.0], "monoenergetic": [300.0, 1500.0]}
"""3 to 20 collisions. Before, the first collisions of one speed leave a front, and g(r, t) is known
to a percent there."""
RARE = 1e-4


@cache
def flights(e: float, initial: str, number: int) -> Any:
    """A run in blocks of 50 000 tracers, with counts of |r|."""
    block = min(number, 50_000)
    return simulate(
        BoltzmannGrad(0.04), e, initial, TIMES[initial], media=number // block, tracers=block,
        seed=1234, observables=["displacement_histogram"],
    )  # fmt: skip


def p_values(e: float, initial: str, number: int, rtol: float, told: float) -> list[float]:
    """Of the density at the restitution `told`, against `number` flights, at each time."""
    times = TIMES[initial]
    scene = Scene(told, 0.04, initial=initial, times=times, outputs=("position_density",))
    found = compare(solve(scene, rtol=rtol), flights(e, initial, number), explain=False)
    assert [test.time for test in found.tests] == times
    return [test.p_value for test in found.tests]


@pytest.mark.parametrize(
    ("e", "initial"),
    slow_but(CASES[1:2], CASES),
)
def test_the_density_meets_a_million_flights(e: float, initial: str) -> None:
    assert min(p_values(e, initial, 1_000_000, 1e-5, e)) > RARE


def test_a_slightly_wrong_density_does_not() -> None:
    assert max(p_values(0.7, "monoenergetic", 1_000_000, 1e-5, 0.69)) < RARE


@pytest.mark.slow
@pytest.mark.parametrize(("e", "initial"), CASES)
def test_the_density_meets_a_hundred_million_flights(e: float, initial: str) -> None:
    assert min(p_values(e, initial, 100_000_000, 1e-8, e)) > RARE
