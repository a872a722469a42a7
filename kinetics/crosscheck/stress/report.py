"""StressReport: every case with its verdict, as JSON and as Markdown tables."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from kinetics.crosscheck.stress.case import HOLDS, MISSED, VERDICTS, StressCase

FORMAT = "inelastic-lorentz stress 1"


@dataclass(frozen=True)
class StressReport:
    """All cases of a sweep.

    Attributes
    ----------
    cases : in the order in which they were run
    quick : whether it was the quick sweep
    seconds : that the whole of it took
    """

    cases: tuple[StressCase, ...]
    quick: bool
    seconds: float

    @property
    def rejected(self) -> tuple[StressCase, ...]:
        """Those that ended as they must not."""
        return tuple(c for c in self.cases if not c.accepted)

    def to_json(self) -> str:
        """One strict JSON document; what is not finite is null."""
        from kinetics.crosscheck.plain import dumps

        document: dict[str, Any] = {
            "format": FORMAT,
            "quick": self.quick,
            "seconds": self.seconds,
            "verdicts": VERDICTS,
            "cases": [asdict(c) for c in self.cases],
        }
        return dumps(document)

    def markdown(self) -> str:
        """A table of groups with the worst case of each, and every case that is not accepted."""
        return "\n".join(self._lines()) + "\n"

    def figures(self) -> dict[str, str]:
        """SVG files by name: error reached against error asked."""
        from kinetics.crosscheck.stress.figures import reached_against_asked

        return {"stress.svg": reached_against_asked(list(self.cases))}

    def _lines(self) -> Iterator[str]:
        count = len(self.cases)
        yield f"# Stability sweep{' (quick)' if self.quick else ''}"
        yield ""
        yield f"{count} cases in {self.seconds:.0f} s, {len(self.rejected)} not as they must end."
        yield ""
        verdicts = list(VERDICTS)
        yield "| group | cases | " + " | ".join(verdicts) + " | worst reached/asked | slowest |"
        yield "|---" * (len(verdicts) + 4) + "|"
        for group in dict.fromkeys(c.group for c in self.cases):
            here = [c for c in self.cases if c.group == group]
            counts = [sum(c.verdict == v for c in here) for v in verdicts]
            worst, slow = _worst(here), max(here, key=lambda c: c.seconds)
            yield (
                f"| {group} | {len(here)} | "
                + " | ".join(str(n or "") for n in counts)
                + f" | {worst} | {slow.seconds:.2f} s: {slow.name} |"
            )
        yield ""
        yield from (f"- {verdict}: {meaning}" for verdict, meaning in VERDICTS.items())
        yield ""
        if self.rejected:
            yield "| verdict | group | case | asked | reached | invariant | note |"
            yield "|---|---|---|---|---|---|---|"
        for case in self.rejected:
            broken = case.violation > case.allowed
            invariant = f"{case.invariant}: {case.violation:.1e} > {case.allowed:.1e}"
            yield (
                f"| {case.verdict} | {case.group} | {case.name} | {_number(case.asked)} "
                f"| {_number(case.reached)} | {invariant if broken else ''} | {case.note} |"
            )
        yield ""


def _number(value: float) -> str:
    if math.isnan(value):
        return "-"
    return f"{value:.1e}" if math.isfinite(value) else "not finite"


def _worst(cases: list[StressCase]) -> str:
    """Of the cases that claim what was asked, the one with the largest reached/asked."""
    claimed = [c for c in cases if c.verdict in (HOLDS, MISSED)]
    known = [c for c in claimed if math.isfinite(c.reached) and math.isfinite(c.asked)]
    if not known:
        return "no reference"
    worst = max(known, key=lambda c: c.reached / c.asked)
    return f"{worst.reached / worst.asked:.1e}: {worst.name}"
