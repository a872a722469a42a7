"""Moved to `files`."""

from kinetics.crosscheck.files import dumps, plain

__all__ = ["dumps", "plain"]
