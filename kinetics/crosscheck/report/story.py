"""The findings of a report in words, and the small tables that the words point to.

A number that belongs to one restitution stands in a table, beside its e; each finding is said once.
Sentences are in `templates/report.json`, with "{words}" that are filled here.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from kinetics.crosscheck.report import runs
from kinetics.crosscheck.report.figures import exact_rates, limiting_drift
from kinetics.crosscheck.report.rows import OBSERVABLES, kept
from kinetics.crosscheck.report.systems import Driven
from kinetics.crosscheck.words import AGREES_BELOW, Verdict, numeral

HOLDS, FAILS = "holds", "does not hold"
CLOSE = 0.01  # relative: a drift, or the limit of d<r^2>/d ln t, from which on it is reached
Record = dict[str, Any]
_WORDS: dict[str, Any] = kept()["story"]


class Story(NamedTuple):
    """Findings first, the paper's claims, tables of tidy records: "summary" has quantity,
    restitution, value and error.
    """

    compared: str
    findings: list[str]
    line: str
    claims: Sequence[dict[str, str]] = ()
    tables: Mapping[str, list[Record]] = {}


def tell(results: runs.Results, table: Any, checks: Sequence[Record]) -> Story:
    """The story of any report; `checks` are the rows of the algebra."""
    if isinstance(results.system, Driven):
        return _driven(results, table)
    return _cooling(results, table, checks)


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
    strict = table[(table.kind == "statistical") & (table.source == runs.FREE)]
    tested = strict[strict.verdict != Verdict.NOT_TESTED]
    same, blind = int((tested.verdict == Verdict.AGREES).sum()), len(strict) - len(tested)
    within = [
        f"{OBSERVABLES[name][1]} within {numeral(100 * rows.within.max(), '.2g')} %"
        for name in ("thermal_speed", "msd", "drift")
        if len(rows := tested[tested.observable == name])
    ]
    solver = table[table.kind == "numerical"]
    met = f"{int((solver.verdict == Verdict.AGREES).sum())} of {len(solver)}"
    return str(_WORDS["agreement"]).format(
        same=same, tested=len(tested), within=f": {', '.join(within)}" if within else "",
        blind=f" that could show a difference of 10 % ({blind} could not)" if blind else "",
        solver=f". The solver meets the closed forms in {met}" if len(solver) else "",
    )  # fmt: skip


def chance(table: Any) -> str:
    """What the verdicts allow for, and what they expect by chance."""
    rows = int((table.kind == "statistical").sum())
    expected = numeral(rows * math.erfc(AGREES_BELOW / math.sqrt(2)), ".2g")
    return str(_WORDS["chance"]).format(rows=rows, expected=expected)


def _cooling(results: runs.Results, table: Any, checks: Sequence[Record]) -> Story:
    system: Any = results.system
    of, cases, paper = system.scatterers, results.cooling, system.is_papers_law
    told, first, rates = _WORDS["cooling"], results.cases[0], ""
    free, hard = (f"{first.samples(name):,}".replace(",", "\u202f") for name in first.runs)
    both = [(case, case.measured[f"hard {of}"]["msd"].last) for case in results.cases]
    ends = [msd / case.theory[runs.KINETIC]["msd"][-1] for case, msd in both]
    # the second order was fitted to other runs
    left = [float(r2.value) / c.solved.dense.msd[-1] - 1 for c, r2 in both if c.solved.dense]
    words: dict[str, Any] = {
        "of": of, "free": free, "hard": hard, "density": system.number_density,
        "rough": "" if system.is_smooth else f", e_t = {system.tangential_restitution:g},",
        "authors": " (H.-D. Kim and H. Hayakawa)" if paper else "",
        "rtol": numeral(system.rtol, ".0e"), "power": "³" if system.dimension == 3 else "²",
        "disks": off([float(ratio.value) - 1 for ratio in ends]),
        "sure": f"± {span([100 * float(ratio.error) for ratio in ends], '.1f')} %",
        "corrected": f"; corrected for density, nothing fitted here, {off(left)} it" * bool(left),
    }  # fmt: skip
    if paper and cases:
        e, exact = exact_rates(1.0, 2)
        of_late = (c.theory[runs.EXACT]["cooling_rate"] / (1 - c.restitution) for c in cases)
        errata = ", ".join(c["label"] for c in checks if c["status"] == "erratum")
        words |= {
            "most": max(exact / (1 - e)), "rates": span(of_late, ".2f"), "checks": len(checks),
            "errata": f" but {errata}, a misprint" if errata else "",
        }  # fmt: skip
        rates = f"exact h/(1 − e) at these e is {words['rates']}, not 1.45; "
    words |= {"rates_of_paper": rates, "spread": told["spread"].format(**words)}
    found = told["paper" if rates else "others" if cases else "elastic"]
    compared, line, *findings = (
        text.format(**words) for text in (told["compared"], told["line"], *found)
    )
    summary = [row for case in results.cases for row in _summary(case, system)]
    claims = _claims(cases) if paper and cases else []
    return Story(compared, [agreement(table), *findings], line, claims, {"summary": summary})


def _summary(case: runs.Case, system: Any) -> Iterable[Record]:
    """What the findings rest on, at one restitution."""
    e, solved, theory = case.restitution, case.solved, case.theory
    hard, name = case.measured[f"hard {system.scatterers}"], f"hard {system.scatterers}"
    unit, over = (1 - e, "/(1 − e)") if system.is_smooth else (1.0, "")

    def row(quantity: str, value: Any, error: float | None = None) -> Record:
        if isinstance(value, runs.Measured):
            value, error = float(value.last.value), float(value.last.error)
        return {"quantity": quantity, "restitution": e, "value": float(value), "error": error}

    def percent(quantity: str, ratio: Any) -> Record:
        found = row(f"{quantity}, %", ratio)
        error = None if found["error"] is None else 100 * found["error"]
        return found | {"value": 100 * (found["value"] - 1), "error": error}

    if case.cools:
        exact, rate = (float(theory[who]["cooling_rate"]) for who in (runs.EXACT, runs.KINETIC))
        yield row(f"h{over}, exact, late times", exact / unit)
        yield percent("… start not yet forgotten", rate / exact)
        yield percent("… finite density, measured", hard["cooling_rate"] / rate)
        if solved.dense is not None:
            speeds = [1 / solved.dense.thermal_speed[k] for k in (solved.early, -1)]
            window = (case.times[-1] - case.times[solved.early]) * system.half_rate
            yield percent("… finite density, predicted", (speeds[1] - speeds[0]) / window / rate)
        yield row(f"h{over}, {name}", hard["cooling_rate"] / unit)
    yield percent("free path over dilute", hard["free_path"] / theory[runs.KINETIC]["free_path"])
    kinetic = theory[runs.KINETIC]["msd"][-1]
    yield percent(f"⟨r²⟩ of {name} at the end over dilute", hard["msd"] / kinetic)
    if solved.dense is not None:
        yield percent("⟨r²⟩ at the end over corrected", hard["msd"] / solved.dense.msd[-1])
    if runs.FIT in theory and case.cools:
        walk, slope = (theory[runs.FIT][name] for name in ("msd", "msd_slope"))
        yield percent("⟨r²⟩ at the end over the paper’s walk", hard["msd"] / walk[-1])
        yield percent("late slope of the walk over dilute", slope / theory[runs.EXACT]["msd_slope"])
    if case.cools:
        share = np.maximum.accumulate(solved.late.msd_slope / theory[runs.EXACT]["msd_slope"])
        time = np.exp(np.interp(1 - CLOSE, share, np.log(solved.late.times)))
        when = f"time from which d⟨r²⟩/d ln t has {1 - CLOSE:.0%} of its limit, d/U"
        yield row(when, f"{time:.2g}")
        yield row("a₂, exact (a Gaussian has 0)", theory[runs.EXACT]["a2"])
    exponent = solved.position.position_tail((4.0,))[0][-1][0]
    yield row("tail exponent n at R = 4 (exponential 1, Gaussian 2)", exponent)
    yield row("kurtosis of the displacement at the end", solved.kinetic.kurtosis[-1])
    yield row("… at 10⁹ d/U", solved.late.kurtosis[-1])
    yield row("tracers at rest in corners of hard scatterers", hard["trapped"].value)


def _claims(cases: Sequence[runs.Case]) -> list[dict[str, str]]:
    """What the paper claims, where, whether it holds, and why; numbers are in the summary."""
    tails = [float(c.solved.position.position_tail((4.0,))[0][-1][0]) for c in cases]
    exponential = max([n for n in tails if math.isfinite(n)], default=math.nan) < 1.1
    words = {
        "decades": span([c.theory[runs.EXACT]["msd_slope"] * math.log(10) for c in cases], ".3g"),
        "tail": HOLDS if exponential else FAILS,
    }
    names = ("claim", "place", "judgement", "text")
    return [
        dict(zip(names, (text.format(**words) for text in claim), strict=True))
        for claim in kept()["claims"]
    ]


# -- driven tracers, and a restitution of the impact speed -----------------------------------------
def _driven(results: runs.Results, table: Any) -> Story:
    records: list[Record] = []
    for case in results.cases:
        state, said = case.solved, case.theory[runs.SOLVER]
        if state is None:
            v0, r2, a2 = (said[n] for n in ("thermal_speed", "msd", "a2"))
            slope = math.log(v0[-1] / v0[-3]) / math.log(case.times[-1] / case.times[-3])
            values = {"v₀ at the end": v0[-1], "⟨r²⟩ at the end": r2[-1],
                      "local power of t in v₀ at the end": slope,
                      "a₂ at the end": a2[-1]}  # fmt: skip
        elif state.field:
            over = said["drift_from_rest"] / state.drift
            away = [-1, *np.flatnonzero(abs(over - 1) > CLOSE)][-1]
            names = ("diffusion_parallel", "diffusion_perpendicular", "drift", "mean_speed")
            values = {OBSERVABLES[name][1]: said[name] for name in names}
            values |= {"D⊥/D∥": said[names[1]] / said[names[0]],
                       "overshoot of ⟨v_z⟩ from rest, %": 100 * (np.max(over) - 1),
                       f"within {CLOSE:.0%} of u from t": case.times[away + 1]}  # fmt: skip
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

    forms = {
        "diffusion": ("D", ".4g"), "a2": ("a₂, steady", ".3g"), "einstein": ("μ⟨vₓ²⟩/D", ".4g"),
        "power": ("local power of t in v₀ at the end", ".3g"), "msd": ("⟨r²⟩ at the end", ".4g"),
        "ratio": ("D⊥/D∥", ".2f"),
    }  # fmt: skip
    words = {
        word: span([r["value"] for r in records if r["quantity"] == name], form)
        for word, (name, form) in forms.items()
    }
    system: Any = results.system
    words |= {"of": system.scatterers, **system.drive}
    words |= {"constant": f"{limiting_drift(0.0, system.dimension):.4f}"}
    what, first, last = (t.format(**words) for t in _WORDS["driven"][system.name])
    compared, agree = _WORDS["driven"]["compared"].format(what=what), agreement(table)
    return Story(compared, [first, agree, last], f"Finding: {agree}", tables={"summary": records})
