"""Which comparisons one report makes: who says what against whom."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from kinetics import sonine
from kinetics.crosscheck.report.case import Array, Case, Measured
from kinetics.crosscheck.report.histograms import band_middles
from kinetics.crosscheck.report.observables import bands_of, bin_density, sure_density
from kinetics.crosscheck.report.row import (
    EXACT,
    KINETIC,
    LEAST_EXPECTED,
    PAPER_FIT,
    RESCALED,
    Row,
    approximation,
    bin_average,
    contact_value,
    cooling_rate_between,
    largest_change,
    last_vdf,
    msd_slope_between,
    numerical,
    statistical,
)
from kinetics.crosscheck.report.settings import ReportSettings
from kinetics.crosscheck.verdicts import judge_numerical


def compare_case(case: Case, settings: ReportSettings) -> list[Row]:
    """Every row of one restitution; statistical ones are not judged yet (see `judged`)."""
    rows = [*_free_path(case, settings)]
    if case.exact is not None:
        rows += _cooling_rate(case, settings)
    rows += [*_a2(case, settings), *_thermal_speed(case)]
    if case.exact is not None:
        rows += _scaled_vdf(case, settings)
    rows += _msd(case, settings)
    if case.exact is not None:
        rows += _msd_slope(case, settings)
    return rows + _kurtosis(case) + _position(case) + _tail_exponent(case)


def _free_path(case: Case, settings: ReportSettings) -> list[Row]:
    dilute = 1 / (2 * settings.number_density)
    dense = dilute / contact_value(settings.number_density)
    return [
        *statistical(case, "free_path", case.free, case.free.free_path, dilute, "1/(2dρ₀)"),
        *statistical(
            case,
            "free_path",
            case.disks,
            case.disks.free_path,
            dilute,
            "1/(2dρ₀)",
            note="disks that exclude each other are met sooner; not in the kinetic equation",
        ),
        *statistical(
            case,
            "free_path",
            case.disks,
            case.disks.free_path,
            dense,
            "1/(2dρ₀g)",
            note="g: Henderson's contact value of hard disks in equilibrium",
        ),
    ]


def _against_both(
    case: Case,
    observable: str,
    free: Measured,
    disks: Measured,
    kinetic: ArrayLike,
    rescaled: ArrayLike,
    times: Array | None = None,
    note: str = "",
) -> list[Row]:
    """Boltzmann-Grad strictly; hard disks as they are, and with their own free path put in."""
    left = "what remains is beyond the free path: recollisions, corners, correlated free paths"
    own = Measured(disks.value, case.rescaled_errors[observable])
    return [
        *statistical(case, observable, case.free, free, kinetic, KINETIC, times, note=note),
        *statistical(
            case, observable, case.disks, disks, kinetic, KINETIC, times, note="finite density"
        ),
        *statistical(case, observable, case.disks, own, rescaled, RESCALED, times, note=left),
    ]


def _cooling_rate(case: Case, settings: ReportSettings) -> list[Row]:
    assert case.exact is not None
    assert case.scaled is not None
    exact = case.exact.cooling_rate
    density = settings.number_density

    def between(thermal_speed: Array) -> float:
        return cooling_rate_between(case.times, thermal_speed, case.early, density)

    kinetic = between(case.kinetic.thermal_speed)
    start = (
        f"slope of 1/v0 from t = {case.times[case.early]:.4g} to {case.times[-1]:.4g} d/U; "
        f"the exact h is {exact:.5f}"
    )
    e = case.restitution
    return [
        numerical(case, "cooling_rate", case.scaled.cooling_rate, exact, settings.rtol),
        approximation(case, "cooling_rate", "Sonine", float(sonine.cooling_rate(e)), exact),
        approximation(case, "cooling_rate", PAPER_FIT, float(sonine.cooling_rate_fitted(e)), exact),
        *_against_both(
            case,
            "cooling_rate",
            case.free.cooling_rate,
            case.disks.cooling_rate,
            kinetic,
            between(case.rescaled.thermal_speed),
            note=start,
        ),
        *statistical(
            case,
            "cooling_rate",
            case.disks,
            case.disks.cooling_rate,
            sonine.cooling_rate_fitted(e),
            PAPER_FIT,
            note="the paper's own claim",
        ),
    ]


def _a2(case: Case, settings: ReportSettings) -> list[Row]:
    rows = []
    if case.exact is not None and case.scaled is not None:
        exact = case.exact.a2
        rows = [
            numerical(case, "a2", case.scaled.a2, exact, settings.rtol),
            approximation(case, "a2", "Sonine", float(sonine.a2(case.restitution)), exact),
        ]
    return rows + _against_both(
        case, "a2", case.free.a2, case.disks.a2, case.kinetic.a2, case.rescaled.a2, case.times
    )


def _thermal_speed(case: Case) -> list[Row]:
    return _against_both(
        case,
        "thermal_speed",
        case.free.thermal_speed,
        case.disks.thermal_speed,
        case.kinetic.thermal_speed,
        case.rescaled.thermal_speed,
        case.times,
    )


def _scaled_vdf(case: Case, settings: ReportSettings) -> list[Row]:
    assert case.exact is not None
    assert case.scaled is not None
    centres = (case.speed_edges[1:] + case.speed_edges[:-1]) / 2
    # Where F is 1e-10 of its peak, a relative tolerance asks for more than double precision holds.
    exact = np.asarray(case.exact.vdf(centres))
    solver = np.asarray(case.scaled.vdf(centres))
    k = int(np.argmax(np.abs(solver - exact)))
    deviation = float((solver[k] - exact[k]) / np.max(exact))
    numerical = Row(
        "scaled_vdf",
        case.restitution,
        "numerical",
        "solver",
        EXACT,
        float(solver[k]),
        float(exact[k]),
        deviation,
        c=float(centres[k]),
        looks=len(centres),
        verdict=judge_numerical(deviation, settings.rtol),
        note=f"worst bin centre, relative to the peak; asked for {settings.rtol:g}",
    )
    kinetic, rescaled = (
        bin_average(last_vdf(solution), case.speed_edges)
        for solution in (case.kinetic, case.rescaled)
    )
    note = f"mean over a bin of c at the last time, bins of {LEAST_EXPECTED} samples or more"
    left = f"; still to change by {largest_change(case, kinetic):.1%} of the peak"
    rows = [numerical]
    for run, theory, against in (
        (case.free, kinetic, KINETIC),
        (case.disks, rescaled, RESCALED),
    ):
        expected = run.samples * theory * math.pi * np.diff(case.speed_edges**2)
        compared = np.where(expected >= LEAST_EXPECTED, theory, np.nan)
        rows += statistical(
            case, "scaled_vdf", run, run.vdf, compared, against, speeds=centres, note=note + left
        )
    return rows


def _msd(case: Case, settings: ReportSettings) -> list[Row]:
    e, density = case.restitution, settings.number_density
    last, theory = float(case.times[-1]), float(case.kinetic.msd[-1])
    walk = float(sonine.msd_random_walk(last, e, density))
    late = slice(case.early, None)
    rows = [
        approximation(
            case,
            "msd",
            PAPER_FIT,
            walk,
            theory,
            KINETIC,
            last,
            f"random walk (eq. msd) with l = {sonine.FITTED_FREE_PATH} d",
        ),
        approximation(
            case,
            "msd",
            "Sonine",
            float(sonine.msd_sonine(last, e, density)),
            theory,
            KINETIC,
            last,
            "eq. ad8",
        ),
        *statistical(
            case,
            "msd",
            case.disks,
            Measured(case.disks.msd.value[late], case.disks.msd.error[late]),
            sonine.msd_random_walk(case.times[late], e, density),
            PAPER_FIT,
            case.times[late],
            note="the paper's own claim, for late times: here the last decade",
        ),
    ]
    return rows + _against_both(
        case, "msd", case.free.msd, case.disks.msd, case.kinetic.msd, case.rescaled.msd, case.times
    )


def _msd_slope(case: Case, settings: ReportSettings) -> list[Row]:
    assert case.exact is not None
    e, density, times = case.restitution, settings.number_density, case.times
    dilute = 1 / (2 * density)
    exact = case.exact.diffusion_slope * dilute**2
    early, last = times[case.early], times[-1]

    def between(msd: Array) -> float:
        return msd_slope_between(times, msd, case.early)

    printed = "limit of late times"
    over = (
        f"from t = {early:.4g} to {last:.4g} d/U; the exact limit is {exact:.5g} d², reached to "
        f"{case.late.msd_slope[-1] / exact - 1:.0e} at t = {case.late.times[-1]:.0e} d/U"
    )
    return [
        approximation(
            case, "msd_slope", PAPER_FIT, sonine_slopes(e, density)[0], exact, note=printed
        ),
        approximation(
            case, "msd_slope", "Sonine", sonine_slopes(e, density)[1], exact, note=printed
        ),
        *_against_both(
            case,
            "msd_slope",
            case.free.msd_slope,
            case.disks.msd_slope,
            between(case.kinetic.msd),
            between(case.rescaled.msd),
            note=over,
        ),
    ]


def sonine_slopes(restitution: float, number_density: float) -> tuple[float, float]:
    """Late d<r^2>/d ln t of the printed formulas, in d^2: random walk (eq. msd), Sonine (ad8)."""
    path = sonine.FITTED_FREE_PATH
    walk = path**2 / math.log1p(path * float(sonine.beta(restitution, number_density)))
    correction = 1 + 3 / 8 * float(sonine.a2(restitution))
    bracket = (1 + restitution) ** 2 * (1 - restitution**2) * correction**2
    return walk, 8 / (math.pi * number_density**2) / bracket


def _kurtosis(case: Case) -> list[Row]:
    last = float(case.times[-1])
    rows = []
    if case.exact is not None:
        rows = [
            approximation(
                case,
                "kurtosis",
                "paper's integral",
                PAPER_KURTOSIS,
                float(case.kinetic.kurtosis[-1]),
                KINETIC,
                last,
                "eq. gdefi has 4 at every time; a Gaussian has 2, which is the limit of late times",
            )
        ]
    return rows + _against_both(
        case,
        "kurtosis",
        case.free.kurtosis,
        case.disks.kurtosis,
        case.kinetic.kurtosis,
        case.rescaled.kurtosis,
        case.times,
    )


PAPER_KURTOSIS = 4.0
"""<R^4>/<R^2>^2 of (2R/eta) K0(R sqrt(2/eta)), eq. gdefi, for every eta."""


def _position(case: Case) -> list[Row]:
    rows: list[Row] = []
    if case.exact is not None:
        rows += [row for form in POSITION_FORMS for row in _printed_position(case, *form)]
    edges = case.position_edges
    centres = (edges[1:] + edges[:-1]) / 2
    theory = bin_density(case, edges)
    for run, note in ((case.free, ""), (case.disks, "; finite density")):
        expected = run.samples * theory * np.diff(edges)
        rows += statistical(
            case,
            "position",
            run,
            run.position,
            np.where(expected >= LEAST_EXPECTED, theory, np.nan),
            KINETIC,
            distances=centres,
            note=f"mean over a bin of R at the last time, bins of {LEAST_EXPECTED} samples or more"
            + note,
        )
    return rows


POSITION_FORMS = (
    ("paper, peak", sonine.position_peak, 0.2, 1.2, "eq. peakg, η = 0.75, for 0.2 ≤ R ≤ 1.2"),
    ("paper, tail", sonine.position_tail, 2.0, 4.0,
     "eq. gammatailg, η = 0.25, γ = 7.39, for 2 ≤ R ≤ 4"),
    ("paper's integral", sonine.position_integral, 0.2, 4.0,
     "eq. gdefi, η = 1/2, for 0.2 ≤ R ≤ 4"),
)  # fmt: skip
"""Source, the printed G(R), and the R between which it is held against the equation."""


def _printed_position(
    case: Case, source: str, form: Callable[[Array], Array], low: float, high: float, note: str
) -> list[Row]:
    r, theory = sure_density(case, np.linspace(low, high, 61))
    if not r.size:
        return []
    printed = form(r)
    k = int(np.argmax(np.abs(np.log(printed / theory))))
    return [
        approximation(
            case,
            "position",
            source,
            float(printed[k]),
            float(theory[k]),
            KINETIC,
            float(case.times[-1]),
            note + ", at its worst",
            float(r[k]),
        )
    ]


def _tail_exponent(case: Case) -> list[Row]:
    theory, middles = bands_of(case), band_middles()
    note = "between bands of R; 2 is a Gaussian, 1 an exponential"
    return [
        row
        for run, extra in ((case.free, ""), (case.disks, "; finite density"))
        for row in statistical(
            case,
            "tail_exponent",
            run,
            run.tail_exponent,
            theory,
            KINETIC,
            distances=middles,
            note=note + extra,
        )
    ]
