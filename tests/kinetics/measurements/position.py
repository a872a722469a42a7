"""Measures the constants of the wave numbers of G(R) again: `kinetics/position`.

Each constant is halved and doubled, or moved by less where that is much. Questions that differ in
law, start, time and tolerance are asked each time. For each value the table has

converged : how many questions are answered within their tolerance;
worst : the largest ratio of the error (against the reference, less the error of that) and the error
    estimate, of these: below 1 the estimate is honest;
question : the index of that one;
work : multiplications of all answers over those with the constants as they are.

References are answers at a fiftieth of the tolerance. position.json has the last results, made by

    python -m tests.kinetics.measurements.position FILE [CONSTANT ...]     6 minutes

Its rows "without logarithms" were measured before tails at e = 0 had logarithms of K; MAX_WORK and
WORK_FACTOR_PER_DIGIT have not been measured yet.
"""

from __future__ import annotations

import json
import math
import sys
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from kinetics import (
    Beam,
    CollisionLaw,
    Monoenergetic,
    Scene,
    SpeedDensity,
    SpeedSamples,
    SpeedTable,
    solve,
)
from kinetics.numerics import FloatArray
from kinetics.position import power_tail, sweep

FILE = Path(__file__).with_suffix(".json")
RADII = np.concatenate([np.geomspace(1e-3, 0.05, 5), np.linspace(0.08, 6.0, 200)])
REFERENCE_OVER_TOLERANCE = 0.02
SPHERES = {"number_density": 1.0 / (12.5 * math.pi), "dimension": 3}
TRIANGLE = SpeedTable([0.0, 0.5, 1.0, 2.0], [0.0, 0.8, 0.8, 0.0])
SAMPLED = CollisionLaw.from_samples([0.4, 0.6], [0.3, 0.5], [0.2, -0.3], dimension=3)


def _gamma(v: FloatArray) -> FloatArray:
    return np.asarray(0.5 * v * v * np.exp(-v))


#: Questions: scene, times in d/U, tolerance.
QUESTIONS: list[tuple[dict[str, Any], list[float], float]] = [
    ({"restitution": 0.7}, [300.0], 1e-6),
    ({"restitution": 0.7}, [1.0, 10.0, 30.0], 1e-4),
    ({"restitution": 0.5}, [30.0], 1e-5),
    ({"restitution": 0.3}, [37.5], 1e-4),
    ({"restitution": 0.2}, [100.0], 1e-3),
    ({"restitution": 0.9}, [1.0, 1e5], 1e-5),
    ({"restitution": 1.0}, [300.0], 1e-6),
    ({"restitution": 0.7, "initial": Monoenergetic()}, [300.0], 1e-6),
    ({"restitution": 0.7, "initial": Monoenergetic()}, [125.0], 1e-3),
    ({"restitution": 1.0, "initial": Monoenergetic()}, [300.0], 1e-6),
    ({"restitution": 0.7, "initial": SpeedSamples([0.5, 1.0, 1.7])}, [300.0], 1e-3),
    ({"restitution": 0.6, "initial": TRIANGLE}, [6.0], 1e-3),
    ({"restitution": 0.7, "initial": SpeedTable([0.0, 1.0], [1.0, 1.0])}, [300.0], 1e-3),
    ({"restitution": 0.9, "initial": SpeedDensity(_gamma)}, [100.0], 1e-6),
    ({"restitution": 0.7, "initial": Beam(0.3)}, [300.0], 1e-5),
    ({"restitution": 0.7, **SPHERES}, [300.0], 1e-6),
    ({"restitution": 0.0, **SPHERES}, [500.0], 1e-5),
    ({"restitution": 0.7, "initial": TRIANGLE, **SPHERES}, [100.0], 1e-3),
    ({"restitution": SAMPLED, "number_density": SPHERES["number_density"]}, [200.0], 1e-3),
    ({"restitution": 0.7, "mass_ratio": 0.1}, [300.0], 1e-5),
    ({"restitution": 0.7, "scatterers": "hard disks"}, [100.0], 1e-3),
    ({"restitution": 0.0}, [100.0], 1e-4),
]

#: Values that are tried.
CONSTANTS: dict[str, list[float]] = {
    "MAX_WORK": [1.5e10, 6e10],
    "WORK_FACTOR_PER_DIGIT": [1.0, 2.0],
    "MAX_WORK_OF_SHARP": [5e8, 2e9],
    "ERROR_SHARE_OF_PANELS": [0.1, 0.4],
    "MAX_ERROR_OF_TAIL_DATA": [5e-6, 2e-5, 2e-4],
    "PANEL_RATIO": [1.25, 1.35, 1.7, 2.0],
    "MAX_REFINEMENTS": [2, 8],
    "UNSEEN_SAFETY": [10.0, 40.0],
    "FRONTS_FADE_AT": [6.0, 24.0],
    "SPEED_NEAR_REST": [5e-5, 2e-4],
    "FITTED_ABOVE": [0.15, 0.2, 0.45, 0.6],
    "MAX_TERMS": [7, 10, 28],
    "TURN_AT": [6.0, 24.0],
    "POINTS_BEYOND_TURN": [8, 32],
    "POINTS_BEFORE_TURN": [60, 240],
}


@dataclass(frozen=True)
class Answer:
    """G(R) at `RADII`, its error estimate, and about the multiplications that it took."""

    density: FloatArray
    error_estimate: float
    work: float


def answer(question: int, rtol: float) -> Answer:
    """Solve one of the questions."""
    arguments, times, _ = QUESTIONS[question]
    solution = solve(Scene(times=times, outputs=("position_density",), **arguments), rtol=rtol)
    systems = solution.stats["systems"]
    work = sum(number * int(size) ** 3 for size, number in systems.items())
    density = solution.scaled_position_density(RADII)
    return Answer(density, solution.stats["position_density_error"], work)


def measure(references: list[Answer]) -> tuple[int, float, int, float]:
    """Return the row of the table for the constants as they are set now, with the work itself."""
    n_converged = 0
    worst = 0.0
    worst_question = -1
    work = 0.0
    for i, (_, _, tolerance) in enumerate(QUESTIONS):
        result = answer(i, tolerance)
        work += result.work
        if result.error_estimate > tolerance:
            continue
        n_converged += 1
        error = float(np.abs(result.density - references[i].density).max())
        ratio = (error - min(references[i].error_estimate, tolerance)) / result.error_estimate
        if ratio > worst:
            worst = ratio
            worst_question = i
    return n_converged, round(worst, 2), worst_question, work


def main() -> None:
    """Measure all constants, or those that are named, and print and write the table."""
    warnings.simplefilter("ignore")
    file = Path(sys.argv[1]) if len(sys.argv) > 1 else FILE
    names = sys.argv[2:] or list(CONSTANTS)
    references = []
    for i, (_, _, tolerance) in enumerate(QUESTIONS):
        references.append(answer(i, REFERENCE_OVER_TOLERANCE * tolerance))
    as_it_is = measure(references)
    rows = {"as it is": (*as_it_is[:3], 1.0)}
    print("as it is", rows["as it is"], flush=True)
    for name in names:
        modules = [module for module in (sweep, power_tail) if hasattr(module, name)]
        original = getattr(modules[0], name)
        for value in CONSTANTS[name]:
            for module in modules:
                setattr(module, name, value)
            row = measure(references)
            key = f"{name} {original:g} -> {value:g}"
            rows[key] = (*row[:3], round(row[3] / as_it_is[3], 2))
            print(key, rows[key], flush=True)
            write_table(rows, file)
        for module in modules:
            setattr(module, name, original)


def write_table(rows: dict[str, tuple[int, float, int, float]], file: Path) -> None:
    """Write the table as JSON, one row a line."""
    lines = [f"{json.dumps(key)}: {json.dumps(row)}" for key, row in rows.items()]
    file.write_text("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    main()
