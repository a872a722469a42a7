"""The report: the three methods on one system, compared number by number, as a page and as JSON.

Begin with `systems.py` (what is compared), then follow the work: `runs.py` runs the solver and the
particles, `reduce.py` makes numbers of the runs, `rows.py` one table of all comparisons,
`figures.py` the pictures, `story.py` the findings in words, `page.py` the HTML page.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pandas import DataFrame

    from kinetics.crosscheck.report.figures import Drawn
    from kinetics.crosscheck.report.runs import Results
    from kinetics.crosscheck.report.story import Story
    from kinetics.crosscheck.report.systems import System

SCHEMA = "inelastic-lorentz/report/2"


@dataclass(frozen=True)
class Report:
    """What was run, compared and found; `document` is what the JSON file holds."""

    results: "Results"
    table: "DataFrame"
    story: "Story"
    figures: "list[Drawn]"
    checks: list[dict[str, Any]]

    @cached_property
    def document(self) -> dict[str, Any]:
        """Plain data: headline, claims, rows, verdict_counts, algebra, tables, figures, settings."""
        from kinetics import __version__
        from kinetics.crosscheck.files import plain
        from kinetics.crosscheck.report import page, rows
        from kinetics.crosscheck.words import MEANING

        story, system = self.story, self.results.system
        known = {name: version(name) for name in ("numpy", "scipy", "numba", "sympy", "matplotlib")}
        headline = {"compared": story.compared, "findings": story.findings, "line": story.line}
        found: dict[str, Any] = plain({
            "schema": SCHEMA,
            "software": {"inelastic-lorentz": __version__} | known,
            "title": page.title(system),
            "headline": {k: page.with_numbers(v) for k, v in headline.items()},
            "claims": story.claims,
            "notes": story.notes,
            "symbols": page.symbols(system),
            "units": page.units(system),
            "settings": system.described(),
            "verdicts": {word.value: text for word, text in MEANING.items()},
            "verdict_counts": rows.counts(self.table),
            "rows": rows.records(self.table),
            "algebra": self.checks,
            "tables": story.tables,
            "figures": [
                {"name": x.name, "title": x.title, "caption": x.caption} for x in self.figures
            ],
        })  # fmt: skip
        return found

    def text(self) -> str:
        """What the terminal shows: a line for each comparison, with its deviations in per cent."""
        from kinetics.crosscheck.report import page

        return page.text(self.document)

    def files(self, formats: Sequence[str] = ()) -> dict[str, str | bytes]:
        """Contents by name: the page, its JSON, its tables as CSV, and figures in the formats."""
        from kinetics.crosscheck.files import dumps
        from kinetics.crosscheck.report import page, story

        import pandas as pd

        name = self.results.system.name
        tables = {key: pd.DataFrame(rows) for key, rows in self.story.tables.items()}
        tables |= {"rows": self.table, "points": story.points(self.results)}
        found: dict[str, str | bytes] = {
            f"{name}.json": dumps(self.document),
            f"{name}.html": page.render(self.document, self.figures, story.chance(self.table)),
        }
        found |= {f"{name}-{key}.csv": table.to_csv(index=False) for key, table in tables.items()}
        return found | {
            f"{name}-{drawn.name}.{kind}": drawn.file(kind)
            for kind in dict.fromkeys(formats) for drawn in self.figures
        }  # fmt: skip

    def write(self, folder: Path, formats: Sequence[str] = ()) -> list[Path]:
        """Write all files into the folder, or none of them; returns their paths."""
        from kinetics.crosscheck.files import write_together

        return write_together(folder, self.files(formats))


def make_report(system: "System", progress: Callable[[str], None] | None = None) -> Report:
    """Run the three methods on a system (see `systems`), and compare them.

    progress is called with the name of each stage, `system.stages` times. ValueError for what
    cannot be simulated; RuntimeError if the derivations fail.
    """
    from kinetics.crosscheck.report import figures, page, rows, runs, story

    tell = progress or (lambda stage: None)
    with page.algebra(system) as waiting:
        results = runs.gather(system, tell)
        tell("comparing")
        table = rows.comparisons(results)
        drawn = figures.figures(results)
        checks = waiting()
    return Report(results, table, story.tell(results, table, checks), drawn, checks)


__all__ = ["Report", "make_report"]
