"""Sizes are checked before memory is asked for, and while compressed data are unpacked."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from kinetics.crosscheck.data.options import refuse_data

#: Data may have at most this fraction of the memory: what is made of them takes some copies.
FRACTION_OF_MEMORY = 1 / 6
#: Memory that is assumed where the system does not say it: what most machines have.
ASSUMED_MEMORY = 16e9
#: What deflate, the densest of the compressions that are read, makes smaller at most: 1032 times.
MAX_COMPRESSION = 1100.0
#: Bytes that a small file may declare whatever it stores.
SMALL = 1e6


#: Bytes of a number once it is read, whatever it takes in a file.
BYTES_OF_NUMBER = 8.0


def available_memory() -> float:
    """Return the memory in bytes that this process may have."""
    if os.name != "posix":
        return ASSUMED_MEMORY
    memory = float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    with contextlib.suppress(OSError, ValueError):  # of a container
        memory = min(memory, float(Path("/sys/fs/cgroup/memory.max").read_text()))
    return memory


class MemoryBudget:
    """What has been read of a source, and how much of it may be read at most.

    Parameters
    ----------
    where : names the source in messages
    """

    def __init__(self, where: str) -> None:
        self._where = where
        self._taken = 0.0

    def take(self, declared: float, stored: float | None = None) -> None:
        """Add data that will be read; InputError if all do not fit, or are more than is stored.

        Parameters
        ----------
        declared : bytes of memory that the data will need
        stored : bytes in the file; None if these are not known
        """
        if stored is not None and declared > MAX_COMPRESSION * stored + SMALL:
            found = f"{stored:.2g} bytes that declare {declared:.2g}"
            refuse_data(self._where, found, "a whole file")
        self._taken += declared
        limit = FRACTION_OF_MEMORY * available_memory()
        if self._taken > limit:
            allowed = f"at most a sixth of the memory, {limit:.2g}"
            refuse_data(self._where, f"data of {self._taken:.2g} bytes", allowed)


def require_memory(where: str, declared: float, stored: float | None = None) -> None:
    """Raise InputError for data of one piece that do not fit; see `MemoryBudget.take`."""
    MemoryBudget(where).take(declared, stored)


def bytes_of_numbers(count: float, itemsize: float) -> float:
    """Return the memory that so many numbers take, as doubles or as they are."""
    return count * max(itemsize, BYTES_OF_NUMBER)
