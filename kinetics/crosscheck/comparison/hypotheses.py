"""What explains a difference: hypotheses, each fitted to the same averages and compared.

A hypothesis that is right lowers the chi-square to what chance allows. Several may: they are ranked
by the chi-square that they leave plus 2 for each fitted parameter (Akaike's criterion), and
"explains" is said only of those within NEAR_BEST of the best. A new hypothesis is a function of the
averages that yields `Tested`, and one entry of the table HYPOTHESES. A theory that has an error of
its own may say so (`finite_density`): that makes its chi-square smaller, and what the larger
covariance takes from the likelihood is counted against it.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.comparison import finite_density
from kinetics.crosscheck.comparison.data_and_theory import DataAndTheory
from kinetics.crosscheck.comparison.fit import Components, Fit, Unknown, components_of, fit
from kinetics.crosscheck.comparison.result import Explanation, said
from kinetics.crosscheck.comparison.statistics import ChiSquare, hotelling, log_widening
from kinetics.crosscheck.comparison.theory import Expectation, SampledStart
from kinetics.crosscheck.verdicts import AGREES_BELOW, DIFFERS_ABOVE, chance

Array = NDArray[np.float64]

AGREES_ABOVE = chance(AGREES_BELOW)
"""p-value from which on what a hypothesis leaves agrees."""
NEAR_BEST = 6.0
"""Distance from the best in chi-square plus 2 per parameter up to which a hypothesis explains as
well: at this distance it is exp(3) = 20 times less likely."""
_LEAST_GAIN = 16.0
"""Of T^2 by one parameter, 4 sigma, and at least a tenth of it: less is no explanation."""
_SPEED_AVERAGES = ("thermal_speed", "a2")
_FACTORS = (0.0, -2.0, 2.0, -5.0, 5.0, -9.0, 9.0)
"""Logarithms of the factors from which a unit or a free path is looked for."""
_WIDEST = 12.0
_OTHER_SCALE = 1.0
"""|ln| of a free path's factor from which on a wrong diameter is the likely reason."""


@dataclass(frozen=True, eq=False)
class Tested:
    """A hypothesis with what it comes to; parameters that were fitted; the averages it expects.

    theory (n_names, n_times), None where it is no theory of all averages. widening: ln of the ratio
    of determinants of the covariance with and without the theory's own error.
    """

    explanation: Explanation
    parameters: int = 0
    theory: Array | None = None
    widening: float = 0.0

    @property
    def criterion(self) -> float:
        """-2 ln likelihood, to a constant, plus 2 per parameter."""
        left = self.explanation.chi_square_after or 0.0
        return left + 2 * self.parameters + self.widening


def tested_hypotheses(both: DataAndTheory) -> list[Tested]:
    """Every hypothesis, the likeliest first, with the chi-square of the averages before and after.

    Empty where too few averages have a spread.
    """
    # Not time 0: there a hypothesis on the start would leave nothing that could differ.
    usable = both.usable & (both.sample.times > 0)
    components = components_of(both.names, usable, both.sample, 1)
    if components.tested.size < 2:
        return []
    difference = both.difference.ravel()[components.tested]
    replicates = both.flat_replicates[:, components.tested]
    before = hotelling(difference, replicates, None, components.one_by_one)
    if before is None:
        return []
    averages = Averages(both, components, before)
    return _ranked([one for hypothesis in HYPOTHESES for one in hypothesis(averages)])


def _ranked(tested: Sequence[Tested]) -> list[Tested]:
    """The likeliest first; "explains" is left only to those near the best."""
    whole = sorted((one for one in tested if one.theory is not None), key=lambda one: one.criterion)
    rest = [one for one in tested if one.theory is None]
    best, found = whole[0].criterion if whole else 0.0, []
    for one in whole:
        if one.explanation.outcome == "explains" and one.criterion > best + NEAR_BEST:
            one = replace(one, explanation=replace(one.explanation, outcome="in part"))
        found.append(one)
    if whole and best < (whole[0].explanation.chi_square_before or 0.0) / 2:
        # What is inferred from the averages is no finding where another cause is that likely.
        rest = [
            replace(one, explanation=replace(one.explanation, outcome="in part"))
            if one.explanation.outcome == "found"
            else one
            for one in rest
        ]
    return found + rest


@dataclass(frozen=True)
class _Fitted:
    """The parameter of a hypothesis with its standard error, and the chi-square that is left."""

    value: float
    error: float
    chi_square: ChiSquare
    fit: Fit
    theory: Array


@dataclass(frozen=True, eq=False)
class Averages:
    """The averages that hypotheses are fitted to, and the chi-square that they start from."""

    both: DataAndTheory
    components: Components
    before: ChiSquare

    def theory(
        self, restitution: float | None = None, free_path: float | None = None, start: Any = None,
        scatterers: str = "dilute",
    ) -> tuple[Array, Array]:  # fmt: skip
        """The theory with some of its numbers changed; see Expectation.theory."""
        scene = self.both.solution.scene
        return self.both.expectation.theory(
            scene.restitution if restitution is None else restitution,
            scene.mean_free_path if free_path is None else free_path,
            scene.initial if start is None else start,
            scatterers,
            1.0 if scatterers == "dilute" else scene.diameter,
        )

    def left_by(
        self, theory: Array, moved: Array, uncertain: Array | None = None
    ) -> tuple[ChiSquare | None, float]:
        """The chi-square that a theory without a free parameter leaves, and Tested.widening.

        moved as in a Model; uncertain: covariance of the theory's own error, as flat averages.
        """
        expectation, tested = self.both.expectation, self.components.tested
        difference = (expectation.values - theory).ravel()[tested]
        replicates = (expectation.replicates - moved).reshape(self.both.sample.groups, -1)
        replicates, one_by_one = replicates[:, tested], self.components.one_by_one
        if uncertain is None:
            return hotelling(difference, replicates, None, one_by_one), 0.0
        known = uncertain[np.ix_(tested, tested)]
        left = hotelling(difference, replicates, known, one_by_one)
        return left, log_widening(replicates, known)

    def fitted(
        self, model: Callable[[float], tuple[Array, Array]], unknown: Unknown,
        starts: Sequence[float], components: Components | None = None,
    ) -> _Fitted | None:  # fmt: skip
        """The best value of one parameter of a model of all averages.

        None where there is none, and where it is at the limit of what was looked at.
        """
        chosen = self.components if components is None else components
        data = self.both.expectation.values, self.both.expectation.replicates
        found = fit(
            [unknown], lambda at: model(float(at[0])), data, chosen, [[at] for at in starts]
        )
        if found is None or found.chi_square is None:
            return None
        value = float(found.values[0])
        return _Fitted(value, float(found.errors[0]), found.chi_square, found, model(value)[0])

    def fitted_log(
        self, model: Callable[[float], tuple[Array, Array]], told: float,
        components: Components | None = None,
    ) -> _Fitted | None:  # fmt: skip
        """The best value of a positive parameter, as a factor of what was told."""
        unknown = Unknown("logarithm", -_WIDEST, _WIDEST)
        found = self.fitted(
            lambda at: model(told * float(np.exp(at))), unknown, _FACTORS, components
        )
        if found is None or abs(found.value) > 0.99 * _WIDEST:
            return None
        value = told * float(np.exp(found.value))
        return replace(found, value=value, error=value * found.error)

    def fitted_path(self, components: Components | None = None) -> _Fitted | None:
        """The best free path, for all averages or for some components."""
        told = self.both.solution.scene.mean_free_path
        return self.fitted_log(lambda at: self.theory(free_path=at), told, components)

    def tested(self, name: str, text: str, headline: str, found: _Fitted) -> Tested:
        """What a hypothesis with one fitted parameter comes to."""
        explanation = self.judged(name, text, headline, found.chi_square)
        explanation = replace(explanation, value=found.value, error=found.error)
        return Tested(explanation, 1, found.theory)

    def judged(self, name: str, text: str, headline: str, after: ChiSquare) -> Explanation:
        """What a hypothesis comes to, from the chi-square that it leaves."""
        before, outcome = self.before, "does not"
        if after.p_value >= AGREES_ABOVE:
            # Averages that agreed already need no explaining.
            outcome = "explains" if before.p_value < AGREES_ABOVE else "does not"
        elif before.statistic - after.statistic > max(_LEAST_GAIN, 0.1 * before.statistic):
            outcome = "in part"
        text = f"{text} {said('tested', before=before, after=after)}"
        return Explanation(
            name, outcome, text, True, None, None, before.value, after.value,
            after.freedom, after.p_value, headline,
        )  # fmt: skip


def _free_path(averages: Averages) -> Iterator[Tested]:
    found, scene = averages.fitted_path(), averages.both.solution.scene
    if found is None:
        return
    told, disks, near = scene.mean_free_path, None, False
    smooth = averages.both.sample.law.smooth_disks
    if (
        smooth and np.pi * scene.number_density * scene.diameter**2 / 4 < 0.5
    ):  # the disks' share of the area
        from kinetics.crosscheck.report.observables import contact_value

        disks = told / contact_value(scene.number_density, scene.diameter)
        near = abs(found.value - disks) <= 3 * found.error and found.value < told
    text = said(
        "free_path", found=found, told=told, disks=disks, near=near, law=averages.both.sample.law
    )
    headline = said("in_place_of", name="l", unit=" d", found=found, told=told)
    if abs(np.log(found.value / told)) > _OTHER_SCALE and averages.both.sample.law.dimension == 2:
        headline += f" (as if d were {told / found.value:.4g} of the unit told)"
    yield averages.tested("free path", text, headline, found)


def _recollisions(averages: Averages) -> Iterator[Tested]:
    """Whether <r^2> stays below the theory once the speeds' own free path is put in."""
    both = averages.both
    of_speeds = both.usable & (both.sample.times > 0)
    of_speeds = of_speeds & np.isin(both.names, _SPEED_AVERAGES)[:, None]
    speeds = components_of(both.names, of_speeds, both.sample, 1)
    sample = both.sample
    if "msd" not in both.names or speeds.tested.size < 2 or sample.free or sample.tabulated:
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
    fits = found.chi_square.p_value >= AGREES_ABOVE
    text = said("recollisions", path=found.value, fits=fits, relative=relative, error=error)
    outcome = ("found" if fits else "in part") if relative < 0 else "does not"
    yield Tested(
        Explanation(
            "recollisions", outcome, text, True, relative, error, p_value=result.p_value,
            chi_square_after=result.value, dof=1,
        )
    )  # fmt: skip


def _restitution(averages: Averages) -> Iterator[Tested]:
    e = averages.both.solution.scene.restitution
    unknown = Unknown("restitution", 0.0, 1.0)
    found = averages.fitted(lambda at: averages.theory(restitution=at), unknown, [e])
    if found is not None:
        text = said("restitution", found=found, told=e)
        headline = said("in_place_of", name="e", unit="", found=found, told=e)
        yield averages.tested("restitution", text, headline, found)


def _start(averages: Averages) -> Iterator[Tested]:
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
        after, _ = averages.left_by(theory, moved)
        if after is not None:
            text, headline = said("start", start=words), f"another start ({words})"
            yield Tested(averages.judged("initial speeds", text, headline, after), 0, theory)


def _unit(
    averages: Averages, name: str, symbol: str, time: float, powers: dict[str, float]
) -> Iterator[Tested]:
    """Another unit than `symbol`; time, powers: of it that times and averages carry."""
    both = averages.both
    if both.own_start and name == "speed unit":
        return
    sample, own = both.expectation.sample, both.own_start
    power = np.array([powers.get(one, 0.0) for one in both.names])[:, None]
    scene = both.solution.scene

    def model(unit: float) -> tuple[Array, Array]:
        at = Expectation(replace(sample, times=sample.times * unit**time), both.names)
        values, moved = at.theory(scene.restitution, scene.mean_free_path, scene.initial)
        return values * unit**power, moved * unit**power if own else values * unit**power

    found = averages.fitted_log(model, 1.0)
    if found is not None:
        text = said("unit", name=name, symbol=symbol, found=found)
        headline = said("unit_headline", symbol=symbol, found=found)
        yield averages.tested(name, text, headline, found)


def _at_rest(averages: Averages) -> Iterator[Tested]:
    """A share f of tracers that do not move from the start: <v^2> and <r^2> times 1 - f."""
    values, moved = averages.theory()
    unknown = Unknown("share", -0.5, 0.9)
    names = averages.both.names
    found = averages.fitted(
        lambda share: (_thinned(values, names, share), _thinned(moved, names, share)), unknown,
        [0.0],
    )  # fmt: skip
    if found is not None and 0 < found.value < 0.85:
        text, headline = said("at_rest", found=found), said("at_rest_headline", found=found)
        yield averages.tested("tracers at rest", text, headline, found)


def _thinned(values: Array, names: Sequence[str], share: float) -> Array:
    """Averages (..., n_names, n_times) of all tracers, where a share of them is at rest."""
    left = 1 - share
    factor = {"thermal_speed": np.sqrt(left), "msd": left, "a2": 1 / left, "kurtosis": 1 / left}
    shift = np.array([1 / left - 1 if name == "a2" else 0.0 for name in names])
    return np.asarray(values * np.array([factor[name] for name in names])[:, None] + shift[:, None])


def _finite_density(averages: Averages) -> Iterator[Tested]:
    """Scatterers at the density told, which tracers meet again: nothing is fitted."""
    both = averages.both
    if not finite_density.is_known(both):
        return
    for scatterers in finite_density.WORDS:
        theory, moved = averages.theory(scatterers=scatterers)
        uncertain = finite_density.covariance(both, theory)
        after, widening = averages.left_by(theory, moved, uncertain)
        if after is not None:
            text = finite_density.described(both, scatterers, theory)
            headline = said("finite_density_headline", scatterers=scatterers)
            found = averages.judged("finite density", text, headline, after)
            yield Tested(found, 0, theory, widening)


HYPOTHESES: tuple[Callable[[Averages], Iterator[Tested]], ...] = (
    _finite_density,
    _free_path,
    _restitution,
    _start,
    # speeds at the start of another size; times, or positions, in another unit than the rest
    partial(_unit, name="speed unit", symbol="U", time=1.0, powers={"thermal_speed": 1.0}),
    partial(_unit, name="time unit", symbol="d/U", time=-1.0, powers={}),
    partial(_unit, name="length unit", symbol="d", time=0.0, powers={"msd": 2.0}),
    _at_rest,
    _recollisions,
)
"""Everything that may explain a difference. The first, which has no free parameter, stands before
others that are as likely."""
