"""What may explain a difference: each cause is a row of the table CAUSES, and one fit.

A cause says which parameters of the theory (`theory.Point`) are other than what was told: set to a
value, or free. Each is tried in every medium that the scatterers may be. It explains if what it
leaves agrees and its value lies CLEARLY from what was told; those that explain are ranked by the
likelihood that they leave (`Fit.criterion`), and only those near the best are said to. Units that
do not belong together, and particles that never move, come first: then nothing else is claimed.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from kinetics.crosscheck.compare.fit import Fit, choose, components_of, fit, media_of
from kinetics.crosscheck.compare.judge import Both
from kinetics.crosscheck.compare.result import OUTCOMES, Explanation
from kinetics.crosscheck.compare.statistics import ChiSquare, chance, hotelling
from kinetics.crosscheck.compare.theory import Point, SampledStart
from kinetics.crosscheck.data.sample import V2, N, Sample
from kinetics.crosscheck.words import AGREES_BELOW, Verdict, number, numeral

AGREES_ABOVE = chance(AGREES_BELOW)  # p-value from which on what a cause leaves agrees
CLEARLY = 3.0  # errors by which a fitted value must differ from what was told
# -2 ln likelihood from the best up to which a cause explains as well: then 20 times less likely
NEAR_BEST = 6.0
# of T^2 by one parameter, 4 sigma, and at least a tenth of it: less is no explanation
_LEAST_GAIN = 16.0
# logarithms of the factors from which a unit or a free path is looked for
_FACTORS = (0.0, -2.0, 2.0, -5.0, 5.0, -9.0, 9.0)
# of the smallest mean square, from which the variance of noise is looked for
_SHARES = (0.02, 0.3, 0.9)
_LATER = (0.3, -0.3, 3.0)  # offsets of the clock that are tried, in the first time above 0


def start_in_words(start: Any) -> str:
    """A start as the middle of a sentence."""
    named = {"gaussian": "a Gaussian start", "monoenergetic": "a start with all speeds U"}
    return named.get(start, start) if isinstance(start, str) else "the data's own speeds at time 0"


def explained(
    both: Both, verdict: Verdict, wrong: Explanation | None, media: Sequence[str]
) -> tuple[list[Explanation], str]:
    """What explains a difference or is to be noted, the likeliest first, and in which medium."""
    medium, law = both.point.scatterers, both.sample.law
    if wrong or law.is_driven or law.field:
        return [wrong] if wrong else [], medium
    notes = [note for note in (_traps(both), _missing(both)) if note]
    tested = []
    if verdict in (Verdict.DIFFERS, Verdict.UNCLEAR):
        tested = list(tested_causes(both, media))
        if tested and tested[0][0].outcome == "explains":
            medium = tested[0][1]
    found = [*(item for item, _ in tested), *notes]
    # Python's sort keeps the order of those of one outcome: the likeliest stays first.
    return sorted(found, key=lambda item: [*OUTCOMES].index(item.outcome)), medium


def tested_causes(both: Both, media: Sequence[str]) -> Iterator[tuple[Explanation, str]]:
    """Every cause in its best medium, the likeliest first; none if too few averages have spread."""
    # Not time 0: there a cause in the start would leave nothing that could differ.
    usable = both.usable & (both.sample.times > 0)
    components = components_of(both.names, usable, both.sample.groups, 1)
    before = hotelling(*both.flat(components[1]))
    if components[1].size < 2 or not components[0].size or before is None:
        return

    def cost(one: Fit) -> float:  # where two are as good, the one that fits no number is first
        return one.criterion + 2.0 * one.at.size

    def rank(pair: tuple[Explanation, Fit]) -> tuple[bool, float]:  # what explains stands first
        return pair[0].outcome != "explains", cost(pair[1])

    tested: list[tuple[Explanation, Fit]] = []
    for cause in CAUSES:
        found: list[Fit] = []
        for change in cause.changes(both, media):
            found += _fitted(both, cause, change, components, found[:1])
        judged = [(_judged(both, cause, one, before), one) for one in found]
        tested += sorted(judged, key=rank)[: 1 if cause.free else None]
    tested.sort(key=rank)
    for item, one in tested:
        far = item.outcome == "explains" and cost(one) > cost(tested[0][1]) + NEAR_BEST
        yield replace(item, outcome="in part") if far else item, one.point.scatterers


def _fitted(
    both: Both, cause: "Cause", change: dict[str, Any], components: Any, near: Sequence[Fit]
) -> list[Fit]:
    """The fit of a cause, or none; near: that in another medium, from which it begins."""
    point = both.point._replace(**change)
    starts: list[Any] = [(x,) for x in cause.starts(both, point)] if cause.free else [()]
    if cause.free and near:
        starts = [near[0].at, starts[0]]
    try:
        found = fit(both.expectation, point, cause.free, components, starts)
    except ValueError:  # a restitution or a density of which there is no theory
        return []
    return [found] if found and found.chi_square else []


def _judged(both: Both, cause: "Cause", found: Fit, before: ChiSquare) -> Explanation:
    """What a cause comes to, from the chi-square that it leaves."""
    after, outcome = found.chi_square, "does not"
    assert after is not None
    value, error, clear = None, None, True
    if cause.free:
        value, error = found.value(*cause.free)
        away = float((found.at - found.coordinates(both.point))[0])
        width = CLEARLY * math.sqrt(found.covariance[0, 0])
        clear = abs(away) > width and 0 <= found.point.at_rest < 0.85
    if after.p_value >= AGREES_ABOVE:
        # Averages that agreed already need no explaining.
        outcome = "explains" if clear and before.p_value < AGREES_ABOVE else "does not"
    elif clear and before.statistic - after.statistic > max(_LEAST_GAIN, 0.1 * before.statistic):
        outcome = "in part"
    text, headline, value, error = cause.words(both, found, value, error)
    if found.point.scatterers not in ("dilute", both.point.scatterers) and cause.free:
        headline += f" ({among(found.point.scatterers)})"
    numbers = [numeral(x, ".4g") for x in (before.value, after.value)]
    text += f" The averages' chi-square goes from {numbers[0]} to {numbers[1]} with "
    text += f"{after.freedom} degrees of freedom (p = {numeral(after.p_value, '.2g')}), "
    text += f"{among(found.point.scatterers)}."
    return Explanation(
        cause.name, outcome, text, True, value, error, before.value, after.value, after.freedom,
        after.p_value, headline,
    )  # fmt: skip


# the sentence and the headline of a cause, its value and its error as they are said
Words = tuple[str, str, float | None, float | None]


def among(scatterers: str) -> str:
    """The medium as the end of a sentence."""
    longer = {"dilute": "dilute scatterers", "overlapping": "overlapping disks"}
    return f"among {longer.get(scatterers, scatterers)}"


def _of_medium(both: Both, found: Fit, value: Any, error: Any) -> Words:
    n = numeral(both.sample.law.free_path(both.point.path), ".4g")
    v0, r2 = (numeral(found.theory[k, -1] / both.theory[k, -1] - 1, "+.2%") for k in (0, 2))
    where = among(found.point.scatterers)
    text = f"Another medium: {where} at n = ρ₀d² = {n} v₀ changes by {v0} and ⟨r²⟩ by {r2} at the "
    text += "last time. Nothing is fitted; an error of the theory is in the covariance."
    return text, f"the finite density of the scatterers ({where}, no fitted number)", None, None


def _media(both: Both, media: Sequence[str]) -> list[dict[str, Any]]:
    return [{"scatterers": medium} for medium in media]


def _other_media(both: Both, media: Sequence[str]) -> list[dict[str, Any]]:
    return _media(both, [m for m in media_of(both.sample, "every", both.point) if m not in media])


def _other_starts(both: Both, media: Sequence[str]) -> list[dict[str, Any]]:
    """The data's own speeds at time 0, or the other named start."""
    start, named = both.sample.start, {"gaussian", "monoenergetic"} - {both.point.start}
    own: Any = [] if both.point.own_start or start is None else [SampledStart(start)]
    others = own if start else sorted(named)
    return [{"start": one} | medium for one in others for medium in _media(both, media)]


def _of_start(both: Both, found: Fit, value: Any, error: Any) -> Words:
    words = start_in_words(found.point.start)
    return f"Another start: {words}, the rest as told.", f"another start ({words})", None, None


def _of_number(symbol: str, title: str, kind: str = "", unit: str = "") -> Any:
    """Of a number in place of what was told; kind: of a unit, which is said in the data's own."""

    def words(both: Both, found: Fit, value: float, error: float) -> Words:
        told = float(getattr(both.point, found.free[0]))
        size, own = both.sample.units.get(kind, (1.0, ""))
        name = f" {own}" if own else unit
        text = f"{symbol} = {number(value * size, error * size)}{name} in place of "
        text += f"{numeral(told * size, '.5g')}{name}"
        return f"Another {title}: {text} fits best.", text, value * size, error * size

    return words


def _of_noise(title: str, unit: str) -> Any:
    def words(both: Both, found: Fit, value: float, error: float) -> Words:
        size = math.sqrt(max(value, 0.0))
        width = error / (2 * size) if size else math.sqrt(error)
        text = f"noise of {number(size, width)} {unit} in each component of the {title}"
        return f"{text[0].upper()}{text[1:]}.", text, size, width

    return words


def _factors(name: str) -> Any:
    return lambda both, point: [math.log(getattr(point, name)) + shift for shift in _FACTORS]


def _noise(name: str, output: int) -> Any:
    def starts(both: Both, point: Point) -> list[float]:
        found = both.expectation.values[output] ** (2 if output == 0 else 1)
        known = found[(both.sample.times > 0) & (found > 0)]
        return [s * float(known.min(initial=1e9)) / both.sample.law.dimension for s in _SHARES]

    return starts


def _offsets(both: Both, point: Point) -> list[float]:
    first = both.sample.times[both.sample.times > 0][0]
    return [share * float(first) for share in _LATER]


class Cause(NamedTuple):
    """A cause: its words, the parameter that is fitted and where to begin, and what is set.

    changes : one dictionary for each variant; none where the cause does not apply
    """

    name: str
    words: Callable[[Both, Fit, Any, Any], Words]
    free: tuple[str, ...] = ()
    starts: Callable[[Both, Point], Sequence[float]] = lambda both, point: (0.0,)
    changes: Callable[[Both, Sequence[str]], Sequence[dict[str, Any]]] = _media


CAUSES = (
    Cause("finite density", _of_medium, changes=_other_media),
    Cause("restitution", _of_number("e", "restitution"), ("restitution",),
          lambda both, point: (point.restitution, 0.9, 0.5)),
    Cause("free path", _of_number("l", "mean free path", "", " d"), ("path",), _factors("path")),
    Cause("initial speeds", _of_start, changes=_other_starts),
    Cause("speed unit", _of_number("U", "unit of speed", "speed"), ("speed_unit",),
          _factors("speed_unit"),
          lambda both, media: [] if both.point.own_start else _media(both, media)),
    Cause("time unit", _of_number("d/U", "unit of time", "time"), ("time_unit",),
          _factors("time_unit")),
    Cause("length unit", _of_number("d", "unit of length", "length"), ("length_unit",),
          _factors("length_unit")),
    Cause("time offset", _of_number("t₀", "zero of the clock", "time", " d/U"), ("time_offset",),
          _offsets),
    Cause("velocity noise", _of_noise("velocity", "U"), ("velocity_noise",), _noise("v", 0)),
    Cause("position noise", _of_noise("displacement", "d"), ("position_noise",), _noise("r", 2)),
    Cause("tracers at rest", _of_number("f", "share of tracers that never move"), ("at_rest",)),
)  # fmt: skip
"""Everything that may explain a difference. A new cause is one row."""

_NO_OTHER = "No other cause is looked for."
_PUT_RIGHT = f"; put it right by --time-unit, --length-unit or --speed-unit. {_NO_OTHER}"


def _found(
    name: str, headline: str, more: str, value: float, error: Any = None, time: float | None = None
) -> Explanation:
    """What the data show by themselves, without a fit, at a time or at all."""
    text = headline if time is None else f"at t = {numeral(time, '.4g')}, {headline}"
    text = f"{text[0].upper()}{text[1:]}{more}"
    return Explanation(name, "found", text, True, value, error, headline=headline)


def wrong_unit(sample: Sample, start: Any) -> Explanation | None:
    """What is said where units do not belong together; None where they do, or cannot be known.

    Before a collision r = v t: |ln(r/(v t))| above .005 is a wrong unit. Speeds twice as large as
    at a named start cannot be, nor half as large while most tracers have not collided.
    """
    law, flights, unit = sample.law, sample.flights, sample.units.get("time", (1.0, ""))
    if law.field or law.is_driven:
        return None
    if flights and abs(math.log(flights[0].ratio)) > 0.005:
        at, value = flights[0].time, 1 / flights[0].ratio
        straight = f"tracers that fly straight have r = {numeral(flights[0].ratio, '.5g')} v t"
        # the true times of two: in proportion, if it is a unit; with the same offset, if the clock
        true = [one.time * one.ratio for one in flights]
        slope = abs(np.diff(true)[0] / (flights[1].time - at)) if len(true) > 1 else math.inf
        if abs(math.log(slope)) < 0.005:
            value = (at - true[0]) * unit[0]
            headline = f"{straight} at t = {numeral(at, '.4g')}, as if the clock were "
            headline += f"{numeral(value, '.4g')} {unit[1] or 'd/U'} ahead"
            return _found("time offset", headline, f"; shift the times. {_NO_OTHER}", value)
        headline = f"{straight}, as if times were {numeral(value, '.5g')} times too long"
        return _found("time unit", headline, _PUT_RIGHT, value, time=at)
    if not isinstance(start, str):
        return None
    most = np.sqrt(law.dimension) if start == "gaussian" else 1.0
    total = sample.sums[:, 0].sum(axis=0)
    ratio = float(sample.speed_scale[0] * np.sqrt(total[V2] / total[N]) / most)
    early = any(one.share > 0.5 and one.time <= sample.times[:2].max() for one in flights)
    if 0.5 <= ratio <= 2.0 or (ratio < 0.5 and not early):
        return None
    headline = f"speeds at the first time are {ratio:.4g} times those of the start"
    return _found("speed unit", headline, _PUT_RIGHT, ratio, time=sample.times[0])


def _traps(both: Both) -> Explanation | None:
    """Tracers that have speed zero at some time, which only trapped ones have."""
    rest, most = int(both.sample.at_rest.max()), int(both.sample.samples.max())
    more = ": caught between scatterers, or stopped by a program."
    return _found("traps", f"{rest} tracers come to rest", more, rest / most) if rest else None


def never_move(sample: Sample) -> Explanation | None:
    """Particles that have speed zero at every time: of late times alone one in 100 at least, as
    tracers may have come to rest before.
    """
    rest, most = int(sample.at_rest.min()), int(sample.samples.max())
    late = sample.times[0] > 0 and rest < 0.01 * most
    if not rest or late or sample.times.size < 2 or sample.law.is_driven:
        return None
    headline = f"{numeral(rest / most, '.2%')} of the particles ({rest}) never move"
    more = ": are these the scatterers? Choose the tracers by --type, or leave the others out."
    return _found("scatterers", headline, more, rest / most)


def _missing(both: Both) -> Explanation | None:
    """Fewer tracers at later times: what is left is biased, and the complete times tell."""
    sample, samples = both.sample, both.sample.samples
    most, least = int(samples.max()), int(np.argmin(samples))
    complete = samples == most
    if np.all(complete):
        return None
    whole, part = (
        hotelling(*both.flat(choose(both.usable & times, sample.groups, 1)))
        for times in (complete, ~complete)
    )
    missing, outcome = most - int(samples[least]), "does not" if part else "noted"
    text = f"{missing} of {most} tracers are missing at t = {numeral(sample.times[least], '.4g')}. "
    text += "A cap on collisions takes the fast ones away."
    if part is not None and part.p_value < AGREES_ABOVE:
        outcome = "explains" if whole is None or whole.p_value >= AGREES_ABOVE else "in part"
    headline = f"{missing} tracers that are missing at later times"
    return Explanation(
        "missing tracers", outcome, text, part is not None, missing / most, None,
        part and part.value, whole and whole.value, whole and whole.freedom,
        whole and whole.p_value, headline,
    )  # fmt: skip
