"""A comparison as tables for the terminal, as figures, and as a page with its numbers as JSON."""

import textwrap
from collections.abc import Sequence

from kinetics.crosscheck.compare.result import OUTCOMES, Comparison, drawn
from kinetics.crosscheck.words import MEANING, Verdict, number, numeral


def test_cells(result: Comparison) -> list[list[str]]:
    """The chi-squares, a line each below the heads."""
    heads = ["chi-square", "t [d/U]", "value", "dof", "p", "sigmas", "better than", "verdict"]
    return [heads] + [
        [t.observable, "all" if t.time is None else numeral(t.time, ".4g"),
         numeral(t.chi_square, ".4g"), str(t.dof), numeral(t.p_value, ".2g"),
         numeral(t.sigmas, ".1f"), numeral(100 * t.within, ".2g") + " %" if t.within is not None
         and t.verdict is Verdict.AGREES else "", str(t.verdict)] for t in result.tests
    ]  # fmt: skip


def row_cells(result: Comparison, every: bool = True) -> list[list[str]]:
    """The rows, a line each below the heads; or those over time, and bins that do not agree."""
    heads = ["observable", "t [d/U]", "bin", "value ± s.e.", "theory", "sigmas", "verdict"]
    return [heads] + [
        [r.observable, numeral(r.time, ".4g"), "" if r.low is None else
         f"{numeral(r.low, '.4g')} to {'∞' if r.high is None else numeral(r.high, '.4g')}",
         number(r.value, r.error), number(r.theory),
         "" if r.sigmas is None else numeral(r.sigmas, "+.1f"), str(r.verdict)]
        for r in result.numbers if every or r.low is None or r.verdict != Verdict.AGREES
    ]  # fmt: skip


def scene_of(result: Comparison) -> dict[str, str]:
    """What was compared, by name."""
    made = f"from {result.groups} groups, by {result.grouping}"
    told = {n: f"{number(p.value, p.error)} ({p.source})" for n, p in result.parameters.items()}
    return told | {"start": result.initial, "errors": made}


def tables(result: Comparison) -> str:
    """The answer, parameters, tests, averages over time, odd bins, and explanations, as text."""

    def aligned(lines: Sequence[Sequence[str]]) -> str:
        wide = [max(map(len, column)) for column in zip(*lines, strict=True)]
        padded = ([cell.ljust(w) for cell, w in zip(line, wide, strict=True)] for line in lines)
        return "\n".join("  ".join(cells).rstrip() for cells in padded)

    def wrapped(text: str) -> str:
        return textwrap.fill(text, 100, subsequent_indent="  ", break_on_hyphens=False)

    shown = row_cells(result, every=False)
    hidden = len(result.numbers) + 1 - len(shown)
    left_out = f"\n({hidden} bins of densities that agree are left out; --json has them)"
    parts = [
        wrapped(result.summary), *(wrapped(f"note: {text}") for text in result.warnings),
        "\n".join(wrapped(f"{name}: {text}") for name, text in scene_of(result).items()),
        aligned(test_cells(result)), aligned(shown) + (left_out if hidden else ""),
        *(wrapped(f"{x.name} ({OUTCOMES[x.outcome]}): {x.text}") for x in result.explanations),
    ]  # fmt: skip
    return "\n\n".join(parts)


def render(result: Comparison, json_name: str) -> str:
    """The page, with nothing beside it. Every text of the comparison is escaped."""
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup

    loader, strict = PackageLoader("kinetics.crosscheck"), StrictUndefined
    made = Environment(
        loader=loader, autoescape=True, undefined=strict, trim_blocks=True, lstrip_blocks=True
    )
    svg = drawn(result, result.figures).decode() if result.figures else ""
    return made.get_template("comparison.html.j2").render(
        result=result, outcomes=OUTCOMES, scene=scene_of(result), tests=test_cells(result),
        meanings={v: MEANING[v] for v in (Verdict.AGREES, Verdict.UNCLEAR, Verdict.DIFFERS)},
        rows=row_cells(result), svg=Markup(svg[svg.find("<svg") :]), json_name=json_name,
    )  # fmt: skip
