r"""The distribution of the displacement: g(r, t), and what the scaled G(R) is made of.

With F(k, t), the average of exp(i k.r) over the start and the paths
(:mod:`kinetics.position.intermediate_scattering`),

    g(r, t) = r integral of k J_0(k r) F(k, t) dk

(paper, section on the position distribution). Tracers that have not collided are kept apart
(:mod:`kinetics.position.ballistic_front`); only the others are transformed, whose F falls fast in
k, until a power of 1/k is left (:mod:`kinetics.position.tail`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics.barycentric import interpolation_rows
from kinetics.numerics.gauss import panels_of
from kinetics.numerics.wave_panel import Indices, WavePanel, chebyshev_points, last_coefficients
from kinetics.position.ballistic_front import fronts, reach, uncollided_density
from kinetics.position.intermediate_scattering import Scattering, points_of
from kinetics.position.tail import PowerTail, fit_tail
from kinetics.states.state import State

FloatArray = NDArray[np.float64]

# F that does not end before is solved for up to this K or K T: of peaks, and of densities
_LARGEST = 8.0
_TURNS = 60.0
_FEW = 0.01  # share of rtol that tracers may be that are left out
_FAR = 50.0  # R beyond which G is nothing
_PIECES = 200  # on which the uncollided are integrated
_DEEPEST = 7  # halvings of an interval of wave numbers
_BEST = 3e-12  # of F at small K
_CHEAPER = 1e-4  # accuracy of F at small K in units of that of G: it costs little
_POWERS = 2.2  # K, in units of where they begin, from which the powers of 1/K are looked for
_STEP = 1.25  # from one interval to the next, at least
_FALL = 0.25  # what powers of 1/K miss falls as K^-4 at least, measured
_CHEAP = 2.0  # K up to which that is


@dataclass(frozen=True)
class Displacement:
    """g(r, t) at the times of a scene.

    Attributes
    ----------
    mean_free_path : l, in d
    times : in d/U, shape (n_times,)
    root_mean_square : sqrt(<r^2>) in d, shape (n_times,)
    panels : F of the collided on intervals of k l
    tails : and beyond them, for each time; None where nothing is left
    cut : K from which F is tapered, for each time; infinite where it ends by itself
    uncollided : (time index, r (n_r,)) -> density of those that have not collided, if they have
        one, in 1/d
    front_radius, front_weight : where and how many they are if they have none, in d and as
        shares of all tracers, shape (n_times, n_speeds); n_speeds = 0 for densities
    reach : radius beyond which there is nothing, in d, shape (n_times,)
    error_estimate : absolute, of G(R)
    systems : how many systems of so many equations were solved, by their size
    """

    mean_free_path: float
    times: FloatArray
    root_mean_square: FloatArray
    panels: tuple[WavePanel, ...]
    tails: tuple[PowerTail | None, ...]
    cut: FloatArray
    uncollided: Callable[[int, FloatArray], FloatArray]
    front_radius: FloatArray
    front_weight: FloatArray
    reach: FloatArray
    error_estimate: float
    systems: dict[int, int]

    @property
    def wave_numbers(self) -> int:
        """How many were solved for."""
        return sum(panel.values.shape[1] for panel in self.panels)

    def density(self, time: int, r: FloatArray) -> FloatArray:
        """g(r, t) without delta peaks, in 1/d, shape (n_r,)."""
        near = np.minimum(r, self.reach[time])
        collided = near / self.mean_free_path * (self._transform(time, r, 0) / self.mean_free_path)
        return np.asarray(collided + self.uncollided(time, r))

    def collided_within(self, time: int, r: FloatArray) -> FloatArray:
        """Share of all tracers that have collided and are within r, shape (n_r,)."""
        inside = r / self.mean_free_path * self._transform(time, r, 1)
        return np.where(r <= self.reach[time], inside, self._collided(time))

    def _collided(self, time: int) -> float:
        """Share of all tracers that have collided: F at k = 0."""
        f = self.panels[0].of(time) if self.panels else None
        if f is None:
            return 0.0
        local, barycentric = chebyshev_points(f.size)
        return float((interpolation_rows(-local[None], barycentric) @ f)[0])

    def within(self, time: int, r: FloatArray) -> FloatArray:
        """Share of all tracers within r, the uncollided among them, shape (n_r,)."""
        front = self.front_weight[time] @ (self.front_radius[time][:, None] <= r)
        free = np.zeros(r.shape)
        if self.front_radius.shape[1] == 0 and np.isfinite(self.reach[time]):
            near = np.minimum(r, self.reach[time])
            edges = np.union1d(np.linspace(0.0, self.reach[time], _PIECES), near)
            free = np.interp(near, edges, _integral(lambda x: self.uncollided(time, x), edges))
        return np.asarray(self.collided_within(time, r) + front + free)

    def collided_in_plane(self, time: int, r: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Density in the plane of the collided, in 1/d^2, and its slope in 1/d^3, (n_r,) each."""
        path = self.mean_free_path
        value = self._transform(time, r, 0) / path / path / (2.0 * math.pi)
        slope = -self._transform(time, r, 2) / path / path / path / (2.0 * math.pi)
        return value, slope

    def _transform(self, time: int, r: FloatArray, kind: int) -> FloatArray:
        """Integral over K of F times K J_0, J_1 or K^2 J_1 (kind 0, 1, 2) at r; 0 out of reach."""
        from scipy.special import j0, j1

        out = np.zeros(r.shape)
        inside = r <= self.reach[time]
        rho = r[inside] / self.mean_free_path
        if rho.size == 0:
            return out
        tail = self.tails[time]
        total = np.zeros(rho.shape) if tail is None else tail.transform(rho, kind)
        bessel = j0 if kind == 0 else j1
        for panel in self.panels:
            f = panel.of(time)
            if f is None:
                continue
            points = _enough(f.size, float(rho.max()) * (panel.high - panel.low))
            k, weight, values = panel.gauss(f, points)
            if tail is not None:
                values = values - tail.at(k)
            elif panel.high > self.cut[time]:
                # without the ringing that a sharp end would leave everywhere
                level = np.clip(k / self.cut[time] - 1.0, 0.0, 1.0)
                values = values * np.cos(0.5 * math.pi * level) ** 2
            total += bessel(np.outer(rho, k)) @ (weight * values * k ** (1, 0, 2)[kind])
        out[inside] = total
        return out


def _enough(nodes: int, turns: float) -> int:
    """Gauss points for a polynomial through the nodes times J_0 over ``turns`` of its argument.

    The Chebyshev coefficients of the Bessel function end at turns/2, softly. By eights: few
    different numbers, so that the points of other times and panels serve again.
    """
    half = 0.5 * turns
    return 8 * math.ceil((8.0 + 0.5 * (nodes + half) + 2.5 * half ** (1.0 / 3.0)) / 8.0)


def _integral(density: Callable[[FloatArray], FloatArray], edges: FloatArray) -> FloatArray:
    """Of a density, from the first edge to each, shape (n_edges,)."""
    x, w = panels_of(np.stack([edges[:-1], edges[1:]], axis=1), 12)
    share = (density(x.ravel()).reshape(x.shape) * w).sum(axis=1)
    return np.concatenate([[0.0], np.cumsum(share)])


def solve_displacement(
    law: CollisionLaw,
    mean_free_path: float,
    state: State,
    times: FloatArray,
    root_mean_square: FloatArray,
    rtol: float,
) -> Displacement:
    """g(r, t) at the times, such that G(R) is right to about rtol, absolute.

    root_mean_square : sqrt(<r^2>) in d, shape (n_times,)
    """
    width = root_mean_square / mean_free_path
    # early, the few that have collided are left out: they would need K up to 1/width
    few = width <= _FEW * rtol
    active = np.nonzero(~few)[0]
    panels: list[WavePanel] = []
    tails: list[PowerTail | None] = [None] * times.size
    missed, known = np.where(few, width, 0.0), np.zeros(times.size)
    system = Scattering(law, mean_free_path, state, times)
    speeds = points_of(state, 1.0, 1e-3)
    typical = math.exp(0.5 * speeds.log_second_moment()) / mean_free_path
    low, high = 0.0, 1.0 / float(width.max()) if active.size else 0.0
    cut = np.full(times.shape, np.inf)
    peaks = state.peaks is not None
    size = 1.0
    while active.size:
        longest = times[active] * typical
        if low >= (_LARGEST if peaks else _TURNS) and low * float(longest.max()) > _TURNS:
            break
        sharp = max(1.0, float(width[active].max()) * high)
        tolerance = min(rtol / sharp, max(_BEST, _CHEAPER * rtol) if high < _CHEAP else 1.0)
        # tracers of one speed that have hardly collided make F turn with cos(K T)
        flying = longest[np.exp(-longest) > tolerance] if peaks else longest[:0]
        swing = 0.5 * (high - low) * float(flying.max(initial=0.0))
        new, error = _interval(system, low, high, active, tolerance, size, swing)
        panels += new
        size = max(float(np.abs(panel.values).max()) for panel in new)
        reached = high
        for i in active:
            begin = math.inf if peaks else max(1.0, 1.0 / width[i])
            tails[i], left = _rest(panels, int(i), begin)
            # F missing at K, or wrong there, adds about K sigma F to G
            share = max(1.0, width[i] * high)
            known[i] = max(known[i], error * share)
            missed[i] = left * share + known[i]
            if missed[i] > 2.0 * rtol:
                enough = 2.0 * high
                if peaks:
                    enough = _end(panels[-1], int(i), rtol / share)
                elif tails[i] is not None:
                    enough = high * min(2.0, max(_STEP, (left * share / rtol) ** _FALL))
                reached = max(reached, enough)
        active = active[missed[active] > 2.0 * rtol]
        low, high = high, reached
    if active.size:
        cut[[i for i in active if tails[i] is None]] = 0.5 * panels[-1].high
    radius, weight = fronts(state, mean_free_path, times)
    return Displacement(
        mean_free_path,
        times,
        root_mean_square,
        tuple(panels),
        tuple(tails),
        cut,
        uncollided_density(state, mean_free_path, times),
        radius,
        weight,
        np.minimum(reach(state, times, 0.1 * rtol), _FAR * root_mean_square),
        float(missed.max(initial=0.0)),
        dict(system.systems),
    )


def _interval(
    system: Scattering,
    low: float,
    high: float,
    active: Indices,
    tolerance: float,
    size: float,
    swing: float,
    depth: int = 0,
) -> tuple[list[WavePanel], float]:
    """F on an interval of K, halved until its Chebyshev coefficients end; and the error.

    tolerance : of F; size : about the largest value there; swing : nodes for its turns
    """
    digits = math.log10(max(10.0, size / tolerance))
    nodes = math.ceil(4.0 + (1.3 if high > 1.5 * low else 1.0) * digits + swing)
    trial = WavePanel(low, high, active, np.empty((active.size, nodes)))
    values, error = system.collided(trial.nodes, active, tolerance)
    missed = last_coefficients(values)
    if missed > tolerance and depth < _DEEPEST:
        middle = 0.5 * (low + high)
        more = (active, tolerance, size, 0.5 * swing, depth + 1)
        left, first = _interval(system, low, middle, *more)
        right, second = _interval(system, middle, high, *more)
        return left + right, max(first, second)
    return [WavePanel(low, high, active, values)], missed + error


def _end(panel: WavePanel, time: int, least: float) -> float:
    """K where F is below ``least`` if it falls on as in the panel; twice the panel's end at most.

    Where F falls as exp(-K^2) it is below sooner.
    """
    f = panel.of(time)
    assert f is not None
    quarter = max(1, f.size // 4)
    last, before = (float(np.abs(x).max()) for x in (f[-quarter:], f[-2 * quarter : -quarter]))
    if not 0.0 < last < before:
        return 2.0 * panel.high
    fall = math.log(before / last) / (panel.nodes[-1] - panel.nodes[-1 - quarter])
    more = math.log(max(1.0, last / least)) / fall
    return min(2.0 * panel.high, max(_STEP * panel.high, panel.high + more))


def _rest(panels: list[WavePanel], time: int, scale: float) -> tuple[PowerTail | None, float]:
    """How F goes on beyond the panels, and how much of it is not known there.

    scale : K where its powers begin; infinite where it does not end in powers
    """
    high = panels[-1].high
    k, f = [], []
    for panel in panels:
        values = panel.of(time)
        if values is not None and panel.high > 0.3 * high:
            k.append(panel.nodes)
            f.append(values)
    last = float(np.abs(f[-1]).max())
    if math.isinf(scale):
        return None, float(np.abs(f[-1][-(f[-1].size // 4) - 1 :]).max())
    if high < _POWERS * scale:
        return None, last
    all_k, all_f = np.concatenate(k), np.concatenate(f)
    use = all_k > 0.3 * high
    tail, left = fit_tail(all_k[use], all_f[use], scale)
    # measured: beyond the panels it is worse than where it was judged in a tenth of the cases
    return (tail, 2.0 * left) if left < 0.3 * last else (None, last)
