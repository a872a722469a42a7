"""One case of the stability sweep: what it came to, and its verdict."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

HOLDS, CAREFUL, SAYS_SO = "holds", "too careful", "says so"
MISSED, BROKEN, SLOW = "missed", "broken", "slow"
ACCEPTED = (HOLDS, CAREFUL, SAYS_SO)
VERDICTS = {
    HOLDS: "a finite answer within the error asked for, and every invariant kept",
    CAREFUL: "the error asked for was reached, though the status says that it was not",
    SAYS_SO: "the status says that the error asked for was not reached; nothing shows that it was",
    MISSED: "the error asked for was not reached, and the status claims that it was",
    BROKEN: "not finite, an invariant violated, a warning, or an exception",
    SLOW: "the answer took longer than a stress case may",
}
LONGEST = 60.0
"""Seconds of processor time that one case may take."""


@dataclass(frozen=True)
class Outcome:
    """What a run gave.

    Attributes
    ----------
    asked : the error asked for; infinite where none was
    reached : the error against a reference; NaN where there is no reference, infinity where the
        answer is not finite
    converged : whether the status claims what was asked for
    in_part : whether ``reached`` is of a part of the answer, the rest having no reference: it may
        show that a claim is wrong, not that an answer without one is right
    known_to : the error of the reference itself
    invariants : name -> (violation, what is allowed), both not negative
    note : anything to add
    """

    asked: float = math.inf
    reached: float = math.nan
    converged: bool = True
    in_part: bool = False
    known_to: float = 0.0
    invariants: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    note: str = ""


@dataclass(frozen=True)
class Case:
    """A case that has not been run: its group, its name, and what to run with which arguments."""

    group: str
    name: str
    work: Callable[..., Outcome]
    arguments: tuple[Any, ...] = ()


@dataclass(frozen=True)
class StressCase:
    """One row: `invariant` names the worst invariant, `violation` and `allowed` are its values.

    `seconds` are of processor time.
    """

    group: str
    name: str
    verdict: str
    asked: float
    reached: float
    invariant: str
    violation: float
    allowed: float
    seconds: float
    note: str

    @property
    def accepted(self) -> bool:
        """Whether it ended as it must."""
        return self.verdict in ACCEPTED


def judge(outcome: Outcome, seconds: float) -> str:
    """The verdict on a run that ended without an exception."""
    if math.isinf(outcome.reached) or any(
        not violation <= allowed for violation, allowed in outcome.invariants.values()
    ):
        return BROKEN
    if outcome.converged and outcome.reached > outcome.asked:
        return MISSED
    if seconds > LONGEST:
        return SLOW
    if outcome.converged:
        return HOLDS
    shown = outcome.reached + outcome.known_to <= outcome.asked < math.inf
    return CAREFUL if shown and not outcome.in_part else SAYS_SO


def attempt(case: Case, clock: Callable[[], float] = time.process_time) -> StressCase:
    """Run one case; nothing that it does stops the sweep, except an interruption."""
    begin = clock()
    outcome = Outcome()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            outcome = case.work(*case.arguments)
        verdict, note = judge(outcome, clock() - begin), outcome.note
    except Exception as met:  # whatever it is, it is the finding
        verdict, note = BROKEN, f"{type(met).__name__}: {met}"
    name, (violation, allowed) = max(
        outcome.invariants.items(),
        key=lambda item: share_of_allowed(*item[1]),
        default=("", (0.0, 0.0)),
    )
    return StressCase(
        case.group, case.name, verdict, outcome.asked, outcome.reached, name, violation, allowed,
        seconds=clock() - begin, note=" ".join(note.split())[:240],
    )  # fmt: skip


def share_of_allowed(violation: float, allowed: float) -> float:
    """How much of what an invariant allows is used up; infinite where it allows nothing."""
    if math.isnan(violation):
        return math.inf
    return violation / allowed if allowed else (math.inf if violation else 0.0)
