"""``python tests/references/make.py FILE [TABLE ...]``: makes the reference values again.

The modules beside this one are the formulas, in mpmath; they share nothing with the solver. Begin
reading at `collision`, the averages of one collision, which the others use. FILE is the package's
``kinetics/crosscheck/references/references.json``, or another. Without a table's name all of them
are made. A table that is made replaces that of FILE; other tables of FILE stay. All of them take
about 45 minutes of one processor where gmpy2 is installed, and several times as long without it;
"benchmark" alone takes two minutes.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import collision
import cooling
import densities
import displacement
import mpmath as mp

from kinetics.crosscheck import references

SIX_STARTS, TWO_STARTS = list(cooling.STARTS), ["monoenergetic", "gaussian"]


def evolution() -> dict[str, Any]:
    """All six starts at two restitutions, both starts of the paper at the others."""
    table = {}
    for e in (0.0, 0.05, 0.4, 0.7, 0.9, 0.99):
        names, powers = TWO_STARTS, [1.0, 2.0, 2.5, 4.0, 6.0]
        if e in (0.05, 0.7):
            names, powers = SIX_STARTS, [1.0, 2.0, 4.0]
        table[str(e)] = cooling.evolution(e, names, powers, displacement.Early(e, 2))
    return table


def benchmark() -> dict[str, Any]:
    """v0, a2, <r^2> and kurtosis at `references.times`."""
    table: dict[str, Any] = {}
    for e in (0.0, 0.2, 0.5, 0.7, 0.95, 0.99):
        line = cooling.Line(e, 0, "-0.6")
        table[str(e)] = {
            start: cooling.thermal(e, start, line) | displacement.short(e, start)
            for start in references.STARTS
        }
    return table


TABLES: dict[str, tuple[int, Callable[[], dict[str, Any]]]] = {
    # name: digits that mpmath works with, and what makes it
    "scaled_density": (40, collision.scaled_density_table),
    "evolution": (40, evolution),
    "beam": (40, lambda: {str(e): cooling.beam(e) for e in (0.2, 0.7)}),
    "displacement": (
        40,
        lambda: (
            {"T": displacement.TIMES}
            | {str(e): displacement.displacement(e) for e in displacement.RESTITUTIONS}
        ),
    ),
    "speed_density": (32, lambda: {str(e): densities.densities(e) for e in densities.RESTITUTIONS}),
    "benchmark": (40, benchmark),
}


def as_text(tables: dict[str, Any]) -> str:
    """JSON with one line for each restitution of each table."""
    blocks = []
    for name, table in tables.items():
        rows = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in table.items()]
        blocks.append(f"{json.dumps(name)}: {{\n" + ",\n".join(rows) + "\n}")
    return "{\n" + ",\n".join(blocks) + "\n}\n"


def main(arguments: list[str]) -> None:
    """Make the named tables, or all, and write the file after each."""
    if not arguments or set(arguments[1:]) - set(TABLES):
        sys.exit(f"usage: python tests/references/make.py FILE [{'|'.join(TABLES)} ...]")
    path = Path(arguments[0])
    tables = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    for name in arguments[1:] or TABLES:
        digits, make = TABLES[name]
        mp.mp.dps = digits
        tables[name] = make()
        path.write_text(as_text(tables), encoding="utf-8")
        print(name, flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
