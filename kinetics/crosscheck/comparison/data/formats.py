"""The table of file formats, and the rows of a file of any of them."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from kinetics.crosscheck.comparison.data.columns import Rows, shown
from kinetics.errors import InputError


@dataclass(frozen=True)
class Format:
    """A file format: the endings of its names, and the module here that reads it.

    The module has a function `read(path, progress)` that yields `Rows` in the order of the file,
    calls `progress` with the share of the file that has been read (0 to 1), and raises InputError
    in one line for what cannot be used.
    """

    suffixes: tuple[str, ...]
    module: str


FORMATS = (
    Format((".csv",), "csv_files"),
    Format((".npz",), "npz_files"),
    Format((".h5", ".hdf5"), "hdf5_files"),
)
"""Every format that can be read. A new one is a row here and a module beside this one."""


def read_rows(path: Path, progress: Callable[[float], None] | None = None) -> Iterator[Rows]:
    """The rows of a file in pieces, in the order of the file.

    InputError in one line for a file that is missing, damaged, of another format, without a column
    or with a value that is not a finite number.
    """
    suffix = path.suffix.lower()
    found = next((one for one in FORMATS if suffix in one.suffixes), None)
    if found is None:
        *first, last = (one.suffixes[0] for one in FORMATS)
        raise InputError(f"{shown(path)}: must be a file {', '.join(first)} or {last}")
    if not path.is_file():
        raise InputError(f"{shown(path)}: {'not a file' if path.exists() else 'no such file'}")
    reader = import_module(f"{__package__}.{found.module}")
    try:
        yield from reader.read(path, progress or (lambda share: None))
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise InputError(f"{shown(path)}: cannot be read ({reason})") from None
