"""A comparison as files (one page with nothing beside it, its numbers as JSON, its figures), and as
tables for the terminal.
"""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup

from kinetics.crosscheck.comparison.result import OBSERVABLES, OUTCOMES, Comparison, said
from kinetics.crosscheck.files import require_file
from kinetics.crosscheck.report.equations import comparison_equations
from kinetics.crosscheck.report.figures import figure_files, svg
from kinetics.crosscheck.report.templates import environment, number, numeral
from kinetics.crosscheck.text_tables import aligned, wrapped
from kinetics.crosscheck.verdicts import EXPLAINED, WORDS
from kinetics.errors import InputError

Plain = Mapping[str, Any]

PARAMETERS = {
    "restitution": "restitution e",
    "number_density": "number density ρ₀ / d⁻²",
    "mean_free_path": "mean free path l / d",
}


def prepare(output: Path, data: Sequence[Path]) -> None:
    """InputError, before anything is read, for an output that cannot be written.

    Or that would take the place of the data.
    """
    for path, endings in ((output, (".html", ".htm")), (_json_path(output), (".json",))):
        require_file("output", path, endings)
        if any(path.resolve() == other.resolve() for other in data):
            raise InputError(f"output: {str(path)!r} is one of the data; they are never changed")


def files_of(
    result: Comparison, output: Path, formats: Sequence[str] = ()
) -> dict[str, str | bytes]:
    """File names and contents: the page, the JSON beside it, and figures in these formats."""
    files: dict[str, str | bytes] = {
        _json_path(output).name: result.to_json(),
        output.name: render(result, _json_path(output).name),
    }
    return files | figure_files(result.figures, output.stem, formats)


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
                cells_of_test(test)
                | {
                    "observable": OBSERVABLES[test["observable"]].short,
                    "at": "all times"
                    if test["time"] is None
                    else f"t = {numeral(test['time'], '.4g')}",
                }
                for test in document["tests"]
            ],
            groups=[
                {"title": observable.title, "rows": shown}
                for name, observable in OBSERVABLES.items()
                if (shown := [cells_of_row(r) for r in document["rows"] if r["observable"] == name])
            ],
            outcomes=OUTCOMES,
            cause=_cause(document),
            head=_head_figures(document),
            words=WORDS,
            classes=CLASSES,
            explained=EXPLAINED_OF_DATA,
        )
    )


CLASSES = {"no difference": "agrees", "unclear": "unclear", "differs": "differs"}
"""The class of the style sheet for each word."""
EXPLAINED_OF_DATA = {
    "no difference": "none was seen; behind “better than” stands the relative difference that "
    "these data would have shown at every time, at 95 %.",
    **{word: EXPLAINED[word] for word in ("unclear", "differs")},
}
"""What the three words say of data."""


def _cause(document: Plain) -> Plain | None:
    """The likeliest explanation, if one explains at least a part of a difference."""
    best = next(iter(document["explanations"]), None)
    if best is None or best["outcome"] not in ("explains", "found", "in part"):
        return None
    return dict(best)


def _head_figures(document: Plain) -> list[str]:
    """The figure of the average that fits least, over all times, and that of all differences."""
    averages = [t for t in document["tests"] if t["time"] is None]
    worst = max(averages, key=lambda test: test["sigmas"], default=None)
    names = [] if worst is None else [worst["observable"].replace("_", "-")]
    return [name for name in (*names, "sigmas") if name in document["figures"]]


def cells_of_test(test: Plain) -> dict[str, str]:
    """The cells of one chi-square, from the document of a comparison."""
    shown = test["within"] is not None and test["verdict"] == "agrees"
    return {
        "observable": test["observable"],
        "time": "all" if test["time"] is None else numeral(test["time"], ".4g"),
        "chi_square": numeral(test["chi_square"], ".4g"),
        "dof": str(test["dof"]),
        "p_value": numeral(test["p_value"], ".2g"),
        "sigmas": numeral(test["sigmas"], ".1f"),
        "within": f"{numeral(100 * test['within'], '.2g')} %" if shown else "",
        "verdict": test["verdict"],
        "word": WORDS[test["verdict"]],
    }


def cells_of_row(row: Plain) -> dict[str, str]:
    """The cells of one row, from the document of a comparison."""
    where = ""
    if row["low"] is not None:
        high = "∞" if row["high"] is None else numeral(row["high"], ".4g")
        where = f"{numeral(row['low'], '.4g')} to {high}"
    sigmas, corrected = row["sigmas"], row["corrected_sigmas"]
    return {
        "observable": row["observable"],
        "time": numeral(row["time"], ".4g"),
        "bin": where,
        "value": number(row["value"], row["error"]),
        "theory": number(row["theory"]),
        "sigmas": "" if sigmas is None else numeral(sigmas, "+.1f"),
        "corrected": "" if corrected is None else f"{corrected:.1f}",
        "verdict": row["verdict"],
        "word": WORDS[row["verdict"]],
    }


def parameter_text(parameter: Plain) -> str:
    """A parameter with its error and where it comes from."""
    return f"{number(parameter['value'], parameter['error'])} ({parameter['source']})"


def tables(result: Comparison) -> str:
    """The answer, parameters, tests, averages over time, odd bins, and explanations.

    Lines of `text_tables.WIDTH` columns at most.
    """
    document = result.document()
    parts = [wrapped(result.summary), *(wrapped(f"note: {text}") for text in result.warnings)]
    told = [wrapped(f"{name}: {parameter_text(p)}") for name, p in document["parameters"].items()]
    told.append(f"start: {result.initial}")
    made = f"from {result.groups} groups, by {result.grouping}" if result.groups else "as told"
    told.append(f"errors: {made}")
    parts.append("\n".join(told))
    names: tuple[str, ...] = (
        "observable", "time", "chi_square", "dof", "p_value", "within", "word",
    )  # fmt: skip
    heads: tuple[str, ...] = (
        "chi-square", "t [d/U]", "value", "dof", "p", "better than", "verdict",
    )  # fmt: skip
    parts.append(_table(names, heads, map(cells_of_test, document["tests"])))
    shown = [r for r in document["rows"] if r["low"] is None or r["verdict"] != "agrees"]
    names = ("observable", "time", "bin", "value", "theory", "sigmas", "word")
    heads = ("observable", "t [d/U]", "bin", "value ± s.e.", "theory", "sigmas", "verdict")
    text = _table(names, heads, map(cells_of_row, shown))
    if hidden := len(document["rows"]) - len(shown):
        text += f"\n({hidden} bins of densities that agree are left out; --json has them)"
    parts.append(text)
    parts += [
        wrapped(f"{item.name} ({OUTCOMES[item.outcome]}): {item.text}")
        for item in result.explanations
    ]
    return "\n\n".join(parts)


def _table(names: Sequence[str], heads: Sequence[str], lines: Iterable[Mapping[str, str]]) -> str:
    return aligned([heads, *([cells[name] for name in names] for cells in lines)])
