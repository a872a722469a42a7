"""Rows, tests and the verdict on everything."""

from dataclasses import replace

import numpy as np

from kinetics.crosscheck.comparison.differences import Judged
from kinetics.crosscheck.comparison.histograms import HistogramResult
from kinetics.crosscheck.comparison.result import (
    ComparisonRow,
    ComparisonTest,
    judge_p_value,
)
from kinetics.crosscheck.comparison.statistics import (
    ChiSquare,
    effective_groups,
    hotelling,
    most_freedom,
    spread_out,
)
from kinetics.crosscheck.verdicts import Verdict, corrected_sigmas, judge_sigmas

_SAME = 1e-6
"""Relative difference up to which data without spread agree with the theory."""


def rows_of(judged: Judged) -> list[ComparisonRow]:
    """One row per observable and time, and per bin of a density."""
    sample = judged.sample
    samples = sample.samples
    effective = effective_groups(judged.flat_replicates).reshape(judged.error.shape)
    rows = []
    for i, name in enumerate(judged.expectation.names):
        looks = int(judged.usable[i].sum())
        for k in np.flatnonzero(judged.compared[i]).tolist():
            value, theory = float(judged.expectation.values[i, k]), float(judged.theory[i, k])
            row = ComparisonRow(
                name, float(sample.times[k]), value, float(judged.error[i, k]), theory, None,
                Verdict.UNDEFINED, None, int(samples[k]),
            )  # fmt: skip
            if judged.usable[i, k]:
                sigmas = float(judged.difference[i, k] / judged.error[i, k])
                row = _judged(row, sigmas, float(effective[i, k]), looks)
            else:
                size = max(abs(value), abs(theory), 1e-300)
                same = abs(judged.difference[i, k]) <= _SAME * size
                verdict = Verdict.AGREES if same else Verdict.DIFFERS
                if sample.groups < 3:  # one tracer is always like itself
                    verdict = Verdict.UNDEFINED
                row = replace(row, error=0.0, verdict=verdict)
            rows.append(row)
    for name in dict.fromkeys(h[0] for h in judged.histograms):
        mine = [h for h in judged.histograms if h[0] == name]
        looks = sum(h[2].share.size for h in mine)
        for _, k, found in mine:
            rows += _bin_rows(name, float(sample.times[k]), found, looks)
    return rows


def _judged(row: ComparisonRow, sigmas: float, groups: float, looks: int) -> ComparisonRow:
    corrected = corrected_sigmas(sigmas, groups, looks)
    return replace(row, sigmas=sigmas, corrected_sigmas=corrected, verdict=judge_sigmas(corrected))


def _bin_rows(name: str, time: float, found: HistogramResult, looks: int) -> list[ComparisonRow]:
    rows = []
    for k in range(found.share.size):
        low, high = float(found.edges[k]), float(found.edges[k + 1])
        width = high - low if np.isfinite(high) else 1.0
        row = ComparisonRow(
            name, time, float(found.share[k] / width), float(found.error[k] / width),
            float(found.theory[k] / width), None, Verdict.UNDEFINED, None, found.samples,
            low, high if np.isfinite(high) else None,
        )  # fmt: skip
        sigmas = float((found.share[k] - found.theory[k]) / found.error[k])
        rows.append(_judged(row, sigmas, found.groups, looks))
    return rows


def tests_of(judged: Judged) -> list[ComparisonTest]:
    """One chi-square per average, over its times, and per density and time."""
    found: list[tuple[str, float | None, ChiSquare]] = []
    for i, name in enumerate(judged.expectation.names):
        times = np.flatnonzero(judged.usable[i])
        times = times[spread_out(times.size, most_freedom(judged.sample.groups))]
        if times.size:
            result = hotelling(judged.difference[i, times], judged.replicates[:, i, times])
            if result is not None:
                found.append((name, None, result))
    for name, k, histogram in judged.histograms:
        if histogram.chi_square is not None:
            found.append((name, float(judged.sample.times[k]), histogram.chi_square))
    return [
        ComparisonTest(
            name, time, c.value, c.freedom, c.p_value, c.groups,
            *judge_p_value(c.p_value, len(found)),
        )
        for name, time, c in found
    ]  # fmt: skip


def overall(rows: list[ComparisonRow], tests: list[ComparisonTest]) -> Verdict:
    """The worst verdict of the tests, and of rows without spread, which no test can hold."""
    words = [test.verdict for test in tests]
    words += [row.verdict for row in rows if row.sigmas is None]
    for verdict in (Verdict.DIFFERS, Verdict.UNCLEAR, Verdict.AGREES):
        if verdict in words:
            return verdict
    return Verdict.UNDEFINED
