"""Least squares with the covariance of the data: restitution and free path from a sample.

The same machinery finds what was not told and tests what may explain a difference: a hypothesis
is a theory with parameters, and what it explains is by how much it lowers the chi-square.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.comparison.statistics import (
    ChiSquare,
    covariance,
    hotelling,
    most_freedom,
    spread_out,
    whitening,
)

Array = NDArray[np.float64]

Model = Callable[[Array], tuple[Array, Array]]
"""Parameters to theory (p,), and its replicates (p,) or (G, p)."""
_STEP = 1e-4
_ROUNDS = 30
_TRIED = 2
"""Starts that are descended from."""


@dataclass(frozen=True)
class Fit:
    """Parameters with standard errors, the chi-square that is left, and how data move them.

    influence (k, p): d(parameters)/d(data), slope (p, k): d(theory)/d(parameters), for the p
    components that were fitted.
    """

    names: tuple[str, ...]
    values: Array
    errors: Array
    chi_square: ChiSquare | None
    influence: Array
    slope: Array
    components: NDArray[np.int64]

    def moved(self, replicates: Array) -> Array:
        """The parameters' shift in each replicate of the data (G, p_all): (G, k)."""
        chosen = replicates[:, self.components]
        return np.asarray((chosen - chosen.mean(axis=0)) @ self.influence.T)


def choose_components(usable: NDArray[np.bool_], groups: int, parameters: int) -> NDArray[np.int64]:
    """Which components (n_names, n_times) can be fitted together: flat indices.

    No more than the groups allow, evenly over time for each average, but not fewer than twice the
    parameters if the groups allow that.
    """
    most = max(most_freedom(groups), min(2 * parameters, groups - 2))
    rows = [np.flatnonzero(row) for row in usable]
    rows = [row for row in rows if row.size]
    if not rows:
        return np.empty(0, np.int64)
    share = max(1, most // len(rows))
    at = [
        k * usable.shape[1] + row[spread_out(row.size, share)]
        for k, row in enumerate(np.flatnonzero(u) for u in usable)
        if row.size
    ]
    return np.concatenate(at)[:most] if len(at) * share > most else np.concatenate(at)


def fit(
    names: Sequence[str],
    model: Model,
    data: tuple[Array, Array],
    components: NDArray[np.int64],
    starts: Sequence[Sequence[float]],
    lower: Sequence[float],
    upper: Sequence[float],
) -> Fit | None:
    """Least squares from the best starts; None where nothing converges.

    data: values (p_all,) and replicates (G, p_all); model gives the same p_all. Parameters stay
    between lower and upper.
    """
    values, replicates = data
    low, high = np.asarray(lower, float), np.asarray(upper, float)

    def residual(at: Array) -> tuple[Array, Array]:
        theory, moved = model(at)
        return (values - theory)[components], (replicates - moved)[..., components]

    best: tuple[float, Array] | None = None
    for at in _most_promising(residual, [np.clip(np.asarray(s, float), low, high) for s in starts]):
        white = whitening(covariance(residual(at)[1]))
        found = _descend(partial(_whitened, residual, white), at, low, high)
        if found is not None and (best is None or found[0] < best[0]):
            best = found
    if best is None:
        return None
    at = best[1]
    left, moved = residual(at)
    white = whitening(covariance(moved))
    slope = -_slopes(lambda p: residual(p)[0], at, low, high)
    influence = np.linalg.pinv(white @ slope) @ white
    spread = np.linalg.pinv((white @ slope).T @ (white @ slope))
    shift = (moved - moved.mean(axis=0)) @ influence.T
    projected = moved - shift @ slope.T
    # What the fit leaves has that many degrees of freedom less.
    chi_square = hotelling(left, projected)
    return Fit(
        tuple(names), at, np.sqrt(np.diagonal(spread)), chi_square, influence, slope, components
    )


def _most_promising(
    residual: Callable[[Array], tuple[Array, Array]], starts: list[Array]
) -> list[Array]:
    """The starts with the least sum of squares: from the others the way is only longer."""
    if len(starts) <= _TRIED:
        return starts
    sizes = []
    for at in starts:
        left, moved = residual(at)
        white = whitening(covariance(moved)) @ left
        sizes.append(float(white @ white))
    return [starts[k] for k in np.argsort(sizes)[:_TRIED]]


def _whitened(residual: Callable[[Array], tuple[Array, Array]], white: Array, at: Array) -> Array:
    return np.asarray(white @ residual(at)[0])


def _descend(
    residual: Callable[[Array], Array], at: Array, low: Array, high: Array
) -> tuple[float, Array] | None:
    """Gauss-Newton with halved steps: the sum of squares and where it is."""
    left = residual(at)
    size = float(left @ left)
    for _ in range(_ROUNDS):
        slope = _ahead(residual, at, left, high)
        if not np.all(np.isfinite(slope)):
            return None
        step = -np.linalg.lstsq(slope, left, rcond=None)[0]
        for _ in range(12):
            new = np.clip(at + step, low, high)
            tried = residual(new)
            tried_size = float(tried @ tried)
            if tried_size < size:
                break
            step = step / 4
        else:
            break
        gain, at, left, size = size - tried_size, new, tried, tried_size
        if gain < 1e-3:
            break
    return (size, at) if np.isfinite(size) else None


def _ahead(residual: Callable[[Array], Array], at: Array, left: Array, high: Array) -> Array:
    """Derivatives (p, k) from one more point for each parameter: good enough to descend."""
    out = []
    for k in range(at.size):
        moved = at.copy()
        moved[k] += _STEP if at[k] + _STEP <= high[k] else -_STEP
        out.append((residual(moved) - left) / (moved[k] - at[k]))
    return np.stack(out, axis=1)


def _slopes(residual: Callable[[Array], Array], at: Array, low: Array, high: Array) -> Array:
    """Derivatives (p, k), centred where the limits leave room."""
    out = []
    for k in range(at.size):
        up, down = at.copy(), at.copy()
        up[k] = min(at[k] + _STEP, high[k])
        down[k] = max(at[k] - _STEP, low[k])
        out.append((residual(up) - residual(down)) / (up[k] - down[k]))
    return np.stack(out, axis=1)
