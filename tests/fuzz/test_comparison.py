"""Comparisons of small and odd data: a verdict for each observable, or a refusal."""

import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from fuzzing import broken, examples, extremes, fuzz, mostly, restitutions, result_or_refusal
from hypothesis import strategies as st

from kinetics.crosscheck.compare import compare_data

_number = mostly(st.floats(-3.0, 3.0), extremes())
_rows = st.lists(st.tuples(st.sampled_from([0.0, 0.0, 2.0, 1e3]), _number, _number), min_size=1)

DATA = st.fixed_dictionaries(
    {
        "rows": st.none() | st.none() | _rows,
        "seed": st.integers(0, 5),
        "name": mostly(st.just("data.csv"), st.sampled_from(["no.csv", "data.h5"]) | broken()),
        "restitution": mostly(restitutions()),
        "number_density": mostly(st.sampled_from([0.04, 0.1]), extremes() | broken()),
        "initial": mostly(st.sampled_from(["auto", "gaussian", "monoenergetic", "data"])),
        "positions": mostly(st.sampled_from(["auto", "displacement", "absolute"])),
        "speed_unit": mostly(st.sampled_from([1.0, "data"]), extremes() | broken()),
        "diameter": mostly(st.just(1.0), extremes() | broken()),
        "explain": st.just(False),
    }
)


@examples(6)
def test_comparisons(tries: int) -> None:
    fuzz(check_comparison, DATA, tries)


def gaussian_rows(seed: int) -> list[tuple[float, ...]]:
    """Twenty tracers that do not collide, at two times: (time, x, y, vx, vy) each."""
    v = np.random.default_rng(seed).standard_normal((20, 2))
    return [(t, *(t * v[k]), *v[k]) for t in (0.0, 0.5) for k in range(20)]


def check_comparison(asked: dict[str, Any]) -> None:
    arguments = {k: v for k, v in asked.items() if k not in ("rows", "seed", "name")}
    given = asked["rows"]
    rows = gaussian_rows(asked["seed"]) if given is None else [(*row, 1.0, row[1]) for row in given]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "data.csv")
        lines = [",".join(repr(float(x)) for x in row) for row in rows]
        path.write_text("\n".join(["time,x,y,vx,vy", *lines, ""]))
        data = asked["name"]
        if isinstance(data, str):
            data = Path(folder, data) if data.endswith((".csv", ".h5")) else data
        found = result_or_refusal(compare_data, data, **arguments)
    if found is None:
        return
    assert found.verdict is not None
    document = found.to_dict()
    for test in document["tests"]:
        assert 0.0 <= test["p_value"] <= 1.0
        assert math.isfinite(test["chi_square"])
