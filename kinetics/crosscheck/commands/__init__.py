"""The commands `lorentz solve`, `simulate` and `derive`, and the options that commands share.

The commands report, compare, bench and stress are in the folders of their work, in `command.py`.
These modules import only click and the table of outputs; what a command needs is imported when it
runs, so that `lorentz --help` stays quick. Begin reading with `solve.py`.
"""
