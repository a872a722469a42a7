r"""The generator of the velocity of a driven tracer, harmonic by harmonic.

Of a function h = sum_m H_m(v) Y_m of the velocity, Y_m = cos(m phi) in the plane and P_m(cos theta)
in space about the field (family 0), or sin(m phi) and P_m^1(cos theta) cos(azimuth) across it
(family 1), the rate of change of its average is that of

    L h = collisions + D_v laplacian h - gamma v.grad h + g d_x h.

A collision with a scatterer of velocity V and the normal n is at the rate q dphi_n/2 in the plane,
q dOmega_n/pi in space, q = (v - V).n > 0, and takes (1 + e*) q n from the velocity. Only V.n
matters, which is Gaussian of deviation w. Distributions are the averages of the polynomials of the
axis: they obey the transposed matrices, and averages over them are sums.

Begin with `Generator`. Its steady state is in `kinetics.driven.steady_solution`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from numpy.polynomial.legendre import legvander

from kinetics.collision import CollisionLaw
from kinetics.drive import Drive
from kinetics.driven.chebyshev_axis import ChebyshevSpeedAxis
from kinetics.driven.harmonics import Chain
from kinetics.driven.panel_collisions import harmonic_bounces
from kinetics.driven.resolution import ChebyshevResolution
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import gauss_legendre

#: Impacts times functions of a solution that may have a finer one, at most: seconds.
MAX_IMPACT_WORK = 2e8
#: Standard deviations of a scatterer's velocity that count: beyond it are 1e-16 of them.
BATH_REACH = 8.5
#: Fewest points of the quadrature over a part of the impact parameter. Chosen: it matters for loose
#: tolerances only; with 5 and with 20 nothing moves at rtol 1e-6.
MIN_IMPACT_POINTS = 10
#: The power by which nodes gather at slow impacts, where e varies as v_n^(1/5).
GATHERING_POWER = 4.0


@dataclass(frozen=True)
class Impacts:
    """Impacts on tracers of one speed: points of a quadrature, shape (n,) each.

    Parameters
    ----------
    cosine : of the normal to the velocity
    q : normal impact speeds
    rate : per unit time; their sum is the rate of collisions
    """

    cosine: FloatArray
    q: FloatArray
    rate: FloatArray


class Generator:
    """The matrices of one drive, in units of l, on one axis of speeds.

    Attributes
    ----------
    drive, axis, harmonics : what acts; the speeds; M
    matrices : the generator without the field, for each harmonic, (M + 1, size, size)
    rate : of collisions at each speed, (size,)
    chain : the equation of distributions
    finer : the next finer resolution; None where there is none
    """

    def __init__(
        self, drive: Drive, axis: ChebyshevSpeedAxis, resolution: ChebyshevResolution
    ) -> None:
        self.drive = drive
        self.axis = axis
        self.harmonics = resolution.harmonics
        self._points = resolution.points
        self._slopes = (axis.derivative(0), axis.derivative(1))
        n_impacts = 0
        if drive.law is not None:
            self.rate = axis.speeds
            self.matrices = self._scaling_collisions(drive.law)
        else:
            self.rate = np.zeros(axis.size)
            self.matrices = np.zeros((self.harmonics + 1, axis.size, axis.size))
            n_impacts = self._set_collisions()
        work = n_impacts * (axis.size + self.harmonics)
        self.finer = resolution.finer if work < MAX_IMPACT_WORK else None
        self._add_noise_and_drag()
        self.chain = self._make_chain()

    def _add_noise_and_drag(self) -> None:
        """Add D_v laplacian - gamma v.grad to the matrices."""
        d = self.drive.dimension
        v = self.axis.speeds
        inverse = np.diag(1.0 / v)
        noise = self.drive.heating * self.axis.faded[:, None]
        for m, matrix in enumerate(self.matrices):
            slope = self._slopes[m % 2]
            second = self._slopes[1 - m % 2] @ slope
            laplacian = second + (d - 1.0) * inverse @ slope - m * (m + d - 2.0) * inverse**2
            matrix += noise * laplacian - self.drive.drag * v[:, None] * slope

    def _make_chain(self) -> Chain:
        """Return the equation of distributions, which obey the transposed matrices."""
        d = self.drive.dimension
        faded = self.axis.faded
        inverse = faded / self.axis.speeds
        turn = np.diag((d - 1.0) * inverse)
        of_even = -(faded[:, None] * self._slopes[0]).T - turn
        of_odd = -(faded[:, None] * self._slopes[1]).T - turn
        return Chain(
            dimension=d,
            lost=-self.matrices.swapaxes(1, 2),
            # the slope of an even harmonic acts on the odd ones
            slopes=(of_odd, of_even),
            inverse=inverse,
            field=self.drive.field,
            absorbs=self.drive.is_field_dominated,
        )

    # -- collisions -------------------------------------------------------------------------------

    def _scaling_collisions(self, law: CollisionLaw) -> FloatArray:
        """Return the matrices where all speeds have the same bounces.

        Only what changes in a bounce is summed, without rounding.
        """
        v = self.axis.speeds
        bounces = harmonic_bounces(law, self.axis.size, self.harmonics)
        changes = [change @ bounces.kept.T for change in self.axis.changes(bounces.log_loss)]
        by_harmonic = np.stack(changes, axis=-1).swapaxes(0, 1)
        matrices = v[:, None] * (by_harmonic @ self.axis.to_coefficients(0))
        nodes = np.arange(v.size)
        matrices[:, nodes, nodes] -= np.outer(bounces.lost.sum(axis=1), v)
        return np.asarray(matrices)

    def _set_collisions(self) -> int:
        """Set the matrices and rates, speed by speed; return the number of impacts."""
        n_impacts = 0
        for i, v in enumerate(self.axis.speeds):
            impacts = self._impacts(v)
            self._set_coefficients(i, v, impacts)
            self.rate[i] = impacts.rate.sum()
            n_impacts += impacts.rate.size
        for parity in (0, 1):
            to_coefficients = self.axis.to_coefficients(parity)
            self.matrices[parity::2] = self.matrices[parity::2] @ to_coefficients
        nodes = np.arange(self.axis.size)
        self.matrices[:, nodes, nodes] -= self.rate
        return n_impacts

    def _set_coefficients(self, i: int, v: float, impacts: Impacts) -> None:
        """Set the averages of polynomials after impacts at the i-th speed: its rows."""
        lost = self.drive.impulse(impacts.q) * impacts.q
        along = v - lost * impacts.cosine
        across_squared = lost**2 - (lost * impacts.cosine) ** 2
        after = np.sqrt(along**2 + across_squared)
        turned = np.divide(along, after, out=np.ones_like(after), where=after > 0.0)
        turned = np.clip(turned, -1.0, 1.0)
        if self.drive.dimension == 2:
            angular = chebvander(turned, self.harmonics)
        else:
            angular = legvander(turned, self.harmonics)
        gained = np.where(impacts.q < self.drive.capture_speed, 0.0, impacts.rate)
        weighted = (angular * gained[:, None]).T
        polynomials = self.axis.polynomials(after)
        for parity in (0, 1):
            self.matrices[parity::2, i] = weighted[parity::2] @ polynomials[parity]

    def _impacts(self, v: float) -> Impacts:
        """Return a quadrature over the impacts of tracers of speed v."""
        if self.drive.bath_speed:
            return self._impacts_in_bath(v)
        breaks = self.drive.breaks / v
        edges = np.unique(np.concatenate([[0.0], breaks[breaks < 1.0], [1.0]]))
        x, weight = self._nodes_at_slow_impacts(self._points_per_interval(edges))
        cosine, weight = self._over_normals(edges, x, weight)
        return Impacts(cosine, v * cosine, weight * v * cosine)

    def _impacts_in_bath(self, v: float) -> Impacts:
        """Return the same where scatterers move."""
        w = self.drive.bath_speed
        reach = BATH_REACH * w / v  # cosines below which the scatterer's own velocity may decide
        edges = np.unique(np.clip([-reach, reach, 1.0], -1.0, 1.0))
        x, weight = gauss_legendre(self._points_per_interval(edges))
        cosine, weight = self._over_normals(edges, x, weight)
        high = v * cosine + BATH_REACH * w
        is_possible = high > 0.0
        high = high[is_possible]
        cosine = cosine[is_possible]
        weight = weight[is_possible]
        low = np.maximum(0.0, v * cosine - BATH_REACH * w)
        breaks = np.clip(self.drive.breaks, low[:, None], high[:, None])
        cuts = np.concatenate([low[:, None], breaks, high[:, None]], axis=1)
        node, node_weight = self._nodes_at_slow_impacts(self._points)
        width = np.diff(cuts, axis=1)[:, :, None]
        q = (cuts[:, :-1, None] + width * node).reshape(cosine.size, -1)
        q_weight = (width * node_weight).reshape(cosine.size, -1)
        deviations = (v * cosine[:, None] - q) / w
        density = np.exp(-0.5 * deviations**2) / (math.sqrt(2.0 * math.pi) * w)
        rate = weight[:, None] * q_weight * q * density
        cosines = np.broadcast_to(cosine[:, None], q.shape)
        return Impacts(cosines.ravel(), q.ravel(), rate.ravel())

    def _points_per_interval(self, edges: FloatArray) -> int:
        """Return how many points each interval of cosines has."""
        n_inner = max(1, edges.size - 2)
        return max(MIN_IMPACT_POINTS, self._points // n_inner)

    def _over_normals(
        self, edges: FloatArray, x: FloatArray, weight: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the cosine of the normal, and its weight, on intervals of cosines.

        edges : of the intervals; x, weight : of the quadrature on [0, 1]
        """
        if self.drive.dimension == 2:
            edges = np.arcsin(edges)
        width = np.diff(edges)[:, None]
        place = (edges[:-1, None] + width * x).ravel()
        weight = (width * weight).ravel()
        if self.drive.dimension == 2:
            return np.sin(place), weight
        return place, 2.0 * weight

    def _nodes_at_slow_impacts(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Return nodes and weights on [0, 1], close to 0 where slow impacts need it."""
        x, weight = gauss_legendre(count)
        if not self.drive.is_singular:
            return x, weight
        return x**GATHERING_POWER, weight * GATHERING_POWER * x ** (GATHERING_POWER - 1.0)
