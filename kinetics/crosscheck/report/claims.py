"""What the paper claims in words, each judged with the numbers of this report.

The sentences stand in `../templates/headline.txt.j2`.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from kinetics import sonine
from kinetics.crosscheck.report.case import Case
from kinetics.crosscheck.report.case_rows import PAPER_KURTOSIS
from kinetics.crosscheck.report.causes import causes
from kinetics.crosscheck.report.figure_lines import Results
from kinetics.crosscheck.report.observables import msd_slope_between, printed_msd_slopes
from kinetics.crosscheck.report.row import PAPER_FIT, Row
from kinetics.crosscheck.report.templates import paragraphs
from kinetics.crosscheck.verdicts import Verdict

HOLDS, PARTLY, FAILS = "holds", "holds in part", "does not hold"
SHOWN_TIMES = (1e3, 1e6, 1e9)
"""Times in d/U at which the growth of <r^2> without bound is shown."""
EXPONENTIAL = 1.1
"""Local exponent n(4) below which a tail is called exponential."""


def claims(results: Results, rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Claim, place in the paper, judgement and text; empty for other laws than the paper's."""
    if not results.is_papers_law or not results.cooling:
        return []
    cases = results.cooling
    walk = [r for r in rows if r.observable == "msd" and r.against == PAPER_FIT and r.sigmas]
    identical = FAILS if any(r.verdict is Verdict.DIFFERS for r in walk) else PARTLY
    tails = [float(c.position.position_tail((4.0,))[0][-1][0]) for c in cases]
    known = [n for n in tails if math.isfinite(n)]
    late = [float(c.late.kurtosis[-1]) for c in cases]
    at_end = [float(c.kinetic.kurtosis[-1]) for c in cases]
    return [
        _claim("rate", PARTLY, causes=causes(results), fit=sonine.FITTED_COOLING_FACTOR),
        _claim("maxwellian", FAILS, a2=[c.scaling_state[0].a2 for c in cases], cases=cases),
        _claim("logarithm", HOLDS, slopes=[_slope_share(c) for c in cases]),
        _claim("localized", FAILS, growth=[_growth(c) for c in cases], times=SHOWN_TIMES),
        _claim("identical", identical, walk=walk, slopes=[walk_slope(c) for c in cases]),
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


def walk_slope(case: Case) -> dict[str, float]:
    """Mean d<r^2>/d ln t over the last decade: the walk's over that of hard disks; and late."""
    density = 1 / (2 * case.late.scene.mean_free_path)
    walk = sonine.msd_random_walk(case.times, case.restitution, density)
    slope = msd_slope_between(case.times, walk, case.early)
    limit, _ = printed_msd_slopes(case.restitution, density)
    return {
        "restitution": case.restitution,
        "disks": float(case.hard.msd_slope.value) / slope - 1,
        "error": float(case.hard.msd_slope.error) / slope,
        "late": limit / case.late_msd_slope - 1,
    }
