"""What is written: strict JSON, and files that are either whole or absent."""

import contextlib
import json
import os
import tempfile
from collections.abc import Collection, Mapping
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.errors import InputError
from kinetics.results.file import write_whole
from kinetics.validation import refuse


def require_writable_folder(folder: Path) -> None:
    """Raise InputError unless files could be created in the folder, which may be new in one that
    exists: asked before long work starts. Leaves nothing.
    """
    inside = folder if folder.exists() or folder.is_symlink() else folder.parent
    why = f"its folder does not exist; make it first: mkdir -p {inside}"
    if inside.exists() or inside.is_symlink():
        try:
            with tempfile.TemporaryFile(dir=inside):
                return
        except OSError as error:
            why = error.strerror or str(error)
    raise InputError(f"output: {str(folder)!r} cannot be written: {why}")


def require_file(option: str, file: Path, endings: Collection[str] = ()) -> None:
    """InputError, naming the option, unless this file, of one of these endings, could be made."""
    why = ""
    if not file.name or (endings and file.suffix.lower() not in endings):
        why = f"it must end in {', '.join(endings)}" if endings else "it must be a file's name"
    elif file.exists() and not file.is_file():
        why = f"it is a {'folder' if file.is_dir() else 'device'}, not a file"
    elif not file.parent.exists():
        why = f"its folder does not exist; make it first: mkdir -p {file.parent}"
    if why:
        refuse(option, str(file), why)
    require_writable_folder(file.parent)


def write_together(folder: Path, contents: Mapping[str, str | bytes]) -> list[Path]:
    """Write all files into the folder, or none of them; returns their paths, or InputError.

    Each is complete on disk before the first takes its final name. Missing folders are created, and
    removed again if nothing comes of it.
    """
    created = [p for p in (folder, *folder.parents) if not p.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_whole({
            os.fspath(folder / name): content.encode() if isinstance(content, str) else content
            for name, content in contents.items()
        })  # fmt: skip
    except OSError as error:
        why = f"cannot be written: {error.strerror}"
        raise InputError(f"output folder {str(folder)!r} {why}") from None
    finally:
        for made in created:
            with contextlib.suppress(OSError):
                made.rmdir()  # succeeds only where it stayed empty
    return [folder / name for name in contents]


def plain(value: Any) -> Any:
    """With arrays as lists, dataclasses as dictionaries, None for numbers that are not finite."""
    if is_dataclass(value):
        return plain(vars(value))
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def dumps(value: Any) -> str:
    """Strict JSON of a value (see `plain`) and a newline."""
    return json.dumps(plain(value), allow_nan=False, indent=1) + "\n"


def rendered(template: str, filters: Mapping[str, Any] | None = None, **values: Any) -> str:
    """A page of this package's templates; every text that is no Markup is escaped."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    made = Environment(
        loader=PackageLoader("kinetics.crosscheck"), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    made.filters |= filters or {}
    return made.get_template(template).render(**values)


def markdown_table(frame: Any) -> str:
    """A DataFrame as a Markdown table, two digits of each number that is not whole."""
    cells = frame.map(lambda x: f"{x:.2g}" if isinstance(x, float) else str(x)).values.tolist()
    lines = [list(frame.columns), ["---"] * len(frame.columns), *cells]
    texts = (" | ".join(cell.replace("|", "\\|") for cell in line) for line in lines)
    return "".join(f"| {text} |\n" for text in texts)
