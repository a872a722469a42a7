"""What may explain a difference: each cause is a row of the table `CAUSES`, and one fit.

A cause says which number of the theory (`point.Point`) is other than what was specified, and fits
it; or it is another medium, another start, or an exchange of components. Each is tried in every
medium that the scatterers may be. It explains if what it leaves agrees and its value lies clearly
from what was specified; those that explain are ranked by `Fit.criterion`, and only those near the
best are said to. Begin with `tested_causes`.

d is the diameter of a scatterer and of the tracer, U the standard deviation of one component of the
initial velocity.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from kinetics.crosscheck.compare.fit import Fit, compare_with_point, fit
from kinetics.crosscheck.compare.measured import Measured
from kinetics.crosscheck.compare.media import media_of
from kinetics.crosscheck.compare.parameters import LIMITS, coordinates_of, free_parameter
from kinetics.crosscheck.compare.point import Point, SampledStart
from kinetics.crosscheck.compare.pool import N_FOR_CAUSE
from kinetics.crosscheck.compare.result import Explanation
from kinetics.crosscheck.compare.statistics import root_of_variance
from kinetics.crosscheck.data.sample import VX, X2, X
from kinetics.crosscheck.words import Verdict, limit_factor, number, numeral

#: Difference of `Fit.criterion` from the best up to which another explains as well. Derived:
#: 2 ln 20, odds of 20; with the same T^2 a fit may have three more numbers. Why 20 is not recorded.
NEAR_BEST = 6.0
#: A cause explains in part only if T^2 falls by this. Derived: 4 sigma of one number, squared.
MIN_GAIN = 16.0
#: A cause explains in part only if T^2 falls by this share of itself, too. Chosen: less is no
#: explanation of a large difference.
MIN_GAIN_SHARE = 0.1
#: How clearly a fitted value must differ from what was specified, which must lie outside the
#: interval that holds this share of the value's errors. Derived: that of a Gaussian within 3 sigma.
CLEARLY = 0.9973
#: Largest share of tracers at rest that explains anything: a fit that runs beyond, to its limit of
#: 0.9 (`parameters.LIMITS`), has failed. Chosen: below the limit, which a bounded fit may only come
#: near; why 0.05 below is not recorded.
MAX_AT_REST = 0.85
#: Restitutions from which a fit of e begins, beside the one specified. Chosen, as the other starts
#: are, to guard against local minima: none was met. In 108 fits of six data sets (e = 0.3 taken for
#: 0.9 and the reverse, five times the density, noise, half of the tracers at rest) each start alone
#: led to the same minimum.
STARTS_OF_RESTITUTION = (0.95, 0.8, 0.5)
#: Offsets of the clock from which a fit begins, over the first time above 0. Chosen: of both signs,
#: within the first time and beyond it.
STARTS_OF_OFFSET = (0.3, -0.3, 3.0)
#: Shares of tracers at rest from which a fit begins. Chosen: none, and few.
STARTS_OF_SHARE_AT_REST = (0.0, 0.1)
#: Variances of noise from which a fit begins, over the smallest mean square of a component. Chosen:
#: weak, and up to near its limit (`parameters.MAX_NOISE_SHARE`).
STARTS_OF_NOISE = (0.02, 0.3, 0.9)
#: Folds of e from the specified number from which a fit of a positive one begins. Chosen: on either
#: side, up to near `parameters.MAX_FOLDS`.
STARTS_OF_FOLDS = (0.0, -2.0, 2.0, -5.0, 5.0, -9.0, 9.0)
#: What may have been exchanged between two axes -> columns of the sums along x. Those along y and z
#: are three and six columns further on.
EXCHANGED_SUMS = {
    "positions": (X, X2),
    "velocities": (VX,),
    "positions and velocities": (VX, X, X2),
}
#: Names of the axes, in the order of the sums.
AXES = "xyz"


@dataclass(frozen=True)
class Cause:
    """A cause of a difference.

    Parameters
    ----------
    name : of the cause
    free : the number of a `Point` that is fitted; empty if none is
    symbol : of that number in a sentence
    unit : that the number is said in, if the data have d and U themselves
    kind : of the data's own unit: "speed", "time" or "length"; empty: it is said in d and U
    title : of noise, what it is noise of
    of_positions : whether it is looked for in positions alone too, for which U is fitted already
    """

    name: str
    free: str = ""
    symbol: str = ""
    unit: str = ""
    kind: str = ""
    title: str = ""
    of_positions: bool = False


#: Everything that may explain a difference. A new cause of a number that a `Point` has is one row
#: here, and its first values in `_starts`. A new number is a field of `Point` too, with its limits
#: in `parameters.LIMITS`, and what it does to data stands twice: in `Theory._as_measured`, of
#: means, and in `pool._simulated_sums`, of simulated tracers. `wrong_unit` is looked for before.
CAUSES = (
    Cause("finite density", of_positions=True),
    Cause("restitution", "restitution", "e", of_positions=True),
    Cause("free path", "path", "l", " d", of_positions=True),
    Cause("initial speeds"),
    Cause("components exchanged"),
    Cause("speed unit", "speed_unit", "U", kind="speed"),
    Cause("time unit", "time_unit", "d/U", kind="time"),
    Cause("length unit", "length_unit", "d", kind="length"),
    Cause("time offset", "time_offset", "the zero of the clock t₀", " d/U", "time"),
    Cause("velocity noise", "velocity_noise", unit="U", title="velocity"),
    Cause("position noise", "position_noise", unit="d", title="displacement"),
    Cause("tracers at rest", "at_rest", "the share f of tracers that never move"),
)


@dataclass(frozen=True)
class TestedCause:
    """A cause, what it comes to, and its fit."""

    explanation: Explanation
    fitted: Fit

    @property
    def rank(self) -> tuple[bool, float, int]:
        """What explains, then the least T^2 + 2 per fitted number, then the fewest of these."""
        explains = self.explanation.outcome == "explains"
        return not explains, self.fitted.criterion, len(self.fitted.free)


def tested_causes(reference: Fit, media: Sequence[str]) -> list[TestedCause]:
    """Return every cause in its best medium, the likeliest first.

    There is none if the test has fewer than two degrees of freedom.

    Parameters
    ----------
    reference : what was specified, with what was fitted beside, which differs from the data
    media : that the scatterers may be
    """
    if reference.chi_square is None or reference.chi_square.freedom < 2:
        return []
    tested: list[TestedCause] = []
    for cause in CAUSES:
        if reference.measured.has_velocities or cause.of_positions:
            tested += _tested(cause, reference, media)
    tested.sort(key=lambda item: item.rank)
    return [_in_part_if_far(item, tested[0]) for item in tested]


def _in_part_if_far(item: TestedCause, best: TestedCause) -> TestedCause:
    """Return a cause that explains, but much less likely than the best one, as one in part."""
    is_far = item.fitted.criterion > best.fitted.criterion + NEAR_BEST
    if item.explanation.outcome == "explains" and is_far:
        return replace(item, explanation=item.explanation._replace(outcome="in part"))
    return item


def _tested(cause: Cause, reference: Fit, media: Sequence[str]) -> list[TestedCause]:
    """Return a cause in its best variant, or in all of them where each says something else."""
    fits: list[Fit] = []
    for measured, point in _variants(cause, reference, media):
        with suppress(ValueError):  # a restitution or a density of which there is no theory
            fitted = _fit_of(cause, reference, measured, point)
            if fitted is not None and fitted.chi_square is not None:
                fits.append(fitted)
    tested = [TestedCause(_judged(reference, cause, fitted), fitted) for fitted in fits]
    tested.sort(key=lambda item: item.rank)
    if cause.name in ("finite density", "initial speeds"):
        return tested
    return tested[:1]


def _fit_of(cause: Cause, reference: Fit, measured: Measured, point: Point) -> Fit | None:
    """Return the fit of a variant, with what was fitted before."""
    names = list(reference.names)
    coordinates = coordinates_of(reference.point, reference.free).tolist()
    if not cause.free and not names:
        theory = None
        if measured.layout is reference.measured.layout:  # its point may be solved already
            theory = reference.theory
        return compare_with_point(measured, point, N_FOR_CAUSE, theory)
    free = [free_parameter(name, point, measured) for name in names]
    if not cause.free:
        return fit(measured, point, free, [coordinates], n_pool=N_FOR_CAUSE)
    parameter = free_parameter(cause.free, point, measured)
    # coordinates of each start; of a number in LIMITS that is the number over its scale
    starts = [
        [*coordinates, parameter.coordinate(value)] for value in _starts(cause, point, measured)
    ]
    # one round: weights from a pool of tracers, then the fit; quicker than the usual rounds
    return fit(measured, point, [*free, parameter], starts, n_rounds=1, n_pool=N_FOR_CAUSE)


def _variants(
    cause: Cause, reference: Fit, media: Sequence[str]
) -> Iterator[tuple[Measured, Point]]:
    """Yield the data and the point of every variant of a cause, but for what is fitted."""
    measured = reference.measured
    point = reference.point
    if cause.free in reference.names:
        return
    if cause.name == "components exchanged":
        yield from _with_exchanged_components(measured, point, media)
        return
    if measured.layout.law.field:
        return  # other causes take the solver long in a field
    if cause.name == "finite density":
        sample = measured.sample
        all_media = media_of("every", sample.law, point.path, point.restitution, sample.free)
        media = [medium for medium in all_media if medium not in media]
    if cause.name == "speed unit" and point.has_own_start:
        return  # the theory starts from the data's speeds, in whatever unit they are
    points = [point]
    if cause.name == "initial speeds":
        points = _other_starts(measured, point)
    for other in points:
        for medium in media:
            yield measured, other.with_values(scatterers=medium)


def _other_starts(measured: Measured, point: Point) -> list[Point]:
    """Return the point with the data's own speeds at time 0, or with the other named start."""
    if point.starts_along_x:
        return []
    bins = measured.sample.start
    if bins is not None:
        if point.has_own_start:
            return []
        return [point.with_values(start=SampledStart(bins))]
    others = {"gaussian", "monoenergetic"} - {point.start}
    return [point.with_values(start=name) for name in sorted(others)]


def _with_exchanged_components(
    measured: Measured, point: Point, media: Sequence[str]
) -> Iterator[tuple[Measured, Point]]:
    """Yield the data with x and another axis exchanged in positions, velocities, or both."""
    if "drift" not in measured.layout.names:
        return
    for axis in range(1, measured.layout.law.dimension):
        for what, columns in EXCHANGED_SUMS.items():
            exchanged = _exchange(measured, axis, columns, what)
            for medium in media:
                yield exchanged, point.with_values(scatterers=medium)


def _exchange(measured: Measured, axis: int, columns: Sequence[int], what: str) -> Measured:
    """Return the data with the sums of x and of another axis, 1 or 2, exchanged."""
    sample = measured.sample
    order = np.arange(sample.sums.shape[2])
    for column in columns:
        # the sums of an axis are three columns after those of the one before
        column_of_axis = column + 3 * axis
        order[column] = column_of_axis
        order[column_of_axis] = column
    exchanged = replace(sample, sums=sample.sums[..., order])
    words = f"x and {AXES[axis]} of the {what}"
    return Measured(exchanged, measured.layout, words)


def _starts(cause: Cause, point: Point, measured: Measured) -> list[float]:
    """Return the values from which the fit of a number begins."""
    layout = measured.layout
    if not measured.has_velocities:  # pairs of frames take the solver long
        return [float(getattr(point, cause.free))]
    first_time = float(layout.times[layout.times > 0.0][0])
    if cause.free == "restitution":
        return [point.restitution, *STARTS_OF_RESTITUTION]
    if cause.free == "time_offset":
        return [share * first_time for share in STARTS_OF_OFFSET]
    if cause.free == "at_rest":
        return list(STARTS_OF_SHARE_AT_REST)
    if cause.free.endswith("noise"):
        scale = free_parameter(cause.free, point, measured).scale
        return [share * scale for share in STARTS_OF_NOISE]
    value = getattr(point, cause.free)
    return [value * math.exp(folds) for folds in STARTS_OF_FOLDS]


def _judged(reference: Fit, cause: Cause, fitted: Fit) -> Explanation:
    """Return what a cause comes to, from the chi-square that it leaves."""
    before = reference.chi_square
    after = fitted.chi_square
    assert before is not None
    assert after is not None
    is_clear = _is_clear(reference, cause, fitted)
    # T^2; the text shows `value`, the chi-square that has the same p-value
    gain = before.statistic - after.statistic
    outcome = "does not"
    if after.verdict is Verdict.AGREES:
        # averages that agreed already need no explaining
        is_needed = before.verdict is not Verdict.AGREES
        outcome = "explains" if is_clear and is_needed else "does not"
    elif gain > max(MIN_GAIN, MIN_GAIN_SHARE * before.statistic) and is_clear:
        # components are exchanged, or not
        outcome = "does not" if cause.name == "components exchanged" else "in part"
    words = _words(reference, cause, fitted)
    headline = words.headline
    if fitted.point.scatterers not in ("dilute", reference.point.scatterers) and cause.free:
        headline += f" (among {fitted.point.scatterers})"
    text = (
        f"{headline[0].upper()}{headline[1:]}. The averages' chi-square goes from "
        f"{numeral(before.value, '.4g')} to {numeral(after.value, '.4g')} with {after.freedom} "
        f"degrees of freedom (p = {numeral(after.p_value, '.2g')}), scatterers: "
        f"{fitted.point.scatterers}."
    )
    return Explanation(
        name=cause.name,
        outcome=outcome,
        text=text,
        tested=True,
        value=words.value,
        error=words.error,
        chi_square_before=before.value,
        chi_square_after=after.value,
        dof=after.freedom,
        p_value=after.p_value,
        headline=headline,
        medium=fitted.point.scatterers,
    )


def _is_clear(reference: Fit, cause: Cause, fitted: Fit) -> bool:
    """Return whether a fitted value lies clearly from what was specified."""
    if not cause.free:
        return True
    value = getattr(fitted.point, cause.free)
    specified = getattr(reference.point, cause.free)
    difference = value - specified if cause.free in LIMITS else math.log(value / specified)
    factor = limit_factor(reference.measured.sample.groups, CLEARLY)
    error = math.sqrt(fitted.covariance[-1, -1])
    is_possible = 0.0 <= fitted.point.at_rest < MAX_AT_REST
    return abs(difference) > factor * error and is_possible


@dataclass(frozen=True)
class _Words:
    """A cause as a clause, with its value and error as they are said."""

    headline: str
    value: float | None = None
    error: float | None = None


def _words(reference: Fit, cause: Cause, fitted: Fit) -> _Words:
    if not cause.free:
        medium = fitted.point.scatterers
        named = {
            "finite density": f"the finite density of the scatterers ({medium}, no fitted number)",
            "initial speeds": f"another start ({fitted.point.start_in_words})",
            "components exchanged": f"an exchange of {fitted.measured.exchanged}",
        }
        return _Words(named[cause.name])
    value, error = fitted.value(cause.free)
    if cause.free.endswith("noise"):  # of a variance the root
        size, width = root_of_variance(value, error)
        shown = number(size, width)
        headline = f"noise of {shown} {cause.unit} in each component of the {cause.title}"
        return _Words(headline, size, width)
    specified = float(getattr(reference.point, cause.free))
    unit = reference.measured.sample.units.get(cause.kind, 1.0)  # in the data's own
    name = cause.unit if unit == 1.0 else ""
    shown = number(value * unit, error * unit)
    headline = (
        f"{cause.symbol} = {shown}{name} in place of {numeral(specified * unit, '.5g')}{name}"
    )
    return _Words(headline, value * unit, error * unit)
