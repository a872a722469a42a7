"""A comparison as tables of plain text for the terminal."""

from kinetics.crosscheck.comparison.result import OUTCOMES, Comparison, Parameter
from kinetics.crosscheck.report.page import number
from kinetics.crosscheck.text import aligned


def tables(result: Comparison) -> str:
    """Parameters, tests, averages over time, densities that do not agree, and explanations."""
    parts = [result.summary]
    parts += [f"note: {warning}" for warning in result.warnings]
    parts.append(
        "\n".join(f"{name}: {parameter_text(p)}" for name, p in result.parameters.items())
        + f"\nstart: {result.initial}"
        + f"\nerrors: from {result.groups} groups, by {result.grouping}"
    )
    tests = [["chi-square", "t [d/U]", "value", "dof", "p", "verdict"]]
    for test in result.tests:
        at = "all" if test.time is None else f"{test.time:.4g}"
        tests.append(
            [test.observable, at, f"{test.chi_square:.4g}", str(test.dof), f"{test.p_value:.2g}",
             test.verdict]
        )  # fmt: skip
    parts.append(aligned(tests))
    rows = [["observable", "t [d/U]", "bin", "value ± s.e.", "theory", "sigmas", "verdict"]]
    hidden = 0
    for row in result.rows:
        if row.low is not None and row.verdict == "agrees":
            hidden += 1
            continue
        high = "" if row.high is None else f"{row.high:.3g}"
        rows.append(
            [row.observable, f"{row.time:.4g}",
             "" if row.low is None else f"{row.low:.3g} to {high}".rstrip(),
             number(row.value, row.error), number(row.theory),
             "" if row.sigmas is None else f"{row.sigmas:+.1f}", row.verdict]
        )  # fmt: skip
    text = aligned(rows)
    if hidden:
        text += f"\n({hidden} bins of densities that agree are left out; --json has them)"
    parts.append(text)
    parts += [
        f"{item.name} ({OUTCOMES[item.outcome]}): {item.text}" for item in result.explanations
    ]
    return "\n\n".join(parts)


def parameter_text(parameter: Parameter) -> str:
    """A parameter with its error and where it comes from."""
    return f"{number(parameter.value, parameter.error)} ({parameter.source})"
