"""Averages over time, for one initial state, by steps of time.

Distributions and their first moments of the place go from step to step by the rule of `radau`;
steps grow as they become smooth: in a field (`Evolution`), and for driven tracers elsewhere.

With x f and y f, integrated over the place, d_t (x f) = (field + collisions) (x f) + v_x f and the
same for y, all averages of the velocity and the displacement up to second order follow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.drive import Drive
from kinetics.driven import radau
from kinetics.driven.harmonics import Chain, across, along, norms
from kinetics.driven.panels import FASTEST_POWER, Resolution, SpeedPanels, bounces, loss_matrices
from kinetics.driven.speed_range import TAIL_OVER_TOLERANCE, top_speed
from kinetics.driven.starts import FEW, Start
from kinetics.numerics import FloatArray
from kinetics.numerics.blocks import BlockElimination
from kinetics.states.state import State

AVERAGES = (
    *("v_x", "v_y", "v^2", "v^2 cos 2", "v_x v_y", "v^4", "v"),
    *("v_x x", "v_y y", "v_x y + v_y x", "1"),
)
INTEGRALS = {"x": (0, 1.0), "y": (1, 1.0), "collisions": (6, 1.0)}
INTEGRALS |= {"x^2": (7, 2.0), "y^2": (8, 2.0), "x y": (9, 1.0)}
"""What grows over time -> the average that it grows with, and a factor."""
ALL = (*AVERAGES, *INTEGRALS)
_MADE = ((0, 0), (0, len(INTEGRALS)))
SQUARES = frozenset({"x^2", "y^2", "x y"})
_SMOOTH = 64.0  # by which a step may be smoother than is asked before it is doubled
#: Rough steps miss less at their ends, by more than this factor. Origin not recorded.
_STEPS_MISS = 30.0
_SHORTEST = 1e-10  # step, of the last time: below it nothing becomes smoother
SHORTEST_TIME = 1e-12
_ROUNDING = 1e-14  # of averages, term by term: shorter steps do not mend it
_FIRST = 0.5  # of the first step, in free flights of the fastest
_SLOWEST = 0.01  # over the usual speed: from there on densities are right
_MOST_HARMONICS = 40  # in a field: seconds, and 200 MB of memory


class Equation:
    """Takes distributions over one step of time after another.

    chain : what changes the sums of each harmonic at some speeds
    fields : name and family of each: of f, and of x f and y f, of which f is the source. Without
        y f of family 1 it is as x f
    speeds : (size,); averages are sums over them
    rate : of collisions, (size,)
    """

    def __init__(
        self, chain: Chain, fields: list[tuple[str, int]], speeds: FloatArray, rate: FloatArray
    ) -> None:
        self.chain, self.fields, self.speeds = chain, fields, speeds
        self._rate, self._modes = rate, radau.modes()
        self._factors: tuple[float, list[dict[int, BlockElimination]]] = (0.0, [])

    def averages(self, f: FloatArray) -> FloatArray:
        """`AVERAGES` of distributions (n, n_fields, M + 1, size), shape (n, n_averages)."""
        v, v2 = self.speeds, self.speeds**2

        def mean(name: str, family: int, m: int, of: Any) -> Any:
            there = (name, family) in self.fields
            return f[:, self.fields.index((name, family)), m] @ of if there else 0

        moved, alike = mean("x", 0, 1, v), ("y", 1) not in self.fields
        found = [
            *(mean("f", 0, 1, v), mean("f", 1, 1, v), mean("f", 0, 0, v2), mean("f", 0, 2, v2)),
            *(0.5 * mean("f", 1, 2, v2), mean("f", 0, 0, v2**2), mean("f", 0, 0, self._rate)),
            *(moved, moved if alike else mean("y", 1, 1, v)),
            *(mean("y", 0, 1, v) + mean("x", 1, 1, v), mean("f", 0, 0, v**0)),
        ]
        return np.stack([one + np.zeros(len(f)) for one in found], axis=1)

    def step(self, f: FloatArray, h: float, source: FloatArray | None) -> FloatArray:
        """The fields (n_fields, M + 1, size) at all points of a step, (STAGES + 1, *f.shape).

        source : at the stages, (STAGES, *f.shape); None for none
        """
        if h != self._factors[0]:
            used, shifts = {k for _, k in self.fields}, [1.0 / (h * one[0]) for one in self._modes]
            shifts = [z if abs(z.imag) > 1e-12 * abs(z) else z.real for z in shifts]
            self._factors = h, [{k: self.chain.elimination(k, z) for k in used} for z in shifts]
        out = np.zeros((radau.STAGES + 1, *f.shape))
        out[0] = f
        by_mode = zip(self._modes, self._factors[1], strict=True)
        for (value, share, of_source, stages), eliminations in by_mode:
            right = share / (h * value) * f
            if source is not None:
                right = right + np.tensordot(of_source, source, axes=1)
            found: NDArray[np.complexfloating] = np.zeros(f.shape, dtype=complex)
            for k, (name, family) in enumerate(self.fields):
                one = eliminations[family]
                part = slice(one.first, one.last + 1)
                every = right[k]
                if name == "x":
                    every = every + self.speeds * along(found[family], family, self.chain.dimension)
                elif name == "y":
                    from_ = 1 - family
                    every = every + self.speeds * across(found[from_], from_, self.chain.dimension)
                found[k, part] = one.solve(every[part])
            out[1:] += (stages[:, None, None, None] * found).real
        return out


class March:
    """One start over time, step after step.

    times : rising, shape (n_times,)
    resolution, axis : with the ``rtol`` of the steps; of speeds
    asked : names of `ALL` that steps must resolve; others may be less accurate, or 0
    values : `ALL`, shape (n_times, n_averages)
    steps, tries : their number, and that of those that were too long as well
    """

    # then steps are taken as they are: another resolution says that this one fails
    most_steps: ClassVar[int] = 300

    times: FloatArray
    resolution: Any
    axis: Any
    asked: frozenset[str]
    values: FloatArray
    steps: int = 0
    tries: int = 0

    @property
    def _ends(self) -> tuple[float, float]:
        """The first time above 0, and the last."""
        last = max(float(self.times[-1]), SHORTEST_TIME)
        return float(np.min(self.times[self.times > 0.0], initial=last)), last

    def _inside(self, now: float, h: float) -> NDArray[np.bool_]:
        """Which times are in a step, (n_times,): also the last one, but for rounding."""
        return (self.times >= now) & (self.times <= now + h * (1.0 + SHORTEST_TIME))

    def _uncollided(self, times: FloatArray) -> FloatArray | float:
        """What tracers in closed form add to the averages, (n, n_averages)."""
        return 0.0

    def _early(self, now: float, h: float) -> tuple[FloatArray, FloatArray] | None:
        """Their distribution at the points of a step, and what they are a source of."""
        return None

    def _keep(self, now: float, h: float, stages: FloatArray) -> None:
        """What densities need of an accepted step that begins now and is h long."""

    def _slowed(self, equation: Equation, f: Any, now: float, values: Any) -> tuple[Equation, Any]:
        """What goes on after a step; values : `ALL` by now, (1, n_averages)."""
        return equation, f

    def _run(self, equation: Equation, f: FloatArray, fastest: float, steps: int = 1) -> None:
        """From f on, up to the last time; fastest : the highest speed in f; steps : that the first
        one is cut in, at least.
        """
        self.values = np.zeros((self.times.size, len(ALL)))
        # at the first of the times averages may be small, as its fourth power: a step ends there
        now, (first, last) = 0.0, self._ends
        h = min(_FIRST / (1.0 + fastest), first) / steps
        totals, asked = np.zeros(len(INTEGRALS)), _STEPS_MISS * self.resolution.rtol
        grows = [one for one, _ in INTEGRALS.values()]
        factor = np.array([factor for _, factor in INTEGRALS.values()])
        while last - now > SHORTEST_TIME * last:
            self.tries += 1
            h = min(h, last - now)
            early, source = self._early(now, h) or (0.0, None)
            stages = equation.step(f, h, source)
            averages = equation.averages(stages)
            total = averages + self._uncollided(now + h * radau.POINTS)
            grown = totals + h * (radau.integral_rows(radau.POINTS) @ total[:, grows]) * factor
            left = radau.roughness(averages)
            left = np.append(left, h * radau.roughness(total)[grows] * factor)
            rough = self._relative(left[None], np.hstack([total, grown])[-1:])
            lost = np.pad(_ROUNDING * equation.averages(np.abs(stages[-1:])), _MADE)
            # inside a step averages miss all of it, not only what its end misses
            end = (now + h) * (1.0 - SHORTEST_TIME)
            is_interpolated = bool(np.any((self.times > now) & (self.times < end)))
            step_tolerance = self.resolution.rtol if is_interpolated else asked
            allowed = max(step_tolerance, self._relative(lost, np.hstack([total, grown])[-1:]))
            if rough > allowed and self.tries < self.most_steps and h > _SHORTEST * last:
                h *= 0.5
                continue
            inside = self._inside(now, h)
            local = (self.times[inside] - now) / h
            found = radau.rows(local) @ averages + self._uncollided(self.times[inside])
            made = totals + h * (radau.integral_rows(local) @ total[:, grows]) * factor
            self.values[inside] = np.hstack([found, made])
            self._keep(now, h, stages + early)
            self.steps += 1
            now, totals = now + h, grown[-1]
            equation, f = self._slowed(equation, stages[-1], now, np.hstack([total, grown])[-1:])
            smooth = rough * _SMOOTH < allowed or self.tries >= self.most_steps
            if smooth and not now < first < now + 1.99 * h:
                h *= 2.0

    def _relative(self, missed: FloatArray, values: FloatArray) -> float:
        """The largest of what values (n, n_averages) miss, relative to the scale of each."""
        of = {name: np.abs(values[:, i]) for i, name in enumerate(ALL)}
        speed, square = of["v^2"], of["x^2"] + of["y^2"]
        scale = of | dict.fromkeys(("v_x", "v_y"), np.sqrt(speed))
        scale |= dict.fromkeys(("v^2 cos 2", "v_x v_y"), speed)
        scale |= dict.fromkeys(("x", "y"), np.sqrt(square)) | dict.fromkeys(SQUARES, square)
        used = [ALL.index(name) for name in self.asked]
        sizes = np.stack([scale[ALL[i]] for i in used], axis=1)
        there = sizes != 0.0  # also what is not a number, of a solution that overflows
        found = np.abs(missed[:, used])[there] / sizes[there]
        worst = float(np.max(found, initial=0.0))
        return worst if math.isfinite(worst) else math.inf

    def difference(self, coarse: March) -> float:
        """The largest difference from another solution, relative to the scale of each average."""
        return self._relative(self.values - coarse.values, self.values)


@dataclass
class Evolution(March):
    """One start over time in a field, in units of sqrt(g l) and sqrt(l/g).

    Of a start that is a few velocities, those that have not collided are in closed form (`starts`),
    and are the source of the others: so averages over smooth functions are right, however rough the
    density is.
    state : of which the start is made
    keeps_density : whether the density is asked for point by point
    made : beginning, length, and v times what collisions make at the points, of each step; if the
        density is asked for
    """

    law: CollisionLaw
    start: Start
    times: FloatArray
    resolution: Resolution
    asked: frozenset[str]
    state: State
    keeps_density: bool = False
    made: list[tuple[float, float, FloatArray]] = field(init=False, default_factory=list)

    def __post_init__(self) -> None:
        one, (first, last), d = self.resolution, self._ends, self.law.dimension
        drive, tail = (
            Drive(restitution=self.law, dimension=d, field=1.0),
            TAIL_OVER_TOLERANCE * one.rtol,
        )
        highest = top_speed(drive, tail, last, self.start.highest)
        self._lasting = top_speed(drive, tail, last)
        if not self.keeps_density:
            # below 1/t no tracer has collided by the time t, but most may be slower; from rest,
            # before the square root of rtol fewer than that have
            slow = min(max(1.0, 1.0 / last), max(self.start.mean_speed, first, math.sqrt(one.rtol)))
        else:  # densities vary where collisions leave few
            slow = min(1.0, max(_SLOWEST * self.start.mean_speed, first))
        lowest = one.lowest * slow
        self.axis = self.left = SpeedPanels.rising(highest, lowest, one.nodes)
        self.families = 1 if self.start.is_symmetric else 2
        of = ("f", "x", "y") if self.asked & SQUARES else ("f",)
        self._fields = [(name, abs(k - (name == "y"))) for name in of for k in range(self.families)]
        self._loss = loss_matrices(self.axis, self.law, one.harmonics)
        equation = self._equation()
        f = np.zeros((len(self._fields), one.harmonics + 1, self.axis.size))
        if self.start.velocities is None:
            f[: self.families] = self.start.projected(
                self.axis, one.harmonics + 1, self.families, self.state, one.rtol
            )
        self._run(equation, f, self.start.highest, math.ceil(1.0 / one.step))

    def _equation(self) -> Equation:
        """On the panels that are left: no collision makes a tracer faster."""
        v, d, n = self.left.speeds, self.law.dimension, self.left.size
        chain = Chain(d, self._loss[:, :n, :n], self.left.slopes(d), 1.0 / v)
        return Equation(chain, self._fields, v, v)

    def _slowed(self, equation: Equation, f: Any, now: float, values: Any) -> tuple[Equation, Any]:
        """Without the highest panel once fewer tracers are there than above the top at the end."""
        left, tail = self.left, TAIL_OVER_TOLERANCE * self.resolution.rtol
        if left.edges[-2] < self._lasting:
            return equation, f
        fast, velocities = f * (left.speeds > left.edges[-2]), self.start.velocities
        missed = np.pad(equation.averages(fast[None]), _MADE)
        early = 0.0 if velocities is None else velocities.uncollided(now).sum()
        if max(self._relative(missed, values), early) > tail:
            return equation, f
        self.left = SpeedPanels(left.edges[:-1], left.counts[:-1])
        return self._equation(), f[..., : self.left.size]

    @property
    def finer(self) -> Resolution | None:
        """A finer resolution; None where there is none."""
        more = self.resolution.finer()
        return more if more.harmonics <= _MOST_HARMONICS else None

    def _uncollided(self, times: FloatArray) -> FloatArray | float:
        velocities = self.start.velocities
        if velocities is None or not times.size:
            return 0.0
        return np.array([velocities.averages(float(t)) for t in times])

    def _early(self, now: float, h: float) -> tuple[FloatArray, FloatArray] | None:
        velocities = self.start.velocities
        if velocities is None:
            return None
        count = self.resolution.harmonics + 1
        fine_times = now + h * radau.FINE
        sums = velocities.projected(fine_times, self.left, count, self._fields)
        early = radau.projected(sums)
        if velocities.along.size > FEW:
            return early, self._gained(early[1:])
        kept, ratio = self._bounces
        made = velocities.collided(fine_times, self.left, count, self._fields, kept, ratio)
        return early, radau.projected(made)[1:]

    @cached_property
    def _bounces(self) -> tuple[FloatArray, FloatArray]:
        """What each bounce keeps of the harmonics, and the ratio of the speeds."""
        kept, _, log_loss = bounces(self.law, FASTEST_POWER, self.resolution.harmonics)
        return kept, np.exp(-log_loss)

    def _keep(self, now: float, h: float, stages: FloatArray) -> None:
        if self.keeps_density:
            families, of = self.families, norms(stages.shape[2], self.law.dimension)
            volume = of[:families] * self.left.volumes(self.law.dimension)
            made = self._gained(stages[:, :families]) / volume
            every = np.zeros((*made.shape[:-1], self.axis.size))
            every[..., : self.left.size] = made * self.left.speeds
            self.made.append((now, h, every))

    def _gained(self, f: FloatArray) -> FloatArray:
        """What sums (..., M + 1, size) gain by collisions per unit time."""
        n = self.left.size
        return self.left.speeds * f - np.einsum("mij,...mj->...mi", self._loss[:, :n, :n], f)
