"""What is measured of a sample, as a flat list of components: begin with `Measured`.

A component is an average at a time, or the mean square displacement between two frames. All arrays
of components are flat, (n_components,), in the order of `Layout`: one average after another, each
at all times of the sample, then the pairs of frames.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.compare.observables import (
    BETWEEN_FRAMES,
    OBSERVABLES,
    Array,
    shaped_difference,
)
from kinetics.crosscheck.data.sample import FramePairs, Law, N, Sample

Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

#: Column of the sums over pairs of frames: the number of tracers.
PAIR_N = 0
#: The sum of |dr|^2.
PAIR_R2 = 1


@dataclass(frozen=True, eq=False)
class Layout:
    """Which average, and of which times, each component is.

    Parameters
    ----------
    names : of the averages over time, in the order of `OBSERVABLES`
    times : of the sample, in d/U, shape (n_times,)
    law : what the system has
    pairs : of frames, or None
    presence : when tracers of the data are there, shape (n, n_times); None if always
    """

    names: tuple[str, ...]
    times: Array
    law: Law
    pairs: FramePairs | None = None
    presence: Mask | None = None

    @property
    def _frames(self) -> tuple[Indices, Indices]:
        """The indices of the earlier and the later frames of pairs; empty without pairs."""
        if self.pairs is None:
            return np.empty(0, np.int64), np.empty(0, np.int64)
        return self.pairs.earlier, self.pairs.later

    @cached_property
    def observable(self) -> NDArray[np.str_]:
        """The name of the observable of each component."""
        over_time = np.repeat(np.array(self.names, dtype="U40"), self.times.size)
        earlier, _ = self._frames
        return np.concatenate([over_time, np.full(earlier.size, BETWEEN_FRAMES, dtype="U40")])

    @cached_property
    def time_index(self) -> Indices:
        """The index of the time of each component, of the later frame of a pair."""
        over_time = np.tile(np.arange(self.times.size), len(self.names))
        _, later = self._frames
        return np.concatenate([over_time, later]).astype(np.int64)

    @cached_property
    def earlier_index(self) -> Indices:
        """The index of the earlier frame of a pair; 0 for averages over time."""
        over_time = np.zeros(self.times.size * len(self.names), np.int64)
        earlier, _ = self._frames
        return np.concatenate([over_time, earlier]).astype(np.int64)

    @cached_property
    def time(self) -> Array:
        """The time of each component in d/U."""
        return np.asarray(self.times[self.time_index])

    @property
    def size(self) -> int:
        """The number of components."""
        return int(self.time_index.size)

    @property
    def all_names(self) -> tuple[str, ...]:
        """The observables that have components."""
        if self.pairs is None:
            return self.names
        return *self.names, BETWEEN_FRAMES

    def is_same_as(self, other: Layout) -> bool:
        """Return whether the components are those of another layout, in the same order."""
        return self.names == other.names and np.array_equal(self.times, other.times)

    def is_of(self, *names: str) -> Mask:
        """Return which components are of these observables."""
        return np.isin(self.observable, names)

    def indices_of(self, name: str) -> Indices:
        """Return the components of an observable, in the order of time."""
        return np.flatnonzero(self.observable == name)

    def measure(self, sums: Array, pair_sums: Array | None) -> Array:
        """Return the components of sums over tracers.

        Parameters
        ----------
        sums : as those of a `Sample`, summed over tracers, shape (..., n_times, n_sums)
        pair_sums : as those of `FramePairs`, shape (..., n_pairs, n_sums); None without pairs

        Returns
        -------
        array of shape (..., n_components)
        """
        parts = []
        with np.errstate(invalid="ignore", divide="ignore"):
            means = np.moveaxis(sums / sums[..., N, None], -1, 0)
            for name in self.names:
                measure = OBSERVABLES[name].measure
                assert measure is not None
                parts.append(measure(means, self.law))
            if pair_sums is not None:
                parts.append(pair_sums[..., PAIR_R2] / pair_sums[..., PAIR_N])
        return np.concatenate(parts, axis=-1)

    def shaped(self, theory: Array, difference: Array) -> Array:
        """Return differences (..., n_components) as `observables.shaped_difference`."""
        shaped = np.array(difference, dtype=float)
        for name in self.all_names:
            row = OBSERVABLES[name]
            chosen = self.observable == name
            shaped[..., chosen] = shaped_difference(
                row.shape, theory[chosen], difference[..., chosen], row.offset
            )
        return shaped

    def sizes(self, theory: Array) -> Array:
        """Return what relative differences are relative to: |theory|, and 1 + a2 for a2.

        Of a mean along x, which may be near 0, it is the largest at any time.
        """
        sizes = np.abs(theory)
        for name in self.all_names:
            chosen = self.observable == name
            sizes[chosen] = np.abs(theory[chosen] + OBSERVABLES[name].offset)
            if name in ("drift", "mean_displacement"):
                sizes[chosen] = np.nanmax(sizes[chosen], initial=0.0)
        return np.where(sizes > 0.0, sizes, np.inf)


@dataclass(frozen=True, eq=False)
class Measured:
    """The averages of a sample, with each group left out in turn.

    Parameters
    ----------
    sample : the data
    layout : what each component is
    exchanged : which components of vectors are exchanged, in words; empty if none
    """

    sample: Sample
    layout: Layout
    exchanged: str = ""

    @classmethod
    def of(cls, sample: Sample, names: Sequence[str]) -> Measured:
        """Measure averages over time, and all pairs of frames that the sample has."""
        return cls(
            sample, Layout(tuple(names), sample.times, sample.law, sample.pairs, sample.presence)
        )

    @cached_property
    def values(self) -> Array:
        """The averages of all tracers, shape (n_components,)."""
        pairs = self.sample.pairs
        pair_sums = None if pairs is None else pairs.sums.sum(axis=0)
        return self.layout.measure(self.sample.sums.sum(axis=0), pair_sums)

    @cached_property
    def replicates(self) -> Array:
        """The averages with each group left out in turn, shape (n_groups, n_components)."""
        pairs = self.sample.pairs
        sums = self.sample.sums
        pair_sums = None if pairs is None else pairs.sums.sum(axis=0) - pairs.sums
        return self.layout.measure(sums.sum(axis=0) - sums, pair_sums)

    @cached_property
    def counts(self) -> Indices:
        """The tracers in each component, shape (n_components,)."""
        counts = self.sample.samples[self.layout.time_index]
        if self.sample.pairs is not None:
            of_pairs = np.rint(self.sample.pairs.sums[:, :, PAIR_N].sum(axis=0))
            counts[self.layout.is_of(BETWEEN_FRAMES)] = of_pairs
        return counts

    @property
    def n_tracers(self) -> int:
        """The number of tracers, at the time that has most."""
        return int(self.counts.max(initial=0))

    @cached_property
    def shares_without_gaps_of_pool(self) -> Array:
        """The share of the tracers that are in each component, shape (n_components,).

        It is 1 where simulated tracers have the gaps of the data themselves (`Layout.presence`).
        """
        if self.layout.presence is not None:
            return np.ones(self.layout.size)
        return np.asarray(self.counts / max(self.n_tracers, 1))

    @property
    def has_velocities(self) -> bool:
        """Whether velocities were measured."""
        return self.sample.has_velocities
