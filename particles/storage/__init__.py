"""Runs on disk: the file of a run, its journal while the run goes on, and when each is written.

May import: the rest of the package except `particles.simulate`.
Begin reading with `file`, which documents the layout of a saved run.
"""
