"""A comparison as cells of text, and as tables for the terminal."""

from collections.abc import Mapping
from typing import Any

from kinetics.crosscheck.comparison.result import OUTCOMES, Comparison
from kinetics.crosscheck.report.templates import number
from kinetics.crosscheck.text_tables import aligned

Plain = Mapping[str, Any]


def cells_of_test(test: Plain) -> dict[str, str]:
    """The cells of one chi-square, from the document of a comparison."""
    return {
        "observable": test["observable"],
        "at": "all times" if test["time"] is None else f"t = {test['time']:.4g}",
        "chi_square": f"{test['chi_square']:.4g}",
        "dof": str(test["dof"]),
        "p_value": f"{test['p_value']:.2g}",
        "sigmas": f"{test['sigmas']:.1f}",
        "verdict": test["verdict"],
    }


def cells_of_row(row: Plain) -> dict[str, str]:
    """The cells of one row, from the document of a comparison."""
    where = ""
    if row["low"] is not None:
        where = f"{row['low']:.4g} to " + ("∞" if row["high"] is None else f"{row['high']:.4g}")
    sigmas, corrected = row["sigmas"], row["corrected_sigmas"]
    return {
        "observable": row["observable"],
        "time": f"{row['time']:.4g}",
        "bin": where,
        "value": number(row["value"], row["error"]),
        "theory": number(row["theory"]),
        "sigmas": "" if sigmas is None else f"{sigmas:+.1f}",
        "corrected": "" if corrected is None else f"{corrected:.1f}",
        "verdict": row["verdict"],
    }


def parameter_text(parameter: Plain) -> str:
    """A parameter with its error and where it comes from."""
    return f"{number(parameter['value'], parameter['error'])} ({parameter['source']})"


def tables(result: Comparison) -> str:
    """Parameters, tests, averages over time, densities that do not agree, and explanations."""
    document = result.document()
    parts = [result.summary, *(f"note: {warning}" for warning in result.warnings)]
    told = [f"{name}: {parameter_text(p)}" for name, p in document["parameters"].items()]
    told.append(f"start: {result.initial}")
    told.append(f"errors: from {result.groups} groups, by {result.grouping}")
    parts.append("\n".join(told))
    heads = ["chi-square", "t [d/U]", "value", "dof", "p", "verdict"]
    cells = [cells_of_test(test) for test in document["tests"]]
    for cell in cells:
        cell["at"] = cell["at"].removeprefix("t = ").removesuffix(" times")
    wanted: tuple[str, ...] = ("observable", "at", "chi_square", "dof", "p_value", "verdict")
    parts.append(aligned([heads, *([cell[name] for name in wanted] for cell in cells)]))
    shown = [r for r in document["rows"] if r["low"] is None or r["verdict"] != "agrees"]
    heads = ["observable", "t [d/U]", "bin", "value ± s.e.", "theory", "sigmas", "verdict"]
    wanted = ("observable", "time", "bin", "value", "theory", "sigmas", "verdict")
    cells = [cells_of_row(row) for row in shown]
    text = aligned([heads, *([cell[name] for name in wanted] for cell in cells)])
    if hidden := len(document["rows"]) - len(shown):
        text += f"\n({hidden} bins of densities that agree are left out; --json has them)"
    parts.append(text)
    parts += [
        f"{item.name} ({OUTCOMES[item.outcome]}): {item.text}" for item in result.explanations
    ]
    return "\n\n".join(parts)
