"""Which media the scatterers may be."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinetics.collision.medium import HIGHEST_DENSITY, LEAST_RESTITUTION
from kinetics.crosscheck.compare.observables import Array
from kinetics.crosscheck.compare.point import Point
from kinetics.crosscheck.data.sample import Sample

#: Every medium of which there is a theory. Overlapping disks, which differ from hard ones by a
#: twentieth of the density, are not tried unasked.
MEDIA = ("dilute", "hard disks", "overlapping disks")


def media_of(sample: Sample, scatterers: str, point: Point | None = None) -> list[str]:
    """Return the media that the scatterers may be.

    Parameters
    ----------
    sample : the data
    scatterers : one medium; "auto" for dilute scatterers and hard disks, "every" for all
    point : for which there must be a theory; None where it is fitted
    """
    if scatterers not in ("auto", "every"):
        return [scatterers]
    if not sample.law.smooth_disks or sample.free or not _has_dense_theory(sample, point):
        return ["dilute"]
    if scatterers == "every":
        return list(MEDIA)
    return ["dilute", "hard disks"]


def _has_dense_theory(sample: Sample, point: Point | None) -> bool:
    if point is None:
        return True
    density = sample.law.free_path(point.path)
    return density <= HIGHEST_DENSITY and point.restitution >= LEAST_RESTITUTION


def across_media(coordinates: Sequence[Array], covariances: Sequence[Array]) -> tuple[Array, Array]:
    """Return fitted numbers and their covariance that hold in each of several media.

    Data that do not tell media apart favour none: the numbers are the means over the media, and
    their covariance is the mean one with twice the sum of squares of the numbers about these means.
    Of two media at a distance D that adds D^2: an error reaches both of them.

    Parameters
    ----------
    coordinates : in each medium, shape (n_free,)
    covariances : in each medium, shape (n_free, n_free)
    """
    middle = np.mean(coordinates, axis=0)
    deviations = np.asarray(coordinates) - middle
    covariance = np.mean(covariances, axis=0) + 2.0 * deviations.T @ deviations
    return np.asarray(middle), np.asarray(covariance)
