"""The table of outputs: every row can be asked for, and a new output is one row."""

import pytest

from kinetics import Beam, Scene, solve
from kinetics.moments.averages import parts_of
from kinetics.moments.backward import Observable
from kinetics.outputs import OUTPUTS, described

TIMES = [0.0, 1.0, 100.0]


@pytest.mark.parametrize("name", OUTPUTS)
def test_every_row(name: str) -> None:
    """Array or method under the name of the row, of the shape that the row says."""
    row = OUTPUTS[name]
    solution = solve(Scene(0.7, initial=Beam(), times=TIMES, outputs=name, harmonics=1), rtol=1e-3)
    assert row.name == name
    assert row.description
    assert row.shape[0] == "n_times"
    found = getattr(solution, name)
    if not (parts := parts_of(name, 2)):
        assert callable(found)
        assert list(solution.values) == []
    else:
        assert tuple(solution.values) == row.names
        expected = [{"n_times": len(TIMES), "d": 2}[n] for n in row.shape]
        assert all(solution.values[n].shape == tuple(expected) for n in row.names)
        assert all(isinstance(part.observable, Observable) for part in parts)
    assert all(described(n, 2)[0] for n in row.names)
    steps = {step.part: step.solved for step in solution.plan}
    assert steps[row.step]
