r"""The axis x - i angle of ln v, on which the gain of the collisions raises less rounding.

v is the speed, l the mean free path, e the restitution. Near e = 1 the gain (`gain`) falls steeply
with the wave number k, and dividing by it raises the rounding of the modes. On the axis x - i angle
the mode k > 0 of everything is larger by e^(k angle), which makes up for that. The price is exp(-v
t/l), which falls as cos(angle) there, and a periodic window at both ends of which the state must be
brought to zero. Begin with :func:`choose_angle`.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from kinetics.numerics import ROUNDING, ComplexArray, FloatArray
from kinetics.numerics.log_grid import LogGrid

#: Angles that are tried. Near pi/2 exp(-v t/l) falls as cos(angle): there they are closer. Chosen.
ANGLES = np.array([*np.arange(0.0, 1.4, 0.05).tolist(), 1.43, 1.46, 1.48, 1.5, 1.52, 1.54])
#: Fraction of the tolerance for each of many small parts of the error, such as rounding. Chosen:
#: some ten of them are next to nothing. Measured as in `spectral_grid`: f moves by 3e-11 at half
#: and at twice, where the estimates are 0.5 to 2.5 times as large.
SHARE_OF_SMALL_ERROR = 0.005
#: A Fourier mode of a state below this fraction of its largest one is rounding, and is left out.
#: Chosen: at half and at twice f moves by 3e-8 of its largest at most (rtol 1e-8,
#: speeds from 1e-3 U).
NEGLIGIBLE_MODE = 24.0 * ROUNDING
#: Width in ln v over which a state on a turned axis is brought to zero at both ends of the window.
#: Chosen: at half and at twice f moves by 3e-11.
TAPER_WIDTH = 3.0
#: Largest argument of the error function that does it: it leaves erfc(4)/2 = 8e-9 at the ends.
#: At half and at twice f moves by 1e-11.
TAPER_STEEPNESS = 4.0
#: What the choice of the angle takes it to leave there: 8e-9 with a margin, as f is g over v.
#: Chosen: at half and at twice nothing moves (e = 0, 0.4 and 0.95).
TAPER_REMAINDER = 1e-4
#: Margin of the rounding that is guessed for the choice of the angle. Chosen: at half and at twice
#: f moves by 3e-11.
ROUNDING_SAFETY = 4.0
#: Distance of the wave numbers at which the gain, a smooth function, is looked at for its size.
#: Chosen: at half and at twice nothing moves (e = 0, 0.4 and 0.95).
SAMPLE_DISTANCE = 4.0
#: Least number of such wave numbers. Chosen: at half and at twice f moves by 2e-12.
MIN_SAMPLES = 64
#: ln of the size of a mode that is zero: 1e-300, close to the smallest number.
LOG_ZERO = -690.0
#: Stands for 0 in a logarithm: close to the smallest number.
TINY = 1e-300


def significant_modes(rows: FloatArray) -> ComplexArray:
    """Return the Fourier modes of a state, rows (n, nodes), with 0 for those that are rounding."""
    modes = np.fft.rfft(rows)
    size = np.abs(modes).max(axis=0)
    negligible = np.nonzero(size < NEGLIGIBLE_MODE * size.max())[0]
    if negligible.size:
        # all from the first one on: the gain would amplify the rounding of higher modes
        modes[:, negligible[0] :] = 0.0
    return np.asarray(modes)


def taper(grid: LogGrid) -> FloatArray:
    """Return factors at the nodes that fall to zero at the lower end of the window, (nodes,).

    In reverse order they fall to zero at the upper end.
    """
    from scipy.special import erfc

    argument = TAPER_STEEPNESS * (1.0 - 2.0 / TAPER_WIDTH * (grid.x - grid.x[0]))
    return np.asarray(0.5 * erfc(argument))


def choose_angle(
    gain_at: Callable[[FloatArray], ComplexArray],
    grid: LogGrid,
    rows: FloatArray,
    spacing: float,
    rtol: float,
) -> tuple[float, float]:
    """Choose the angle of the axis for a state.

    It is the smallest that leaves next to nothing of rtol to rounding, or the best one: what
    rounding leaves of f at the lowest speeds is guessed, with a margin, for the choice only.

    Parameters
    ----------
    gain_at : maps wave numbers, equidistant from 0 on, to ln of the gain
    grid : nodes that resolve the state
    rows : the state there, its real and imaginary part, shape (n_rows, nodes)
    spacing : spacing of the nodes that are to be used
    rtol : accuracy that is aimed at

    Returns
    -------
    The angle, and ln of the largest 1/(G e^(k angle)).
    """
    nyquist = math.pi / spacing
    n_samples = max(MIN_SAMPLES, math.ceil(nyquist / SAMPLE_DISTANCE)) + 1
    k = np.linspace(0.0, nyquist, n_samples)
    mode_size = np.abs(significant_modes(rows)).max(axis=0) / grid.nodes
    log_mode_size = np.log(np.maximum(mode_size, TINY))
    log_size = np.interp(k, grid.wave_numbers, log_mode_size, right=LOG_ZERO)
    # ln of G e^(k angle), (n_angles, n_samples)
    log_raised_gain = gain_at(k).real + np.multiply.outer(ANGLES, k)
    log_largest_inverse = -log_raised_gain.min(axis=1)
    # the rounding of the largest mode of u, divided by the smallest gain
    log_largest_mode = (log_size + log_raised_gain).max(axis=1)
    log_rounding = math.log(ROUNDING_SAFETY * NEGLIGIBLE_MODE)
    log_error = log_largest_inverse + log_largest_mode + log_rounding
    # the rounding of the highest modes that are kept fills the window up to its ends
    log_gain_of_kept_modes = log_raised_gain[:, log_size > LOG_ZERO].max(axis=1)
    log_size_at_ends = log_gain_of_kept_modes + log_size.max()
    log_error_of_ends = log_size_at_ends + math.log(NEGLIGIBLE_MODE * TAPER_REMAINDER)
    log_error = np.maximum(log_error, log_error_of_ends)
    log_tolerance = math.log(SHARE_OF_SMALL_ERROR * rtol)
    is_accurate = log_error < max(float(log_error.min()), log_tolerance)
    # no angle is below the minimum itself: then it is the best one
    index = int(is_accurate.argmax()) if is_accurate.any() else int(log_error.argmin())
    return float(ANGLES[index]), float(log_largest_inverse[index])
