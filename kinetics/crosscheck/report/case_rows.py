"""Every comparison that a report makes for one restitution."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from kinetics import Solution, sonine
from kinetics.crosscheck.numerals import numeral
from kinetics.crosscheck.report.case import Array, Case, ParticleRun
from kinetics.crosscheck.report.observables import (
    ball,
    bands_of,
    bin_average,
    bin_density,
    contact_value,
    cooling_rate_between,
    largest_change,
    last_vdf,
    middles,
    msd_slope_between,
    printed_msd_slopes,
    sure_density,
)
from kinetics.crosscheck.report.row import (
    KINETIC,
    PAPER_FIT,
    RESCALED,
    Row,
    approximation,
    numerical,
    statistical,
)
from kinetics.crosscheck.report.settings import ReportSettings
from kinetics.crosscheck.verdicts import judge_numerical

LEAST_EXPECTED = 50
"""Samples that a bin must be expected to hold before its jackknife error is trusted."""
ENOUGH = f"bins of {LEAST_EXPECTED} samples or more"
PAPER_KURTOSIS = 4.0
"""<R^4>/<R^2>^2 of (2R/eta) K0(R sqrt(2/eta)), eq. gdefi, for every eta."""


def rows_of_case(case: Case, settings: ReportSettings) -> list[Row]:
    """Every row of one restitution."""
    cooling = case.exact is not None
    rows = _free_path(case, settings)
    if cooling:
        rows += _cooling_rate(case, settings)
    rows += _a2(case, settings)
    rows += _particles(case, "thermal_speed")
    if cooling:
        rows += _scaled_vdf(case, settings)
    rows += _msd(case, settings)
    if cooling:
        rows += _msd_slope(case, settings)
    return rows + _kurtosis(case, settings) + _position(case, settings) + _tail_exponent(case)


def _particles(
    case: Case,
    observable: str,
    reduce: Callable[..., float] | None = None,
    note: str = "",
) -> list[Row]:
    """Particles against the equation: Boltzmann-Grad; hard disks or spheres; these with their l.

    `reduce` makes a number of a solution; without it the solution's values over time are compared.
    """
    kinetic, rescaled = (
        getattr(solution, observable) if reduce is None else reduce(solution)
        for solution in (case.kinetic, case.rescaled)
    )
    left = "what remains is beyond the free path: recollisions, corners, correlated free paths"
    return [
        *statistical(case, observable, case.free, kinetic, note=note),
        *statistical(case, observable, case.hard, kinetic, note="finite density"),
        *statistical(case, observable, case.hard, rescaled, RESCALED, left),
    ]


def _free_path(case: Case, settings: ReportSettings) -> list[Row]:
    dilute, name, of = 1 / (2 * settings.half_rate), "free_path", settings.scatterers
    sooner = f"{of} that exclude each other are met sooner; not in the kinetic equation"
    dense = dilute / contact_value(settings.number_density, dimension=settings.dimension)
    author = "Henderson's" if settings.dimension == 2 else "Carnahan and Starling's"
    equilibrium = f"g: {author} contact value of hard {of} in equilibrium"
    cross_section = "2d" if settings.dimension == 2 else "πd²"
    return [
        *statistical(case, name, case.free, dilute, f"1/({cross_section}ρ₀)"),
        *statistical(case, name, case.hard, dilute, f"1/({cross_section}ρ₀)", sooner),
        *statistical(case, name, case.hard, dense, f"1/({cross_section}ρ₀g)", equilibrium),
    ]


def _cooling_rate(case: Case, settings: ReportSettings) -> list[Row]:
    e, name = case.restitution, "cooling_rate"
    exact, solver = (state.cooling_rate for state in case.scaling_state)
    note = (
        f"slope of 1/v0 from t = {case.times[case.early]:.4g} to {case.times[-1]:.4g} d/U; "
        f"the exact h of late times is {exact:.5f}"
    )

    def rate(solution: Solution) -> float:
        return cooling_rate_between(
            case.times, solution.thermal_speed, case.early, settings.half_rate
        )

    solved = numerical(e, name, solver, exact, settings.rtol)
    if not settings.is_papers_law:
        return [solved, *_particles(case, name, rate, note)]
    fitted = float(sonine.cooling_rate_fitted(e))
    return [
        solved,
        approximation(case.restitution, name, "Sonine", float(sonine.cooling_rate(e)), exact),
        approximation(case.restitution, name, PAPER_FIT, fitted, exact),
        *_particles(case, name, rate, note),
        *statistical(case, name, case.hard, fitted, PAPER_FIT, "the paper's own claim"),
    ]


def _a2(case: Case, settings: ReportSettings) -> list[Row]:
    rows = _particles(case, "a2")
    if case.exact is None:
        return rows
    exact, solver = (state.a2 for state in case.scaling_state)
    rows = [numerical(case.restitution, "a2", solver, exact, settings.rtol), *rows]
    if settings.is_papers_law:
        printed = float(sonine.a2(case.restitution))
        rows.insert(1, approximation(case.restitution, "a2", "Sonine", printed, exact))
    return rows


def _scaled_vdf(case: Case, settings: ReportSettings) -> list[Row]:
    edges, name = case.speed_edges, "scaled_vdf"
    centres = middles(edges)
    # Where F is 1e-10 of its peak, a relative tolerance asks for more than double precision holds.
    exact, solver = (np.asarray(state.vdf(centres)) for state in case.scaling_state)
    k = int(np.argmax(np.abs(solver - exact)))
    deviation = float((solver[k] - exact[k]) / np.max(exact))
    row = numerical(case.restitution, name, float(solver[k]), float(exact[k]), settings.rtol)
    row = replace(
        row, deviation=deviation, verdict=judge_numerical(deviation, settings.rtol),
        c=float(centres[k]), looks=len(centres),
        note=f"worst bin centre, relative to the peak; {row.note}",
    )  # fmt: skip
    kinetic, rescaled = (
        bin_average(last_vdf(s), edges, case.dimension) for s in (case.kinetic, case.rescaled)
    )
    note = (
        f"mean over a bin of c at the last time, {ENOUGH}; "
        f"still to change by {largest_change(case, kinetic):.1%} of the peak"
    )
    area = ball(case.dimension) * np.diff(edges**case.dimension)
    return [
        row,
        *statistical(case, name, case.free, _filled(case.free, kinetic, area), note=note),
        *statistical(case, name, case.hard, _filled(case.hard, rescaled, area), RESCALED, note),
    ]


def _filled(run: ParticleRun, density: Array, measure: Array) -> Array:
    """The density in those bins in which it expects enough samples, NaN in others."""
    return np.where(run.samples * density * measure >= LEAST_EXPECTED, density, np.nan)


def _msd(case: Case, settings: ReportSettings) -> list[Row]:
    if not settings.is_papers_law:
        return _particles(case, "msd")
    e, density, times = case.restitution, settings.number_density, case.times
    last, theory = float(times[-1]), float(case.kinetic.msd[-1])
    walk = sonine.msd_random_walk(times, e, density)
    printed = float(sonine.msd_sonine(last, e, density))
    note = f"random walk, eq. (22), with l = {sonine.FITTED_FREE_PATH} d"
    claim = "the paper's own claim, for late times: here the last decade"
    at_end: dict[str, Any] = {"against": KINETIC, "time": last}
    late = np.where(np.arange(times.size) >= case.early, walk, np.nan)
    return [
        approximation(
            case.restitution, "msd", PAPER_FIT, float(walk[-1]), theory, **at_end, note=note
        ),
        approximation(
            case.restitution, "msd", "Sonine", printed, theory, **at_end, note="eq. (C9)"
        ),
        *statistical(case, "msd", case.hard, late, PAPER_FIT, claim),
        *_particles(case, "msd"),
    ]


def _msd_slope(case: Case, settings: ReportSettings) -> list[Row]:
    times, exact, name = case.times, case.late_msd_slope, "msd_slope"
    limit = "limit of late times"
    note = (
        f"from t = {times[case.early]:.4g} to {times[-1]:.4g} d/U; the exact limit is "
        f"{exact:.5g} d², reached to {numeral(case.late.msd_slope[-1] / exact - 1, '.0e')} at "
        f"t = {numeral(case.late.times[-1], '.0e')} d/U"
    )
    rows = _particles(case, name, lambda s: msd_slope_between(times, s.msd, case.early), note)
    if not settings.is_papers_law:
        return rows
    walk, printed = printed_msd_slopes(case.restitution, settings.number_density)
    return [
        approximation(case.restitution, name, PAPER_FIT, walk, exact, note=limit),
        approximation(case.restitution, name, "Sonine", printed, exact, note=limit),
        *rows,
    ]


def _kurtosis(case: Case, settings: ReportSettings) -> list[Row]:
    rows = _particles(case, "kurtosis")
    if case.exact is None or not settings.is_papers_law:
        return rows
    note = "eq. (53) has 4 at every time; a Gaussian has 2, which is the limit of late times"
    printed = approximation(
        case.restitution, "kurtosis", "paper's integral", PAPER_KURTOSIS,
        float(case.kinetic.kurtosis[-1]), KINETIC, time=float(case.times[-1]), note=note,
    )  # fmt: skip
    return [printed, *rows]


POSITION_FORMS = (
    ("paper, peak", sonine.position_peak, 0.2, 1.2, "eq. (59), η = 0.75, for 0.2 ≤ R ≤ 1.2"),
    ("paper, tail", sonine.position_tail, 2.0, 4.0,
     "eq. (58), η = 0.25, γ = 7.39, for 2 ≤ R ≤ 4"),
    ("paper's integral", sonine.position_integral, 0.2, 4.0,
     "eq. (53), η = 1/2, for 0.2 ≤ R ≤ 4"),
)  # fmt: skip
"""Source, the printed G(R), and the R between which it is held against the equation."""


def _position(case: Case, settings: ReportSettings) -> list[Row]:
    rows: list[Row] = []
    printed_forms = POSITION_FORMS if case.exact is not None and settings.is_papers_law else ()
    for source, form, low, high, note in printed_forms:
        r, density = sure_density(case, np.linspace(low, high, 61))
        if r.size:
            printed = form(r)
            k = int(np.argmax(np.abs(np.log(printed / density))))
            row = approximation(
                case.restitution, "position", source, float(printed[k]), float(density[k]), KINETIC,
                time=float(case.times[-1]), note=note + ", at its worst", distance=float(r[k]),
            )  # fmt: skip
            rows.append(row)
    theory, width = bin_density(case, case.position_edges), np.diff(case.position_edges)
    note = f"mean over a bin of R at the last time, {ENOUGH}"
    for run, extra in ((case.free, ""), (case.hard, "; finite density")):
        filled = _filled(run, theory, width)
        rows += statistical(case, "position", run, filled, note=note + extra)
    return rows


def _tail_exponent(case: Case) -> list[Row]:
    theory = bands_of(case)
    note = "between bands of R; 2 is a Gaussian, 1 an exponential"
    return [
        *statistical(case, "tail_exponent", case.free, theory, note=note),
        *statistical(case, "tail_exponent", case.hard, theory, note=note + "; finite density"),
    ]
