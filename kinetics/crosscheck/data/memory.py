"""Sizes are checked before memory is asked for, and while compressed data are unpacked."""

from __future__ import annotations

import os

from kinetics.crosscheck.data.options import refuse_data

#: Data may have at most this fraction of the memory: what is made of them takes some copies.
FRACTION_OF_MEMORY = 1 / 6
#: Memory that is assumed where the system does not say it: what most machines have.
ASSUMED_MEMORY = 16e9
#: What deflate, the densest of the compressions that are read, makes smaller at most: 1032 times.
MAX_COMPRESSION = 1100.0
#: Bytes that a small file may declare whatever it stores.
SMALL = 1e6


def available_memory() -> float:
    """Return the memory of this machine in bytes."""
    if os.name != "posix":
        return ASSUMED_MEMORY
    return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))


def require_memory(where: str, declared: float, stored: float | None = None) -> None:
    """Raise InputError for data that do not fit, or that are more than is stored.

    Parameters
    ----------
    where : names the source in messages
    declared : bytes that the data are said to be
    stored : bytes in the file; None if these are not known
    """
    if stored is not None and declared > MAX_COMPRESSION * stored + SMALL:
        refuse_data(where, f"{stored:.2g} bytes that declare {declared:.2g}", "a whole file")
    limit = FRACTION_OF_MEMORY * available_memory()
    if declared > limit:
        allowed = f"at most a sixth of the memory, {limit:.2g}"
        refuse_data(where, f"data of {declared:.2g} bytes", allowed)
