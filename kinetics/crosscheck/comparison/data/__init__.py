"""Particle data as they come: files of several formats, read in pieces of rows.

For: turning a file of any format into `Rows` (one row is one tracer at one time), checking them,
and reducing them to one `Sample`; positions in a periodic box are made continuous by
`unwrapping.py`, tables of averages become a sample in `averages.py`, and units that a file states
are read by `stated_units.py`. A new format is one file here with a function `read`, and one row of
the table `columns.FORMATS`; formats of frames share `frames.py`. May import: `comparison.sample`,
`comparison.reduction`, `comparison.result`, `kinetics.errors` and `kinetics.validation`; nothing of
the theory. Begin reading at `read.py`, then `columns.py`.
"""
