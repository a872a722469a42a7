"""What may explain a difference, tested: each hypothesis is fitted to the same averages.

A hypothesis that is right lowers the chi-square to what chance allows. One that only helps says by
how much; and what the data show by themselves (tracers at rest, tracers that are missing, tails
too thin to judge) is said whether or not it is needed.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.comparison.fit import Fit, choose_components, fit
from kinetics.crosscheck.comparison.result import Explanation
from kinetics.crosscheck.comparison.statistics import ChiSquare, hotelling
from kinetics.crosscheck.comparison.theory import SPEED, SampledStart, bin_shares, sampled_start
from kinetics.crosscheck.rows import contact_value
from kinetics.crosscheck.verdicts import AGREES_BELOW, DIFFERS_ABOVE, Verdict, chance

if TYPE_CHECKING:
    from kinetics.crosscheck.comparison.judged import Judged

Array = NDArray[np.float64]

AGREES_ABOVE = chance(AGREES_BELOW)
"""p-value from which on what a hypothesis leaves agrees."""
_FAR_SLOWER = 8.0
_LEAST_GAIN = 16.0  # of chi-square by one parameter: 4 sigma
_SPEED_AVERAGES = ("thermal_speed", "a2")


def explanations_of(judged: "Judged", verdict: Verdict) -> Iterator[Explanation]:
    """Hypotheses, where there is a difference; and what is to be noted in any case."""
    if verdict in (Verdict.DIFFERS, Verdict.UNCLEAR):
        case = _case(judged)
        if case is not None:
            yield from _free_path(case)
            yield from _recollisions(case)
            yield from _restitution(case)
            yield from _start(case)
            yield from _speed_unit(case)
            yield from _at_rest_fraction(case)
    yield from _traps(judged)
    yield from _missing(judged)
    yield from _not_forgotten(judged)
    yield from _tails(judged)


@dataclass(frozen=True, eq=False)
class _Case:
    """The averages that hypotheses are fitted to, and the chi-square that they start from."""

    judged: "Judged"
    components: NDArray[np.int64]
    before: ChiSquare

    @property
    def theory(self) -> "Callable[..., tuple[Array, Array]]":
        """Restitution, ln l and start to the flat theory and its replicates."""
        scene = self.judged.solution.scene

        def flat(
            e: float = scene.restitution,
            log_path: float = float(np.log(scene.mean_free_path)),
            start: Any = scene.initial,
        ) -> tuple[Array, Array]:
            values, moved = self.judged.expectation.theory(e, float(np.exp(log_path)), start)
            return values, moved

        return flat

    def fit(
        self, name: str, model: Any, start: list[float], low: float, high: float,
        components: Any = None,
    ) -> Fit | None:  # fmt: skip
        expectation = self.judged.expectation
        data = (
            expectation.values.ravel(),
            expectation.replicates.reshape(self.judged.sample.groups, -1),
        )
        chosen = self.components if components is None else components

        def flat(at: Array) -> tuple[Array, Array]:
            values, moved = model(float(at[0]))
            return values.ravel(), moved.reshape(*moved.shape[:-2], -1)

        return fit([name], flat, data, chosen, [[s] for s in start], [low], [high])

    def chosen(self, names: tuple[str, ...]) -> Any:
        """The components of these averages alone."""
        n_times = self.judged.sample.times.size
        wanted = [i for i, n in enumerate(self.judged.expectation.names) if n in names]
        return self.components[np.isin(self.components // n_times, wanted)]


def _case(judged: "Judged") -> _Case | None:
    # Not time 0: there a hypothesis on the start would leave nothing that could differ.
    usable = judged.usable & (judged.sample.times > 0)
    components = choose_components(usable, judged.sample.groups, 2)
    if components.size < 2:
        return None
    difference = judged.difference.ravel()[components]
    replicates = judged.replicates.reshape(judged.sample.groups, -1)[:, components]
    before = hotelling(difference, replicates)
    return None if before is None else _Case(judged, components, before)


def _outcome(before: ChiSquare, after: ChiSquare) -> str:
    if after.p_value >= AGREES_ABOVE:
        # Averages that agreed already need no explaining.
        return "explains" if before.p_value < AGREES_ABOVE else "does not"
    gained = before.value - after.value
    return "in part" if gained > max(_LEAST_GAIN, 0.1 * before.value) else "does not"


def _tested(
    name: str, text: str, before: ChiSquare, after: ChiSquare,
    value: float | None = None, error: float | None = None,
) -> Explanation:  # fmt: skip
    outcome = _outcome(before, after)
    left = (
        f" The averages' chi-square goes from {before.value:.4g} to {after.value:.4g} with "
        f"{after.freedom} degrees of freedom (p = {after.p_value:.2g})."
    )
    return Explanation(
        name, outcome, text + left, True, value, error, before.value, after.value, after.freedom,
        after.p_value,
    )  # fmt: skip


def _free_path(case: _Case) -> Iterator[Explanation]:
    scene = case.judged.solution.scene
    log_path = float(np.log(scene.mean_free_path))
    found = case.fit(
        "log_path", lambda at: case.theory(log_path=at), [log_path], log_path - 3, log_path + 3
    )
    if found is None or found.chi_square is None:
        return
    path = float(np.exp(found.values[0]))
    error = path * float(found.errors[0])
    ratio = path / scene.mean_free_path
    text = (
        f"Another mean free path: l = {path:.5g} ± {error:.2g} d fits best, {ratio - 1:+.1%} from "
        f"1/(2dρ₀) = {scene.mean_free_path:.5g} d, as a density of {1 / (2 * path):.5g} d⁻² would "
        "have."
    )
    fraction = np.pi * scene.number_density * scene.diameter**2 / 4
    if fraction < 0.5:
        disks = scene.mean_free_path / contact_value(scene.number_density, scene.diameter)
        text += (
            f" Hard disks that do not overlap have l = {disks:.5g} d at the density told "
            f"({disks / scene.mean_free_path - 1:+.1%}, Henderson's contact value)"
        )
        near = abs(path - disks) <= 3 * error and ratio < 1
        text += ": that is the finite density of the scatterers." if near else "."
    yield _tested("free path", text, case.before, found.chi_square, path, error)


def _recollisions(case: _Case) -> Iterator[Explanation]:
    """Whether <r^2> stays below the theory once the speeds' own free path is put in."""
    judged = case.judged
    names = judged.expectation.names
    components = case.chosen(_SPEED_AVERAGES)
    if "msd" not in names or components.size < 2 or judged.sample.free:
        return
    log_path = float(np.log(judged.solution.scene.mean_free_path))
    found = case.fit(
        "log_path", lambda at: case.theory(log_path=at), [log_path], log_path - 3, log_path + 3,
        components,
    )  # fmt: skip
    if found is None or found.chi_square is None:
        return
    k, last = names.index("msd"), judged.sample.times.size - 1
    theory, moved = case.theory(log_path=float(found.values[0]))
    ahead, _ = case.theory(log_path=float(found.values[0]) + 1e-4)
    slope = (ahead[k, last] - theory[k, last]) / 1e-4
    expectation = judged.expectation
    flat = expectation.replicates.reshape(judged.sample.groups, -1)
    shift = found.moved(flat)[:, 0]
    replicates = expectation.replicates[:, k, last] - moved[..., k, last] - shift * slope
    difference = np.array([expectation.values[k, last] - theory[k, last]])
    result = hotelling(difference, replicates[:, None])
    if result is None or result.p_value > chance(DIFFERS_ABOVE):
        return
    relative = float(difference[0] / theory[k, last])
    error = abs(relative) / np.sqrt(result.value)
    fits = "fits them" if found.chi_square.p_value >= AGREES_ABOVE else "fits them best"
    below = relative < 0
    text = (
        f"The speeds alone have l = {np.exp(found.values[0]):.5g} d ({fits}); with it ⟨r²⟩ at the "
        f"last time is {relative:+.1%} ± {error:.1%} from the kinetic equation. "
        + (
            "Tracers that come back to scatterers they have met spread less than the equation, "
            "which forgets them, says: recollisions of a finite density do that."
            if below
            else "Recollisions would make it smaller, not larger."
        )
    )
    yield Explanation(
        "recollisions", "found" if below else "does not", text, True, relative, float(error),
        p_value=result.p_value, chi_square_after=result.value, dof=1,
    )  # fmt: skip


def _restitution(case: _Case) -> Iterator[Explanation]:
    e = case.judged.solution.scene.restitution
    found = case.fit("restitution", lambda at: case.theory(e=at), [e], 0.0, 1.0)
    if found is None or found.chi_square is None:
        return
    value, error = float(found.values[0]), float(found.errors[0])
    text = f"Another restitution: e = {value:.5g} ± {error:.2g} fits best, instead of {e:.5g}."
    yield _tested("restitution", text, case.before, found.chi_square, value, error)


def _start(case: _Case) -> Iterator[Explanation]:
    """The data's own speeds at time 0, or the other named start."""
    judged = case.judged
    told = judged.solution.scene.initial
    starts: list[tuple[str, Any]] = []
    if judged.sample.start is not None and not isinstance(told, SampledStart):
        starts.append(("the data's own speeds at time 0", sampled_start(judged.sample)))
    elif judged.sample.start is None:
        starts += [
            (words, name)
            for name, words in (("gaussian", "a Gaussian"), ("monoenergetic", "all speeds U"))
            if name != told
        ]
    for words, start in starts:
        theory, moved = case.theory(start=start)
        expectation = judged.expectation
        difference = (expectation.values - theory).ravel()[case.components]
        replicates = (expectation.replicates - moved).reshape(judged.sample.groups, -1)
        after = hotelling(difference, replicates[:, case.components])
        if after is not None:
            yield _tested(
                "initial speeds", f"Another start: {words}, the rest as told.", case.before, after
            )


def _speed_unit(case: _Case) -> Iterator[Explanation]:
    """Speeds at the start of another size: v and t in another unit than U."""
    judged = case.judged
    scene, names = judged.solution.scene, judged.expectation.names
    if isinstance(scene.initial, SampledStart):
        return
    speeds = np.array([float(name == "thermal_speed") for name in names])[:, None]
    expectation = judged.expectation

    def model(log_unit: float) -> tuple[Array, Array]:
        unit = float(np.exp(log_unit))
        moved = replace(expectation.sample, times=expectation.sample.times * unit)
        at = type(expectation)(moved, names)
        values, _ = at.theory(scene.restitution, scene.mean_free_path, scene.initial)
        scaled = values * unit**speeds
        return scaled, scaled

    found = case.fit("log_unit", model, [0.0], -5.0, 5.0)
    if found is None or found.chi_square is None:
        return
    unit = float(np.exp(found.values[0]))
    error = unit * float(found.errors[0])
    text = (
        f"Speeds in another unit, or faster at the start: U = {unit:.5g} ± {error:.2g} in the "
        "data's unit fits best, instead of 1."
    )
    yield _tested("speed unit", text, case.before, found.chi_square, unit, error)


def _at_rest_fraction(case: _Case) -> Iterator[Explanation]:
    """A share f of tracers that do not move from the start: <v^2> and <r^2> times 1 - f."""
    names = case.judged.expectation.names
    powers = {"thermal_speed": 0.5, "msd": 1.0}

    def model(share: float) -> tuple[Array, Array]:
        left = 1 - share

        def thinned(values: Array) -> Array:
            out = values.copy()
            for k, name in enumerate(names):
                if name in powers:
                    out[..., k, :] *= left ** powers[name]
                elif name == "a2":
                    out[..., k, :] = (1 + out[..., k, :]) / left - 1
                else:
                    out[..., k, :] /= left
            return out

        values, moved = case.theory()
        return thinned(values), thinned(moved)

    found = case.fit("share", model, [0.0], -0.5, 0.9)
    if found is None or found.chi_square is None or found.values[0] <= 0:
        return
    share, error = float(found.values[0]), float(found.errors[0])
    text = f"A share of {share:.2%} ± {error:.2%} of the tracers that never moves fits best."
    yield _tested("tracers at rest", text, case.before, found.chi_square, share, error)


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
        if count < 5 or (count - expected) < DIFFERS_ABOVE * np.sqrt(max(expected, count)):
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
            f"Tails: a bin needs {50} expected samples to be judged. At t = "
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
