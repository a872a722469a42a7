"""Files that are whole or absent: written beside their target under a random name, and renamed."""

import os
import re
import secrets
import stat
from contextlib import suppress

from particles.checks import short

# Never through a symbolic link, and never waiting for the other end of a pipe; Windows has neither.
SAFELY = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)


def write_whole(path: str, contents: bytes | memoryview) -> None:
    """Write a file, replacing it if it exists. Raises ValueError if it cannot be written."""
    require_regular(path)
    folder, name = os.path.split(path)
    beside = os.path.join(folder, f".{name}.{secrets.token_hex(8)}.part")
    try:
        descriptor = os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL | SAFELY, 0o666)
        with open(descriptor, "wb", buffering=0) as file:
            write_all(file.fileno(), contents)
            os.fsync(file.fileno())
        os.replace(beside, path)
    except OSError as error:
        raise cannot_write(path, error) from None
    finally:
        with suppress(OSError):
            os.unlink(beside)  # it is there only if something went wrong


def write_all(descriptor: int, data: bytes | memoryview) -> None:
    """Write all bytes; a full disk may take a part of them before it refuses the rest."""
    rest = memoryview(data)
    while rest:
        rest = rest[os.write(descriptor, rest[: 2**24]) :]


def remove_leftovers(path: str) -> None:
    """Remove what processes that were killed while they wrote this file have left beside it."""
    folder, name = os.path.split(path)
    pattern = re.compile(rf"\.{re.escape(name)}\.[0-9a-f]{{16}}\.part")
    for other in os.listdir(folder or "."):
        if pattern.fullmatch(other):
            with suppress(OSError):
                os.unlink(os.path.join(folder, other))


def require_regular(path: str) -> None:
    """Raise ValueError for a path where something else than a file is: a folder, device or pipe."""
    try:
        mode = os.stat(path).st_mode
    except OSError:
        return  # nothing is there, or what tries to use it says why it cannot
    if not stat.S_ISREG(mode):
        raise ValueError(f"{path}: is a {_kind(mode)}, not a file")


def _kind(mode: int) -> str:
    kinds = {stat.S_IFDIR: "folder", stat.S_IFIFO: "pipe", stat.S_IFSOCK: "socket"}
    return kinds.get(stat.S_IFMT(mode), "device")


def cannot_write(path: str, error: OSError) -> ValueError:
    """Return what is said where a file cannot be written."""
    return ValueError(f"output = {short(path, 200)}: cannot be written ({error.strerror or error})")
