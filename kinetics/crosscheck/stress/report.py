"""StressReport: every case with its verdict, as JSON and as Markdown tables."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from kinetics.crosscheck.stress.case import HOLDS, MISSED, VERDICTS, StressCase, share_of_allowed

FORMAT = "inelastic-lorentz stress 2"


@dataclass(frozen=True)
class StressReport:
    """All cases of a sweep.

    Attributes
    ----------
    cases : in the order in which they were run
    quick : whether it was the quick sweep
    seconds : that the whole of it took
    processor_seconds : and of processor time, compilation of the kernels among it
    """

    cases: tuple[StressCase, ...]
    quick: bool
    seconds: float
    processor_seconds: float

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
            "processor_seconds": self.processor_seconds,
            "verdicts": VERDICTS,
            "cases": [asdict(c) for c in self.cases],
        }
        return dumps(document)

    def markdown(self, every_case: bool = False) -> str:
        """Verdicts by group, the worst case of each, and what is not accepted, or every case."""
        return "\n".join(self._lines(every_case)) + "\n"

    def figures(self) -> dict[str, str]:
        """SVG files by name: error reached against error asked."""
        from kinetics.crosscheck.stress.figures import reached_against_asked

        return {"stress.svg": reached_against_asked(list(self.cases))}

    def _lines(self, every_case: bool) -> Iterator[str]:
        groups = {
            group: [c for c in self.cases if c.group == group]
            for group in dict.fromkeys(c.group for c in self.cases)
        }
        yield f"# Stability sweep{' (quick)' if self.quick else ''}"
        yield ""
        yield (
            f"{len(self.cases)} cases in {self.seconds:.0f} s, {self.processor_seconds:.0f} s of "
            f"processor time; {len(self.rejected)} not as they must end."
        )
        yield ""
        yield from _verdicts(groups)
        yield from (f"- {verdict}: {meaning}" for verdict, meaning in VERDICTS.items())
        yield ""
        yield from _worst(groups)
        if self.rejected:
            yield "## Not as they must end"
            yield ""
            yield from _rows(self.rejected)
        if every_case:
            for group, cases in groups.items():
                yield f"## {group[0].upper()}{group[1:]}"
                yield ""
                yield from _rows(cases)


def _verdicts(groups: dict[str, list[StressCase]]) -> Iterator[str]:
    """How many cases of each group got which verdict, and the sums."""
    yield "| group | cases | " + " | ".join(VERDICTS) + " |"
    yield "|---" + "|---:" * (len(VERDICTS) + 1) + "|"
    every = [c for cases in groups.values() for c in cases]
    for group, cases in {**groups, "all": every}.items():
        counts = [sum(c.verdict == v for c in cases) for v in VERDICTS]
        yield f"| {group} | {len(cases)} | " + " | ".join(str(n or "") for n in counts) + " |"
    yield ""


def _worst(groups: dict[str, list[StressCase]]) -> Iterator[str]:
    """The case of each group that is worst in error, in an invariant, and in time."""
    yield "| group | largest error reached/asked | invariant nearest to what it may | slowest |"
    yield "|---|---|---|---|"
    for group, cases in groups.items():
        slow = max(cases, key=lambda c: c.seconds)
        yield (
            f"| {group} | {_worst_error(cases)} | {_worst_invariant(cases)} "
            f"| {slow.seconds:.2f} s: {slow.name} |"
        )
    yield ""


def _rows(cases: list[StressCase] | tuple[StressCase, ...]) -> Iterator[str]:
    """One row for each case."""
    yield "| verdict | group | case | asked | reached | invariant | violation | allowed | note |"
    yield "|---|---|---|---:|---:|---|---:|---:|---|"
    for c in cases:
        bounds = (_number(c.violation), _number(c.allowed)) if c.invariant else ("", "")
        yield (
            f"| {c.verdict} | {c.group} | {c.name} | {_asked(c)} | {_number(c.reached)} "
            f"| {_cell(c.invariant)} | {bounds[0]} | {bounds[1]} | {_cell(c.note)} |"
        )
    yield ""


def _cell(text: str) -> str:
    """Text that cannot end the cell of a table."""
    return text.replace("|", "\\|")


def _asked(case: StressCase) -> str:
    return _number(case.asked) if math.isfinite(case.asked) else ""


def _number(value: float) -> str:
    if math.isnan(value):
        return ""
    return f"{value:.1e}" if math.isfinite(value) else "not finite"


def _worst_error(cases: list[StressCase]) -> str:
    """Of the cases that claim what was asked, the one with the largest reached/asked."""
    claimed = [c for c in cases if c.verdict in (HOLDS, MISSED)]
    known = [c for c in claimed if math.isfinite(c.reached) and math.isfinite(c.asked)]
    if not known:
        return "no reference"
    worst = max(known, key=lambda c: c.reached / c.asked)
    return f"{_number(worst.reached)}/{_number(worst.asked)}: {worst.name}"


def _worst_invariant(cases: list[StressCase]) -> str:
    """The case whose worst invariant uses up most of what it allows."""
    known = [c for c in cases if c.invariant]
    if not known:
        return ""
    worst = max(known, key=lambda c: share_of_allowed(c.violation, c.allowed))
    if worst.violation == 0.0:
        return "none violated"
    bounds = f"{_number(worst.violation)}/{_number(worst.allowed)}"
    return f"{_cell(worst.invariant)}, {bounds}: {worst.name}"
