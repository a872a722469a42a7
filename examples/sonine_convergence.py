"""The Sonine expansion at orders 1 to 20, beside the exact cooling rate, a2 and diffusion.

python examples/sonine_convergence.py

At order 1 these are the paper's formulas. For e < 0.75 higher orders lead away from the exact
values (odd ones have no real solution there); closer to 1 they oscillate about the exact
values and approach them. Only the elastic diffusion coefficient converges.
"""

from typing import Any

from kinetics import ScalingSolution, sonine

RESTITUTIONS = (0.4, 0.7, 0.8, 0.9, 0.99)
ORDERS = tuple(range(1, 21))
SHOWN = (1, 2, 3, 4, 5, 6, 8, 10, 12, 14, 16, 18, 20)


def exact_diffusion(restitution: float) -> float:
    """D_e/(l v0) = <c>/(2 (1 - <cos chi>)) of the scaled state."""
    exact = ScalingSolution(restitution)
    return exact.moment(1) / (2 * exact.law.harmonic_decay_rate(0, 1))


EXACT = {
    e: (ScalingSolution(e).cooling_rate, ScalingSolution(e).a2, exact_diffusion(e))
    for e in RESTITUTIONS
}
SERIES = {
    (e, n): (state.cooling_rate, state.a2, sonine.diffusion_of_order(e, n).coefficient)
    for e in RESTITUTIONS
    for n in ORDERS
    for state in [sonine.scaled_state(e, n)]
}
# The elastic gas keeps its Gaussian: D = (3/8) l <|v|> = 0.3323 l v0.
ELASTIC = {n: sonine.diffusion_of_order(1.0, n).coefficient for n in ORDERS}
ELASTIC_EXACT = 3 / 8 * 0.8862269254527580  # sqrt(pi)/2


def show(row: Any) -> str:
    """One row of the table; a dash where there is no real solution."""
    return "  ".join(f"{x:8.4f}" if x == x else "       -" for x in row)


if __name__ == "__main__":
    for number, title in ((0, "h"), (1, "a2"), (2, "D_e/(l v0)")):
        heads = [f"e = {e:g}" for e in RESTITUTIONS] + (["e = 1"] if number == 2 else [])
        print(f"{title:10s}", "  ".join(f"{head:>8s}" for head in heads))
        for n in SHOWN:
            row = [SERIES[e, n][number] for e in RESTITUTIONS]
            print(f"  n = {n:<5d}", show(row + ([ELASTIC[n]] if number == 2 else [])))
        row = [EXACT[e][number] for e in RESTITUTIONS]
        print("  exact    ", show(row + ([ELASTIC_EXACT] if number == 2 else [])))
