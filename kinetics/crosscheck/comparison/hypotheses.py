"""What may explain a difference, tested: each hypothesis is fitted to the same averages.

A hypothesis that is right lowers the chi-square to what chance allows. One that only helps says by
how much.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.comparison.fit import Fit, choose_components, fit
from kinetics.crosscheck.comparison.result import Explanation
from kinetics.crosscheck.comparison.statistics import ChiSquare, hotelling
from kinetics.crosscheck.comparison.theory import SampledStart, sampled_start
from kinetics.crosscheck.report.rows import contact_value
from kinetics.crosscheck.verdicts import AGREES_BELOW, DIFFERS_ABOVE, chance

if TYPE_CHECKING:
    from kinetics.crosscheck.comparison.differences import Judged

Array = NDArray[np.float64]

AGREES_ABOVE = chance(AGREES_BELOW)
"""p-value from which on what a hypothesis leaves agrees."""
_LEAST_GAIN = 16.0  # of chi-square by one parameter: 4 sigma
_SPEED_AVERAGES = ("thermal_speed", "a2")


def tested_hypotheses(judged: "Judged") -> Iterator[Explanation]:
    """Every hypothesis, with the chi-square of the averages before and after."""
    case = _case(judged)
    if case is not None:
        yield from _free_path(case)
        yield from _recollisions(case)
        yield from _restitution(case)
        yield from _start(case)
        yield from _speed_unit(case)
        yield from _at_rest_fraction(case)


@dataclass(frozen=True, eq=False)
class _Case:
    """The averages that hypotheses are fitted to, and the chi-square that they start from."""

    judged: "Judged"
    components: NDArray[np.int64]
    before: ChiSquare

    @property
    def theory(self) -> "Callable[..., tuple[Array, Array]]":
        """Restitution, ln l and start to the flat theory and its replicates."""
        scene = self.judged.solution.scene

        def flat(
            e: float = scene.restitution,
            log_path: float = float(np.log(scene.mean_free_path)),
            start: Any = scene.initial,
        ) -> tuple[Array, Array]:
            values, moved = self.judged.expectation.theory(e, float(np.exp(log_path)), start)
            return values, moved

        return flat

    def fit(
        self, name: str, model: Any, start: list[float], low: float, high: float,
        components: Any = None,
    ) -> Fit | None:  # fmt: skip
        expectation = self.judged.expectation
        data = (
            expectation.values.ravel(),
            expectation.replicates.reshape(self.judged.sample.groups, -1),
        )
        chosen = self.components if components is None else components

        def flat(at: Array) -> tuple[Array, Array]:
            values, moved = model(float(at[0]))
            return values.ravel(), moved.reshape(*moved.shape[:-2], -1)

        return fit([name], flat, data, chosen, [[s] for s in start], [low], [high])

    def chosen(self, names: tuple[str, ...]) -> Any:
        """The components of these averages alone."""
        n_times = self.judged.sample.times.size
        wanted = [i for i, n in enumerate(self.judged.expectation.names) if n in names]
        return self.components[np.isin(self.components // n_times, wanted)]


def _case(judged: "Judged") -> _Case | None:
    # Not time 0: there a hypothesis on the start would leave nothing that could differ.
    usable = judged.usable & (judged.sample.times > 0)
    components = choose_components(usable, judged.sample.groups, 2)
    if components.size < 2:
        return None
    difference = judged.difference.ravel()[components]
    replicates = judged.replicates.reshape(judged.sample.groups, -1)[:, components]
    before = hotelling(difference, replicates)
    return None if before is None else _Case(judged, components, before)


def _outcome(before: ChiSquare, after: ChiSquare) -> str:
    if after.p_value >= AGREES_ABOVE:
        # Averages that agreed already need no explaining.
        return "explains" if before.p_value < AGREES_ABOVE else "does not"
    gained = before.value - after.value
    return "in part" if gained > max(_LEAST_GAIN, 0.1 * before.value) else "does not"


def _tested(
    name: str, text: str, before: ChiSquare, after: ChiSquare,
    value: float | None = None, error: float | None = None,
) -> Explanation:  # fmt: skip
    outcome = _outcome(before, after)
    left = (
        f" The averages' chi-square goes from {before.value:.4g} to {after.value:.4g} with "
        f"{after.freedom} degrees of freedom (p = {after.p_value:.2g})."
    )
    return Explanation(
        name, outcome, text + left, True, value, error, before.value, after.value, after.freedom,
        after.p_value,
    )  # fmt: skip


def _free_path(case: _Case) -> Iterator[Explanation]:
    scene = case.judged.solution.scene
    log_path = float(np.log(scene.mean_free_path))
    found = case.fit(
        "log_path", lambda at: case.theory(log_path=at), [log_path], log_path - 3, log_path + 3
    )
    if found is None or found.chi_square is None:
        return
    path = float(np.exp(found.values[0]))
    error = path * float(found.errors[0])
    ratio = path / scene.mean_free_path
    text = (
        f"Another mean free path: l = {path:.5g} ± {error:.2g} d fits best, {ratio - 1:+.1%} from "
        f"1/(2dρ₀) = {scene.mean_free_path:.5g} d, as a density of {1 / (2 * path):.5g} d⁻² would "
        "have."
    )
    fraction = np.pi * scene.number_density * scene.diameter**2 / 4
    if fraction < 0.5:
        disks = scene.mean_free_path / contact_value(scene.number_density, scene.diameter)
        text += (
            f" Hard disks that do not overlap have l = {disks:.5g} d at the density told "
            f"({disks / scene.mean_free_path - 1:+.1%}, Henderson's contact value)"
        )
        near = abs(path - disks) <= 3 * error and ratio < 1
        text += ": that is the finite density of the scatterers." if near else "."
    yield _tested("free path", text, case.before, found.chi_square, path, error)


def _recollisions(case: _Case) -> Iterator[Explanation]:
    """Whether <r^2> stays below the theory once the speeds' own free path is put in."""
    judged = case.judged
    names = judged.expectation.names
    components = case.chosen(_SPEED_AVERAGES)
    if "msd" not in names or components.size < 2 or judged.sample.free:
        return
    log_path = float(np.log(judged.solution.scene.mean_free_path))
    found = case.fit(
        "log_path", lambda at: case.theory(log_path=at), [log_path], log_path - 3, log_path + 3,
        components,
    )  # fmt: skip
    if found is None or found.chi_square is None:
        return
    k, last = names.index("msd"), judged.sample.times.size - 1
    theory, moved = case.theory(log_path=float(found.values[0]))
    ahead, _ = case.theory(log_path=float(found.values[0]) + 1e-4)
    slope = (ahead[k, last] - theory[k, last]) / 1e-4
    expectation = judged.expectation
    flat = expectation.replicates.reshape(judged.sample.groups, -1)
    shift = found.moved(flat)[:, 0]
    replicates = expectation.replicates[:, k, last] - moved[..., k, last] - shift * slope
    difference = np.array([expectation.values[k, last] - theory[k, last]])
    result = hotelling(difference, replicates[:, None])
    if result is None or result.p_value > chance(DIFFERS_ABOVE):
        return
    relative = float(difference[0] / theory[k, last])
    error = abs(relative) / np.sqrt(result.value)
    fits = "fits them" if found.chi_square.p_value >= AGREES_ABOVE else "fits them best"
    below = relative < 0
    text = (
        f"The speeds alone have l = {np.exp(found.values[0]):.5g} d ({fits}); with it ⟨r²⟩ at the "
        f"last time is {relative:+.1%} ± {error:.1%} from the kinetic equation. "
        + (
            "Tracers that come back to scatterers they have met spread less than the equation, "
            "which forgets them, says: recollisions of a finite density do that."
            if below
            else "Recollisions would make it smaller, not larger."
        )
    )
    yield Explanation(
        "recollisions", "found" if below else "does not", text, True, relative, float(error),
        p_value=result.p_value, chi_square_after=result.value, dof=1,
    )  # fmt: skip


def _restitution(case: _Case) -> Iterator[Explanation]:
    e = case.judged.solution.scene.restitution
    found = case.fit("restitution", lambda at: case.theory(e=at), [e], 0.0, 1.0)
    if found is None or found.chi_square is None:
        return
    value, error = float(found.values[0]), float(found.errors[0])
    text = f"Another restitution: e = {value:.5g} ± {error:.2g} fits best, instead of {e:.5g}."
    yield _tested("restitution", text, case.before, found.chi_square, value, error)


def _start(case: _Case) -> Iterator[Explanation]:
    """The data's own speeds at time 0, or the other named start."""
    judged = case.judged
    told = judged.solution.scene.initial
    starts: list[tuple[str, Any]] = []
    if judged.sample.start is not None and not isinstance(told, SampledStart):
        starts.append(("the data's own speeds at time 0", sampled_start(judged.sample)))
    elif judged.sample.start is None:
        starts += [
            (words, name)
            for name, words in (("gaussian", "a Gaussian"), ("monoenergetic", "all speeds U"))
            if name != told
        ]
    for words, start in starts:
        theory, moved = case.theory(start=start)
        expectation = judged.expectation
        difference = (expectation.values - theory).ravel()[case.components]
        replicates = (expectation.replicates - moved).reshape(judged.sample.groups, -1)
        after = hotelling(difference, replicates[:, case.components])
        if after is not None:
            yield _tested(
                "initial speeds", f"Another start: {words}, the rest as told.", case.before, after
            )


def _speed_unit(case: _Case) -> Iterator[Explanation]:
    """Speeds at the start of another size: v and t in another unit than U."""
    judged = case.judged
    scene, names = judged.solution.scene, judged.expectation.names
    if isinstance(scene.initial, SampledStart):
        return
    speeds = np.array([float(name == "thermal_speed") for name in names])[:, None]
    expectation = judged.expectation

    def model(log_unit: float) -> tuple[Array, Array]:
        unit = float(np.exp(log_unit))
        moved = replace(expectation.sample, times=expectation.sample.times * unit)
        at = type(expectation)(moved, names)
        values, _ = at.theory(scene.restitution, scene.mean_free_path, scene.initial)
        scaled = values * unit**speeds
        return scaled, scaled

    found = case.fit("log_unit", model, [0.0], -5.0, 5.0)
    if found is None or found.chi_square is None:
        return
    unit = float(np.exp(found.values[0]))
    error = unit * float(found.errors[0])
    text = (
        f"Speeds in another unit, or faster at the start: U = {unit:.5g} ± {error:.2g} in the "
        "data's unit fits best, instead of 1."
    )
    yield _tested("speed unit", text, case.before, found.chi_square, unit, error)


def _at_rest_fraction(case: _Case) -> Iterator[Explanation]:
    """A share f of tracers that do not move from the start: <v^2> and <r^2> times 1 - f."""
    names = case.judged.expectation.names
    powers = {"thermal_speed": 0.5, "msd": 1.0}

    def model(share: float) -> tuple[Array, Array]:
        left = 1 - share

        def thinned(values: Array) -> Array:
            out = values.copy()
            for k, name in enumerate(names):
                if name in powers:
                    out[..., k, :] *= left ** powers[name]
                elif name == "a2":
                    out[..., k, :] = (1 + out[..., k, :]) / left - 1
                else:
                    out[..., k, :] /= left
            return out

        values, moved = case.theory()
        return thinned(values), thinned(moved)

    found = case.fit("share", model, [0.0], -0.5, 0.9)
    if found is None or found.chi_square is None or found.values[0] <= 0:
        return
    share, error = float(found.values[0]), float(found.errors[0])
    text = f"A share of {share:.2%} ± {error:.2%} of the tracers that never moves fits best."
    yield _tested("tracers at rest", text, case.before, found.chi_square, share, error)
