"""load(path): a value from a file, whatever its class."""

from __future__ import annotations

import os
from typing import Any

from kinetics.names import import_named
from kinetics.results.file import read_value


def load(path: str | os.PathLike[str]) -> Any:
    """Read a value that its ``save`` method wrote to a file.

    Parameters
    ----------
    path
        Of the netCDF-4 file.

    Returns
    -------
    object
        Of the class that was saved, and equal to what was saved. What had been solved on demand is
        solved again when it is needed.

    Raises
    ------
    InputError
        One line: there is no such file, it is damaged, or `kinetics` did not save it.
    """
    return read_value(path, import_named)
