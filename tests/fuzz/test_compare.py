"""Comparisons of small and odd data: a verdict with its p-values, or a refusal."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from fuzzing import broken, extremes, fuzz, mostly, restitutions, tried
from hypothesis import strategies as st

from kinetics import compare

number = mostly(st.floats(-3.0, 3.0), st.sampled_from([0.0, 1e150, 1e308, float("nan")]))
odd = st.lists(st.tuples(st.sampled_from([0.0, 0.0, 2.0, 1e3]), number, number), min_size=1)
TOLD = {
    "restitution": restitutions,
    "number_density": mostly([0.04, 0.1], extremes),
    "initial": mostly(["auto", "gaussian", "monoenergetic", "data"]),
    "positions": mostly(["auto", "displacement", "absolute"]),
    "speed_unit": mostly([1.0, "data"], extremes),
    "diameter": mostly([1.0], extremes),
}


@fuzz(
    6, rows=st.none() | odd, seed=st.integers(0, 5), told=st.fixed_dictionaries(TOLD),
    name=mostly(["data.csv"], st.sampled_from(["no.csv", "data.h5"]) | broken),
)  # fmt: skip
def test_comparisons(rows: Any, seed: int, told: Any, name: Any) -> None:
    # twenty tracers that do not collide, at two times
    v = np.random.default_rng(seed).standard_normal((20, 2))
    free = [(t, *(t * v[k]), *v[k]) for t in (0.0, 0.5) for k in range(20)]
    lines = free if rows is None else [(*row, 1.0, row[1]) for row in rows]
    text = "\n".join(",".join(repr(float(x)) for x in line) for line in lines)
    Path("data.csv").write_text(f"time,x,y,vx,vy\n{text}\n")
    found = tried(compare, name, **told, explain=False)
    if found is not None:
        document = json.loads(found.to_json())
        assert document["verdict"]
        assert all(0.0 <= test["p_value"] <= 1.0 for test in document["tests"])
