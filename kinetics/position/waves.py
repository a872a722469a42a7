"""What the backward equation gives for some wave numbers: a_m as a function of X = ln(v t/l)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetics.numerics import FloatArray
from kinetics.numerics.panels import PanelRule


@dataclass(frozen=True)
class Waves:
    """a_m for some wave numbers, in space b_m of `directions`.

    Attributes
    ----------
    wave_numbers : K = k l, shape (n_k,)
    rule : the collocation
    start : X where the panels begin
    values : a_m at the nodes, shape (n_panels, n_kept, nodes, n_k); m up to n_kept - 1
    coefficients : of the power series in T below the panels, shape (n_terms, n_kept, n_k)
    ended : whether everything is below the tolerance at the last panel, and 0 from there on
    error_estimate : absolute, of a_0 and of those kept
    panel_errors : the same on each panel, root of the sum of the squares of all that are kept (m
        and -m), shape (n_panels,)
    systems : how many systems of rule.nodes - 1 equations were solved
    """

    wave_numbers: FloatArray
    rule: PanelRule
    start: float
    values: FloatArray
    coefficients: FloatArray
    ended: bool
    error_estimate: float
    panel_errors: FloatArray
    systems: int

    def __call__(self, x: FloatArray, m: int = 0) -> FloatArray:
        """a_m at X = x (n_x,), -inf allowed: shape (n_x, n_k)."""
        level = (x - self.start) / self.rule.width
        out = np.empty((x.size, self.wave_numbers.size))
        low = level < 0.0
        if low.any():
            out[low] = series_sum(self.coefficients[:, m], np.exp(x[low]))
        count = self.values.shape[0]
        inside = level[~low]
        index = np.minimum(inside.astype(int), count - 1)
        rows = self.rule.rows(np.minimum(inside - index, 1.0))
        found = np.einsum("ij,ijk->ik", rows, self.values[index, m])
        beyond = inside > count
        if beyond.any():
            found[beyond] = self._late(inside[beyond] - count, m)
        out[~low] = found
        return out

    def error_at(self, x: FloatArray) -> FloatArray:
        """The error at X = x (n_x,), from `panel_errors`: shape (n_x,)."""
        level = np.floor((x - self.start) / self.rule.width)
        beyond = 0.0 if self.ended else self.panel_errors[-1]
        padded = np.concatenate([[0.0], self.panel_errors, [beyond]])
        return padded[np.clip(level + 1.0, 0.0, padded.size - 1.0).astype(int)]

    def _late(self, panels: FloatArray, m: int) -> FloatArray:
        """Beyond the last panel: 0, or the power of T with which the last panel falls."""
        if self.ended:
            return np.zeros((panels.size, self.wave_numbers.size))
        last = self.values[-1, m, -1]
        with np.errstate(divide="ignore", invalid="ignore", under="ignore"):
            fall = np.where(last != 0.0, np.abs(last / self.values[-1, m, 0]), 0.0)
            return np.asarray(last * np.minimum(1.0, fall) ** panels[:, None])


def series_sum(coefficients: FloatArray, path: FloatArray) -> FloatArray:
    """The power series with these coefficients (n_terms, ...) at T = path (n,): (n, ...)."""
    with np.errstate(under="ignore"):
        powers = path[:, None] ** np.arange(coefficients.shape[0])
    return np.tensordot(powers, coefficients, axes=1)


def together(last: FloatArray) -> FloatArray:
    """Root of the sum of squares over all harmonics, (n_panels, n_kept, n_k): (n_panels,)."""
    each = last.max(axis=2)
    each[:, 1:] *= 2.0
    return np.asarray(np.sqrt((each**2).sum(axis=1)))


def carried(errors: FloatArray, sizes: FloatArray) -> FloatArray:
    """Errors of each panel with those of panels below it, which fall as the solution does.

    errors, sizes : of each panel by itself, and its largest value, shape (n_panels,) each
    """
    out, before = np.empty_like(errors), 0.0
    for j, (error, size) in enumerate(zip(errors, sizes, strict=True)):
        fall = min(1.0, size / sizes[j - 1]) if j and sizes[j - 1] > 0.0 else 1.0
        before = max(error, before * fall)
        out[j] = before
    return out
