"""Files: a netCDF-4 file for each value, written whole or not at all, and checked when read.

A file holds the averages, for any program, and the variable `record`, the JSON from which the value
is built again (`record.py`). It is checksummed by HDF5.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import secrets
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from kinetics.errors import InputError, short
from kinetics.results.record import Json, from_json, to_json

if TYPE_CHECKING:
    import xarray

    Path = str | bytes | os.PathLike[str]

#: Names the layout of the record; another one is refused when a file is read.
FORMAT = "inelastic-lorentz kinetics 3"
#: What the format of a file says that the package `particles` saved.
PARTICLES = "inelastic-lorentz particles"
#: The variable of a file that holds the record.
RECORD = "record"
#: From this version of its format on, HDF5 checksums the structure of a file as well.
HDF5_FORMAT = "v110"
#: Characters of a path that are shown in a message.
MAX_PATH_SHOWN = 300


def write_value(path: Path, value: object, averages: xarray.Dataset) -> None:
    """Write a value and its averages to a file, whole or not at all; InputError if it cannot be."""
    document = json.dumps({"format": FORMAT, "value": to_json(value)})
    averages[RECORD] = "byte", np.frombuffer(document.encode(), np.uint8)
    write_whole({path: _netcdf_bytes(averages)})


def read_value(path: Path, find_class: Callable[[str], object]) -> Any:
    """Build the value that a file holds.

    Parameters
    ----------
    path : of the file
    find_class : imports the module that defines the class of a name

    Raises
    ------
    InputError : there is no such file, it is damaged, or :func:`write_value` did not write it
    """
    try:
        document = _read_record(path)
        if document["format"] != FORMAT:
            stored_format = short(document["format"])
            raise InputError(f"this version reads {FORMAT!r}, not {stored_format}")
        return from_json(document["value"], find_class)
    except InputError as error:
        raise InputError(f"path: got {_shown(path)}; {error}") from None
    except Exception as error:  # h5py raises errors of nearly any class
        what = f"it is damaged, or no file that kinetics saved ({type(error).__name__})"
        raise InputError(f"path: got {_shown(path)}; {what}") from None


def _read_record(path: Path) -> dict[str, Json]:
    """Return the record of a file; no other file is opened, and no more memory used than stored."""
    import h5py

    if not os.path.isfile(path):
        raise InputError("there is no such file")
    with h5py.File(path, "r") as file:
        if PARTICLES in str(file.attrs.get("format", b"")):
            raise InputError("it is a run of particles, which particles.load reads")
        if not isinstance(file.get(RECORD, getlink=True), h5py.HardLink):
            raise ValueError("the record is a link")
        record = file[RECORD]
        is_elsewhere = record.is_virtual or bool(record.external)
        if is_elsewhere or record.id.get_storage_size() < record.nbytes:
            raise ValueError("the record is not stored in the file")
        document = json.loads(record[()].tobytes())
    assert isinstance(document, dict)
    return document


def write_whole(contents: Mapping[Path, bytes]) -> None:
    """Write files, by their paths, all of them or none; InputError where one cannot be written.

    Each is written beside its target under a random name; when all are on the disk they get their
    own. Symbolic links are followed.
    """
    target_of_temporary: dict[str, str] = {}
    path: Path = ""
    try:
        for path, content in contents.items():
            target = os.path.realpath(os.fsdecode(path))
            if os.path.exists(target) and not os.path.isfile(target):
                raise OSError("it is a folder, a device or a pipe, not a file")
            folder, base = os.path.split(target)
            temporary = os.path.join(folder, f".{base}.{secrets.token_hex(8)}.part")
            target_of_temporary[temporary] = target
            with open(temporary, "xb") as file:  # x: never through a symbolic link
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
        for temporary, target in target_of_temporary.items():
            os.replace(temporary, target)
    except (OSError, TypeError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        what = f"it cannot be written ({reason})"
        raise InputError(f"path: got {_shown(path)}; {what}") from None
    finally:
        for temporary in target_of_temporary:
            with contextlib.suppress(OSError):
                os.unlink(temporary)  # it is there only if something went wrong


def _netcdf_bytes(averages: xarray.Dataset) -> bytes:
    """Return a dataset as netCDF-4, made in memory: on a full disk HDF5 would end the process."""
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    encoding = {}
    for name, array in averages.variables.items():
        if array.dtype.kind in "biuf":
            has_chunks = array.size > 0 and array.ndim > 0
            encoding[name] = {"_FillValue": None, "fletcher32": has_chunks}
    image = io.BytesIO()
    with h5netcdf.File(image, "w", libver=(HDF5_FORMAT, HDF5_FORMAT)) as file:
        averages.dump_to_store(H5NetCDFStore(file), encoding=encoding)
    return image.getvalue()


def _shown(path: Path) -> str:
    """Return a path as it is shown in a message."""
    return short(str(path), MAX_PATH_SHOWN)
