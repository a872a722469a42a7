"""What the paper claims in words, each judged with the numbers of this report.

The sentences stand in `../templates/headline.txt.j2`.
"""

import math
from typing import Any

import numpy as np

from kinetics import sonine
from kinetics.crosscheck.report.case import Case
from kinetics.crosscheck.report.case_rows import PAPER_KURTOSIS
from kinetics.crosscheck.report.causes import causes
from kinetics.crosscheck.report.figure_lines import Results
from kinetics.crosscheck.report.observables import msd_slope_between, printed_msd_slopes
from kinetics.crosscheck.report.templates import paragraphs

HOLDS, PARTLY, FAILS = "holds", "holds in part", "does not hold"
SHOWN_TIMES = (1e3, 1e6, 1e9)
"""Times in d/U at which the growth of <r^2> without bound is shown."""
EXPONENTIAL = 1.1
"""Local exponent n(4) below which a tail is called exponential."""


def claims(results: Results) -> list[dict[str, Any]]:
    """Claim, place in the paper, judgement and text; empty for other laws than the paper's."""
    if not results.is_papers_law or not results.cooling:
        return []
    cases = results.cooling
    tails = [float(c.position.position_tail((4.0,))[0][-1][0]) for c in cases]
    known = [n for n in tails if math.isfinite(n)]
    late = [float(c.late.kurtosis[-1]) for c in cases]
    at_end = [float(c.kinetic.kurtosis[-1]) for c in cases]
    return [
        _claim("rate", PARTLY, causes=causes(results), fit=sonine.FITTED_COOLING_FACTOR),
        _claim("maxwellian", FAILS, a2=[c.scaling_state[0].a2 for c in cases], cases=cases),
        _claim("logarithm", HOLDS, slopes=[_slope_share(c) for c in cases]),
        _claim("localized", FAILS, growth=[_growth(c) for c in cases], times=SHOWN_TIMES),
        _claim("identical", PARTLY, walks=[walk_of(c) for c in cases]),
        _claim("tail", HOLDS if known and max(known) < EXPONENTIAL else FAILS, tails=tails),
        _claim("universal", FAILS, ends=at_end, late=late, last=float(cases[0].late.times[-1]),
               printed=PAPER_KURTOSIS),
    ]  # fmt: skip


def _claim(block: str, judgement: str, **values: Any) -> dict[str, Any]:
    claim, place, text = paragraphs("headline.txt.j2", f"claim_{block}", **values)
    return {"claim": claim, "place": place, "judgement": judgement, "text": text}


def _slope_share(case: Case) -> float:
    """d<r^2>/d ln t over its limit, between the last two decades of the late times."""
    late = case.late
    back = int(np.searchsorted(late.times, late.times[-1] / 100))
    return msd_slope_between(late.times, late.msd, back) / case.late_msd_slope


def _growth(case: Case) -> dict[str, Any]:
    """<r^2> at the shown times, and what each decade adds in the end."""
    at = np.interp(np.log(SHOWN_TIMES), np.log(case.late.times), case.late.msd)
    decade = case.late_msd_slope * math.log(10)
    return {"restitution": case.restitution, "msd": at.tolist(), "decade": decade}


def walk_of(case: Case) -> dict[str, Any]:
    """Relative differences of the paper's random walk, in per cent.

    "disks": <r^2> of hard disks from the walk's at the last time, with "error"; "worst": the same
    at the worst time of the last decade; "dilute" and "dense": the walk's late slope in ln t from
    those of the dilute equation and of the equation of hard disks.
    """
    density = 1 / (2 * case.late.scene.mean_free_path)
    walk = sonine.msd_random_walk(case.times, case.restitution, density)
    ratio = 100 * (case.hard.msd.value / walk - 1)
    limit, _ = printed_msd_slopes(case.restitution, density)
    dense = None if case.dense_slope is None else 100 * (limit / case.dense_slope - 1)
    decade = ratio[case.early :]
    return {
        "restitution": case.restitution,
        "disks": float(ratio[-1]),
        "error": float(100 * case.hard.msd.error[-1] / walk[-1]),
        "worst": float(decade[np.argmax(np.abs(decade))]),
        "dilute": 100 * (limit / case.late_msd_slope - 1),
        "dense": dense,
    }
