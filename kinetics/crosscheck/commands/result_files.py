"""What `lorentz solve --output` writes: a result as .csv, .nc (netCDF) or .h5."""

from __future__ import annotations

from collections.abc import Collection
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from kinetics.errors import InputError

ENDINGS = (".csv", ".nc", ".h5")


def check_output(path: Path) -> None:
    """Raise an error, before any work, for a file that cannot be written or is of another kind."""
    from kinetics.crosscheck.files import require_file

    require_file("output", path, ENDINGS)
    if path.suffix.lower() == ".nc" and find_spec("xarray") is None:
        how = "python -m pip install 'inelastic-lorentz[xarray]'"
        raise InputError(f"output: .nc needs xarray, which is not installed: {how}")


def write_result(result: Any, path: Path, points: dict[str, Any], wide: Collection[str]) -> None:
    """Write a result.

    points : where its densities are asked for, as of ``to_xarray``
    wide : the densities of which a .csv file has one column for each point
    """
    from kinetics.crosscheck.files import write_together

    if path.suffix.lower() == ".h5":
        result.save(path)
    elif path.suffix.lower() == ".nc":
        made = result.to_xarray(**points).to_netcdf(engine="scipy")
        write_together(path.parent, {path.name: bytes(made)})
    else:
        table = result.table(**points)
        write_together(path.parent, {path.name: table.csv(wide)})
