"""What may explain a difference: each cause is a row of the table CAUSES, and one fit.

A cause says which parameters of the theory (`theory.Point`) are other than what was told: set to a
value, or free. Each is tried in every medium that the scatterers may be. It explains if what it
leaves agrees and its value lies CLEARLY from what was told; those that explain are ranked by the
likelihood that they leave (`Fit.criterion`), and only those near the best are said to.
"""

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

from kinetics.crosscheck.compare.fit import Fit, components_of, coordinates, fit, media_of
from kinetics.crosscheck.compare.judge import Both
from kinetics.crosscheck.compare.result import Explanation
from kinetics.crosscheck.compare.statistics import AGREES_ABOVE, ChiSquare, hotelling
from kinetics.crosscheck.compare.theory import Point, SampledStart
from kinetics.crosscheck.words import number, numeral

CLEARLY = 3.0  # errors by which a fitted value must differ from what was told
NEAR_BEST = 6.0  # -2 ln likelihood from the best up to which a cause explains as well
_LEAST_GAIN = 16.0  # of T^2 by one parameter, 4 sigma, and a tenth of it: less explains nothing
_FACTORS = (0.0, -2.0, 2.0, -5.0, 5.0, -9.0, 9.0)  # where ln of a unit or free path is looked for
_SHARES = (0.02, 0.3, 0.9)  # of the smallest mean square: where variances of noise are
_LATER = (0.3, -0.3, 3.0)  # offsets of the clock that are tried, in the first time above 0


class Cause(NamedTuple):
    """A cause: its name, the parameter that is fitted and its symbol, the unit in which that is
    said, or the kind of the data's own unit; of noise, in what it is.
    """

    name: str
    free: str = ""
    symbol: str = ""
    unit: str = ""
    kind: str = ""
    title: str = ""


CAUSES = (
    Cause("finite density"),
    Cause("restitution", "restitution", "e"),
    Cause("free path", "path", "l", " d"),
    Cause("initial speeds"),
    Cause("speed unit", "speed_unit", "U", kind="speed"),
    Cause("time unit", "time_unit", "d/U", kind="time"),
    Cause("length unit", "length_unit", "d", kind="length"),
    Cause("time offset", "time_offset", "the zero of the clock t₀", " d/U", "time"),
    Cause("velocity noise", "velocity_noise", unit="U", title="velocity"),
    Cause("position noise", "position_noise", unit="d", title="displacement"),
    Cause("tracers at rest", "at_rest", "the share f of tracers that never move"),
)
"""Everything that may explain a difference: a new cause is one row, and a place in `_starts`."""


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
        for change in _changes(cause, both, media):
            point, free = both.point._replace(**change), (cause.free,) if cause.free else ()
            starts: list[Any] = [(x,) for x in _starts(cause, both, point)] if free else [()]
            if free and found:  # begins from the fit in another medium
                starts = [found[0].at, starts[0]]
            # a restitution or a density of which there is no theory
            with suppress(ValueError):
                made = fit(both.expectation, point, free, components, starts)
                found += [made] if made and made.chi_square else []
        judged = [(_judged(both, cause, one, before), one) for one in found]
        tested += sorted(judged, key=rank)[: 1 if cause.free else None]
    tested.sort(key=rank)
    for item, one in tested:
        far = item.outcome == "explains" and cost(one) > cost(tested[0][1]) + NEAR_BEST
        yield item._replace(outcome="in part") if far else item, one.point.scatterers


def _changes(cause: Cause, both: Both, media: Sequence[str]) -> list[dict[str, Any]]:
    """What a cause sets to other values, a dictionary for each variant."""
    point, start = both.point, both.sample.start
    in_media: list[dict[str, Any]] = [{"scatterers": medium} for medium in media]
    if cause.name == "finite density":
        others = media_of(both.sample, "every", point)
        return [{"scatterers": medium} for medium in others if medium not in media]
    if cause.name == "initial speeds":  # the data's own, or the other named start
        own = [SampledStart(start)] if start is not None and not point.own_start else []
        named = [] if start else sorted({"gaussian", "monoenergetic"} - {point.start})
        return [{"start": one} | medium for one in (*own, *named) for medium in in_media]
    return [] if cause.name == "speed unit" and point.own_start else in_media


def _starts(cause: Cause, both: Both, point: Point) -> list[float]:
    """Where the fit of a parameter, or of its logarithm, begins."""
    name, sample = cause.free, both.sample
    after = sample.times > 0
    if name == "restitution":
        return [point.restitution, 0.9, 0.5]
    if name == "time_offset":
        return [share * float(sample.times[after][0]) for share in _LATER]
    if name == "at_rest":
        return [0.0]
    if name in ("velocity_noise", "position_noise"):
        square = both.expectation.values[0] ** 2 if name[0] == "v" else both.expectation.values[2]
        least = float(square[after & (square > 0)].min(initial=1e9))
        return [share * least / sample.law.dimension for share in _SHARES]
    return [math.log(getattr(point, name)) + shift for shift in _FACTORS]


def _judged(both: Both, cause: Cause, found: Fit, before: ChiSquare) -> Explanation:
    """What a cause comes to, from the chi-square that it leaves."""
    after, outcome, clear = found.chi_square, "does not", True
    assert after is not None
    if cause.free:
        away = abs(float((found.at - coordinates(both.point, found.free))[0]))
        clear = away > CLEARLY * math.sqrt(found.covariance[0, 0])
        clear &= 0 <= found.point.at_rest < 0.85
    if after.p_value >= AGREES_ABOVE:
        # Averages that agreed already need no explaining.
        outcome = "explains" if clear and before.p_value < AGREES_ABOVE else "does not"
    elif clear and before.statistic - after.statistic > max(_LEAST_GAIN, 0.1 * before.statistic):
        outcome = "in part"
    headline, value, error = _words(both, cause, found)
    if found.point.scatterers not in ("dilute", both.point.scatterers) and cause.free:
        headline += f" (among {found.point.scatterers})"
    numbers = [numeral(x, ".4g") for x in (before.value, after.value)]
    text = f"{headline[0].upper()}{headline[1:]}. The averages' chi-square goes from {numbers[0]} "
    text += f"to {numbers[1]} with {after.freedom} degrees of freedom "
    text += f"(p = {numeral(after.p_value, '.2g')}), scatterers: {found.point.scatterers}."
    return Explanation(
        cause.name, outcome, text, True, value, error, before.value, *after[:3], headline
    )


def _words(both: Both, cause: Cause, found: Fit) -> tuple[str, float | None, float | None]:
    """The headline of a cause, its value and its error as they are said."""
    medium = found.point.scatterers.replace("overlapping", "overlapping disks")
    if cause.name == "finite density":
        return f"the finite density of the scatterers ({medium}, no fitted number)", None, None
    if not cause.free:
        return f"another start ({found.point.start_in_words})", None, None
    value, error = found.value(cause.free)
    if "noise" in cause.name:  # of a variance the root
        size = math.sqrt(max(value, 0.0))
        width = error / (2 * size) if size else math.sqrt(error)
        said = f"noise of {number(size, width)} {cause.unit} in each component of the {cause.title}"
        return said, size, width
    told = float(getattr(both.point, cause.free))
    unit = both.sample.units.get(cause.kind, 1.0)  # in the data's own
    name = cause.unit if unit == 1.0 else ""
    said = f"{cause.symbol} = {number(value * unit, error * unit)}{name} in place of "
    return f"{said}{numeral(told * unit, '.5g')}{name}", value * unit, error * unit
