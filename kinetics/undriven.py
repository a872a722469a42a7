"""Answers for tracers that only collide: the parts that the outputs need, and no other.

Averages come from the backward equation (`kinetics.moments`), densities of the velocity from one
equation for each angular harmonic (`kinetics.densities`), the distribution of the displacement from
its Fourier transform (`kinetics.position`). Tracers with drag take the paths of those without, in
another time (`SlowedAnswer`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.densities.elastic import elastic_profile
from kinetics.densities.harmonic import HarmonicProblem, Profile, angular_function
from kinetics.densities.velocity_component import component_densities
from kinetics.errors import InputError, PlanStep, SolverStatus, judge_errors, warn_missed
from kinetics.model_error import model_errors
from kinetics.moments.averages import Averages, PowerRange, check_moment
from kinetics.moments.observables import Observable, speed_power
from kinetics.moments.outputs import (
    AveragedOutput,
    Ingredient,
    averaged_outputs,
    root_mean_square_displacement,
)
from kinetics.numerics import FloatArray
from kinetics.outputs import (
    AVERAGES,
    COLLISIONS,
    DENSITIES,
    DISPLACEMENT,
    INITIAL_STATE,
    OUTPUTS,
    POSITION,
    SCATTERING,
    VELOCITY,
    described,
)
from kinetics.position.density import Displacement
from kinetics.position.sweep import solve_displacement
from kinetics.results.value import Value
from kinetics.scene import Scene
from kinetics.validation import refuse

#: Least relative error that is stated of averages: sums over the initial state, and from panel to
#: panel, leave rounding of this size. Chosen: some hundred roundings.
ROUNDING_OF_AVERAGES = 1e-13
#: Least error of G(R) that is aimed at: for less, wave numbers are needed that take minutes.
MIN_ERROR_OF_POSITION_DENSITY = 1e-8
#: Averages are prepared for angular harmonics up to this one at least, that of the tensors.
LEAST_HARMONIC = 2
#: Most Chebyshev nodes of a panel of the backward equation: more only add rounding.
MAX_NODES = 48
#: Most re-solves of averages with more nodes; one is usual.
MAX_REFINEMENTS = 4
#: With how many powers of the speed at that time outputs with drag go, by their unit.
POWER_OF_SPEED = {"1": 0, "d": 0, "d^2": 0, "U": 1, "d U": 1, "U^2": 2, "m U^2": 2}
#: Why the plan calls moments of the velocity skipped if e = 1.
KEPT_SPEEDS = "elastic: speeds are kept, harmonics relax at their own rates"


@dataclass(frozen=True, eq=False, repr=False)
class UndrivenAnswer(Value):
    """The answer to a scene without field or drive; each part is solved when it is needed.

    Its members are those of :class:`kinetics.answer.Answer`, and what only undriven tracers have.

    Parameters
    ----------
    scene, rtol, method, nodes : as :func:`kinetics.solve` takes them
    """

    scene: Scene
    rtol: float
    method: str | None
    nodes: int | None

    @classmethod
    def _is_cache(cls, name: str) -> bool:
        """Return whether a part is left out of a pickled answer: densities are kept there."""
        return name in ("averages", "_averaged")

    @cached_property
    def _averaged(self) -> Mapping[str, AveragedOutput]:
        """The outputs that are made of averages, by name."""
        table = averaged_outputs(self.scene.dimension)
        return {name: table[name] for name in sorted(self.scene.outputs) if name in table}

    @property
    def _ingredients(self) -> list[tuple[Ingredient, ...]]:
        """The averages that each of these outputs is made of."""
        return [output.ingredients for output in self._averaged.values()]

    @property
    def _steps(self) -> set[str]:
        """The steps of the plan that the outputs need."""
        return {OUTPUTS[name].step for name in self.scene.outputs}

    def _observables(self, step: str) -> set[Observable]:
        """Return the observables that the outputs of one step of the plan are made of."""
        observables: set[Observable] = set()
        for name, output in self._averaged.items():
            if OUTPUTS[name].step == step:
                observables.update(ingredient.observable for ingredient in output.ingredients)
        return observables

    # -- averages ---------------------------------------------------------------------------------

    @cached_property
    def averages(self) -> Averages:
        """The averages over the tracers, with enough nodes for the outputs."""
        powers = [observable.degree for observable in self._observables(VELOCITY)]
        largest = PowerRange(highest=max([2.0, *powers]))
        averages = Averages.over(*self.scene.problem, self.rtol, largest)
        return _with_enough_nodes(averages, self._ingredients)

    @property
    def values(self) -> dict[str, FloatArray]:
        """Every output that is an array, in the order of the table; InputError on overflow."""
        values: dict[str, FloatArray] = {}
        for name, output in OUTPUTS.items():
            if name not in self._averaged:
                continue
            functions = self._averaged[name].functions
            for array_name, function in zip(output.names, functions, strict=True):
                with np.errstate(over="ignore", invalid="ignore"):
                    array = function(self.averages)
                values[array_name] = _in_range(array_name, array)
        return values

    @property
    def typical_speed(self) -> FloatArray:
        """A speed of the order of the thermal one in U, shape (n_times,)."""
        return np.asarray(np.exp(self.averages.log_reference))

    def power(self, p: Any, m: Any) -> NDArray[Any]:
        """Return <v^p exp(-i m phi)> in U^p, shape (n_times,), complex for m > 0.

        InputError where it does not exist; warns where the error estimate exceeds rtol.
        """
        p, m = check_moment(self.scene.law, self.scene.state, p, m)
        ingredients = [(Ingredient(speed_power(p, m)),)]
        powers = PowerRange(lowest=p, highest=p, harmonic=max(m, LEAST_HARMONIC))
        name = f"<v^{p:g}>"
        # negative powers of speeds near 0 may overflow: these are refused
        with np.errstate(under="ignore", over="ignore", invalid="ignore"):
            averages = Averages.over(*self.scene.problem, self.rtol, powers)
            averages = _with_enough_nodes(averages, ingredients)
            error = max(_error_of(averages, ingredients), averages.start.error({0, m}))
            moments = averages.power(p, m) * np.exp(p * averages.log_reference)
        moments = _in_range(name, moments)
        if error > self.rtol:
            warn_missed(name, error, self.rtol)
        return moments

    # -- densities of the velocity ----------------------------------------------------------------

    @cached_property
    def profiles(self) -> Mapping[int, Profile]:
        """The angular harmonics of the velocity distribution that the outputs need, by m."""
        if DENSITIES not in self._steps:
            return {}
        profiles = {}
        for m in range(self._highest_harmonic + 1):
            profile = self._solve_harmonic(m)
            if profile is not None:
                profiles[m] = profile
        return profiles

    @property
    def _highest_harmonic(self) -> int:
        """The highest angular harmonic of the velocity distribution that the outputs need."""
        if "velocity_density" not in self.scene.outputs:
            return 0
        of_state = self.scene.state.highest_harmonic
        if of_state is None:
            return self.scene.harmonics
        return min(of_state, self.scene.harmonics)

    def _solve_harmonic(self, m: int) -> Profile | None:
        """Solve for harmonic m by the requested or the best method; None if the start has none."""
        law, path, state, times = self.scene.problem
        if state.harmonic(m, self.rtol) is None:
            return None
        problem = HarmonicProblem(law, path, state, m, times, self.rtol, self.nodes)
        if law.is_elastic:
            return elastic_profile(problem)
        is_spectral_requested = self.method == "spectral"
        if is_spectral_requested or (self.method is None and state.smooth):
            from kinetics.densities.spectral import solve_spectral

            profile = solve_spectral(problem)
            if profile is not None:
                return profile
            if is_spectral_requested:
                allowed = "this initial state is too rough for it, use 'conservative'"
                refuse("method", self.method, allowed)
        from kinetics.densities.conservative import solve_conservative

        return solve_conservative(problem)

    @property
    def uncollided(self) -> FloatArray:
        """The share of tracers in the delta peaks of a start of sharp speeds, shape (n_times,)."""
        peak_weight = self.profiles[0].peak_weight
        if peak_weight is None:
            return np.zeros(self.averages.times.shape)
        return np.asarray(peak_weight.real)

    @property
    def captured(self) -> FloatArray:
        """No tracer sticks: zeros, shape (n_times,)."""
        return np.zeros(self.averages.times.shape)

    def speed_density(self, v: FloatArray) -> FloatArray:
        """Density of the speed in 1/U at speeds v (n_v,), shape (n_times, n_v)."""
        return np.asarray(self.profiles[0].continuous(v).real)

    def component_density(self, v_x: FloatArray) -> FloatArray:
        """Density of one component of the velocity in 1/U, shape (n_times, n)."""
        isotropic_part = self.profiles[0]
        return component_densities(
            isotropic_part, np.abs(v_x), self.typical_speed, self.scene.dimension
        )

    def velocity_density(self, v: FloatArray, phi: FloatArray) -> FloatArray:
        """Density of the velocity in U^-d, shape (n_times, n_v, n_phi)."""
        law = self.scene.law
        density = np.zeros((self.averages.times.size, v.size, phi.size))
        for m, profile in self.profiles.items():
            by_angle = angular_function(m, phi, law.dimension)
            density += (profile.continuous(v)[:, :, None] * by_angle).real
        return density / (law.unit_surface * v[:, None] ** (law.dimension - 1))

    # -- the displacement -------------------------------------------------------------------------

    @cached_property
    def displacement(self) -> Displacement | None:
        """The distribution of the displacement; None if no output needs it."""
        if POSITION not in self._steps:
            return None
        tolerance = max(self.rtol, MIN_ERROR_OF_POSITION_DENSITY)
        # wave numbers follow from <r^2>: the same for all rtol above, and whatever nodes are given
        averages_rtol = min(self.rtol, MIN_ERROR_OF_POSITION_DENSITY)
        averages = Averages.over(*self.scene.problem, averages_rtol, self.averages.powers)
        root_mean_square = _in_range("msd", root_mean_square_displacement(averages))
        return solve_displacement(*self.scene.problem, root_mean_square, tolerance)

    # -- how it was done --------------------------------------------------------------------------

    @cached_property
    def errors(self) -> dict[str, float]:
        """Error estimates, by part of the result."""
        errors = {
            AVERAGES: _error_of(self.averages, self._ingredients),
            INITIAL_STATE: self._start_error,
        }
        if self.profiles:
            estimates = [profile.error_estimate for profile in self.profiles.values()]
            errors[DENSITIES] = float(np.max(estimates))  # keeps what is not a number
        if self.displacement is not None:
            errors[POSITION] = self.displacement.error_estimate
        return errors

    @property
    def _start_error(self) -> float:
        """The relative error of the harmonics of the initial state that the outputs need."""
        harmonics = {0, *self.profiles}
        for ingredients in self._ingredients:
            harmonics.update(ingredient.averaged_over for ingredient in ingredients)
        return self.averages.start.error(harmonics)

    @property
    def verdict(self) -> tuple[SolverStatus, str]:
        """The status and the message, which also says where the theory is not to be trusted."""
        tolerance = {
            AVERAGES: self.rtol,
            INITIAL_STATE: self.rtol,
            DENSITIES: self.rtol,
            POSITION: max(self.rtol, MIN_ERROR_OF_POSITION_DENSITY),
        }
        nodes = self.nodes if self.profiles else None
        status, message = judge_errors(self.errors, tolerance, nodes)
        medium = self.averages.law.medium
        if medium is not None:
            names = []
            if self.profiles:
                names.append("speed_density")
            if self.displacement is not None:
                names.append("position_density")
            errors = model_errors(self.scene, names)
            largest = {name: float(error.max()) for name, error in errors.items()}
            message += medium.limits(largest)
        return status, message

    @property
    def plan(self) -> tuple[PlanStep, ...]:
        """What was solved, what was skipped, and why."""
        needed = self._steps | {INITIAL_STATE}
        if self._harmonics_solved:
            needed.add("angular harmonics")
        steps = []
        medium = self.averages.law.medium
        if medium is not None:
            steps.append(PlanStep("scatterers met again", True, medium.level))
        for name, reason in self._reasons().items():
            if name in needed:
                steps.append(PlanStep(name, reason != KEPT_SPEEDS, reason))
            else:
                steps.append(PlanStep(name, False, "not asked for"))
        return tuple(steps)

    @property
    def _harmonics_solved(self) -> list[int]:
        """The angular harmonics that any part solves, rising."""
        of_moments = {observable.harmonic for observable in self._observables(VELOCITY)}
        return sorted(of_moments | set(self.profiles))

    def _reasons(self) -> dict[str, str]:
        """Return what each step of the plan is, or would be, in words."""
        averages = self.averages
        velocity = KEPT_SPEEDS
        if not averages.law.is_elastic:
            velocity = f"backward equation for {self._moment_names()}"
        is_isotropic = averages.state.highest_harmonic == 0
        enough = "the start is isotropic" if is_isotropic else "no output needs more"
        methods = sorted({profile.method for profile in self.profiles.values()})
        n_equations = len(self._observables(DISPLACEMENT))
        n_wave_numbers = self.displacement.wave_numbers if self.displacement else 0
        return {
            VELOCITY: velocity,
            INITIAL_STATE: f"{averages.start.speeds.x.size} weighted speeds represent it",
            COLLISIONS: "asked for",
            DISPLACEMENT: f"{n_equations} scalar equations and what drives them",
            POSITION: f"{n_wave_numbers} wave numbers",
            SCATTERING: "solved for the wave numbers that are asked for",
            "angular harmonics": f"m = {self._harmonics_solved}: {enough}",
            DENSITIES: f"{len(self.profiles)} harmonics, {', '.join(methods)}",
        }

    def _moment_names(self) -> str:
        """Return the moments of the velocity that are solved, in words: "v^2, v^2 (m = 2)"."""
        observables = self._observables(VELOCITY)
        names = []
        for degree, m in sorted((each.degree, each.harmonic) for each in observables):
            names.append(f"v^{degree:g} (m = {m})" if m else f"v^{degree:g}")
        return ", ".join(names)

    @property
    def stats(self) -> dict[str, Any]:
        """Numbers about the work: points of the initial state, panels, nodes, wave numbers."""
        averages = self.averages
        stats: dict[str, Any] = {"initial_points": int(averages.start.speeds.x.size)}
        if not averages.law.is_elastic:
            stats["panels"] = averages.equation.n_panels
            stats["nodes_per_panel"] = averages.equation.nodes
        for m, profile in self.profiles.items():
            stats[f"density_nodes_m{m}"] = profile.nodes
        displacement = self.displacement
        if displacement is not None:
            stats["wave_numbers"] = displacement.wave_numbers
            stats["position_density_error"] = displacement.error_estimate
            # how many systems of so many equations were solved for F(k)
            systems = displacement.systems.items()
            stats["systems"] = {str(n_equations): count for n_equations, count in systems}
        return stats


@dataclass(frozen=True)
class SlowedAnswer:
    """The answer to a scene with drag alone, from that of a scene without.

    With v = exp(-gamma t) u, u goes on without drag in the time (1 - exp(-gamma t))/gamma: the
    paths are the same. Its members are those of :class:`kinetics.answer.Answer`.

    Parameters
    ----------
    undragged : the answer without drag, at the times (1 - exp(-gamma t))/gamma
    drag : gamma in U/d
    times : t in d/U, shape (n_times,)
    """

    undragged: UndrivenAnswer
    drag: float
    times: FloatArray

    @classmethod
    def of(cls, scene: Scene, rtol: float, method: str | None, nodes: int | None) -> SlowedAnswer:
        """Return the answer to a scene with drag; the arguments are those of `kinetics.solve`."""
        times = np.asarray(scene.times)
        undragged_times = -np.expm1(-scene.drag * times) / scene.drag
        undragged = replace(scene, drag=0.0, times=undragged_times)
        return cls(UndrivenAnswer(undragged, rtol, method, nodes), scene.drag, times)

    @property
    def _slowing(self) -> FloatArray:
        """v/u = exp(-gamma t), shape (n_times,)."""
        return np.asarray(np.exp(-self.drag * self.times))

    @property
    def values(self) -> dict[str, FloatArray]:
        """Every output that is an array."""
        scene = self.undragged.scene
        values = self.undragged.values
        for name, array in values.items():
            unit, _, _ = described(name, scene.dimension)
            factor = self._slowing ** POWER_OF_SPEED[unit]
            values[name] = (array.T * factor).T
        if "msd_slope" in values:
            # d/d ln t from d/d ln t', t' the time without drag; both are t at t = 0
            undragged_times = np.asarray(scene.times)
            time_ratio = np.ones(self.times.shape)
            np.divide(self.times, undragged_times, out=time_ratio, where=undragged_times > 0.0)
            values["msd_slope"] *= time_ratio * self._slowing
        return values

    @property
    def errors(self) -> dict[str, float]:
        """Error estimates, by part of the result."""
        return self.undragged.errors

    @property
    def verdict(self) -> tuple[SolverStatus, str]:
        """The status and the message."""
        return self.undragged.verdict

    @property
    def plan(self) -> tuple[PlanStep, ...]:
        """What was solved, what was skipped, and why."""
        reason = "the paths are those without drag, in the time (1 - exp(-drag t))/drag"
        return (PlanStep("drag", True, reason), *self.undragged.plan)

    @property
    def stats(self) -> dict[str, Any]:
        """Numbers about the work."""
        return self.undragged.stats

    @property
    def typical_speed(self) -> FloatArray:
        """A speed of the order of the thermal one in U, shape (n_times,)."""
        return self.undragged.typical_speed * self._slowing

    @property
    def uncollided(self) -> FloatArray:
        """The share of tracers in the delta peaks of a start of sharp speeds, shape (n_times,)."""
        return self.undragged.uncollided

    @property
    def captured(self) -> FloatArray:
        """No tracer sticks: zeros, shape (n_times,)."""
        return np.zeros(self.times.shape)

    def speed_density(self, v: FloatArray) -> FloatArray:
        """Density of the speed in 1/U at speeds v (n_v,), shape (n_times, n_v)."""
        return self._density_of_v(self.undragged.speed_density, 1, v)

    def component_density(self, v_x: FloatArray) -> FloatArray:
        """Density of one component of the velocity in 1/U, shape (n_times, n)."""
        return self._density_of_v(self.undragged.component_density, 1, v_x)

    def velocity_density(self, v: FloatArray, phi: FloatArray) -> FloatArray:
        """Density of the velocity in U^-d, shape (n_times, n_v, n_phi)."""

        def density_of_u(u: FloatArray) -> FloatArray:
            return self.undragged.velocity_density(u, phi)

        return self._density_of_v(density_of_u, self.undragged.scene.dimension, v)

    def _density_of_v(
        self, density_of_u: Callable[[FloatArray], FloatArray], n_components: int, v: FloatArray
    ) -> FloatArray:
        """Return a density of v, made of the density of u = v/slowing at each time."""
        densities = []
        with np.errstate(all="ignore"):  # late all of it is at rest
            for time, slowing in enumerate(self._slowing):
                densities.append(density_of_u(v / slowing)[time] / slowing**n_components)
        return np.nan_to_num(np.array(densities), nan=0.0, posinf=math.inf)


def _error_of(averages: Averages, outputs: Collection[tuple[Ingredient, ...]]) -> float:
    """Return the largest relative error of outputs made of these averages; infinite for NaN."""
    largest = ROUNDING_OF_AVERAGES
    for ingredients in outputs:
        error = 0.0
        for ingredient in ingredients:
            # one that the initial state makes zero has no error
            if averages.start.harmonic(ingredient.averaged_over) is not None:
                relative = averages.error_estimate(ingredient.observable)
                error += ingredient.error_factor * relative
        if math.isnan(error):
            return math.inf
        largest = max(largest, error)
    return largest


def _with_enough_nodes(averages: Averages, outputs: Collection[tuple[Ingredient, ...]]) -> Averages:
    """Return averages with as many nodes of a panel as outputs need, by their error estimates."""
    for _ in range(MAX_REFINEMENTS):
        excess = _error_of(averages, outputs) / averages.rtol
        if not 1.0 < excess < math.inf:
            break
        missing_digits = math.ceil(math.log10(excess))
        nodes = averages.equation.nodes + 1 + missing_digits  # a node is about a digit
        if averages.equation.nodes >= MAX_NODES:
            break
        averages = averages.with_nodes(min(nodes, MAX_NODES))
    return averages


def _in_range(name: str, value: NDArray[Any]) -> NDArray[Any]:
    """Return a value; InputError where it is beyond the largest number of double precision."""
    if not np.all(np.isfinite(value)):
        raise InputError(f"times: {name} overflows there; ask for other times, speeds or powers")
    return value
