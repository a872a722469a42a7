"""The findings of a report in words, and the small tables that the words point to.

A number that belongs to one restitution stands in a table, beside its e; each finding is said once.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from kinetics.crosscheck.report import runs
from kinetics.crosscheck.report.figures import exact_rates
from kinetics.crosscheck.report.rows import OBSERVABLES, kept
from kinetics.crosscheck.report.runs import (
    EXACT,
    FIT,
    FREE,
    KINETIC,
    SOLVER,
    Case,
    Measured,
    Results,
)
from kinetics.crosscheck.report.systems import SCATTERERS, Driven
from kinetics.crosscheck.words import AGREES_BELOW, Verdict, numeral

HOLDS, FAILS = "holds", "does not hold"
SHARE = 0.99  # share of its limit at which d<r^2>/d ln t counts as reached
CLOSE = 0.01  # the drift is reached when the mean velocity stays as close to it, relative to it
Record = dict[str, Any]


class Story(NamedTuple):
    """Findings first, the paper's claims, tables of tidy records: "summary" has quantity,
    restitution, value and error.
    """

    compared: str
    findings: list[str]
    line: str
    claims: Sequence[dict[str, str]] = ()
    tables: Mapping[str, list[Record]] = {}


def tell(results: Results, table: Any, checks: Sequence[Record]) -> Story:
    """The story of any report; `checks` are the rows of the algebra."""
    if isinstance(results.system, Driven):
        return _driven(results, table)
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


def agreement(table: Any) -> str:
    """In how many comparisons that could have shown a difference particles and solver show none."""
    strict = table[(table.kind == "statistical") & (table.source == FREE)]
    tested = strict[strict.verdict != Verdict.NOT_TESTED]
    same, blind = int((tested.verdict == Verdict.AGREES).sum()), len(strict) - len(tested)
    text = f"Equation and dilute simulation agree in {same} of {len(tested)} comparisons"
    text += f" that could show a difference of 10 % ({blind} could not)" if blind else ""
    within = [
        f"{OBSERVABLES[name][1]} within {numeral(100 * rows.within.max(), '.2g')} %"
        for name in ("thermal_speed", "msd", "drift")
        if len(rows := tested[tested.observable == name])
    ]
    text += f": {', '.join(within)}" if within else ""
    solver = table[table.kind == "numerical"]
    met = int((solver.verdict == Verdict.AGREES).sum())
    text += f". The solver meets the closed forms in {met} of {len(solver)}" if len(solver) else ""
    return text + "."


def chance(table: Any) -> str:
    """What the verdicts allow for, and what they expect by chance."""
    rows = int((table.kind == "statistical").sum())
    expected = numeral(rows * math.erfc(AGREES_BELOW / math.sqrt(2)), ".2g")
    return (
        f"{rows} rows are statistical; each shows the worst of its times or bins, its p-value "
        "(Student's, errors jackknifed over independent groups) multiplied by their number and "
        "turned into corrected sigmas. Were every theory true, at most "
        f"{expected} of them would not agree by chance."
    )


def _cooling(results: Results, table: Any, checks: Sequence[Record]) -> Story:
    system: Any = results.system
    of, cases, paper = system.scatterers, results.cooling, system.is_papers_law
    rough = "" if system.is_smooth else f", e_t = {system.tangential_restitution:g},"
    first = results.cases[0]
    free, hard = (f"{first.samples(name):,}".replace(",", "\u202f") for name in first.runs)
    compared = (
        f"Tracers among fixed {of}{rough} lose speed at every bounce"
        f"{' (H.-D. Kim and H. Hayakawa)' if paper else ''}. For each e: the equation to "
        f"{numeral(system.rtol, '.0e')}, {free} tracers of the dilute limit, {hard} among hard "
        f"{of}, ρ₀d{'³' if system.dimension == 3 else '²'} = {system.number_density:g}."
    )
    both = [(case, case.measured[f"hard {of}"]["msd"].last) for case in results.cases]
    ends = [msd / case.theory[KINETIC]["msd"][-1] for case, msd in both]
    disks = off([float(ratio.value) - 1 for ratio in ends])
    sure = f"± {span([100 * float(ratio.error) for ratio in ends], '.1f')} %"
    left = [float(r2.value) / c.solved.dense.msd[-1] - 1 for c, r2 in both if c.solved.dense]
    # the second order was fitted to other runs
    corrected = f"; corrected for density, nothing fitted here, {off(left)} it" if left else ""
    spread = (
        f"Hard {of} spread less than the equation, which forgets every scatterer: ⟨r²⟩ ends "
        f"{disks} it ({sure}){corrected}."
    )
    findings = [agreement(table)]
    line = f"Finding: ⟨r²⟩ of hard {of} ends {disks} the equation ({sure})"
    if paper and cases:
        e, exact = exact_rates(1.0, 2)
        rates = [case.theory[EXACT]["cooling_rate"] / (1 - case.restitution) for case in cases]
        line = f"Finding: exact h/(1 − e) at these e is {span(rates, '.2f')}, not 1.45; {line[9:]}"
        errata = ", ".join(c["label"] for c in checks if c["status"] == "erratum")
        findings += [
            "The cooling rate is not 1.45 (1 − e): exact h/(1 − e) is 4/3 to "
            f"{max(exact / (1 - e)):.2f} over all e, {span(rates, '.2f')} at these. The paper’s is "
            "lifted by a start not yet forgotten and disks not dilute.",
            spread,
            "The tracer is not localized: ⟨r²⟩ grows as ln t without bound. The paper’s random "
            "walk fits because its two fitted numbers stand for the density.",
            "F(c) is no Gaussian, and no exponential tail of G(R) is seen. Of "
            f"{len(checks)} printed formulas derived again all follow"
            + (f" but {errata}, a misprint." if errata else "."),
        ]
    elif cases:
        findings += [
            "In the end v₀ = 2l/(ht) with the exact h of the table, and the mean square "
            "displacement grows as the logarithm of time, without bound.",
            spread,
        ]
    else:
        findings.append(spread)
    summary = [row for case in results.cases for row in _summary(case, system)]
    claims = _claims(cases) if paper and cases else []
    return Story(compared, findings, line, claims, {"summary": summary})


def _summary(case: Case, system: Any) -> Iterable[Record]:
    """What the findings rest on, at one restitution."""
    e, solved, theory = case.restitution, case.solved, case.theory
    hard, name = case.measured[f"hard {system.scatterers}"], f"hard {system.scatterers}"
    unit, over = (1 - e, "/(1 − e)") if system.is_smooth else (1.0, "")

    def row(quantity: str, value: Any, error: float | None = None) -> Record:
        if isinstance(value, Measured):
            value, error = float(value.last.value), float(value.last.error)
        return {"quantity": quantity, "restitution": e, "value": float(value), "error": error}

    def percent(quantity: str, ratio: Any) -> Record:
        found = row(f"{quantity}, %", ratio)
        error = None if found["error"] is None else 100 * found["error"]
        return found | {"value": 100 * (found["value"] - 1), "error": error}

    if case.cools:
        exact, rate = theory[EXACT]["cooling_rate"], float(theory[KINETIC]["cooling_rate"])
        yield row(f"h{over}, exact, late times", exact / unit)
        yield percent("… start not yet forgotten", rate / exact)
        yield percent("… finite density, measured", hard["cooling_rate"] / rate)
        if solved.dense is not None:
            speeds = [1 / solved.dense.thermal_speed[k] for k in (solved.early, -1)]
            window = (case.times[-1] - case.times[solved.early]) * system.half_rate
            yield percent("… finite density, predicted", (speeds[1] - speeds[0]) / window / rate)
        yield row(f"h{over}, {name}", hard["cooling_rate"] / unit)
    yield percent("free path over dilute", hard["free_path"] / theory[KINETIC]["free_path"])
    kinetic = theory[KINETIC]["msd"][-1]
    yield percent(f"⟨r²⟩ of {name} at the end over dilute", hard["msd"] / kinetic)
    before = kinetic
    for level, msd in solved.levels.items():
        yield percent(f"… the {level} makes", 1 + (msd - before) / kinetic)
        before = msd
    if solved.dense is not None:
        yield percent("⟨r²⟩ at the end over corrected", hard["msd"] / solved.dense.msd[-1])
    if FIT in theory and case.cools:
        yield percent("⟨r²⟩ at the end over the paper’s walk", hard["msd"] / theory[FIT]["msd"][-1])
        slope = theory[FIT]["msd_slope"]
        yield percent("late slope of the walk over dilute", slope / theory[EXACT]["msd_slope"])
        if solved.dense_slope is not None:
            yield percent("late slope of the walk over hard disks", slope / solved.dense_slope)
    if case.cools:
        share = np.maximum.accumulate(solved.late.msd_slope / theory[EXACT]["msd_slope"])
        time = np.exp(np.interp(SHARE, share, np.log(solved.late.times)))
        yield row(f"time from which d⟨r²⟩/d ln t has {SHARE:.0%} of its limit, d/U", f"{time:.2g}")
        yield row("a₂, exact (a Gaussian has 0)", theory[EXACT]["a2"])
    exponent = solved.position.position_tail((4.0,))[0][-1][0]
    yield row("tail exponent n at R = 4 (exponential 1, Gaussian 2)", exponent)
    yield row("kurtosis of the displacement at the end", solved.kinetic.kurtosis[-1])
    yield row("… at 10⁹ d/U", solved.late.kurtosis[-1])
    yield row("tracers at rest in corners of hard scatterers", hard["trapped"].value)


def _claims(cases: Sequence[Case]) -> list[dict[str, str]]:
    """What the paper claims, where, whether it holds, and why; numbers are in the summary."""
    tails = [float(c.solved.position.position_tail((4.0,))[0][-1][0]) for c in cases]
    exponential = max([n for n in tails if math.isfinite(n)], default=math.nan) < 1.1
    words = {
        "decades": span([c.theory[EXACT]["msd_slope"] * math.log(10) for c in cases], ".3g"),
        "tail": HOLDS if exponential else FAILS,
    }
    names = ("claim", "place", "judgement", "text")
    return [
        dict(zip(names, (text.format(**words) for text in claim), strict=True))
        for claim in kept()["claims"]
    ]


# -- tracers in a field ----------------------------------------------------------------------------
def _falling(results: Results, table: Any, checks: Sequence[Record]) -> Story:
    lines = results.more["lines"]

    def each(of: Callable[[int, Any], str]) -> str:
        return " and ".join(f"{of(d, line)} among {SCATTERERS[d]}" for d, line in lines.items())

    def constant(d: int, line: Any) -> str:
        return f"{float(runs.near_elastic(0.0, d)['drift']):.4f}"

    def ratio(d: int, line: Any) -> str:
        return span(line["diffusion_perpendicular"] / line["diffusion_parallel"], ".2f")

    compared = (
        f"Tracers fall from rest among fixed {results.system.scatterers}, and lose speed at every "
        "bounce. Solver and Boltzmann-Grad particles are of the dilute limit."
    )
    others = table[(table.kind == "statistical") & table.verdict.isin(["unclear", "differs"])]
    said = "; ".join(
        f"{OBSERVABLES[r.observable][1]} among {r.system}, e = {r.restitution:g}: "
        f"{r.corrected_sigmas:.1f} σ" for r in others.itertuples()
    )  # fmt: skip
    findings = [
        "At every e below 1 the tracer reaches a constant mean velocity, the drift u. As e → 1 "
        "it flies faster, collides more often and falls more slowly: u/√(gl) → "
        f"c (1 − e²)^(1/4), c = {each(constant)}.",
        agreement(table) + (f" Not: {said}." if said else ""),
        f"Tracers spread faster across the field than along it: D⊥/D∥ is {each(ratio)}.",
    ]
    summary = sorted(
        (
            {"quantity": f"{OBSERVABLES[name][1]}, {SCATTERERS[case.dimension]}",
             "restitution": case.restitution, "value": case.theory[SOLVER][name], "error": None}
            for case in results.cases
            for name in ("drift", "diffusion_parallel", "diffusion_perpendicular", "mean_speed")
            if name in case.theory[SOLVER]
        ), key=lambda row: row["quantity"],
    )  # fmt: skip
    if results.more["approach"]:
        overshoots, reached = [], []
        for case in results.more["approach"]:
            over = case.theory[SOLVER]["drift_from_rest"] / case.solved.drift
            away = [-1, *np.flatnonzero(abs(over - 1) > CLOSE)][-1]
            overshoots.append(100 * float(np.max(over) - 1))
            reached.append(float(case.times[min(away + 1, over.size - 1)]) if away >= 0 else 0.0)
        findings.append(
            f"From rest the mean velocity first exceeds the drift, by {span(overshoots, '.0f')} %, "
            f"and is within {100 * CLOSE:g} % of it from t = {span(reached, '.2g')} √(l/g) on."
        )
    return Story(compared, findings, f"Finding: {findings[1]}", tables={"summary": summary})


# -- driven tracers, and a restitution of the impact speed -----------------------------------------
def _driven(results: Results, table: Any) -> Story:
    system: Any = results.system
    what = {
        "bath": f"moving {system.scatterers}, infinitely heavy, w = {system.bath_speed:g} U",
        "heated": f"fixed {system.scatterers}, heated by white noise, Dᵥ = {system.heating:g} U³/l",
        "viscoelastic": f"fixed viscoelastic {system.scatterers}",
    }[system.name]
    compared = (
        f"Tracers among {what}, from a Gaussian start. "
        "Solver and Boltzmann-Grad particles are of the dilute limit."
    )
    records: list[Record] = []
    for case in results.cases:
        state = case.solved.state
        found = {name: float(case.theory[SOLVER][name][-1]) for name in ("thermal_speed", "msd")}
        if state is None:
            v0, t = case.theory[SOLVER]["thermal_speed"], case.times
            slope = math.log(v0[-1] / v0[-3]) / math.log(t[-1] / t[-3])
            values = {"v₀ at the end": found["thermal_speed"], "⟨r²⟩ at the end": found["msd"],
                      "local power of t in v₀ at the end": slope,
                      "a₂ at the end": case.theory[SOLVER]["a2"][-1]}  # fmt: skip
        else:
            values = {
                "v₀, steady": state.thermal_speed,
                "a₂, steady": state.a2 if abs(state.a2) > state.rtol else 0.0,
                "collision rate": state.collision_rate, "D": state.diffusion_coefficient,
                "mobility μ": state.mobility,
                "μ⟨vₓ²⟩/D": state.mobility * state.mean_square_along / state.diffusion_coefficient,
            }  # fmt: skip
        records += [
            {"quantity": name, "restitution": case.restitution, "value": float(x), "error": None}
            for name, x in values.items()
        ]

    def each(name: str, form: str) -> str:
        return span([r["value"] for r in records if r["quantity"] == name], form)

    if system.name == "bath":
        first = (
            "The steady state is Maxwellian, of the temperature ⟨vₓ²⟩ = w²(1 + e)/(1 − e), though "
            "no bounce keeps the energy."
        )
        last = f"The Einstein relation μ⟨vₓ²⟩/D = 1 holds all the same; D is {each('D', '.4g')} Ul."
    elif system.name == "heated":
        first = f"The steady state is not Maxwellian: a₂ is {each('a₂, steady', '.3g')}."
        last = f"The Einstein relation does not hold: μ⟨vₓ²⟩/D is {each('μ⟨vₓ²⟩/D', '.4g')}, not 1."
    else:
        power = each("local power of t in v₀ at the end", ".3g")
        first = f"Slow impacts lose less: in the end v₀ falls as t^({power}), at a fixed e as 1/t."
        last = f"⟨r²⟩ keeps growing and is {each('⟨r²⟩ at the end', '.4g')} l² at the last time."
    findings = [first, agreement(table), last]
    return Story(compared, findings, f"Finding: {findings[1]}", tables={"summary": records})
