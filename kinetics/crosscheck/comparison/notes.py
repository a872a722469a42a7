"""What explains a difference: tested hypotheses, and what data and theory show by themselves.

Tracers at rest, tracers that are missing, a start that is not forgotten and tails too thin to judge
are told whether or not there is a difference.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from kinetics.crosscheck.comparison.fit import choose_components
from kinetics.crosscheck.comparison.histograms import LEAST_EXPECTED
from kinetics.crosscheck.comparison.hypotheses import AGREES_ABOVE, tested_hypotheses
from kinetics.crosscheck.comparison.result import Explanation
from kinetics.crosscheck.comparison.statistics import hotelling
from kinetics.crosscheck.comparison.theory import SPEED, SampledStart, bin_shares
from kinetics.crosscheck.verdicts import DIFFERS_ABOVE, Verdict

if TYPE_CHECKING:
    from kinetics.crosscheck.comparison.differences import Judged

_FAR_SLOWER = 8.0
_FEWEST_TRAPPED = 5


def explanations_of(judged: "Judged", verdict: Verdict) -> Iterator[Explanation]:
    """Hypotheses, where there is a difference; and what is to be noted in any case."""
    if verdict in (Verdict.DIFFERS, Verdict.UNCLEAR):
        yield from tested_hypotheses(judged)
    yield from _traps(judged)
    yield from _missing(judged)
    yield from _own_start(judged)
    yield from _not_forgotten(judged)
    yield from _tails(judged)


def _traps(judged: "Judged") -> Iterator[Explanation]:
    """Tracers at the last time that are far slower than the theory's slowest.

    Far: eight times slower than the upper end of the lowest bin, so that another restitution,
    density or start, which shift all speeds a little, cannot put them there.
    """
    last = [h for h in judged.histograms if h[0] == SPEED][-1:]
    binned = judged.sample.speeds
    for _, k, found in last:
        assert binned is not None
        edges = binned.edges[k]
        cut = max(int(np.searchsorted(edges, found.edges[1] / _FAR_SLOWER)), 0)
        density = judged.densities[SPEED]
        at = int(np.argmin(np.abs(density.times - judged.sample.times[k])))
        shares = bin_shares(density, SPEED, at, edges)
        count, theory = int(binned.totals[k, : cut + 1].sum()), float(shares[: cut + 1].sum())
        expected = theory * found.samples
        share = (count - expected) / found.samples
        error = float(np.sqrt(max(count, 1.0))) / found.samples
        if count < _FEWEST_TRAPPED or (count - expected) < DIFFERS_ABOVE * np.sqrt(
            max(expected, count)
        ):
            break
        rest = int(judged.sample.at_rest[k])
        text = (
            f"Traps: at t = {judged.sample.times[k]:.4g}, {count} tracers are slower than "
            f"{edges[cut]:.3g} U, where {expected:.3g} are expected: an excess of {share:.2%} ± "
            f"{error:.2%} of all. {rest} of them have speed zero. Tracers caught in corners "
            "between scatterers, or stopped by a program, are such."
        )
        yield Explanation("traps", "found", text, True, share, error)
        return
    rest = int(judged.sample.at_rest.max())
    if rest:
        text = f"{rest} tracers have speed zero at some time, which only trapped ones have."
        yield Explanation("traps", "found", text, True, rest / int(judged.sample.samples.max()))


def _missing(judged: "Judged") -> Iterator[Explanation]:
    """Fewer tracers at later times: what is left is biased, and the complete times tell."""
    samples = judged.sample.samples
    most = int(samples.max())
    complete = samples == most
    capped = judged.sample.capped
    if np.all(complete):
        return
    least = int(np.argmin(samples))
    who = "" if capped is None else f" (they are stopped after {capped} collisions)"
    text = (
        f"Tracers are missing{who}: of {most}, {most - int(samples[least])} at "
        f"t = {judged.sample.times[least]:.4g}. A cap on collisions takes the fast ones away, and "
        "what is left is too slow."
    )
    difference = judged.difference.ravel()
    flat = judged.replicates.reshape(judged.sample.groups, -1)
    results = []
    for times in (complete, ~complete):
        usable = judged.usable & times
        components = choose_components(usable, judged.sample.groups, 1)
        results.append(
            hotelling(difference[components], flat[:, components]) if components.size else None
        )
    whole, part = results
    names = judged.expectation.names
    if part is None:
        yield Explanation("missing tracers", "noted", text, False)
        return
    outcome = "does not"
    if part.p_value < AGREES_ABOVE:
        outcome = "explains" if whole is None or whole.p_value >= AGREES_ABOVE else "in part"
    if whole is not None:
        text += (
            f" At the times that have all of them the averages have chi-square {whole.value:.4g} "
            f"with {whole.freedom} degrees of freedom (p = {whole.p_value:.2g}), at the others "
            f"{part.value:.4g} with {part.freedom} (p = {part.p_value:.2g})."
        )
    if "thermal_speed" in names:
        i = names.index("thermal_speed")
        if judged.usable[i, least]:
            off = judged.difference[i, least] / judged.theory[i, least]
            text += f" The thermal speed is {off:+.1%} from the theory there."
    yield Explanation(
        "missing tracers", outcome, text, True,
        value=float((most - samples[least]) / most),
        chi_square_before=part.value, chi_square_after=None if whole is None else whole.value,
        dof=None if whole is None else whole.freedom,
        p_value=None if whole is None else whole.p_value,
    )  # fmt: skip


def _own_start(judged: "Judged") -> Iterator[Explanation]:
    """A density that started from the data's own speeds cannot differ much from them early."""
    if isinstance(judged.solution.scene.state, SampledStart) and judged.histograms:
        text = (
            "The theory starts from the data's own speeds. The averages' errors allow for that; "
            "the densities' do not, and while most tracers have not collided their p-values are "
            "too high."
        )
        yield Explanation("own start", "noted", text, False)


def _not_forgotten(judged: "Judged") -> Iterator[Explanation]:
    """Whether the theory itself is still on its way to the scaling state."""
    from kinetics import ScalingSolution

    e = judged.solution.scene.restitution
    names = judged.expectation.names
    if e >= 1 or "a2" not in names or not np.isfinite(judged.theory[names.index("a2"), -1]):
        return
    i = names.index("a2")
    exact, last = ScalingSolution(e).a2, float(judged.theory[i, -1])
    away = last - exact
    if abs(away) < max(0.01 * (1 + exact), float(judged.error[i, -1])):
        return
    text = (
        f"The start is not forgotten: at the last time the kinetic equation itself has "
        f"a₂ = {last:.4f}, the scaling state {exact:.4f}. Such data differ from the scaling state "
        "(its h, a₂ and F(c)) without anything being wrong."
    )
    yield Explanation("start not forgotten", "noted", text, False, away)


def _tails(judged: "Judged") -> Iterator[Explanation]:
    """What is too rare to be judged."""
    if judged.histograms:
        name, k, found = judged.histograms[-1]
        unit = "U" if name == SPEED else "d"
        text = (
            f"Tails: a bin needs {LEAST_EXPECTED} expected samples to be judged. At t = "
            f"{judged.sample.times[k]:.4g} everything above {found.edges[-2]:.4g} {unit} is one "
            f"bin of {found.share[-1] * found.samples:.0f} samples; how the tail falls beyond that "
            "takes more of them."
        )
        yield Explanation("tails", "noted", text, False, float(found.edges[-2]))
    names = judged.expectation.names
    for name in ("a2", "kurtosis"):
        if name not in names:
            continue
        i = names.index(name)
        scale = 1 + judged.theory[i, -1] if name == "a2" else judged.theory[i, -1]
        relative = float(judged.error[i, -1] / scale)
        if judged.usable[i, -1] and relative > 0.1:
            text = (
                f"Too few samples for the fourth moment behind {name}: its standard error at the "
                f"last time is {relative:.0%}."
            )
            yield Explanation("few samples", "noted", text, False, relative)
