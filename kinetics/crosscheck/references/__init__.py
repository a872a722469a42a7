"""Reference values in high precision, for the tests and for the benchmark.

`references.json` holds them, by name and then by restitution as text; `load` and `kept` read it.
The formulas that made it are in ``tests/references``, and share nothing with the solver;
``python tests/references/make.py FILE`` makes it again. The tables:

- "scaled_density": F(c) of the scaling state, lists c and F;
- "evolution": averages of six starts at the times TIMES of ``cooling.py`` in d/U: "v^p" in U^p,
  "collisions", "msd" in d^2; "beam": <v^2 cos(m phi)> of a beam of speed U at these, by m;
- "displacement": "square" and "fourth", <r^2>/l^2 and <r^4>/l^4 at the times "T" in l/U;
- "speed_density": f(v, t) as pairs [v, f], by start and time, in units of l and U;
- "benchmark": v0, a2, <r^2>, kurtosis by start, quantity and horizon, see `kept`.
"""

import json
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

#: Mean free path in d. Derived: 1/(2 n) of the paper's number density n = 0.04 d^-2.
MEAN_FREE_PATH = 12.5
#: Initial states of the table "benchmark", those of the paper.
STARTS = ("gaussian", "monoenergetic")
#: Name of a horizon -> its first and last time in d/U, and how many times it has, log-spaced.
HORIZONS = {"short": (0.1, 1e2, 25), "long": (1.0, 1e8, 25)}


@cache
def load() -> dict[str, Any]:
    """Every table, by name."""
    text = files(__package__).joinpath("references.json").read_text(encoding="utf-8")
    return dict(json.loads(text))


def times(horizon: str) -> FloatArray:
    """Output times of the table "benchmark" in d/U, shape (25,)."""
    first, last, count = HORIZONS[horizon]
    return np.geomspace(first, last, count)


def kept(quantity: str, restitution: float, start: str, horizon: str) -> FloatArray:
    """Values at `times(horizon)`, shape (25,): "thermal_speed" in U, "a2"; of the short horizon
    also "msd" in d^2 and "kurtosis". Number density 0.04, so that l = MEAN_FREE_PATH.

    KeyError for what is not kept.
    """
    return np.array(load()["benchmark"][repr(float(restitution))][start][quantity][horizon])
