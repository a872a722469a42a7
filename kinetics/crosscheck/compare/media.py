"""Which media the scatterers may be."""

from __future__ import annotations

from kinetics.collision.medium import HIGHEST_DENSITY, LEAST_RESTITUTION
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
