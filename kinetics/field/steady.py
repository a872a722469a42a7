"""The steady state in a field, and the dispersion about its drift.

Harmonics of f obey (field + collisions) f = 0 with mass 1; the dispersion follows from the linear
response h to the velocity itself,

    (field + collisions) h = (v_z - u) f,  D_parallel = integral of v_z h,  integral of h = 0

with the drift u, and with v_x f on the right for the direction across. Errors of the speed axis are
seen in relations between averages that hold exactly; errors of the harmonics in what another
continuation beyond the last of them would change.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.field.averages import SteadyAverages
from kinetics.field.collisions import collision_matrices
from kinetics.field.ladder import Chain, Elimination, continuation
from kinetics.field.resolution import SMALL_RATIO, Resolution, smallest_ratio
from kinetics.numerics import FloatArray

_STEEPEST = 70.0  # f falls no faster than v^-70 where it counts
# M is found on few speeds: what another continuation changes hardly depends on them
_COARSE, _COARSER = 1e-4, 1e-3  # the latter for an rtol above 1e-7
_TRIED = (11, 15, 19, 23, 27, 31, 39, 47, 63, 79, 95, 127)
_FALL = 7.0  # what harmonics up to M miss falls about as M^-7, or faster
_ATTEMPTS = 3
_ROUNDING = 1e-13  # what elimination loses
_CAUTION = 2.0  # times what other continuations change: they may agree by accident


def find_steady_state(law: CollisionLaw, rtol: float) -> SteadyState:
    """The steady state with as many harmonics and panels as rtol needs, or with the most tried."""
    harmonics = _harmonics_for(law, rtol)
    resolution = replace(Resolution.first(law, rtol), harmonics=harmonics)
    best = SteadyState(law, resolution)
    for _ in range(_ATTEMPTS - 1):
        if best.speed_error <= rtol:
            break
        resolution = resolution.finer_speeds()
        finer = SteadyState(law, resolution)
        if not finer.speed_error < best.speed_error:
            break
        best = finer
    return best


def _harmonics_for(law: CollisionLaw, rtol: float) -> int:
    """The first M tried that serves rtol, but for those that others show to be too few."""
    coarse = _COARSE if rtol < 1e-7 else _COARSER
    needed = min(2.0 * (1.5 - math.log10(rtol)), 23.0)  # fewer are never enough
    for m in _TRIED[:-1]:
        if m >= needed:
            missed = _harmonics_miss(law, m, coarse)
            if missed <= rtol:
                return m
            needed = max(m + 1.0, m * (missed / rtol) ** (1.0 / _FALL))
    return _TRIED[-1]


def _harmonics_miss(law: CollisionLaw, highest: int, coarse: float) -> float:
    """The error of the harmonics up to M, from a solution on few speeds."""
    return SteadyState(law, Resolution(coarse, highest)).harmonic_error


def find_dispersion(state: SteadyState, allowed: float) -> Dispersion:
    """Both diffusion coefficients; more finely resolved than the state if they need it."""
    found = state.dispersion
    for _ in range(_ATTEMPTS - 1):
        if found.error <= allowed:
            break
        finer = state.resolution.finer_speeds()
        finer = replace(finer, harmonics=finer.harmonics + 8)
        state = SteadyState(state.law, finer)
        found = min(found, state.dispersion, key=lambda dispersion: dispersion.error)
    return found


class Dispersion(NamedTuple):
    """Diffusion about the drift, along and across the field, and the relative error of both."""

    parallel: float
    perpendicular: float
    error: float


class SteadyState:
    """The steady state on given panels and harmonics.

    Parameters
    ----------
    law : the collision law, not elastic
    resolution : panels and harmonics
    """

    def __init__(self, law: CollisionLaw, resolution: Resolution) -> None:
        self.law, self.resolution = law, resolution
        self.panels = resolution.panels(law)
        self.highest = resolution.harmonics
        self.powers, *self.other_powers = resolution.powers(law)
        v = self.panels.speeds
        self._mass = law.unit_surface * v ** (law.dimension - 1.0) * self.panels.weights

    @cached_property
    def _collisions(self) -> FloatArray:
        return collision_matrices(self.panels, self.law, self.highest, True, _STEEPEST)

    @cached_property
    def _along(self) -> Elimination:
        v = self.panels.speeds
        chain = Chain(self.panels, self.law.dimension)
        # a source anywhere, for the border: its factor comes out as 0, to the discretisation
        border = self._mass, v**2 * np.exp(-v)
        return Elimination(chain, self._collisions, self.powers, border=border)

    @cached_property
    def averages(self) -> SteadyAverages:
        """Of the steady state."""
        source = np.zeros((self.highest + 1, self.panels.size))
        return SteadyAverages(self.law, self.panels, self._along.solve(source, 1.0)[0])

    def gained(self, harmonics: FloatArray) -> FloatArray:
        """v times what collisions make per unit time, of the shape of f_m, (M + 1, size)."""
        lost = np.einsum("mij,mj->mi", self._collisions, harmonics)
        return np.asarray(self.panels.speeds**2 * harmonics - lost)

    @property
    def speed_error(self) -> float:
        """The largest defect of an exact relation."""
        found = dict(self.averages.defects)
        if smallest_ratio(self.law) < SMALL_RATIO:
            found.pop("<cos/v^2>", None)
        return max(_ROUNDING, *(abs(defect) for defect in found.values()))

    @property
    def error(self) -> float:
        """Relative error of the averages."""
        return max(self.speed_error, self.harmonic_error)

    @cached_property
    def harmonic_error(self) -> float:
        """By how much other continuations change the figures, relative to each."""
        f = self.averages.harmonics
        figures = np.abs(self.averages.figures)
        changes = (self._along.other_continuation(f, other) for other in self.other_powers)
        moved = [SteadyAverages(self.law, self.panels, change).figures for change in changes]
        return _CAUTION * float(np.max(np.abs(moved) / figures))

    @cached_property
    def dispersion(self) -> Dispersion:
        """Diffusion along and across the field."""
        parallel, first = self._response(0)
        across, second = self._response(1)
        return Dispersion(parallel, across, max(first, second))

    def _response(self, family: int) -> tuple[float, float]:
        """D along (family 0) or across the field (1), and its relative error."""
        v, d = self.panels.speeds, self.law.dimension
        f = self.averages.harmonics
        last, before = continuation(self.highest + 1.0, self.highest, self.powers)
        f = np.vstack([f, last * f[-1] + before * f[-2]])
        chain = self._along.chain if family == 0 else Chain(self.panels, d, 1)
        top = chain.highest(self.highest)
        source = np.zeros((top + 1 - family, v.size))
        drift = self.averages.moment(1.0, 1)
        for m in range(family, top + 1):
            if family == 0:
                source[m] = chain.up(m) * v * f[m + 1] - drift * f[m]
                source[m] += chain.down(m) * v * f[m - 1] if m else 0.0
            elif d == 2:
                source[m - 1] = 0.5 * v * ((2.0 if m == 1 else 1.0) * f[m - 1] - f[m + 1])
            else:
                source[m - 1] = v * (f[m - 1] / (2.0 * m - 1.0) - f[m + 1] / (2.0 * m + 3.0))
        if family == 0:
            elimination = self._along
        else:
            elimination = Elimination(chain, self._collisions, self.powers)
        h = elimination.solve(source * v)[0]
        value = self._first_harmonic(h, 1.0, family)
        changes = (elimination.other_continuation(h, other) for other in self.other_powers)
        moved = [abs(self._first_harmonic(change, 1.0, family)) for change in changes]
        error = _CAUTION * max(moved) / abs(value)
        return value, max(error, abs(self._response_defect(h, family)))

    def _first_harmonic(self, h: FloatArray, p: float, family: int) -> float:
        """Integral of v^(p-1) v_z h, or v^(p-1) v_x h for family 1."""
        d = self.law.dimension
        return float((self._mass * self.panels.speeds**p) @ h[1 - family]) / d

    def _response_defect(self, h: FloatArray, family: int) -> float:
        """By how much an exact relation between averages over h is missed.

        The moment v^2 of row 0, or v_x of row 1: lambda(2) <v^3>_h - 2 D_parallel =
        <v^2 v_z> - u <v^2>, and lambda_1(1) <v v_x>_h = <v_x^2>.
        """
        law, v, moment = self.law, self.panels.speeds, self.averages.moment
        if family == 0:
            third = float(law.decay_rate(2.0)) * float((self._mass * v**3) @ h[0])
            drift = moment(1.0, 1)
            right = moment(3.0, 1) - drift * moment(2.0, 0)
            return (third - right) / (2.0 * self._first_harmonic(h, 1.0, 0)) - 1.0
        second, turned, d = moment(2.0, 0), moment(2.0, 2), law.dimension
        left = float(law.harmonic_decay_rate(1.0, 1)) * self._first_harmonic(h, 2.0, 1)
        return left * d / (second - turned) - 1.0
