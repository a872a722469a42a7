"""Which media the scatterers may be."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from kinetics.collision.medium import HIGHEST_DENSITY, LEAST_RESTITUTION
from kinetics.crosscheck.compare.observables import Array
from kinetics.crosscheck.compare.parameters import LIMITS
from kinetics.crosscheck.compare.point import Point
from kinetics.crosscheck.data.sample import Law

#: Every medium of which there is a theory. Overlapping disks, which differ from hard ones by a
#: twentieth of the density, are not tried unasked.
MEDIA = ("dilute", "hard disks", "overlapping disks")


def media_of(
    scatterers: str,
    law: Law,
    path: float | None,
    restitution: float | None,
    are_dilute: bool = False,
) -> list[str]:
    """Return the media that the scatterers may be.

    Parameters
    ----------
    scatterers : one medium; "auto" for dilute scatterers and hard disks, "every" for all
    law : of the system: there is a theory of dense media for smooth disks alone
    path : mean free path in d, at which there must be a theory; None where it is fitted
    restitution : likewise
    are_dilute : whether tracers are known to meet no scatterer twice
    """
    if scatterers not in ("auto", "every"):
        return [scatterers]
    has_theory = law.smooth_disks and not are_dilute
    if has_theory and path is not None:
        has_theory = law.free_path(path) <= HIGHEST_DENSITY
    if has_theory and restitution is not None:
        has_theory = restitution >= LEAST_RESTITUTION
    if not has_theory:
        return ["dilute"]
    if scatterers == "every":
        return list(MEDIA)
    return ["dilute", "hard disks"]


class FitInMedium(Protocol):
    """A fit in one medium; all media have the same free numbers."""

    @property
    def point(self) -> Point:
        """The theory with the fitted numbers."""

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the fitted numbers."""

    @property
    def coordinates(self) -> Array:
        """The fitted numbers, or their logarithms where these are fitted, shape (n_free,)."""

    @property
    def covariance(self) -> Array:
        """The covariance of the coordinates, shape (n_free, n_free)."""


def across_media(best: FitInMedium, others: Sequence[FitInMedium]) -> tuple[Point, Array, Array]:
    """Return the best fit's point with numbers that hold in all media, coordinates and covariance.

    Data that do not tell media apart favour none: the numbers are the means over the media, and
    their covariance is the mean one with twice the sum of squares of the numbers about these means.
    Of two media at a distance D that adds D^2: an error reaches both of them.

    Parameters
    ----------
    best : the likeliest fit
    others : those in media that the data do not exclude
    """
    fits = [best, *others]
    coordinates = np.array([fitted.coordinates for fitted in fits])
    middle = np.mean(coordinates, axis=0)
    deviations = coordinates - middle
    own = np.mean([fitted.covariance for fitted in fits], axis=0)
    covariance = own + 2.0 * deviations.T @ deviations
    values: dict[str, float] = {}
    for name, coordinate in zip(best.names, middle.tolist(), strict=True):
        values[name] = coordinate
        if name not in LIMITS:
            values[name] = math.exp(coordinate)
    return best.point.with_values(**values), middle, np.asarray(covariance)
