"""A program in C that shares no line with the package is asked again."""

import shutil

import numpy as np
import outside_tracks
import pytest

from kinetics import fit


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
@pytest.mark.parametrize(("restitution", "density"), [(0.4, 0.02), (0.9, 0.04), (0.6, 0.05)])
def test_the_program_asked_again(restitution: float, density: float) -> None:
    columns = outside_tracks.columns_of(outside_tracks.run_program(restitution, density, seed=2))
    result = fit(columns, scatterers="hard disks")
    assert result.verdict == "agrees"
    found = result.parameters["restitution"]
    assert abs(found.value - restitution) < 3.5 * found.error
    assert np.isfinite(result.parameters["number_density"].error)
