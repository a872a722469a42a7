"""The answer: fits become a Comparison, with its verdict, what the data show by themselves, the
numbers of the theory, and a summary in words.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from itertools import product
from typing import Any

import numpy as np

from kinetics.crosscheck.compare.fit import Fit, choose, fit, hotelling
from kinetics.crosscheck.compare.judge import histograms_of, rows_of, tests_of, worst_of
from kinetics.crosscheck.compare.result import OUTCOMES, Comparison, Explanation, Parameter
from kinetics.crosscheck.compare.theory import OBSERVABLES
from kinetics.crosscheck.data.sample import Law, Sample
from kinetics.crosscheck.words import Verdict, number, numeral

_NO_DENSITIES = "At a finite density averages alone are compared, with an error of the theory."
_OWN_START = "The theory starts from the data's own speeds: early densities' p-values are too high."
_SYMBOLS = {
    "e_t": "tangential_restitution", "field": "field", "M/m": "mass_ratio", "w": "bath_speed",
    "D_v": "heating", "γ": "drag", "v_c": "capture_speed",
}  # fmt: skip


def answered(
    sample: Sample, fits: Sequence[Fit], media: Sequence[str], explain: bool
) -> Comparison:
    """The rows, tests, verdict and explanations of the likeliest fit, or of what explains."""
    in_medium, explanations = {one.point.scatterers: one for one in fits}, list[Explanation]()
    seen = cache(lambda medium: _seen(in_medium[medium]))
    wrong, best = never_move(sample) or wrong_unit(fits), _likeliest(fits, seen)
    point, verdict = best.point, Verdict.DIFFERS if wrong else seen(best.point.scatterers)[-1]
    if explain:
        explanations, medium = _explained(best, verdict, wrong, media)
        if medium in in_medium and medium != point.scatterers:  # what explains is shown
            best, point = in_medium[medium], in_medium[medium].point
    densities, rows, tests, found = seen(point.scatterers)
    verdict = Verdict.DIFFERS if wrong else found
    likely = (x for x in explanations[:1] if x.outcome in ("explains", "found") and x.headline)
    first = wrong or (None if verdict is Verdict.AGREES else next(likely, None))
    note = [_OWN_START] if point.own_start and densities else []
    note += [_NO_DENSITIES] if point.scatterers != "dilute" else []
    parameters = _parameters(best, wrong)
    return Comparison(
        verdict=verdict, summary=_summary(best, fits, parameters, tests, verdict, first),
        parameters=parameters, initial=point.start_in_words, samples=int(sample.samples.max()),
        groups=sample.groups, grouping=sample.grouping, names=sample.names,
        warnings=(*sample.warnings, *note), tests=tests, explanations=tuple(explanations),
        numbers=rows, medium=point.scatterers,
        covariance=tuple(map(tuple, best.covariance.tolist())),
    )  # fmt: skip


def _seen(found: Fit) -> tuple[bool, Any, Any, Verdict]:
    """Whether densities were compared, the rows, the tests, and the verdict on them."""
    histograms = list(histograms_of(found))
    rows, tests = tuple(rows_of(found, histograms)), tuple(tests_of(found, histograms))
    # Rows without spread no test can hold.
    without_scatter = [r.verdict for r in rows if r.sigmas is None]
    tested = [test.verdict for test in tests]
    verdict = worst_of([*tested, *without_scatter])
    if verdict is Verdict.AGREES and tested and Verdict.AGREES not in tested:
        verdict = Verdict.NOT_TESTED  # what is exact, or the start, agrees: no test of the rest
    return bool(histograms), rows, tests, verdict


def _likeliest(fits: Sequence[Fit], seen: Callable[[str], Any]) -> Fit:
    """The likeliest of the fits that agree with the data, also in every single test, or of all.

    Its covariance holds what the others would make of the numbers, by their likelihoods (Buckland,
    Burnham and Augustin, Biometrics 53, 603 (1997)).
    """
    fits = [f for f in fits if f.chi_square and f.chi_square.verdict is Verdict.AGREES] or fits
    fits = [f for f in fits if seen(f.point.scatterers)[-1] is Verdict.AGREES] or fits
    best = min(fits, key=lambda f: f.criterion)
    if not np.isfinite(best.criterion):
        return best
    weight = np.exp([(best.criterion - one.criterion) / 2 for one in fits])
    away = np.array([one.at - best.at for one in fits])
    return replace(best, covariance=best.covariance + (away.T * (weight / weight.sum())) @ away)


def _explained(
    told: Fit, verdict: Verdict, wrong: Explanation | None, media: Sequence[str]
) -> tuple[list[Explanation], str]:
    """What explains a difference or is to be noted, the likeliest first, and in which medium."""
    medium, law = told.point.scatterers, told.expectation.sample.law
    if wrong or (law.is_driven and not law.field):
        return [wrong] if wrong else [], medium
    found = [] if law.field else list(_noted(told))
    if verdict in (Verdict.DIFFERS, Verdict.UNCLEAR):
        from kinetics.crosscheck.compare.causes import tested_causes

        tested = list(tested_causes(told, media))
        if tested and tested[0][0].outcome == "explains":
            medium = tested[0][1]
        found = [*(item for item, _ in tested), *found]
    # Python's sort keeps the order of those of one outcome: the likeliest stays first.
    return sorted(found, key=lambda item: [*OUTCOMES].index(item.outcome)), medium


# -- what the data show by themselves, without a fit -----------------------------------------------
def never_move(sample: Sample) -> Explanation | None:
    """Particles that have speed zero at every time; of late times alone, one in 100 at least."""
    rest, most = int(sample.at_rest.min()), int(sample.samples.max())
    late = sample.times[0] > 0 and rest < 0.01 * most
    if not rest or late or sample.times.size < 2 or sample.law.is_driven:
        return None
    said = f"{numeral(rest / most, '.2%')} of the particles ({rest}) never move"
    more = ": are these the scatterers? Choose the tracers by --type, or leave the others out."
    return Explanation("scatterers", "found", said + more, value=rest / most, headline=said)


def wrong_unit(fits: Sequence[Fit]) -> Explanation | None:
    """What is said where units do not belong together; None where they do, or cannot be known.

    Before a collision r = v t: |ln(r/(v t))| above .005 is a wrong unit, or a wrong clock. Which
    it is, say the averages that are left with the value that this gives: all near the best.
    """
    sample, own_start = fits[0].expectation.sample, fits[0].point.own_start
    (at, ratio), unit = sample.flights, sample.units.get("time", 1.0)
    if sample.law.field or sample.law.is_driven or abs(math.log(ratio)) <= 0.005:
        return None
    from kinetics.crosscheck.compare.causes import NEAR_BEST

    size, ahead = numeral(1 / ratio, ".5g"), at * (1 - ratio) * unit
    words = {
        "time offset": (at * (ratio - 1), f"the clock were {numeral(ahead, '.4g')} ahead"),
        "time unit": (1 / ratio, f"times were {size} times too long"),
        "speed unit": (1 / ratio, f"speeds were {size} times too high"),
        "length unit": (ratio, f"lengths were {numeral(ratio, '.5g')} times too long"),
    }
    costs = dict[str, float]()
    for told, (name, (value, _)) in product(fits, words.items()):
        changed: Any = {name.replace(" ", "_"): value}
        if name == "speed unit":  # the times are right, and a Gaussian may be the start
            changed |= {"time_unit": value} | ({"start": "gaussian"} if own_start else {})
        usable = told.usable & (sample.times > 0)
        made = fit(told.expectation, told.point._replace(**changed), told.free, usable, [told.at])
        if made and made.chi_square and made.chi_square.verdict is not Verdict.DIFFERS:
            costs[name] = min(made.criterion, costs.get(name, math.inf))
    if "speed unit" in costs and own_start:  # no start but a Gaussian is needed
        costs.pop("time unit", None)
    near = min(costs.values(), default=0.0) + NEAR_BEST
    may_be = [one for one in sorted(costs, key=costs.__getitem__) if costs[one] < near] or [*words]
    said = f"tracers that fly straight have r = {numeral(ratio, '.5g')} v t at t = "
    said += f"{numeral(at * unit, '.4g')}, as if {' or '.join(words[one][1] for one in may_be)}"
    more = f"{said}; shift the times, or say --time-unit, --length-unit or --speed-unit. No other "
    value = ahead if may_be[0] == "time offset" else words[may_be[0]][0]
    return Explanation(may_be[0], "found", more + "cause is looked for.", True, value,
                       headline=said)  # fmt: skip


def _noted(told: Fit) -> Iterator[Explanation]:
    """Tracers that come to rest, and those that are missing later: the complete times tell."""
    sample, samples = told.expectation.sample, told.expectation.sample.samples
    most, least, rest = int(samples.max()), int(np.argmin(samples)), int(sample.at_rest.max())
    if rest:
        said = f"tracers come to rest ({rest}): caught between scatterers, or stopped by a program"
        # few change densities alone: where averages differ, it is for another reason
        agree = told.chi_square is None or told.chi_square.verdict is Verdict.AGREES
        outcome = "found" if agree else "noted"
        yield Explanation("traps", outcome, f"{said}.", value=rest / most, headline=said)
    complete = sample.is_complete
    if np.all(complete):
        return
    whole, part = (
        hotelling(*told.flat(choose(told.usable & times, sample.groups)))
        for times in (complete, ~complete)
    )
    missing, outcome = most - int(samples[least]), "does not" if part else "noted"
    if part is not None and part.verdict is not Verdict.AGREES:
        alone = whole is None or whole.verdict is Verdict.AGREES
        outcome = "explains" if alone else "in part"
    said = f"{missing} tracers that are missing at later times"
    text = f"{said}, of {most} at t = {numeral(sample.times[least], '.4g')}. "
    text += "A cap on collisions takes the fast ones away."
    left: tuple[Any, ...] = (None, None, None) if whole is None else whole[:3]
    yield Explanation(
        "missing tracers", outcome, text, part is not None, missing / most, None,
        part and part.value, left[0], left[1], left[2], said,
    )  # fmt: skip


# -- in words --------------------------------------------------------------------------------------
def _parameters(found: Fit, wrong: Explanation | None) -> dict[str, Parameter]:
    """The numbers of the theory; those that were fitted have standard errors."""
    point, left, why = found.point, found.chi_square, ""
    if wrong or (left is not None and left.verdict is Verdict.DIFFERS):
        why = wrong.headline if wrong else "the model does not fit"
    density = found.expectation.sample.law.free_path(point.path)
    values = {"restitution": point.restitution, "number_density": density}
    values |= {"mean_free_path": point.path}
    made = {}
    for name, value in values.items():
        free = "restitution" if name == "restitution" else "path"
        made[name] = Parameter(value, None, "from ρ₀" if name == "mean_free_path" else "told")
        if callable(value):
            made[name] = Parameter(None, None, f"told: {value}")
        elif free in found.free and why:
            used = f"no value: {why}; the theory that is shown has {numeral(value, '.5g')}"
            made[name] = Parameter(None, None, used)
        elif free in found.free:
            at, error = found.value(free)
            error *= value / at if at else 1.0
            made[name] = Parameter(value, error, "fitted to v₀ and ⟨r²⟩ over time")
    return made


def _summary(
    found: Fit, fits: Sequence[Fit], parameters: dict[str, Parameter],
    tests: Sequence[Any], verdict: Verdict, best: Explanation | None,
) -> str:  # fmt: skip
    """What was fitted, the verdict, what was compared, the medium and the clearest difference."""
    within = [
        f"{numeral(min(t.within, 10.0), '.2g' if t.within < 0.001 else '.2%')} for "
        f"{OBSERVABLES[t.observable].short}"
        for t in tests
        if t.within is not None and t.verdict is Verdict.AGREES
    ]  # fmt: skip
    cause = f"; {best.headline} explains it" if best else ""
    answer = {
        Verdict.AGREES: f"No difference seen, better than {', '.join(within) or 'no average'}.",
        Verdict.UNCLEAR: f"A difference is possible, more samples would show it{cause}.",
        Verdict.DIFFERS: f"They differ{cause}.",
        Verdict.NOT_TESTED: f"Not tested: {found.expectation.sample.groups} independent groups are "
        "too few for errors this large.",
    }.get(verdict, "Nothing could be tested.")
    fitted = " and ".join(
        f"{symbol} = {number(one.value, one.error)}"
        for name, symbol in (("restitution", "e"), ("number_density", "ρ₀"))
        if (one := parameters[name]).error is not None
    )
    if best is not None and best.outcome == "found":
        answer = f"They differ. Look at the data first: {best.headline}."
    elif fitted:
        answer = f"{fitted}, fitted. {answer}"
    sample, law, point = found.expectation.sample, found.expectation.sample.law, found.point
    told: dict[str, Any] = {"e": point.restitution, "ρ₀": law.free_path(point.path)}
    told |= {s: getattr(law, n) for s, n in _SYMBOLS.items() if getattr(law, n) != getattr(Law, n)}
    said = [f"{k} = {x if callable(x) else numeral(x, '.6g')}" for k, x in told.items()]
    first, last = (numeral(sample.times[k], ".4g") for k in (0, -1))
    answer += f" {int(sample.samples.max())} tracers at {sample.times.size} times from {first} to "
    answer += f"{last} d/U, compared with the kinetic equation with "
    answer += f"{', '.join(said)}, from {point.start_in_words}."
    if len(fits) > 1 and found.chi_square:
        left = {
            one.point.scatterers: f"{numeral(one.chi_square.value, '.3g')}/{one.chi_square.freedom}"
            for one in fits if one.chi_square
        }  # fmt: skip
        answer += f" The medium taken: {point.scatterers} {left.pop(point.scatterers)}"
        answer += " (chi-square/degrees of freedom; "
        answer += f"{', '.join(f'{name} {one}' for name, one in left.items())})."
    odd = [t for t in tests if t.verdict not in (Verdict.AGREES, Verdict.NOT_TESTED)]
    if odd:
        t = min(odd, key=lambda test: test.p_value)
        at = "" if t.time is None else f" at t = {numeral(t.time, '.4g')}"
        answer += f" Of {len(tests)} tests {len(odd)} do not agree; the clearest is {t.observable}"
        answer += f"{at}: chi-square {numeral(t.chi_square, '.4g')} with {t.dof} degrees of freedom"
        answer += f", p = {numeral(t.p_value, '.2g')}."
    return answer
