"""compare(): a sample against a solution, as rows, tests and one verdict."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from kinetics.crosscheck.comparison.data_and_theory import (
    DataAndTheory,
    Histogram,
    side_by_side,
)
from kinetics.crosscheck.comparison.fit import Fit
from kinetics.crosscheck.comparison.result import (
    OUTCOMES,
    Comparison,
    ComparisonRow,
    ComparisonTest,
    Explanation,
    Parameter,
    said,
)
from kinetics.crosscheck.comparison.sample import Sample
from kinetics.crosscheck.comparison.statistics import (
    ChiSquare,
    effective_groups,
    hotelling,
    most_freedom,
    of_the_worst,
)
from kinetics.crosscheck.comparison.theory import SampledStart, system_of
from kinetics.crosscheck.comparison.units import wrong_speeds, wrong_unit
from kinetics.crosscheck.verdicts import (
    DIFFERS_ABOVE,
    Verdict,
    chance,
    corrected_sigmas,
    gaussian_sigmas,
    judge_sigmas,
)
from kinetics.errors import InputError, short

if TYPE_CHECKING:
    from kinetics import Scene, Solution
    from particles import Ensemble

_SAME = 1e-6
"""Relative difference up to which data without spread agree with the theory: ten times the
tolerance that the solver is given."""


def compare(
    solution: "Solution",
    ensemble: "Ensemble | Sample",
    explain: bool = True,
    densities: "Mapping[str, Solution] | None" = None,
    found: Fit | None = None,
) -> Comparison:
    """Compare particles with a solution of the kinetic equation.

    Parameters
    ----------
    solution : of the scene that the particles claim to be; what it was asked for of thermal_speed,
        a2, msd, kurtosis, speed_density, position_density is compared, at the times that both have
    ensemble : a particle run, or a Sample (data.read.read_sample), in the scene's units
    explain : test what may explain a difference, and prepare figures; False is quicker
    densities : solutions of the same scene for "speed_density" and "position_density", at some of
        the times; without them `solution` is asked
    found : the fit that the scene's numbers come from, if they were fitted to these data

    Returns
    -------
    Comparison : frozen; rows, chi-squares with p-values, verdicts, explanations, and figures' data

    Raises
    ------
    InputError (a ValueError) : no time or no observable in common, or fewer than two groups
    """
    if isinstance(ensemble, Sample):
        sample = ensemble
    else:
        from kinetics.crosscheck.comparison.data.ensemble_files import from_ensemble

        sample = from_ensemble(ensemble)
    law = system_of(solution).law
    for name in ("dimension", "field"):
        ours, theirs = getattr(law, name), getattr(sample.law, name)
        if not math.isclose(ours, theirs, rel_tol=1e-9):
            raise InputError(f"solution: is of {name} {ours}, the data of {theirs}")
    both = side_by_side(solution, replace(sample, law=law), found, densities)
    return judged(both, explain, found)


def judged(both: DataAndTheory, explain: bool, found: Fit | None) -> Comparison:
    """The rows, tests, verdict and explanations of data and theory side by side."""
    sample, solution = both.sample, both.solution
    rows, tests = list(rows_of(both)), tests_of(both)
    verdict = overall(rows, tests)
    unit = wrong_unit(sample) or wrong_speeds(sample, solution.scene.initial)
    explanations: tuple[Explanation, ...] = ()
    figures: dict[str, Any] = {}
    if explain:
        explanations, figures = _explained(both, verdict, unit)
    return Comparison(
        verdict=verdict,
        summary=_summary(both, rows, tests, verdict, unit or _headlined(explanations)),
        rows=tuple(rows),
        tests=tuple(tests),
        explanations=explanations,
        parameters=_parameters(solution.scene, found, unit),
        initial=start_in_words(solution.scene.initial),
        samples=0 if sample.tabulated else int(sample.samples.max()),
        groups=0 if sample.tabulated else sample.groups,
        grouping=sample.grouping,
        warnings=sample.warnings,
        names=sample.names,
        figures=figures,
    )


def _parameters(
    scene: "Scene", found: Fit | None, unit: Explanation | None
) -> dict[str, Parameter]:
    """The numbers of the scene; those that were fitted have standard errors.

    A fit that leaves a difference, or that used a wrong unit, has found no value.
    """
    e, density, path = scene.restitution, scene.number_density, scene.mean_free_path
    errors = {} if found is None else dict(zip(found.names, found.errors.tolist(), strict=True))
    left = None if found is None else found.chi_square
    rejected = left is not None and left.p_value < chance(DIFFERS_ABOVE)

    def fitted(value: float, error: float, words: str) -> Parameter:
        if unit is not None or rejected:
            why = said("no_value", unit=unit is not None, left=left, used=value)
            return Parameter(None, None, why)
        return Parameter(value, error, words)

    words = "fitted to v₀ and ⟨r²⟩ over time"
    inverse = "1/(2dρ₀)" if scene.dimension == 2 else "1/(πd²ρ₀)"
    of_density = Parameter(density, None, "told"), Parameter(path, None, inverse)
    if (error := errors.get("log_path")) is not None:
        of_density = (
            fitted(density, error * density, f"{inverse.replace('ρ₀', 'l')}, l {words}"),
            fitted(path, error * path, words),
        )
    error = errors.get("restitution")
    return {
        "restitution": Parameter(e, None, "told") if error is None else fitted(e, error, words),
        "number_density": of_density[0],
        "mean_free_path": of_density[1],
    }


def _explained(
    both: DataAndTheory, verdict: Verdict, unit: Explanation | None
) -> tuple[tuple[Explanation, ...], dict[str, Any]]:
    """What explains a difference, the likeliest first; and the data of the figures.

    Where a unit is wrong, nothing else is claimed.
    """
    from kinetics.crosscheck.comparison.figures import figures_of
    from kinetics.crosscheck.comparison.hypotheses import tested_hypotheses
    from kinetics.crosscheck.comparison.notes import notes_of

    if unit is not None:
        return (unit,), figures_of(both)
    if both.sample.law.field:
        return (Explanation("field", "noted", said("in_field"), False),), figures_of(both)
    differs = verdict in (Verdict.DIFFERS, Verdict.UNCLEAR)
    tested = tested_hypotheses(both) if differs else []
    explanations = [one.explanation for one in tested] + list(notes_of(both))
    best = next((one for one in tested if one.explanation.outcome == "explains"), None)
    # Python's sort keeps the order of those of one outcome: the likeliest stays first.
    ordered = sorted(explanations, key=lambda item: list(OUTCOMES).index(item.outcome))
    return tuple(ordered), figures_of(both, None if best is None else best.theory)


def _headlined(explanations: Sequence[Explanation]) -> Explanation | None:
    """The explanation that the summary names: the likeliest, if it explains the difference."""
    best = explanations[0] if explanations else None
    return best if best is not None and best.outcome == "explains" and best.headline else None


def rows_of(both: DataAndTheory) -> Iterator[ComparisonRow]:
    """One row per observable and time, and per bin of a density."""
    sample = both.sample
    effective = effective_groups(both.replicates)
    for i, name in enumerate(both.names):
        looks = int(both.usable[i].sum())
        for k in np.flatnonzero(both.compared[i]).tolist():
            value, theory = float(both.expectation.values[i, k]), float(both.theory[i, k])
            sigmas, corrected, error = None, None, 0.0
            if both.usable[i, k]:
                error = float(both.error[i, k])
                sigmas = float(both.difference[i, k] / error)
                corrected = corrected_sigmas(sigmas, float(effective[i, k]), looks)
                verdict = judge_sigmas(corrected)
            elif sample.groups < 3 or (sample.law.field and sample.times[k] > 0):
                # One tracer is always like itself, and falls before its first collision as others.
                verdict = Verdict.UNDEFINED
            else:
                same = abs(value - theory) <= _SAME * max(abs(value), abs(theory), 1e-300)
                verdict = Verdict.AGREES if same else Verdict.DIFFERS
            yield ComparisonRow(
                name, float(sample.times[k]), value, error, theory, sigmas, verdict, corrected,
                0 if sample.tabulated else int(sample.samples[k]),
            )  # fmt: skip
    for name in both.densities:
        mine = [histogram for histogram in both.histograms if histogram.name == name]
        looks = sum(histogram.share.size for histogram in mine)
        for histogram in mine:
            yield from _bin_rows(histogram, looks)


def _bin_rows(found: Histogram, looks: int) -> Iterator[ComparisonRow]:
    for k in range(found.share.size):
        low, high = found.edges[k : k + 2].tolist()
        width = high - low if np.isfinite(high) else 1.0
        value, error, theory = (
            float(part[k] / width) for part in (found.share, found.error, found.theory)
        )
        sigmas = float((found.share[k] - found.theory[k]) / found.error[k])
        corrected = corrected_sigmas(sigmas, found.groups, looks)
        yield ComparisonRow(
            found.name, found.time, value, error, theory, sigmas, judge_sigmas(corrected),
            corrected, found.samples, low, high if np.isfinite(high) else None,
        )  # fmt: skip


def tests_of(both: DataAndTheory) -> list[ComparisonTest]:
    """One chi-square per average, over all its times, and per density and time."""
    found: list[tuple[str, float | None, ChiSquare | None]] = []
    for i, name in enumerate(both.names):
        found.append((name, None, _over_times(both, i)))
    found += [(h.name, h.time, h.chi_square) for h in both.histograms]
    known = [(name, time, c) for name, time, c in found if c is not None]
    tests = []
    for name, time, c in known:
        sigmas, verdict = judge_p_value(c.p_value, len(known))
        within = None
        if time is None:
            i = both.names.index(name)
            within, verdict = _within(both, i), _worst([verdict, _verdict_of_times(both, i)])
        tests.append(
            ComparisonTest(
                name, time, c.value, c.freedom, c.p_value, c.groups, sigmas, verdict, within
            )
        )
    return tests


def _over_times(both: DataAndTheory, i: int) -> ChiSquare | None:
    """The chi-square of one average.

    Where there are more times than the groups allow degrees of freedom, the differences in standard
    errors of neighbouring times are added up. Of a table of averages it is that of the time that
    differs most: how its errors are correlated is not known.
    """
    times = np.flatnonzero(both.usable[i])
    if not times.size:
        return None
    if both.sample.tabulated:
        return of_the_worst(both.difference[i, times] / both.error[i, times])
    most = most_freedom(both.sample.groups)
    difference = both.difference[i, times] / both.error[i, times]
    replicates = both.replicates[:, i, times] / both.error[i, times]
    if times.size > most:
        starts = np.arange(most) * times.size // most
        difference = np.add.reduceat(difference, starts)
        replicates = np.add.reduceat(replicates, starts, axis=1)
    return hotelling(difference, replicates)


def _verdict_of_times(both: DataAndTheory, i: int) -> Verdict:
    """The verdict on the time of an average that differs most, out of all times of all averages.

    Twice as many looks are allowed for: the chi-squares have looked at the same times.
    """
    looks = 2 * int(both.usable.sum())
    effective = effective_groups(both.replicates[:, i])
    return _worst(
        judge_sigmas(
            corrected_sigmas(
                float(both.difference[i, k] / both.error[i, k]), float(effective[k]), looks
            )
        )
        for k in np.flatnonzero(both.usable[i]).tolist()
    )


def _within(both: DataAndTheory, i: int) -> float:
    """The relative difference that the data exclude at every time, at 95 %: |d| + 2 sigma.

    Of 1 + a2 for a2, which may be zero, and in a field of the largest value of all times.
    """
    usable = both.usable[i]
    size = np.abs(both.theory[i] + (1.0 if both.names[i] == "a2" else 0.0))[usable]
    if both.sample.law.field:
        size = np.full(size.size, size.max())
    return float(np.max((np.abs(both.difference[i]) + 2 * both.error[i])[usable] / size))


def judge_p_value(p_value: float, trials: int) -> tuple[float, Verdict]:
    """Gaussian sigmas of a p-value, the least of so many, and the verdict on it."""
    sigmas = gaussian_sigmas(min(1.0, p_value * trials))
    return sigmas, judge_sigmas(sigmas)


def _worst(verdicts: Iterable[Verdict]) -> Verdict:
    words = set(verdicts)
    order = (Verdict.DIFFERS, Verdict.UNCLEAR, Verdict.AGREES)
    return next((verdict for verdict in order if verdict in words), Verdict.UNDEFINED)


def overall(rows: Sequence[ComparisonRow], tests: Sequence[ComparisonTest]) -> Verdict:
    """The worst verdict of the tests, and of rows without spread, which no test can hold."""
    words = [test.verdict for test in tests]
    return _worst(words + [row.verdict for row in rows if row.sigmas is None])


def _summary(
    both: DataAndTheory, rows: Sequence[ComparisonRow], tests: Sequence[ComparisonTest],
    verdict: Verdict, best: Explanation | None,
) -> str:  # fmt: skip
    odd = [test for test in tests if test.verdict is not Verdict.AGREES]
    odd_rows = [row for row in rows if row.sigmas is not None and row.verdict is not Verdict.AGREES]
    return said(
        "summary", tabulated=both.sample.tabulated, samples=int(both.sample.samples.max()),
        times=both.sample.times,
        scene=both.solution.scene, start=start_in_words(both.solution.scene.initial),
        verdict=verdict, tests=len(tests), odd=odd, best=best, shorts=SHORT,
        least=min(odd, key=lambda test: test.p_value, default=None),
        row=max(odd_rows, key=lambda row: abs(row.sigmas or 0.0), default=None),
        within=[(test.observable, test.within) for test in tests if test.within is not None],
    )  # fmt: skip


SHORT = {"thermal_speed": "v₀", "a2": "1 + a₂", "msd": "⟨r²⟩", "kurtosis": "⟨r⁴⟩/⟨r²⟩²"} | {
    "drift": "⟨v_x⟩", "mean_displacement": "⟨x⟩", "dispersion_parallel": "var x",
    "dispersion_perpendicular": "var y",
}  # fmt: skip
"""The averages as the summary names them."""


def start_in_words(initial: Any) -> str:
    """The start of a scene as the middle of a sentence."""
    if isinstance(initial, SampledStart):
        return "the data's own speeds at time 0"
    named = {
        "rest": "rest",
        "gaussian": "a Gaussian start",
        "monoenergetic": "a start with all speeds U",
    }
    if isinstance(initial, str) and initial in named:
        return named[initial]
    return f"the start {short(initial)}"
