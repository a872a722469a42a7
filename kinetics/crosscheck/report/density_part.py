"""The part of a report on the finite density of the scatterers: its table, text and figures."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from kinetics.collision.medium import HIGHEST_DENSITY, SETTLED
from kinetics.crosscheck.numerals import numeral
from kinetics.crosscheck.report.case import Case, Scans
from kinetics.crosscheck.report.density_levels import (
    DILUTE,
    FIRST,
    FITTED,
    LEADING,
    LEVELS,
    PATH,
    PlacePrediction,
    Prediction,
    place_predictions,
    predictions,
)
from kinetics.crosscheck.report.density_scan import ReturnScan, figures, gather_returns
from kinetics.crosscheck.report.settings import ReportSettings
from kinetics.crosscheck.report.templates import paragraphs
from kinetics.crosscheck.strict_json import plain


@dataclass(frozen=True)
class DensityPart:
    """All that is in the part."""

    predictions: list[Prediction]
    places: list[PlacePrediction]
    scan: ReturnScan


def gather_density_part(
    cases: Sequence[Case], scans: Scans, settings: ReportSettings
) -> DensityPart | None:
    """Solve and run what the part needs; None at a density that the theory is not tried at."""
    if settings.number_density > HIGHEST_DENSITY:
        return None
    (case,) = (case for case in cases if case.restitution == scans.density.restitution)
    return DensityPart(
        predictions=predictions(cases, settings),
        places=place_predictions(cases, settings),
        scan=gather_returns(case, scans.density, settings),
    )


def add_density_part(
    document: dict[str, Any], part: DensityPart | None, cases: Sequence[Case]
) -> dict[str, Any]:
    """The document with "finite_density" and two more figures."""
    if part is None:
        return document
    own = {
        "levels": LEVELS,
        "text": _text(part, cases),
        "rows": [
            asdict(row) | {"off": {level: asdict(row.off(level)) for level in LEVELS}}
            for row in part.predictions
        ],
        "places": [asdict(row) for row in part.places],
        "scan": asdict(part.scan),
    }
    more = plain({"finite_density": own, "figures": document["figures"] | figures(part.scan)})
    return document | more


def _text(part: DensityPart, cases: Sequence[Case]) -> list[str]:
    """What the numbers explain, a paragraph for each restitution, and what they do not."""
    by_case = {
        case.restitution: {
            row.observable: row for row in part.predictions if row.restitution == case.restitution
        }
        for case in cases
    }
    early = [
        case.restitution for case in cases
        if case.times[-1] < SETTLED * case.kinetic.scene.mean_free_path
    ]  # fmt: skip
    return paragraphs(
        "density.txt.j2", "explanation", by_case=by_case, places=part.places, early=early,
        settled=SETTLED, dilute=DILUTE, path=PATH, leading=LEADING, first=FIRST, fitted=FITTED,
        percent=_percent,
    )  # fmt: skip


def _percent(value: Any, error: Any = None) -> str:
    """A ratio less 1, in per cent, with its standard error if it has one."""
    text = numeral(100.0 * float(value), "+.1f")
    return f"{text} %" if error is None else f"{text} ± {100.0 * float(error):.1f} %"
