"""The findings of a report in words, and the small tables that the words point to.

A number that belongs to one restitution stands in a table, beside its e; each finding is said once.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from kinetics import sonine
from kinetics.collision.medium import SETTLED
from kinetics.crosscheck.report import runs
from kinetics.crosscheck.report.figures import exact_states
from kinetics.crosscheck.report.reduce import contact_value
from kinetics.crosscheck.report.rows import OBSERVABLES
from kinetics.crosscheck.report.runs import EXACT, FIT, FREE, KINETIC, LEVELS, Case, Results
from kinetics.crosscheck.report.systems import SCATTERERS
from kinetics.crosscheck.words import AGREES_BELOW, Verdict, number, numeral

if TYPE_CHECKING:
    from pandas import DataFrame

HOLDS, PARTLY, FAILS = "holds", "holds in part", "does not hold"
SHARE = 0.99
"""Share of its limit at which d<r^2>/d ln t counts as reached."""
CLOSE = 0.01
"""The drift is reached when the mean velocity stays as close to it as this, relative to it."""


@dataclass(frozen=True)
class Story:
    """What a reader should know: findings first, then the paper's claims, then tables of numbers.

    tables : by name, tidy records; those of "summary" have quantity, restitution, value, error and
        unit, and are shown with a column for each restitution
    """

    compared: str
    findings: list[str]
    line: str
    claims: list[dict[str, str]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    tables: dict[str, list[dict[str, Any]]] = field(default_factory=dict)


def tell(results: Results, table: "DataFrame", checks: Sequence[dict[str, Any]]) -> Story:
    """The story of any report; `checks` are the rows of the algebra."""
    return (_falling if results.system.in_field else _cooling)(results, table, checks)


def span(values: Iterable[float], form: str) -> str:
    """Smallest to largest of some numbers, as a sentence says it; NaN is left out."""
    known = [v for v in values if math.isfinite(v)]
    if not known:
        return "–"
    low, high = (numeral(f(known), form) for f in (min, max))
    return low if low == high else f"{low} to {high}"


def off(values: Sequence[float]) -> str:
    """Relative differences as a range of per cent: "15 to 20 % below"."""
    percents = [100 * value for value in values]
    form = ".0f" if all(abs(p) >= 5 for p in percents) else ".1f"
    for sign, word in ((-1, "below"), (1, "above")):
        if all(p * sign > 0 for p in percents):
            return f"{span([p * sign for p in percents], form)} % {word}"
    return f"{span(percents, '+' + form)} % from"


def agreement(table: "DataFrame") -> str:
    """In how many comparisons that could have shown a difference particles and solver show none."""
    strict = table[(table.kind == "statistical") & (table.source == FREE)]
    tested = strict[strict.verdict != Verdict.NOT_TESTED]
    same, blind = int((tested.verdict == Verdict.AGREES).sum()), len(strict) - len(tested)
    text = f"Equation and dilute simulation agree in {same} of {len(tested)} comparisons"
    text += f" that could show a difference of 10 % ({blind} could not)" if blind else ""
    within = [
        f"{OBSERVABLES[name].short} within {numeral(100 * rows.within.max(), '.2g')} %"
        for name in ("thermal_speed", "msd", "drift")
        if len(rows := tested[tested.observable == name])
    ]
    text += f": {', '.join(within)}" if within else ""
    solver = table[table.kind == "numerical"]
    met = int((solver.verdict == Verdict.AGREES).sum())
    text += f". The solver meets the closed forms in {met} of {len(solver)}" if len(solver) else ""
    return text + "."


def chance(table: "DataFrame") -> str:
    """What the verdicts allow for, and what they expect by chance."""
    rows = int((table.kind == "statistical").sum())
    expected = numeral(rows * math.erfc(AGREES_BELOW / math.sqrt(2)), ".2g")
    return (
        f"{rows} rows are statistical; each shows the worst of its times or bins, its p-value "
        "(Student's, errors jackknifed over independent groups) multiplied by their number and "
        "turned into corrected sigmas. Were every theory true, at most "
        f"{expected} of the rows would not agree by chance."
    )


# -- a gas that cools ------------------------------------------------------------------------------


def _cooling(results: Results, table: "DataFrame", checks: Sequence[dict[str, Any]]) -> Story:
    system: Any = results.system
    of, paper, cases = system.scatterers, system.is_papers_law, results.cooling
    rough = "" if system.is_smooth else f", e_t = {system.tangential_restitution:g}"
    many = [f"{n:,}".replace(",", "\u202f")
            for n in (system.free_tracers, system.media * system.tracers)]  # fmt: skip
    compared = (
        f"Tracers among fixed {of}{rough} lose speed at every bounce"
        f"{' (H.-D. Kim and H. Hayakawa)' if paper else ''}. For each e: the equation to "
        f"{numeral(system.rtol, '.0e')}, {many[0]} tracers of the dilute limit, {many[1]} among "
        f"hard {of}, ρ₀d{'³' if system.dimension == 3 else '²'} = {system.number_density:g}."
    )
    disks = [_last(case, f"hard {of}") / _end(case) - 1 for case in results.cases]
    dense = [case for case in results.cases if case.solved.dense is not None]
    left = [_last(case, f"hard {of}") / case.solved.dense.msd[-1] - 1 for case in dense]
    corrected = f"; corrected for density, nothing fitted, {off(left)} it"
    findings = [agreement(table)]
    if paper and cases:
        e, states = exact_states(1.0, 2)
        highest = max(s.cooling_rate / (1 - x) for x, s in zip(e.tolist(), states, strict=True))
        findings.append(
            f"The cooling rate is not 1.45 (1 − e): h/(1 − e) falls from {highest:.2f} to 4/3. The "
            "paper’s value is lifted by a start not yet forgotten and by disks that are not dilute."
        )
    elif cases:
        findings.append(
            "In the end v₀ = 2l/(ht) with the exact h of the table, and the mean square "
            "displacement grows as the logarithm of time, without bound."
        )
    findings.append(
        f"Hard {of} spread less than the equation, which forgets every scatterer: ⟨r²⟩ ends "
        f"{off(disks)} it{corrected if dense else ''}."
    )
    if paper and cases:
        errata = [c for c in checks if c["status"] == "erratum"]
        named = ", ".join(c["label"] for c in errata)
        findings += [
            "The tracer is not localized: ⟨r²⟩ grows as ln t without bound. The paper’s random "
            "walk fits because its two fitted numbers stand for the density.",
            "F(c) is no Gaussian, and no exponential tail of G(R) is seen. Of "
            f"{len(checks)} printed formulas derived again all follow"
            + (f" but {named}, a misprint." if errata else "."),
        ]
    exact = [case.theory[EXACT]["cooling_rate"] / (1 - case.restitution) for case in cases]
    line = f"Finding: ⟨r²⟩ of hard {of} ends {off(disks)} the equation"
    if paper and cases:
        line = f"Finding: h/(1 − e) is {span(exact, '.2f')}, not 1.45; {line[9:]}"
    tables = {"summary": [row for case in results.cases for row in _summary(case, results)]}
    if "levels" in results.more:
        tables["finite_density"] = results.more["levels"]
    if "dimensions" in results.more:
        tables["dimensions"] = results.more["dimensions"]
    claims = _claims(results) if paper and cases else []
    return Story(compared, findings, line, claims, _notes(results), tables)


def _last(case: Case, source: str) -> float:
    return float(case.measured[source]["msd"].value[-1])


def _end(case: Case) -> float:
    return float(case.theory[KINETIC]["msd"][-1])


def _summary(case: Case, results: Results) -> Iterable[dict[str, Any]]:
    """What the findings rest on, at one restitution."""
    system: Any = results.system
    e, solved, theory = case.restitution, case.solved, case.theory
    hard = case.measured[f"hard {system.scatterers}"]
    unit, over = (1 - e, "/(1 − e)") if system.is_smooth else (1.0, "")

    def row(quantity: str, value: Any, error: Any = None, sign: str = "") -> dict[str, Any]:
        error = None if error is None else float(error)
        named = {"quantity": quantity, "restitution": e, "value": float(value), "error": error}
        return named | {"unit": "%" if quantity.endswith("%") else "", "sign": sign}

    def percent(quantity: str, ratio: Any, error: Any = None) -> dict[str, Any]:
        error = None if error is None else 100 * float(error)
        return row(f"{quantity}, %", 100 * (float(ratio) - 1), error, "+")

    if case.cools:
        exact, rate = theory[EXACT]["cooling_rate"], float(theory[KINETIC]["cooling_rate"])
        yield row(f"h{over}, exact, late times", exact / unit)
        yield percent("… start not yet forgotten in the last decade", rate / exact)
        measured = hard["cooling_rate"] / rate
        yield percent("… finite density, measured", measured.value, measured.error)
        if solved.dense is not None:
            speeds = [1 / solved.dense.thermal_speed[k] for k in (solved.early, -1)]
            window = case.times[-1] - case.times[solved.early]
            dense = (speeds[1] - speeds[0]) / window / system.half_rate
            yield percent("… finite density, predicted", dense / rate)
        measured = hard["cooling_rate"] / unit
        yield row(f"h{over}, hard {system.scatterers}", measured.value, measured.error)
    path = hard["free_path"] / theory[KINETIC]["free_path"]
    yield percent("free path over dilute", path.value, path.error)
    ratio = hard["msd"][-1] / _end(case)
    yield percent("⟨r²⟩ at the end over dilute", ratio.value, ratio.error)
    if solved.dense is not None:
        ratio = hard["msd"][-1] / float(solved.dense.msd[-1])
        yield percent("⟨r²⟩ at the end over corrected", ratio.value, ratio.error)
    if FIT in theory and case.cools:
        ratio = hard["msd"][-1] / float(theory[FIT]["msd"][-1])
        yield percent("⟨r²⟩ at the end over the paper’s walk", ratio.value, ratio.error)
        slope = theory[FIT]["msd_slope"]
        yield percent("late slope of the walk over dilute", slope / theory[EXACT]["msd_slope"])
        if solved.dense_slope is not None:
            yield percent("late slope of the walk over hard disks", slope / solved.dense_slope)
    if case.cools:
        late, limit = solved.late, theory[EXACT]["msd_slope"]
        share = np.maximum.accumulate(late.msd_slope / limit)
        time = np.exp(np.interp(SHARE, share, np.log(late.times)))
        yield row(f"t from which d⟨r²⟩/d ln t has {SHARE:.0%} of its limit, d/U", f"{time:.2g}")
        yield row("a₂, exact (a Gaussian has 0)", theory[EXACT]["a2"])
    exponent = solved.position.position_tail((4.0,))[0][-1][0]
    yield row("tail exponent n at R = 4 (exponential 1, Gaussian 2)", exponent)
    yield row("kurtosis of the displacement at the end", solved.kinetic.kurtosis[-1])
    yield row("… at 10⁹ d/U", solved.late.kurtosis[-1])
    caught = float(hard["trapped"].value)
    yield row(f"hard-{system.scatterers[:-1]} tracers at rest in corners", caught)


def _claims(results: Results) -> list[dict[str, str]]:
    """What the paper claims, where, whether it holds, and why; numbers are in the summary."""
    cases = results.cooling
    tails = [float(c.solved.position.position_tail((4.0,))[0][-1][0]) for c in cases]
    late = [c.solved.late for c in cases]
    back = int(np.searchsorted(late[0].times, late[0].times[-1] / 100))
    shares = [
        (x.msd[-1] - x.msd[back]) / math.log(x.times[-1] / x.times[back])
        / c.theory[EXACT]["msd_slope"]
        for x, c in zip(late, cases, strict=True)
    ]  # fmt: skip
    decades = [c.theory[EXACT]["msd_slope"] * math.log(10) for c in cases]
    exponential = max([n for n in tails if math.isfinite(n)], default=math.nan) < 1.1
    found = [
        ("The cooling rate is h(e) = 1.45 (1 − e).", "eq. (8)", PARTLY,
         "It fits hard disks read as the paper reads them; of late times it is no constant times "
         "1 − e."),
        ("The scaled velocity distribution F(c) is a Gaussian.", "Figure 6", FAILS,
         "a₂ is not 0, F vanishes at c = 0 for every e above 0, and the tail is exponential."),
        ("⟨r²⟩ obeys a power of a logarithm of time.", "abstract", HOLDS,
         f"With the power 1: over the last two decades before 10⁹ d/U d⟨r²⟩/d ln t is "
         f"{span(shares, '.4f')} of its exact limit."),
        ("The tracer is localized for e < 1.", "section 3.2", FAILS,
         f"Each further factor of ten in time adds {span(decades, '.3g')} d² without end; over the "
         "times of a simulation this looks like a standstill."),
        ("The random walk becomes identical with the simulation.", "after eq. (22)", PARTLY,
         "It is near at the last times; its late slope is the wrong one, and it parts ever more."),
        ("The tail of the scaled positions G(R) is exponential.", "eq. (58)",
         HOLDS if exponential else FAILS,
         f"The local exponent lies between an exponential and a Gaussian: {span(tails, '.2f')} at "
         "R = 4."),
        ("G(R) depends neither on e nor on time.", "below eq. (23)", FAILS,
         "Its kurtosis does, and tends to the 2 of a Gaussian; the paper’s integral, eq. (53), has "
         "4 always."),
    ]  # fmt: skip
    names = ("claim", "place", "judgement", "text")
    return [dict(zip(names, claim, strict=True)) for claim in found]


def _notes(results: Results) -> list[str]:
    """What a careful reader asks of the hard scatterers."""
    system: Any = results.system
    of, (dilute,) = system.scatterers, {1 / (2 * system.half_rate)}
    hard = [case.measured[f"hard {of}"] for case in results.cases]
    most = max(float(run["most_collisions"].value) for run in hard)
    capped = max(float(run["above_cap"].value) for run in hard)
    contact = dilute / contact_value(system.number_density, system.dimension)
    notes = [
        f"The mean free path of hard {of} is {span([float(r['free_path'].value) for r in hard], '.2f')} "
        f"d; dilute it is {dilute:.4g} d, with the contact value of the equilibrium {contact:.4g} d.",
        f"Tracers are followed without the paper’s cap of {runs.PAPER_CAP} collisions: the most "
        f"that any had is {most:g}, and {numeral(100 * capped, '.2g')} % had more than the cap.",
    ]
    if any(float(run["trapped"].value) for run in hard):
        notes.append(
            "Tracers caught in corners count as at rest there; the many bounces in corners shorten "
            "the measured free path."
        )
    if "density" in results.more:
        limits = results.more["density"]["limits"]
        said = ", ".join(
            f"{OBSERVABLES[name].short} {number(float(x.value), float(x.error))}"
            for name, x in limits.items() if np.isfinite(x.value)
        )  # fmt: skip
        notes.append(f"Over the dilute equation, extrapolated to density 0: {said}.")
    early = [
        f"{case.restitution:g}" for case in results.cases
        if "levels" in results.more and case.times[-1] < SETTLED * dilute
    ]  # fmt: skip
    if early:
        notes.append(
            f"At e = {', '.join(early)} the last time is before {SETTLED:g} l/U: the corrected "
            "equation is too small there, by up to 1.3 ρ₀d² of itself."
        )
    return notes


# -- tracers in a field ----------------------------------------------------------------------------


def _falling(results: Results, table: "DataFrame", checks: Sequence[dict[str, Any]]) -> Story:
    lines, dense = results.more["lines"], results.more["dense"]

    def each(of: Callable[[int, dict[str, Any]], str]) -> str:
        return " and ".join(f"{of(d, line)} among {SCATTERERS[d]}" for d, line in lines.items())

    def ratio(d: int, line: dict[str, Any]) -> str:
        return span(line["diffusion_perpendicular"] / line["diffusion_parallel"], ".2f")

    compared = (
        f"Tracers fall from rest among fixed {results.system.scatterers}; a bounce leaves a share "
        "e of the velocity along the line of centres. Solver and Boltzmann-Grad particles are of "
        "the limit of low density."
    )
    others = table[(table.kind == "statistical") & table.verdict.isin(["unclear", "differs"])]
    said = "; ".join(
        f"{OBSERVABLES[r.observable].short} among {r.system} at e = {r.restitution:g} "
        f"({r.corrected_sigmas:.1f} σ)" for r in others.itertuples()
    )  # fmt: skip
    findings = [
        "For every e below 1 the tracer comes to a constant mean velocity, the drift u. As e → 1 "
        "it moves faster in all directions, collides more often, and falls more slowly: "
        f"u = c (1 − e²)^¼ √(gl), with c = "
        f"{each(lambda d, _: format(float(runs.near_elastic(0.0, d)['drift']), '.4f'))}.",
        agreement(table) + (f" Others: {said}." if said else ""),
        f"Tracers spread faster across the field than along it: D⊥/D∥ is {each(ratio)}.",
    ]
    if dense:
        n = dense[0].places["captures"][1]
        slower = [1 - c.measured[runs.EXTRAPOLATED]["drift_over_density"].value[-1] for c in dense]
        caught = [c.measured[runs.EXTRAPOLATED]["trapped"].value[-1][-1] for c in dense]
        at = ", ".join(f"{c.restitution:g}" for c in dense)
        findings.append(
            f"Hard disks at ρ₀d² = {n[-1]:g} (e = {at}) slow the fall by "
            f"{span([100 * float(x) for x in slower], '.0f')} %, of which the shorter path makes "
            f"{100 * (1 - contact_value(n[-1]) ** -0.5):.0f} %; corners of two disks trap "
            f"{span([100 * float(x) for x in caught], '.0f')} % in the end."
        )
    if results.more["approach"]:
        overshoots, reached = zip(*map(_overshoot, results.more["approach"]), strict=True)
        findings.append(
            f"From rest the mean velocity first exceeds the drift, by {span(overshoots, '.0f')} %, "
            f"and is within {CLOSE:.0%} of it from t = {span(reached, '.2g')} √(l/g) on."
        )
    summary = []
    for case in results.cases:
        for name in ("drift", "diffusion_parallel", "diffusion_perpendicular", "mean_square_speed"):
            if name in case.measured.get(FREE, ()):
                summary.append({
                    "quantity": f"{OBSERVABLES[name].short}, {SCATTERERS[case.dimension]}",
                    "restitution": case.restitution, "error": None, "unit": "", "sign": "",
                    "value": case.theory[runs.SOLVER][name],
                })  # fmt: skip
    summary.sort(key=lambda row: row["quantity"])
    names = ("drift_over_density", "captures")
    tables = {"summary": summary}
    if dense:
        tables["hard_disks"] = [
            {"restitution": c.restitution, "density": float(n)}
            | {k: float(c.measured[runs.EXTRAPOLATED][k].value[i]) for k in names}
            | {"error": float(c.measured[runs.EXTRAPOLATED]["drift_over_density"].error[i])}
            | {"trapped": float(c.measured[runs.EXTRAPOLATED]["trapped"].value[i][-1])}
            | {"until": float(c.times[-1])}
            for c in dense for i, n in enumerate(c.places["captures"][1])
        ]  # fmt: skip
    return Story(compared, findings, f"Finding: {findings[1]}", tables=tables)


def _overshoot(case: Case) -> tuple[float, float]:
    """By how many per cent the mean velocity exceeds the drift, and when it is close to it."""
    ratio = case.theory[runs.SOLVER]["drift_from_rest"] / case.solved.drift
    away = np.flatnonzero(abs(ratio - 1) > CLOSE)
    reached = float(case.times[min(away[-1] + 1, len(ratio) - 1)]) if away.size else 0.0
    return 100 * float(np.max(ratio) - 1), reached


def points(results: Results) -> "DataFrame":
    """Everything measured and every theory at its times and bins, one number in a row."""
    import pandas as pd

    rows = []
    for case in results.cases:
        of = {"system": case.system, "restitution": case.restitution}
        sources = {s: {k: (m.value, m.error) for k, m in x.items()} for s, x in case.measured.items()}
        sources |= {s: {k: (v, np.nan) for k, v in x.items()} for s, x in case.theory.items()}
        for source, found in sources.items():
            for name, (value, error) in found.items():
                place, at = case.places.get(name, ("", np.array(np.nan)))
                if np.ndim(value) > 1 or np.shape(value) not in ((), np.shape(at)):
                    continue
                for x, y, s in zip(*map(np.ravel, np.broadcast_arrays(at, value, error)), strict=True):
                    rows.append({**of, "source": source, "observable": name, "at": place,
                                 "x": x, "value": y, "error": s})  # fmt: skip
    return pd.DataFrame(rows)


__all__ = ["LEVELS", "Story", "agreement", "chance", "off", "points", "span", "tell"]
