"""Histograms against a density: bins wide enough to be judged, and their chi-square."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.comparison.sample import Binned, Sample
from kinetics.crosscheck.comparison.statistics import (
    ChiSquare,
    hotelling,
    most_freedom,
    pearson,
)
from kinetics.crosscheck.comparison.theory import SPEED, bin_shares
from kinetics.states.isotropic import Monoenergetic

if TYPE_CHECKING:
    from kinetics import Solution

Array = NDArray[np.float64]

LEAST_EXPECTED = 50
"""Samples that a bin must be expected to hold: their distribution is then nearly Gaussian."""
MOST_IN_A_BIN = 1 / 12
"""Share of the samples from which on a bin is not made wider, so that the body has a shape."""
_MOST_BINS = 40


@dataclass(frozen=True)
class Histogram:
    """One histogram at one time against the theory, in bins of LEAST_EXPECTED samples or more.

    name : "speed_density" or "position_density"; time in d/U, and its index in the sample
    edges (n + 1,), in U or d: the first is 0, the last infinite; share of the samples, its standard
    error (from `groups` groups) and the theory, (n,) each.
    """

    name: str
    time: float
    index: int
    edges: Array
    share: Array
    error: Array
    theory: Array
    samples: int
    groups: int
    chi_square: ChiSquare | None


def compare_histogram(
    sample: Sample, solution: "Solution", name: str, index: int, at: int
) -> Histogram | None:
    """A sample's histogram at its time `index` against a solution's density at its time `at`.

    None where too few samples are expected for two bins.
    """
    binned = sample.speeds if name == SPEED else sample.displacements
    assert binned is not None
    samples = int(binned.totals[index].sum())
    shares = bin_shares(solution, name, at, binned.edges[index])
    shares = shares / shares.sum()
    independent = sample.grouping != "medium" or sample.free
    most = _MOST_BINS
    if not independent and binned.by_group is not None:
        most = min(most, most_freedom(len(binned.by_group)) + 1)
    peak = None
    if isinstance(solution.scene.state, Monoenergetic):
        peak = solution.scene.state.speed * (1.0 if name == SPEED else sample.times[index])
    starts = _merged(shares * samples, samples, most, binned.edges[index], peak)
    if starts.size < 2:
        return None
    theory = np.add.reduceat(shares, starts)
    counts = np.add.reduceat(binned.totals[index], starts).astype(float)
    share = counts / samples
    edges = np.concatenate([[0.0], binned.edges[index][starts[1:] - 1], [np.inf]])
    error, groups = _errors(binned, index, starts, share, samples)
    # The spread of a bin that is emptier than expected is too small: at least binomial.
    error = np.maximum(error, np.sqrt(theory * (1 - theory) / samples))
    if independent or groups is None:
        effect = 1.0 if binned.design_effect is None else float(binned.design_effect[index])
        chi_square = pearson(counts, theory * samples, effect)
    else:
        # Left out in turn: the shares of all but one group.
        rest = counts - groups
        replicates = rest / rest.sum(axis=1, keepdims=True) - theory
        chi_square = hotelling((share - theory)[:-1], replicates[:, :-1])
    behind = sample.groups if binned.by_group is None else len(binned.by_group)
    time = float(sample.times[index])
    return Histogram(name, time, index, edges, share, error, theory, samples, behind, chi_square)


def _errors(
    binned: Binned, index: int, starts: NDArray[np.int64], share: Array, samples: int
) -> tuple[Array, Array | None]:
    """Standard errors of the shares, and the counts of each group if they are known."""
    if binned.by_group is None:
        assert binned.design_effect is not None
        return np.sqrt(share * (1 - share) / samples * binned.design_effect[index]), None
    groups = np.add.reduceat(binned.by_group[:, index].astype(float), starts, axis=1)
    spread = groups - share * groups.sum(axis=1, keepdims=True)
    n = len(groups)
    return np.sqrt(n / (n - 1) * np.sum(spread**2, axis=0)) / samples, groups


def _merged(
    expected: Array, samples: int, most: int, edges: Array, peak: float | None
) -> NDArray[np.int64]:
    """The first fine bin of each bin, from the counts expected in the fine bins.

    Bins start at LEAST_EXPECTED in the tails and double towards the middle, where the body is: a
    small excess at rest or far out is seen beside few others. Of a delta peak that stands on an
    edge, rounding may have put samples on either side: no bin ends there.
    """
    widest = max(samples * MOST_IN_A_BIN, samples / most * 2, LEAST_EXPECTED)
    starts, held, before = [0], 0.0, 0.0
    for k, count in enumerate(expected[:-1].tolist()):
        held += count
        target = min(max(min(before, (samples - before) / 2), LEAST_EXPECTED), widest)
        on_peak = peak is not None and abs(edges[min(k, edges.size - 1)] - peak) < 1e-6 * peak
        if held >= target and samples - before - held >= LEAST_EXPECTED and not on_peak:
            starts.append(k + 1)
            before += held
            held = 0.0
    while len(starts) > most:  # where the tails alone are too many, every second edge goes
        starts = starts[::2]
    return np.array(starts)
