"""What is to be noted whether or not data and theory differ: what data and theory show themselves.

Tracers at rest, tracers that are missing, a start that is not forgotten, and what is too rare to be
judged.
"""

from collections.abc import Iterator

import numpy as np

from kinetics.crosscheck.comparison.data_and_theory import LEAST_EXPECTED, DataAndTheory
from kinetics.crosscheck.comparison.fit import choose_components
from kinetics.crosscheck.comparison.result import Explanation, said
from kinetics.crosscheck.comparison.statistics import hotelling
from kinetics.crosscheck.comparison.theory import SPEED, bin_shares
from kinetics.crosscheck.verdicts import AGREES_BELOW, DIFFERS_ABOVE, chance

_FAR_SLOWER = 8.0
"""A trapped tracer is that many times slower than the upper end of the lowest bin: a wrong
restitution, density or start, which shift all speeds a little, cannot put a tracer there."""
_FEWEST_TRAPPED = 5


def notes_of(both: DataAndTheory) -> Iterator[Explanation]:
    """Everything that is to be noted."""
    for note in (_traps, _missing, _own_start, _not_forgotten, _tails, _few_samples):
        yield from note(both)


def _traps(both: DataAndTheory) -> Iterator[Explanation]:
    """Tracers at the last time that are far slower than the theory's slowest."""
    for found in [h for h in both.histograms if h.name == SPEED][-1:]:
        binned, density = both.sample.speeds, both.densities[SPEED]
        assert binned is not None
        edges = binned.edges[found.index]
        cut = int(np.searchsorted(edges, found.edges[1] / _FAR_SLOWER))
        at = int(np.argmin(np.abs(density.times - found.time)))
        count = int(binned.totals[found.index, : cut + 1].sum())
        expected = float(bin_shares(density, SPEED, at, edges)[: cut + 1].sum()) * found.samples
        excess = count - expected
        if count < _FEWEST_TRAPPED or excess < DIFFERS_ABOVE * np.sqrt(max(expected, count)):
            break
        share, error = excess / found.samples, float(np.sqrt(count)) / found.samples
        text = said(
            "traps", time=found.time, count=count, speed=edges[cut], expected=expected,
            share=share, error=error, rest=int(both.sample.at_rest[found.index]),
        )  # fmt: skip
        yield Explanation("traps", "found", text, True, share, error)
        return
    rest = int(both.sample.at_rest.max())
    if rest:
        share = rest / int(both.sample.samples.max())
        yield Explanation("traps", "found", said("zero_speeds", rest=rest), True, share)


def _missing(both: DataAndTheory) -> Iterator[Explanation]:
    """Fewer tracers at later times: what is left is biased, and the complete times tell."""
    samples = both.sample.samples
    most, least = int(samples.max()), int(np.argmin(samples))
    complete = samples == most
    if np.all(complete):
        return
    results = []
    for times in (complete, ~complete):
        chosen = choose_components(both.usable & times, both.sample.groups, 1)
        results.append(hotelling(both.difference.ravel()[chosen], both.flat_replicates[:, chosen]))
    whole, part = results
    off = None
    if "thermal_speed" in both.names:
        i = both.names.index("thermal_speed")
        if both.usable[i, least]:
            off = both.difference[i, least] / both.theory[i, least]
    missing = most - int(samples[least])
    text = said(
        "missing", capped=both.sample.capped, most=most, missing=missing,
        time=both.sample.times[least], whole=whole, part=part, off=off,
    )  # fmt: skip
    if part is None:
        yield Explanation("missing tracers", "noted", text, False)
        return
    outcome, agrees = "does not", chance(AGREES_BELOW)
    if part.p_value < agrees:
        outcome = "explains" if whole is None or whole.p_value >= agrees else "in part"
    yield Explanation(
        "missing tracers", outcome, text, True, value=missing / most,
        chi_square_before=part.value, chi_square_after=None if whole is None else whole.value,
        dof=None if whole is None else whole.freedom,
        p_value=None if whole is None else whole.p_value,
    )  # fmt: skip


def _own_start(both: DataAndTheory) -> Iterator[Explanation]:
    """A density that started from the data's own speeds cannot differ much from them early."""
    if both.own_start and both.histograms:
        yield Explanation("own start", "noted", said("own_start"), False)


def _not_forgotten(both: DataAndTheory) -> Iterator[Explanation]:
    """Whether the theory itself is still on its way to the scaling state."""
    from kinetics import ScalingSolution

    scene = both.solution.scene
    e, law = scene.restitution, both.sample.law
    if (e >= 1 and law.tangential_restitution >= 1) or "a2" not in both.names:
        return
    i = both.names.index("a2")
    exact, last = (
        ScalingSolution(e, law.tangential_restitution, law.dimension).a2,
        float(both.theory[i, -1]),
    )
    away = last - exact
    # Written so that a theory that is not finite is left out.
    if not abs(away) >= max(0.01 * (1 + exact), float(both.error[i, -1])):
        return
    text = said("not_forgotten", last=last, exact=exact)
    yield Explanation("start not forgotten", "noted", text, False, away)


def _tails(both: DataAndTheory) -> Iterator[Explanation]:
    """What is too rare to be judged."""
    for found in both.histograms[-1:]:
        edge, count = float(found.edges[-2]), found.share[-1] * found.samples
        text = said(
            "tails", least=LEAST_EXPECTED, time=found.time, edge=edge, count=count,
            unit="U" if found.name == SPEED else "d",
        )  # fmt: skip
        yield Explanation("tails", "noted", text, False, edge)


def _few_samples(both: DataAndTheory) -> Iterator[Explanation]:
    """Fourth moments that are hardly known at the last time."""
    for i, name in enumerate(both.names):
        if name not in ("a2", "kurtosis") or not both.usable[i, -1]:
            continue
        scale = 1 + both.theory[i, -1] if name == "a2" else both.theory[i, -1]
        relative = float(both.error[i, -1] / scale)
        if relative > 0.1:
            text = said("few_samples", name=name, relative=relative)
            yield Explanation("few samples", "noted", text, False, relative)
