"""Rules that turn initial states into weighted points on the axis of ln v.

The solver only needs averages of smooth functions of ln v over the initial state: one point for a
monoenergetic start, the trapezoid rule for a Gaussian, panels of Gauss-Legendre points for a table,
and for samples a fine grid that gives every smooth average that the samples give. For densities
that functions give see `function_points`.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from kinetics.errors import InputError
from kinetics.numerics import FloatArray, NumberArray
from kinetics.numerics.chebyshev import interpolation_rows
from kinetics.numerics.gauss import panels_between
from kinetics.states.state import LogMeasure

#: e-folds of accuracy beyond rtol, so that cut tails are rtol/e^2 and do not add up. Chosen:
#: moments of a Gaussian are right to 0.12 rtol; with 1 to 0.33, with 4 to 0.02.
MARGIN = 2.0
#: More e-folds for the spacing of a Gaussian's points: for the factor of its error that is not
#: exponential. Measured: with half of it moments of a Gaussian are right to 0.16 rtol, not 0.12.
SPACING_FOLDS = 6.0
#: More e-folds for each power of the speed, as its error has a power of the wave number. Measured:
#: with half of it moments up to p = 40 are right to 0.85 rtol, not 0.12; twice changes nothing.
SPACING_FOLDS_PER_POWER = 1.5

#: Least speed in U whose logarithm is taken. Chosen: slower ones are denormal numbers.
LEAST_SPEED = 1e-320
#: Least ln v of a table. Chosen: the smallest number of full accuracy is e^-708.
LEAST_LOG_SPEED = -700.0
#: Gauss points of a panel of a table. Derived with `MAX_LOG_CHANGE_OF_TABLE`; with 3 averages move
#: by 2e-10, with 12 by 4e-14 (rtol 1e-8).
TABLE_POINTS = 6
#: Least number of panels of a table in a unit of ln v. Chosen; for powers up to 4 it follows from
#: `MAX_LOG_CHANGE_OF_TABLE`.
TABLE_PANELS_PER_UNIT = 4.0
#: ln of how far v^p f v may change across a panel of a table. Derived: 6 Gauss points leave 2e-16
#: times its twelfth power, 2e-14.
MAX_LOG_CHANGE_OF_TABLE = 1.5

#: Grid points over which a sample is spread. Chosen; `INTERPOLATION_ERROR` says what they leave.
SAMPLE_WIDTH = 12
#: Interpolation by 12 points of spacing h leaves this times h^12 times the twelfth derivative of a
#: function, which is p^12 v^p for a power. Derived: (1 3 5 7 9 11/2^6)^2/12!.
INTERPOLATION_ERROR = (10395.0 / 64.0) ** 2 / math.factorial(SAMPLE_WIDTH)
#: Widest spacing of the grid of samples in ln v. Derived: it leaves 2e-19 p^12.
SAMPLE_SPACING = 1.0 / 16.0
#: So many samples are always kept as they are. Chosen: the grid of more has about 400 points.
FEW_SAMPLES = 400
#: Samples that are put on the grid at once, so that memory stays flat. Measured: with half of it
#: 400,000 samples take as long, with twice of it half as long again.
SAMPLES_AT_ONCE = 100_000


def gaussian_points(
    rtol: float, lowest: float, highest: float, dimension: int, deviation: float, ratio: float = 1.0
) -> LogMeasure:
    """Return points of v^(d-1) exp(-v^2/2 D^2), by the trapezoid rule in ln v.

    Spacing h leaves exp(-pi^2/(2 h)), times a power of k for the powers of v. The left end is where
    v^(d + lowest), or v^2, is below rtol/e^2, the right one where exp(-v^2/2) is as small.

    Parameters
    ----------
    rtol : relative accuracy of averages
    lowest, highest : of these powers of the speed
    dimension : d
    deviation : D
    ratio : the density may be multiplied by a function of v/D that is at most this, and at most D/v
    """
    folds = math.log(1.0 / rtol) + MARGIN
    folds_of_spacing = folds + SPACING_FOLDS + SPACING_FOLDS_PER_POWER * (highest + dimension - 2)
    power = min(2.0, dimension + lowest)
    left = -(folds + math.log(ratio)) / power
    if power > 1.0:
        left = max(left, -folds / (power - 1.0))
    right = 0.5 * math.log(2.0 * folds_of_spacing)
    spacing = 0.5 * math.pi**2 / folds_of_spacing
    x = np.arange(left, right + spacing, spacing)
    weight = np.exp(dimension * x - 0.5 * np.exp(2.0 * x))
    return LogMeasure(x + math.log(deviation), weight / weight.sum())


def table_points(
    speed: FloatArray, density: NumberArray, rtol: float, lowest: float, highest: float
) -> LogMeasure:
    """Return points of a density, real or complex, that is linear between tabulated speeds.

    Its pieces are divided into Gauss panels in ln v, which are narrow enough for powers of the
    speed from ``lowest`` to ``highest``. One that begins at speed 0 goes down to where what is left
    is rtol of <v^lowest>.

    Raises
    ------
    InputError : <v^lowest> nearly diverges, so that this is beyond the range of doubles
    """
    knots = np.log(np.maximum(speed, LEAST_SPEED))
    if speed[0] == 0.0:
        density_exponent = 1.0 if density[0] else 2.0
        exponent = density_exponent + min(lowest, 0.0)
        knots[0] = knots[1] - (math.log(1.0 / rtol) + MARGIN) / exponent
        if knots[0] < LEAST_LOG_SPEED:
            raise InputError(f"p: got {lowest:g}; <v^p> of this table is too near to divergence")
    steepest = max(highest + 2.0, -lowest)  # of v^p f v, f at most linear in v
    panels_per_unit = max(TABLE_PANELS_PER_UNIT, steepest / MAX_LOG_CHANGE_OF_TABLE)
    edges = []
    for begin, end in itertools.pairwise(knots):
        if end > begin:
            n_panels = max(1, math.ceil(panels_per_unit * (end - begin)))
            edges.append(np.linspace(begin, end, n_panels + 1)[:-1])
    edges.append(knots[-1:])
    x, quadrature_weight = panels_between(np.concatenate(edges), TABLE_POINTS)
    v = np.exp(x)
    return without_zeros(x, quadrature_weight * v * np.interp(v, speed, density))


def samples_points(x: FloatArray, weight: NumberArray, rtol: float, power: float) -> LogMeasure:
    """Return samples at ln v = x of some weights, (n,) each; many are gathered on a fine grid.

    Averages of v^power, and of functions of ln v that are no steeper, stay the same to a tenth of
    rtol: each sample is spread over the grid points around it by the rows that interpolate there.
    """
    finest = (0.1 * rtol / INTERPOLATION_ERROR) ** (1.0 / SAMPLE_WIDTH) / max(abs(power), 1.0)
    spacing = min(SAMPLE_SPACING, finest)
    start = spacing * (math.floor(float(x.min()) / spacing) - SAMPLE_WIDTH)
    n_cells = math.ceil((float(x.max()) - start) / spacing) + SAMPLE_WIDTH
    few_samples = FEW_SAMPLES
    if spacing < SAMPLE_SPACING:
        few_samples = max(few_samples, n_cells)
    if x.size <= few_samples:
        return LogMeasure(x, weight)
    grid_weight = np.zeros(n_cells + 1, dtype=weight.dtype)
    offsets = np.arange(SAMPLE_WIDTH)
    nodes = offsets.astype(float)
    binomials = [math.comb(SAMPLE_WIDTH - 1, k) for k in range(SAMPLE_WIDTH)]
    barycentric = np.array(binomials) * (-1.0) ** nodes
    n_pieces = max(1, x.size // SAMPLES_AT_ONCE)
    x_pieces = np.array_split(x, n_pieces)
    weight_pieces = np.array_split(weight, n_pieces)
    for x_piece, weight_piece in zip(x_pieces, weight_pieces, strict=True):
        cell = (x_piece - start) / spacing
        first_node = np.floor(cell).astype(int) - SAMPLE_WIDTH // 2 + 1
        rows = interpolation_rows((cell - first_node)[:, None] - nodes, barycentric)
        np.add.at(grid_weight, first_node[:, None] + offsets, rows * weight_piece[:, None])
    return without_zeros(start + spacing * np.arange(n_cells + 1), grid_weight)


def without_zeros(x: FloatArray, weight: NumberArray) -> LogMeasure:
    """Return the points whose weights are not zero."""
    nonzero = weight != 0.0
    return LogMeasure(x[nonzero], weight[nonzero])
