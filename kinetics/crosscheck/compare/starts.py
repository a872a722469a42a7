"""The start of the tracers: as specified, or as the velocities at time 0 show it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.special import chdtrc

from kinetics.crosscheck.compare.point import BEAM, SampledStart
from kinetics.crosscheck.data.sample import V2, V4, VX, X2, Law, N, Sample
from kinetics.crosscheck.words import numeral
from kinetics.errors import InputError
from kinetics.validation import one_of, refuse

#: Names that a start may have, and what they mean.
STARTS = {
    "auto": "auto",
    "gaussian": "gaussian",
    "monoenergetic": "monoenergetic",
    "one speed": "monoenergetic",
    "beam": "beam",
    "data": "data",
    "first frames": "data",
    "rest": "rest",
}
#: Relative difference of squares of speeds that are one speed.
SAME_SQUARE = 1e-6
#: The p-value from which on speeds at time 0 are taken for those of a Gaussian with U = 1.
MIN_P_VALUE = 1e-3
#: |ln| of the U of a sample's own speeds, over 1, from which on a unit may have been forgotten.
FORGOTTEN_UNIT = 0.2


def start_of(sample: Sample, initial: str) -> tuple[Sample, Any]:
    """Return the start as a Scene has it, and the sample with what is to be said of it.

    Parameters
    ----------
    initial : one of `STARTS`; "auto" for what the data say, or their velocities at time 0 show
    """
    name = STARTS[one_of("initial", initial, tuple(STARTS))]
    if name == "auto":
        name = sample.told.get("initial", "auto")
    law = sample.law
    gains_energy = bool(law.field or law.bath_speed or law.heating)
    if name == "rest" and not gains_energy:
        refuse("initial", initial, "without a field, a bath or heating nothing would move")
    if name == "beam":
        return sample, BEAM
    if name not in ("auto", "data"):
        return sample, name
    if sample.start is None:
        if name == "data":
            refuse("initial", initial, "there are no velocities at time 0")
        return sample, "gaussian"
    if sample.start.squares.size == 0:
        if not gains_energy:
            raise InputError("data: every speed at time 0 is zero; nothing will move")
        return sample, "rest"
    if name == "auto":
        named = _named_start(sample)
        if named is not None:
            return sample, named
    if law.field:
        refuse("initial", initial, "in a field the start must be rest, gaussian or monoenergetic")
    if name == "auto":
        sample = _with_remark_on_unit(sample)
    assert sample.start is not None
    return sample, SampledStart(sample.start)


def _named_start(sample: Sample) -> Any:
    """Return the named start that the velocities at time 0 allow; None if there is none."""
    assert sample.start is not None
    squares = sample.start.squares
    if np.all(np.abs(squares - 1.0) < SAME_SQUARE):
        sums = sample.sums[:, 0].sum(axis=0)
        has_axes = sums.size > X2 and not sample.law.field
        is_along_x = has_axes and sums[VX] > (1.0 - SAME_SQUARE) * sums[N]
        return BEAM if is_along_x else "monoenergetic"
    if (
        squares.size > 1
        and gaussian_p_value(sample.sums[:, 0].sum(axis=0), sample.law) >= MIN_P_VALUE
    ):
        return "gaussian"
    return None


def gaussian_p_value(sums: np.ndarray, law: Law) -> float:
    """Return the p-value of v^2 and v^4 of independent tracers with Gaussian velocities, U = 1.

    With x = v^2/d and d dimensions, x is gamma-distributed: its moments are known to the order 4.
    """
    d = law.dimension
    half = d / 2.0
    moments = [1.0]
    for order in range(4):
        moments.append(moments[-1] * (half + order) / half)
    covariance = np.empty((2, 2))
    for i, p in enumerate((1, 2)):
        for j, q in enumerate((1, 2)):
            covariance[i, j] = moments[p + q] / (moments[p] * moments[q]) - 1.0
    n = float(sums[N])
    relative = np.array([sums[V2] / n / d - 1.0, sums[V4] / n / d**2 / moments[2] - 1.0])
    statistic = n * float(relative @ np.linalg.solve(covariance, relative))
    return float(chdtrc(2.0, statistic))


def _with_remark_on_unit(sample: Sample) -> Sample:
    """Return the sample, with a remark where its speeds look like those of another unit."""
    assert sample.start is not None
    if sample.units:
        return sample
    squares = sample.start.squares
    counts = sample.start.counts
    unit = math.sqrt(float(squares @ counts) / counts.sum() / sample.law.dimension)
    if abs(math.log(unit)) <= FORGOTTEN_UNIT:
        return sample
    shown = numeral(unit, ".4g")
    remark = f"Speeds at time 0 are those of U = {shown} of the data's unit; is it --speed-unit?"
    return replace(sample, warnings=(*sample.warnings, remark))
