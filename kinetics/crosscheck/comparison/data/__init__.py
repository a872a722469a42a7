"""Particle data as they come: files of several formats, read in pieces of rows.

For: turning a file of any format into `Rows` (one row is one tracer at one time), checking them,
and reducing them to one `Sample`. A new format is one file here with a function `read`, and one row
of the table `columns.FORMATS`; formats of frames share `frames.py`. May import:
`comparison.sample`, `comparison.reduction` and `kinetics.errors`; nothing of the theory. Begin
reading at `read.py`, then `columns.py`.
"""
