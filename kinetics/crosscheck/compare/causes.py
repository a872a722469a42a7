"""What may explain a difference: each cause is a row of the table CAUSES, and one fit.

A cause says which parameters of the theory (`theory.Point`) are other than what was told: set to a
value, or free. One that is right lowers the chi-square to what chance allows. Several may: they are
ranked by the chi-square that they leave plus 2 for each fitted parameter (Akaike's criterion), and
"explains" is said only of those within NEAR_BEST of the best. The theory among scatterers at a
finite density has an error of its own: that makes its chi-square smaller, and what the larger
covariance takes from the likelihood is counted against it. Units that do not belong together are
looked for first: then nothing else is claimed. Notes are made in any case.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from kinetics.crosscheck.compare.fit import Components, Fit, choose_components, components_of, fit
from kinetics.crosscheck.compare.judge import Both
from kinetics.crosscheck.compare.result import Explanation
from kinetics.crosscheck.compare.statistics import ChiSquare, chance, hotelling
from kinetics.crosscheck.compare.theory import SPEED, SampledStart, bin_shares
from kinetics.crosscheck.data.sample import V2, N, Sample
from kinetics.crosscheck.words import AGREES_BELOW, DIFFERS_ABOVE, numeral

AGREES_ABOVE = chance(AGREES_BELOW)
"""p-value from which on what a cause leaves agrees."""
NEAR_BEST = 6.0
"""Distance from the best in chi-square plus 2 per parameter up to which a cause explains as well:
at this distance it is exp(3) = 20 times less likely."""
_LEAST_GAIN = 16.0
"""Of T^2 by one parameter, 4 sigma, and at least a tenth of it: less is no explanation."""
_FACTORS = (0.0, -2.0, 2.0, -5.0, 5.0, -9.0, 9.0)
"""Logarithms of the factors from which a unit or a free path is looked for."""
MEDIA = {"hard disks": "hard disks that do not overlap", "overlapping": "overlapping disks"}
"""The media that are tried, as in a Scene, and in words."""
_LEAST_RESTITUTION = 0.2
"""Below it the theory at a finite density is of the leading order only, its error not measured."""


class Cause(NamedTuple):
    """A cause of a difference.

    changes : of the data and theory, the parameters that are set, one dictionary for each variant;
        none where the cause does not apply
    free : the parameter that is fitted, if one is
    words : of data, theory and fit, the sentence and the headline
    """

    name: str
    changes: Callable[[Both], Sequence[dict[str, Any]]]
    words: Callable[[Both, Fit], tuple[str, str]]
    free: tuple[str, ...] = ()


def tested_causes(both: Both) -> tuple[list[Explanation], Any]:
    """Every cause, the likeliest first, and the averages that the one that explains expects.

    Empty where too few averages have a spread. None without one that explains.
    """
    # Not time 0: there a cause in the start would leave nothing that could differ.
    usable = both.usable & (both.sample.times > 0)
    components = components_of(both.names, usable, both.sample, 1)
    if components.tested.size < 2:
        return [], None
    before = hotelling(*both.flat(components.tested), None, components.one_by_one)
    if before is None:
        return [], None
    tested = [
        (found.chi_square.value + 2 * len(cause.free) + found.widening, found, cause)
        for cause in CAUSES
        for change in cause.changes(both)
        if (found := _fitted(both, components, change, cause.free))
        and found.chi_square
        # a share of tracers at rest is one between none and nearly all
        and (cause.free != ("at_rest",) or 0 < found.point.at_rest < 0.85)
    ]
    tested.sort(key=lambda one: one[0])  # -2 ln likelihood, to a constant, plus 2 per parameter
    every, best = [], None
    for criterion, found, cause in tested:
        item = _judged(both, cause, found, before)
        if item.outcome == "explains" and criterion > tested[0][0] + NEAR_BEST:
            item = replace(item, outcome="in part")
        if item.outcome == "explains" and best is None:
            best = found.theory
        every.append(item)
    return every, best


def _fitted(
    both: Both, components: Components, change: dict[str, Any], free: tuple[str, ...]
) -> Fit | None:
    point = both.point._replace(**change)
    told = [getattr(point, name) for name in free]
    starts: Any = [told]
    if free and free[0] not in ("restitution", "at_rest"):
        starts = [[math.log(told[0]) + shift] for shift in _FACTORS]
    return fit(both.expectation, point, free, components, starts)


def _judged(both: Both, cause: Cause, found: Fit, before: ChiSquare) -> Explanation:
    """What a cause comes to, from the chi-square that it leaves."""
    after, outcome = found.chi_square, "does not"
    assert after is not None
    if after.p_value >= AGREES_ABOVE:
        # Averages that agreed already need no explaining.
        outcome = "explains" if before.p_value < AGREES_ABOVE else "does not"
    elif before.statistic - after.statistic > max(_LEAST_GAIN, 0.1 * before.statistic):
        outcome = "in part"
    text, headline = cause.words(both, found)
    text += (
        f" The averages' chi-square goes from {numeral(before.value, '.4g')} to "
        f"{numeral(after.value, '.4g')} with {after.freedom} degrees of freedom "
        f"(p = {numeral(after.p_value, '.2g')})."
    )
    value, error = found.value(cause.free[0]) if cause.free else (None, None)
    return Explanation(
        cause.name, outcome, text, True, value, error, before.value, after.value, after.freedom,
        after.p_value, headline,
    )  # fmt: skip


# -- the causes and their sentences ----------------------------------------------------------------


def _pm(found: tuple[float, float], form: str = ".5g", of_error: str = ".2g") -> str:
    return f"{numeral(found[0], form)} ± {numeral(found[1], of_error)}"


def _media(both: Both) -> list[dict[str, Any]]:
    """The media at the density of the scatterers, where there is a theory of them.

    For smooth disks in the plane at a density that is told (not fitted to the same data); not for
    particles that are known to meet no scatterer again.
    """
    from kinetics.collision.medium import HIGHEST_DENSITY

    scene, fitted = both.solution.scene, both.found is not None and "path" in both.found.free
    known = scene.restitution >= _LEAST_RESTITUTION and scene.number_density <= HIGHEST_DENSITY
    if fitted or both.sample.free or not known or not both.sample.law.smooth_disks:
        return []
    return [{"scatterers": medium} for medium in MEDIA]


def _of_density(both: Both, found: Fit) -> tuple[str, str]:
    from kinetics.collision.medium import SETTLED, TESTED_DENSITY

    kind, n = found.point.scatterers, both.solution.scene.number_density
    changes = found.theory[:, -1] / both.theory[:, -1] - 1
    text = (
        f"The finite density of the scatterers, n = ρ₀d² = {numeral(n, '.4g')}, as {MEDIA[kind]}: "
        f'the equation of Scene(scatterers="{kind}"), in which tracers meet scatterers again; '
        f"nothing is fitted. At the last time it changes v₀ by {numeral(changes[0], '+.2%')} and "
        f"⟨r²⟩ by {numeral(changes[2], '+.2%')}. It is trusted from {SETTLED:g} l/U on, and its "
        f"own error, known from simulations up to n = {TESTED_DENSITY:g}, is added to the "
        "covariance."
    )
    return text, f"the finite density of the scatterers ({kind}, no fitted number)"


def _of_path(both: Both, found: Fit) -> tuple[str, str]:
    scene, law, (value, error) = both.solution.scene, both.sample.law, found.value("path")
    told, path = scene.mean_free_path, f"l = {_pm((value, error))} d"
    density, share = numeral(law.free_path(value), ".5g"), math.pi * scene.number_density / 4
    text = f"Another mean free path: {path} fits best, {numeral(value / told - 1, '+.1%')} from "
    text += f"{numeral(told, '.5g')} d, as a density of {density} d^-{law.dimension} would have."
    if law.smooth_disks and share < 0.5:
        # Henderson, Mol. Phys. 30, 971 (1975): the pair correlation of hard disks at contact
        disks = told * (1 - share) ** 2 / (1 - 7 * share / 16)
        near = abs(value - disks) <= 3 * error and value < told
        text += (
            f" Hard disks that do not overlap have l = {numeral(disks, '.5g')} d at this density"
        )
        text += ": that is the finite density of the scatterers." if near else "."
    headline = f"{path} in place of {numeral(told, '.5g')} d"
    if abs(math.log(value / told)) > 1 and law.dimension == 2:  # a wrong diameter is likely
        headline += f" (as if d were {told / value:.4g} of the unit told)"
    return text, headline


def _of_restitution(both: Both, found: Fit) -> tuple[str, str]:
    told, e = numeral(both.point.restitution, ".5g"), _pm(found.value("restitution"))
    text = f"Another restitution: e = {e} fits best, instead of {told}."
    return text, f"e = {e} in place of {told}"


def _other_starts(both: Both) -> list[dict[str, Any]]:
    """The data's own speeds at time 0, or the other named start."""
    start = both.sample.start
    if start is not None:
        return [] if both.own_start else [{"start": SampledStart(start)}]
    return [{"start": n} for n in ("gaussian", "monoenergetic") if n != both.point.start]


def _of_start(both: Both, found: Fit) -> tuple[str, str]:
    named = {"gaussian": "a Gaussian", "monoenergetic": "all speeds U"}
    start = found.point.start
    words = named[start] if isinstance(start, str) else "the data's own speeds at time 0"
    return f"Another start: {words}, the rest as told.", f"another start ({words})"


def _of_unit(symbol: str, name: str) -> Callable[[Both, Fit], tuple[str, str]]:
    def words(both: Both, found: Fit) -> tuple[str, str]:
        value = f"{symbol} = {_pm(found.value(name))}"
        text = f"Another {name.replace('_', ' ')}: with {value} in the data's unit, instead of 1, "
        return text + "the equation fits best.", f"{value} in place of 1 in the data's unit"

    return words


def _of_rest(both: Both, found: Fit) -> tuple[str, str]:
    share = f"a share of {_pm(found.value('at_rest'), '.2%', '.2%')} of tracers that never move"
    return f"{share.capitalize()} fits best.", share


def _always(both: Both) -> list[dict[str, Any]]:
    return [{}]


CAUSES = (
    Cause("finite density", _media, _of_density),
    Cause("free path", _always, _of_path, ("path",)),
    Cause("restitution", _always, _of_restitution, ("restitution",)),
    Cause("initial speeds", _other_starts, _of_start),
    Cause("speed unit", lambda both: [] if both.own_start else [{}], _of_unit("U", "speed_unit"),
          ("speed_unit",)),
    Cause("time unit", _always, _of_unit("d/U", "time_unit"), ("time_unit",)),
    Cause("length unit", _always, _of_unit("d", "length_unit"), ("length_unit",)),
    Cause("tracers at rest", _always, _of_rest, ("at_rest",)),
)  # fmt: skip
"""Everything that may explain a difference. The first, which has no free parameter, stands before
others that are as likely. A new cause is one row."""

# -- units that do not belong together -------------------------------------------------------------

_FAR, _MOST = 2.0, 0.5
"""Factor by which speeds are in another unit, and the share of tracers that have not collided."""
_WRONG_ABOVE = 0.005
"""|ln(|r|/(|v| t))| from which on units do not belong together."""


def wrong_unit(sample: Sample, start: Any) -> Explanation | None:
    """What is said where units do not belong together; None where they do, or cannot be known.

    Tracers that have not collided are at r = v t. Speeds never rise, so that larger ones than at a
    named start cannot be; smaller ones cannot be while most tracers have not collided. A factor of
    two is asked for: less may be another start.
    """
    flights = sample.flights
    if sample.law.field:
        return None
    if flights is not None and abs(math.log(flights.ratio)) > _WRONG_ABOVE:
        found, inverse = (numeral(x, ".5g") for x in (flights.ratio, 1 / flights.ratio))
        headline = (
            f"tracers that fly straight have r = {found} v t, as if times were {inverse} times"
        )
        text = (
            f"At t = {numeral(flights.time, '.4g')}, {numeral(flights.share, '.0%')} of the "
            f"tracers have flown straight, at r = {found} v t, which is r = v t in units that "
            "belong together. Say so by --time-unit, --length-unit or --speed-unit. No other cause "
            "is looked for."
        )
        value = 1 / flights.ratio
        return Explanation("time unit", "found", text, True, value, headline=f"{headline} too long")
    if not isinstance(start, str):
        return None
    most = np.sqrt(sample.law.dimension) if start == "gaussian" else 1.0
    total = sample.sums[:, 0].sum(axis=0)
    ratio = float(sample.speed_scale[0] * np.sqrt(total[V2] / total[N]) / most)
    early = flights is not None and flights.share > _MOST and flights.time <= sample.times[:2].max()
    if not (ratio > _FAR or (ratio < 1 / _FAR and early)):
        return None
    text = (
        f"At t = {numeral(sample.times[0], '.4g')} the root mean square speed is "
        f"{numeral(ratio * most, '.5g')} U, where the start has {numeral(most, '.4g')} U: speeds "
        "are in another unit. Say so by --speed-unit (a number, or data where there is a time 0), "
        "and give the diameter by --length-unit. No other cause is looked for."
    )
    headline = f"speeds at the first time are {ratio:.4g} times those of the start"
    return Explanation("speed unit", "found", text, True, ratio, headline=headline)


# -- notes -----------------------------------------------------------------------------------------

_FAR_SLOWER = 8.0
"""A trapped tracer is that many times slower than the upper end of the lowest bin: a wrong
restitution, density or start, which shift all speeds a little, cannot put a tracer there."""
_FEWEST_TRAPPED = 5


def notes_of(both: Both) -> Iterator[Explanation]:
    """Everything that is to be noted, whether or not data and theory differ."""
    for note in (_traps, _missing, _not_forgotten):
        if (found := note(both)) is not None:
            yield found
    if both.own_start and both.histograms:
        text = (
            "The theory starts from the data's own speeds. The averages' errors allow for that; "
            "p-values of densities are too high while most tracers have not collided."
        )
        yield Explanation("own start", "noted", text, False)


def _traps(both: Both) -> Explanation | None:
    """Tracers at the last time that are far slower than the theory's slowest, or at rest."""
    rest, most = int(both.sample.at_rest.max()), int(both.sample.samples.max())
    for h in [h for h in both.histograms if h.name == SPEED][-1:]:
        binned, density = both.sample.speeds, both.densities[SPEED]
        assert binned is not None
        edges = binned.edges[h.index]
        cut = int(np.searchsorted(edges, h.edges[1] / _FAR_SLOWER))
        at = int(np.argmin(np.abs(density.times - h.time)))
        count = int(binned.totals[h.index, : cut + 1].sum())
        expected = float(bin_shares(density, SPEED, at, edges)[: cut + 1].sum()) * h.samples
        excess = count - expected
        if count < _FEWEST_TRAPPED or excess < DIFFERS_ABOVE * math.sqrt(max(expected, count)):
            break
        share, error = excess / h.samples, math.sqrt(count) / h.samples
        text = (
            f"Traps: at t = {numeral(h.time, '.4g')}, {count} tracers are slower than "
            f"{numeral(edges[cut], '.3g')} U, where {numeral(expected, '.3g')} are expected: an "
            f"excess of {_pm((share, error), '.2%', '.2%')} of all; {rest} have speed zero. "
            "Tracers caught in corners between scatterers, or stopped by a program, are such."
        )
        return Explanation("traps", "found", text, True, share, error)
    text = f"{rest} tracers have speed zero at some time, which only trapped ones have."
    return Explanation("traps", "found", text, True, rest / most) if rest else None


def _missing(both: Both) -> Explanation | None:
    """Fewer tracers at later times: what is left is biased, and the complete times tell."""
    sample, samples = both.sample, both.sample.samples
    most, least = int(samples.max()), int(np.argmin(samples))
    complete = samples == most
    if np.all(complete):
        return None
    whole, part = (
        hotelling(*both.flat(choose_components(both.usable & times, sample.groups, 1)))
        for times in (complete, ~complete)
    )
    missing = most - int(samples[least])
    cap = f" (stopped after {sample.capped} collisions)" if sample.capped is not None else ""
    text = (
        f"Tracers are missing{cap}: {missing} of {most} at t = "
        f"{numeral(sample.times[least], '.4g')}. A cap on collisions takes the fast ones away, and "
        "what is left is too slow."
    )
    outcome = "noted" if part is None else "does not"
    if part is not None and part.p_value < AGREES_ABOVE:
        outcome = "explains" if whole is None or whole.p_value >= AGREES_ABOVE else "in part"
        text += f" At the times without all of them p = {numeral(part.p_value, '.2g')}."
    left = (None, None, None) if whole is None else (whole.value, whole.freedom, whole.p_value)
    return Explanation(
        "missing tracers", outcome, text, part is not None, missing / most, None,
        None if part is None else part.value, *left,
    )  # fmt: skip


def _not_forgotten(both: Both) -> Explanation | None:
    """Whether the theory itself is still on its way to the scaling state."""
    from kinetics import ScalingSolution

    e, law = both.point.restitution, both.sample.law
    if (e >= 1 and law.tangential_restitution >= 1) or "a2" not in both.names:
        return None
    i = both.names.index("a2")
    exact = ScalingSolution(e, law.tangential_restitution, law.dimension).a2
    last = float(both.theory[i, -1])
    # Written so that a theory that is not finite is left out.
    if not abs(last - exact) >= max(0.01 * (1 + exact), float(both.error[i, -1])):
        return None
    text = (
        f"At the last time the equation itself has a₂ = {numeral(last, '.4f')}, the scaling state "
        f"{numeral(exact, '.4f')}: the start is not forgotten, without anything being wrong."
    )
    return Explanation("start not forgotten", "noted", text, False, last - exact)
