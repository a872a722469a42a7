"""BenchReport: all rows of a benchmark, as JSON, as Markdown tables and as a figure."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from kinetics.crosscheck.bench.record import Record

FORMAT = "inelastic-lorentz bench 2"


@dataclass(frozen=True)
class BenchReport:
    """A whole benchmark.

    Attributes
    ----------
    records : all rows
    quick : whether it was the quick one
    cases : names of the cases that were run
    machine : processor and versions
    seconds : that the whole of it took, wall-clock
    """

    records: tuple[Record, ...]
    quick: bool
    cases: tuple[str, ...]
    machine: dict[str, Any]
    seconds: float

    def to_json(self) -> str:
        """One strict JSON document; what is not finite is null."""
        from kinetics.crosscheck.strict_json import dumps

        return dumps({"format": FORMAT, **asdict(self)})

    def markdown(self) -> str:
        """A heading, and all tables that have rows."""
        from kinetics.crosscheck.bench.tables import tables

        about = ", ".join(f"{k.replace('_', ' ')} {v}" for k, v in self.machine.items())
        lines = [
            f"# Benchmark{' (quick)' if self.quick else ''}",
            "",
            f"{about}. {self.seconds:.0f} s in all. Times are medians over repeats, which are made "
            "in turns: processor time of one thread where nothing else is said, so that others on "
            "the machine do not count.",
            "",
            *tables(self.records),
        ]
        return "\n".join(lines) + "\n"

    def files(self) -> dict[str, str]:
        """The contents of what ``lorentz bench -o`` writes, by name; a figure if it has data."""
        from kinetics.crosscheck.bench.figures import work_precision

        files = {"bench.json": self.to_json(), "bench.md": self.markdown()}
        figure = work_precision(self.records)
        return files | ({"work-precision.svg": figure} if figure else {})
