"""What data cannot tell of fitted numbers: begin with `unknown_directions`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinetics.crosscheck.compare.observables import Array

#: Errors of the restitution, of ln l and of ln U from which on these are not known.
UNKNOWN_FROM = {"restitution": 0.1, "path": 0.3, "speed_unit": 0.2}
#: Share of a direction from which on a number is named as a part of it.
NAMED_FROM = 0.3
#: How the numbers are named in a sentence.
NAMES = {"restitution": "e", "path": "the mean free path", "speed_unit": "U"}


def unknown_directions(names: Sequence[str], covariance: Array) -> list[tuple[str, ...]]:
    """Return the names of the numbers in each combination that data do not know.

    Those with an infinite variance are one combination; numbers that are not in `UNKNOWN_FROM` are
    not looked at.

    Parameters
    ----------
    names : of the fitted numbers
    covariance : of these, or of their logarithms, shape (n_names, n_names)
    """
    all_names = np.array(names, dtype="U20")
    is_looked_at = np.isin(all_names, list(UNKNOWN_FROM))
    is_infinite = ~np.isfinite(np.diagonal(covariance))
    directions = []
    if np.any(is_looked_at & is_infinite):
        directions.append(tuple(all_names[is_looked_at & is_infinite].tolist()))
    chosen = np.flatnonzero(is_looked_at & ~is_infinite)
    units = np.array([UNKNOWN_FROM[name] for name in all_names[chosen].tolist()])
    scaled = covariance[np.ix_(chosen, chosen)] / np.outer(units, units)
    variances, axes = np.linalg.eigh(scaled)
    for variance, axis in zip(variances.tolist(), np.abs(axes.T), strict=True):
        # a number is named where the direction is mostly its own, or leaves it unknown
        is_named = (axis > NAMED_FROM) | (variance * axis**2 > 1.0)
        if variance > 1.0:
            directions.append(tuple(all_names[chosen[is_named]].tolist()))
    return directions


def unknown_numbers(names: Sequence[str], covariance: Array) -> set[str]:
    """Return the numbers that are in such a combination, or have such an error alone."""
    unknown: set[str] = set()
    for direction in unknown_directions(names, covariance):
        unknown |= set(direction)
    for name, variance in zip(names, np.diagonal(covariance), strict=True):
        if variance > UNKNOWN_FROM.get(name, np.inf) ** 2:
            unknown.add(name)
    return unknown


def cannot_tell(names: Sequence[str], covariance: Array, data: str) -> tuple[str, ...]:
    """Return a sentence for each combination of numbers that data do not know.

    data : the data in the sentence, such as "these data"
    """
    sentences = []
    for direction in unknown_directions(names, covariance):
        verb = "is not known" if len(direction) == 1 else "cannot be told apart"
        named = " and ".join(NAMES[name] for name in direction)
        sentences.append(f"{named} {verb} by {data}.")
    return tuple(sentences)
