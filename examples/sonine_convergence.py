"""The Sonine expansion at orders 1 to 20, beside the exact cooling rate and a2.

python examples/sonine_convergence.py

At order 1 these are the paper's formulas. For e < 0.75 higher orders lead away from the exact
values (odd ones have no real solution there); closer to 1 they oscillate about the exact
values and approach them.
"""

from typing import Any

from kinetics import ScalingSolution, sonine

RESTITUTIONS = (0.4, 0.7, 0.8, 0.9, 0.99)
ORDERS = tuple(range(1, 21))
SHOWN = (1, 2, 3, 4, 5, 6, 8, 10, 12, 14, 16, 18, 20)


EXACT = {e: (ScalingSolution(e).cooling_rate, ScalingSolution(e).a2) for e in RESTITUTIONS}
SERIES = {
    (e, n): (state.cooling_rate, state.a2)
    for e in RESTITUTIONS
    for n in ORDERS
    for state in [sonine.scaled_state(e, n)]
}


def show(row: Any) -> str:
    """One row of the table; a dash where there is no real solution."""
    return "  ".join(f"{x:8.4f}" if x == x else "       -" for x in row)


if __name__ == "__main__":
    for number, title in ((0, "h"), (1, "a2")):
        heads = [f"e = {e:g}" for e in RESTITUTIONS]
        print(f"{title:10s}", "  ".join(f"{head:>8s}" for head in heads))
        for n in SHOWN:
            print(f"  n = {n:<5d}", show(SERIES[e, n][number] for e in RESTITUTIONS))
        print("  exact    ", show(EXACT[e][number] for e in RESTITUTIONS))
