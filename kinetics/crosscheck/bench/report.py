"""BenchReport: all rows of a benchmark, as JSON, as Markdown tables and as figures."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from kinetics.crosscheck.bench.record import Record
from kinetics.errors import InputError

FORMAT = "inelastic-lorentz bench 1"


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

    def as_dict(self) -> dict[str, Any]:
        """Plain values by name."""
        return {
            "format": FORMAT,
            "quick": self.quick,
            "cases": list(self.cases),
            "machine": self.machine,
            "seconds": self.seconds,
            "records": [r.as_dict() for r in self.records],
        }

    def to_json(self) -> str:
        """One strict JSON document."""
        from kinetics.crosscheck.plain import dumps

        return dumps(self.as_dict())

    @classmethod
    def from_json(cls, text: str) -> BenchReport:
        """Read back what `to_json` wrote; InputError for anything else."""
        try:
            found = json.loads(text)
            if found["format"] != FORMAT:
                raise KeyError(found["format"])
            return cls(
                records=tuple(Record(**row) for row in found["records"]),
                quick=bool(found["quick"]),
                cases=tuple(found["cases"]),
                machine=dict(found["machine"]),
                seconds=float(found["seconds"]),
            )
        except (json.JSONDecodeError, KeyError, TypeError, ValueError, AttributeError):
            raise InputError(
                f"compare: the file holds no benchmark of the format {FORMAT!r}"
            ) from None

    def markdown(self) -> str:
        """All tables."""
        from kinetics.crosscheck.bench.tables import lines

        return "\n".join(lines(self)) + "\n"

    def figures(self) -> dict[str, str]:
        """SVG files by name; those that have data."""
        from kinetics.crosscheck.bench.figures import draw_all

        return draw_all(list(self.records))
