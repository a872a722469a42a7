"""Tracks of a program in C that shares no line with the package agree with its theory.

`lorentz.c` is the program, `outside_tracks.py` runs it; the file beside them has 1,000 of its
tracers.
"""

import shutil

import numpy as np
import outside_tracks
import pytest

from kinetics import compare, fit


def test_its_tracks_agree_with_the_theory_of_hard_disks() -> None:
    result = compare(
        outside_tracks.FILE,
        outside_tracks.RESTITUTION,
        outside_tracks.DENSITY,
        scatterers="hard disks",
    )
    assert result.verdict == "agrees"
    assert result.samples == 1000


def test_restitution_and_density_are_found() -> None:
    """Within 3 of their errors."""
    parameters = fit(outside_tracks.FILE, scatterers="hard disks").parameters
    restitution = parameters["restitution"]
    density = parameters["number_density"]
    assert abs(restitution.value - outside_tracks.RESTITUTION) < 3.0 * restitution.error
    assert abs(density.value - outside_tracks.DENSITY) < 3.0 * density.error


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
