"""One row of a benchmark: a measured figure, or what could not be measured."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

MEASURED, FAILED, NOT_AVAILABLE = "measured", "failed", "not available"

PRECISION, ACCURACY, SKIPPING = "precision", "accuracy", "skipping"
COST, PARTICLES = "cost", "particles"
"""The sections of a benchmark."""


@dataclass(frozen=True)
class Record:
    """One row.

    Attributes
    ----------
    section : the part of the benchmark
    problem : what is solved, with its restitution
    method : who solves it
    setting : name of what is varied: "rtol", "nodes", "order", "samples", ...
    value : of the setting; None where there is none
    seconds, low, high : median and quartiles of the run time in s; None if not measured. Of one
        thread the processor time, so that others on the machine do not count; of more, wall-clock
    wall : median of the wall-clock time in s
    warm_up : wall-clock time of the first call, in s
    repeats : behind the median
    error : error reached, as the section defines it; None where it has none
    asked : error asked for
    status : "measured", "failed" or "not available"
    note : why it failed, or what else there is to say
    threads : that the work might use
    extra : further figures by name
    """

    section: str
    problem: str
    method: str
    setting: str = ""
    value: float | None = None
    seconds: float | None = None
    low: float | None = None
    high: float | None = None
    wall: float | None = None
    warm_up: float | None = None
    repeats: int = 0
    error: float | None = None
    asked: float | None = None
    status: str = MEASURED
    note: str = ""
    threads: int = 1
    extra: dict[str, Any] = field(default_factory=dict)


def failed(section: str, problem: str, method: str, why: object, **others: Any) -> Record:
    """A row that says on one line what went wrong; why : an exception, or words."""
    text = f"{type(why).__name__}: {why}" if isinstance(why, Exception) else str(why)
    note = " ".join(text.split())[:200]
    return Record(section, problem, method, status=FAILED, note=note, **others)
