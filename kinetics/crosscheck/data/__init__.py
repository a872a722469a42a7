"""Anybody's particle data: files and tables, as tracks, as sums over independent groups.

    file or arrays -> `formats` -> `table` -> `gather` -> `tracks` -> `sample`

- `options`: what a user says about data; `columns`: names of columns, and their units; `arrays`:
  types of arrays
- `formats`: which function reads which file: `text_table` (CSV), `containers` (NumPy, MATLAB,
  Parquet, HDF5), `h5md`, `trajectories` (LAMMPS, XYZ, GSD); `frames` unwraps positions, `missing`
  reads masks, `memory` bounds sizes
- `table`: one row for each particle at each time; `gather`: tracers at common times; `tracks`:
  their displacements
- what data cannot be: `motion` (faster, or further, than physics allows), `differences` (velocities
  made of positions), `identity` (rows of no tracer), `ends` (fast tracks end first)
- `sample`: sums over groups; `frame_pairs`: of displacements between frames, which positions alone
  know; `ensembles`: those of runs of `particles`
- `averages`: tables of averages, as papers have them

Begin with `reading.read_sample`.
"""
