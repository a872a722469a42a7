"""The command `compare`, from where it still is."""

from kinetics.crosscheck.comparison.command import compare

__all__ = ["compare"]
