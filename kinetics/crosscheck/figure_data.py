"""The data of each figure, as plain lists: what the JSON file holds and `figures` draws."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics import sonine
from kinetics.crosscheck.evidence import Array, Case, Measured, ParticleEvidence
from kinetics.crosscheck.rows import last_vdf
from kinetics.crosscheck.settings import ReportSettings

Data = dict[str, Any]

LARGEST_SLOPE_ERROR = 0.2
"""Standard error of (1/v0 - 1/v0(0))/((1-e) d rho0 t) above which a point says nothing."""


def all_figures(cases: Sequence[Case], settings: ReportSettings) -> dict[str, Data]:
    """The data of every figure that these cases allow, by figure name."""
    cooling = [case for case in cases if case.exact is not None]
    figures: dict[str, Data] = {}
    if cooling:
        figures["cooling-rate"] = cooling_rate(cooling)
        figures["a2"] = a2(cooling)
    figures["thermal-speed"] = thermal_speed(cases, settings)
    if cooling:
        figures["inverse-speed"] = inverse_speed(cooling, settings)
        figures["scaled-vdf"] = scaled_vdf(cooling)
    figures["msd"] = msd(cases, settings)
    figures["position"] = position(cases)
    return figures


def _axis(
    label: str, unit: str = "", scale: str = "linear", limits: tuple[float, float] | None = None
) -> Data:
    return {
        "label": label,
        "unit": unit,
        "scale": scale,
        "limits": None if limits is None else list(limits),
    }


def _series(
    source: str,
    x: ArrayLike,
    y: ArrayLike,
    error: ArrayLike | None = None,
    restitution: float | None = None,
) -> Data:
    return {
        "source": source,
        "restitution": restitution,
        "x": _plain(x),
        "y": _plain(y),
        "error": None if error is None else _plain(error),
    }


def _plain(values: ArrayLike) -> list[float | None]:
    """Floats, and None for what has no finite value: JSON has no NaN."""
    return [
        float(v) if np.isfinite(v) else None for v in np.atleast_1d(np.asarray(values, dtype=float))
    ]


def _figure(title: str, description: str, x: Data, y: Data, series: Iterable[Data]) -> Data:
    return {"title": title, "description": description, "x": x, "y": y, "series": list(series)}


def _both_runs(case: Case) -> tuple[ParticleEvidence, ParticleEvidence]:
    return case.free, case.disks


def _positive(measured: Measured) -> Measured:
    """Without what a logarithmic axis cannot show: empty bins."""
    keep = measured.value > 0
    return Measured(np.where(keep, measured.value, np.nan), np.where(keep, measured.error, np.nan))


def _all_restitutions() -> Array:
    """0 <= e < 1, with the threshold from which on the printed a2 is real."""
    return np.sort([*np.linspace(0.0, 0.99, 100), 0.999, sonine.THRESHOLD_RESTITUTION + 1e-12])


def cooling_rate(cases: Sequence[Case]) -> Data:
    """h(e)/(1-e): every witness, and both printed formulas (labels hetomu2, hsimu)."""
    from kinetics.exact import ScalingSolution

    e = _all_restitutions()
    exact = [ScalingSolution(float(x)).cooling_rate for x in e]
    at = np.array([case.restitution for case in cases])
    solver = [case.scaled.cooling_rate for case in cases if case.scaled is not None]
    series = [
        _series("exact", e, exact / (1 - e)),
        _series("solver", at, solver / (1 - at)),
        _series("Sonine", e, sonine.cooling_rate(e) / (1 - e)),
        _series("paper's fit", e, sonine.cooling_rate_fitted(e) / (1 - e)),
    ]
    for name, runs in _by_run(cases):
        h = np.array([float(run.cooling_rate.value) for run in runs])
        error = np.array([float(run.cooling_rate.error) for run in runs])
        series.append(_series(name, at, h / (1 - at), error / (1 - at)))
    return _figure(
        "Cooling rate",
        "h(e)/(1 − e) over the restitution e. Exactly, it is √2 at "
        "e = 0 and 4/3 as e approaches 1; the paper's fit is the constant 1.45, and its Sonine "
        "expression exists only above e = 0.58. Particle values are the slope of 1/v₀ over a "
        "finite time, with l = 1/(2dρ₀); the bars are one standard error.",
        _axis("restitution $e$", limits=(0.0, 1.0)),
        _axis("$h(e)/(1-e)$"),
        series,
    )


def _by_run(cases: Sequence[Case]) -> list[tuple[str, list[ParticleEvidence]]]:
    """The runs of every case, Boltzmann-Grad first, under the name that they share."""
    runs = zip(*(_both_runs(case) for case in cases), strict=True)
    return [(same[0].name, list(same)) for same in runs]


def a2(cases: Sequence[Case]) -> Data:
    """Second Sonine coefficient: exact, solver, printed roots (sonine11), particles at the end."""
    from kinetics.exact import ScalingSolution

    e = _all_restitutions()
    at = [case.restitution for case in cases]
    series = [
        _series("zero", [0.0, 1.0], [0.0, 0.0]),
        _series("exact", e, [ScalingSolution(float(x)).a2 for x in e]),
        _series("solver", at, [case.scaled.a2 for case in cases if case.scaled is not None]),
        _series("Sonine", e, sonine.a2(e)),
        _series("Sonine, unstable root", e, sonine.a2(e, "unstable")),
    ]
    for name, runs in _by_run(cases):
        values = [run.a2.value[-1] for run in runs]
        series.append(_series(name, at, values, [run.a2.error[-1] for run in runs]))
    return _figure(
        "Second Sonine coefficient",
        "a₂(e) = ⟨c⁴⟩/2 − 1. Exactly, it falls from 2 at e = 0 to −1/2 as e approaches 1; the two "
        "printed roots exist only above e = 0.58. Particle values are those of the last time, when "
        "the Gaussian start is not quite forgotten; the bars are one standard error.",
        _axis("restitution $e$", limits=(0.0, 1.0)),
        _axis("$a_2$"),
        series,
    )


def _over_time(case: Case, name: str) -> list[Data]:
    """The kinetic equation's line and both runs' points of one observable, over time."""
    e = case.restitution
    series = [_series("kinetic equation", case.times, getattr(case.kinetic, name), None, e)]
    for run in _both_runs(case):
        measured: Measured = getattr(run, name)
        series.append(_series(run.name, case.times, measured.value, measured.error, e))
    return series


def thermal_speed(cases: Sequence[Case], settings: ReportSettings) -> Data:
    """v0(t), and eq. veq with the fitted h(e)."""
    series = []
    for case in cases:
        e = case.restitution
        fitted = sonine.thermal_speed(
            case.times, sonine.cooling_rate_fitted(e), settings.number_density
        )
        series += [
            *_over_time(case, "thermal_speed"),
            _series("paper's fit", case.times, fitted, None, e),
        ]
    return _figure(
        "Thermal speed",
        "v₀(t) from a Gaussian start for each restitution e, on logarithmic axes. The paper's fit "
        "is 1/v₀ = 1/v₀(0) + dρ₀ht with h = 1.45 (1 − e).",
        _axis("time $t$", "d/U", "log"),
        _axis("thermal speed $v_0$", "U", "log"),
        series,
    )


def inverse_speed(cases: Sequence[Case], settings: ReportSettings) -> Data:
    """The paper's Fig. v0re, J = (1/v0(t) - 1/v0(0))/(1-e), over its slope's d rho0 t."""
    series = []
    for case in cases:
        e, start = case.restitution, 1 / sonine.THERMAL_SPEED_START
        scale = (1 - e) * settings.number_density * case.times
        v = case.kinetic.thermal_speed
        series.append(_series("kinetic equation", case.times, (1 / v - start) / scale, None, e))
        for run in _both_runs(case):
            v, dv = run.thermal_speed.value, run.thermal_speed.error
            error = dv / v**2 / scale
            shown = error < LARGEST_SLOPE_ERROR
            j = (1 / v - start) / scale
            series.append(_series(run.name, case.times[shown], j[shown], error[shown], e))
    ends = [min(case.times[0] for case in cases), max(case.times[-1] for case in cases)]
    series.append(_series("paper's fit", ends, [sonine.FITTED_COOLING_FACTOR] * 2))
    return _figure(
        "Inverse thermal speed",
        "The paper's Figure v0re divided by its abscissa: (1/v₀(t) − 1/v₀(0))/((1 − e) dρ₀t), "
        "which the paper reads as the constant 1.45. The kinetic equation starts at the Gaussian's "
        "rate and tends to the exact h(e)/(1 − e); hard disks lie above, their free path "
        "being shorter. The bars are one standard error, the spread of the start included; points "
        f"with a larger one than {LARGEST_SLOPE_ERROR:g} are left out.",
        _axis("time $t$", "d/U", "log"),
        _axis(r"$(1/v_0 - 1/v_0(0))\,/\,((1-e)\,d\rho_0 t)$"),
        series,
    )


def scaled_vdf(cases: Sequence[Case]) -> Data:
    """F(c) on a logarithmic scale with its exact tail (label scalev)."""
    series = []
    edges = cases[0].speed_edges
    c = np.linspace(0.02, edges[-1], 200)
    for case in cases:
        assert case.exact is not None
        e = case.restitution
        vdf = np.asarray(case.exact.vdf(c))
        series.append(_series("kinetic equation", c, last_vdf(case.kinetic)(c), None, e))
        series.append(_series("scaling state", c, vdf, None, e))
        # The tail c^(1/(1-e^2) - 2) exp(-2 c/h), joined to the exact curve where c ends.
        power = 1 / (1 - e**2) - 2
        tail = c**power * np.exp(-2 * c / case.exact.cooling_rate)
        far = c > edges[-1] * 0.55
        series.append(_series("exact tail", c[far], (tail * vdf[-1] / tail[-1])[far], None, e))
        centres = (case.speed_edges[1:] + case.speed_edges[:-1]) / 2
        for run in _both_runs(case):
            shown = _positive(run.vdf)
            series.append(_series(run.name, centres, shown.value, shown.error, e))
    series.append(_series("Gaussian", c, sonine.vdf(c, 0.0)))
    smallest = min(v for s in series if s["error"] for v in s["y"] if v)
    return _figure(
        "Scaled velocity distribution",
        "F(c) over the scaled speed c = v/v₀, a density in the plane, at the last time: the "
        "kinetic equation, and particles averaged over a bin of c with one standard error. The "
        "scaling state, exact, is what they tend to; it has an exponential tail and, for e above "
        "0, vanishes at c = 0. The paper fits the Gaussian.",
        _axis("scaled speed $c = v/v_0$"),
        _axis("$F(c)$", "", "log", (smallest / 3, 2.0)),
        series,
    )


def msd(cases: Sequence[Case], settings: ReportSettings) -> Data:
    """<r^2(t)>, the random walk (label msd) and the Sonine result (label ad8)."""
    series = []
    for case in cases:
        e, density = case.restitution, settings.number_density
        series += [
            *_over_time(case, "msd"),
            _series(
                "paper's fit", case.times, sonine.msd_random_walk(case.times, e, density), None, e
            ),
            _series("Sonine", case.times, sonine.msd_sonine(case.times, e, density), None, e),
        ]
    return _figure(
        "Mean square displacement",
        "The tracer is localised: ⟨r²⟩ grows with the logarithm of time. The paper's fit is its "
        "random walk with l = 13.5 d and h = 1.45 (1 − e); its Sonine result exists only for e "
        "above 0.58. The bars are one standard error.",
        _axis("time $t$", "d/U", "log"),
        _axis(r"$\langle r^2\rangle$", "d²"),
        series,
    )


def position(cases: Sequence[Case]) -> Data:
    """G(R) of the particles at the last time, with the paper's forms (label inelasticposi)."""
    series = []
    for case in cases:
        centres = (case.position_edges[1:] + case.position_edges[:-1]) / 2
        for run in _both_runs(case):
            shown = _positive(run.position)
            series.append(_series(run.name, centres, shown.value, shown.error, case.restitution))
    r = np.linspace(0.05, cases[0].position_edges[-1], 120)
    series += [
        _series("paper, peak", r, sonine.position_peak(r)),
        _series("paper, tail", r[r > 1], sonine.position_tail(r[r > 1])),
        _series("paper's integral", r, sonine.position_integral(r, 0.5)),
    ]
    return _figure(
        "Scaled position distribution",
        "G(R) over the scaled distance R = r/√⟨r²⟩ at the last time. The paper's peak form "
        "has η = 0.75, its tail form η = 0.25 and γ = 7.39, both fitted; its integral is "
        "drawn with η = 1/2, which ⟨R²⟩ = 1 demands. The bars are one standard error.",
        _axis(r"scaled distance $R$"),
        _axis("$G(R)$", "", "log", (1e-4, 2.0)),
        series,
    )
