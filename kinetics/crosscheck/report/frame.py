"""What the documents of both reports have, and how their files are written."""

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from kinetics import __version__
from kinetics.crosscheck.files import write_together
from kinetics.crosscheck.report.figures import figure_files
from kinetics.crosscheck.report.row import Row, counts
from kinetics.crosscheck.report.templates import paragraphs
from kinetics.crosscheck.strict_json import dumps
from kinetics.crosscheck.verdicts import AGREES_BELOW, DIFFERS_ABOVE, MEANING, chance

Document = dict[str, Any]
_PACKAGES = ("numpy", "scipy", "numba", "sympy", "matplotlib")


def frame(rows: Sequence[Row]) -> Document:
    """Versions, what the verdicts mean, how many rows have each, and what chance does to them."""
    (many,) = paragraphs(
        "report.txt.j2",
        "multiple_comparisons",
        rows=sum(row.kind == "statistical" for row in rows),
        below=AGREES_BELOW,
        above=DIFFERS_ABOVE,
        chance_below=chance(AGREES_BELOW),
        chance_above=chance(DIFFERS_ABOVE),
    )
    known = {name: version(name) for name in _PACKAGES}
    return {
        "software": {"inelastic-lorentz": __version__} | known,
        "verdicts": {word.value: text for word, text in MEANING.items()},
        "verdict_counts": counts(rows),
        "multiple_comparisons": many,
    }


def write_files(
    document: Mapping[str, Any], name: str, page: str, folder: Path, formats: Sequence[str]
) -> list[Path]:
    """Write NAME.json and NAME.html into the folder, all or nothing; returns the paths.

    `formats` (of "svg", "pdf", "png") adds each figure as a file NAME-FIGURE.FORMAT.
    """
    files: dict[str, str | bytes] = {f"{name}.json": dumps(document), f"{name}.html": page}
    return write_together(folder, files | figure_files(document["figures"], name, formats))
