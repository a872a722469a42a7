"""Names that have moved to `kinetics.crosscheck.cli.options`."""

from kinetics.crosscheck.cli.options import progress  # noqa: F401
