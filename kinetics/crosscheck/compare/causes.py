"""What may explain a difference: each cause is a row of the table CAUSES, and one fit.

A cause says which parameters of the theory (`theory.Point`) are other than what was told, set to a
value or free, or that components of the data are exchanged. Each is tried in every medium that the
scatterers may be. It explains if what it leaves agrees and its value lies clearly from what was
told; those that explain are ranked by the likelihood that they leave (`Fit.criterion`), and only
those near the best are said to.
"""

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

from kinetics.crosscheck.compare.fit import LIMITS, ChiSquare, Fit, choose, fit, hotelling, media_of
from kinetics.crosscheck.compare.result import Explanation
from kinetics.crosscheck.compare.theory import BEAM, Expectation, Point, SampledStart
from kinetics.crosscheck.data.sample import VX, X2, X
from kinetics.crosscheck.words import Verdict, limit_factor, number, numeral

NEAR_BEST = 6.0  # -2 ln likelihood from the best up to which a cause explains as well


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
    Cause("components exchanged"),
    Cause("speed unit", "speed_unit", "U", kind="speed"),
    Cause("time unit", "time_unit", "d/U", kind="time"),
    Cause("length unit", "length_unit", "d", kind="length"),
    Cause("time offset", "time_offset", "the zero of the clock t₀", " d/U", "time"),
    Cause("velocity noise", "velocity_noise", unit="U", title="velocity"),
    Cause("position noise", "position_noise", unit="d", title="displacement"),
    Cause("tracers at rest", "at_rest", "the share f of tracers that never move"),
)
"""Everything that may explain a difference: a new cause is one row, and a place in `_starts`."""
_EXCHANGED = {"positions": (X, X2), "velocities": (VX,), "positions and velocities": (VX, X, X2)}


def tested_causes(told: Fit, media: Sequence[str]) -> Iterator[tuple[Explanation, str]]:
    """Every cause in its best medium, the likeliest first; none if too few averages have spread."""
    # Not time 0: there a cause in the start would leave nothing that could differ.
    usable = told.usable & (told.expectation.sample.times > 0)
    chosen = choose(usable, told.expectation.sample.groups)
    before = hotelling(*told.flat(chosen))
    if chosen.size < 2 or before is None:
        return

    def cost(one: Fit) -> float:  # where two are as good, the one that fits no number is first
        return one.criterion + 2.0 * one.at.size

    def rank(pair: tuple[Explanation, Fit]) -> tuple[bool, float]:  # what explains stands first
        return pair[0].outcome != "explains", cost(pair[1])

    tested: list[tuple[Explanation, Fit]] = []
    for cause in CAUSES:
        found: list[Fit] = []
        for measured, point in _variants(cause, told, media):
            free = (cause.free,) if cause.free else ()
            starts = [[x] for x in _starts(cause, told, point)] if free else []
            if free and found:  # begins from the fit in another medium
                starts = [found[0].at.tolist(), starts[0]]
            # a restitution or a density of which there is no theory
            with suppress(ValueError):
                made = fit(measured, point, free, usable, starts)
                found += [made] if made and made.chi_square else []
        judged = sorted(((_judged(told, cause, one, before), one) for one in found), key=rank)
        every = cause.name in ("finite density", "initial speeds")
        tested += judged if every else judged[:1]
    tested.sort(key=rank)
    for item, one in tested:
        far = item.outcome == "explains" and cost(one) > cost(tested[0][1]) + NEAR_BEST
        yield item._replace(outcome="in part") if far else item, one.point.scatterers


def _variants(cause: Cause, told: Fit, media: Sequence[str]) -> Iterator[tuple[Expectation, Point]]:
    """The data and the theory, but for what is fitted, of every variant of a cause."""
    measured, point, changes = told.expectation, told.point, list[dict[str, Any]]([{}])
    law, start = measured.sample.law, measured.sample.start
    if cause.name == "components exchanged":
        yield from (
            (measured.with_exchanged(axis, columns, what), point._replace(scatterers=medium))
            for medium in media
            for axis in range(1, law.dimension if "drift" in measured.names else 1)
            for what, columns in _EXCHANGED.items()
        )
    if law.field or cause.name == "components exchanged":
        return  # other causes take the solver long in a field
    if cause.name == "finite density":
        media = [one for one in media_of(measured.sample, "every", point) if one not in media]
    elif cause.name == "initial speeds":  # the data's own, or the other named start
        own = [SampledStart(start)] if start is not None and not point.own_start else []
        named = [] if start else sorted({"gaussian", "monoenergetic"} - {point.start})
        changes = [{"start": one} for one in (*own, *named) if point.start != BEAM]
    elif cause.name == "speed unit" and point.own_start:
        return
    for change in changes:
        yield from ((measured, point._replace(scatterers=x, **change)) for x in media)


def _starts(cause: Cause, told: Fit, point: Point) -> list[float]:
    """Where the fit of a parameter, or of its logarithm, begins."""
    name, sample, measured = cause.free, told.expectation.sample, told.expectation
    after = sample.times > 0
    if name == "restitution":
        return [point.restitution, 0.9, 0.5]
    if name == "time_offset":
        return [share * float(sample.times[after][0]) for share in (0.3, -0.3, 3.0)]
    if name == "at_rest":
        return [0.0]
    if name in ("velocity_noise", "position_noise"):
        of = measured.names.index("thermal_speed" if name[0] == "v" else "msd")
        square = measured.values[of] ** (2 if name[0] == "v" else 1)
        least = float(square[after & (square > 0)].min(initial=1e9))
        return [share * least / sample.law.dimension for share in (0.02, 0.3, 0.9)]
    shifts = (0.0, -2.0, 2.0, -5.0, 5.0, -9.0, 9.0)
    return [math.log(getattr(point, name)) + shift for shift in shifts]


def _judged(
    told: Fit, cause: Cause, found: Fit, before: ChiSquare,
    least_gain: float = 16.0, clearly: float = 0.9973,
) -> Explanation:  # fmt: skip
    """What a cause comes to, from the chi-square that it leaves; in part if T^2 falls by least_gain
    (4 sigma of one parameter) and a tenth. clearly : share of the errors of a fitted value that
    must lie nearer to it than what was told (3 sigma of a Gaussian)
    """
    after, outcome, clear = found.chi_square, "does not", True
    assert after is not None
    if cause.free:
        value, before_it = (getattr(one.point, cause.free) for one in (found, told))
        away = value - before_it if cause.free in LIMITS else math.log(value / before_it)
        factor = limit_factor(told.expectation.sample.groups, clearly)
        clear = abs(away) > factor * math.sqrt(found.covariance[0, 0])
        clear &= 0 <= found.point.at_rest < 0.85
    if after.verdict is Verdict.AGREES:
        # Averages that agreed already need no explaining.
        needed = before.verdict is not Verdict.AGREES
        outcome = "explains" if clear and needed else "does not"
    elif before.statistic - after.statistic > max(least_gain, 0.1 * before.statistic):
        # components are exchanged, or not
        outcome = "in part" if clear and cause.name != "components exchanged" else "does not"
    headline, value, error = _words(told, cause, found)
    if found.point.scatterers not in ("dilute", told.point.scatterers) and cause.free:
        headline += f" (among {found.point.scatterers})"
    numbers = [numeral(x, ".4g") for x in (before.value, after.value)]
    text = f"{headline[0].upper()}{headline[1:]}. The averages' chi-square goes from {numbers[0]} "
    text += f"to {numbers[1]} with {after.freedom} degrees of freedom "
    text += f"(p = {numeral(after.p_value, '.2g')}), scatterers: {found.point.scatterers}."
    return Explanation(
        cause.name, outcome, text, True, value, error, before.value, *after[:3], headline
    )


def _words(told: Fit, cause: Cause, found: Fit) -> tuple[str, float | None, float | None]:
    """The headline of a cause, its value and its error as they are said."""
    if not cause.free:
        medium = found.point.scatterers.replace("overlapping", "overlapping disks")
        named = {
            "finite density": f"the finite density of the scatterers ({medium}, no fitted number)",
            "initial speeds": f"another start ({found.point.start_in_words})",
            "components exchanged": f"an exchange of {found.expectation.exchanged}",
        }
        return named[cause.name], None, None
    value, error = found.value(cause.free)
    if "noise" in cause.name:  # of a variance the root
        size = math.sqrt(max(value, 0.0))
        width = error / (2 * size) if size else math.sqrt(error)
        said = f"noise of {number(size, width)} {cause.unit} in each component of the {cause.title}"
        return said, size, width
    was = float(getattr(told.point, cause.free))
    unit = told.expectation.sample.units.get(cause.kind, 1.0)  # in the data's own
    name = cause.unit if unit == 1.0 else ""
    said = f"{cause.symbol} = {number(value * unit, error * unit)}{name} in place of "
    return f"{said}{numeral(was * unit, '.5g')}{name}", value * unit, error * unit
