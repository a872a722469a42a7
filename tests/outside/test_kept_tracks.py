"""Tracks that programs of others kept agree with the theory of hard disks.

Three programs that share no line with the package: `lorentz.c`, LAMMPS (`lorentz.lammps`) and
DynamO (`lorentz.dynamo.xml`). The files have 1,000 of the tracers of each, as
`outside_tracks.py`, `lammps_tracks.py` and `dynamo_tracks.py` write them.
"""

from pathlib import Path

import dynamo_tracks
import lammps_tracks
import outside_tracks
import pytest

from kinetics import compare, fit

DENSITY = outside_tracks.DENSITY
RESTITUTION = outside_tracks.RESTITUTION
of_all_programs = pytest.mark.parametrize(
    "file",
    [outside_tracks.FILE, lammps_tracks.FILE, dynamo_tracks.FILE],
    ids=["a program in C", "LAMMPS", "DynamO"],
)


@of_all_programs
def test_they_agree_with_the_theory_of_hard_disks(file: Path) -> None:
    result = compare(file, RESTITUTION, DENSITY, scatterers="hard disks")
    assert result.verdict == "agrees"
    assert result.samples == 1000


@of_all_programs
def test_their_restitution_and_density_are_found(file: Path) -> None:
    """Within 3 of their errors."""
    parameters = fit(file, scatterers="hard disks").parameters
    restitution = parameters["restitution"]
    density = parameters["number_density"]
    assert abs(restitution.value - RESTITUTION) < 3.0 * restitution.error
    assert abs(density.value - DENSITY) < 3.0 * density.error


def test_times_of_lammps_are_those_that_its_file_states() -> None:
    result = compare(lammps_tracks.FILE, RESTITUTION, DENSITY, scatterers="hard disks")
    assert set(result.rows["time"]) == set(lammps_tracks.TIMES)


def test_tracers_within_a_soft_contact_of_lammps_are_named_by_their_numbers() -> None:
    """Three are seen while they turn about, and are faster at the next time."""
    result = compare(lammps_tracks.FILE, RESTITUTION, DENSITY, scatterers="hard disks")
    (text,) = [warning for warning in result.warnings if "impossible" in warning]
    assert "tracer 20259 at time 3" in text
