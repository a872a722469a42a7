"""Tracers that have not collided: a singular, ballistic part of g(r, t), known exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetics.numerics import FloatArray
from kinetics.numerics.chebyshev import FirstKind
from kinetics.numerics.gauss import panels_between
from kinetics.results import Value
from kinetics.states.state import State

_NODES = 16  # of a polynomial for a piece of the initial density
_LEFT_OUT = 1e-13  # its last coefficient relative to its largest value: rounding of its sum; and
# the share of tracers that may be faster than all pieces
_HALVINGS = 100  # of the axis towards speed 0, where a density may be a root of v
_JUMP = 2.0**-45  # width of a piece, relative to its speed, that is left for a jump
_MOST_PIECES = 4000  # where a density is rough everywhere: half a million numbers
_NONE_LEFT = 40.0  # flights of so many l without a collision: e^-40 of the tracers


@dataclass(frozen=True)
class UncollidedDensity(Value):
    """f(r/t) exp(-r/l)/t, f the density of the initial speeds; 0 for a start of sharp speeds.

    Attributes
    ----------
    mean_free_path : l, in d
    times : in d/U, shape (n_times,)
    edges : of the pieces of f, speeds in U, rising, shape (n_pieces + 1,); none for sharp speeds
    values : f at Chebyshev points of the first kind of each piece, in 1/U, shape (n_pieces, nodes)
    """

    mean_free_path: float
    times: FloatArray
    edges: FloatArray
    values: FloatArray

    @property
    def is_zero(self) -> bool:
        """Whether the start has no speed density."""
        return self.edges.size == 0

    def at(self, time: int, r: FloatArray) -> FloatArray:
        """Density in 1/d at radii r in d, shape (n_r,)."""
        out, t = np.zeros(r.shape), self.times[time]
        if self.is_zero or t == 0.0:
            return out
        with np.errstate(under="ignore", over="ignore"):
            v = r / t
            piece = np.searchsorted(self.edges, v, side="right") - 1
            # the last edge belongs to the last piece
            piece = np.where(v == self.edges[-1], self.edges.size - 2, piece)
            inside = (piece >= 0) & (piece < self.edges.size - 1)
            piece, v = piece[inside], v[inside]
            local = (v - self.edges[piece]) / (self.edges[piece + 1] - self.edges[piece])
            f = np.einsum("ij,ij->i", FirstKind(_NODES).rows(local), self.values[piece])
            # a speed density is not negative: what is below zero is rounding, at v = 0 above all
            out[inside] = np.maximum(f, 0.0) * np.exp(-r[inside] / self.mean_free_path) / t
        return out

    def within(self, time: int, r: FloatArray) -> FloatArray:
        """Share of all tracers that have not collided and are within r, shape of r (n_r,)."""
        t = self.times[time]
        if self.is_zero or t == 0.0:
            return np.zeros(r.shape)
        with np.errstate(over="ignore"):
            bounds = self.edges * t
        # exp(-r/l) turns over l: pieces no longer than that while there are tracers left
        far = min(float(bounds[-1]), _NONE_LEFT * self.mean_free_path)
        near = np.clip(r, 0.0, far)
        inner = bounds[bounds < far]
        edges = np.unique(np.concatenate([np.linspace(0.0, far, int(_NONE_LEFT) + 1), inner, near]))
        x, w = panels_between(edges, 12)
        share = (self.at(time, x) * w).reshape(edges.size - 1, -1).sum(axis=1)
        return np.interp(near, edges, np.concatenate([[0.0], np.cumsum(share)]))


def uncollided_density(
    state: State, mean_free_path: float, times: FloatArray, fastest: float
) -> UncollidedDensity:
    """The uncollided of a start: its speed density in pieces, each a polynomial to rounding.

    fastest : see :func:`fastest_speed`
    """
    profile = state.profile(0)
    if profile is None:
        return UncollidedDensity(mean_free_path, times, np.zeros(0), np.zeros((0, _NODES)))
    kinks = np.asarray(state.kinks, dtype=float)
    if kinks.size:
        top = float(kinks[-1])
    else:
        # where a function ends is not known: go on from somewhat above the fastest
        above = fastest * 2.0 ** np.arange(0.25, 20.0, 0.25)
        there = np.nonzero(np.abs(profile(above)) * above > _LEFT_OUT)[0]
        top = float(above[min(there.max(initial=-1) + 1, above.size - 1)])
    edges = np.union1d([0.0, top], kinks[(kinks >= 0.0) & (kinks <= top)])
    rule = FirstKind(_NODES)
    starts, kept = [], []
    ends = np.stack([edges[:-1], edges[1:]], axis=1)
    for halving in range(_HALVINGS + 1):
        v = ends[:, :1] + (ends[:, 1:] - ends[:, :1]) * rule.local
        f = np.asarray(profile(v.ravel()).real).reshape(v.shape)
        left_out = np.maximum(*rule.last_coefficients(f))
        done = left_out <= _LEFT_OUT * np.abs(f).max(axis=1)
        done |= ends[:, 1] - ends[:, 0] <= _JUMP * ends[:, 1]
        done |= (halving == _HALVINGS) | (ends.shape[0] > _MOST_PIECES)
        starts.append(ends[done, 0])
        kept.append(f[done])
        low, high = ends[~done].T
        middle = 0.5 * (low + high)
        ends = np.concatenate([np.stack([low, middle], axis=1), np.stack([middle, high], axis=1)])
        if ends.size == 0:
            break
    order = np.argsort(np.concatenate(starts))
    pieces = np.append(np.concatenate(starts)[order], top)
    return UncollidedDensity(mean_free_path, times, pieces, np.concatenate(kept)[order])


def fronts(state: State, mean_free_path: float, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where the uncollided of each delta peak of the speed are, and their share of all tracers.

    Shape (n_times, n_speeds) each, radii in d; n_speeds = 0 for a start with a density.
    """
    peaks = state.peaks
    if peaks is None:
        return np.zeros((times.size, 0)), np.zeros((times.size, 0))
    speed, share = peaks
    with np.errstate(over="ignore", under="ignore"):
        radius = np.outer(times, speed)
        return radius, share * np.exp(-radius / mean_free_path)


def fastest_speed(state: State, rtol: float) -> float:
    """The largest of sharp speeds; for densities, one that all but about rtol of the tracers keep
    below.
    """
    peaks = state.peaks
    if peaks is not None:
        return float(np.max(peaks[0]))
    found = state.harmonic(0, rtol)
    assert found is not None  # harmonic 0 is never zero
    return float(np.exp(found.x.max()))
