"""Files that are either whole or absent: written beside their target and renamed."""

import contextlib
import os
import secrets
import tempfile
from collections.abc import Mapping
from pathlib import Path


def require_writable_folder(folder: Path) -> None:
    """Raise ValueError, naming the folder, unless files could be created in it. Leaves nothing.

    Asked before long work starts. Where the folder does not exist yet, its nearest existing
    ancestor is tried, and nothing is created.
    """
    existing = folder
    while not existing.exists() and not existing.is_symlink() and existing.parent != existing:
        existing = existing.parent
    try:
        with tempfile.TemporaryFile(dir=existing):
            pass
    except OSError as error:
        raise ValueError(
            f"output folder {str(folder)!r} cannot be written: {error.strerror or error}; "
            "allowed is a folder, existing or new, in which files can be created"
        ) from None


def write_together(folder: Path, contents: Mapping[str, str | bytes]) -> list[Path]:
    """Write all files into the folder, or none of them; returns their paths.

    Every file is complete on disk under a temporary name before the first takes its final name, so
    an interruption while writing leaves what stood there before. Missing folders are created, and
    removed again if nothing comes of it. ValueError if the folder cannot be written.
    """
    created = _missing(folder)
    temporary: dict[str, Path] = {}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in contents.items():
            path = folder / f".{name}.{secrets.token_hex(4)}.part"
            temporary[name] = path
            with open(path, "xb") as file:
                file.write(content.encode() if isinstance(content, str) else content)
                file.flush()
                os.fsync(file.fileno())
        for name in contents:
            os.replace(temporary[name], folder / name)
            del temporary[name]
    except OSError as error:
        raise ValueError(
            f"output folder {str(folder)!r} cannot be written: {error.strerror or error}"
        ) from None
    finally:
        for path in temporary.values():
            with contextlib.suppress(OSError):
                path.unlink()
        for made in created:
            with contextlib.suppress(OSError):
                made.rmdir()  # succeeds only where it stayed empty
    return [folder / name for name in contents]


def _missing(folder: Path) -> list[Path]:
    """The folders that mkdir would create, innermost first."""
    return [p for p in (folder, *folder.parents) if not p.exists()]
