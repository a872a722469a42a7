"""One case of the stability sweep: what it came to, and its verdict."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from kinetics.errors import InputError

HOLDS, SAYS_SO, REFUSED = "holds", "says so", "refused"
MISSED, BROKEN, SLOW = "missed", "broken", "slow"
ACCEPTED = (HOLDS, SAYS_SO, REFUSED)
VERDICTS = {
    HOLDS: "a finite answer within the error asked for, and every invariant kept",
    SAYS_SO: "the error asked for was not reached, and the status says so",
    REFUSED: "an error that names the argument and says what to change",
    MISSED: "the error asked for was not reached, and the status claims that it was",
    BROKEN: "not finite, an invariant violated, a warning, or an exception that explains nothing",
    SLOW: "it holds, but took longer than a stress case may",
}
LONGEST = 20.0
"""Seconds that one case may take."""


@dataclass(frozen=True)
class Outcome:
    """What a run gave.

    Attributes
    ----------
    asked : the error asked for; infinite where none was
    reached : the error against a reference; NaN where there is no reference, infinity where the
        answer is not finite
    converged : whether the status claims what was asked for
    invariants : name -> (violation, what is allowed), both not negative
    note : anything to add
    """

    asked: float = math.inf
    reached: float = math.nan
    converged: bool = True
    invariants: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    note: str = ""


@dataclass(frozen=True)
class StressCase:
    """One row: `invariant` names the worst invariant, `violation` and `allowed` are its values."""

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
    if outcome.reached > outcome.asked:
        return MISSED if outcome.converged else SAYS_SO
    if not outcome.converged:
        return SAYS_SO
    return SLOW if seconds > LONGEST else HOLDS


def attempt(
    group: str,
    name: str,
    work: Callable[[], Outcome],
    clock: Callable[[], float] = time.perf_counter,
) -> StressCase:
    """Run one case; nothing that it does stops the sweep, except an interruption."""
    begin = clock()
    outcome, note = Outcome(), ""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            outcome = work()
        verdict = judge(outcome, clock() - begin)
        note = outcome.note
    except Exception as met:  # whatever it is, it is the finding
        verdict, note = BROKEN, f"{type(met).__name__}: {met}"
        if _is_refusal(met):
            verdict, note = REFUSED, str(met)
    worst = ("", 0.0, 0.0)
    for key, (violation, allowed) in outcome.invariants.items():
        share = violation / allowed if allowed else (math.inf if violation else 0.0)
        known = worst[1] / worst[2] if worst[2] else (math.inf if worst[1] else -1.0)
        if not share <= known:
            worst = (key, violation, allowed)
    return StressCase(
        group=group,
        name=name,
        verdict=verdict,
        asked=outcome.asked,
        reached=outcome.reached,
        invariant=worst[0],
        violation=worst[1],
        allowed=worst[2],
        seconds=clock() - begin,
        note=" ".join(note.split())[:240],
    )


def _is_refusal(error: Exception) -> bool:
    """Whether it is an answer to bad input, and not a ValueError from deep inside."""
    if isinstance(error, InputError):
        return True
    here = error.__traceback__
    while here is not None and here.tb_next is not None:
        here = here.tb_next
    where = here.tb_frame.f_globals.get("__name__", "") if here is not None else ""
    return isinstance(error, ValueError) and where.startswith("particles.")


Case = tuple[str, str, Callable[[], Outcome]]
"""Group, name and work of a case that has not been run."""


def named(group: str, name: str, work: Callable[..., Outcome], *arguments: Any) -> Case:
    """A case whose work takes these arguments."""
    return group, name, lambda: work(*arguments)
