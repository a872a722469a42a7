"""g(r, t) of the equation against flights: counts of independent tracers, bin by bin.

Tracers of the Boltzmann-Grad medium share nothing, so that the counts of a run are multinomial and
Pearson's sum over the bins is chi-square. The seed is fixed; a right density fails at p = 1e-4 for
one seed in 10 000.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.stats import chi2

from kinetics import Scene, solve
from particles import BoltzmannGrad, simulate

LEAST = 50.0  # expected counts of a bin: neighbours are merged up to there
RARE = 1e-4


@dataclass(frozen=True)
class Counts:
    """counts (n_times, n_bins) of |r| between edges (n_bins + 1,) in d, the first edge 0."""

    edges: np.ndarray
    counts: np.ndarray


def flights(e: float, initial: str, times: list[float], number: int, seed: int) -> Counts:
    """|r| at the times of `number` tracers with random free paths, number density 0.04.

    `number` in blocks of 50 000: 1.5 million tracers a second and processor at 14 collisions each.
    """
    block = min(number, 50_000)
    run = simulate(
        BoltzmannGrad(0.04), e, initial, times, media=number // block, tracers=block, seed=seed,
        observables=["displacement_histogram"],
    )  # fmt: skip
    histogram = run.displacement_histogram
    shares = np.column_stack([histogram.below, histogram.probability.value, histogram.above])
    counts = np.rint(shares * number)
    assert np.all(counts.sum(axis=1) == number)
    # what is below the first edge joins the first bin; nothing flies beyond the last
    assert np.all(counts[:, -1] == 0)
    counts[:, 1] += counts[:, 0]
    return Counts(np.append(0.0, histogram.edges[1:]), counts[:, 1:-1])


def shares_of(density: Callable[[np.ndarray], np.ndarray], edges: np.ndarray) -> np.ndarray:
    """Integral of a radial density over each bin, (n_times, n_bins), by three points a bin."""
    x, w = np.polynomial.legendre.leggauss(3)
    width = np.diff(edges)
    r = (edges[:-1, None] + width[:, None] * (x + 1) / 2).ravel()
    values = np.asarray(density(r))
    return values.reshape(len(values), len(width), 3) @ (w / 2) * width


def chi_square(counts: np.ndarray, shares: np.ndarray) -> tuple[float, int, float]:
    """Pearson's sum of one time, its degrees of freedom and its p-value.

    shares (n_bins,) of a law that may leave out something: the rest makes a bin of its own.
    """
    number = counts.sum()
    expected = number * shares
    group = np.zeros(len(counts), dtype=int)
    filled = 0.0
    for k in range(1, len(counts)):
        filled += expected[k - 1]
        group[k] = group[k - 1]
        if filled >= LEAST and expected[k:].sum() >= LEAST:
            group[k] += 1
            filled = 0.0
    n = np.bincount(group, counts)
    m = np.bincount(group, expected)
    total = float(np.sum((n - m) ** 2 / m))
    freedom = len(n) - 1
    return total, freedom, float(chi2.sf(total, freedom))


def inside(counts: np.ndarray, edges: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """The edges of one time where tracers are, up to `reach`, and their counts.

    The first bin reaches down to 0; the last count is of all that is beyond the last edge.
    """
    low = int(np.searchsorted(np.cumsum(counts), LEAST))
    high = len(counts) - int(np.searchsorted(np.cumsum(counts[::-1]), LEAST))
    high = min(high, int(np.searchsorted(edges, reach, side="right")) - 1)
    kept = np.concatenate([[counts[: low + 1].sum()], counts[low + 1 : high]])
    return np.append(0.0, edges[low + 1 : high + 1]), np.append(kept, counts[high:].sum())


# -- the method on a law that is known ------------------------------------------------------------


def isotropic_walk(t: float, number: int, stretch: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Counts and edges of r drawn from the exact isotropic walk at t; `stretch` falsifies it."""
    u = np.random.default_rng(7).uniform(size=number)
    s = np.maximum(t + np.log1p(-u), 0.0)  # sqrt(t^2 - r^2); 0 for the ring
    edges = np.linspace(0.0, t, 101)
    counts = np.histogram(np.minimum(stretch * np.sqrt(t**2 - s**2), t), edges)[0]
    return counts.astype(float), edges


def test_a_right_law_passes_and_a_slightly_wrong_one_fails() -> None:
    t = 3.0
    for stretch, right in ((1.0, True), (1.005, False)):
        counts, edges = isotropic_walk(t, 1_000_000, stretch)
        # the ring stands in the last bin
        share = np.diff(-np.expm1(np.sqrt(t**2 - edges**2) - t))
        share[-1] += np.exp(-t)
        total, freedom, p = chi_square(counts, share)
        assert freedom == 99
        assert (p > RARE) is right, (total, freedom, p)


def test_bins_are_merged_until_enough_is_expected() -> None:
    counts = np.array([10.0, 30.0, 20.0, 100.0, 4.0])
    total, freedom, p = chi_square(counts, counts / counts.sum())
    assert (total, freedom, p) == (pytest.approx(0.0), 1, pytest.approx(1.0))


def test_shares_are_integrals_of_the_density() -> None:
    edges = np.append(0.0, np.geomspace(0.01, 20.0, 200))
    times = np.array([1.0, 4.0])[:, None]
    found = shares_of(lambda r: 2 * r / times * np.exp(-(r**2) / times), edges)
    exact = np.diff(-np.exp(-(edges**2) / times), axis=1)
    np.testing.assert_allclose(found, exact, atol=1e-10)


def test_flights_have_the_mean_square_of_the_equation() -> None:
    times = [60.0, 600.0]
    found = flights(0.7, "gaussian", times, 100_000, seed=21)
    middle = np.sqrt((found.edges[1:] ** 2 + found.edges[:-1] ** 2) / 2)
    square = found.counts @ middle**2 / 100_000
    exact = solve(Scene(0.7, times=times, outputs=("msd",))).msd
    # <r^4> = 2.5 <r^2>^2 makes 0.4 % of it; 5 of that, and 0.1 % for the bins
    np.testing.assert_allclose(square, exact, rtol=0.02)


# -- the density of the solver --------------------------------------------------------------------

CASES = [(0.4, "gaussian"), (0.9, "gaussian"), (1.0, "gaussian"), (0.7, "monoenergetic")]
TIMES = [60.0, 300.0, 1500.0]  # 3 to 20 collisions
# of one speed: before that, the first collisions leave a front that g(r, t) resolves to a percent
LATER = [300.0, 1500.0]


def compare(e: float, initial: str, number: int, rtol: float) -> list[float]:
    """p-values at the times of the density against `number` flights."""
    times = LATER if initial == "monoenergetic" else TIMES
    found = flights(e, initial, times, number, seed=1234)
    out = []
    for k, t in enumerate(times):
        solution = solve(
            Scene(
                e, number_density=0.04, initial=initial, times=[t], outputs=("position_density",)
            ),
            rtol=rtol,
        )
        # short of the front of one speed, at r = t, where the density is not smooth
        reach = 0.9 * t if initial == "monoenergetic" else np.inf
        edges, counts = inside(found.counts[k], found.edges, reach)
        share = shares_of(solution.position_density, edges)[0]
        out.append(chi_square(counts, np.append(share, max(0.0, 1.0 - share.sum())))[2])
    return out


@pytest.mark.parametrize(
    ("e", "initial"),
    [CASES[1], CASES[3], *(pytest.param(*c, marks=pytest.mark.slow) for c in (CASES[0], CASES[2]))],
)
def test_the_density_meets_a_million_flights(e: float, initial: str) -> None:
    p = compare(e, initial, 1_000_000, 1e-5)
    assert min(p) > RARE, p


@pytest.mark.slow
@pytest.mark.parametrize(("e", "initial"), CASES)
def test_the_density_meets_a_hundred_million_flights(e: float, initial: str) -> None:
    p = compare(e, initial, 100_000_000, 1e-8)
    assert min(p) > RARE, p
