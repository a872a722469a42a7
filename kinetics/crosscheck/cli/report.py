"""The command `report`, from where it still is."""

from kinetics.crosscheck.report.command import report

__all__ = ["report"]
