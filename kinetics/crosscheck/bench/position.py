"""Run time against error of the displacement: its moments, and its whole distribution G(R).

Error measures:

- <r^2>(t), kurtosis(t): the largest relative error over 25 log-spaced times;
- G(R): the largest |G - G_ref| over 200 radii to R = 6, over the largest G_ref. Of a histogram
  that of the mean in each bin from R = 0.25 to 4, the exact one by the reference's shares.

No closed form of G(R) is known: its reference is the solver at its tightest, compared with <r^2>
and <r^4>, which come from scalar equations without wave numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics import Scene, solve, sonine
from kinetics.crosscheck import references
from kinetics.crosscheck.bench import methods
from kinetics.crosscheck.bench.measuring import Effort, Work, measure, sweep
from kinetics.crosscheck.bench.methods import (
    CONSERVATIVE,
    MONTE_CARLO,
    NUMBER_DENSITY,
    PRINTED,
    SONINE,
    SPECTRAL,
    STRAIGHTFORWARD,
)
from kinetics.crosscheck.bench.precision import (
    QUANTITIES,
    TOLERANCES,
    binned,
    relative,
    restitutions,
    sample_numbers,
)
from kinetics.crosscheck.bench.record import NOT_AVAILABLE, PRECISION, Record
from kinetics.numerics.gauss import panels_between

FloatArray = NDArray[np.float64]

REFERENCE = "reference"
RADII = np.linspace(0.0, 6.0, 200)  # R
BINS = (0.25, 4.0)
PAIR = (0.6, 300.0)  # e and t in d/U, of the paper's figure inelasticposi
# of the reference and of the sweep; of the quick benchmark, and of the full one
_REFERENCE_RTOL = {True: 1e-7, False: 1e-8}
_DENSITY_TOLERANCES = {True: (1e-2, 1e-4, 1e-5), False: tuple(10.0**-k for k in range(2, 8))}
_MANY = 4_000_000  # samples of one more Monte Carlo run of the full benchmark
_CANNOT = (
    (CONSERVATIVE, "it makes densities of the speed alone"),
    (STRAIGHTFORWARD, "not written: it would need further matrices, of m = 1 and on"),
    (SONINE, "a moment expansion: it has no displacement"),
)


def position(effort: Effort) -> list[Record]:
    """<r^2>(t) and kurtosis(t) of both starts, and G(R) at one of the paper's pairs."""
    works: list[Work] = []
    for e in restitutions(effort):
        for start in references.STARTS:
            works += _moment("msd", e, start, effort)
    for start in references.STARTS[: 1 if effort.quick else None]:
        works += _moment("kurtosis", restitutions(effort)[0], start, effort)
    reference = density_reference(*PAIR, _REFERENCE_RTOL[effort.quick])
    works += distribution(*PAIR, reference, effort)
    rows = [reference.record(works[-1].problem), *measure(works, effort)]
    return rows + [
        Record(PRECISION, problem, method, status=NOT_AVAILABLE, note=why)
        for problem in dict.fromkeys(work.problem for work in works)
        for method, why in _CANNOT
    ]


def _moment(quantity: str, e: float, start: str, effort: Effort) -> list[Work]:
    times = references.times("short")
    problem = f"{QUANTITIES[quantity]}, {start}, t <= {times[-1]:.0e}, e = {e:g}"
    exact = references.kept(quantity, e, start, "short")
    scene = Scene(e, NUMBER_DENSITY, initial=start, times=times, outputs=(quantity,))

    def spectral(rtol: float) -> FloatArray:
        return np.asarray(getattr(solve(scene, rtol), quantity))

    def monte_carlo(samples: float, seed: int) -> FloatArray:
        run = methods.particles(e, start, times, samples, seed)
        return np.asarray(getattr(run, quantity).value)

    of = partial(sweep, PRECISION, problem, error=lambda found: relative(found, exact))
    return [
        *of(SPECTRAL, "rtol", TOLERANCES, spectral),
        *of(MONTE_CARLO, "samples", sample_numbers(effort), monte_carlo, seeded=True),
    ]


# -- the distribution ------------------------------------------------------------------------------


@dataclass(frozen=True)
class DensityReference:
    """G(R) at one time.

    Attributes
    ----------
    solution : the tight solve, of the outputs "msd" and "position_density"
    kurtosis : <r^4>/<r^2>^2 by its own equations
    rtol : of the solution
    """

    solution: Any
    kurtosis: float
    rtol: float

    def curve(self, r: FloatArray) -> FloatArray:
        """G at R = r, shape (n_r,)."""
        return np.asarray(self.solution.scaled_position_density(r)[0])

    def error(self, found: FloatArray) -> float:
        """Error of a curve at RADII."""
        exact = self.curve(RADII)
        return float(np.max(np.abs(found - exact)) / exact.max())

    def histogram_error(self, run: Any) -> float:
        """Error of a run's displacement histogram at its only time."""
        root = np.sqrt(self.solution.msd[0])
        found = binned(
            run.displacement_histogram, np.sqrt(run.msd.value[0]), BINS,
            lambda r: self.solution.position_fraction(r * root)[0], np.diff,
        )  # fmt: skip
        return found / float(self.curve(RADII).max())

    def moments_missed(self) -> dict[str, float]:
        """Relative errors of the norm, of <R^2> and of <R^4>, integrated to R = 24."""
        r, weight = panels_between(np.linspace(0.0, 24.0, 49), 24)
        g = self.curve(r) * weight
        exact = {"norm": (0, 1.0), "second": (2, 1.0), "fourth": (4, self.kurtosis)}
        return {name: abs(float(g @ r**p) / value - 1.0) for name, (p, value) in exact.items()}

    def record(self, problem: str) -> Record:
        """The row that says how exact this reference is. It has no run time."""
        missed = self.moments_missed()
        note = "integrals of 1, R^2 and R^4 miss 1, <r^2> and <r^4> by {:.0e}, {:.0e} and {:.0e}"
        return Record(PRECISION, problem, REFERENCE, "rtol", self.rtol, error=max(missed.values()),
                      note=note.format(*missed.values()), extra=missed)  # fmt: skip


def density_reference(e: float, t: float, rtol: float) -> DensityReference:
    """G(R) of a Gaussian start at time t in d/U, to rtol."""

    def at(rtol: float, *outputs: str) -> Any:
        return solve(Scene(e, NUMBER_DENSITY, times=[t], outputs=outputs), rtol)

    kurtosis = float(at(1e-12, "kurtosis").kurtosis[0])
    return DensityReference(at(rtol, "msd", "position_density"), kurtosis, rtol)


def distribution(e: float, t: float, reference: DensityReference, effort: Effort) -> list[Work]:
    """G(R) by the solver, by Monte Carlo, and by the paper's formulas with its constants."""
    scene = Scene(e, NUMBER_DENSITY, times=[t], outputs=("position_density",))

    def spectral(rtol: float) -> FloatArray:
        return np.asarray(solve(scene, rtol).scaled_position_density(RADII)[0])

    def monte_carlo(samples: float, seed: int) -> Any:
        observables = ("displacement_histogram",)
        return methods.particles(e, "gaussian", np.array([t]), samples, seed, observables)

    printed = {
        "eq. gdefi, eta = 1/2": sonine.position_integral,
        "eq. peakg, eta = 0.75": sonine.position_peak,
        "eq. gammatailg, eta = 0.25, gamma = 7.39": sonine.position_tail,
    }
    samples = [*sample_numbers(effort), *(() if effort.quick else (_MANY,))]
    of = partial(sweep, PRECISION, f"G(R), gaussian, t = {t:g}, e = {e:g}", error=reference.error)
    works = of(SPECTRAL, "rtol", _DENSITY_TOLERANCES[effort.quick], spectral)
    works += of(MONTE_CARLO, "samples", samples, monte_carlo, error=reference.histogram_error,
                seeded=True)  # fmt: skip
    for name, form in printed.items():
        works += of(PRINTED, name, (None,), lambda _, form=form: np.asarray(form(RADII)))
    return works
