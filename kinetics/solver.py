"""What answers a scene: the parts that its outputs need and no other, their errors, and the plan.

Without a field or a drive it is an :class:`Answer`; else :class:`kinetics.field.scene.FieldScene`
or :class:`kinetics.driven.scene.DrivenScene`, which have `values`, `errors`, `verdict`, `plan`,
`stats`, `typical_speed` and the densities of the velocity under the same names. With drag alone it
is a :class:`Slowed` one.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.densities import harmonic
from kinetics.densities.harmonic import HarmonicProblem, Profile
from kinetics.errors import InputError, PlanStep, SolverStatus, judged, warn_missed
from kinetics.moments import averages as averaged
from kinetics.moments.averages import Averages, Part
from kinetics.moments.backward import Observable, speed_power
from kinetics.numerics import FloatArray
from kinetics.outputs import (
    COLLISIONS,
    DENSITIES,
    DISPLACEMENT,
    OUTPUTS,
    POSITION,
    SCATTERING,
    VELOCITY,
    described,
)
from kinetics.position.density import Displacement
from kinetics.position.sweep import solve_displacement
from kinetics.results import Value
from kinetics.scene import Scene
from kinetics.validation import refuse

START = "initial state"  # its name in errors and in the plan
_LEFT = 1e-13  # relative: what sums over the initial state and up the panels may leave
_BEST_DENSITY = 1e-8  # of G(R): more takes wave numbers that cost minutes
_MOST_NODES = 48  # of a panel: still more only add rounding


def answer_to(scene: Scene, rtol: float, method: str | None, nodes: int | None) -> Any:
    """The answer to a scene, of any kind; the arguments are those of `kinetics.solve`."""
    if scene.system is not None:
        if scene.system.only_slows and "displacement_tensor" not in scene.outputs:
            return Slowed.of(scene, rtol, method, nodes)
        from kinetics.driven.scene import DrivenScene

        system = scene.system.scaled(scene.mean_free_path)
        return DrivenScene(*scene.problem, scene.field, scene.outputs, rtol, system)
    if scene.field:
        from kinetics.field.scene import FieldScene

        return FieldScene(*scene.problem, scene.field, scene.outputs, rtol)
    return Answer(scene, rtol, method, nodes)


@dataclass(frozen=True)
class Answer(Value):
    """The answer to a scene without a field; each part is solved when it is asked for.

    scene, rtol, method, nodes : as `kinetics.solve` takes them
    """

    scene: Scene
    rtol: float
    method: str | None
    nodes: int | None

    def __getstate__(self) -> dict[str, Any]:
        return {name: part for name, part in vars(self).items() if name != "averages"}

    @property
    def _parts(self) -> dict[str, tuple[Part, ...]]:
        """Output -> the observables that it is made of."""
        outputs, dimension = sorted(self.scene.outputs), self.scene.dimension
        return {name: averaged.parts_of(name, dimension) for name in outputs}

    @property
    def _steps(self) -> set[str]:
        """The steps of the plan that the outputs need."""
        return {OUTPUTS[name].step for name in self.scene.outputs}

    def _observables(self, step: str) -> set[Observable]:
        """What the outputs of one step are made of."""
        found = (made for name, made in self._parts.items() if OUTPUTS[name].step == step)
        return {y for made in found for _, y, _ in made}

    # -- averages ---------------------------------------------------------------------------------

    @cached_property
    def averages(self) -> Averages:
        """The averages over the tracers, with enough nodes for the outputs."""
        degree = max([2.0, *(y.degree for y in self._observables(VELOCITY))])
        asked = Averages(*self.scene.problem, self.rtol, degree)
        return _with_enough_nodes(asked, self._parts.values())

    @property
    def values(self) -> dict[str, FloatArray]:
        """Every output that is an array, in the order of the table; InputError on overflow."""
        found: dict[str, FloatArray] = {}
        parts = self._parts
        for name, row in OUTPUTS.items():
            if parts.get(name):
                with np.errstate(over="ignore", invalid="ignore"):
                    made = getattr(averaged, name)(self.averages)
                arrays = made if isinstance(made, tuple) else (made,)
                found |= {n: _in_range(n, a) for n, a in zip(row.names, arrays, strict=True)}
        return found

    @property
    def typical_speed(self) -> FloatArray:
        """Of the order of the thermal speed, in U, shape (n_times,)."""
        return np.asarray(np.exp(self.averages.log_reference))

    def power(self, p: Any, m: Any) -> NDArray[Any]:
        """<v^p exp(-i m phi)> in U^p, shape (n_times,), complex for m > 0.

        InputError where it does not exist; warns where the error estimate exceeds rtol.
        """
        p, m = averaged.moment_arguments(self.scene.law, self.scene.state, p, m)
        needed = [(Part(1.0, speed_power(p, m), m),)]
        averages = Averages(*self.scene.problem, self.rtol, p, p, harmonic=max(m, 2))
        averages = _with_enough_nodes(averages, needed)
        error = max(_error_of(averages, needed), averages.start_error({0, m}))
        if error > self.rtol:
            warn_missed(f"<v^{p:g}>", error, self.rtol)
        with np.errstate(under="ignore", over="ignore", invalid="ignore"):
            found = averages.power(p, m) * np.exp(p * averages.log_reference)
        return _in_range(f"<v^{p:g}>", found)

    # -- densities of the velocity ----------------------------------------------------------------

    @cached_property
    def profiles(self) -> Mapping[int, Profile]:
        """The harmonics of the velocity distribution that the outputs need."""
        if DENSITIES not in self._steps:
            return {}
        highest = 0
        if "velocity_density" in self.scene.outputs:
            there = self.scene.state.highest_harmonic
            highest = self.scene.harmonics if there is None else min(there, self.scene.harmonics)
        found = {m: self._profile(m) for m in range(highest + 1)}
        return {m: profile for m, profile in found.items() if profile is not None}

    def _profile(self, m: int) -> Profile | None:
        """Harmonic m by the method asked for, or the best; None where the start makes it zero."""
        law, path, state, times = self.scene.problem
        if state.harmonic(m, self.rtol) is None:
            return None
        asked = HarmonicProblem(law, path, state, m, times, self.rtol, self.nodes)
        if law.is_elastic:
            return harmonic.elastic_profile(asked)
        if self.method != "conservative" and (state.smooth or self.method == "spectral"):
            from kinetics.densities.spectral import solve_spectral

            profile = solve_spectral(asked)
            if profile is not None:
                return profile
            if self.method == "spectral":
                allowed = "this initial state is too rough for it, use 'conservative'"
                refuse("method", self.method, allowed)
        from kinetics.densities.conservative import solve_conservative

        return solve_conservative(asked)

    @property
    def uncollided(self) -> FloatArray:
        """Share of tracers in the delta peak of a start of one speed, shape (n_times,)."""
        peak = self.profiles[0].peak_weight
        return np.zeros(self.averages.times.shape) if peak is None else np.asarray(peak.real)

    def speed_density(self, v: FloatArray) -> FloatArray:
        """In 1/U at all times, shape (n_times, n_v)."""
        return np.asarray(self.profiles[0].continuous(v).real)

    def component_density(self, v_x: FloatArray) -> FloatArray:
        """Of one component of the velocity in 1/U at all times, shape (n_times, n)."""
        speed, d = self.typical_speed, self.scene.dimension
        return harmonic.component_densities(self.profiles[0], np.abs(v_x), speed, d)

    def velocity_density(self, v: FloatArray, phi: FloatArray) -> FloatArray:
        """In U^-d at all times, shape (n_times, n_v, n_phi)."""
        law = self.scene.law
        out = np.zeros((self.averages.times.size, v.size, phi.size))
        for m, profile in self.profiles.items():
            turn = harmonic.angular_function(m, phi, law.dimension)
            out += (profile.continuous(v)[:, :, None] * turn).real
        return out / (law.unit_surface * v[:, None] ** (law.dimension - 1))

    # -- the displacement -------------------------------------------------------------------------

    @cached_property
    def displacement(self) -> Displacement | None:
        """The distribution of the displacement, if an output needs it."""
        if POSITION not in self._steps:
            return None
        # the same for every rtol, as the wave numbers depend on it
        own = replace(self.averages, rtol=min(self.rtol, _BEST_DENSITY), nodes=None)
        root = _in_range("msd", averaged.root_mean_square(own))
        rtol = 0.4 * max(self.rtol, _BEST_DENSITY)  # the rest is for its transform
        return solve_displacement(*self.scene.problem, root, rtol)

    # -- how it was done --------------------------------------------------------------------------

    @cached_property
    def errors(self) -> dict[str, float]:
        """Part of the result -> its error estimate."""
        averages = _error_of(self.averages, self._parts.values())
        found = {"averages": averages, START: self._start_error}
        if self.profiles:
            found[DENSITIES] = max(one.error_estimate for one in self.profiles.values())
        if self.displacement is not None:
            found[POSITION] = self.displacement.error_estimate
        return found

    @property
    def _start_error(self) -> float:
        """Of the harmonics of the start that the outputs need."""
        harmonics = {part.start for parts in self._parts.values() for part in parts}
        return self.averages.start_error({0, *harmonics, *self.profiles})

    @property
    def verdict(self) -> tuple[SolverStatus, str]:
        """The status and the message, which also says where the theory is not to be trusted."""
        allowed = dict.fromkeys(("averages", START, DENSITIES), self.rtol)
        allowed[POSITION] = max(self.rtol, _BEST_DENSITY)
        status, message = judged(self.errors, allowed, self.nodes if self.profiles else None)
        if (medium := self.averages.law.medium) is not None:
            message += medium.limits(bool(self.profiles), self.displacement is not None)
        return status, message

    @property
    def plan(self) -> tuple[PlanStep, ...]:
        """What was solved, what was skipped, and why."""
        averages, profiles, flights = self.averages, self.profiles, self.displacement
        chain = self._observables(DISPLACEMENT)
        powers = sorted((y.degree, y.harmonic) for y in self._observables(VELOCITY))
        moments = ", ".join(f"v^{p:g}" + (f" (m = {m})" if m else "") for p, m in powers)
        harmonics = sorted({m for _, m in powers} | set(profiles))
        isotropic = averages.state.highest_harmonic == 0
        enough = "the start is isotropic" if isotropic else "no output needs more"
        methods = sorted({one.method for one in profiles.values()})
        kept = "elastic: speeds are kept, harmonics relax at their own rates"
        reasons = {
            VELOCITY: kept if averages.law.is_elastic else f"backward equation for {moments}",
            START: f"{averages.speeds.x.size} weighted speeds represent it",
            COLLISIONS: "asked for",
            DISPLACEMENT: f"{len(chain)} scalar equations and what drives them",
            POSITION: f"{flights.wave_numbers if flights else 0} wave numbers",
            SCATTERING: "solved for the wave numbers that are asked for",
            "angular harmonics": f"m = {harmonics}: {enough}",
            DENSITIES: f"{len(profiles)} harmonics, {', '.join(methods)}",
        }
        asked = self._steps | {START} | ({"angular harmonics"} if harmonics else set())
        steps = [
            PlanStep(part, part in asked and why != kept, why if part in asked else "not asked for")
            for part, why in reasons.items()
        ]
        medium = averages.law.medium
        again = [PlanStep("scatterers met again", True, medium.level)] if medium else []
        return (*again, *steps)

    @property
    def stats(self) -> dict[str, Any]:
        """Numbers about the work: points of the initial state, panels, nodes, wave numbers."""
        averages, flights = self.averages, self.displacement
        stats: dict[str, Any] = {"initial_points": int(averages.speeds.x.size)}
        if not averages.law.is_elastic:
            stats["panels"] = averages.equation.count
            stats["nodes_per_panel"] = averages.equation.nodes
        stats |= {f"density_nodes_m{m}": one.nodes for m, one in self.profiles.items()}
        if flights is not None:
            stats["wave_numbers"] = flights.wave_numbers
            stats["position_density_error"] = flights.error_estimate
            # how many systems of so many equations were solved for F(k)
            stats["systems"] = {str(size): count for size, count in flights.systems.items()}
        return stats


@dataclass(frozen=True)
class Slowed(Answer):
    """The answer to a scene with drag alone: its tracers take the paths of those without drag.

    With v = exp(-gamma t) u, u goes on without drag in the time (1 - exp(-gamma t))/gamma.

    scene : that without drag, at these times
    drag, real_times : gamma in U/d, and t in d/U
    """

    drag: float
    real_times: FloatArray

    @classmethod
    def of(cls, scene: Scene, rtol: float, method: str | None, nodes: int | None) -> Slowed:
        """The answer to this scene; the arguments are those of `kinetics.solve`."""
        times, drag = np.asarray(scene.times), scene.drag
        free = replace(scene, drag=0.0, times=-np.expm1(-drag * times) / drag)
        return cls(free, rtol, method, nodes, drag, times)

    @property
    def _slower(self) -> FloatArray:
        """v over u, shape (n_times,)."""
        return np.asarray(np.exp(-self.drag * self.real_times))

    @property
    def values(self) -> dict[str, FloatArray]:
        """Every output that is an array, as without drag."""
        found, slower, free = super().values, self._slower, np.asarray(self.scene.times)
        powers = {"U": 1, "d U": 1, "U^2": 2, "m U^2": 2}
        for name, array in found.items():
            power = powers.get(described(name, self.scene.dimension)[0], 0)
            found[name] = (array.T * slower**power).T
        if "msd_slope" in found:
            ratio = np.divide(self.real_times, free, out=np.ones(free.shape), where=free > 0.0)
            found["msd_slope"] *= ratio * slower
        return found

    @property
    def typical_speed(self) -> FloatArray:
        """Of the order of the thermal speed, in U, shape (n_times,)."""
        return super().typical_speed * self._slower

    @property
    def plan(self) -> tuple[PlanStep, ...]:
        """As without drag."""
        why = "the paths are those without drag, in the time (1 - exp(-drag t))/drag"
        return (PlanStep("drag", True, why), *super().plan)

    def _each(self, density: Any, n: int, v: FloatArray, *more: Any) -> FloatArray:
        """A density of n components of u, one time after another, as that of v."""
        with np.errstate(all="ignore"):  # at late times all of it is at rest
            found = [density(v / x, *more)[i] / x**n for i, x in enumerate(self._slower)]
        return np.nan_to_num(np.array(found), nan=0.0, posinf=math.inf)

    def speed_density(self, v: FloatArray) -> FloatArray:
        """In 1/U at all times, shape (n_times, n_v)."""
        return self._each(super().speed_density, 1, v)

    def velocity_density(self, v: FloatArray, phi: FloatArray) -> FloatArray:
        """In U^-d at all times, shape (n_times, n_v, n_phi)."""
        return self._each(super().velocity_density, self.scene.dimension, v, phi)


def _error_of(averages: Averages, needed: Collection[tuple[Part, ...]]) -> float:
    """The largest relative error estimate of the outputs that are made of these parts."""
    found = [_LEFT]
    for made in needed:
        # a part that the initial state makes zero has no error
        there = [part for part in made if averages.measure(part.start) is not None]
        found.append(sum(part.factor * averages.error_estimate(part.observable) for part in there))
    return max(found)


def _with_enough_nodes(averages: Averages, needed: Collection[tuple[Part, ...]]) -> Averages:
    """The averages with as many nodes of a panel as the outputs need, by their error estimates."""
    for _ in range(4):
        missing = _error_of(averages, needed) / averages.rtol
        if not 1.0 < missing < math.inf:
            break
        nodes = averages.equation.nodes + 1 + math.ceil(math.log10(missing))
        averages = averages.with_nodes(min(nodes, _MOST_NODES))
    return averages


def _in_range(name: str, value: NDArray[Any]) -> NDArray[Any]:
    """The value; InputError where it is beyond the largest number of double precision."""
    if not np.all(np.isfinite(value)):
        raise InputError(f"times: {name} overflows there; ask for other times, speeds or powers")
    return value
