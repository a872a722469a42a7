"""Measures the constants of kinetics/densities and prints them beside the values used.

Run as a script: python tests/kinetics/measurements/densities.py (a minute).
"""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np

from kinetics import CollisionLaw, Gaussian, Monoenergetic, Scene, SpeedDensity, solve
from kinetics.crosscheck.references import load
from kinetics.densities import conservative, conservative_errors, harmonic, marginal, spectral
from kinetics.densities.grid_density import GridDensity
from kinetics.densities.harmonic import HarmonicProblem, Profile
from kinetics.densities.spectral import solve_spectral

REFERENCES = load()["speed_density"]
STARTS = {"gaussian": Gaussian(), "gamma": SpeedDensity(lambda v: 0.5 * v**2 * np.exp(-v))}


def error_of(profile: Profile, kept: dict[str, Any]) -> float:
    """Largest error of f(v, t) against the references, relative to the maximum of f(., t)."""
    worst = 0.0
    for i, pairs in enumerate(kept.values()):
        v, exact = np.array(pairs).T
        found = profile.at(i, v).real
        top = profile.at(i, np.geomspace(v[0], 100.0 * v[-1], 4000)).real.max()
        worst = max(worst, float(np.max(np.abs(found - exact)) / top))
    return worst


def spectral_error(e: str, start: str, rtol: float) -> tuple[float, float]:
    """Error reached and estimate of the spectral method."""
    kept = REFERENCES[e][start]
    times = np.array([float(t) for t in kept])
    found = solve_spectral(
        HarmonicProblem(CollisionLaw(float(e)), 1.0, STARTS[start], 0, times, rtol)
    )
    assert found is not None
    return error_of(found, kept), found.error_estimate


def measure_rounding() -> None:
    """What rounding leaves, with and without the collisions taken out of the equation."""
    print("spectral._BEST, where nothing but rounding is left: error at rtol = 1e-13")
    worst = max(spectral_error(e, s, 1e-13)[0] for e in REFERENCES for s in STARTS)
    print(f"  used {spectral._BEST:.1e}, measured {worst:.1e}")
    print("spectral_error over its estimate at rtol = 1e-7, 1e-9, 1e-12: below 1")
    for e in REFERENCES:
        for start in STARTS:
            ratios = [np.divide(*spectral_error(e, start, r)) for r in (1e-7, 1e-9, 1e-12)]
            print(f"  e = {e}, {start}: " + ", ".join(f"{ratio:.2f}" for ratio in ratios))
    print("spectral._BEST_STEPPED: error of steps at rtol = 1e-12")
    at_once = spectral._at_once
    spectral._at_once = lambda *a: None
    worst = max(spectral_error(e, "gaussian", 1e-12)[0] for e in ("0.2", "0.7"))
    spectral._at_once = at_once
    print(f"  used {spectral._BEST_STEPPED:.1e}, measured {worst:.1e}")


def slowest_zero(e: float, m: int) -> float:
    """The largest real part, below 0, of a zero z of 1 - E[s^z cos(m chi)]; -1 if none is above."""
    q = CollisionLaw(e).quadrature_for(40.0, m)
    weight = q.weight * q.harmonic(m)
    found = -1.0
    for start in (complex(a, b) for a in (-0.1, -0.4, -0.7, -0.95) for b in range(16)):
        z = start
        for _ in range(12):
            power = np.exp(-z * q.log_loss)
            step = (1.0 - power @ weight) / ((power * q.log_loss) @ weight)
            z -= step / max(1.0, abs(step))
            if not -1.2 < z.real < 0.2:
                break
        if z.real < -1e-6 and abs(1.0 - np.exp(-z * q.log_loss) @ weight) < 1e-8:
            found = max(found, z.real)
    return found


def measure_low_speeds() -> None:
    """How slowly harmonics without their collisions fall at low speeds."""
    print(
        "spectral._SLOWEST, the exponent of harmonics m > 0 at low speeds, of e below _SMALL_RATIO"
    )
    exponents = {(e, m): -slowest_zero(e, m) for e in (0.0, 1e-3, 0.03, 0.1, 0.2, 0.3)
                 for m in (1, 2, 3, 4, 6, 8, 16, 32)}  # fmt: skip
    least = min(exponents, key=lambda case: exponents[case])
    print(f"  used {spectral._SLOWEST}, measured {exponents[least]:.2f} at e, m = {least}")


def measure_maximum() -> None:
    """The least maximum of the isotropic density of ln v, over times."""
    print("harmonic.LEAST_MAXIMUM of the isotropic density of ln v")
    least, times = math.inf, np.geomspace(1e-2, 1e6, 30)
    for e in (0.0, 0.1, 0.4, 0.8):
        found = solve_spectral(
            HarmonicProblem(CollisionLaw(e), 1.0, Gaussian(2.0, 2.0), 0, times, 1e-4)
        )
        assert found is not None
        density = found.density if isinstance(found.density, GridDensity) else found.density.early
        least = min(least, float(density.values.max(axis=1).min()))
    print(f"  used {harmonic.LEAST_MAXIMUM}, measured {least:.2f}")


def measure_spacing() -> None:
    """The error of the conservative method over the square of its spacing, and its sweeps."""
    print(
        "conservative_errors._ERROR[2] + conservative_errors._ERROR_NEAR_ONE/(1 - e)^2, and _SWEEPS"
    )
    v, times = np.geomspace(0.02, 3.0, 200), np.array([0.5, 5.0, 50.0])
    for e in (0.0, 0.3, 0.6, 0.8, 0.9):
        law = CollisionLaw(e)
        exact = solve_spectral(HarmonicProblem(law, 1.0, Gaussian(), 0, times, 1e-8))
        found = conservative.solve_conservative(
            HarmonicProblem(law, 1.0, Gaussian(), 0, times, 1e-9, 1500)
        )
        assert exact is not None
        assert isinstance(found.density, conservative.NodeMasses)
        size = exact.continuous(v).max(axis=1, keepdims=True)
        error = float(np.max(np.abs(found.continuous(v) - exact.continuous(v)) / size))
        used = conservative_errors._ERROR[2] + conservative_errors._ERROR_NEAR_ONE / (1.0 - e) ** 2
        count, arriving = [0], conservative._Axis._arriving

        def counting(axis: Any, moving: Any, n: Any = count, inner: Any = arriving) -> Any:
            n[0] += 1
            return inner(axis, moving)

        conservative._Axis._arriving = counting  # type: ignore[method-assign]
        late = np.array([1e4, 1e6])
        conservative.solve_conservative(
            HarmonicProblem(law, 1.0, Monoenergetic(), 0, late, 1e-12, 400)
        )
        conservative._Axis._arriving = arriving  # type: ignore[method-assign]
        sweeps = count[0] * law.mean_log_loss / (1.0 + math.log1p(1e6))
        print(
            f"  e = {e}: used {used:.1f} and {conservative._SWEEPS:.0f}, measured "
            f"{error / found.density.spacing**2:.1f} and {sweeps:.0f}; error over its estimate "
            f"{error / found.error_estimate:.2f}"
        )


def measure_convolution() -> None:
    """From which size on transforms are quicker than sums."""
    print(f"conservative._DIRECTLY, used {conservative._DIRECTLY}; ms by sums / by transforms")
    kept = conservative._DIRECTLY
    for nodes in (300, 700, 1500, 3000):
        taken = []
        for limit in (10**12, 0):
            conservative._DIRECTLY = limit
            mass = np.full(nodes, 1.0 / nodes)
            axis = conservative._Axis(np.ones(nodes), np.full(nodes // 2, 2.0 / nodes), mass, False)
            axis._arriving(mass)
            start = time.perf_counter()
            for _ in range(20):
                axis._arriving(mass)
            taken.append(50.0 * (time.perf_counter() - start))
        print(f"  {nodes * (nodes // 2)} products: {taken[0]:.2f} / {taken[1]:.2f}")
    conservative._DIRECTLY = kept


def measure_marginal() -> None:
    """The error of one component, relative to the maximum."""
    print("marginal: promised 1e-8 of the maximum for smooth densities; measured")
    x = np.linspace(0.0, 4.0, 41)
    found = marginal.component_density(lambda v: np.exp(-0.5 * v * v) / (2 * np.pi), x, 1.4)
    exact = np.exp(-0.5 * x * x) / math.sqrt(2 * math.pi)
    print(f"  Gaussian: {np.max(np.abs(found - exact)) / exact[0]:.1e}")
    scene = Scene(0.5, 0.5, initial=Gaussian(), times=[3.0], outputs=("speed_density",))
    solution, angle = solve(scene, 1e-11), np.polynomial.legendre.leggauss(60)
    # v = v_x cosh(u): the integral of f(v)/pi over u, in pieces of u
    for v_x in (0.05, 0.3):
        u = 0.25 * (np.arange(24)[:, None] + 0.5 * (angle[0] + 1.0))
        f = solution.speed_density((v_x * np.cosh(u)).ravel())[0].reshape(u.shape)
        exact_one = float((f @ angle[1]).sum() * 0.125 / math.pi)
        found_one = solution.velocity_component_density([v_x])[0, 0]
        print(f"  e = 0.5, v_x = {v_x}: {abs(found_one / exact_one - 1.0):.1e}")


if __name__ == "__main__":
    measure_rounding()
    measure_low_speeds()
    measure_maximum()
    measure_spacing()
    measure_convolution()
    measure_marginal()
