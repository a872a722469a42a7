"""The report: the three methods on one system, compared number by number, as a page and as JSON.

Begin with `systems.py` (what is compared), then follow the work: `runs.py` runs the methods,
`rows.py` makes one table of all comparisons, `figures.py` the pictures, `story.py` the findings in
words, `page.py` the HTML page.
"""

import textwrap
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

SCHEMA = "inelastic-lorentz/report/2"


@dataclass(frozen=True)
class Report:
    """What was run (`runs.Results`), compared (a pandas DataFrame), found, drawn and derived."""

    results: Any
    table: Any
    story: Any
    figures: list[Any]
    checks: list[dict[str, Any]]

    @cached_property
    def document(self) -> dict[str, Any]:
        """What the JSON file holds: headline, claims, rows, verdict_counts, algebra and more."""
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
            **page.head(system),
            "headline": {k: page.with_numbers(v) for k, v in headline.items()},
            "claims": story.claims,
            "settings": {n: x for n, x in vars(system).items() if n != "stages"},
            "verdicts": {word.value: text for word, text in MEANING.items()},
            "verdict_counts": rows.counts(self.table),
            "rows": rows.records(self.table),
            "algebra": self.checks,
            "tables": story.tables,
            "figures": [
                {key: vars(x)[key] for key in ("name", "title", "caption")} for x in self.figures
            ],
        })  # fmt: skip
        return found

    def text(self) -> str:
        """What the terminal shows: the findings, and how many rows have each verdict."""
        story = self.document["headline"]
        counted = (f"{n} {verdict}" for verdict, n in self.document["verdict_counts"].items())
        lines = (story["compared"], *story["findings"], ", ".join(counted))
        return "\n".join(textwrap.fill(line, 100) for line in lines)

    def write(self, folder: Path, formats: Sequence[str] = ()) -> list[Path]:
        """Write the page, its JSON, its tables and figures in these formats, or nothing; paths."""
        import pandas as pd

        from kinetics.crosscheck.files import dumps, write_together
        from kinetics.crosscheck.report import page, rows, story

        name = self.results.system.name
        tables = {key: pd.DataFrame(table) for key, table in self.story.tables.items()}
        tables |= {"rows": self.table, "points": rows.points(self.results)}
        html = page.render(self.document, self.figures, story.chance(self.table))
        found: dict[str, str | bytes] = {f"{name}.html": html, f"{name}.json": dumps(self.document)}
        found |= {f"{name}-{key}.csv": table.to_csv(index=False) for key, table in tables.items()}
        for kind in dict.fromkeys(formats):
            found |= {f"{name}-{drawn.name}.{kind}": drawn.file(kind) for drawn in self.figures}
        return write_together(folder, found)


def make_report(system: Any, progress: Callable[[str], None] | None = None) -> Report:
    """Run the three methods on a system (of `systems.py`), and compare them.

    progress is called with each stage. ValueError for what cannot be simulated.
    """
    from kinetics.crosscheck.report import figures, page, rows, runs, story

    tell = progress or (lambda stage: None)
    with ThreadPoolExecutor(1) as beside:
        deriving = beside.submit(page.algebra, system)
        results = runs.gather(system, tell)
        tell("comparing")
        table = rows.comparisons(results)
        drawn, checks = figures.figures(results), deriving.result()
    return Report(results, table, story.tell(results, table, checks), drawn, checks)


__all__ = ["Report", "make_report"]
