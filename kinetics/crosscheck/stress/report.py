"""StressReport: every case with its verdict, as JSON and as Markdown tables."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass

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
        from kinetics.crosscheck.strict_json import dumps

        return dumps(
            {
                "format": FORMAT,
                "quick": self.quick,
                "seconds": self.seconds,
                "processor_seconds": self.processor_seconds,
                "verdicts": VERDICTS,
                "cases": [asdict(c) for c in self.cases],
            }
        )

    def markdown(self, every_case: bool = False) -> str:
        """A row for each group; then the cases that are not accepted, or every case."""
        lines = [
            f"# Stability sweep{' (quick)' if self.quick else ''}",
            "",
            f"{len(self.cases)} cases in {self.seconds:.0f} s, {self.processor_seconds:.0f} s of "
            f"processor time; {len(self.rejected)} did not end as they must.",
            "",
            *_groups(self.cases),
            *(f"- {verdict}: {meaning}" for verdict, meaning in VERDICTS.items()),
            "",
        ]
        for title, cases in (
            ("Cases that did not end as they must", self.rejected),
            ("Every case", self.cases if every_case else ()),
        ):
            if cases:
                lines += [f"## {title}", "", *_rows(cases)]
        return "\n".join(lines) + "\n"


def _groups(every: tuple[StressCase, ...]) -> Iterator[str]:
    """For each group: how many got which verdict, and the worst in error, invariant and time."""
    heads = ["group", "cases", *VERDICTS, "largest error reached/asked",
             "invariant nearest to its limit", "slowest"]  # fmt: skip
    yield "| " + " | ".join(heads) + " |"
    yield "|---" + "|---:" * (len(VERDICTS) + 1) + "|---" * 3 + "|"
    groups = {g: [c for c in every if c.group == g] for g in dict.fromkeys(c.group for c in every)}
    for group, cases in {**groups, "all": list(every)}.items():
        counts = [sum(c.verdict == v for c in cases) for v in VERDICTS]
        cells = [group, str(len(cases)), *(str(n or "") for n in counts)]
        if group in groups:
            slow = max(cases, key=lambda c: c.seconds)
            cells += [_worst_error(cases), _worst_invariant(cases),
                      f"{slow.seconds:.2f} s: {slow.name}"]  # fmt: skip
        else:
            cells += ["", "", ""]
        yield "| " + " | ".join(cells) + " |"
    yield ""


def _rows(cases: Iterable[StressCase]) -> Iterator[str]:
    """One row for each case."""
    yield "| verdict | group | case | asked | reached | invariant | violation | allowed | note |"
    yield "|---|---|---|---:|---:|---|---:|---:|---|"
    for c in cases:
        asked = _number(c.asked) if math.isfinite(c.asked) else ""
        bounds = (_number(c.violation), _number(c.allowed)) if c.invariant else ("", "")
        yield (
            f"| {c.verdict} | {c.group} | {c.name} | {asked} | {_number(c.reached)} "
            f"| {_cell(c.invariant)} | {bounds[0]} | {bounds[1]} | {_cell(c.note)} |"
        )
    yield ""


def _cell(text: str) -> str:
    """Text that cannot end the cell of a table."""
    return text.replace("|", "\\|")


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
