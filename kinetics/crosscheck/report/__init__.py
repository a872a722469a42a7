"""The report: the three methods on one system, compared number by number, as a page and as JSON.

Begin with `systems.py` (what is compared) and `cases.py` (what the methods give). `cooling.py` and
`driven.py` run the methods, `rows.py` makes one table of all comparisons, `figures.py` the
pictures, `story.py` the findings in words, `page.py` the HTML page.
"""

import textwrap
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kinetics.crosscheck.report.progress import Progress, say_nothing

if TYPE_CHECKING:
    from pandas import DataFrame

    from kinetics.crosscheck.report.algebra import AlgebraRow
    from kinetics.crosscheck.report.cases import Results
    from kinetics.crosscheck.report.figures import Drawn
    from kinetics.crosscheck.report.story import Story
    from kinetics.crosscheck.report.systems import System

SCHEMA = "inelastic-lorentz/report/2"
#: Packages whose versions a report names.
PACKAGES = ("numpy", "scipy", "numba", "sympy", "matplotlib")
#: Columns of a line of text in the terminal.
LINE_WIDTH = 100


@dataclass(frozen=True)
class Report:
    """What was run, compared, found, drawn and derived, and by which command, if by one."""

    results: "Results"
    table: "DataFrame"
    story: "Story"
    figures: "list[Drawn]"
    checks: "list[AlgebraRow]"
    command: str = ""

    @cached_property
    def document(self) -> dict[str, Any]:
        """What the JSON file holds: headline, claims, rows, verdict_counts, algebra and more."""
        from kinetics.crosscheck.files import plain
        from kinetics.crosscheck.report import algebra, page, rows
        from kinetics.crosscheck.words import MEANING

        system = self.results.system
        story = self.story
        document: dict[str, Any] = plain(
            {
                "schema": SCHEMA,
                "software": _versions(),
                **page.head(system),
                "headline": {
                    "compared": algebra.cite(story.compared),
                    "findings": [algebra.cite(finding) for finding in story.findings],
                    "line": algebra.cite(story.line),
                },
                "claims": story.claims,
                "errata": story.errata,
                "settings": system.settings,
                "command": self.command,
                "verdicts": {verdict.value: meaning for verdict, meaning in MEANING.items()},
                "verdict_counts": rows.verdict_counts(self.table),
                "rows": rows.records(self.table),
                "algebra": self.checks,
                "tables": story.tables,
                "figures": [drawn.words for drawn in self.figures],
            }
        )
        return document

    def text(self) -> str:
        """Return what the terminal shows: the findings, and how many rows have each verdict."""
        headline = self.document["headline"]
        counts = self.document["verdict_counts"]
        counted = ", ".join(f"{count} {verdict}" for verdict, count in counts.items())
        lines = [headline["compared"], *headline["findings"], counted]
        return "\n".join(textwrap.fill(line, LINE_WIDTH) for line in lines)

    def write(self, folder: Path, formats: Sequence[str] = ()) -> list[Path]:
        """Write the page, its JSON, its tables and figures in these formats, all or nothing.

        Returns the paths.
        """
        import pandas as pd

        from kinetics.crosscheck.files import dumps, write_together
        from kinetics.crosscheck.report import page, rows, story

        name = self.results.system.name
        html = page.render(self.document, self.figures, story.expected_by_chance(self.table))
        contents: dict[str, str | bytes] = {
            f"{name}.html": html,
            f"{name}.json": dumps(self.document),
        }
        tables: dict[str, pd.DataFrame] = {}
        for key, records in self.story.tables.items():
            tables[key] = pd.DataFrame(records)
        tables["rows"] = self.table
        tables["points"] = rows.points(self.results)
        for key, table in tables.items():
            contents[f"{name}-{key}.csv"] = table.to_csv(index=False)
        for kind in dict.fromkeys(formats):
            for drawn in self.figures:
                contents[f"{name}-{drawn.name}.{kind}"] = drawn.file(kind)
        return write_together(folder, contents)


def _versions() -> Mapping[str, str]:
    """Return the version of this package and of those that it rests on."""
    from kinetics import __version__

    versions = {"inelastic-lorentz": __version__}
    for package in PACKAGES:
        versions[package] = version(package)
    return versions


def make_report(system: "System", progress: Progress | None = None, command: str = "") -> Report:
    """Run the three methods on a system (of `systems.py`), and compare them.

    Parameters
    ----------
    system : a `Cooling` or `Driven` system
    progress : called with the name of each stage
    command : by which it is made, for the page

    Raises
    ------
    ValueError : for what cannot be simulated
    """
    from kinetics.crosscheck.report import algebra, figures, rows, story
    from kinetics.crosscheck.report.gather import gather

    tell = progress or say_nothing
    with ThreadPoolExecutor(1) as beside:
        deriving = beside.submit(algebra.derive, system)
        results = gather(system, tell)
        tell("comparing")
        table = rows.comparisons(results)
        drawn = figures.draw_all(results)
        checks = deriving.result()
    findings = story.tell_story(results, table, checks)
    return Report(results, table, findings, drawn, checks, command)


__all__ = ["Report", "make_report"]
