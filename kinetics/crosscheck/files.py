"""What is written: strict JSON, and files that are either whole or absent."""

import contextlib
import json
import os
import tempfile
from collections.abc import Callable, Collection, Mapping
from dataclasses import is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kinetics.errors import InputError
from kinetics.results.file import write_whole
from kinetics.validation import refuse

if TYPE_CHECKING:
    from pandas import DataFrame


def require_writable_folder(folder: Path) -> None:
    """Raise InputError unless files could be created in the folder, which may be new in one that
    exists: checked before long work starts. Leaves nothing.
    """
    existing = folder
    if not _is_there(folder):
        existing = folder.parent
    reason = _missing_folder(existing)
    if _is_there(existing):
        try:
            with tempfile.TemporaryFile(dir=existing):
                return
        except OSError as error:
            reason = error.strerror or str(error)
    raise InputError(f"output: {str(folder)!r} cannot be written: {reason}")


def _is_there(path: Path) -> bool:
    """Return whether a path exists, be it a broken link."""
    return path.exists() or path.is_symlink()


def _missing_folder(folder: Path) -> str:
    """Return what a user can do where a folder is missing."""
    return f"its folder does not exist; make it first: mkdir -p {folder}"


def require_file(option: str, file: Path, endings: Collection[str] = ()) -> None:
    """Raise InputError, naming the option, unless this file, of one of these endings, could be
    made.
    """
    reason = _reason_against_file(file, endings)
    if reason:
        refuse(option, str(file), reason)
    require_writable_folder(file.parent)


def _reason_against_file(file: Path, endings: Collection[str]) -> str:
    """Return why a file could not be made; empty if nothing speaks against it."""
    if endings and file.suffix.lower() not in endings:
        return f"it must end in {', '.join(endings)}"
    if not file.name:
        return "it must be a file's name"
    if file.is_dir():
        return "it is a folder, not a file"
    if file.exists() and not file.is_file():
        return "it is a device, not a file"
    if not file.parent.exists():
        return _missing_folder(file.parent)
    return ""


def write_together(folder: Path, contents: Mapping[str, str | bytes]) -> list[Path]:
    """Write all files into the folder, or none of them; return their paths.

    Each is complete on disk before the first takes its final name. Missing folders are created, and
    removed again if nothing comes of it. Raises InputError for what cannot be written.
    """
    new_folders = [path for path in (folder, *folder.parents) if not path.exists()]
    files: dict[str | bytes | os.PathLike[str], bytes] = {}
    for name, content in contents.items():
        if isinstance(content, str):
            content = content.encode()
        files[os.fspath(folder / name)] = content
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(files)
    except OSError as error:
        reason = f"cannot be written: {error.strerror}"
        raise InputError(f"output folder {str(folder)!r} {reason}") from None
    finally:
        for new_folder in new_folders:
            with contextlib.suppress(OSError):
                new_folder.rmdir()  # succeeds only where it stayed empty
    return [folder / name for name in contents]


def plain(value: Any) -> Any:
    """Return a value with arrays as lists, dataclasses as dictionaries, None for what is no number.

    Numbers that are not finite have no place in JSON.
    """
    if is_dataclass(value):
        return plain(vars(value))
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def dumps(value: Any) -> str:
    """Return strict JSON of a value (see `plain`) and a newline."""
    return json.dumps(plain(value), allow_nan=False, indent=1) + "\n"


def rendered(
    template: str, filters: Mapping[str, Callable[..., object]] | None = None, **values: object
) -> str:
    """Return a page of this package's templates; every text that is no Markup is escaped."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("kinetics.crosscheck"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= filters or {}
    return environment.get_template(template).render(**values)


def markdown_table(frame: "DataFrame") -> str:
    """Return a table in Markdown, with two digits of each number that is not whole."""
    lines: list[list[str]] = [[str(head) for head in frame.columns]]
    lines.append(["---"] * len(frame.columns))
    lines += frame.map(_cell).values.tolist()
    text = ""
    for line in lines:
        cells = " | ".join(cell.replace("|", "\\|") for cell in line)
        text += f"| {cells} |\n"
    return text


def _cell(value: object) -> str:
    """Return a cell of a table as text."""
    if isinstance(value, float):
        return f"{value:.2g}"
    return str(value)
