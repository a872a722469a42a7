"""Speed densities that functions give, as weighted points on the axis of ln v.

The function is scanned from the slowest to the fastest speed in doubles (`density_scan`), and
integrated where it matters (`halved_panels`). Begin with `function_points`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from kinetics.errors import ERRORS_OF_FUNCTIONS, InputError
from kinetics.numerics import LARGEST_LOG, FloatArray, NumberArray
from kinetics.states.density_scan import SCAN_PANEL, DensityScan
from kinetics.states.halved_panels import integrate_by_halving
from kinetics.states.points import without_zeros
from kinetics.states.state import LogMeasure

#: A user's function: maps speeds in U, shape (n,), to values of that shape.
UserFunction = Callable[[FloatArray], ArrayLike]

#: Speed in U beyond which a density may be NaN: no tracer is as fast. None is as slow as the
#: reciprocal. Chosen: powers of v overflow there in formulas.
FASTEST_TRACER = 1e30
#: The error of a panel over rtol, as several panels add up. Chosen; at half and at twice no average
#: of a smooth density moves (rtol 1e-8).
TOLERANCE_OF_PANEL = 0.1
#: Least rtol that is aimed at. Chosen: below is rounding.
MIN_RTOL = 1e-15


def evaluate_density(density: UserFunction, v: FloatArray) -> NumberArray:
    """Call a user's density on an array of speeds.

    NaN counts as 0 beyond FASTEST_TRACER and below its reciprocal.

    Raises
    ------
    InputError : the answer cannot be used
    """
    try:
        with np.errstate(all="ignore"):
            f = np.asarray(density(v))
        f = f.astype(complex if f.dtype.kind == "c" else float)
        if f.shape != v.shape:
            raise ValueError(f"it returned shape {f.shape} for speeds of shape {v.shape}")
    except ERRORS_OF_FUNCTIONS as error:
        allowed = "it must map an array of speeds to one of densities"
        raise InputError(
            f"initial: the density could not be evaluated ({error}); {allowed}"
        ) from None
    is_empty = (v > FASTEST_TRACER) | (v < 1.0 / FASTEST_TRACER)
    f = np.where(np.isnan(f) & is_empty, 0.0, f)
    if np.any(np.isnan(f)):
        speed = f"{v[np.isnan(f)][0]:g}"
        raise InputError(f"initial: the density is NaN at v = {speed} U; it must be a number")
    return f


def function_points(
    density: UserFunction,
    rtol: float,
    lowest: float,
    highest: float,
    *,
    has_narrow_peaks: bool = False,
) -> LogMeasure | None:
    """Return quadrature points of a speed density, or a harmonic of one, that a function gives.

    Averages of v^p are right to about rtol for p from ``lowest`` to ``highest``, and for p = 0 and
    2: panels in ln v reach as far as these powers notice, and are halved until each of the powers
    is resolved. What cannot be resolved is in the ``error`` of the result. Peaks narrower than
    0.1 % are looked for if ``has_narrow_peaks``, which takes a hundred times as many evaluations.

    Returns
    -------
    The points; None for a function that is zero.

    Raises
    ------
    InputError
        where the function is NaN, has no finite integral or no second moment.
    """

    def per_log_speed(x: FloatArray) -> NumberArray:
        v = np.exp(x)
        return np.asarray(evaluate_density(density, v) * v)

    scan = DensityScan.of(per_log_speed, has_narrow_peaks)
    if scan.is_zero:
        return None
    powers = sorted({2.0, max(highest, 2.0), 0.0, min(lowest, 0.0)}, reverse=True)
    log_averages = scan.log_averages(powers)
    if scan.has_power_law_tail:
        scan.refuse_divergent(powers, log_averages)

    def importance(x: FloatArray) -> FloatArray:
        """Return the largest relative change of an average for a change of the mass at ln v = x."""
        exponents = []
        for power, log_average in zip(powers, log_averages, strict=True):
            exponents.append(power * x - log_average)
        return np.asarray(np.exp(np.minimum(np.max(exponents, axis=0), LARGEST_LOG)))

    panels = scan.panels_that_count(powers, log_averages, rtol)
    tolerance = TOLERANCE_OF_PANEL * max(rtol, MIN_RTOL)
    integral = integrate_by_halving(per_log_speed, panels, importance, tolerance, SCAN_PANEL)
    points = without_zeros(integral.x, integral.weight)
    return LogMeasure(points.x, points.weight, integral.error)
