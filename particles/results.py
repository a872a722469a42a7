"""Estimates with standard errors, how they are made from sums, and how tracers ended.

Tracers of one configuration share their scatterers and are not independent; configurations are. So
every error is the spread over configurations: the delete-one jackknife, and the ratio estimator's
variance for histograms (Cochran, Sampling Techniques, chapters 6 and 9). It is infinite with one.
Begin reading with `Estimate` and `jackknife`.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from particles.values import Value, html_table

#: Columns of a line that an estimate is printed on: components that need more are not printed.
COLUMNS = 100
#: What stands behind a value whose error is unknown, and what it means.
ERROR_UNKNOWN = "± ?"
WHY_UNKNOWN = "± ?: the error is unknown, as one configuration has no spread"
#: Smallest number that is printed to the second digit of its error; smaller ones have an exponent.
#: The origin of the number is not recorded.
SMALLEST_DECIMAL = 1e-4
#: Such numbers are below this one. The origin of the number is not recorded.
DECIMAL_BELOW = 1e6


@dataclass(frozen=True, eq=False)
class Estimate(Value):
    """A value and its standard error, arrays of one shape; time is the first axis.

    The value is NaN where nothing was sampled, the error infinite where it is unknown.
    """

    value: np.ndarray
    error: np.ndarray

    def __repr__(self) -> str:
        """One line for each value along the first axis, with all its components."""
        lines = [", ".join(cells) for cells in self.cells()]
        if len(lines) == 1:
            return f"Estimate({lines[0]})"
        if np.isinf(self.error).any():
            lines.append(WHY_UNKNOWN)
        if any(len(line) > COLUMNS for line in lines):
            return f"Estimate of shape {np.shape(self.value)}"
        return "\n".join(["Estimate", *lines])

    def _repr_html_(self) -> str:
        """The same as a table."""
        rows = []
        for k, cells in enumerate(self.cells()):
            rows.append((str(k), *cells))
        if np.isinf(self.error).any():
            rows.append((WHY_UNKNOWN,))
        return html_table("Estimate, with standard errors", (), rows)

    def cells(self) -> list[list[str]]:
        """Return the components of each value along the first axis, with their errors."""
        values = np.atleast_1d(self.value)
        errors = np.atleast_1d(self.error)
        cells = []
        for value, error in zip(values, errors, strict=True):
            pairs = zip(np.ravel(value).tolist(), np.ravel(error).tolist(), strict=True)
            cells.append([format_estimate(*pair) for pair in pairs])
        return cells

    def divided(self, unit: np.ndarray | float) -> "Estimate":
        """Return the estimate in another unit."""
        return Estimate(self.value / unit, self.error / unit)


def format_estimate(value: float, error: float) -> str:
    """Return a number to the second digit of its error; as it is where that is too long."""
    if error == math.inf:
        return f"{value:.6g} {ERROR_UNKNOWN}"
    size = max(abs(value), error)
    if not 0.0 < error < math.inf or not SMALLEST_DECIMAL <= size < DECIMAL_BELOW:
        return f"{value:.6g} ± {error:.2g}"
    decimals = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:.{decimals}f} ± {error:.{decimals}f}"


@dataclass(frozen=True, eq=False)
class Histogram(Value):
    """Share of the samples in each bin.

    edges (n_bins + 1,), the same at every time. probability: Estimate (n_times, n_bins) of the
    share in a bin, not divided by its width; below, above (n_times,): the shares outside.
    """

    edges: np.ndarray
    probability: Estimate
    below: np.ndarray
    above: np.ndarray

    @property
    def density(self) -> Estimate:
        """Probability per unit of the variable, (n_times, n_bins)."""
        return self.probability.divided(np.diff(self.edges))


@dataclass(frozen=True, eq=False)
class Statuses(Value):
    """How many tracers ended in each way, and where and when the trapped ones did.

    finished: reached the last output time. collision_cap: made max_collisions collisions first.
    trapped: caught in a corner between scatterers, where infinitely many collisions follow within
    1e-9 d or so, or at rest after a head-on collision at e = 0. In a field at rest in a corner of
    two disks that opens against the field; with a tangential restitution below 1, where it would
    slide along a disk; and at rest on the very top of a disk. escaped: flew 1e6 mean free paths
    without a collision. captured: struck a scatterer with a normal velocity below capture_speed.
    trap_times (trapped + captured,) in d/U: when it was declared. With tangential restitution 1 the
    collisions end later by what some 1e-9 d take at the last speed, below 1 they may take for ever.
    trap_places (.., dimension) from the tracer's start, in d; trap_tracers (.., 2): configuration
    and tracer.
    """

    finished: int
    collision_cap: int
    trapped: int
    escaped: int
    trap_times: np.ndarray = field(repr=False)
    trap_places: np.ndarray = field(repr=False)
    trap_tracers: np.ndarray = field(repr=False)
    captured: int = 0


def jackknife(sums: np.ndarray, function: Callable[[np.ndarray], np.ndarray]) -> Estimate:
    """Return function(total) with its delete-one error.

    Parameters
    ----------
    sums : of each configuration, shape (n_configurations, ...)
    function : maps a sum over configurations to an array
    """
    n = len(sums)
    with np.errstate(all="ignore"):
        total = sums.sum(axis=0)
        value = np.asarray(function(total), dtype=float)
        if n < 2:
            return Estimate(value, np.full(value.shape, np.inf))
        without_one = np.array([function(total - own) for own in sums])
        # Deviations from the value: no cancellation in the squares.
        deviations = without_one - value
        error = np.sqrt((n - 1) * deviations.var(axis=0))
    return Estimate(value, _infinite_where_unknown(error))


def estimate_shares(
    counts: np.ndarray, squares: np.ndarray, cross: np.ndarray, samples: np.ndarray, n: int
) -> Estimate:
    """Return counts / samples with its error over n configurations.

    Parameters
    ----------
    counts, squares, cross : sums over configurations of the count c in a bin, of c^2 and of c m,
        where m is the number of samples, shape (n_times, n_bins)
    samples : sums over configurations of m and of m^2, shape (2, n_times)
    n : number of configurations
    """
    with np.errstate(all="ignore"):
        total = samples[0][:, None]
        shares = counts / total
        # The sum over configurations of (c - share m)^2; it may be negative by rounding.
        spread = squares - 2.0 * shares * cross + shares * shares * samples[1][:, None]
        spread = np.maximum(spread, 0.0)
        if n > 1:
            error = np.sqrt(spread * (n / (n - 1))) / total
        else:
            error = np.full(shares.shape, np.inf)
    return Estimate(shares, _infinite_where_unknown(error))


def _infinite_where_unknown(error: np.ndarray) -> np.ndarray:
    return np.where(np.isnan(error), np.inf, error)
