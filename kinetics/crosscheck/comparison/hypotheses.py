"""What may explain a difference, tested: each hypothesis is fitted to the same averages.

A hypothesis that is right lowers the chi-square to what chance allows. One that only helps says by
how much.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.comparison.data_and_theory import DataAndTheory
from kinetics.crosscheck.comparison.fit import Fit, Unknown, choose_components, fit
from kinetics.crosscheck.comparison.result import Explanation, said
from kinetics.crosscheck.comparison.statistics import ChiSquare, hotelling
from kinetics.crosscheck.comparison.theory import Expectation, sampled_start
from kinetics.crosscheck.verdicts import AGREES_BELOW, DIFFERS_ABOVE, chance

Array = NDArray[np.float64]

AGREES_ABOVE = chance(AGREES_BELOW)
"""p-value from which on what a hypothesis leaves agrees."""
_LEAST_GAIN = 16.0
"""Of chi-square by one parameter, 4 sigma, and at least a tenth of it: less is no explanation."""
_SPEED_AVERAGES = ("thermal_speed", "a2")


def tested_hypotheses(both: DataAndTheory) -> Iterator[Explanation]:
    """Every hypothesis, with the chi-square of the averages before and after."""
    # Not time 0: there a hypothesis on the start would leave nothing that could differ.
    usable = both.usable & (both.sample.times > 0)
    components = choose_components(usable, both.sample.groups, 2)
    if components.size < 2:
        return
    difference = both.difference.ravel()[components]
    before = hotelling(difference, both.flat_replicates[:, components])
    if before is not None:
        averages = _Averages(both, components, before)
        for hypothesis in (_free_path, _recollisions, _restitution, _start, _unit, _at_rest):
            yield from hypothesis(averages)


@dataclass(frozen=True)
class _Fitted:
    """The parameter of a hypothesis with its standard error, and the chi-square that is left."""

    value: float
    error: float
    chi_square: ChiSquare
    fit: Fit


@dataclass(frozen=True, eq=False)
class _Averages:
    """The averages that hypotheses are fitted to, and the chi-square that they start from."""

    both: DataAndTheory
    components: NDArray[np.int64]
    before: ChiSquare

    def theory(
        self, restitution: float | None = None, free_path: float | None = None, start: Any = None
    ) -> tuple[Array, Array]:
        """The theory with some of its numbers changed; see Expectation.theory."""
        scene = self.both.solution.scene
        return self.both.expectation.theory(
            scene.restitution if restitution is None else restitution,
            scene.mean_free_path if free_path is None else free_path,
            scene.initial if start is None else start,
        )

    def fitted(
        self, model: Callable[[float], tuple[Array, Array]], unknown: Unknown, start: float,
        components: Any = None,
    ) -> _Fitted | None:  # fmt: skip
        """The best value of one parameter of a model of all averages; None where there is none."""
        expectation, groups = self.both.expectation, self.both.sample.groups

        def flat(at: Array) -> tuple[Array, Array]:
            values, moved = model(float(at[0]))
            return values.ravel(), moved.reshape(*moved.shape[:-2], -1)

        data = expectation.values.ravel(), expectation.replicates.reshape(groups, -1)
        chosen = self.components if components is None else components
        found = fit([unknown], flat, data, chosen, [[start]])
        if found is None or found.chi_square is None:
            return None
        return _Fitted(float(found.values[0]), float(found.errors[0]), found.chi_square, found)

    def fitted_log(
        self, model: Callable[[float], tuple[Array, Array]], told: float, width: float,
        components: Any = None,
    ) -> _Fitted | None:  # fmt: skip
        """The best value of a positive parameter, within a factor exp(width) of what was told."""
        start = float(np.log(told))
        unknown = Unknown("logarithm", start - width, start + width)
        found = self.fitted(lambda at: model(float(np.exp(at))), unknown, start, components)
        if found is None:
            return None
        value = float(np.exp(found.value))
        return replace(found, value=value, error=value * found.error)

    def fitted_path(self, components: Any = None) -> _Fitted | None:
        """The best free path, for all averages or for some components."""
        told = self.both.solution.scene.mean_free_path
        return self.fitted_log(lambda at: self.theory(free_path=at), told, 3.0, components)

    def tested(self, name: str, text: str, found: _Fitted | ChiSquare) -> Explanation:
        """What a hypothesis comes to, from the chi-square that it leaves."""
        value, error, after, before = None, None, found, self.before
        if isinstance(found, _Fitted):
            value, error, after = found.value, found.error, found.chi_square
        assert isinstance(after, ChiSquare)
        outcome = "does not"
        if after.p_value >= AGREES_ABOVE:
            # Averages that agreed already need no explaining.
            outcome = "explains" if before.p_value < AGREES_ABOVE else "does not"
        elif before.value - after.value > max(_LEAST_GAIN, 0.1 * before.value):
            outcome = "in part"
        text = f"{text} {said('tested', before=before, after=after)}"
        return Explanation(
            name, outcome, text, True, value, error, before.value, after.value,
            after.freedom, after.p_value,
        )  # fmt: skip


def _free_path(averages: _Averages) -> Iterator[Explanation]:
    found, scene = averages.fitted_path(), averages.both.solution.scene
    if found is None:
        return
    told, disks, near = scene.mean_free_path, None, False
    if np.pi * scene.number_density * scene.diameter**2 / 4 < 0.5:  # the disks' share of the area
        from kinetics.crosscheck.report.observables import contact_value

        disks = told / contact_value(scene.number_density, scene.diameter)
        near = abs(found.value - disks) <= 3 * found.error and found.value < told
    text = said("free_path", found=found, told=told, disks=disks, near=near)
    yield averages.tested("free path", text, found)


def _recollisions(averages: _Averages) -> Iterator[Explanation]:
    """Whether <r^2> stays below the theory once the speeds' own free path is put in."""
    both = averages.both
    wanted = [i for i, name in enumerate(both.names) if name in _SPEED_AVERAGES]
    speeds = averages.components[np.isin(averages.components // both.sample.times.size, wanted)]
    if "msd" not in both.names or speeds.size < 2 or both.sample.free:
        return
    found = averages.fitted_path(speeds)
    if found is None:
        return
    k, last = both.names.index("msd"), both.sample.times.size - 1
    theory, moved = averages.theory(free_path=found.value)
    expectation = both.expectation
    slope = found.fit.slope.reshape(*theory.shape, 1)[k, last, 0]
    shift = found.fit.moved(expectation.replicates.reshape(both.sample.groups, -1))[:, 0]
    replicates = expectation.replicates[:, k, last] - moved[..., k, last] - shift * slope
    difference = np.array([expectation.values[k, last] - theory[k, last]])
    result = hotelling(difference, replicates[:, None])
    if result is None or result.p_value > chance(DIFFERS_ABOVE):
        return
    relative = float(difference[0] / theory[k, last])
    error = float(abs(relative) / np.sqrt(result.value))
    text = said(
        "recollisions", path=found.value, fits=found.chi_square.p_value >= AGREES_ABOVE,
        relative=relative, error=error,
    )  # fmt: skip
    yield Explanation(
        "recollisions", "found" if relative < 0 else "does not", text, True, relative, error,
        p_value=result.p_value, chi_square_after=result.value, dof=1,
    )  # fmt: skip


def _restitution(averages: _Averages) -> Iterator[Explanation]:
    e = averages.both.solution.scene.restitution
    unknown = Unknown("restitution", 0.0, 1.0)
    found = averages.fitted(lambda at: averages.theory(restitution=at), unknown, e)
    if found is not None:
        text = said("restitution", found=found, told=e)
        yield averages.tested("restitution", text, found)


def _start(averages: _Averages) -> Iterator[Explanation]:
    """The data's own speeds at time 0, or the other named start."""
    both = averages.both
    starts: list[tuple[str, Any]] = []
    if both.sample.start is None:
        named = (("gaussian", "a Gaussian"), ("monoenergetic", "all speeds U"))
        told = both.solution.scene.initial
        starts = [(words, name) for name, words in named if name != told]
    elif not both.own_start:
        starts = [("the data's own speeds at time 0", sampled_start(both.sample))]
    for words, start in starts:
        theory, moved = averages.theory(start=start)
        difference = (both.expectation.values - theory).ravel()[averages.components]
        replicates = (both.expectation.replicates - moved).reshape(both.sample.groups, -1)
        after = hotelling(difference, replicates[:, averages.components])
        if after is not None:
            yield averages.tested("initial speeds", said("start", start=words), after)


def _unit(averages: _Averages) -> Iterator[Explanation]:
    """Speeds at the start of another size: v and t in another unit than U."""
    both = averages.both
    if both.own_start:
        return
    scene, sample = both.solution.scene, both.expectation.sample
    speeds = np.array([float(name == "thermal_speed") for name in both.names])[:, None]

    def model(unit: float) -> tuple[Array, Array]:
        at = Expectation(replace(sample, times=sample.times * unit), both.names)
        values, _ = at.theory(scene.restitution, scene.mean_free_path, scene.initial)
        scaled = values * unit**speeds
        return scaled, scaled

    found = averages.fitted_log(model, 1.0, 5.0)
    if found is not None:
        yield averages.tested("speed unit", said("speed_unit", found=found), found)


def _at_rest(averages: _Averages) -> Iterator[Explanation]:
    """A share f of tracers that do not move from the start: <v^2> and <r^2> times 1 - f."""
    values, moved = averages.theory()
    unknown = Unknown("share", -0.5, 0.9)
    names = averages.both.names
    found = averages.fitted(
        lambda share: (_thinned(values, names, share), _thinned(moved, names, share)), unknown, 0.0
    )
    if found is not None and found.value > 0:
        yield averages.tested("tracers at rest", said("at_rest", found=found), found)


def _thinned(values: Array, names: Sequence[str], share: float) -> Array:
    """Averages (..., n_names, n_times) of all tracers, where a share of them is at rest."""
    left, out = 1 - share, values.copy()
    for k, name in enumerate(names):
        if name == "thermal_speed":
            out[..., k, :] *= np.sqrt(left)
        elif name == "msd":
            out[..., k, :] *= left
        elif name == "a2":
            out[..., k, :] = (1 + out[..., k, :]) / left - 1
        else:
            out[..., k, :] /= left
    return out
