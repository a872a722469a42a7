"""Tables of averages with standard errors, such as `t,v0,v0_error,msd,msd_error`, as a sample.

A table says nothing of single tracers. Its sample has groups that are made up: their mean is the
average of the table, and their spread gives its standard error. Errors of different averages and
times are made independent, as the table does not say how they are correlated.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.comparison.data.columns import Averages
from kinetics.crosscheck.comparison.reduction import MOST_TIMES
from kinetics.crosscheck.comparison.result import said
from kinetics.crosscheck.comparison.sample import R2, R4, V2, V4, Law, N, Sample
from kinetics.errors import InputError

Array = NDArray[np.float64]

GROUPS = 1000
"""Groups that are made up: so many that errors are as good as exact."""


def sample_of(pieces: Sequence[Averages], names: tuple[str, ...], law: Law) -> Sample:
    """The sample of a table, in its own units; InputError for one that cannot be used."""
    where = ", ".join(names)
    columns = {
        name: np.concatenate([piece.columns[name] for piece in pieces])
        for name in pieces[0].columns
    }
    order = np.argsort(columns["time"])
    columns = {name: np.asarray(values, float)[order] for name, values in columns.items()}
    times = columns.pop("time")
    if not times.size or times[0] < 0 or np.any(np.diff(times) <= 0) or times.size > MOST_TIMES:
        raise InputError(
            f"{where}: a table of averages needs 1 to {MOST_TIMES} different times, not negative"
        )
    for name, values in columns.items():
        if name.startswith("error of ") and np.any(values < 0):
            raise InputError(f"{where}: an {name} is negative")
    sums, left_out = _sums(columns, law)
    if not np.any(np.isfinite(sums[0, :, [V2, R2]])):
        raise InputError(f"{where}: no average has a value and a standard error above 0")
    warnings = [said("table")]
    if left_out:
        warnings.append(said("left_out", names=left_out))
    ones = np.ones(times.size)
    return Sample(
        names, times, sums, ones, ones, None, None, None, np.zeros(times.size, np.int64), "table",
        law, warnings=tuple(warnings), tabulated=True,
    )  # fmt: skip


def _sums(columns: Mapping[str, Array], law: Law) -> tuple[Array, list[str]]:
    """The sums of the made-up groups, (GROUPS, n_times, 5), and averages that cannot be used.

    NaN where an average is not known, or its error is not above 0.
    """
    (first, *_) = columns.values()
    spread = _Spread(first.size * len(columns))
    sums = np.full((GROUPS, first.size, 5), np.nan)
    sums[..., N] = 1.0
    relative: dict[int, Array] = {}
    for name, column, power in (
        ("thermal_speed", V2, 2.0), ("mean_square_speed", V2, 1.0), ("msd", R2, 1.0)
    ):  # fmt: skip
        if name in columns and column not in relative:
            value, error = _usable(columns, name)
            relative[column] = spread.of(power * error / value)
            sums[..., column] = value**power * (1 + relative[column])
    left_out = []
    for name, column, second in (("a2", V4, V2), ("kurtosis", R4, R2)):
        if name not in columns:
            continue
        if second not in relative:
            left_out.append(name)
            continue
        value, error = _usable(columns, name)
        size = law.gaussian * (1 + value) if name == "a2" else value
        unit = law.gaussian if name == "a2" else 1.0
        mean = sums[..., second].mean(axis=0)
        # The ratio to the squared second moment has the spread that the table gives it.
        wanted = spread.of(unit * error / size) + 2 * relative[second]
        sums[..., column] = size * mean**2 * (1 + wanted)
    return sums, left_out


def _usable(columns: Mapping[str, Array], name: str) -> tuple[Array, Array]:
    value, error = columns[name], columns[f"error of {name}"]
    good = np.isfinite(value) & (error > 0) & (np.isfinite(error)) & ((value > 0) | (name == "a2"))
    return np.where(good, value, np.nan), np.where(good, error, np.nan)


class _Spread:
    """Deviations of groups from their mean, which are orthogonal for different averages."""

    def __init__(self, most: int) -> None:
        rng = np.random.default_rng(0)
        free = rng.normal(size=(GROUPS, min(most + 1, GROUPS - 1)))
        free[:, 0] = 1.0
        self._axes, _ = np.linalg.qr(free)
        self._next = 1

    def of(self, relative: Any) -> Any:
        """Deviations (GROUPS, n) whose mean is 0 and has these standard errors (n,)."""
        at = 1 + (self._next - 1 + np.arange(relative.size)) % (self._axes.shape[1] - 1)
        self._next += relative.size
        return self._axes[:, at] * relative * np.sqrt(GROUPS * (GROUPS - 1))
