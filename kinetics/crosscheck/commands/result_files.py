"""What `lorentz solve --output` writes: a result as .csv, .nc (netCDF) or .h5."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

ENDINGS = (".csv", ".nc", ".h5")


def check_output(path: Path) -> None:
    """Raise an error, before any work, for a file that cannot be written or is of another kind."""
    from kinetics.crosscheck.files import require_file

    require_file("output", path, ENDINGS)


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
        write_together(path.parent, {path.name: _csv(result, points, wide)})


def _csv(result: Any, points: dict[str, Any], wide: Collection[str]) -> str:
    """A row for each time, heads with units; of functions a column for each of their points."""
    frame = result.to_dataframe()
    units = dict(frame.attrs["units"])
    made = result.to_xarray(**points) if wide else {}
    for name, one in made.items():
        if one.dims == ("time",) and name not in frame:  # it comes with a function
            frame[name], units[name] = one.values, one.attrs["units"]
        along = one[one.dims[1]].values if name in wide else ()
        for i, x in enumerate(along):
            frame[head := f"{name}({one.dims[1]}={x:g})"] = one.values[:, i]
            units[head] = one.attrs["units"]
    heads = [n if units[n] == "1" else f"{n} [{units[n]}]" for n in frame.columns]
    return str(frame.to_csv(index=False, header=heads, lineterminator="\n"))
