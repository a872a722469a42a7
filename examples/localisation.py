"""The displacement distribution G(R), and what the paper claims of it, from the equation.

python examples/localisation.py [--figure FILE]

G(R) is the radial density of R = r/sqrt(<r^2>). The paper finds, at its four pairs of restitution
and time, one curve that is independent of both, with a Gaussian peak and an exponential tail. The
kinetic equation, solved without a fitted constant, gives for the same pairs:

1. The tail is no pure exponential yet. With p = G/(2 pi R) ~ exp(-(R/b)^n), the local exponent n
   falls from 1.57 ... 1.75 at R = 1 to 1.26 ... 1.52 at R = 4 and 1.20 ... 1.26 at R = 6 (e < 0.9);
   n = 1 would be exponential, 2 a Gaussian. The rate -d ln p/dR keeps growing, from 2.2 ... 2.3 at
   R = 1 to 3.3 ... 4.7 at R = 4 and 3.5 ... 3.9 at R = 6 (e < 0.9): each passes the paper's
   sqrt(2/eta) = 2.83 before R = 2, and no rate is common. Per mean free path instead of
   sqrt(<r^2>), it is 0.86, 1.02 and 0.96 at R = 6, about the 1 of a free flight.
2. The kurtosis <r^4>/<r^2>^2 at the pairs is 2.50, 2.55, 2.41, 2.23. It tends to the 2 of a
   Gaussian like 2 + c/ln t, c = 2.9954, 2.3983, 1.8472, 1.3368, 0.8617, 0.4174 for e = 0.4 ... 0.9;
   at e = 0.4 it is still 2.26 at t = 1e6. The 4 of the paper's integral is nowhere near.
3. G is not independent of e and t. Among the pairs it differs by up to 0.075, a tenth of its
   height, and by a factor 6.8 at R = 4; e = 0.6 and e = 0.4 at their times differ by 0.016,
   which a plot hides. At equal times e = 0.4 and 0.9 differ by 0.62/ln t: 0.088 at t = 1e3,
   0.0092 at 1e30, 0.0009 at 1e300. Only as ln t grows without end do all tend to one curve, the
   Gaussian 2 R exp(-R^2), and n(3), 1.29 and 1.59 at t = 1e3, to 2: 1.98 and 1.997 at 1e300.
   The paper's integral, 4 R K0(2R), stays 0.43 ... 0.53 away.
4. Fitted to the true curve, eq. gammatailg needs eta = 0.13 ... 0.22 and gamma = 8.4 ... 42 on
   2 <= R <= 4 (paper: 0.25 and 7.39; gamma = 2 without a fit), and other values further out:
   its rate is one and that of the curve grows. The peak needs eta = 0.78 ... 0.89 (paper:
   0.75); the Gaussian limit has 1. The integral fits nowhere, whatever its eta.
"""

import sys
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize_scalar
from scipy.special import k0

from kinetics import Scene, Solution, solve
from kinetics.paper import (
    TAIL_ETA,
    position_far_tail,
    position_integral,
    position_peak,
    position_tail,
)

PAIRS = ((0.4, 3000.0), (0.6, 300.0), (0.7, 500.0), (0.9, 1000.0))  # of fig. inelasticposi, d/U
RADII = np.linspace(0.0, 6.0, 601)  # R
TAIL_RADII = np.arange(1.0, 7.0)
RESTITUTIONS = (0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
KURTOSIS_TIMES = np.array([1e2, 1e3, 1e4, 1e6, 1e10, 1e30, 1e100, 1e200, 1e300])  # d/U
LATE_TIMES = np.array([1e3, 1e6, 1e12, 1e30, 1e100, 1e300])
FORMS = {
    "tail": lambda r, eta: position_tail(r, eta, 1.0),
    "far_tail": position_far_tail,
    "peak": position_peak,
    "integral": position_integral,
}
FITS = (("tail", 2.0, 4.0), ("tail", 3.0, 5.0), ("far_tail", 3.0, 5.0), ("peak", 0.0, 1.0),
        ("integral", 0.0, 5.0))  # fmt: skip

GAUSSIAN = 2 * RADII * np.exp(-(RADII**2))
INTEGRAL = 4 * RADII * k0(2 * np.maximum(RADII, 1e-300))  # eq. gdefi with <R^2> = 1


def displacement(e: float, times: np.ndarray | list[float], rtol: float) -> Solution:
    """G(R) at the times."""
    return solve(Scene(e, times=times, outputs=("msd", "kurtosis", "position_density")), rtol)


def largest(difference: np.ndarray) -> np.ndarray:
    """Over the radii."""
    return np.abs(difference).max(axis=-1)


def fitted(g: np.ndarray, form: str, low: float, high: float) -> tuple[float, float, float]:
    """eta, gamma (1 where the form has none) and the rms of ln(form/G) over low <= R <= high."""
    used = slice(*np.searchsorted(RADII, [max(low, 1e-9), high + 1e-9]))

    def logarithm(log_eta: float) -> np.ndarray:
        return np.log(FORMS[form](RADII[used], np.exp(log_eta)) / g[used])

    def spread(log_eta: float) -> float:
        ratio = logarithm(log_eta)
        return float(np.std(ratio) if "tail" in form else np.sqrt(np.mean(ratio**2)))

    best = minimize_scalar(spread, bounds=np.log([0.02, 5.0]), method="bounded").x
    gamma = np.exp(-np.mean(logarithm(best))) if "tail" in form else 1.0
    return float(np.exp(best)), float(gamma), spread(best)


# 1e-7: G(6) is about 1e-7. At the late times G is not asked for far out.
AT_PAIRS = {e: displacement(e, [t], rtol=1e-7) for e, t in PAIRS}
G = {e: found.scaled_position_density(RADII)[0] for e, found in AT_PAIRS.items()}
TAILS = {e: [x[0] for x in found.position_tail(TAIL_RADII)] for e, found in AT_PAIRS.items()}
FITTED = {
    (e, form, low, high): fitted(np.maximum(g, 0.0), form, low, high)
    for e, g in G.items()
    for form, low, high in FITS
}
LATE = {e: displacement(e, LATE_TIMES, rtol=1e-5) for e in (0.4, 0.9)}
LATE_G = {e: found.scaled_position_density(RADII) for e, found in LATE.items()}
LATE_EXPONENTS = {e: found.position_tail([3.0])[0][:, 0] for e, found in LATE.items()}


def kurtosis_over_time(e: float) -> tuple[np.ndarray, float]:
    """Kurtosis at KURTOSIS_TIMES, and the c of its 2 + c/ln t.

    <r^2> and the excess <r^4> - 2 <r^2>^2 both grow like ln t, up to powers of 1/t. Their slopes
    a and b give c = b/a^2.
    """
    outputs = ("msd", "kurtosis", "diffusion_coefficient")
    found = solve(Scene(e, times=KURTOSIS_TIMES, outputs=outputs), rtol=1e-10)
    excess = (found.kurtosis - 2) * found.msd**2
    slope = (excess[-1] - excess[-3]) / np.log(KURTOSIS_TIMES[-1] / KURTOSIS_TIMES[-3])
    return found.kurtosis, float(slope / found.msd_slope[-1] ** 2)


KURTOSIS = {e: kurtosis_over_time(e) for e in RESTITUTIONS}


def draw(path: str) -> None:
    """G(R), its local exponent, the kurtosis, and the differences over time."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 2, figsize=(9.5, 7.2), layout="constrained")
    (curves, exponent), (kurtosis, differences) = axes
    r, inner = RADII[5:], RADII[25:501]
    for e, t in PAIRS:
        curves.plot(r, G[e][5:], label=f"e = {e}, t = {t:g}")
        exponent.plot(inner, AT_PAIRS[e].position_tail(inner)[0][0], label=f"e = {e}, t = {t:g}")
    curves.plot(r, GAUSSIAN[5:], "k:", lw=1, label="$2R\\,e^{-R^2}$")
    curves.plot(r, INTEGRAL[5:], "k-.", lw=1, label="$4R K_0(2R)$")
    curves.plot(r, position_tail(r), "--", color="gray", label="paper, tail")
    curves.plot(r, position_peak(r), "-", color="gray", lw=0.7, label="paper, peak")
    curves.set(yscale="log", ylim=(1e-8, 2), xlabel="$R$", ylabel="$G(R)$")
    curves.legend(fontsize="x-small", frameon=False)
    for n, name in ((2, "Gaussian"), (1, "exponential")):
        exponent.axhline(n, color="black", lw=0.8)
        exponent.text(5, n + 0.02, name, ha="right", fontsize="small")
    exponent.set(xlabel="$R$", ylabel="local exponent $n(R)$", ylim=(0.9, 2.1))
    times = np.log(KURTOSIS_TIMES)
    for k, e in enumerate(RESTITUTIONS):
        values, c = KURTOSIS[e]
        kurtosis.plot(times, values - 2, "o-", ms=3, color=f"C{k}", label=f"e = {e}")
        kurtosis.plot(times, c / times, "--", lw=0.8, color=f"C{k}")
    kurtosis.set(xscale="log", yscale="log", xlabel="$\\ln t$")
    kurtosis.set_ylabel("$\\langle r^4\\rangle/\\langle r^2\\rangle^2 - 2$;  dashed: $c/\\ln t$")
    kurtosis.legend(fontsize="x-small", frameon=False)
    late = np.log(LATE_TIMES)
    differences.plot(late, largest(LATE_G[0.4] - LATE_G[0.9]), "ks-", label="e = 0.4 to 0.9")
    for k, e in enumerate(LATE_G):
        gap = largest(LATE_G[e] - GAUSSIAN), largest(LATE_G[e] - INTEGRAL)
        differences.plot(late, gap[0], "o-", color=f"C{3 * k}", label=f"e = {e} to the Gaussian")
        differences.plot(late, gap[1], "x--", color=f"C{3 * k}", label=f"e = {e} to $4R K_0(2R)$")
    differences.set(xscale="log", yscale="log", xlabel="$\\ln t$")
    differences.set_ylabel("largest difference of $G$ over $R$")
    differences.legend(fontsize="x-small", frameon=False)
    figure.savefig(path, dpi=150)
    plt.close(figure)


def show(values: ArrayLike, form: str = "7.3f") -> str:
    """One row of a table; a dash where the density is below the error of the solution."""
    return "  ".join(f"{x:{form}}" if x == x else "      -" for x in np.asarray(values))


if __name__ == "__main__":
    print("1. Local exponent n of G(R)/R, and its rate, at R =")
    print("                     ", show(TAIL_RADII, "7g"))
    for e, t in PAIRS:
        for name, values in zip(("n", "rate"), TAILS[e], strict=True):
            print(f"  e = {e}, t = {t:4g} {name:4s}", show(values))
        path = AT_PAIRS[e].scene.mean_free_path / AT_PAIRS[e].msd[0] ** 0.5
        print("    per mean free path", show(TAILS[e][1] * path))
    print(f"  paper: n = 1, rate sqrt(2/eta) = {np.sqrt(2 / TAIL_ETA):.2f}\n")

    print("2. <r^4>/<r^2>^2 at the pairs:", show([AT_PAIRS[e].kurtosis[0] for e, _ in PAIRS]))
    print("  t =    ", "  ".join(f"{t:7.0e}" for t in KURTOSIS_TIMES), "  c of 2 + c/ln t")
    for e, (values, c) in KURTOSIS.items():
        print(f"  e = {e}", show(values), f" {c:9.5f}")

    print("\n3. Largest difference of two G(R), and ratio at R = 4")
    for a, b in combinations(G, 2):
        ratio = np.interp(4.0, RADII, G[a]) / np.interp(4.0, RADII, G[b])
        print(f"  e = {a} and {b} at the pairs: {largest(G[a] - G[b]):.4f} {ratio:7.3f}")
    print("  to 2R exp(-R^2):       ", show(largest(np.array(list(G.values())) - GAUSSIAN)))
    print("  to 4R K0(2R):          ", show(largest(np.array(list(G.values())) - INTEGRAL)))
    print("  t =                    ", "  ".join(f"{t:7.0e}" for t in LATE_TIMES))
    print("  e = 0.4 and 0.9        ", show(largest(LATE_G[0.4] - LATE_G[0.9]), "7.5f"))
    for e, g in LATE_G.items():
        print(f"  e = {e} to 2R exp(-R^2)", show(largest(g - GAUSSIAN), "7.5f"))
        print(f"  e = {e} to 4R K0(2R)   ", show(largest(g - INTEGRAL), "7.5f"))
        print(f"  e = {e}, n at R = 3    ", show(LATE_EXPONENTS[e]))

    print("\n4. The printed forms fitted to G(R): eta, gamma, rms of ln(form/G)")
    for form, low, high in FITS:
        print(f"  {form}, {low:g} <= R <= {high:g}")
        for e, t in PAIRS:
            eta, gamma, residual = FITTED[e, form, low, high]
            factor = f"{gamma:8.2f}" if "tail" in form else "       -"
            print(f"    e = {e}, t = {t:4g}  {eta:7.4f} {factor}  {residual:7.3f}")
    print("  paper: eta 0.25 and gamma 7.39 in the tail, eta 0.75 at the peak")
    if len(sys.argv) == 3 and sys.argv[1] == "--figure":
        draw(sys.argv[2])
