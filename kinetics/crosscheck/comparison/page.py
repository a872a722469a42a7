"""A comparison as files: one page with nothing beside it, its numbers as JSON, its figures."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup

from kinetics.crosscheck.comparison.result import OUTCOMES, TITLES, Comparison
from kinetics.crosscheck.files import require_writable_folder
from kinetics.crosscheck.report.equations import comparison_equations
from kinetics.crosscheck.report.figures import figure_file, svg
from kinetics.crosscheck.report.page import environment, number
from kinetics.crosscheck.verdicts import MEANING, Verdict
from kinetics.errors import InputError

SHORT = {
    "thermal_speed": "v₀(t)",
    "a2": "a₂(t)",
    "msd": "⟨r²(t)⟩",
    "kurtosis": "kurtosis of r",
    "speed_density": "speed density",
    "position_density": "displacement density",
}
"""The name of each observable where space is short."""
UNITS = (
    "Lengths in d, the diameter of a scatterer and of the tracer; speeds in U, the standard "
    "deviation of one component of the initial velocity; times in d/U; densities in d⁻²."
)


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
            units=UNITS,
            json_name=json_name,
            svgs={name: Markup(svg(name, data)) for name, data in document["figures"].items()},
            equations=comparison_equations(),
            parameters=[_parameter(name, p) for name, p in document["parameters"].items()],
            tests=[_test(test) for test in document["tests"]],
            groups=_groups(document["rows"]),
            outcomes=OUTCOMES,
            verdicts={
                word.value: MEANING[word]
                for word in (Verdict.AGREES, Verdict.UNCLEAR, Verdict.DIFFERS)
            },
        )
    )


def _parameter(name: str, parameter: Mapping[str, Any]) -> dict[str, str]:
    words = {
        "restitution": "restitution e",
        "number_density": "number density ρ₀ / d⁻²",
        "mean_free_path": "mean free path l / d",
    }
    return {
        "name": words.get(name, name),
        "value": number(parameter["value"], parameter["error"]),
        "source": parameter["source"],
    }


def _test(test: Mapping[str, Any]) -> dict[str, str]:
    return {
        "observable": SHORT.get(test["observable"], test["observable"]),
        "at": "all times" if test["time"] is None else f"t = {test['time']:.4g}",
        "chi_square": f"{test['chi_square']:.4g}",
        "dof": str(test["dof"]),
        "p_value": f"{test['p_value']:.2g}",
        "sigmas": f"{test['sigmas']:.1f}",
        "verdict": test["verdict"],
    }


def _groups(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    return [
        {"title": title, "rows": shown}
        for name, title in TITLES.items()
        if (shown := [_row(row) for row in rows if row["observable"] == name])
    ]


def _row(row: Mapping[str, Any]) -> dict[str, str]:
    where = ""
    if row["low"] is not None:
        where = f"{row['low']:.4g} to " + ("∞" if row["high"] is None else f"{row['high']:.4g}")
    return {
        "time": f"{row['time']:.4g}",
        "bin": where,
        "value": number(row["value"], row["error"]),
        "theory": number(row["theory"]),
        "sigmas": "" if row["sigmas"] is None else f"{row['sigmas']:+.1f}",
        "corrected": ("" if row["corrected_sigmas"] is None else f"{row['corrected_sigmas']:.1f}"),
        "verdict": row["verdict"],
    }
