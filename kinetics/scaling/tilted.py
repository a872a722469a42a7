r"""The stationary scaled equation, solved through a tilt of the logarithmic speed axis.

The paper's scaled equation (label ``ifmu2``), for the density g of x = ln(kappa v t/l), reads

    dg/dx = -e^x g/kappa + E[ e^(x+xi) g(x+xi) ]/kappa,     xi = -ln s >= 0 :

a constant drift to larger v t against the losses at bounces. Integrated once it says that g, the
flux upwards past x, equals the flux downwards past x that the losses make. For G = e^(theta x) g on
a periodic window of equidistant x this is a convolution W (symbol lambda(z)/(kappa z),
z = theta - i k):

    G = W (e^x G).

G is the null vector of a dense matrix of 50 to 200 rows. The tilt theta moves the peak of the
unknown along the axis: each tilt resolves g around the peak of e^(theta x) g, with rounding errors
relative to g itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics import ComplexArray, FloatArray
from kinetics.numerics.log_grid import LogGrid

MAX_NODES = 4096  # a matrix of 130 MB
SMALLEST_NODES = 8
# The error of a tilt is about e^-depth of its peak, if its window ends where the density weighs
# e^(1-depth) and its highest mode is e^-(depth + _MORE_MODES): depth is ln(1/rtol) and a margin.
_MARGIN = 7.0
_MORE_MODES = 1.0
# The highest modes left out move a wide density as a whole, which high moments notice: more modes
# for each unit of its deviation.
_MORE_WHERE_WIDE = 2.3
_MISSED = 20.0  # a tilt whose estimate is this far above its error is solved again
# Rounding of a tilt relative to its peak; over its deviation for nearly elastic tracers. They
# size grids and joins; what is promised is the floor of kinetics.scaling.log_density.
_ROUNDING, _NARROW_ROUNDING = 1e-14, 2e-15
_NARROWEST = 2.2  # deviations that a tilt serves on either side, at least
# Error over estimate: of the unknown that makes the equation regular, some and more for narrow
# densities, and of the highest modes.
_DEFECT, _NARROW_DEFECT, _SPECTRUM = 30.0, 1.3, 0.3
# If a bounce may lose more than _FEW_BOUNCES (in -ln s), few of them carry a tracer from the bulk
# (x near 0) to low speeds, and a tilt there loses as much of its accuracy as the bulk is below its
# peak: e^-_BULK_DROP at most.
_FEW_BOUNCES, _BULK_DROP = -math.log(0.65), 3.5
_SIZING = 0.6  # of the exponent that sets the points of lambda: less accuracy will size a grid
# Share of energy lost (e = 1 - 1e-6) below which 1 - E[s^z] loses more digits than sizes of grids
# can bear.
_ELASTIC = 1.333e-6


def flux_symbol(
    law: CollisionLaw, z: NDArray[Any], decay: NDArray[Any] | None = None
) -> NDArray[Any]:
    """lambda(z)/(kappa z), 1 at z = 0: the flux of losses past a speed, relative to v at it.

    ``decay`` is lambda(z) where it is known.
    """
    zero = z == 0.0
    safe = np.where(zero, 1.0, z)
    if decay is None:
        decay = law.decay_symbol(safe)
    return np.asarray(np.where(zero, 1.0, decay / (law.mean_log_loss * safe)))


def drift_log(law: CollisionLaw, z: NDArray[Any]) -> NDArray[Any]:
    """rho(z) = ln(kappa z/lambda(z)) = ln A(z+1) - ln A(z), A(z) = E[(kappa v t/l)^z]; z real.

    An estimate for the sizes of windows: at large |z| the plain quadrature is a percent off.
    """
    if law.uniform_power:
        return np.asarray(np.log1p(z / law.uniform_power))
    q = law.quadrature
    zero = z == 0.0
    safe = np.where(zero, 1.0, z)
    decay = -np.expm1(-np.multiply.outer(safe, q.log_loss)) @ q.weight
    decay = law.met_again(safe, decay, 0)
    return np.asarray(np.where(zero, 0.0, np.log(law.mean_log_loss * safe / decay)))


def peak_position(law: CollisionLaw, z: NDArray[Any]) -> NDArray[Any]:
    """Where e^(z x) g(x) peaks in the scaling state, x = ln(kappa v t/l); an estimate, z real.

    The mean of x is the derivative of ln A, rho(z - 1/2) up to third differences of rho.
    """
    q = law.uniform_power
    if q:
        # nearly the digamma function at q + z, the derivative of ln Gamma(q + z)
        return np.asarray(np.log(z + q + 0.5) - 1.0 / (z + q) - math.log(q))
    return drift_log(law, z - 0.5)


@dataclass(frozen=True)
class Tilt:
    """The solution seen through e^(theta x).

    Attributes
    ----------
    theta : the tilt
    grid : nodes in x = ln(kappa v t/l)
    values : e^(theta x) g(x)/A(theta) at the nodes, shape (nodes,); sums to 1/h
    centre, deviation : mean and standard deviation of x under that density
    span : it is used down to e^(-span^2/2) of the peak, about so many deviations from the centre
    noise : the error relative to the maximum for which its grid was chosen
    defect, edges, spectrum : three estimates of that error: from the unknown that makes the
        discrete equation regular, from the values at the ends, and from the highest modes
    """

    theta: float
    grid: LogGrid
    values: FloatArray
    centre: float
    deviation: float
    span: float
    noise: float
    defect: float
    edges: float
    spectrum: float

    @property
    def discretisation_error(self) -> float:
        """Estimate of the part of the error that more nodes would make smaller."""
        return max(self.defect, self.edges, self.spectrum)

    @cached_property
    def landmarks(self) -> tuple[float, float, float]:
        """Log g, up to the tilt's own scale, at the bottom, the centre and the top."""
        low, middle, high = self.log_density(np.array([self.bottom, self.centre, self.top]))
        return float(low), float(middle), float(high)

    @cached_property
    def _ends(self) -> tuple[float, float]:
        """Lowest and highest x at which the tilt is used as long as there is a neighbour."""
        size = math.exp(-0.5 * self.span**2) * float(self.values.max())
        used = np.nonzero(self.values >= size)[0]
        return float(self.grid.x[used[0]]), float(self.grid.x[used[-1]])

    @property
    def bottom(self) -> float:
        """The lowest of them."""
        return self._ends[0]

    @property
    def top(self) -> float:
        """The highest of them."""
        return self._ends[1]

    @cached_property
    def _coefficients(self) -> ComplexArray:
        return self.grid.coefficients(self.values)

    def density(self, x: FloatArray) -> FloatArray:
        """g(x) up to the tilt's own scale, x (n,) in the window, with its sign."""
        return self.grid.evaluate(self._coefficients, x) * np.exp(-self.theta * x)

    def log_density(self, x: FloatArray) -> FloatArray:
        """Log g(x) up to the tilt's own scale, x (n,) in the window; -inf where it is not > 0."""
        value = self.grid.evaluate(self._coefficients, x)
        return self._log(value) - self.theta * x

    @cached_property
    def log_at_nodes(self) -> FloatArray:
        """The same at the nodes."""
        return self._log(self.values) - self.theta * self.grid.x

    @staticmethod
    def _log(value: FloatArray) -> FloatArray:
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(np.maximum(value, 0.0)))


def _variance(law: CollisionLaw, theta: float) -> float:
    """Of x under the tilt, nearly: the second derivative of ln E[(kappa v t/l)^z] at theta."""
    if law.energy_loss < _ELASTIC:
        # E[xi^2]/(2 kappa): differences of logarithms close to 0 would have no digits
        q = law.quadrature
        return float(q.weight @ q.log_loss**2) / (2.0 * law.mean_log_loss)
    around = theta + np.array([-0.01, 0.01])
    return float(np.diff(peak_position(law, around))[0]) / 0.02


def window_of(law: CollisionLaw, theta: float, depth: float) -> tuple[float, float, float]:
    """Ends of the window beyond which the tilted density weighs e^-depth, and its width.

    Chernoff's bound on either side. The logarithms of moments that it needs are sums of
    rho(z) = ln(kappa z/lambda(z)), taken in steps of about half a standard deviation.
    """
    deviation = math.sqrt(_variance(law, theta))
    stride = max(1, round(0.5 / deviation))
    n = np.arange(1, 51)
    # sum of rho over stride integers, from its middle: exact at stride 1
    up_at = theta + (n - 0.5) * stride - 0.5
    down_at = theta - (n - 0.5) * stride - 0.5
    if math.isfinite(law.lowest_power):
        down_at = down_at[:0]
    else:
        down_at = down_at[down_at > -600.0 / float(law.quadrature.log_loss.max())]
    rho = drift_log(law, np.concatenate([up_at, down_at])) * stride
    up, down = np.cumsum(rho[:50]), -np.cumsum(rho[50:])
    # a density of x falls as e^-(e^x) there: its own factor e^x is allowed for
    right = float(np.min((up + depth + 5.0) / (n * stride)))
    if not down_at.size:
        # the tilted density is e^((theta - lowest power) x) there; below e = 1e-200 as at e = 0
        lowest = law.lowest_power if math.isfinite(law.lowest_power) else -1.0
        return -(depth + 2.0) / (theta - lowest), right, deviation
    left = float(np.max(-(down + depth) / (n[: down.size] * stride)))
    return left, right, deviation


def band_of(law: CollisionLaw, theta: float, depth: float, deviation: float) -> float:
    """The wave number at which the transform A(theta + i k) has fallen to e^-depth.

    For Re z >= 1/2 the derivative of ln A is nearly rho(z - 1/2), rho = ln(kappa z/lambda(z));
    lower lines are taken there by ln A(z) = ln A(z + 1) - rho(z).
    """
    # lower down only wide densities need this: the branches are followed step by step
    shift = max(0, math.ceil(1.0 - theta)) if deviation > 0.4 else 0
    for reach in (14.0, 60.0, 300.0) if deviation < 0.6 else (45.0, 300.0):
        k = np.linspace(0.0, reach / deviation, 32)
        lines = np.append(theta + np.arange(shift), theta + shift - 0.5)
        log_flux = _log_flux_on_lines(law, lines, k)
        # the imaginary part without its branches, from step to step
        turn = -np.cumsum(np.angle(np.exp(1j * np.diff(log_flux[-1].imag, prepend=0.0))))
        fall = np.concatenate([[0.0], np.cumsum(0.5 * (turn[1:] + turn[:-1]) * np.diff(k))])
        # the real part has no branches
        if shift:
            fall -= (log_flux[:shift].real - log_flux[:shift, :1].real).sum(axis=0)
        past = np.nonzero(fall > depth)[0]
        if past.size:
            # the fall is convex: the wave number of the last point before is not far off
            i = int(past[0])
            share = (depth - fall[i - 1]) / (fall[i] - fall[i - 1])
            return float(k[i - 1] + share * (k[i] - k[i - 1]))
    return float(k[-1])


def _log_flux_on_lines(law: CollisionLaw, real: FloatArray, k: FloatArray) -> ComplexArray:
    """ln[lambda(z)/(kappa z)] at z = real + i k, shape (n_real, n_k), accurate enough for sizes.

    real (n_real,), k (n_k,) equidistant from 0. The lines share the exponentials of k.
    """
    real = np.where(np.abs(real) < 1e-3, 1e-3, real)  # lambda(z)/z has a limit at z = 0
    z = real[:, None] + 1j * k
    if law.uniform_power:
        return np.asarray(-np.log(1.0 + z / law.uniform_power))
    if law.energy_loss < _ELASTIC:
        # 1 - E[s^z] would be 0
        return np.asarray(np.log(flux_symbol(law, z.ravel()).reshape(z.shape)))
    q = law.quadrature_for(_SIZING * float(np.abs(real).max() + k[-1]))
    weights = q.weight * np.exp(-np.multiply.outer(real, q.log_loss))
    turns = np.empty((q.log_loss.size, k.size), dtype=complex)
    turns[:] = np.exp(-1j * k[1] * q.log_loss)[:, None]
    turns[:, 0] = 1.0
    power = weights @ np.cumprod(turns, axis=1, out=turns)
    decay = law.met_again(z, 1.0 - power, 0)
    return np.asarray(np.log(decay / (law.mean_log_loss * z)))


def _span(rtol: float) -> float:
    """Deviations from its centre at which a tilt leaves an eighth of rtol: there are many seams.

    Its error there is some 0.3 e^-depth of the peak, and g is e^(-span^2/2) of it.
    """
    room = 0.1 * rtol / max(math.exp(-_MARGIN) * rtol, _ROUNDING)
    return max(_NARROWEST, math.sqrt(2.0 * math.log(max(room, 1.0))))


def next_tilt(law: CollisionLaw, known: Tilt, rtol: float, *, above: bool) -> float | None:
    """The tilt that takes over, up or down, where a known one ends.

    None where there is none: at low e tracers get to low speeds from the bulk in few bounces, and
    the tilt must still resolve the bulk.
    """
    sign = 1.0 if above else -1.0
    span = _span(rtol)
    # s^z must not overflow, half a unit below the tilt either
    deepest = float(law.quadrature.log_loss.max())
    lowest = max(-500.0 / deepest, 0.55 - 690.0 / deepest)
    shares = np.array([2.0, 1.6, 1.3, 1.0, 0.8, 0.65, 0.5, 0.4, 0.3])
    thetas = known.theta + sign * shares * (span + known.span) / known.deviation
    thetas = thetas[thetas > lowest]
    if thetas.size == 0:
        return None
    two = peak_position(law, np.concatenate([thetas, thetas + 0.05]))
    centre = two[: thetas.size]
    slope = (two[thetas.size :] - centre) / 0.05
    distance = sign * (centre - known.centre)
    near = distance <= known.span * known.deviation + span * np.sqrt(np.abs(slope))
    if not above and law.largest_loss > _FEW_BOUNCES:
        near &= (centre > 0.0) | (centre**2 < 2.0 * _BULK_DROP * np.abs(slope))
    return float(thetas[near][0]) if np.any(near) else None


def solve_tilt(law: CollisionLaw, theta: float, rtol: float, nodes: int | None = None) -> Tilt:
    """Solve the scaled equation for e^(theta x) g; ``nodes`` overrides the choice of spacing."""
    span = _span(rtol)
    depth = math.log(1.0 / rtol) + _MARGIN
    if nodes is not None:
        left, right, _ = window_of(law, theta, depth - 1.0)
        tilt = _solve_on(law, theta, LogGrid(left, (right - left) / nodes, nodes))
        rounding = _NARROW_ROUNDING / tilt.deviation
        return replace(tilt, span=span, noise=max(tilt.discretisation_error, rounding))
    noise = max(math.exp(-depth), _ROUNDING)
    for more in (0.0, 2.5, 5.0):
        grid = _choose_grid(law, theta, depth + more)
        tilt = _solve_on(law, theta, grid)
        if tilt.discretisation_error <= _MISSED * noise or grid.nodes >= MAX_NODES:
            break
    return replace(tilt, span=span, noise=noise)


def _choose_grid(law: CollisionLaw, theta: float, depth: float) -> LogGrid:
    left, right, deviation = window_of(law, theta, depth - 1.0)
    more = _MORE_MODES + _MORE_WHERE_WIDE * deviation
    band = band_of(law, theta, depth + more, deviation)
    # an odd number: at an even one the highest mode is half missing, and its error ten times that
    nodes = min(MAX_NODES, max(SMALLEST_NODES, math.ceil((right - left) * band / math.pi))) | 1
    return LogGrid(left, (right - left) / nodes, nodes)


def _solve_on(law: CollisionLaw, theta: float, grid: LogGrid) -> Tilt:
    nodes = grid.nodes
    decay = law.decay_symbol(theta - 1j * grid.wave_numbers)
    flux = grid.circulant(flux_symbol(law, theta - 1j * grid.wave_numbers, decay))
    # one more row and column make it regular: the row fixes the sum, and the unknown of the column
    # is what the discrete equation lacks to have a solution
    matrix = np.empty((nodes + 1, nodes + 1))
    np.multiply(flux, -np.exp(grid.x), out=matrix[:nodes, :nodes])
    matrix.ravel()[: nodes * (nodes + 1) : nodes + 2] += 1.0
    matrix[:nodes, nodes] = 1.0
    matrix[nodes, :nodes] = 1.0
    matrix[nodes, nodes] = 0.0
    right_side = np.zeros(nodes + 1)
    right_side[nodes] = 1.0 / grid.spacing
    solution = np.linalg.solve(matrix, right_side)
    values: FloatArray = np.asarray(solution[:nodes], dtype=float)
    top = float(np.abs(values).max())
    spectrum = np.abs(np.fft.rfft(values))
    centre = float(grid.x @ values) * grid.spacing
    variance = float((grid.x - centre) ** 2 @ values) * grid.spacing
    deviation = math.sqrt(max(variance, grid.spacing**2))
    first, before, last = (abs(float(v)) for v in values[[0, -2, -1]])
    # beyond the last node the density goes on falling, faster and faster
    last *= min(1.0, last / before) if before > 0.0 else 1.0
    return Tilt(
        theta=theta,
        grid=grid,
        values=values,
        centre=centre,
        deviation=deviation,
        span=_NARROWEST,
        noise=0.0,
        defect=abs(float(solution[nodes])) / top * (_DEFECT + _NARROW_DEFECT / deviation),
        edges=max(first, last) / top,
        spectrum=_SPECTRUM * float(spectrum[-2:].max()) / float(spectrum[0]),
    )
