"""Names that have moved to `kinetics.crosscheck.cli.options`."""

from kinetics.crosscheck.cli.options import *  # noqa: F403
