"""compare(): a sample against a solution."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from kinetics.crosscheck.comparison.data.ensemble_files import from_ensemble
from kinetics.crosscheck.comparison.differences import Judged, judge
from kinetics.crosscheck.comparison.fit import Fit
from kinetics.crosscheck.comparison.result import (
    OUTCOMES,
    Comparison,
    ComparisonTest,
    Parameter,
)
from kinetics.crosscheck.comparison.rows import overall, rows_of, tests_of
from kinetics.crosscheck.comparison.sample import Sample
from kinetics.crosscheck.comparison.theory import SampledStart
from kinetics.crosscheck.verdicts import Verdict
from kinetics.errors import short

if TYPE_CHECKING:
    from kinetics import Solution
    from particles import Ensemble


def compare(
    solution: "Solution",
    ensemble: "Ensemble | Sample",
    explain: bool = True,
    densities: "Mapping[str, Solution] | None" = None,
    parameters: dict[str, Parameter] | None = None,
    found: Fit | None = None,
) -> Comparison:
    """Hold particles against a solution of the kinetic equation.

    Parameters
    ----------
    solution : of the scene that the particles claim to be; what it was asked for of thermal_speed,
        a2, msd, kurtosis, speed_density, position_density is compared, at the times that both have
    ensemble : a particle run, or a Sample (comparison.data.read.read_sample), in the scene's units
    explain : test what may explain a difference, and prepare figures; False is quicker
    densities : solutions of the same scene for "speed_density" and "position_density", at some of
        the times; without them `solution` is asked
    parameters, found : where the scene's numbers come from, if they were fitted to these data

    Returns
    -------
    Comparison : frozen; rows, chi-squares with p-values, verdicts, explanations, and figures' data

    Raises
    ------
    InputError (a ValueError) : no time or no observable in common, or fewer than two groups
    """
    sample = ensemble if isinstance(ensemble, Sample) else from_ensemble(ensemble)
    judged = judge(solution, sample, found, densities)
    rows, tests = rows_of(judged), tests_of(judged)
    verdict = overall(rows, tests)
    explanations: list[Any] = []
    figures: dict[str, Any] = {}
    if explain:
        from kinetics.crosscheck.comparison.figures import figures_of
        from kinetics.crosscheck.comparison.notes import explanations_of

        order = list(OUTCOMES)
        explanations = sorted(
            explanations_of(judged, verdict),
            key=lambda item: (order.index(item.outcome), item.chi_square_after or 0.0),
        )
        figures = figures_of(judged)
    scene = solution.scene
    told = {
        "restitution": Parameter(scene.restitution, None, "told"),
        "number_density": Parameter(scene.number_density, None, "told"),
        "mean_free_path": Parameter(scene.mean_free_path, None, "1/(2dρ₀)"),
    }
    return Comparison(
        verdict=verdict,
        summary=_summary(judged, tests, verdict),
        rows=tuple(rows),
        tests=tuple(tests),
        explanations=tuple(explanations),
        parameters=told | (parameters or {}),
        initial=start_in_words(scene.initial),
        samples=int(sample.samples.max()),
        groups=sample.groups,
        grouping=sample.grouping,
        warnings=sample.warnings,
        names=sample.names,
        figures=figures,
    )


def _summary(judged: Judged, tests: Sequence[ComparisonTest], verdict: Verdict) -> str:
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
    odd = [test for test in tests if test.verdict is not Verdict.AGREES]
    tail = ""
    if odd:
        least = min(odd, key=lambda test: test.p_value)
        at = "" if least.time is None else f" at t = {least.time:.4g}"
        tail = (
            f" Of {len(tests)} tests {len(odd)} do not agree; the clearest is "
            f"{least.observable.replace('_', ' ')}{at}: chi-square {least.chi_square:.4g} with "
            f"{least.dof} degrees of freedom, p = {least.p_value:.2g}."
        )
    return head + words[verdict] + tail


def start_in_words(initial: Any) -> str:
    """The start of a scene as the middle of a sentence."""
    if isinstance(initial, SampledStart):
        return "the data's own speeds at time 0"
    named = {"gaussian": "a Gaussian start", "monoenergetic": "a start with all speeds U"}
    if isinstance(initial, str) and initial in named:
        return named[initial]
    return f"the start {short(initial)}"
