"""The kinetic equation's G(R) at the last time, as histograms and logarithms need it."""

import math

import numpy as np

from kinetics.crosscheck.report.case import Array, Case
from kinetics.crosscheck.report.histograms import BANDS, band_exponent

SURE = 20.0
"""Multiples of its tolerance above which G(R) is known well enough for its logarithm."""


def sure_density(case: Case, r: Array) -> tuple[Array, Array]:
    """Those of the R at which the last G(R) is well above its error, and G(R) there."""
    density = case.position.scaled_position_density(r)[-1]
    known = density > SURE * case.position.rtol
    return r[known], density[known]


def bin_density(case: Case, edges: Array) -> Array:
    """G(R) of the kinetic equation at the last time, averaged over each bin of R."""
    root = math.sqrt(float(case.position.msd[-1]))
    return np.asarray(case.position.position_fraction(edges * root)[-1] / np.diff(edges))


def bands_of(case: Case) -> Array:
    """The kinetic equation's `band_exponent`, from the shares that a histogram would have."""
    root = math.sqrt(float(case.position.msd[-1]))
    return band_exponent(case.position.position_fraction(BANDS * root)[-1])
