"""What may explain a difference: each cause is a row of the table CAUSES, and one fit.

A cause says which parameters of the theory (`theory.Point`) are other than what was told: set to a
value, or free. They are ranked by the chi-square that they leave plus 2 for each fitted parameter
(Akaike's criterion), and "explains" is said only of those within NEAR_BEST of the best. Where the
theory has an error of its own, what that takes from the likelihood is counted against it. Units
that do not belong together are looked for first: then nothing else is claimed.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from kinetics.crosscheck.compare.fit import Fit, choose_components, components_of, fit
from kinetics.crosscheck.compare.judge import Both
from kinetics.crosscheck.compare.result import OUTCOMES, Explanation
from kinetics.crosscheck.compare.statistics import ChiSquare, chance, hotelling
from kinetics.crosscheck.compare.theory import SPEED, SampledStart, bin_shares
from kinetics.crosscheck.data.sample import V2, N, Sample
from kinetics.crosscheck.words import AGREES_BELOW, DIFFERS_ABOVE, Verdict, numeral

AGREES_ABOVE = chance(AGREES_BELOW)
"""p-value from which on what a cause leaves agrees."""
NEAR_BEST = 6.0
"""Distance from the best in chi-square plus 2 per parameter up to which a cause explains as well:
at this distance it is exp(3) = 20 times less likely."""
_LEAST_GAIN = 16.0
"""Of T^2 by one parameter, 4 sigma, and at least a tenth of it: less is no explanation."""
_FACTORS = (0.0, -2.0, 2.0, -5.0, 5.0, -9.0, 9.0)
"""Logarithms of the factors from which a unit or a free path is looked for."""
_LEAST_RESTITUTION = 0.2
"""Below it the theory at a finite density is of the leading order only, its error not measured."""


def start_in_words(start: Any) -> str:
    """A start as the middle of a sentence."""
    named = {"gaussian": "a Gaussian start", "monoenergetic": "a start with all speeds U"}
    return named.get(start, start) if isinstance(start, str) else "the data's own speeds at time 0"


def explained(both: Both, verdict: Verdict, unit: Explanation | None) -> list[Explanation]:
    """What explains a difference and is to be noted, the likeliest first; or only a wrong unit."""
    if unit or both.sample.law.field:
        return [unit] if unit else []
    tested = tested_causes(both) if verdict in (Verdict.DIFFERS, Verdict.UNCLEAR) else ()
    notes = [note for note in (_traps(both), _missing(both)) if note is not None]
    # Python's sort keeps the order of those of one outcome: the likeliest stays first.
    return sorted([*tested, *notes], key=lambda item: [*OUTCOMES].index(item.outcome))


def tested_causes(both: Both) -> Iterator[Explanation]:
    """Every cause, the likeliest first; none where too few averages have a spread."""
    # Not time 0: there a cause in the start would leave nothing that could differ.
    usable = both.usable & (both.sample.times > 0)
    components = components_of(both.names, usable, both.sample.groups, 1)
    before = hotelling(*both.flat(components[1]), None, both.sample.tabulated)
    if components[1].size < 2 or not components[0].size or before is None:
        return
    tested = []
    for cause in CAUSES:
        for change in cause.changes(both):
            point, free, starts = both.point._replace(**change), cause.free, list[Any]([()])
            if free:
                starts = [(getattr(point, free[0]),)]
                if free[0] not in ("restitution", "at_rest"):
                    starts = [(math.log(starts[0][0]) + shift,) for shift in _FACTORS]
            found = fit(both.expectation, point, free, components, starts)
            # a share of tracers at rest is one between none and nearly all
            low = 0.0 if free == ("at_rest",) else -1.0
            if found and found.chi_square and low < found.point.at_rest < 0.85:
                # -2 ln likelihood, to a constant, plus 2 per parameter
                criterion = found.chi_square.value + 2 * len(free) + found.widening
                tested.append((criterion, _judged(both, cause, found, before)))
    tested.sort(key=lambda one: one[0])
    for criterion, item in tested:
        far = item.outcome == "explains" and criterion > tested[0][0] + NEAR_BEST
        yield replace(item, outcome="in part") if far else item


def _judged(both: Both, cause: "Cause", found: Fit, before: ChiSquare) -> Explanation:
    """What a cause comes to, from the chi-square that it leaves."""
    after, outcome = found.chi_square, "does not"
    assert after is not None
    if after.p_value >= AGREES_ABOVE:
        # Averages that agreed already need no explaining.
        outcome = "explains" if before.p_value < AGREES_ABOVE else "does not"
    elif before.statistic - after.statistic > max(_LEAST_GAIN, 0.1 * before.statistic):
        outcome = "in part"
    text, headline = cause.words(both, found)
    numbers = [numeral(x, ".4g") for x in (before.value, after.value)]
    text += f" The averages' chi-square goes from {numbers[0]} to {numbers[1]} with "
    text += f"{after.freedom} degrees of freedom (p = {numeral(after.p_value, '.2g')})."
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

    For smooth disks at a density that is told; not for particles that meet no scatterer again.
    """
    from kinetics.collision.medium import HIGHEST_DENSITY

    law, fitted = both.sample.law, both.found is not None and "path" in both.found.free
    known = both.point.restitution >= _LEAST_RESTITUTION and law.smooth_disks
    if fitted or both.sample.free or not known or law.free_path(both.point.path) > HIGHEST_DENSITY:
        return []
    return [{"scatterers": medium} for medium in ("hard disks", "overlapping")]


def _of_density(both: Both, found: Fit) -> tuple[str, str]:
    from kinetics.collision.medium import SETTLED

    kind, n = found.point.scatterers, numeral(both.sample.law.free_path(both.point.path), ".4g")
    v0, r2 = (numeral(found.theory[k, -1] / both.theory[k, -1] - 1, "+.2%") for k in (0, 2))
    text = (
        f'The finite density of the scatterers, n = ρ₀d² = {n}, by Scene(scatterers="{kind}"), '
        f"trusted from {SETTLED:g} l/U on, changes v₀ by {v0} and ⟨r²⟩ by {r2} at the last time. "
        "Nothing is fitted, and its own error is added to the covariance."
    )
    return text, f"the finite density of the scatterers ({kind}, no fitted number)"


def _other_starts(both: Both) -> list[dict[str, Any]]:
    """The data's own speeds at time 0, or the other named start."""
    start = both.sample.start
    if start is not None:
        return [] if both.point.own_start else [{"start": SampledStart(start)}]
    return [{"start": n} for n in ("gaussian", "monoenergetic") if n != both.point.start]


def _of_start(both: Both, found: Fit) -> tuple[str, str]:
    words = start_in_words(found.point.start)
    return f"Another start: {words}, the rest as told.", f"another start ({words})"


def _of_number(symbol: str, title: str, unit: str = "") -> Callable[[Both, Fit], tuple[str, str]]:
    def words(both: Both, found: Fit) -> tuple[str, str]:
        name = found.free[0]
        value = f"{symbol} = {_pm(found.value(name))}{unit} in place of "
        value += f"{numeral(getattr(both.point, name), '.5g')}{unit}"
        return f"Another {title}: {value} fits best.", value

    return words


class Cause(NamedTuple):
    """A cause: its sentence and headline, the parameter that is fitted, and those that are set.

    changes : one dictionary for each variant; none where the cause does not apply
    """

    name: str
    words: Callable[[Both, Fit], tuple[str, str]]
    free: tuple[str, ...] = ()
    changes: Callable[[Both], Sequence[dict[str, Any]]] = lambda both: [{}]


CAUSES = (
    Cause("finite density", _of_density, (), _media),
    Cause("free path", _of_number("l", "mean free path", " d"), ("path",)),
    Cause("restitution", _of_number("e", "restitution"), ("restitution",)),
    Cause("initial speeds", _of_start, (), _other_starts),
    Cause("speed unit", _of_number("U", "unit of speed"), ("speed_unit",),
          lambda both: [] if both.point.own_start else [{}]),
    Cause("time unit", _of_number("d/U", "unit of time"), ("time_unit",)),
    Cause("length unit", _of_number("d", "unit of length"), ("length_unit",)),
    Cause("tracers at rest", _of_number("f", "share of tracers that never move"), ("at_rest",)),
)  # fmt: skip
"""Everything that may explain a difference. The first, which has no free parameter, stands before
others that are as likely. A new cause is one row."""

# -- units that do not belong together -------------------------------------------------------------

_FAR, _MOST = 2.0, 0.5
"""Factor by which speeds are in another unit, and the share of tracers that have not collided."""
_WRONG_ABOVE = 0.005
"""|ln(|r|/(|v| t))| from which on units do not belong together."""
_PUT_RIGHT = (
    "put it right by --time-unit, --length-unit or --speed-unit. No other cause is looked for."
)


def wrong_unit(sample: Sample, start: Any) -> Explanation | None:
    """What is said where units do not belong together; None where they do, or cannot be known.

    Tracers that have not collided are at r = v t. Speeds never rise, so that larger ones than at a
    named start cannot be; smaller ones cannot be while most tracers have not collided. A factor of
    two is asked for: less may be another start.
    """
    flights, field = sample.flights, sample.law.field
    if not field and flights is not None and abs(math.log(flights.ratio)) > _WRONG_ABOVE:
        value = 1 / flights.ratio
        headline = f"tracers that fly straight have r = {numeral(flights.ratio, '.5g')} v t, as if "
        headline += f"times were {numeral(value, '.5g')} times too long"
        text = f"At t = {numeral(flights.time, '.4g')}, {headline}; {_PUT_RIGHT}"
        return Explanation("time unit", "found", text, True, value, headline=headline)
    if field or not isinstance(start, str):
        return None
    most = np.sqrt(sample.law.dimension) if start == "gaussian" else 1.0
    total = sample.sums[:, 0].sum(axis=0)
    ratio = float(sample.speed_scale[0] * np.sqrt(total[V2] / total[N]) / most)
    early = flights is not None and flights.share > _MOST and flights.time <= sample.times[:2].max()
    if not (ratio > _FAR or (ratio < 1 / _FAR and early)):
        return None
    headline = f"speeds at the first time are {ratio:.4g} times those of the start"
    text = f"At t = {numeral(sample.times[0], '.4g')}, {headline}; {_PUT_RIGHT}"
    return Explanation("speed unit", "found", text, True, ratio, headline=headline)


# -- notes -----------------------------------------------------------------------------------------

_FAR_SLOWER = 8.0
"""A trapped tracer is that many times slower than the upper end of the lowest bin: a wrong
restitution, density or start, which shift all speeds a little, cannot put a tracer there."""
_FEWEST_TRAPPED = 5


def _traps(both: Both) -> Explanation | None:
    """Tracers at the last time that are far slower than the theory's slowest, or at rest."""
    rest, most = int(both.sample.at_rest.max()), int(both.sample.samples.max())
    binned = both.sample.speeds
    for h in [h for h in both.histograms if h.name == SPEED and binned][-1:]:
        assert binned is not None
        edges, density = binned.edges[h.index], both.densities[SPEED]
        cut = int(np.searchsorted(edges, h.edges[1] / _FAR_SLOWER))
        at = int(np.argmin(np.abs(density.times - h.time)))
        count = int(binned.totals[h.index, : cut + 1].sum())
        expected = float(bin_shares(density, SPEED, at, edges)[: cut + 1].sum()) * h.samples
        excess = count - expected
        if count < _FEWEST_TRAPPED or excess < DIFFERS_ABOVE * math.sqrt(max(expected, count)):
            break
        share, error = excess / h.samples, math.sqrt(count) / h.samples
        text = (
            f"At t = {numeral(h.time, '.4g')}, {count} tracers are slower than "
            f"{numeral(edges[cut], '.3g')} U, {_pm((share, error), '.2%', '.2%')} of all too many; "
            f"{rest} have speed zero: caught between scatterers, or stopped by a program."
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
    missing, outcome = most - int(samples[least]), "does not" if part else "noted"
    text = f"{missing} of {most} tracers are missing at t = {numeral(sample.times[least], '.4g')}. "
    text += "A cap on collisions takes the fast ones away."
    if part is not None and part.p_value < AGREES_ABOVE:
        outcome = "explains" if whole is None or whole.p_value >= AGREES_ABOVE else "in part"
    left = (whole.value, whole.freedom, whole.p_value) if whole else (None, None, None)
    return Explanation(
        "missing tracers", outcome, text, part is not None, missing / most, None,
        part.value if part else None, *left,
    )  # fmt: skip
