"""Anybody's particle data: files and tables, as tracks, as sums over independent groups.

    file or arrays -> `formats` -> `table` -> `tracks` -> `sample`

- `options`: what a user says about data; `columns`: names of columns, and their units
- `formats`: which function reads which file: `text_table` (CSV), `containers` (NumPy, MATLAB,
  Parquet, HDF5), `h5md`, `trajectories` (LAMMPS, XYZ, GSD); `box` unwraps, `missing` reads masks,
  `memory` bounds sizes
- `table`: one row for each particle at each time; `tracks`: tracers at common times
- `sample`: sums over groups; `ensembles`: those of runs of `particles`

Begin with `reading.read_sample`.
"""
