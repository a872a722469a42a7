"""compare(): a sample against a solution, row by row and test by test."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.comparison.fit import Fit
from kinetics.crosscheck.comparison.histograms import HistogramResult, compare_histogram
from kinetics.crosscheck.comparison.reduction import SAME_TIME
from kinetics.crosscheck.comparison.result import (
    OUTCOMES,
    Comparison,
    ComparisonRow,
    ComparisonTest,
    Explanation,
    Parameter,
    judge_p_value,
)
from kinetics.crosscheck.comparison.sample import Sample, from_ensemble
from kinetics.crosscheck.comparison.statistics import (
    ChiSquare,
    effective_groups,
    errors,
    hotelling,
    most_freedom,
    spread_out,
)
from kinetics.crosscheck.comparison.theory import (
    DISPLACEMENT,
    MOMENTS,
    SPEED,
    Expectation,
    SampledStart,
)
from kinetics.crosscheck.verdicts import Verdict, corrected_sigmas, judge_sigmas
from kinetics.errors import InputError, short

if TYPE_CHECKING:
    from kinetics import Solution
    from particles import Ensemble

Array = NDArray[np.float64]

HISTOGRAM_TIMES = 6
"""Times at which densities are compared, at most."""
_NO_SPREAD = 1e-9
"""Standard error over value below which the data have no spread: a start with one speed."""


@dataclass(frozen=True, eq=False)
class Judged:
    """The numbers behind a comparison: what the figures draw and the explanations refit.

    difference, error, usable (n_names, n_times); replicates (G, n_names, n_times) of the
    difference; solution_index (n_times,): the solution's index of each of the sample's times.
    """

    sample: Sample
    solution: "Solution"
    expectation: Expectation
    theory: Array
    difference: Array
    replicates: Array
    error: Array
    usable: NDArray[np.bool_]
    solution_index: NDArray[np.int64]
    histograms: list[tuple[str, int, HistogramResult]]
    rows: tuple[ComparisonRow, ...]
    tests: tuple[ComparisonTest, ...]


def compare(
    solution: "Solution",
    ensemble: "Ensemble | Sample",
    explain: bool = True,
    parameters: dict[str, Parameter] | None = None,
    found: Fit | None = None,
) -> Comparison:
    """Hold particles against a solution of the kinetic equation.

    Parameters
    ----------
    solution : of the scene that the particles claim to be; what it was asked for of thermal_speed,
        a2, msd, kurtosis, speed_density, position_density is compared, at the times that both have
    ensemble : a particle run, or a Sample (comparison.data.read_sample)
    explain : test what may explain a difference, where there is one
    parameters, found : where the scene's numbers come from, if they were fitted to these data

    Returns
    -------
    Comparison : frozen; rows, chi-squares with p-values, verdicts, explanations, and figures' data

    Raises
    ------
    InputError (a ValueError) : no time or no observable in common, or fewer than two groups
    """
    from kinetics.crosscheck.comparison.draw import figures_of
    from kinetics.crosscheck.comparison.explain import explanations

    sample = ensemble if isinstance(ensemble, Sample) else from_ensemble(ensemble)
    judged = judge(solution, sample, found)
    verdict = _overall(judged)
    scene = solution.scene
    told = {
        "restitution": Parameter(scene.restitution, None, "told"),
        "number_density": Parameter(scene.number_density, None, "told"),
        "mean_free_path": Parameter(scene.mean_free_path, None, "1/(2dρ₀)"),
    }
    return Comparison(
        verdict=verdict,
        summary=_summary(judged, verdict),
        rows=judged.rows,
        tests=judged.tests,
        explanations=_ordered(explanations(judged, verdict)) if explain else (),
        parameters=told | (parameters or {}),
        initial=start_in_words(scene.initial),
        samples=int(sample.samples.max()),
        groups=sample.groups,
        grouping=sample.grouping,
        warnings=sample.warnings,
        names=sample.names,
        figures=figures_of(judged) if explain else {},
    )


def _ordered(items: Iterable[Explanation]) -> tuple[Explanation, ...]:
    return tuple(sorted(items, key=lambda item: list(OUTCOMES).index(item.outcome)))


def judge(solution: "Solution", sample: Sample, found: Fit | None = None) -> Judged:
    """Rows and tests; see `compare`."""
    if sample.groups < 2:
        raise InputError("ensemble: has fewer than two groups; there are no standard errors")
    matches = [_match(t, np.asarray(solution.times)) for t in sample.times]
    keep = np.array([k for k, m in enumerate(matches) if m is not None], np.int64)
    if keep.size == 0:
        raise InputError(
            f"solution: its times {short(solution.times.tolist())} have none in common with the "
            f"data's {short(sample.times.tolist())}"
        )
    index = np.array([m for m in matches if m is not None], np.int64)
    sample = sample.at(keep)
    outputs = solution.scene.outputs
    names = [name for name in MOMENTS if name in outputs]
    kinds = [
        name
        for name, binned in ((SPEED, sample.speeds), (DISPLACEMENT, sample.displacements))
        if name in outputs and binned is not None
    ]
    if not names and not kinds:
        raise InputError(
            f"solution: was asked for {', '.join(outputs)}; needed is at least one of "
            f"{', '.join((*MOMENTS, SPEED, DISPLACEMENT))}"
        )
    names = names or ["thermal_speed"]
    expectation = Expectation(sample, names)
    theory, moved = _theory(solution, expectation, index)
    difference = expectation.values - theory
    replicates = expectation.replicates - moved
    if found is not None:
        shift = found.moved(replicates.reshape(sample.groups, -1))
        slopes = _slopes(solution, expectation, found)
        replicates = replicates - np.tensordot(shift, slopes, axes=(1, 0))
    error = errors(replicates.reshape(sample.groups, -1)).reshape(difference.shape)
    with np.errstate(invalid="ignore"):
        size = np.maximum(np.abs(expectation.values), np.abs(theory))
        usable = np.isfinite(difference) & (error > _NO_SPREAD * size) & np.isfinite(error)
    histograms = [
        (name, k, result)
        for name in kinds
        for k in _histogram_times(sample)
        if (result := compare_histogram(sample, solution, name, k, int(index[k]))) is not None
    ]
    return Judged(
        sample, solution, expectation, theory, difference, replicates, error, usable, index,
        histograms,
        tuple(
            _rows(
                sample, expectation, theory, difference, error, usable, histograms,
                effective_groups(replicates.reshape(sample.groups, -1)).reshape(error.shape),
            )
        ),
        tuple(_tests(sample, names, difference, replicates, usable, histograms)),
    )  # fmt: skip


def _match(time: float, times: Array) -> int | None:
    k = int(np.argmin(np.abs(times - time)))
    return k if abs(times[k] - time) <= SAME_TIME * max(time, 1e-300) else None


def _theory(solution: "Solution", expectation: Expectation, index: Any) -> tuple[Array, Array]:
    scene = solution.scene
    if isinstance(scene.state, SampledStart) and expectation.sample.start is not None:
        return expectation.theory(scene.restitution, scene.mean_free_path, scene.state)
    values = np.stack(
        [
            np.asarray(getattr(solution, name))[index]
            if name in solution.scene.outputs
            else np.full(index.size, np.nan)
            for name in expectation.names
        ]
    )
    return values, values


def _slopes(solution: "Solution", expectation: Expectation, found: Fit) -> Array:
    """d(theory)/d(parameters) of every component, (k, n_names, n_times)."""
    from kinetics.crosscheck.comparison.find import theory_of

    scene = solution.scene
    out = []
    for k in range(len(found.names)):
        step = np.zeros(len(found.names))
        step[k] = 1e-4
        up, down = found.values + step, found.values - step
        if found.names[k] == "restitution":
            up[k], down[k] = min(up[k], 1.0), max(down[k], 0.0)
        ends = [
            theory_of(expectation, found.names, at, scene.restitution, scene.mean_free_path,
                      scene.initial)[0]
            for at in (up, down)
        ]  # fmt: skip
        out.append((ends[0] - ends[1]) / (up[k] - down[k]))
    return np.stack(out)


def _histogram_times(sample: Sample) -> list[int]:
    later = np.flatnonzero(sample.times > 0)
    return [int(later[k]) for k in spread_out(later.size, HISTOGRAM_TIMES)]


def _rows(
    sample: Sample, expectation: Expectation, theory: Array, difference: Array, error: Array,
    usable: Any, histograms: Sequence[tuple[str, int, HistogramResult]], effective: Array,
) -> list[ComparisonRow]:  # fmt: skip
    rows = []
    samples = sample.samples
    for i, name in enumerate(expectation.names):
        if not np.any(np.isfinite(theory[i])):
            continue
        looks = int(usable[i].sum())
        for k, time in enumerate(sample.times):
            value, expected = float(expectation.values[i, k]), float(theory[i, k])
            if not (np.isfinite(value) and np.isfinite(expected)):
                continue
            row = ComparisonRow(
                name, float(time), value, float(error[i, k]), expected, None, Verdict.UNDEFINED,
                None, int(samples[k]),
            )  # fmt: skip
            if usable[i, k]:
                sigmas = float(difference[i, k] / error[i, k])
                row = _judged(row, sigmas, float(effective[i, k]), looks)
            else:  # no spread: a start with one speed, or not yet moved
                same = abs(difference[i, k]) <= 1e-6 * max(abs(value), abs(expected), 1e-300)
                row = replace(row, error=0.0, verdict=Verdict.AGREES if same else Verdict.DIFFERS)
            rows.append(row)
    for name in dict.fromkeys(h[0] for h in histograms):
        mine = [h for h in histograms if h[0] == name]
        looks = sum(h[2].share.size for h in mine)
        for _, k, found in mine:
            rows += _bin_rows(name, float(sample.times[k]), found, sample.groups, looks)
    return rows


def _judged(row: ComparisonRow, sigmas: float, groups: float, looks: int) -> ComparisonRow:
    corrected = corrected_sigmas(sigmas, groups, looks)
    return replace(row, sigmas=sigmas, corrected_sigmas=corrected, verdict=judge_sigmas(corrected))


def _bin_rows(
    name: str, time: float, found: HistogramResult, groups: int, looks: int
) -> list[ComparisonRow]:
    rows = []
    for k in range(found.share.size):
        low, high = float(found.edges[k]), float(found.edges[k + 1])
        width = high - low if np.isfinite(high) else 1.0
        row = ComparisonRow(
            name, time, float(found.share[k] / width), float(found.error[k] / width),
            float(found.theory[k] / width), None, Verdict.UNDEFINED, None, found.samples,
            low, high if np.isfinite(high) else None,
        )  # fmt: skip
        # An error from the few samples of an emptied bin would be too small: at least binomial.
        least = np.sqrt(found.theory[k] * (1 - found.theory[k]) / found.samples)
        sigmas = float((found.share[k] - found.theory[k]) / max(found.error[k], least))
        rows.append(_judged(row, sigmas, groups, looks))
    return rows


def _tests(
    sample: Sample, names: Sequence[str], difference: Array, replicates: Array, usable: Any,
    histograms: Sequence[tuple[str, int, HistogramResult]],
) -> list[ComparisonTest]:  # fmt: skip
    found: list[tuple[str, float | None, ChiSquare]] = []
    for i, name in enumerate(names):
        times = np.flatnonzero(usable[i])
        times = times[spread_out(times.size, most_freedom(sample.groups))]
        if times.size:
            result = hotelling(difference[i, times], replicates[:, i, times])
            if result is not None:
                found.append((name, None, result))
    for name, k, histogram in histograms:
        if histogram.chi_square is not None:
            found.append((name, float(sample.times[k]), histogram.chi_square))
    return [
        ComparisonTest(
            name, time, c.value, c.freedom, c.p_value, c.groups,
            *judge_p_value(c.p_value, len(found)),
        )
        for name, time, c in found
    ]  # fmt: skip


def _overall(judged: Judged) -> Verdict:
    spreadless = [row.verdict for row in judged.rows if row.sigmas is None]
    for verdict in (Verdict.DIFFERS, Verdict.UNCLEAR):
        if verdict in spreadless or any(test.verdict is verdict for test in judged.tests):
            return verdict
    return Verdict.AGREES if judged.tests else Verdict.UNDEFINED


def _summary(judged: Judged, verdict: Verdict) -> str:
    scene, sample = judged.solution.scene, judged.sample
    head = (
        f"{int(sample.samples.max())} tracers at {sample.times.size} times from "
        f"{sample.times[0]:.4g} to {sample.times[-1]:.4g} d/U, against the kinetic equation with "
        f"e = {scene.restitution:.6g} and ρ₀ = {scene.number_density:.6g} d⁻², from "
        f"{start_in_words(scene.initial)}: "
    )
    words = {
        Verdict.AGREES: "they agree.",
        Verdict.UNCLEAR: "a difference is possible, but more samples would have to show it.",
        Verdict.DIFFERS: "they differ.",
        Verdict.UNDEFINED: "nothing could be tested.",
    }
    odd = [test for test in judged.tests if test.verdict is not Verdict.AGREES]
    tail = ""
    if odd:
        least = min(odd, key=lambda test: test.p_value)
        at = "" if least.time is None else f" at t = {least.time:.4g}"
        tail = (
            f" Of {len(judged.tests)} tests {len(odd)} do not agree; the clearest is "
            f"{least.observable.replace('_', ' ')}{at}: chi-square {least.chi_square:.4g} with "
            f"{least.dof} degrees of freedom, p = {least.p_value:.2g}."
        )
    return head + words[verdict] + tail


def start_in_words(initial: Any) -> str:
    """The start of a scene as the middle of a sentence."""
    if isinstance(initial, SampledStart):
        return "the data's own speeds at time 0"
    if isinstance(initial, str):
        return {"gaussian": "a Gaussian start", "monoenergetic": "a start with all speeds U"}.get(
            initial, initial
        )
    return f"the start {short(initial)}"
