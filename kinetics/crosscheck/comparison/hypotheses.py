"""What explains a difference: tested hypotheses, and what data and theory show by themselves.

Each hypothesis is fitted to the same averages. One that is right lowers the chi-square to what
chance allows; one that only helps says by how much. Tracers at rest, tracers that are missing, a
start that is not forgotten and tails too thin to judge are named whether or not there is a
difference.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.comparison.data_and_theory import LEAST_EXPECTED, DataAndTheory
from kinetics.crosscheck.comparison.fit import Fit, Unknown, choose_components, fit
from kinetics.crosscheck.comparison.result import Explanation, said
from kinetics.crosscheck.comparison.statistics import ChiSquare, hotelling
from kinetics.crosscheck.comparison.theory import (
    SPEED,
    Expectation,
    SampledStart,
    bin_shares,
)
from kinetics.crosscheck.verdicts import AGREES_BELOW, DIFFERS_ABOVE, Verdict, chance

Array = NDArray[np.float64]

AGREES_ABOVE = chance(AGREES_BELOW)
"""p-value from which on what a hypothesis leaves agrees."""
_LEAST_GAIN = 16.0
"""Of chi-square by one parameter, 4 sigma, and at least a tenth of it: less is no explanation."""
_SPEED_AVERAGES = ("thermal_speed", "a2")
_FAR_SLOWER = 8.0
"""A trapped tracer is that many times slower than the upper end of the lowest bin: a wrong
restitution, density or start, which shift all speeds a little, cannot put a tracer there."""
_FEWEST_TRAPPED = 5


def explanations_of(both: DataAndTheory, verdict: Verdict) -> Iterator[Explanation]:
    """Hypotheses, where there is a difference; and what is to be noted in any case."""
    if verdict in (Verdict.DIFFERS, Verdict.UNCLEAR):
        yield from tested_hypotheses(both)
    for note in (_traps, _missing, _own_start, _not_forgotten, _tails, _few_samples):
        yield from note(both)


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
        chosen = self.components if components is None else components
        data = self.both.expectation.values, self.both.expectation.replicates
        found = fit([unknown], lambda at: model(float(at[0])), data, chosen, [[start]])
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
    shift = found.fit.moved(expectation.replicates)[:, 0]
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
        starts = [("the data's own speeds at time 0", SampledStart(both.sample.start))]
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
    left = 1 - share
    factor = {"thermal_speed": np.sqrt(left), "msd": left, "a2": 1 / left, "kurtosis": 1 / left}
    shift = np.array([1 / left - 1 if name == "a2" else 0.0 for name in names])
    return np.asarray(values * np.array([factor[name] for name in names])[:, None] + shift[:, None])


def _traps(both: DataAndTheory) -> Iterator[Explanation]:
    """Tracers at the last time that are far slower than the theory's slowest."""
    for found in [h for h in both.histograms if h.name == SPEED][-1:]:
        binned, density = both.sample.speeds, both.densities[SPEED]
        assert binned is not None
        edges = binned.edges[found.index]
        cut = int(np.searchsorted(edges, found.edges[1] / _FAR_SLOWER))
        at = int(np.argmin(np.abs(density.times - found.time)))
        count = int(binned.totals[found.index, : cut + 1].sum())
        expected = float(bin_shares(density, SPEED, at, edges)[: cut + 1].sum()) * found.samples
        excess = count - expected
        if count < _FEWEST_TRAPPED or excess < DIFFERS_ABOVE * np.sqrt(max(expected, count)):
            break
        share, error = excess / found.samples, float(np.sqrt(count)) / found.samples
        text = said(
            "traps", time=found.time, count=count, speed=edges[cut], expected=expected,
            share=share, error=error, rest=int(both.sample.at_rest[found.index]),
        )  # fmt: skip
        yield Explanation("traps", "found", text, True, share, error)
        return
    rest = int(both.sample.at_rest.max())
    if rest:
        share = rest / int(both.sample.samples.max())
        yield Explanation("traps", "found", said("zero_speeds", rest=rest), True, share)


def _missing(both: DataAndTheory) -> Iterator[Explanation]:
    """Fewer tracers at later times: what is left is biased, and the complete times tell."""
    samples = both.sample.samples
    most, least = int(samples.max()), int(np.argmin(samples))
    complete = samples == most
    if np.all(complete):
        return
    results = []
    for times in (complete, ~complete):
        chosen = choose_components(both.usable & times, both.sample.groups, 1)
        results.append(hotelling(both.difference.ravel()[chosen], both.flat_replicates[:, chosen]))
    whole, part = results
    off = None
    if "thermal_speed" in both.names:
        i = both.names.index("thermal_speed")
        if both.usable[i, least]:
            off = both.difference[i, least] / both.theory[i, least]
    missing = most - int(samples[least])
    text = said(
        "missing", capped=both.sample.capped, most=most, missing=missing,
        time=both.sample.times[least], whole=whole, part=part, off=off,
    )  # fmt: skip
    if part is None:
        yield Explanation("missing tracers", "noted", text, False)
        return
    outcome, agrees = "does not", chance(AGREES_BELOW)
    if part.p_value < agrees:
        outcome = "explains" if whole is None or whole.p_value >= agrees else "in part"
    yield Explanation(
        "missing tracers", outcome, text, True, value=missing / most,
        chi_square_before=part.value, chi_square_after=None if whole is None else whole.value,
        dof=None if whole is None else whole.freedom,
        p_value=None if whole is None else whole.p_value,
    )  # fmt: skip


def _own_start(both: DataAndTheory) -> Iterator[Explanation]:
    """A density that started from the data's own speeds cannot differ much from them early."""
    if both.own_start and both.histograms:
        yield Explanation("own start", "noted", said("own_start"), False)


def _not_forgotten(both: DataAndTheory) -> Iterator[Explanation]:
    """Whether the theory itself is still on its way to the scaling state."""
    from kinetics import ScalingSolution

    e = both.solution.scene.restitution
    if e >= 1 or "a2" not in both.names:
        return
    i = both.names.index("a2")
    exact, last = ScalingSolution(e).a2, float(both.theory[i, -1])
    away = last - exact
    # Written so that a theory that is not finite is left out.
    if not abs(away) >= max(0.01 * (1 + exact), float(both.error[i, -1])):
        return
    text = said("not_forgotten", last=last, exact=exact)
    yield Explanation("start not forgotten", "noted", text, False, away)


def _tails(both: DataAndTheory) -> Iterator[Explanation]:
    """What is too rare to be judged."""
    for found in both.histograms[-1:]:
        edge, count = float(found.edges[-2]), found.share[-1] * found.samples
        text = said(
            "tails", least=LEAST_EXPECTED, time=found.time, edge=edge, count=count,
            unit="U" if found.name == SPEED else "d",
        )  # fmt: skip
        yield Explanation("tails", "noted", text, False, edge)


def _few_samples(both: DataAndTheory) -> Iterator[Explanation]:
    """Fourth moments that are hardly known at the last time."""
    for i, name in enumerate(both.names):
        if name not in ("a2", "kurtosis") or not both.usable[i, -1]:
            continue
        scale = 1 + both.theory[i, -1] if name == "a2" else both.theory[i, -1]
        relative = float(both.error[i, -1] / scale)
        if relative > 0.1:
            text = said("few_samples", name=name, relative=relative)
            yield Explanation("few samples", "noted", text, False, relative)
