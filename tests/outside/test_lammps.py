"""Tracks of LAMMPS agree with the theory of hard disks, and are read as LAMMPS writes them.

`lorentz.lammps` is the input, `lammps_tracks.py` runs it; the file beside them has 1,000 tracers.
LAMMPS knows no hard disks: a contact is a short spring and dashpot, whose restitution, measured
head on by `lammps_tracks.py`, is 0.699 to 0.704.
"""

import lammps_tracks

from kinetics import compare, fit


def test_its_tracks_agree_with_the_theory_of_hard_disks() -> None:
    result = compare(
        lammps_tracks.FILE,
        lammps_tracks.RESTITUTION,
        lammps_tracks.DENSITY,
        scatterers="hard disks",
    )
    assert result.verdict == "agrees"
    assert result.samples == lammps_tracks.TRACERS
    assert set(result.rows["time"]) == set(lammps_tracks.TIMES)


def test_restitution_and_density_are_found() -> None:
    """Within 3 of their errors."""
    result = fit(lammps_tracks.FILE, scatterers="hard disks")
    restitution = result.parameters["restitution"]
    density = result.parameters["number_density"]
    assert abs(restitution.value - lammps_tracks.RESTITUTION) < 3.0 * restitution.error
    assert abs(density.value - lammps_tracks.DENSITY) < 3.0 * density.error
