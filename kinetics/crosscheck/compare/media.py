"""Which media the scatterers may be."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol, TypeVar

import numpy as np

from kinetics.collision.medium import HIGHEST_DENSITY, LEAST_RESTITUTION
from kinetics.crosscheck.compare.observables import Array
from kinetics.crosscheck.compare.parameters import LIMITS
from kinetics.crosscheck.compare.point import Point
from kinetics.crosscheck.data.sample import Law

#: Every medium of which there is a theory. Overlapping disks, which differ from hard ones by a
#: twentieth of the density, are not tried unasked.
MEDIA = ("dilute", "hard disks", "overlapping disks")
#: By how much the criterion of a medium may be above the best one before the data exclude it.
#: Derived: 2 ln 20, odds of 20 to 1, as of causes (`causes.NEAR_BEST`). Why 20 is not recorded.
EXCLUDED_ABOVE = 6.0
#: The same of positions alone. Chosen: 4 sigma of one number, squared, as media are often in the
#: wrong order. Of 60 sets of 600 to 1000 tracks among hard disks of 0.04 d^-2 the criterion of hard
#: disks was above that of dilute scatterers in 9, by 13.5 at most.
EXCLUDED_ABOVE_OF_POSITIONS = 16.0


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
        density = law.free_path(path)  # it gives n of l as well: n l is a constant
        has_theory = density <= HIGHEST_DENSITY
    if has_theory and restitution is not None:
        has_theory = restitution >= LEAST_RESTITUTION
    if not has_theory:
        return ["dilute"]
    if scatterers == "every":
        return list(MEDIA)
    return ["dilute", "hard disks"]


FitInMediumType = TypeVar("FitInMediumType", bound="FitInMedium")


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

    @property
    def criterion(self) -> float:
        """By how much the data are unlikely: -2 ln likelihood and 2 for each fitted number."""


def media_not_excluded(
    best: FitInMediumType, fits: Sequence[FitInMediumType], are_positions: bool = False
) -> list[FitInMediumType]:
    """Return the fits in other media that the data, perhaps positions alone, do not exclude."""
    limit = best.criterion + (EXCLUDED_ABOVE_OF_POSITIONS if are_positions else EXCLUDED_ABOVE)
    medium = best.point.scatterers
    return [fit for fit in fits if fit.point.scatterers != medium and fit.criterion <= limit]


def across_media(best: FitInMedium, others: Sequence[FitInMedium]) -> tuple[Point, Array, Array]:
    """Return the best fit's point with numbers that hold in all media, coordinates and covariance.

    The numbers are the means over the media, weighted by their likelihoods. An error reaches all
    media, however unlikely: the covariance is the mean one with twice the sum of squares of the
    numbers about their plain means, which of two media at a distance D is D^2.

    Parameters
    ----------
    best : the likeliest fit of those that agree with the data
    others : those in media that the data do not exclude
    """
    if not others:
        return best.point, best.coordinates, best.covariance
    fits = [best, *others]
    coordinates = np.array([fitted.coordinates for fitted in fits])
    # a medium with a lesser criterion whose fit does not agree with the data is not the best: it
    # counts no more than that
    excess = np.array([max(fitted.criterion - best.criterion, 0.0) for fitted in fits])
    likelihoods = np.exp(-0.5 * excess)
    weights = likelihoods / likelihoods.sum()
    middle = weights @ coordinates
    deviations = coordinates - coordinates.mean(axis=0)
    own = sum(weight * fit.covariance for weight, fit in zip(weights, fits, strict=True))
    covariance = own + 2.0 * deviations.T @ deviations
    values: dict[str, float] = {}
    for name, coordinate in zip(best.names, middle.tolist(), strict=True):
        values[name] = coordinate
        if name not in LIMITS:  # a number without limits is fitted as its logarithm
            values[name] = math.exp(coordinate)
    return best.point.with_values(**values), middle, np.asarray(covariance)
