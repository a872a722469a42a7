"""StressReport: every case with its verdict, as JSON and as Markdown tables."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass

from kinetics.crosscheck.stress.case import HOLDS, MISSED, VERDICTS, StressCase, share_of_allowed
from kinetics.crosscheck.text_tables import markdown

FORMAT = "inelastic-lorentz stress 2"
_GROUP_HEADS = ("group", "cases", *VERDICTS, "largest share of what is allowed", "slowest")
_CASE_HEADS = ("verdict", "group", "case", "asked", "reached", "invariant", "violation", "allowed",
               "note")  # fmt: skip


@dataclass(frozen=True)
class StressReport:
    """All cases of a sweep.

    Attributes
    ----------
    cases : in the order in which they were run
    quick : whether it was the quick sweep
    seconds : that the whole of it took
    processor_seconds : and of processor time, compilation of the kernels among it
    not_run : how many more an interruption left out
    """

    cases: tuple[StressCase, ...]
    quick: bool
    seconds: float
    processor_seconds: float
    not_run: int = 0

    @property
    def rejected(self) -> tuple[StressCase, ...]:
        """Those that ended as they must not."""
        return tuple(c for c in self.cases if not c.accepted)

    def to_json(self) -> str:
        """One strict JSON document; what is not finite is null."""
        from kinetics.crosscheck.strict_json import dumps

        return dumps({"format": FORMAT, "verdicts": VERDICTS, **asdict(self)})

    def files(self) -> dict[str, str]:
        """The contents of what ``lorentz stress -o`` writes, by name."""
        return {"stress.json": self.to_json(), "stress.md": self.markdown(every_case=True)}

    def markdown(self, every_case: bool = False) -> str:
        """A row for each group; then the cases that are not accepted, or every case."""
        groups = dict.fromkeys(c.group for c in self.cases)
        rows = [_group(name, [c for c in self.cases if c.group == name]) for name in groups]
        lines = [
            f"# Stability sweep{' (quick)' if self.quick else ''}",
            "",
            f"{len(self.cases)} cases in {self.seconds:.0f} s, {self.processor_seconds:.0f} s of "
            f"processor time; {len(self.rejected)} did not end as they must."
            f"{f' Interrupted: {self.not_run} more were not run.' if self.not_run else ''}",
            "",
            *markdown(_GROUP_HEADS, [*rows, [*_counts("all", self.cases), "", ""]]),
            *(f"- {verdict}: {meaning}" for verdict, meaning in VERDICTS.items()),
            "",
        ]
        for title, cases in (
            ("Cases that did not end as they must", self.rejected),
            ("Every case", self.cases if every_case else ()),
        ):
            if cases:
                lines += [f"## {title}", "", *markdown(_CASE_HEADS, map(_case, cases))]
        return "\n".join(lines) + "\n"


def _counts(name: str, cases: Sequence[StressCase]) -> list[str]:
    """How many cases there are, and how many got which verdict."""
    counts = (sum(c.verdict == verdict for c in cases) for verdict in VERDICTS)
    return [name, str(len(cases)), *(str(n or "") for n in counts)]


def _group(name: str, cases: Sequence[StressCase]) -> list[str]:
    """The row of a group: counts, the case nearest to a limit, and the slowest."""
    (share, what), worst = max(((_share(c), c.name) for c in cases), key=lambda found: found[0])
    slow = max(cases, key=lambda c: c.seconds)
    return [*_counts(name, cases), f"{share:.1e} of {what}: {worst}" if share else "0",
            f"{slow.seconds:.2f} s: {slow.name}"]  # fmt: skip


def _share(c: StressCase) -> tuple[float, str]:
    """How much of the error asked for, or of what an invariant allows, a case uses up; of which.

    The error counts where the status claims it and there is a reference.
    """
    share = (share_of_allowed(c.violation, c.allowed), c.invariant)
    known = c.verdict in (HOLDS, MISSED) and math.isfinite(c.reached) and math.isfinite(c.asked)
    return max(share, (c.reached / c.asked, "the error asked for")) if known else share


def _case(c: StressCase) -> list[str]:
    asked = _number(c.asked) if math.isfinite(c.asked) else ""
    bounds = [_number(c.violation), _number(c.allowed)] if c.invariant else ["", ""]
    return [c.verdict, c.group, c.name, asked, _number(c.reached), c.invariant, *bounds, c.note]


def _number(value: float) -> str:
    if math.isnan(value):
        return ""
    return f"{value:.1e}" if math.isfinite(value) else "not finite"
