"""A comparison as files: one page with nothing beside it, its numbers as JSON, its figures."""

from collections.abc import Sequence
from pathlib import Path

from markupsafe import Markup

from kinetics.crosscheck.comparison.result import OBSERVABLES, OUTCOMES, Comparison, said
from kinetics.crosscheck.comparison.text import cells_of_row, cells_of_test, parameter_text
from kinetics.crosscheck.files import require_writable_folder
from kinetics.crosscheck.report.equations import comparison_equations
from kinetics.crosscheck.report.figures import figure_file, svg
from kinetics.crosscheck.report.templates import environment
from kinetics.crosscheck.verdicts import MEANING, Verdict
from kinetics.errors import InputError

PARAMETERS = {
    "restitution": "restitution e",
    "number_density": "number density ρ₀ / d⁻²",
    "mean_free_path": "mean free path l / d",
}


def prepare(output: Path, data: Sequence[Path]) -> None:
    """InputError, before anything is read, for an output that cannot be written.

    Or that would take the place of the data.
    """
    if output.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"output: got {str(output)!r}; it must be a file .html")
    for path in (output, _json_path(output)):
        if path.is_dir():
            raise InputError(f"output: {str(path)!r} is a folder; it must be a file .html")
        if any(path.resolve() == other.resolve() for other in data):
            raise InputError(f"output: {str(path)!r} is one of the data; they are never changed")
    require_writable_folder(output.parent)


def files_of(
    result: Comparison, output: Path, formats: Sequence[str] = ()
) -> dict[str, str | bytes]:
    """File names and contents: the page, the JSON beside it, and figures in these formats."""
    files: dict[str, str | bytes] = {
        _json_path(output).name: result.to_json(),
        output.name: render(result, _json_path(output).name),
    }
    for name, data in result.figures.items():
        for kind in dict.fromkeys(formats):
            files[f"{output.stem}-{name}.{kind}"] = figure_file(name, data, kind)
    return files


def _json_path(output: Path) -> Path:
    return output.with_suffix(".json")


def render(result: Comparison, json_name: str) -> str:
    """The page. Every text of the comparison is escaped."""
    document = result.document()
    return (
        environment()
        .get_template("comparison.html.j2")
        .render(
            doc=document,
            units=said("units"),
            json_name=json_name,
            svgs={name: Markup(svg(name, data)) for name, data in document["figures"].items()},
            equations=comparison_equations(),
            parameters={
                PARAMETERS[k]: parameter_text(p) for k, p in document["parameters"].items()
            },
            tests=[
                cells_of_test(test) | {"observable": OBSERVABLES[test["observable"]].short}
                for test in document["tests"]
            ],
            groups=[
                {"title": observable.title, "rows": shown}
                for name, observable in OBSERVABLES.items()
                if (shown := [cells_of_row(r) for r in document["rows"] if r["observable"] == name])
            ],
            outcomes=OUTCOMES,
            verdicts={
                word.value: MEANING[word]
                for word in (Verdict.AGREES, Verdict.UNCLEAR, Verdict.DIFFERS)
            },
        )
    )
